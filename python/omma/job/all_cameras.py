"""Every camera of a scene into a folder: what ``omma render-cameras`` does."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from omma._core import Background, Camera, Error, Eye
from omma.base.addresses import expect_local
from omma.base.arguments import checked, positive
from omma.base.files import (
    PathLike,
    WholeFiles,
    check_kept,
    check_target,
    left_behind,
    make_directory,
)
from omma.base.progress import Progress, Stage
from omma.base.renamed import renamed_arguments
from omma.base.values import value_class
from omma.job.animated import told_at_rest
from omma.picture.band_colours import colours_of
from omma.picture.cameras import camera_eye, camera_projection, display, picture_size, render_camera
from omma.picture.files import paint_of_projection, write_png
from omma.picture.projections import LISTS, Picture, projection_size
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Options, Sampling, Settings, fixed_samples, takes_options
from omma.scene.backgrounds import parse_background
from omma.scene.building import READING, build_world
from omma.scene.files import read_scene
from omma.scene.light_words import parse_light, warnings_of
from omma.scene.world import World

if TYPE_CHECKING:
    from typing_extensions import Unpack

_LONGEST_NAME = 100


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class CameraReport:
    """One camera of several that were rendered."""

    index: int  # among the scene's cameras
    name: str
    type: str
    width: int
    height: int
    seconds: float  # rendering alone
    output: str  # the file written
    eye: str  # the eye's file, "" where the camera is none
    projection: str  # that the eye is shown in, "" where the camera is none


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class AllCamerasReport:
    """What `render_all_cameras` did."""

    cameras: tuple[CameraReport, ...]
    build_seconds: float  # reading the files and building the acceleration structure
    backend: str
    threads: int
    warnings: tuple[str, ...]  # what the scene's loader passed over


@renamed_arguments(kernel="angular_sensitivity")
@checked
@takes_options
def render_all_cameras(
    scene: PathLike,
    folder: PathLike,
    sampling: Sampling = Settings.sampling,
    *,
    unit: str | float | None = None,
    scene_index: int | None = None,
    threads: int = 0,
    backend: str = "",
    devices: Sequence[int] = (),
    background: Background | str | None = None,
    light: str | None = None,
    projection: str | None = None,
    width: int | None = None,
    height: int | None = None,
    gamma: float = 2.2,
    progress: Stage | None = None,
    **options: Unpack[Options],
) -> AllCamerasReport:
    """Render every camera of a scene file into a `.png` of its own, named after the camera.

    Args:
        scene: glTF file.
        folder: where the pictures go; made where it is missing. Characters of a camera's name that
            file names should not have become _; cameras of one name get _2, _3 and on.
        unit: of lengths in the cameras' eye files; the scene's unit where not given.
        width, height: of every picture, as in `render_camera` and `projection_ids`; but
            projections with a pixel for each ommatidium keep their own size.
        projection: of all eyes, instead of the one that their camera names.
        sampling: `Fixed`.
        scene_index, threads, backend, devices, background, light, gamma, progress, options: as in
            `render_file`.

    Raises:
        omma.Error: anything wrong with an input, an eye that a camera names and that is not to be
            found too; nothing is rendered then.
    """
    tell: Stage = progress if progress is not None else lambda stage, fraction: None
    positive(gamma, "gamma")
    rays, seed = fixed_samples(sampling, "pictures"), Settings(sampling, **options).seed
    start = time.perf_counter()
    tell(READING, None)
    world = read_scene(scene, scene_index, progress=partial(tell, READING))
    cameras = world.cameras
    if not cameras:
        raise Error(f"{world.path}: has no camera")
    warnings = warnings_of(world, light is not None)
    warnings += told_at_rest(world, "cameras' pictures have no time")
    eyes: list[Eye | None] = []
    shown: list[str] = []
    for camera in cameras:
        if camera.type != "compound":
            picture_size(camera, width, height)
            eyes.append(None)
            shown.append("")
            continue
        of_camera = camera_eye(world, camera, "m" if unit is None else unit)
        eyes.append(of_camera)
        own, warning = camera_projection(camera)
        shown.append(own if projection is None else projection)
        if warning is not None and projection is None:
            warnings.append(warning)
        projection_size(of_camera, shown[-1], *_size(shown[-1], width, height))
    seen = build_world(
        world,
        tell,
        background=parse_background(background) if isinstance(background, str) else background,
        backend=backend,
        devices=devices,
        threads=threads,
        **({} if light is None else parse_light(light)),
    )

    def renderer_of(eye: Eye) -> Renderer:
        return Renderer(seen, eye, sampling, threads=threads, **options)

    target = Path(expect_local(folder, "a folder of pictures"))
    make_directory(target)
    files = [target / f"{name}.png" for name in file_names([camera.name for camera in cameras])]
    is_picture = isinstance(background, str) and Path(background).exists()
    check_kept(files, [scene, *([str(background)] if is_picture else [])])
    for file in files:
        check_target(str(file))
    warnings += left_behind([str(file) for file in files])
    built = time.perf_counter()
    reports = []
    with WholeFiles() as whole:
        for index, camera in enumerate(cameras):

            def tell_share(done: float, index: int = index) -> None:
                tell(f"Rendering {cameras[index].name}", (index + done) / len(cameras))

            began = time.perf_counter()
            eye, name, file = eyes[index], shown[index], files[index]
            pixels = (
                _picture(seen, camera, width, height, rays, seed, gamma, tell_share)
                if eye is None
                else _eye_picture(renderer_of(eye), camera, name, width, height, gamma, tell_share)
            )
            seconds = time.perf_counter() - began
            write_png(whole, str(file), pixels)
            reports.append(
                CameraReport(
                    index=index,
                    name=camera.name,
                    type=camera.type,
                    width=pixels.shape[1],
                    height=pixels.shape[0],
                    seconds=seconds,
                    output=str(file),
                    eye="" if eye is None else eye.path,
                    projection=name,
                )
            )
    return AllCamerasReport(
        cameras=tuple(reports),
        build_seconds=built - start,
        backend=seen.backend,
        threads=seen.threads,
        warnings=tuple(warnings),
    )


def _picture(
    world: World,
    camera: Camera,
    width: int | None,
    height: int | None,
    samples: int,
    seed: int,
    gamma: float,
    progress: Progress,
) -> Picture:
    linear = render_camera(
        world,
        camera,
        width=width,
        height=height,
        samples=samples,
        seed=seed,
        progress=progress,
    )
    return display(colours_of(world, linear), gamma)


def _eye_picture(
    renderer: Renderer,
    camera: Camera,
    projection: str,
    width: int | None,
    height: int | None,
    gamma: float,
    progress: Progress,
) -> Picture:
    pose = camera.world_from_camera[None]
    across, down = _size(projection, width, height)
    paint = paint_of_projection(renderer, pose, projection, across, down, gamma)
    return paint(0, renderer.render(pose, progress=progress)[0])


def _size(projection: str, width: int | None, height: int | None) -> tuple[int | None, int | None]:
    return (None, None) if projection.removesuffix("_ids") in LISTS else (width, height)


def file_names(names: Sequence[str]) -> list[str]:
    """A file's name, without its ending, for each of these names: safe, and no two alike.

    Also where the system does not tell upper from lower case.
    """
    chosen: list[str] = []
    for name in names:
        safe = re.sub(r"[^\w.-]+", "_", name)[:_LONGEST_NAME].lstrip(".") or "camera"
        taken = {each.lower() for each in chosen}
        number, unique = 1, safe
        while unique.lower() in taken:
            number += 1
            unique = f"{safe}_{number}"
        chosen.append(unique)
    return chosen
