"""What is shown as the command, and as the lines of Python, that render the same numbers."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass

from omma.view.state import Look, Seen

_POSE_FILE = "pose.csv"
_HEADER = "x,y,z,yaw_deg,pitch_deg,roll_deg"


@dataclass(frozen=True)
class Sources:
    """The files that a world and an eye came from; "" and () where they were made in memory."""

    scene: str = ""
    eyes: tuple[str, ...] = ()
    unit: str = "mm"
    background: str | None = None
    light: str | None = None  # as `omma.scene.light_words.parse_light` takes it
    lit: bool = False
    ultraviolet: tuple[float, ...] | None = None
    scene_unit: str | None = None
    scene_up: str | None = None
    scene_voxel_m: float | None = None


def render_command(sources: Sources, seen: Seen) -> tuple[str, str | None]:
    """The command that renders what is seen into view.npy and view.png, and None; or "" and why
    there is none."""
    look = seen.look
    if not sources.scene or not sources.eyes:
        return "", "the scene or the eye was made in Python, not read from a file"
    if sources.lit and sources.light is None:
        return "", "the light was made in Python, not said to 'omma view'"
    if look.time_s is not None:
        return "", "'omma render' knows no time of animations"
    lines = []
    eyes = list(sources.eyes)
    unit = [] if sources.unit == "mm" else ["--unit", sources.unit]
    if look.acceptance_factor != 1:
        factor = repr(look.acceptance_factor)
        eyes = [f"eye_{k}.csv" for k in range(len(eyes))]
        for source, made in zip(sources.eyes, eyes, strict=True):
            lines.append(
                ["omma", "eye", "acceptance", source, "--factor", factor, *unit, "-o", made]
            )
    words = ["omma", "render", sources.scene]
    for eye in eyes:
        words += ["--eye", eye]
    pose = look.pose
    before = ""
    target = pose.target_m
    if target is not None:
        words += ["--position", *_numbers(pose.position_m), "--look-at", *_numbers(target)]
    else:
        row = _row(look)
        before = f"printf '{_HEADER}\\n{row}\\n' > {_POSE_FILE}\n"
        words += ["--path", _POSE_FILE]
    words += unit
    if sources.scene_unit is not None:
        words += ["--scene-unit", sources.scene_unit]
    if sources.scene_up is not None:
        words += ["--scene-up", sources.scene_up]
    if sources.scene_voxel_m is not None:
        words += ["--scene-voxel-m", repr(sources.scene_voxel_m)]
    if sources.background is not None:
        words += ["--background", sources.background]
    if sources.light is not None:
        words += ["--light", sources.light]
    words += ["--samples", str(seen.samples)]
    words += ["--standard-error"] if seen.standard_error else []
    if look.receptors:
        words.append("--receptors")
        if sources.ultraviolet is not None:
            words += ["--ultraviolet", ",".join(_numbers(sources.ultraviolet))]
        words += ["-o", "view.npy"]
    else:
        words += ["-o", "view.npy", "-o", "view.png"]
    return before + "\n".join(shlex.join(line) for line in [*lines, words]), None


def render_python(sources: Sources, seen: Seen) -> str:
    """Lines of Python that give ``responses`` as they are seen; a world or an eye that no file has
    is taken to be called ``world`` and ``eye``."""
    look, pose = seen.look, seen.look.pose
    lines = ["import omma", ""]
    if sources.scene and (sources.light is not None or not sources.lit):
        of_file = [repr(sources.scene)]
        if sources.scene_unit is not None:
            of_file.append(f"unit={sources.scene_unit!r}")
        if sources.scene_up is not None:
            of_file.append(f"up={sources.scene_up!r}")
        if sources.scene_voxel_m is not None:
            of_file.append(f"voxel_m={sources.scene_voxel_m!r}")
        lines.append(f"scene = omma.load_scene({', '.join(of_file)})")
        arguments = ["scene"]
        if sources.background is not None:
            lines.append("from omma.scene.backgrounds import parse_background")
            arguments.append(f"background=parse_background({sources.background!r})")
        if sources.light is not None:
            lines.append("from omma.scene.light_words import parse_light")
            arguments.append(f"**parse_light({sources.light!r})")
        lines.append(f"world = omma.World({', '.join(arguments)})")
    if sources.eyes:
        unit = "" if sources.unit == "mm" else f", {sources.unit!r}"
        read = [f"omma.load_eye({name!r}{unit})" for name in sources.eyes]
        one = read[0] if len(read) == 1 else f"omma.eye.merge_eyes([{', '.join(read)}])"
        lines.append(f"eye = {one}")
    if look.acceptance_factor != 1:
        lines.append(f"eye = omma.eye.set_acceptance(eye, factor={look.acceptance_factor!r})")
    if look.time_s is not None:
        lines.append(f"world.at({look.time_s!r})")
    target = pose.target_m
    if target is not None:
        lines.append(f"pose = omma.look_at({pose.position_m!r}, {target!r})")
    else:
        angles = (pose.yaw_deg, pose.pitch_deg, pose.roll_deg)
        lines.append(f"pose = omma.poses_from_angles({pose.position_m!r}, {angles!r})[0]")
    lines.append(f"renderer = omma.Renderer(world, eye, omma.Fixed({seen.samples}))")
    error = "standard_error=True" if seen.standard_error else ""
    call = "render"
    if look.receptors:
        call = "render_receptors"
        if sources.ultraviolet is not None:
            error = ", ".join(filter(None, [f"ultraviolet={sources.ultraviolet!r}", error]))
    given = ", ".join(filter(None, ["pose", error]))
    names = "responses, errors" if seen.standard_error else "responses"
    lines.append(f"{names} = renderer.{call}({given})")
    return "\n".join(lines)


def path_text(looks: Sequence[Look]) -> str:
    """Poses as a file that ``--path`` takes."""
    return "\n".join([_HEADER, *(_row(look) for look in looks), ""])


def absolute(path: str | os.PathLike[str]) -> str:
    """A file's name from the root, so that a command finds it from anywhere."""
    return os.path.abspath(os.fsdecode(path))


def _row(look: Look) -> str:
    pose = look.pose
    numbers = (*pose.position_m, pose.yaw_deg, pose.pitch_deg, pose.roll_deg)
    return ",".join(_numbers(numbers))


def _numbers(values: Sequence[float]) -> list[str]:
    # Six decimals, as poses keep; never 1e-06, which some programs do not read.
    return [f"{value:.6f}".rstrip("0").rstrip(".") for value in values]
