"""Which ommatidia are neighbours: the lattice of an eye, in direction and on its surface.

Neighbours are those of the Delaunay triangulation on the sphere, which is the convex hull of the
directions (K. Q. Brown 1979, Information Processing Letters 9:223). In a hexagonal lattice these
are the six around each, also where it is stretched: along its rows by less than √3, across them by
any factor. (Stretched further along its rows it is another lattice, with other neighbours.)
A triangulation also closes over what an eye does not see: triangles far larger than the lattice
are taken away, and then, from the border inwards, flat ones that only bridge notches in it. The
triangles of a lattice are never obtuse, so none of its own is lost.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Flags, Floats, Ints
from omma.base.directions import normalized
from omma.base.values import value_class

# The circle around a triangle of a lattice has 0.5 to 0.71 times the radius of the distance to the
# third nearest point. What is far over that spans a hole; a steep acute zone has up to about 2. Up
# to seven missing ommatidia side by side (1.73) are bridged.
_LARGEST_CIRCLE = 2.0
# How much larger that distance is than around it, at the edges of the steepest acute zones.
_STEEPEST = 1.5
# A right angle is the most a lattice has; the rest is disorder. Triangles flatter than the first
# are taken from the border again and again, those flatter than the second once, so that a
# disordered eye is not eaten up.
_FLATTEST_RAD, _FLATTEST_OUTER_RAD = np.radians(110), np.radians(95)
_SAME_RAD = 1e-6  # directions in single precision are known to 1e-7


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Neighbours:
    """The neighbours among K points.

    pairs: (E, 2), each pair of neighbours once, as indices into the K points.
    triangles: (T, 3), counter-clockwise seen from outside; no point of the K lies in one.
    border: (K,), whether a point is on the border of the lattice, or has no neighbours.
    first: (K,), of points that are in the same direction, and of doubles, the first: pairs and
        triangles hold only that one, and what is asked of the others is answered for it.
    """

    pairs: Ints
    triangles: Ints
    border: Flags
    first: Ints

    def count(self) -> Ints:
        """How many neighbours each has: (K,)."""
        count = np.bincount(self.pairs.ravel(), minlength=len(self.border))
        return np.asarray(count[self.first])

    def mean_over_neighbours(self, values: Floats) -> Floats:
        """The mean of ``values`` (K,) or (K, D) over the neighbours of each; NaN where none."""
        flat = values.reshape(len(values), -1)
        total = np.zeros_like(flat)
        for one, other in (self.pairs.T, self.pairs.T[::-1]):
            np.add.at(total, one, flat[other])
        return self._mean(total, self.pairs).reshape(values.shape)

    def mean_over_pairs(self, values: Floats) -> Floats:
        """The mean of ``values`` (E,), one a pair, over the pairs of each: (K,), NaN where none."""
        total = np.zeros((len(self.border), 1))
        for end in self.pairs.T:
            np.add.at(total, end, values[:, None])
        return self._mean(total, self.pairs)[:, 0]

    def mean_over_triangles(self, values: Floats) -> Floats:
        """The mean of ``values`` (T, ...), one a triangle, over those at each point: (K, ...)."""
        flat = values.reshape(len(values), int(np.prod(values.shape[1:])))
        total = np.zeros((len(self.border), flat.shape[1]))
        for corner in self.triangles.T:
            np.add.at(total, corner, flat)
        return self._mean(total, self.triangles).reshape(len(total), *values.shape[1:])

    def _mean(self, total: Floats, groups: Ints) -> Floats:
        count = np.bincount(groups.ravel(), minlength=len(total))[:, None]
        mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
        return np.asarray(mean[self.first])


def direction_lattice(
    axis: Floats, eye_id: NDArray[np.int32], double_of: Ints | None = None
) -> Neighbours:
    """The lattice of axes (N, 3), each eye's for itself. Ommatidia of one eye with the same axis
    count as one, and so do `doubles`."""
    single = _single(double_of, len(axis))
    groups = []
    for which in np.unique(eye_id):
        members = np.flatnonzero((eye_id == which) & single)
        directions = normalized(axis[members])
        groups.append((members, directions))
    return _answered_for_doubles(_joined(groups, len(axis)), double_of)


def surface_lattice(
    position: Floats, eye_id: NDArray[np.int32], double_of: Ints | None = None
) -> Neighbours:
    """The lattice of positions (N, 3), each eye's for itself, seen from its centre. `doubles` count
    as one.

    Meant for surfaces that bulge, as eyes do. Eyes with fewer than four positions, or with all of
    them at a point, have none.
    """
    single = _single(double_of, len(position))
    groups = []
    for which in np.unique(eye_id):
        members = np.flatnonzero((eye_id == which) & single)
        outward = position[members] - eye_centre(position[members])
        length = np.linalg.norm(outward, axis=1, keepdims=True)
        if len(members) >= 4 and length.min() > 0:
            groups.append((members, outward / length))
    return _answered_for_doubles(_joined(groups, len(position)), double_of)


def surface_normals(position: Floats, surface: Neighbours) -> Floats:
    """The normals of the surface, out of the eye, from the triangles around each position by their
    area: (N, 3), of any length; zero where there are none."""
    extent = float(np.ptp(position, axis=0).max()) or 1.0
    corners = position[surface.triangles] / extent
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.nan_to_num(surface.mean_over_triangles(area * len(position)))


def eye_centre(position: Floats) -> Floats:
    """The centre of the sphere that fits positions (N, 3) best, or their middle where none does.

    Least squares in |p|² = 2 p·c + k, linear in c. Where the positions bulge so little that the
    centre would be over ten times their extent away, it is put there; where they lie in a plane,
    across it.
    """
    middle = position.mean(axis=0)
    shifted = position - middle
    extent = float(np.abs(shifted).max())
    if extent == 0 or len(position) < 4:
        return np.asarray(middle)
    scaled = shifted / extent
    spread, directions = np.linalg.svd(scaled, full_matrices=False)[1:]
    if spread[2] < 1e-4 * spread[1]:
        return np.asarray(middle - 10 * extent * directions[2])
    unknowns = np.column_stack([2 * scaled, np.ones(len(scaled))])
    found = np.linalg.lstsq(unknowns, np.sum(scaled**2, axis=1), rcond=1e-9)[0][:3]
    far = float(np.linalg.norm(found))
    return np.asarray(middle + extent * found * min(1.0, 10 / max(far, 1e-30)))


def sides(position: Floats, eye_id: NDArray[np.int32]) -> NDArray[np.int32]:
    """``eye_id``, or 0 and 1 for left and right where a single eye is clearly two: (N,).

    That is where the positions leave a gap around x = 0 of over four times the median distance to
    the nearest position, as projections have it too.
    """
    from scipy.spatial import cKDTree

    if len(np.unique(eye_id)) > 1 or len(position) < 8:
        return eye_id
    x = position[:, 0]
    if not (x.min() < 0 < x.max()):
        return eye_id
    gap = x[x >= 0].min() - x[x < 0].max()
    spacing = cKDTree(position).query(position, k=2)[0][:, 1]
    if gap <= 4 * float(np.median(spacing)):
        return eye_id
    return (x >= 0).astype(np.int32)


def _single(double_of: Ints | None, count: int) -> Flags:
    return np.ones(count, bool) if double_of is None else double_of < 0


def _answered_for_doubles(lattice: Neighbours, double_of: Ints | None) -> Neighbours:
    if double_of is None:
        return lattice
    counted = np.where(double_of < 0, np.arange(len(double_of)), double_of)
    return replace(lattice, border=lattice.border[counted], first=lattice.first[counted])


def _joined(groups: Iterable[tuple[Ints, Floats]], count: int) -> Neighbours:
    pairs, triangles = [], []
    border, same = np.ones(count, bool), np.arange(count)
    for members, directions in groups:
        first, inverse = _distinct(directions)
        found, corners, outer = _lattice(directions[first])
        pairs.append(members[first][found])
        triangles.append(members[first][corners])
        border[members] = outer[inverse]
        same[members] = members[first][inverse]
    return Neighbours(
        np.concatenate(pairs or [np.empty((0, 2), np.int64)]).astype(np.int64),
        np.concatenate(triangles or [np.empty((0, 3), np.int64)]).astype(np.int64),
        border,
        same,
    )


def _distinct(directions: Floats) -> tuple[Ints, Ints]:
    # The first of each set of equal directions, and which of these each belongs to.
    from scipy.spatial import cKDTree

    _, index, inverse = np.unique(directions, axis=0, return_index=True, return_inverse=True)
    label = index[inverse.reshape(-1)]
    near = cKDTree(directions[index]).query_pairs(_SAME_RAD, output_type="ndarray")
    for one, other in np.sort(index[near], axis=1):
        label[label == label[other]] = label[one]
    first, inverse = np.unique(label, return_inverse=True)
    return first.astype(np.int64), inverse.astype(np.int64)


def _lattice(directions: Floats) -> tuple[Ints, Ints, Flags]:
    # Pairs, triangles, and which points are on the border.
    from scipy.spatial import cKDTree

    triangles = _delaunay(directions)
    if len(triangles):
        spacing = _local_spacing(directions)
        triangles = _without_bridges(directions, triangles, spacing)
    if len(triangles) == 0:
        return _chain(directions), triangles, np.ones(len(directions), bool)
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    pairs, times = np.unique(edges, axis=0, return_counts=True)
    border = np.zeros(len(directions), bool)
    border[pairs[times == 1]] = True
    lonely = np.setdiff1d(np.arange(len(directions)), triangles)
    border[lonely] = True
    # A point that only flat triangles held keeps the nearest it has, but one far off the lattice,
    # as by a wrong axis, is nobody's neighbour.
    if len(lonely):
        apart, near = cKDTree(directions).query(directions[lonely], k=2)
        close = apart[:, 1] <= _LARGEST_CIRCLE * spacing[near[:, 1]]
        more = np.sort(np.column_stack([lonely, near[:, 1]])[close], axis=1)
        pairs = np.unique(np.concatenate([pairs, more]), axis=0)
    return pairs, triangles, border


def _delaunay(directions: Floats) -> Ints:
    from scipy.spatial import ConvexHull, QhullError

    if len(directions) < 3:
        return np.empty((0, 3), np.int64)
    if len(directions) == 3:
        triangles = np.arange(3)[None]
    else:
        try:
            hull = ConvexHull(directions)
        except QhullError:  # all on one circle
            return np.empty((0, 3), np.int64)
        # Where an eye sees less than half of all directions, the hull closes on its far side: there
        # the middle of the sphere is outside.
        triangles = hull.simplices[hull.equations[:, 3] < -_SAME_RAD].astype(np.int64)
    a, b, c = directions[triangles].transpose(1, 0, 2)
    inside = np.sum(np.cross(b - a, c - a) * a, axis=1) < 0
    triangles[inside] = triangles[inside][:, ::-1]
    return np.asarray(triangles)


def _chain(directions: Floats) -> Ints:
    # Points on one circle, or too few for a triangle: each with its nearest, and with its second
    # nearest where that is so from both sides, which it is not at the ends of a row.
    from scipy.spatial import cKDTree

    count = len(directions)
    if count < 2:
        return np.empty((0, 2), np.int64)
    near = cKDTree(directions).query(directions, k=3 if count > 3 else 2)[1][:, 1:]
    nearest = np.sort(np.column_stack([np.arange(count), near[:, 0]]), axis=1)
    both = np.column_stack([np.repeat(np.arange(count), near.shape[1]), near.ravel()])
    pairs, times = np.unique(np.sort(both, axis=1), axis=0, return_counts=True)
    return np.asarray(np.unique(np.concatenate([pairs[times == 2], nearest]), axis=0))


def _local_spacing(directions: Floats) -> Floats:
    # The distance to the third nearest, but little more than it is for the nearest six: of a point
    # far off the lattice, as by a wrong axis, it is that of the lattice it is nearest to.
    from scipy.spatial import cKDTree

    distance, near = cKDTree(directions).query(directions, k=min(7, len(directions)))
    third = distance[:, :4][:, -1]
    around = np.median(third[near[:, 1:]], axis=1)
    return np.asarray(np.minimum(third, _STEEPEST * around))


def _without_bridges(directions: Floats, triangles: Ints, spacing: Floats) -> Ints:
    corners = directions[triangles]
    edge = np.linalg.norm(corners[:, [1, 2, 0]] - corners[:, [2, 0, 1]], axis=2)  # opposite each
    doubled = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    radius = edge.prod(axis=1) / np.maximum(2 * doubled, 1e-300)
    kept = radius <= _LARGEST_CIRCLE * spacing[triangles].max(axis=1)
    triangles, edge = triangles[kept], edge[kept]
    while len(triangles):
        flat = _outer_angle(triangles, edge) > _FLATTEST_RAD
        if not flat.any():
            break
        triangles, edge = triangles[~flat], edge[~flat]
    kept = _outer_angle(triangles, edge) <= _FLATTEST_OUTER_RAD
    return np.asarray(triangles[kept])


def _outer_angle(triangles: Ints, edge: Floats) -> Floats:
    # The largest angle of each triangle that lies opposite a border edge, 0 where none does.
    ends = np.sort(triangles[:, [[1, 2], [2, 0], [0, 1]]], axis=2)
    _, which, times = np.unique(
        ends.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True
    )
    outer = (times == 1)[which.reshape(-1)].reshape(-1, 3)
    a, b, c = edge, np.roll(edge, -1, axis=1), np.roll(edge, 1, axis=1)
    angle = np.arccos(np.clip((b**2 + c**2 - a**2) / (2 * b * c), -1, 1))
    return np.asarray(np.where(outer, angle, 0.0).max(axis=1, initial=0.0))
