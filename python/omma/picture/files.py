"""Pictures of an eye's responses as files, one for each pose, in any projection."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error
from omma.base.addresses import expect_local
from omma.base.arguments import checked
from omma.base.files import PathLike, WholeFiles, check_ending, check_target
from omma.base.poses import Matrices
from omma.picture.band_colours import colours_of
from omma.picture.frame import Frame
from omma.picture.projections import project, projection_ids
from omma.picture.unseen import hatching, unseen
from omma.rendering.renderer import Renderer
from omma.rendering.response_files import Piece
from omma.rendering.settings import fixed_samples

Made = TypeVar("Made")

# A picture (height, width, 3 or 4) from the number of a pose and its responses (N, C).
Paint = Callable[[int, NDArray[np.float32]], NDArray[Any]]


def series(name: str, poses: int) -> Iterator[str]:
    """The names of the pictures of so many poses."""
    return (_name_of(name, pose, poses) for pose in range(poses))


def _name_of(name: str, pose: int, poses: int) -> str:
    stem, suffix = os.path.splitext(name)
    number = f"_{pose:0{max(4, len(str(poses - 1)))}}" if poses > 1 else ""
    return f"{stem}{number}{suffix}"


class PngWriter:
    """A picture of each pose: ``name`` where there is one, else name_0000.png, name_0001.png, ...

    The number is that of the pose. They get their names together: a series is there whole or not at
    all, and needs its space on the disk twice where an older one is replaced. In a render that
    may go on later each gets its name at once.
    """

    def __init__(self, files: WholeFiles, name: str, pose_count: int, paint: Paint) -> None:
        self._files, self._paint = files, paint
        self._name, self._poses = name, pose_count
        check_target(self.name(0))

    def name(self, pose: int) -> str:
        """The file that shows a pose."""
        return _name_of(self._name, pose, self._poses)

    def write(self, piece: Piece) -> None:
        names = [self.name(piece.first + i) for i in range(len(piece.responses))]

        def encoded(i: int) -> bytes:
            pixels = self._paint(piece.first + i, piece.responses[i])
            # Patches of one colour each, which filters do not make smaller.
            return _core.encode_png(names[i], pixels, quick=True)

        for name, data in zip(names, on_threads(encoded, len(names))):
            with nullcontext(self._files) if self._files.kept is None else WholeFiles() as files:
                file = files.open(name)
                file.write(data)
                file.close()


@checked
def save_png(path: PathLike, pixels: NDArray[np.uint8]) -> None:
    """Write 8-bit pixels (height, width, 3 or 4), row 0 at the top, as a PNG file.

    It is written under another name and renamed, so that no half of a file is left. Linear
    colours, such as those of `omma.picture.bands_to_rgb`, go through `omma.picture.display` first.

    Raises:
        omma.Error: the pixels or the path do not do.
    """
    check_ending(path, ".png")
    found = np.asarray(pixels)
    if found.dtype.kind == "f":
        raise Error(
            "pixels: expected uint8 of shape (height, width, 3 or 4), found "
            f"{found.dtype} of shape {found.shape}; "
            "omma.picture.display(pixels) makes uint8 of linear colours (height, width, 3)"
        )
    _core.save_png(expect_local(path, "a picture by save_png"), pixels)


def on_threads(make: Callable[[int], Made], count: int) -> Iterator[Made]:
    """make(0), make(1), ... in order, some of them at once: painting and packing leave Python."""
    workers = min(count, os.cpu_count() or 1)
    if workers < 2:
        yield from map(make, range(count))
        return
    with ThreadPoolExecutor(workers, "omma-pictures") as pool:
        made: deque[Future[Made]] = deque()
        for i in range(count):
            made.append(pool.submit(make, i))
            # No more of them in memory than it takes to keep all threads busy.
            if len(made) > 2 * workers:
                yield made.popleft().result()
        while made:
            yield made.popleft().result()


def write_png(files: WholeFiles, name: str, pixels: NDArray[Any]) -> None:
    """Writes a picture (height, width, 3 or 4), one of several files."""
    file = files.open(name)
    file.write(_core.encode_png(name, pixels))
    file.close()


def paint_of_projection(
    renderer: Renderer,
    poses: Matrices,
    projection: str | None,
    width: int | None,
    height: int | None,
    gamma: float,
) -> Paint:
    """What paints responses of a renderer's eye at the poses that it renders: in a projection, of
    which the pixels are all there is, or without one as `framed` does."""
    eye = renderer.eye
    # What is wrong with a projection or a size shows here, before anything is rendered.
    if projection == "raw_ommatidial_samples":
        rows = fixed_samples(renderer.settings.sampling, projection) if height is None else height
        projection_ids(eye, projection, width, rows)

        def paint_rays(pose: int, responses: NDArray[np.float32]) -> NDArray[Any]:
            rays = renderer.render_rays(poses[pose], first_pose=pose)
            colours = colours_of(renderer.world, rays)
            return project(eye, colours, projection, width, rows, gamma=gamma)

        return paint_rays
    world = renderer.world
    if projection is None:
        return _paint_framed(renderer, width, height, gamma, apart=False)
    ids = projection_ids(eye, projection, width, height)
    if projection.endswith("_ids"):
        encoded = _core.encode_ids(ids)
        return lambda pose, responses: encoded
    hatched = hatching(unseen(ids, projection))
    return lambda pose, responses: hatched(_core.paint(ids, colours_of(world, responses), gamma))


def paint_side_by_side(
    renderer: Renderer, width: int | None, height: int | None, gamma: float
) -> Paint:
    """What paints each eye of a renderer's head apart, panels of ``width`` x ``height``."""
    return _paint_framed(renderer, width, height, gamma, apart=True)


def _paint_framed(
    renderer: Renderer, width: int | None, height: int | None, gamma: float, apart: bool
) -> Paint:
    frame, world = Frame(renderer.eye, width, height, apart), renderer.world
    return lambda pose, responses: frame.paint(colours_of(world, responses), gamma)
