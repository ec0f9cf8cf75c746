"""Eyes' directions from the local interommatidial angle: a hexagonal lattice on the sphere.

The angle may differ horizontally and vertically, and from place to place. The lattice is hexagonal
in the metric (h/horizontal)² + (v/vertical)² of small steps h to the side and v up: six neighbours
at distance 1. Its density is 2/(√3 horizontal vertical) per steradian.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Flags, Floats
from omma.base.directions import azimuth_elevation_deg_of as azimuth_elevation_deg_of
from omma.base.directions import direction as direction
from omma.base.directions import normalized
from omma.base.progress import Stage
from omma.base.slips import warn_of_slip
from omma.base.values import value_class
from omma.eye.cells import cells
from omma.eye.nearest import Nearest
from omma.eye.relaxation import MARGIN, Domain, Region, grown, started

__all__ = ["Lattice", "LatticeCheck", "check_lattice"]

Angle = ArrayLike | Callable[[Floats], ArrayLike]
FieldOfView = Callable[[Floats], ArrayLike]


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Lattice:
    """Directions (N, 3) in the head frame, and the factor ``scale`` by which the
    wanted angles had to be multiplied to give as many as asked."""

    directions: Floats
    scale: float


def metric_of(directions: Floats, angles: Floats) -> Floats:
    """The metric (K, 2, 3) at directions (K, 3) of angles (K, 2): east and up over the angles."""
    x, _, z = directions.T
    level = np.hypot(x, z)
    # At the poles there is no east; any direction across is as good.
    at_pole = level < 1e-9
    level = np.where(at_pole, 1.0, level)
    east = np.stack([np.where(at_pole, 1.0, -z / level), np.zeros(len(x)), x / level], axis=1)
    up = np.cross(east, directions)
    return np.stack([east / angles[:, :1], up / angles[:, 1:]], axis=1)


def angles_at(directions: Floats, horizontal: Angle, vertical: Angle | None) -> Floats:
    """Horizontal and vertical angle (K, 2) in directions (K, 3), checked."""
    across = _values(horizontal, directions, "horizontal_rad")
    up = across if vertical is None else _values(vertical, directions, "vertical_rad")
    return np.stack([across, up], axis=1)


def _values(angle: Angle, directions: Floats, name: str) -> Floats:
    given = angle(directions) if callable(angle) else angle
    values = array_of(given, name, [(), (len(directions),)]) + np.zeros(len(directions))
    good = np.isfinite(values) & (values > 0) & (values < math.pi)
    if not good.all():
        bad = int(np.flatnonzero(~good)[0])
        azimuth, elevation = azimuth_elevation_deg_of(directions[bad])
        raise Error(
            f"{name}: expected angles above 0 and below 180°, found {values[bad]} rad at azimuth "
            f"{azimuth:.4g}°, elevation {elevation:.4g}°"
        )
    return values


_FACE_CELLS = 96  # to a side of the cube that the sphere is cut along; a cell is just under 1°
_CELL_FRACTION = 0.1  # of an ommatidium, at most, in the cells where the density is summed
_MOST_CELLS = 8_000_000


class SphereCells:
    """All directions as cells, and the angles wanted in them. Outside of the field of view the
    angles are those of the nearest cell inside."""

    def __init__(
        self,
        horizontal: Angle,
        vertical: Angle | None,
        field_of_view: FieldOfView | None,
        count: int | None,
    ) -> None:
        self._horizontal, self._vertical = horizontal, vertical
        self._field_of_view = field_of_view
        self.scale = 1.0
        self._asked, self._seen = np.empty((0, 3)), np.empty(0, bool)
        corner, size, face = _base_cells()
        middle, solid_angle = _cell_middle(corner, size, face)
        inside = self.sees(middle)
        if not inside.any():
            raise Error(f"field_of_view: holds none of {len(middle):,} directions all round")
        self._set_inside(middle[inside])
        if count is not None:
            # Roughly at first, so that cells are as fine as that many ommatidia need.
            found = float(self._fractions(middle, solid_angle)[inside].sum())
            self.scale = math.sqrt(found / count)
        region = Region(self.sees, self.metric, middle, inside, self._inside)
        done: list[tuple[Floats, Floats]] = []
        while len(corner):
            middle, solid_angle = _cell_middle(corner, size, face)
            fraction = self._fractions(middle, solid_angle)
            # The wall is at the margin of the coarsest lattice, for which such cells are fine.
            done_with = (fraction <= _CELL_FRACTION) | (region.outside(middle) > 2 * MARGIN)
            done.append((middle[done_with], fraction[done_with]))
            rest = np.flatnonzero(~done_with)
            if sum(len(part) for part, _ in done) + 4 * len(rest) > _MOST_CELLS:
                raise Error(
                    "horizontal_rad: the angles are so small that there would be more than "
                    f"{_MOST_CELLS // 40:,} ommatidia"
                )
            half = np.repeat(size[rest] / 2, 4)
            shift = np.tile([[0, 0], [1, 0], [0, 1], [1, 1]], (len(rest), 1)) * half[:, None]
            corner = np.repeat(corner[rest], 4, axis=0) + shift
            size, face = half, np.repeat(face[rest], 4)
        self.middle = np.concatenate([part for part, _ in done])
        self.fraction = np.concatenate([part for _, part in done])
        inside = self.sees(self.middle)
        self.closed = bool(inside.all())
        total = float(self.fraction[inside].sum())
        self.count = count or round(total)
        if self.count < 2:
            raise Error("horizontal_rad: the field of view holds less than 2 ommatidia")
        self.fraction *= self.count / total
        self.scale *= math.sqrt(total / self.count)
        self._set_inside(self.middle[inside])
        self.region = Region(self.sees, self.metric, self.middle, inside, self._inside)

    def sees(self, directions: Floats) -> Flags:
        """Which directions (K, 3) are in the field of view."""
        if self._field_of_view is None:
            return np.ones(len(directions), bool)
        # Asked for by the metric and the distance outside, one after the other.
        if np.array_equal(directions, self._asked):
            return self._seen
        seen = np.asarray(self._field_of_view(directions))
        if seen.shape != (len(directions),) or seen.dtype != np.bool_:
            raise Error(
                f"field_of_view: expected truth values of shape ({len(directions)},), found "
                f"{seen.dtype} of shape {seen.shape}"
            )
        self._asked, self._seen = directions.copy(), seen.copy()
        return seen

    def angles(self, directions: Floats) -> Floats:
        """Horizontal and vertical angle (K, 2), rad, also outside."""
        seen = self.sees(directions)
        if seen.all():
            return self.scale * angles_at(directions, self._horizontal, self._vertical)
        angles = np.empty((len(directions), 2))
        angles[~seen] = self._inside_angles[self._inside(directions[~seen])]
        if seen.any():
            angles[seen] = angles_at(directions[seen], self._horizontal, self._vertical)
        return self.scale * angles

    def metric(self, directions: Floats) -> Floats:
        """What measures small steps in units of the wanted angles: (K, 2, 3)."""
        return metric_of(directions, self.angles(directions))

    def _fractions(self, directions: Floats, solid_angle: Floats) -> Floats:
        angles = self.angles(directions)
        return np.asarray(solid_angle * 2 / (math.sqrt(3) * angles[:, 0] * angles[:, 1]))

    def _set_inside(self, inside: Floats) -> None:
        self._inside_angles = angles_at(inside, self._horizontal, self._vertical)
        self._inside = Nearest(inside)


def _base_cells() -> tuple[Floats, Floats, NDArray[np.int64]]:
    side = np.arange(_FACE_CELLS) * (2 / _FACE_CELLS) - 1
    a, b = np.meshgrid(side, side, indexing="ij")
    corner = np.stack([a.ravel(), b.ravel()], axis=1)
    face = np.repeat(np.arange(6), len(corner))
    return np.tile(corner, (6, 1)), np.full(len(face), 2 / _FACE_CELLS), face


def _cell_middle(corner: Floats, size: Floats, face: NDArray[np.int64]) -> tuple[Floats, Floats]:
    # Squares on the faces of the cube around the unit sphere: middles as directions and solid
    # angles, exact: that of a rectangle from the face's middle to (x, y) is
    # atan(xy / sqrt(x² + y² + 1)).
    middle = corner + size[:, None] / 2
    third = np.where(face % 2, -1.0, 1.0)
    points = np.empty((len(face), 3))
    for axis in range(3):
        rows = face // 2 == axis
        points[rows, axis] = third[rows]
        points[rows, (axis + 1) % 3] = middle[rows, 0]
        points[rows, (axis + 2) % 3] = middle[rows, 1]
    solid_angle = np.zeros(len(face))
    for x, y, sign in ((1, 1, 1), (0, 1, -1), (1, 0, -1), (0, 0, 1)):
        a, b = corner[:, 0] + x * size, corner[:, 1] + y * size
        solid_angle += sign * np.arctan(a * b / np.sqrt(a * a + b * b + 1))
    return normalized(points), solid_angle


@checked
def lay_directions(
    horizontal_rad: Angle,
    vertical_rad: Angle | None = None,
    *,
    field_of_view: FieldOfView | None = None,
    count: int | None = None,
    seed: int = 0,
    progress: Stage | None = None,
) -> Lattice:
    """Directions in a hexagonal lattice of given local interommatidial angles.

    Args:
        horizontal_rad: the wanted angle between an ommatidium and a neighbour to its side: a number
            or a function of directions (K, 3) in the head's frame (+X right, +Y up,
            -Z ahead), to (K,) numbers. Asked for inside the field of view only.
        vertical_rad: the same for a neighbour above or below; None: as horizontally. Rows as they
            are published, ommatidia Δφ_h apart in a row and every second row Δφ_v below, are
            horizontally Δφ_h and vertically Δφ_v/√3.
        field_of_view: a function of directions (K, 3) to truth values (K,), as from `window` or
            `outline`; None: all round. It is looked at about every degree, more finely where
            ommatidia are dense.
        count: how many, exactly; the angles are all multiplied by what that takes. None: as many
            as the angles make, the integral of 2/(√3 horizontal vertical).
        seed: the same seed gives the same directions (on one machine); another one, another
            arrangement.
        progress: called as progress(stage, share done) now and then.

    Raises:
        omma.Error: an argument out of range, an angle that is none, an empty field of view.

    Warns:
        UserWarning: numbers above 60°, mostly degrees, where they are not relative to a ``count``.
    """
    random, tell = started(count, seed, progress)
    sphere = SphereCells(horizontal_rad, vertical_rad, field_of_view, count)
    domain = Domain(
        normalized,
        sphere.metric,
        None if sphere.closed else sphere.region.outside,
        sphere.middle,
        sphere.fraction,
    )
    points = grown(domain, sphere.count, random, partial(tell, "placing ommatidia"))
    if not sphere.closed:
        points = sphere.region.deepest(points, sphere.count)
    if count is None:
        _tell_of_degrees(horizontal_rad, vertical_rad)
    return Lattice(points, sphere.scale)


def _tell_of_degrees(horizontal_rad: Angle, vertical_rad: Angle | None) -> None:
    for name, angle in (("horizontal_rad", horizontal_rad), ("vertical_rad", vertical_rad)):
        if angle is not None and not callable(angle):
            warn_of_slip("interommatidial angle", angle, name)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class LatticeCheck:
    """How near a lattice comes to what was wanted.

    ``ratio`` (N,) is the mean distance of an ommatidium to its six nearest, in the metric of the
    wanted angles: 1 is as wanted. ``degree`` (N,) is the number of its neighbours, those whose
    Voronoi cells in that metric touch its own; ``inner`` (N,) those that neighbours surround. Of
    the inner ones, ``median_error`` and ``p95_error`` are the median and 95th percentile of
    |ratio - 1| and ``six_fraction`` is the share with six neighbours.
    """

    ratio: Floats
    degree: NDArray[np.int64]
    inner: Flags
    median_error: float
    p95_error: float
    six_fraction: float


# Between neighbours of five-, six- and sevenfold points the widest angle is 72°, 60° and 51°; on a
# border of a lattice it is 120° at least.
_BORDER_GAP_RAD = math.radians(100)


@checked
def check_lattice(
    directions: ArrayLike, horizontal_rad: Angle, vertical_rad: Angle | None = None
) -> LatticeCheck:
    """Compare directions (N, 3) with the local angles wanted, as `lay_directions` takes them.

    Raises:
        omma.Error: directions that are none, fewer than 8 of them, angles that are none.

    Warns:
        UserWarning: numbers above 60°, mostly degrees.
    """
    points = array_of(directions, "directions")
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 8:
        raise Error(f"directions: expected at least 8 of shape (N, 3), found {points.shape}")
    metric = metric_of(points, angles_at(points, horizontal_rad, vertical_rad))
    _tell_of_degrees(horizontal_rad, vertical_rad)
    net = cells(points, metric)
    ratio = np.sort(net.distance, axis=1)[:, :6].mean(axis=1)
    inner = net.widest_gap_rad < _BORDER_GAP_RAD
    if not inner.any():
        raise Error("directions: no ommatidium is surrounded by neighbours")
    error = np.abs(ratio[inner] - 1)
    return LatticeCheck(
        ratio,
        net.degree,
        inner,
        float(np.median(error)),
        float(np.quantile(error, 0.95)),
        float(np.mean(net.degree[inner] == 6)),
    )
