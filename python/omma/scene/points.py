"""Point clouds: what laser scanners and photogrammetry measure, read from files in pieces."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, positive, whole
from omma.base.arrays import Floats
from omma.base.files import PathLike
from omma.base.mesh_parts import linear, world_from_file
from omma.base.progress import Progress
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.scene.memory import free_bytes, words_for_bytes
from omma.scene.point_cells import AllPoints, CellMeans, Columns
from omma.scene.point_files import Piece, PointFile, open_points

# A cloud farther from zero than this many of its half sizes has an offset, as meshes have.
_FAR = 4
# No world is larger.
_MOST_M = 1e18
# While it is read, for each number of a point that is kept: itself, and once more when the pieces
# are joined, of one column at a time.
_BYTES_PER_NUMBER = 5.5


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class PointCloud:
    """Points of N places on surfaces, and what is known of each.

    ``positions_m`` (N, 3) are float32, in a right-handed frame with +Y up, from ``offset_m`` (3,)
    on, which is float64, so that a survey in UTM keeps its millimetres. ``colors`` (N, 3) are
    linear RGB, ``intensity`` (N,) is how much of a laser's light came back, in any unit,
    ``normals`` (N, 3) are those of the file, of any length, ``labels`` (N,) numbers of classes: in
    LAS files 2 is ground, 3 to 5 are vegetation. Each is None where the file does not have it.
    ``scanners_m`` (S, 3) is where scanners stood, in the frame of ``offset_m``; normals then point
    to the nearest. ``path`` is where it came from.

    Raises:
        omma.Error: shapes that do not go together, numbers that are not finite.
    """

    positions_m: NDArray[np.float32]
    offset_m: Floats
    colors: NDArray[np.float32] | None = None
    intensity: NDArray[np.float32] | None = None
    normals: NDArray[np.float32] | None = None
    labels: NDArray[np.int32] | None = None
    scanners_m: Floats | None = None
    path: str = ""

    @checked
    def __init__(
        self,
        positions_m: ArrayLike,
        offset_m: ArrayLike = (0.0, 0.0, 0.0),
        *,
        colors: ArrayLike | None = None,
        intensity: ArrayLike | None = None,
        normals: ArrayLike | None = None,
        labels: ArrayLike | None = None,
        scanners_m: ArrayLike | None = None,
        path: str = "",
    ) -> None:
        offset = _finite(offset_m, "offset_m", (3,), np.float64)
        exact = _finite(positions_m, "positions_m", (None, 3), None)
        if exact.dtype != np.float32 and len(exact):
            # What single precision would round is taken off, as of meshes.
            middle = (exact.min(axis=0) / 2 + exact.max(axis=0) / 2).astype(np.float64)
            if np.abs(middle).max() > _FAR * np.ptp(exact, axis=0).max() / 2:
                exact, offset = exact - middle, offset + middle
        count = len(exact)
        _check_size(exact, "positions_m")
        _check_size(offset[None], "offset_m")
        made: dict[str, Any] = {
            "positions_m": exact.astype(np.float32, copy=False),
            "offset_m": offset,
            "colors": _finite(colors, "colors", (count, 3)),
            "intensity": _finite(intensity, "intensity", (count,)),
            "normals": _finite(normals, "normals", (count, 3)),
            "labels": _finite(labels, "labels", (count,), np.int32),
            "scanners_m": _finite(scanners_m, "scanners_m", (None, 3), np.float64),
            "path": path,
        }
        if colors is not None and (made["colors"] < 0).any():
            raise Error("colors: expected linear colours of 0 or more")
        for name, value in made.items():
            if isinstance(value, np.ndarray):
                # What others could write to is copied, not the many points of a file.
                value = value.copy() if value.flags.writeable else value
                value.flags.writeable = False
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.positions_m)

    @property
    def bounds(self) -> Floats | None:
        """Lower and upper corner of the box around all points: (2, 3), m; None where there are
        none."""
        if not len(self):
            return None
        low, high = self.positions_m.min(axis=0), self.positions_m.max(axis=0)
        return np.array([low, high], np.float64) + self.offset_m


@checked
def load_points(
    path: PathLike,
    *,
    unit: str | float = "m",
    up: str | None = None,
    every: int = 1,
    voxel_m: float | None = None,
    bounds: ArrayLike | None = None,
    progress: Progress | None = None,
) -> PointCloud:
    """Read the points of a `.ply`, `.las`, `.laz`, `.e57` or text file.

    LAS and LAZ need laspy (`pip install 'omma[points]'`), E57 needs pye57 (`'omma[e57]'`). A file
    is read in pieces and thinned on the way: memory is needed for what is kept only. Text files
    (`.xyz`, `.pts`, `.asc`, `.txt`, `.csv`) name their columns in the first line (x, y, z, red,
    green, blue, intensity, nx, ny, nz, classification), or have 3 (x y z), 4 (and intensity), 6
    (and red green blue) or 7 of them (intensity, then red green blue). Colours are taken as sRGB,
    of 8 or 16 bits or up to 1, whichever holds them all. Points that are not finite, and those that
    a LAS file marks as noise (classes 7 and 18) or withheld, are left out.

    Args:
        path: the file.
        unit: of its lengths: "m", "mm", "um" or a number of metres (a foot: 0.3048).
        up: "y", "z" or "-y", the axis that points up in it; None: z, in PLY files y.
        every: of the file's order, each how many-th point is kept.
        voxel_m: side of the cells of a grid, in each of which the mean of the points is kept.
        bounds: (2, 3), lower and upper corner of a box of the world, m; what lies outside is passed
            over.
        progress: called with the finished share (0 to 1) after each piece. What it raises ends the
            reading and is raised here.

    Raises:
        omma.Error: the file is missing, cut off or broken, holds no points or more than fit into
            memory; it says how many would. A package is not installed.

    Warns:
        UserWarning: points that were left out, by number and reason; a unit that is likely another.
    """
    file = open_points(os.fsdecode(path))
    sieve = Sieve(file, unit, up, every, voxel_m, bounds)
    cloud, told = read_points(sieve, progress)
    for sentence in told:
        warn_caller(f"{file.path}: {sentence}", UserWarning)
    return cloud


class Sieve:
    """Which points of a file are kept, and where they are in the world."""

    def __init__(
        self,
        file: PointFile,
        unit: str | float = "m",
        up: str | None = None,
        every: int = 1,
        voxel_m: float | None = None,
        bounds: ArrayLike | None = None,
    ) -> None:
        self.file = file
        self.world_from_file = world_from_file(unit, file.up if up is None else up)
        self.every = whole(every, "every", 1, 1 << 40)
        self.voxel_m = None if voxel_m is None else positive(voxel_m, "voxel_m")
        self.box = None if bounds is None else array_of(bounds, "bounds", (2, 3))
        if self.box is not None and not (self.box[0] < self.box[1]).all():
            raise Error("bounds: expected a lower and an upper corner")
        self.offset_m: Floats | None = None
        self.kept = self.read = self.not_finite = 0

    def pass_through(self, piece: Piece, white: float) -> Columns:
        """What is kept of a piece, by names of `PointCloud`; positions are from ``offset_m`` on."""
        start = -self.read % self.every
        self.read += len(piece.positions)
        world = self.world_from_file
        with np.errstate(invalid="ignore"):
            positions = piece.positions[start :: self.every] @ world[:3, :3].T
        given = {"colors": piece.colors, "intensity": piece.intensity, "normals": piece.normals}
        rows = {
            name: np.asarray(one[start :: self.every], np.float32)
            for name, one in given.items()
            if one is not None
        }
        taken = np.isfinite(positions).all(axis=1)
        for one in rows.values():
            taken &= np.isfinite(one).all(axis=tuple(range(1, one.ndim)))
        self.not_finite += int((~taken).sum())
        if self.box is not None:
            taken &= ((positions >= self.box[0]) & (positions <= self.box[1])).all(axis=1)
        positions = positions[taken]
        _check_size(positions, self.file.path)
        rows = {name: one[taken] for name, one in rows.items()}
        if piece.labels is not None:
            rows["labels"] = piece.labels[start :: self.every][taken]
        if len(positions) and self.offset_m is None:
            low, high = positions.min(axis=0), positions.max(axis=0)
            is_far = np.abs(low + high).max() > _FAR * (high - low).max()
            self.offset_m = (low + high) / 2 if is_far else np.zeros(3)
        if self.offset_m is not None:
            positions = positions - self.offset_m
        if "colors" in rows:
            rows["colors"] = linear(np.clip(rows["colors"] / white, 0, 1)).astype(np.float32)
        if "normals" in rows:
            turn = world[:3, :3] / np.cbrt(np.linalg.det(world[:3, :3]))
            rows["normals"] = rows["normals"] @ turn.T.astype(np.float32)
        self.kept += len(positions)
        return {"positions": positions.astype(np.float32), **rows}

    @property
    def left_out(self) -> dict[str, int]:
        """How many points are left out whatever is asked for, by reason."""
        counts = {"not finite": self.not_finite, **self.file.left_out}
        return {reason: count for reason, count in counts.items() if count}

    def none_found(self) -> Error:
        """What there is to raise where no point has passed."""
        unread = sum(self.file.left_out.values())
        why = ", ".join(f"{count:,} {reason}" for reason, count in self.left_out.items())
        return Error(
            f"{self.file.path}: expected points, found none of {self.read + unread:,} that can be "
            f"used{': ' if why else ''}{why}"
        )


def _check_size(positions: NDArray[np.floating[Any]], name: str) -> None:
    if len(positions) and np.abs(positions).max() > _MOST_M:
        raise Error(f"{name}: expected points within {_MOST_M:g} m, found farther ones")


def read_points(sieve: Sieve, progress: Progress | None = None) -> tuple[PointCloud, list[str]]:
    """The points that pass, and what there is to warn of."""
    file = sieve.file
    _check_memory(sieve)
    for white in file.whites:
        sieve.offset_m, sieve.kept, sieve.read, sieve.not_finite = None, 0, 0, 0
        found = _gather(sieve, white, white == file.whites[-1], progress)
        if found is not None:
            break
    columns = found.columns() if found is not None else {}
    for one in columns.values():
        one.flags.writeable = False
    offset = sieve.offset_m
    if offset is None:
        raise sieve.none_found()
    told = [f"{count:,} points are left out: {reason}" for reason, count in sieve.left_out.items()]
    if file.doubt:
        told.append(file.doubt)
    colors = columns.get("colors")
    if colors is not None and not colors.any():
        told.append("all its colours are black, which is taken as having none")
        del columns["colors"]
    if advice := file.units.advice(sieve.world_from_file):
        told.append(advice)
    world = sieve.world_from_file[:3, :3]
    cloud = PointCloud(
        columns.pop("positions"),
        offset,
        **columns,
        scanners_m=[world @ one - offset for one in file.scanners] or None,
        path=file.path,
    )
    return cloud, told


def _gather(
    sieve: Sieve, white: float, is_last: bool, progress: Progress | None
) -> AllPoints | CellMeans | None:
    """What is kept; None where a colour is above ``white``, which is then another."""
    kept = AllPoints() if sieve.voxel_m is None else CellMeans(sieve.voxel_m)
    for piece in sieve.file.pieces():
        if piece.colors is not None and not is_last:
            with np.errstate(invalid="ignore"):
                if np.nanmax(piece.colors, initial=0) > white:
                    return None
        columns = sieve.pass_through(piece, white)
        if len(columns["positions"]):
            kept.add(columns)
        if progress is not None:
            progress(min(sieve.read / (sieve.file.count or max(sieve.read, 1)), 1.0))
    return kept


def _check_memory(sieve: Sieve) -> None:
    """omma.Error where all points would not fit."""
    file = sieve.file
    if sieve.voxel_m is not None or sieve.box is not None or file.count is None:
        return
    first = next(file.pieces(), None)
    if first is None:
        return
    numbers = 3 * sum(one is not None for one in (first.positions, first.colors, first.normals))
    numbers += sum(one is not None for one in (first.intensity, first.labels))
    needed, free = file.count / sieve.every * numbers * _BYTES_PER_NUMBER, free_bytes()
    if needed > free:
        fit = int(free / (numbers * _BYTES_PER_NUMBER))
        raise Error(
            f"{file.path}: {file.count // sieve.every:,} points take {words_for_bytes(needed)}, of "
            f"which {words_for_bytes(free)} are free: {fit:,} would fit; thin them by voxel_m, or "
            f"in omma.scene.load_points by every={-(-file.count // fit)} or bounds"
        )


def _finite(
    value: Any, name: str, shape: tuple[int | None, ...], dtype: Any = np.float32
) -> NDArray[Any] | Any:
    if value is None:
        return None
    if dtype is None:
        given = np.asarray(value)
        dtype = np.float32 if given.dtype == np.float32 else np.float64
    array = array_of(value, name, shape, dtype)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        bad = int(np.count_nonzero(~np.isfinite(array).reshape(len(array), -1).all(axis=1)))
        raise Error(f"{name}: expected finite numbers, found {bad:,} rows that are not")
    return array
