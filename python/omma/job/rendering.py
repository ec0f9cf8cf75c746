"""From files to files: what the command ``omma render`` does, as one function."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from omma import _core
from omma._core import Background, Camera, Error, Eye, Scene
from omma.base.arguments import as_named, checked
from omma.base.files import (
    PathLike,
    WholeFiles,
    check_target,
    left_behind,
    make_parent,
    metres_per_unit,
)
from omma.base.poses import Matrices, as_poses, load_poses, poses_from_angles
from omma.base.renamed import renamed_arguments
from omma.base.values import value_class
from omma.eye.files import load_eye
from omma.job.outputs import output_names, writers_of
from omma.job.pieces import render_of_ommatidia, render_of_receptors, render_pieces
from omma.job.resuming import KeptRender, inputs_of
from omma.job.story import call_text, story_of
from omma.picture.band_colours import colours_of
from omma.picture.cameras import (
    camera_eye,
    camera_projection,
    display,
    picture_size,
    render_camera,
)
from omma.picture.files import Paint, paint_of_projection, paint_side_by_side, write_png
from omma.rendering.labels import labels_of
from omma.rendering.renderer import Renderer
from omma.rendering.report import SpentRays
from omma.rendering.settings import (
    Options,
    Sampling,
    Settings,
    Shared,
    ToError,
    fixed_samples,
    options_of,
    takes_options,
)
from omma.scene.backgrounds import parse_background
from omma.scene.building import BUILDING, READING, Stage, build_world
from omma.scene.files import read_scene
from omma.scene.light_words import parse_light, warnings_of
from omma.scene.world import World

if TYPE_CHECKING:
    from typing_extensions import Unpack

# Arguments that are not recorded: they do not change responses, or the files tell them.
_NO_RECORD = (
    *("scene", "outputs", "eyes", "path", "poses", "threads", "backend", "progress", "resume"),
    *("command", "sampling", "options"),  # the last two are told as settings
)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class RenderReport:
    """What a render did."""

    ommatidia: int  # 0 for a camera's picture
    poses: int
    rays: int
    seconds: float  # rendering alone, without reading, building and writing
    build_seconds: float  # reading the files and building the acceleration structure
    writing_seconds: float  # writing, as far as it did not happen beside rendering
    frames_per_s: float
    backend: str
    threads: int
    view: str  # where from: "camera NAME", "path FILE", ...
    eyes: tuple[str, ...]  # eye files, as they were found
    outputs: tuple[str, ...]  # files written
    warnings: tuple[str, ...]  # what the scene's loader passed over
    picture: tuple[int, int] | None = None  # width and height of a camera's picture
    spent: SpentRays | None = None  # where rays were spent to reach an error
    receptors: int = 0  # where their responses were asked for


@renamed_arguments(kernel="angular_sensitivity")
@checked
@takes_options
def render_file(
    scene: PathLike,
    outputs: PathLike | Sequence[PathLike],
    sampling: Sampling = Settings.sampling,
    *,
    eyes: PathLike | Sequence[PathLike] = (),
    unit: str | float | None = None,
    camera: str | int | None = None,
    position: ArrayLike | None = None,
    look_at: ArrayLike | None = None,
    path: PathLike | None = None,
    poses: ArrayLike | None = None,
    scene_index: int | None = None,
    scene_unit: str | float | None = None,
    scene_up: str | None = None,
    threads: int = 0,
    backend: str = "",
    background: Background | str | None = None,
    light: str | None = None,
    standard_error: bool = False,
    receptors: bool = False,
    ultraviolet: ArrayLike | None = None,
    projection: str | None = None,
    width: int | None = None,
    height: int | None = None,
    gamma: float = 2.2,
    side_by_side: bool = False,
    resume: bool = False,
    command: str | None = None,
    progress: Stage | None = None,
    **options: Unpack[Options],
) -> RenderReport:
    """Render a scene file through eye files, or one of its cameras, into files.

    This is what ``omma render`` does. Poses and responses go through memory a piece at a time, so
    that any number of poses will do.

    Args:
        scene: a file as `load_scene` reads it.
        outputs: files to write, by their endings. Of an eye: `.zarr`, `.nc`, `.parquet`, and
            `.npy` with a `.json` beside it, which say what the numbers are and are read by
            `omma.rendering.load_responses` (docs/datasets.md); `.csv` as `save_responses`
            writes it; `.png` a picture (of several poses: name_0000.png and on, by the number of
            the pose); `.mp4` a video with a frame for each pose, 30 a second (a path has no
            times). Of another camera: `.npy`, float32 (height, width, 3) as
            `render_camera` gives it, and `.png`. Missing directories are made.
        eyes: `.eye` files, together one head. None: the camera as it is, a compound one with the
            eye that it names in its ``compound-structure``, see `camera_eye`.
        unit: of lengths in the eye files: "mm" (the default), "um", "m" or metres. For a camera's
            own eye the default is the scene's unit, as in CompoundRay.
        camera: name or index of the camera in the scene that is rendered, or with ``eyes`` that the
            head is at; its whole transform is the pose, its scale too. With ``position``, ``path``
            or ``poses`` and no ``eyes`` it is the camera's own eye, in its scale, that is there.
        position, look_at: instead, where the head is and the point it looks at, (3,), m; without
            ``look_at`` it looks along -Z.
        path: instead, a CSV file of poses, see `load_poses`.
        poses: instead, matrices world_from_head (P, 4, 4) or (4, 4), m.
        scene_index: which of the scenes in the file; None takes its default.
        scene_unit, scene_up: of `.obj`, `.ply` and `.stl` files, ``unit`` and ``up`` of
            `load_scene`.
        sampling, options: as in `Renderer`; the frame of a path's pose has its number in the path.
            A camera's picture takes `Fixed` and a seed, as `render_camera` does.
        threads, backend: as in `Renderer`.
        background: a `Background`, or text as `parse_background` takes it.
        light: what lights the scene, as text that `omma.scene.light_words.parse_light` takes;
            numbers are then spectral radiance in bands, and pictures have the colours that people
            see.
        standard_error: also write standard errors of an eye's responses: beside OUT.npy an
            OUT.error.npy, in a `.csv` three more columns, else a variable or columns of their own.
        receptors: write responses of the eye's receptors: `.npy`, float32 (P, R), and `.csv`, a
            line for each pose and receptor. Not with `ToError`.
        ultraviolet: light below 400 nm for receptors, see `Renderer.render_receptors`.
        projection: of an eye in a picture, see `omma.picture.project`. None: for a camera's own eye
            the camera's ``compound-projection``, else as `omma.picture.framed`: in a frame with
            degrees, hatched where no ommatidium looks, eyes whose fields overlap apart.
        width, height: pixels of a picture, see `render_camera` and `projection_ids`. Of one panel
            without its frame where no projection is named; ``side_by_side`` gives each eye one,
            always.
        gamma: of pictures.
        resume: of a path, into `.npy`, `.csv` and `.png`. What is rendered so far is kept where
            the work is cut off, by Ctrl-C, a kill or a loss of power, and the same call goes on
            from there, to the same bits: beside an output OUT there are then OUT.partial and,
            beside the first, OUT.resume. Pictures of several poses get their names one by one.
        command: what files that say how they were made say of it; None: this call.
        progress: called with what is being done and its finished share, None where not known.

    Without camera, position, path and poses the head is at the scene's first camera, or at the
    origin where the scene has none. Without eyes either, the first compound camera is rendered, or
    the first of all where none is.

    Raises:
        omma.Error: anything wrong with an input, named in the message; with ``resume`` also where
            what is kept was made from other inputs. No output is left then.
        KeyboardInterrupt: Ctrl-C. But for ``resume`` nothing is left.
    """
    given = dict(locals())
    others = {name: value for name, value in given.items() if name not in _NO_RECORD}
    settings = Settings(sampling, **options)
    tell: Stage = progress if progress is not None else lambda stage, fraction: None
    names = output_names(outputs, standard_error, resume, [path])
    chosen = [name for name in ("camera", "position", "path", "poses") if given[name] is not None]
    eye_paths = [eyes] if isinstance(eyes, (str, os.PathLike)) else list(eyes)
    if len(chosen) == 2 and chosen[0] == "camera" and not eye_paths:
        chosen = chosen[1:]  # the camera says which eye, not where
    if len(chosen) > 1:
        raise Error(f"{chosen[0]} and {chosen[1]}: only one of them can say where the head is")
    if resume and path is None:
        raise Error("resume: expected a path of poses")
    videos = [name for name in names if name.lower().endswith(".mp4")]
    if videos and projection is not None and projection.endswith("_ids"):
        raise Error(f"projection: a video shows responses, found {projection!r}")
    if look_at is not None and position is None:
        raise Error("look_at: needs a position to look from")
    start = time.perf_counter()
    tell(READING, None)
    with as_named(unit="scene_unit", up="scene_up"):
        world = read_scene(
            scene, scene_index, unit=scene_unit, up=scene_up, progress=partial(tell, READING)
        )
    node = _camera(world, camera, chosen, bool(eye_paths))
    backdrop = parse_background(background) if isinstance(background, str) else background
    lit = {} if light is None else parse_light(light)

    def build() -> World:
        return build_world(
            world, tell, threads=threads, background=backdrop, backend=backend, **lit
        )

    own_eye_elsewhere = node is not None and not eye_paths and chosen not in ([], ["camera"])
    if node is not None and own_eye_elsewhere and node.type != "compound":
        raise Error(f"{chosen[0]}: is for eyes; camera '{node.name}' is {node.type}")
    if node is not None and not eye_paths and node.type != "compound":
        of_eyes = {
            "standard_error": standard_error,
            "receptors": receptors,
            "projection": projection is not None,
            "side_by_side": side_by_side,
            "resume": resume,
            **{
                one.name: getattr(settings, one.name) != one.default
                for one in options_of(Settings)
                if one.name != "seed"
            },
        }
        _check_picture_arguments(
            node, names, [name for name, is_given in of_eyes.items() if is_given]
        )
        size = picture_size(node, width, height)
        rays = fixed_samples(sampling, "a picture")
        return _render_picture(build(), node, names, size, rays, settings.seed, gamma, start, tell)
    if ultraviolet is not None and not receptors:
        raise Error("ultraviolet: is for receptors=True")
    if receptors:
        fixed_samples(sampling, "receptors")
        for name in names:
            if Path(name).suffix.lower() in (".png", ".mp4"):
                raise Error(f"{name}: expected numbers, not a picture, for responses of receptors")
    tell("Reading the eye", None)
    head, found = _head(world, eye_paths, node, unit)
    if node is not None and own_eye_elsewhere:
        head = _as_large(head, node)
    if receptors and len(head.receptor_type) == 0:
        raise Error(
            f"{head.path or 'eye'}: expected receptors, found none (.csv eyes can have them, "
            "omma.receptors.assign_receptors makes them)"
        )
    matrices, view = _poses(node, position, look_at, path, poses)
    warnings = warnings_of(world, bool(lit))
    if projection is None:
        if node is not None and not eye_paths:
            projection, warning = camera_projection(node)
            warnings += [] if warning is None else [warning]
    elif side_by_side:
        raise Error("projection: side_by_side has its own")
    renderer = Renderer(
        build(), head, sampling, threads=threads, progress=partial(tell, BUILDING), **options
    )
    if isinstance(sampling, Shared) and not receptors:
        shared = np.count_nonzero(renderer.shared_ommatidia)
        if 2 * shared < len(head):
            warnings.append(
                f"sampling: {shared:,} of {len(head):,} ommatidia share rays; the others would "
                "gain nothing and trace their own"
            )
    built = time.perf_counter()
    for name in names:
        make_parent(name)
    kept: KeptRender | None = None
    if resume:
        read = [scene, *found, *([] if path is None else [path])]
        if isinstance(background, str) and Path(background).exists():
            read.append(background)
        kept = KeptRender(names, inputs_of(settings, others, read, names, renderer.backend))
        view += f", resumed at pose {kept.done:,}" if kept.done else ""
    spent = kept.spent if kept is not None else None
    if spent is None and isinstance(sampling, ToError):
        spent = SpentRays(sampling.error or 0.0, sampling.relative_error or 0.0)
    labels = labels_of(
        renderer,
        matrices,
        receptors=receptors,
        standard_error=standard_error,
        more=story_of(given, found, backdrop, command or call_text(render_file, given)),
    )

    def make_paint() -> Paint:
        tell("Preparing the picture", None)
        if side_by_side:
            return paint_side_by_side(renderer, width, height, gamma)
        return paint_of_projection(renderer, matrices, projection, width, height, gamma)

    begun, seconds_before = time.perf_counter(), 0.0 if kept is None else kept.seconds
    with WholeFiles(None if kept is None else kept.bytes) as files, ExitStack() as closed:
        writers, written = writers_of(
            files,
            closed,
            names,
            labels,
            head,
            receptors=receptors,
            standard_error=standard_error,
            make_paint=make_paint,
        )
        if receptors:
            render = render_of_receptors(renderer, ultraviolet, standard_error)
        else:
            render = render_of_ommatidia(renderer, standard_error, spent)
        pose_bytes = 4 * max(1, int(np.prod(labels.shape("response")[1:])))
        if kept is None:
            seconds = render_pieces(render, writers, matrices, pose_bytes, tell)
        else:
            save = partial(kept.save, files, spent)
            seconds = kept.seconds
            seconds += render_pieces(render, writers, matrices, pose_bytes, tell, save, kept.done)
    writing = time.perf_counter() - begun - (seconds - seconds_before)
    if kept is not None:
        kept.remove()
    warnings += left_behind(*_by_kind(written))
    if spent is None:
        scrambles = _core.error_scrambles if standard_error else 1
        each = renderer.rays_per_receptor_frame if receptors else renderer.rays_per_frame
        rays = len(matrices) * each * scrambles
    else:
        rays = spent.total
    return RenderReport(
        ommatidia=len(head),
        poses=len(matrices),
        rays=rays,
        seconds=seconds,
        build_seconds=built - start,
        writing_seconds=writing,
        frames_per_s=len(matrices) / max(seconds, 1e-9),
        backend=renderer.backend,
        threads=renderer.threads,
        view=view,
        eyes=tuple(found),
        outputs=tuple(written),
        warnings=tuple(warnings),
        spent=spent,
        receptors=len(head.receptor_type) if receptors else 0,
    )


def _check_picture_arguments(node: Camera, names: Sequence[str], of_eyes: Sequence[str]) -> None:
    for name in of_eyes:
        raise Error(
            f"{name}: is for eyes; camera '{node.name}' is {node.type}, and no eye is given"
        )
    for name in names:
        if Path(name).suffix.lower() not in (".npy", ".png"):
            raise Error(
                f"{name}: expected .npy or .png for the picture of camera '{node.name}', which is "
                f"{node.type}"
            )


def _render_picture(
    world: World,
    node: Camera,
    names: Sequence[str],
    size: tuple[int, int],
    samples: int,
    seed: int,
    gamma: float,
    start: float,
    tell: Stage,
) -> RenderReport:
    """Render a camera that is no eye into files; ``start`` is when reading began."""
    for name in names:
        make_parent(name)
        check_target(name)
    built = time.perf_counter()
    picture = render_camera(
        world,
        node,
        width=size[0],
        height=size[1],
        samples=samples,
        seed=seed,
        progress=lambda done: tell("Rendering", done),
    )
    seconds = time.perf_counter() - built
    tell("Writing", 1.0)
    with WholeFiles() as files:
        for name in names:
            if Path(name).suffix.lower() == ".npy":
                np.lib.format.write_array(files.open(name), picture)
            else:
                write_png(files, name, display(colours_of(world, picture), gamma))
    return RenderReport(
        ommatidia=0,
        poses=1,
        rays=size[0] * size[1] * samples,
        seconds=seconds,
        build_seconds=built - start,
        writing_seconds=time.perf_counter() - built - seconds,
        frames_per_s=1 / max(seconds, 1e-9),
        backend=world.backend,
        threads=world.threads,
        view=f"camera {node.name}, {node.type}",
        eyes=(),
        outputs=tuple(names),
        warnings=(*warnings_of(world.scene, world.light is not None), *left_behind(names)),
        picture=size,
    )


def _by_kind(written: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names of files, and of those that are directories."""
    directories = [name for name in written if Path(name).is_dir()]
    return [name for name in written if name not in directories], directories


def _camera(
    world: Scene, camera: str | int | None, chosen: list[str], with_eye: bool
) -> Camera | None:
    """The camera that is rendered, or that the head is at; None where there is none to take."""
    if camera is not None:
        return world.camera(camera)
    compound = [each for each in world.cameras if each.type == "compound"]
    if with_eye:
        return None if chosen or not world.cameras else world.cameras[0]
    if compound:
        return compound[0]
    if chosen:
        raise Error(f"{world.path}: no eye is given, and no camera in the scene names one")
    if not world.cameras:
        raise Error(f"{world.path}: no eye is given, and the scene has no camera")
    return world.cameras[0]


def _head(
    world: Scene, eye_paths: Sequence[PathLike], node: Camera | None, unit: str | float | None
) -> tuple[Eye, list[str]]:
    """All eyes as one, and the files they came from."""
    if eye_paths:
        metres = metres_per_unit("mm" if unit is None else unit)
        eyes = [load_eye(name, metres) for name in eye_paths]
        merged = eyes[0] if len(eyes) == 1 else _core.merge_eyes(eyes)
        return merged, [os.fsdecode(name) for name in eye_paths]
    assert node is not None
    own = camera_eye(world, node, "m" if unit is None else unit)
    return own, [own.path]


def _as_large(eye: Eye, node: Camera) -> Eye:
    """A camera's own eye as large as its node makes it, for poses that only turn and move."""
    sizes = np.linalg.norm(node.world_from_camera[:3, :3], axis=0)
    if np.abs(sizes - 1).max() < 1e-6:
        return eye
    large: Eye = _core.merge_eyes([(eye, np.diag([*sizes, 1.0]))])
    return large


def _poses(
    node: Camera | None,
    position: ArrayLike | None,
    look_at: ArrayLike | None,
    path: PathLike | None,
    poses: ArrayLike | None,
) -> tuple[Matrices, str]:
    """Poses (P, 4, 4) and in words where they come from."""
    if poses is not None:
        matrices = as_poses(poses)
        if not np.isfinite(matrices).all():
            raise Error("poses: expected finite numbers")
        return matrices, "poses that were given"
    if path is not None:
        return load_poses(path), f"path {os.fsdecode(path)}"
    if position is not None and look_at is not None:
        return _core.look_at(position, look_at)[None], "position, looking at a point"
    if position is not None:
        return poses_from_angles(position, (0, 0, 0)), "position, looking along -Z"
    if node is not None:
        return node.world_from_camera[None], f"camera {node.name}"
    return np.eye(4)[None], "the origin, looking along -Z"
