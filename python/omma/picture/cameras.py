"""Pictures through the cameras of a scene, and the eyes that compound cameras name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Background, Camera, Error, Eye, Scene
from omma.base.arguments import array_of, checked, whole
from omma.base.progress import Progress
from omma.eye.files import load_eye
from omma.picture.projections import PROJECTIONS, LinearPicture
from omma.picture.response_scale import is_rgb_below_0
from omma.rendering.pose_warnings import warn_of_poses
from omma.rendering.renderer import Renderer
from omma.scene.world import World
from omma.scene.world_moves import camera_now

DEFAULT_PROJECTION = "spherical_orientationwise"


@checked
def render_camera(
    scene: Scene | World | Renderer,
    camera: Camera | str | int,
    *,
    width: int | None = None,
    height: int | None = None,
    samples: int = 16,
    seed: int = 0,
    threads: int | None = None,
    background: Background | None = None,
    progress: Progress | None = None,
) -> LinearPicture:
    """What a perspective, orthographic or panoramic camera sees: float32 (height, width, 3).

    Linear radiance, row 0 at the top, never clipped; `display` makes 8-bit colours of it. Each
    pixel is the mean over its area. A perspective camera has its vertical field of view and aspect
    ratio, an orthographic one its half extents times its node's scale (glTF 2.0, 3.10); a panoramic
    one shows all directions, azimuth from left to right with straight ahead in the middle,
    elevation from the top down. znear and zfar cut nothing off.

    Args:
        scene: the scene, or a world of it or a renderer, whose acceleration structure, threads and
            background are then used. A world keeps the rays of its last picture: the next one of
            the same kind of camera, size, ``samples`` and ``seed`` has them, wherever it is taken.
        camera: its name or its index among ``scene.cameras``, where it is since the last
            `World.at`; or a camera as it is, which may be of another scene.
        width, height: pixels. What is left out follows from the camera's aspect ratio, so that
            pixels are square; 1024 wide where both are. A perspective camera without an aspect
            ratio is 4 to 3.
        samples: rays per pixel, spread evenly over it; a single one goes through its middle.
        seed: of the samples. The same inputs and seed give the same bits.
        threads: None or 0 takes one per hardware thread.
        background: instead of the scene's own.
        progress: called with the finished share (0 to 1) a few times a second.

    Raises:
        omma.Error: no such camera, a compound one (`camera_eye` gives its eye), one whose
            projection makes no sense, or an argument out of its range.
    """
    world = scene.world if isinstance(scene, Renderer) else scene
    if isinstance(world, World):
        if threads is not None or background is not None:
            name = "background" if threads is None else "threads"
            raise Error(f"{name}: the world that is given has its own")
    elif isinstance(world, Scene):
        world = World(world, threads=threads or 0, background=background)
    else:
        found = type(scene).__name__
        raise TypeError(f"scene: expected omma.Scene, omma.World or omma.Renderer, found {found}")
    which = camera if isinstance(camera, Camera) else camera_now(world, camera)
    size = picture_size(which, width, height)
    picture = np.empty((size[1], size[0], world.bands), np.float32)
    _core.render_camera(
        world._engine,
        which,
        picture,
        whole(samples, "samples", 1, 1 << 20),
        whole(seed, "seed", 0, (1 << 64) - 1),
        progress,
    )
    warn_of_poses(world._engine, which.world_from_camera[None])
    return picture


@checked
def display(picture: LinearPicture, gamma: float = 2.2) -> NDArray[np.uint8]:
    """A linear picture (height, width, 3) as `save_png` takes it: uint8 of the same shape.

    Display value = 255 * clamp(radiance) ** (1 / gamma).

    Raises:
        omma.Error: another shape, or numbers below 0, which no colour shows: a luminance under
            -0.1. Less than that, as of colours that no screen has, is cut off.
    """
    picture = array_of(picture, "picture", (None, None, 3), np.float32)
    if is_rgb_below_0(picture):
        raise Error(
            f"picture: expected red, green and blue from 0 on, found {np.nanmin(picture):.3g}"
        )
    height, width = picture.shape[:2]
    pixels = np.arange(height * width, dtype=np.int32).reshape(height, width)
    return _core.paint(pixels, picture.reshape(-1, picture.shape[2]), gamma)


@checked
def camera_eye(scene: Scene, camera: Camera | str | int, unit: str | float = "m") -> Eye:
    """The eye that a compound camera names in its extras.

    The file is looked for at the path as it stands there, then beside the scene. Its lengths are in
    the scene's unit, metres, as in CompoundRay, where ``unit`` does not say otherwise; render it at
    the pose ``camera.world_from_camera``, whose scale applies to it too.

    Raises:
        omma.Error: no such camera, one that names no eye, or an eye that is missing or broken.
    """
    which = camera if isinstance(camera, Camera) else scene.camera(camera)
    structure = which.compound_structure
    if not structure:
        raise Error(f"{scene.path or 'scene'}: camera '{which.name}' names no eye")
    candidates = [Path(structure), Path(scene.path).parent / structure]
    for candidate in candidates:
        if candidate.is_file():
            return load_eye(candidate, unit)
    raise Error(
        f"{scene.path or 'scene'}: camera '{which.name}' names the eye '{structure}', "
        f"which is neither {candidates[0]} nor {candidates[1]}"
    )


def camera_projection(camera: Camera) -> tuple[str, str | None]:
    """The projection that a compound camera's eye is shown in, and what is wrong with its own."""
    name = camera.compound_projection
    if not name or name.removesuffix("_ids") in PROJECTIONS:
        return name or DEFAULT_PROJECTION, None
    return DEFAULT_PROJECTION, (
        f"camera '{camera.name}': there is no projection '{name}', it is shown in "
        f"{DEFAULT_PROJECTION}"
    )


def picture_size(camera: Camera, width: int | None, height: int | None) -> tuple[int, int]:
    """Width and height of a camera's picture, with what is left out filled in."""
    largest = _core.max_picture_extent
    return _core.picture_size(
        camera,
        0 if width is None else whole(width, "width", 1, largest),
        0 if height is None else whole(height, "height", 1, largest),
    )
