"""What comes nearer: motion away from a direction in the field of view, and cells that pool it as
LPLC2 of flies do.

An LPLC2 neuron has four dendrites, a cross, each in the layer of the lobula plate that holds motion
in the direction in which that dendrite leads away from the middle: it is excited by motion outwards
along each arm, and inhibited by motion inwards there (Klapoetke et al. 2017, Nature 551:237). What
moves across all of the field in one direction is outward in one arm and inward in the opposite.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, one_of, whole, within
from omma.base.arrays import Floats, Ints
from omma.base.directions import normalized
from omma.base.progress import Progress
from omma.base.values import value_class
from omma.eye.field import sphere_directions

# Arms of a cell, in this order.
ARMS = ("right", "up", "left", "down")
# Where all four lie in the field of view each arm has at least so many ommatidia.
_LEAST_OF_AN_ARM = 3
# Nearer to the middle no direction leads away from it.
_LEAST_AWAY = 1e-6
# Between cells that are spread: 47,600 of them on the sphere.
_LEAST_SPACING_DEG = 1.0
# Of a cell and an ommatidium; those in arms are kept, 40 bytes each.
_MOST_PAIRS = 1 << 28
# So many take a hundredth of a second, and 20 MB.
_PAIRS_AT_ONCE = 1 << 16
# Axes, and what is right and up there, (N, 3) each, of length 1.
_Frames = tuple[Floats, Floats, Floats]


@checked
def expansion(
    eye: Eye, vectors: ArrayLike, center: ArrayLike, *, radius_deg: float = 30.0
) -> Floats:
    """The mean motion away from a direction, of the ommatidia around it.

    Of a flat thing that comes straight on, l/v being half its size over its speed and t the time to
    collision, optic flow is sin θ cos θ / t away from its middle where it is seen, θ away from it,
    which is up to atan(l/v / t): the mean over the ommatidia on it times t depends on their axes
    alone. Motion vectors of detectors have no such meaning; they are above 0 all the same.

    Args:
        eye: whose.
        vectors: (..., N, 2), right and up: motion vectors of `DetectorArray.vectors`, or optic flow
            of ground truth. Ommatidia whose vector is NaN do not count.
        center: the direction (3,) in the head's frame.
        radius_deg: of the ommatidia that count, from that direction.

    Returns:
        (...,), in the unit of the vectors; above 0 where things move away from the direction. NaN
        where no ommatidium counts.

    Example:
        >>> eye = omma.eye.generate_eye(500)
        >>> still = omma.motion.expansion(eye, np.zeros((3, 500, 2)), (0, 0, -1))
        >>> still.shape, bool(still.any())
        ((3,), False)

    Raises:
        omma.Error: a wrong shape, a direction of no length, or a radius out of its range.
    """
    moved = array_of(vectors, "vectors", (..., len(eye), 2))
    middle = _centers_of(np.atleast_2d(array_of(center, "center", (3,))), "center")[0]
    frames = _frames_of(eye)
    theta, outward, _ = _around(frames[0], middle)
    near = (theta > _LEAST_AWAY) & (theta < math.radians(within(radius_deg, "radius_deg", 0, 180)))
    motion = np.einsum(
        "...nk,nk->...n", moved[..., near, :], _in_frames(frames, near, outward[near])
    )
    counts = np.isfinite(motion)
    total = np.where(counts, motion, 0).sum(axis=-1)
    number = counts.sum(axis=-1)
    return np.asarray(np.where(number > 0, total / np.maximum(number, 1), np.nan))


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class LoomingCells:
    """C cells over N ommatidia, each a cross of four arms; `looming_cells` makes them.

    Attributes:
        count: N.
        center: (C, 3), directions in the head's frame, the middles of their fields.
        cell, arm, ommatidium: (M,), which ommatidium is in which arm (of `omma.motion.ARMS`) of
            which cell.
        along: (M, 2), the direction of the arm at that ommatidium: right and up.
    """

    count: int
    center: Floats
    cell: Ints
    arm: Ints
    ommatidium: Ints
    along: Floats

    def __post_init__(self) -> None:
        whole(self.count, "count", 1, 2**31 - 1)
        center = array_of(self.center, "center", (None, 3), finite=True)
        along = array_of(self.along, "along", (None, 2), finite=True)
        limits = {"cell": len(center), "arm": len(ARMS), "ommatidium": self.count}
        for name, limit in limits.items():
            index = array_of(getattr(self, name), name, (len(along),), np.int64)
            if len(index) and (index.min() < 0 or index.max() >= limit):
                raise Error(f"{name}: expected numbers from 0 to {limit - 1}")
            object.__setattr__(self, name, index)
        object.__setattr__(self, "center", center)
        object.__setattr__(self, "along", along)

    def __len__(self) -> int:
        """How many cells there are."""
        return len(self.center)

    @checked
    def arms(self, vectors: ArrayLike) -> Floats:
        """The mean motion outwards along each arm, what goes inwards subtracted.

        Args:
            vectors: (..., N, 2), right and up, as `expansion` takes them.

        Returns:
            (..., C, 4), in the unit of the vectors, in the order of `omma.motion.ARMS`; NaN where
            no ommatidium of an arm counts.

        Raises:
            omma.Error: a wrong shape.
        """
        moved = array_of(vectors, "vectors", (..., self.count, 2))
        flat = moved.reshape(-1, self.count, 2)
        counts = np.asarray(np.isfinite(flat).all(axis=-1))
        seen = np.where(counts[..., None], flat, 0).reshape(len(flat), -1)
        total, number = (self._sums @ seen.T).T, (self._members @ counts.T.astype(float)).T
        mean = np.where(number > 0, total / np.maximum(number, 1), np.nan)
        return np.asarray(mean.reshape(*moved.shape[:-2], len(self), len(ARMS)))

    @checked
    def responses(self, vectors: ArrayLike, *, join: Literal["sum", "product"] = "sum") -> Floats:
        """What the cells answer: 0 or more.

        Args:
            vectors: (..., N, 2), right and up, as `expansion` takes them.
            join: "sum", the mean of the four arms, 0 where it is below 0: Zhou et al. 2022, eLife
                11:e72067, whose cells are such sums. "product": the fourth root of the arms'
                product, 0 where one is not above 0, so that all must move outwards, as others
                multiply (Zhao et al. 2023, iScience).

        Returns:
            (..., C), in the unit of the vectors; NaN where an arm is.

        Raises:
            omma.Error: a wrong shape, or another word for ``join``.
        """
        arms = self.arms(vectors)
        if one_of(join, ("sum", "product"), "join") == "sum":
            return np.asarray(np.maximum(arms.mean(axis=-1), 0))
        return np.asarray(np.prod(np.maximum(arms, 0) ** 0.25, axis=-1))

    @cached_property
    def _sums(self) -> csr_array:
        # (4 C, 2 N): what each arm adds up.
        columns = (2 * self.ommatidium[:, None] + (0, 1)).ravel()
        return self._matrix(self.along.ravel(), np.repeat(self._rows, 2), columns, 2 * self.count)

    @cached_property
    def _members(self) -> csr_array:
        # (4 C, N): 1 for each ommatidium of an arm.
        return self._matrix(np.ones(len(self.cell)), self._rows, self.ommatidium, self.count)

    @property
    def _rows(self) -> Ints:
        return len(ARMS) * self.cell + self.arm

    def _matrix(self, values: Floats, rows: Ints, columns: Ints, width: int) -> csr_array:
        return csr_array((values, (rows, columns)), (len(ARMS) * len(self), width))


@checked
def looming_cells(
    eye: Eye,
    centers: ArrayLike | None = None,
    *,
    radius_deg: float = 30.0,
    spacing_deg: float = 17.0,
    progress: Progress | None = None,
) -> LoomingCells:
    """Cells that pool local motion as LPLC2 do: outwards along the four arms of a cross.

    An arm is the quarter of the field around its direction, right, up, left or down as seen at the
    cell's middle; at an ommatidium it points the same way, carried there along the great circle.

    Args:
        eye: whose motion vectors are pooled.
        centers: directions (C, 3) in the head's frame. None: spread evenly, ``spacing_deg`` apart,
            wherever all four arms lie in the field of view.
        radius_deg: of the fields: LPLC2's are some 60° across (Klapoetke et al. 2017).
        spacing_deg: between neighbouring cells, where no centers are given. *Drosophila* has some
            80 on each side, and so has this; 1° at least, 47,600 directions.
        progress: called with the finished share (0 to 1), as many cells of large eyes take
            seconds; what it raises ends the work.

    Example:
        >>> cells = omma.motion.looming_cells(omma.species.drosophila().eye)
        >>> bool(cells.responses(np.zeros((len(omma.species.drosophila().eye), 2))).any())
        False

    Raises:
        omma.Error: directions of no length, an angle out of its range, more than 268 million pairs
            of a cell and an ommatidium, or no direction with four arms.
    """
    radius = math.radians(within(radius_deg, "radius_deg", 1e-3, 180))
    spread = centers is None
    if centers is None:
        spacing = math.radians(within(spacing_deg, "spacing_deg", _LEAST_SPACING_DEG, 180))
        # As many as there are hexagons of that spacing.
        count = max(round(8 * math.pi / (math.sqrt(3) * spacing**2)), 1)
    else:
        given = array_of(centers, "centers", (None, 3))
        count = len(given)
    if count * len(eye) > _MOST_PAIRS:
        name = "spacing_deg" if spread else "centers"
        raise Error(
            f"{name}: expected at most {_MOST_PAIRS:,} pairs of a cell and an ommatidium, found "
            f"{count:,} cells and {len(eye):,} ommatidia"
        )
    middles = sphere_directions(count) if spread else _centers_of(given, "centers")
    frames = _frames_of(eye)
    kept: list[Floats] = []
    cell, arm, ommatidium, along = [], [], [], []
    at_once = max(_PAIRS_AT_ONCE // max(len(eye), 1), 1)
    for first in range(0, count, at_once):
        if progress is not None:
            progress(first / count)
        some = middles[first : first + at_once]
        # Nearly so near; what is near is told exactly of these.
        of, near = np.nonzero(some @ frames[0].T > math.cos(radius) - 1e-6)
        theta, outward, turned = _around(frames[0][near], some[of])
        is_in = (theta > _LEAST_AWAY) & (theta < radius)
        of, near = of[is_in], near[is_in]
        outward, turned = outward[is_in], turned[is_in]
        which = np.rint(turned / (math.pi / 2)).astype(np.int64) % len(ARMS)
        members = np.bincount(len(ARMS) * of + which, minlength=len(ARMS) * len(some))
        stays = members.reshape(-1, len(ARMS)).min(axis=1) >= (_LEAST_OF_AN_ARM if spread else 0)
        # The arm's direction, in the great circle's frame at the ommatidium: outwards and across.
        off = (math.pi / 2) * which - turned
        across = np.cross(outward, frames[0][near])
        way = np.cos(off)[:, None] * outward + np.sin(off)[:, None] * across
        chosen = stays[of]
        cell.append((len(kept) + np.cumsum(stays) - 1)[of[chosen]])
        arm.append(which[chosen])
        ommatidium.append(near[chosen])
        along.append(_in_frames(frames, near[chosen], way[chosen]))
        kept.extend(some[stays])
    if not kept:
        raise Error(
            f"eye: expected somewhere at least {_LEAST_OF_AN_ARM} ommatidia in each of the four "
            f"arms of a cell, within {math.degrees(radius):g}°; found nowhere"
        )
    if progress is not None:
        progress(1.0)
    return LoomingCells(
        len(eye), np.array(kept), *map(np.concatenate, (cell, arm, ommatidium, along))
    )


def _frames_of(eye: Eye) -> _Frames:
    axis, right, up = (
        normalized(np.asarray(each, np.float64)) for each in (eye.axis, eye.right, eye.up)
    )
    return axis, right, up


def _around(axis: Floats, middle: Floats) -> tuple[Floats, Floats, Floats]:
    """Of axes (M, 3) how far they are from directions (M, 3) or (3,): angles (M,); which way leads
    on from there, directions (M, 3); and the way to them from the middle (M,), from right towards
    up; rad."""
    level = np.sum(axis * middle, axis=-1)
    away = axis * level[:, None] - middle
    length = np.linalg.norm(away, axis=1)
    is_steep = np.abs(middle[..., 1:2]) >= 1 - 1e-9
    right = normalized(np.cross(middle, np.where(is_steep, (0.0, 0, 1), (0.0, 1, 0))))
    up = np.cross(right, middle)
    outward = away / np.where(length > 0, length, 1)[:, None]
    turned = np.arctan2(np.sum(axis * up, axis=-1), np.sum(axis * right, axis=-1))
    return np.arctan2(length, level), outward, turned


def _in_frames(frames: _Frames, which: NDArray[np.generic], ways: Floats) -> Floats:
    """Directions (K, 3) as right and up (K, 2) of these ommatidia."""
    right, up = (each[which] for each in frames[1:])
    return np.stack([np.sum(ways * right, axis=1), np.sum(ways * up, axis=1)], axis=1)


def _centers_of(directions: Floats, name: str) -> Floats:
    length = np.linalg.norm(directions, axis=1)
    if not (np.isfinite(length).all() and (length > 0).all()):
        raise Error(f"{name}: expected directions of a length above 0")
    return np.asarray(directions / length[:, None])
