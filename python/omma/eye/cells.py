"""Neighbours in a lattice whose spacing differs from place to place and from one direction to
another, so that distances are measured by a metric of each point's own.

A metric (N, 2, 3) is two vectors along the surface at right angles, whose products with a step are
its lengths along them in units of the spacing wanted there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omma.base.arrays import Flags, Floats, Ints

NEIGHBOURS = 18  # two rings of a hexagonal lattice; the next is under a hundredth of the force


def pair_distance_squared(apart: Floats, own: Floats, other: Floats) -> Floats:
    """Squared metric length (N, K) of steps (N, K, 3) from points of metric ``own`` (N, 2, 3) to
    others of metric ``other`` (N, K, 2, 3): the geometric mean of what both say, which is close to
    the integral between them."""
    here = _squared(np.matmul(apart, own.transpose(0, 2, 1)))
    return np.asarray(np.sqrt(here * _squared(np.matmul(other, apart[..., None])[..., 0])))


def _squared(lengths: Floats) -> Floats:
    # Of both components (..., 2); a sum along so short an axis is slow.
    lengths *= lengths
    return np.asarray(lengths[..., 0] + lengths[..., 1])


class Pairs:
    """Each point with those ``near`` it (N, K), for who measures between them again and again. Most
    are near each other: what the other's metric says of a step is what it says of its own back."""

    def __init__(self, near: Ints) -> None:
        count, width = near.shape
        rows = np.arange(count)[:, None]
        self.near = near
        order = np.argsort(near, axis=1)
        key = (rows * count + np.take_along_axis(near, order, axis=1)).ravel()
        back = (near * count + rows).ravel()
        place = np.minimum(np.searchsorted(key, back), len(key) - 1)
        self._back = (rows * width + order).ravel()[place]
        self._alone = np.flatnonzero(key[place] != back)
        self._other = near.ravel()[self._alone]

    def distance_squared(self, apart: Floats, metric: Floats) -> Floats:
        """As `pair_distance_squared` of steps (N, K, 3) from each to its near ones, for the metric
        (N, 2, 3) of all points."""
        here = _squared(np.matmul(apart, metric.transpose(0, 2, 1)))
        # `pair_distance_squared` multiplies vectors there, in which OpenBLAS adds in another order
        # (found on x86-64 with FMA): taken here too, as where a lattice ends depends on rounding.
        turned = metric[:, :, _VECTOR_ORDER].transpose(0, 2, 1)
        there = _squared(np.matmul(apart[:, :, _VECTOR_ORDER], turned)).ravel().take(self._back)
        steps = apart.reshape(-1, 3).take(self._alone, axis=0)
        alone = np.matmul(metric.take(self._other, axis=0), steps[:, :, None])[..., 0]
        there[self._alone] = _squared(alone)
        here *= there.reshape(here.shape)
        return np.asarray(np.sqrt(here, out=here))


_VECTOR_ORDER = [1, 0, 2]


def nearest(points: Floats, metric: Floats, count: int) -> Ints:
    """The ``count`` (or all) nearest of each point in the metric, in no order: (N, count)."""
    from scipy.spatial import cKDTree

    count = min(count, len(points) - 1)
    size = np.linalg.norm(metric, axis=2)
    # The nearest in space hold the nearest in the metric where enough of them are looked at.
    stretch = size.max(axis=1) / size.min(axis=1)
    found = np.empty((len(points), count), dtype=np.int64)
    tree = cKDTree(points)
    for low, high in ((1.0, 1.5), (1.5, 3.0), (3.0, 6.0), (6.0, np.inf)):
        group = np.flatnonzero((stretch >= low) & (stretch < high))
        looked = min(len(points), 1 + math.ceil(1.3 * count * min(high, 12.0)))
        for start in range(0, len(group), 4096):
            rows = group[start : start + 4096]
            near = tree.query(points[rows], looked)[1].reshape(len(rows), -1)
            apart = points[rows, None, :] - points[near]
            length = pair_distance_squared(apart, metric[rows], metric[near])
            length[near == rows[:, None]] = np.inf
            chosen = np.argpartition(length, count - 1, axis=1)[:, :count]
            found[rows] = np.take_along_axis(near, chosen, axis=1)
    return found


@dataclass(frozen=True)
class Cells:
    """Cells of the lattice: which of its ``near`` (N, K) are neighbours, at what metric distance
    (N, K), how many, and the widest angle between two neighbours next to each other (rad)."""

    near: Ints
    distance: Floats
    is_neighbour: Flags
    widest_gap_rad: Floats

    @property
    def degree(self) -> Ints:
        return np.asarray(self.is_neighbour.sum(axis=1))

    def edges(self) -> Ints:
        """Pairs (E, 2) that are neighbours of each other, the lower index first."""
        start, column = np.nonzero(self.is_neighbour)
        end = self.near[start, column]
        key = np.minimum(start, end) * len(self.near) + np.maximum(start, end)
        unique, count = np.unique(key, return_counts=True)
        key = unique[count == 2]
        return np.stack([key // len(self.near), key % len(self.near)], axis=1)


# Neighbours further away than this look at each other across a notch of the border.
_LONGEST_EDGE = 1.75


def cells(points: Floats, metric: Floats) -> Cells:
    """The Voronoi cell of each point, in the plane of its own metric.

    Inverted at the circle around the point, the others' corners of the convex hull are the
    neighbours; a corner sees all the rest within half a turn.
    """
    near = nearest(points, metric, NEIGHBOURS)
    n, k = near.shape
    distance = np.empty((n, k))
    is_neighbour = np.zeros((n, k), bool)
    gap = np.empty(n)
    for first in range(0, n, 4096):
        rows = slice(first, min(first + 4096, n))
        apart = points[near[rows]] - points[rows, None, :]
        length = np.sqrt(pair_distance_squared(apart, metric[rows], metric[near[rows]]))
        flat = np.matmul(apart, metric[rows].transpose(0, 2, 1))
        flat *= (length / np.maximum(np.linalg.norm(flat, axis=2), 1e-300))[:, :, None]
        inverse = flat / np.maximum(length**2, 1e-12)[:, :, None]
        # The point itself, at infinity after inversion, is the origin of the dual hull.
        inverse = np.concatenate([inverse, np.zeros((len(inverse), 1, 2))], axis=1)
        to = inverse[:, None, :, :] - inverse[:, :k, None, :]
        angle = np.arctan2(to[..., 1], to[..., 0])
        own = np.arange(k)
        angle[:, own, own] = angle[:, own, (own + 1) % k]  # none to itself: any other again
        angle.sort(axis=2)
        around = np.diff(angle, axis=2, append=angle[:, :, :1] + 2 * math.pi)
        corner = (around.max(axis=2) > math.pi) & (length < _LONGEST_EDGE)
        distance[rows], is_neighbour[rows] = length, corner
        bearing = np.where(corner, np.arctan2(flat[..., 1], flat[..., 0]), np.inf)
        bearing.sort(axis=1)
        first_bearing = np.where(corner.any(axis=1), bearing[:, 0], 0.0)[:, None]
        bearing = np.where(np.isinf(bearing), first_bearing + 2 * math.pi, bearing)
        turn = np.diff(bearing, axis=1, append=first_bearing + 2 * math.pi)
        gap[rows] = turn.max(axis=1)
    return Cells(near, distance, is_neighbour, gap)
