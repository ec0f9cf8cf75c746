"""From files to files: what the command ``omma render`` does, as one function."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from omma import _core
from omma._core import Background, Camera, Error, Eye, Scene
from omma.base.arguments import checked
from omma.base.files import (
    PathLike,
    WholeFiles,
    check_target,
    left_behind,
    make_directory,
    metres_per_unit,
)
from omma.base.poses import Matrices, load_poses, poses_from_angles
from omma.base.values import value_class
from omma.eye.files import load_eye
from omma.job.pieces import render_of_ommatidia, render_of_receptors, render_pieces
from omma.job.resuming import KeptRender, inputs_of
from omma.picture.cameras import (
    DEFAULT_PROJECTION,
    camera_eye,
    camera_projection,
    display,
    picture_size,
    render_camera,
)
from omma.picture.files import (
    Paint,
    PngWriter,
    paint_of_projection,
    paint_side_by_side,
    write_png,
)
from omma.rendering.receptor_files import receptor_writers
from omma.rendering.renderer import BUILDING, READING, Renderer
from omma.rendering.report import SpentRays
from omma.rendering.response_files import CsvWriter, NpyWriter, Writer
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
from omma.scene.files import load_scene
from omma.scene.world import World

if TYPE_CHECKING:
    from typing_extensions import Unpack

SUFFIXES = (".npy", ".csv", ".png")

# Called with what is being done and its finished share (0 to 1), None where that is not known.
Stage = Callable[[str, float | None], object]

# What makes no difference to responses, or is told by what is in the files.
_NO_RECORD = (
    *("scene", "outputs", "eyes", "path", "threads", "backend", "progress", "resume"),
    *("sampling", "options"),  # are told as settings
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
    scene_index: int | None = None,
    threads: int = 0,
    backend: str = "",
    background: Background | str | None = None,
    standard_error: bool = False,
    receptors: bool = False,
    ultraviolet: ArrayLike | None = None,
    projection: str | None = None,
    width: int | None = None,
    height: int | None = None,
    gamma: float = 2.2,
    side_by_side: bool = False,
    resume: bool = False,
    progress: Stage | None = None,
    **options: Unpack[Options],
) -> RenderReport:
    """Render a scene file through eye files, or one of its cameras, into files.

    This is what ``omma render`` does. Poses and responses go through memory a piece at a time, so
    that any number of poses will do.

    Args:
        scene: glTF file.
        outputs: files to write, by their endings. Of an eye: `.npy` and `.csv` as
            `save_responses` writes them, `.png` a picture (of several poses: name_0000.png and on,
            by the number of the pose). Of another camera: `.npy`, float32 (height, width, 3) as
            `render_camera` gives it, and `.png`. Missing directories are made.
        eyes: `.eye` files, together one head. None: the camera as it is, a compound one with the
            eye that it names in its ``compound-structure``, see `camera_eye`.
        unit: of lengths in the eye files: "mm" (the default), "um", "m" or metres. For a camera's
            own eye the default is the scene's unit, as in CompoundRay.
        camera: name or index of the camera in the scene that is rendered, or with ``eyes`` that the
            head is at; its whole transform is the pose, its scale too.
        position, look_at: instead, where the head is and the point it looks at, (3,), m; without
            ``look_at`` it looks along -Z.
        path: instead, a CSV file of poses, see `load_poses`.
        scene_index: which of the scenes in the file; None takes its default.
        sampling, options: as in `Renderer`; the frame of a path's pose has its number in the path.
            A camera's picture takes `Fixed` and a seed, as `render_camera` does.
        threads, backend: as in `Renderer`.
        background: a `Background`, or text as `parse_background` takes it.
        standard_error: also write standard errors of an eye's responses: beside OUT.npy an
            OUT.error.npy, in a `.csv` three more columns.
        receptors: write responses of the eye's receptors: `.npy`, float32 (P, R), and `.csv`, a
            line for each pose and receptor. Not with `ToError`.
        ultraviolet: light below 400 nm for receptors, see `Renderer.render_receptors`.
        projection: of an eye in a picture, see `omma.picture.project`. None: for a camera's own eye
            the camera's ``compound-projection``, else "spherical_orientationwise".
        width, height: pixels of a picture, see `render_camera` and `projection_ids`. Of one panel
            where ``side_by_side``, which paints each eye apart, see `omma.picture.side_by_side`.
        gamma: of pictures.
        resume: of a path. What is rendered so far is kept where the work is cut off, by Ctrl-C, a
            kill or a loss of power, and the same call goes on from there, to the same bits: beside
            an output OUT there are then OUT.partial and, beside the first, OUT.resume. Pictures of
            several poses get their names one by one.
        progress: called with what is being done and its finished share, None where not known.

    Without camera, position and path the head is at the scene's first camera, or at the origin
    where the scene has none. Without eyes either, the first compound camera is rendered, or the
    first of all where none is.

    Raises:
        omma.Error: anything wrong with an input, named in the message; with ``resume`` also where
            what is kept was made from other inputs. No output is left then.
        KeyboardInterrupt: Ctrl-C. But for ``resume`` nothing is left.
    """
    others = {name: value for name, value in locals().items() if name not in _NO_RECORD}
    settings = Settings(sampling, **options)
    tell: Stage = progress if progress is not None else lambda stage, fraction: None
    names = _output_names(outputs, standard_error, path)
    chosen = [
        name
        for name, given in (("camera", camera), ("position", position), ("path", path))
        if given is not None
    ]
    if len(chosen) > 1:
        raise Error(f"{chosen[0]} and {chosen[1]}: only one of them can say where the head is")
    if resume and path is None:
        raise Error("resume: expected a path of poses")
    if look_at is not None and position is None:
        raise Error("look_at: needs a position to look from")
    eye_paths = [eyes] if isinstance(eyes, (str, os.PathLike)) else list(eyes)
    start = time.perf_counter()
    tell(READING, None)
    world = load_scene(scene, scene_index, progress=partial(tell, READING))
    node = _camera(world, camera, chosen, bool(eye_paths))
    backdrop = parse_background(background) if isinstance(background, str) else background
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
        _check_picture_arguments(node, names, [name for name, given in of_eyes.items() if given])
        size = picture_size(node, width, height)
        rays = fixed_samples(sampling, "a picture")
        seen = World(
            world,
            threads=threads,
            background=backdrop,
            backend=backend,
            progress=partial(tell, BUILDING),
        )
        return _render_picture(seen, node, names, size, rays, settings.seed, gamma, start, tell)
    if ultraviolet is not None and not receptors:
        raise Error("ultraviolet: is for receptors=True")
    if receptors:
        fixed_samples(sampling, "receptors")
    tell("Reading the eye", None)
    head, found = _head(world, eye_paths, node, unit)
    poses, view = _poses(node, position, look_at, path)
    warnings = list(world.warnings)
    if projection is None:
        projection = DEFAULT_PROJECTION
        if node is not None and not eye_paths:
            projection, warning = camera_projection(node)
            warnings += [] if warning is None else [warning]
    elif side_by_side:
        raise Error("projection: side_by_side has its own")
    renderer = Renderer(
        world,
        head,
        sampling,
        threads=threads,
        background=backdrop,
        backend=backend,
        progress=partial(tell, BUILDING),
        **options,
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
        make_directory(Path(name).parent)
    kept: KeptRender | None = None
    if resume:
        read = [scene, *found, *([] if path is None else [path])]
        if isinstance(background, str) and Path(background).exists():
            read.append(background)
        kept = KeptRender(names, inputs_of(settings, others, read, names, renderer.backend))
        view += f", resumed at pose {kept.done:,}" if kept.done else ""
    spent = kept.spent if kept is not None else None
    if spent is None and isinstance(sampling, ToError):
        spent = SpentRays(sampling.error)
    with WholeFiles(None if kept is None else kept.bytes) as files:
        if receptors:
            writers, written = receptor_writers(files, names, head, len(poses), standard_error)
            render = render_of_receptors(renderer, ultraviolet, standard_error)
            pose_bytes = 4 * len(head.receptor_type)
        else:
            writers, written = _writers(
                files,
                names,
                renderer,
                poses,
                standard_error,
                tell,
                lambda: (
                    paint_side_by_side(renderer, width, height, gamma)
                    if side_by_side
                    else paint_of_projection(renderer, poses, projection, width, height, gamma)
                ),
            )
            render = render_of_ommatidia(renderer, standard_error, spent)
            pose_bytes = 4 * max(1, len(head)) * renderer.bands
        if kept is None:
            seconds = render_pieces(render, writers, poses, pose_bytes, tell)
        else:
            save = partial(kept.save, files, spent)
            seconds = kept.seconds
            seconds += render_pieces(render, writers, poses, pose_bytes, tell, save, kept.done)
    if kept is not None:
        kept.remove()
    warnings += left_behind(written)
    if spent is None:
        scrambles = _core.error_scrambles if standard_error else 1
        each = renderer.rays_per_receptor_frame if receptors else renderer.rays_per_frame
        rays = len(poses) * each * scrambles
    else:
        rays = spent.total
    return RenderReport(
        ommatidia=len(head),
        poses=len(poses),
        rays=rays,
        seconds=seconds,
        build_seconds=built - start,
        frames_per_s=len(poses) / max(seconds, 1e-9),
        backend=renderer.backend,
        threads=renderer.threads,
        view=view,
        eyes=tuple(found),
        outputs=tuple(written),
        warnings=tuple(warnings),
        spent=spent,
        receptors=len(head.receptor_type) if receptors else 0,
    )


def _writers(
    files: WholeFiles,
    names: Sequence[str],
    renderer: Renderer,
    poses: Matrices,
    standard_error: bool,
    tell: Stage,
    make_paint: Callable[[], Paint],
) -> tuple[list[Writer], list[str]]:
    """Writers of the files named, and the names of all files written."""
    shape = (len(poses), len(renderer.eye), renderer.bands)
    writers: list[Writer] = []
    written: list[str] = []
    for name in names:
        suffix = Path(name).suffix.lower()
        if suffix == ".npy":
            writers.append(NpyWriter(files, name, shape))
            written.append(name)
            if standard_error:
                beside = error_name(name)
                writers.append(NpyWriter(files, beside, shape, of_errors=True))
                written.append(beside)
        elif suffix == ".csv":
            writers.append(CsvWriter(files, name, renderer.eye, standard_error, renderer.bands))
            written.append(name)
        else:
            tell("Preparing the picture", None)
            picture = PngWriter(files, name, len(poses), make_paint())
            writers.append(picture)
            written += [picture.name(i) for i in range(len(poses))]
    return writers, written


def _check_picture_arguments(node: Camera, names: Sequence[str], of_eyes: Sequence[str]) -> None:
    for name in of_eyes:
        raise Error(
            f"{name}: is for eyes; camera '{node.name}' is {node.type}, and no eye is given"
        )
    for name in names:
        if Path(name).suffix.lower() == ".csv":
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
        make_directory(Path(name).parent)
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
                write_png(files, name, display(picture, gamma))
    return RenderReport(
        ommatidia=0,
        poses=1,
        rays=size[0] * size[1] * samples,
        seconds=seconds,
        build_seconds=built - start,
        frames_per_s=1 / max(seconds, 1e-9),
        backend=world.backend,
        threads=world.threads,
        view=f"camera {node.name}, {node.type}",
        eyes=(),
        outputs=tuple(names),
        warnings=(*world.scene.warnings, *left_behind(names)),
        picture=size,
    )


def _output_names(
    outputs: PathLike | Sequence[PathLike], standard_error: bool, path: PathLike | None
) -> list[str]:
    several = [outputs] if isinstance(outputs, (str, os.PathLike)) else outputs
    names = [os.fsdecode(name) for name in several]
    if not names:
        raise Error("outputs: expected at least one file to write, found none")
    for name in names:
        if Path(name).suffix.lower() not in SUFFIXES:
            raise Error(f"{name}: expected an output ending in {', '.join(SUFFIXES)}")
        if Path(name).is_dir():
            raise Error(f"{name}: cannot be written: it is a directory")
    errors = [error_name(name) for name in names if standard_error and name.endswith(".npy")]
    files = [os.path.abspath(name) for name in names + errors]
    for i, file in enumerate(files):
        if file in files[:i]:
            raise Error(f"{file}: is an output twice")
        if path is not None and file == os.path.abspath(os.fsdecode(path)):
            raise Error(f"{file}: would replace the poses it is made from")
    return names


def error_name(name: str) -> str:
    """Where the standard errors of the responses in an `.npy` file go: beside it."""
    return str(Path(name).with_suffix(".error.npy"))


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


def _poses(
    node: Camera | None,
    position: ArrayLike | None,
    look_at: ArrayLike | None,
    path: PathLike | None,
) -> tuple[Matrices, str]:
    """Poses (P, 4, 4) and in words where they come from."""
    if path is not None:
        return load_poses(path), f"path {os.fsdecode(path)}"
    if position is not None and look_at is not None:
        return _core.look_at(position, look_at)[None], "position, looking at a point"
    if position is not None:
        return poses_from_angles(position, (0, 0, 0)), "position, looking along -Z"
    if node is not None:
        return node.world_from_camera[None], f"camera {node.name}"
    return np.eye(4)[None], "the origin, looking along -Z"
