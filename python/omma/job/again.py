"""Renders that are made again from what they wrote: ``omma render --like``."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import checked
from omma.base.files import PathLike, digests_of
from omma.eye.files import load_eye
from omma.job.rendering import RenderReport, Stage, render_file
from omma.rendering.labels import eye_digest
from omma.rendering.read_back import load_responses
from omma.rendering.settings import settings_from_record


@checked
def render_like(
    like: PathLike,
    outputs: PathLike | Sequence[PathLike],
    *,
    scene: PathLike | None = None,
    eyes: PathLike | Sequence[PathLike] = (),
    threads: int = 0,
    command: str | None = None,
    progress: Stage | None = None,
) -> RenderReport:
    """Render again what a file of responses was made of, to the same bits.

    Poses, settings, seed and background are those that the file says, and scene and eyes must be
    what they were. The bits are the same for the same version of Omma on the same kind of
    processor; where one of them differs the report's warnings say so.

    Args:
        like: what `render_file` wrote: `.zarr`, `.nc`, `.parquet`, or `.npy` with its `.json`.
        outputs: files to write, as in `render_file`.
        scene, eyes: where they are now, if not where they were.
        threads, command, progress: as in `render_file`.

    Raises:
        omma.Error: a file that does not say how it was made; a scene, eye or background that is
            another now, with both hashes; and as `render_file`.
    """
    name = os.fsdecode(like)
    data = load_responses(like)
    said = dict(data.attrs)
    if "eye_files" not in said or "world_from_head" not in data.coords:
        raise Error(
            f"{name}: does not say how it was made; what omma render writes as .zarr, .nc, "
            ".parquet or .npy does"
        )
    if not said["scene"]:
        raise Error(f"{name}: was rendered of a scene that was in memory, not in a file")
    if said.get("background") == "":
        raise Error(f"{name}: was rendered before a background that was in memory, not in a file")
    scene_file = said["scene"] if scene is None else scene
    check_scene(name, said, scene_file)
    given = [eyes] if isinstance(eyes, (str, os.PathLike)) else list(eyes)
    eye_files = given or json.loads(said["eye_files"])
    check_eyes(name, said, eye_files)
    check_background(name, said)
    settings = settings_from_record(said)
    report = render_file(
        scene_file,
        outputs,
        settings.sampling,
        eyes=eye_files,
        unit=said["eye_unit_m"],
        poses=data.world_from_head.values,
        scene_index=said.get("scene_index"),
        scene_unit=said.get("scene_unit_m"),
        scene_up=said.get("scene_up"),
        threads=threads,
        backend=backend_word(said["backend"]),
        background=said.get("background"),
        light=said.get("light_words"),
        standard_error="standard_error" in data,
        receptors="receptor" in data.response.dims,
        ultraviolet=json.loads(said["ultraviolet"]) if "ultraviolet" in said else None,
        command=command or f"omma.job.render_like({name!r}, ...)",
        progress=progress,
        **settings.options(),
    )
    differs = [
        f"{name} was rendered with {was}, this is {now}: the last bits may differ"
        for was, now in (
            (f"Omma {said['omma_version']}", f"Omma {_core.__version__}"),
            (said["backend"], report.backend),
        )
        if was != now
    ]
    return replace(report, warnings=(*report.warnings, *differs))


def check_scene(name: str, said: Mapping[str, Any], scene: PathLike) -> None:
    """omma.Error where the scene's files are not what they were."""
    was = _beside_each_other(json.loads(said["scene_sha256"]), said["scene"])
    now = _beside_each_other(digests_of(scene), os.fsdecode(scene))
    for file in [*now, *(file for file in was if file not in now)]:
        if was.get(file) != now.get(file):
            raise Error(
                f"{os.path.join(os.path.dirname(os.fsdecode(scene)), file)}: is not what {name} "
                f"was rendered of: SHA-256 was {was.get(file)}, is {now.get(file)}"
            )


def check_eyes(name: str, said: Mapping[str, Any], eyes: Sequence[PathLike]) -> None:
    """omma.Error where eye files do not give the eye that it was."""
    digest = eye_digest(head_of(eyes, said["eye_unit_m"]))
    if digest != said["eye_sha256"]:
        raise Error(
            f"{', '.join(os.fsdecode(eye) for eye in eyes)}: is not the eye that {name} was "
            f"rendered through: SHA-256 was {said['eye_sha256']}, is {digest}"
        )


def check_background(name: str, said: Mapping[str, Any]) -> None:
    """omma.Error where a background's picture is not what it was."""
    if "background_sha256" in said:
        was, now = json.loads(said["background_sha256"]), digests_of(said["background"])
        if was != now:
            raise Error(
                f"{said['background']}: is not the background of {name}: SHA-256 was "
                f"{', '.join(was.values())}, is {', '.join(now.values())}"
            )


def head_of(eyes: Sequence[PathLike], unit: str | float) -> Eye:
    """Eye files as one head."""
    loaded = [load_eye(eye, unit) for eye in eyes]
    return loaded[0] if len(loaded) == 1 else _core.merge_eyes(loaded)


def backend_word(backend: str) -> str:
    """What chooses a backend, from what it calls itself, such as "embree 3.13.5"."""
    return backend.replace(",", " ").split()[0]


def _beside_each_other(digests: Mapping[str, str], scene: str) -> dict[str, str]:
    """Digests by where files are as seen from the scene's folder."""
    folder = os.path.dirname(scene) or "."
    return {os.path.relpath(file, folder): digest for file, digest in digests.items()}
