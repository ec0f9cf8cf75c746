"""Ommatidia by row and neighbour: hexagonal coordinates, and who is dorsal, in front, ventral.

A compound eye's lattice is hexagonal, but curved, stretched and not without faults. So neighbours
come from the triangulation of `omma.eye.neighbours`, and what is "dorsal" among an ommatidium's six
is handed on from the middle of the eye outwards: where both have six neighbours around them, the
direction opposite to the one gone is the way back. Coordinates count the steps on the way.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arguments import checked, one_of
from omma.base.arrays import Floats, Ints
from omma.base.directions import normalized
from omma.base.slips import warn_of_slip
from omma.base.values import value_class
from omma.eye.doubles import doubles
from omma.eye.neighbours import Neighbours, direction_lattice, sides, surface_lattice

__all__ = ["DIRECTIONS", "NO_COORDINATE", "HexagonalCoordinates"]


# What neighbours are called, in the order of their columns: from the dorsal one over the front.
DIRECTIONS = ("v", "q", "-p", "-v", "-q", "p")
# Steps in p and q to each of them; v = p + q (h = q - p leads between q and -p, to the front).
_STEPS = np.array([[1, 1], [0, 1], [-1, 0], [-1, -1], [0, -1], [1, 0]])
# Coordinate of an ommatidium that has none.
NO_COORDINATE = -(2**31)

# In a lattice of six neighbours at least this share of the inner ommatidia have six. Points strewn
# at random have 0.29 (Poisson-Delaunay), a lattice grown over a field of view 0.85 and more.
_LEAST_SIX = 0.6
# In a square lattice one edge in three is the diagonal of a square, as long as the other diagonal.
_MOST_SQUARE, _SQUARE_WITHIN = 0.2, 0.05
# From dorsal towards the front. An eye whose rows are vertical has neighbours at 0° and every 60°,
# one whose rows are horizontal at 30°, 90° ...: either way v is the first of them.
_FIRST_RAD = np.radians(15)
# Further from the horizon, dorsal and front are ill defined, as at a pole.
_POLE_RAD = np.radians(60)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class HexagonalCoordinates:
    """Where each of N ommatidia is in the lattice of its eye.

    Directions are anatomical, the same for left and right eyes, whose coordinates are mirror
    images: in an eye of vertical rows, as a fly's, +v is dorsal, +q dorsal and to the front, +p
    dorsal and to the back; in an eye of horizontal rows +q is to the front, +v dorsal and to the
    front, +p dorsal and to the back. Rows p, q, v = p + q and h = q - p, to the front, count as
    those of Zhao et al. 2025 (Nature, doi:10.1038/s41586-025-09276-5).

    Attributes:
        p, q: (N,), 0 in the middle of each eye; `NO_COORDINATE` where there is none: at faults of
            the lattice, where it was not reached, or where another has the same coordinates already
            (behind a fault, where a row begins or ends).
        neighbours: (N, 6), ommatidia in the directions v, q, -p, -v, -q, p (`DIRECTIONS`); -1 at
            edges and faults. Mutual: the neighbour's neighbour in the opposite direction, three
            columns on, is the ommatidium itself.
        fault: (N,), inner ommatidia that have not six neighbours.
        side: (N,), -1 in a left eye, 1 in a right one.
        angle_rad: (N, 6), where the neighbours in that direction lie on average in the eye, from
            dorsal (0) towards the front (a quarter turn); NaN in an eye without a lattice.
    """

    p: Ints
    q: Ints
    neighbours: Ints
    fault: NDArray[np.bool_]
    side: Ints
    angle_rad: Floats

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which ommatidia have coordinates: (N,)."""
        return np.asarray(self.p != NO_COORDINATE)

    def towards(self, angle_rad: float) -> Ints:
        """The neighbour of each that lies nearest to this direction, from dorsal (0) towards the
        front (a quarter turn): (N,), -1 where there is none. In each eye it is one direction.

        Warns:
            UserWarning: a direction of more than a turn, mostly degrees.
        """
        off = np.abs((self.angle_rad - angle_rad + np.pi) % (2 * np.pi) - np.pi)
        warn_of_slip("direction", angle_rad, "angle_rad")
        off = np.where(np.isnan(off), 0.0, off)
        found: Ints = self.neighbours[np.arange(len(off)), np.argmin(off, axis=1)]
        return found


@checked
def hexagonal_coordinates(
    eye: Eye, by: Literal["surface", "direction"] = "surface"
) -> HexagonalCoordinates:
    """Rows and neighbours of an eye, or of each eye of a head for itself.

    Args:
        by: whose lattice: that of the lenses on the "surface", which is what neurons are wired by,
            or that of viewing directions, for eyes whose positions say nothing.

    Returns:
        Coordinates and neighbours; none in an eye whose lattice is not hexagonal (square, or
        scattered).

    Example:
        >>> found = omma.eye.hexagonal_coordinates(omma.eye.generate_eye(200))
        >>> found.neighbours.shape
        (200, 6)

    Raises:
        omma.Error: another word for ``by``.
    """
    one_of(by, ("surface", "direction"), "by")
    position, axis = eye.position_m.astype(np.float64), normalized(eye.axis.astype(np.float64))
    eye_id = sides(position, eye.eye_id)
    positions = position if by == "surface" else axis
    lattice_of = surface_lattice if by == "surface" else direction_lattice
    lattice = lattice_of(positions, eye_id, doubles(position, axis, eye_id))
    count = len(axis)
    p, q = np.full(count, NO_COORDINATE, np.int64), np.full(count, NO_COORDINATE, np.int64)
    neighbours, angle = np.full((count, 6), -1, np.int64), np.full((count, 6), np.nan)
    side = np.ones(count, np.int64)
    degree = lattice.count()
    fault = ~lattice.border & (degree != 6)
    fans = _fans(lattice, count)
    for which in np.unique(eye_id):
        members = np.flatnonzero(eye_id == which)
        side[members] = 1 if axis[members, 0].mean() >= 0 else -1
        if not _is_hexagonal(lattice, positions, members, degree):
            continue
        # Rings run counter-clockwise from outside, which is from dorsal to the front in left eyes.
        rings = {i: fans[i][:: -side[i]] for i in members.tolist() if i in fans and not fault[i]}
        inner = [i for i in rings if not lattice.border[i]]
        seed = inner[int(np.argmax(axis[inner] @ axis[members].mean(axis=0)))]
        neighbours[members] = _neighbours(rings, set(inner), seed, count)[members]
        turned, angle[members] = _turned(neighbours, axis, members, side[seed])
        neighbours[members] = turned
        p[members], q[members] = _counted(neighbours, seed, count)[:, members]
    return HexagonalCoordinates(p, q, neighbours, fault, side, angle)


def _fans(lattice: Neighbours, count: int) -> dict[int, list[int]]:
    # The neighbours of each in the order of its triangles: a closed ring of an inner point; of one
    # on the border from one end to the other. None of points where the border touches itself.
    following: list[dict[int, int]] = [{} for _ in range(count)]
    for a, b, c in lattice.triangles.tolist():
        following[a][b], following[b][c], following[c][a] = c, a, b
    fans = {}
    for i, after in enumerate(following):
        starts = set(after) - set(after.values())
        if not after or len(starts) > 1:
            continue
        fan = [min(starts or after)]
        while fan[-1] in after and len(fan) <= len(after):
            fan.append(after[fan[-1]])
        if not starts and fan[-1] == fan[0]:
            fan.pop()
        if len(fan) == len(set(after) | set(after.values())) <= 6:
            fans[i] = fan
    return fans


def _is_hexagonal(lattice: Neighbours, positions: Floats, members: Ints, degree: Ints) -> bool:
    inner = members[~lattice.border[members]]
    if len(inner) == 0 or np.mean(degree[inner] == 6) < _LEAST_SIX:
        return False
    # Edges between two triangles, against the line between the corners opposite.
    triangles = lattice.triangles[np.isin(lattice.triangles[:, 0], members)]
    edges = np.sort(triangles[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
    order = np.lexsort(edges.T)
    edges, opposite = edges[order], triangles.reshape(-1)[order]
    twice = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    along = np.linalg.norm(positions[edges[twice, 0]] - positions[edges[twice, 1]], axis=1)
    across = np.linalg.norm(positions[opposite[twice]] - positions[opposite[twice + 1]], axis=1)
    return bool(np.mean(np.abs(across / along - 1) < _SQUARE_WITHIN) < _MOST_SQUARE)


def _neighbours(rings: dict[int, list[int]], inner: set[int], seed: int, count: int) -> Ints:
    # Breadth first from the seed: assigns the six neighbours of each by direction.
    found = np.full((count, 6), -1, np.int64)
    found[seed] = rings[seed]
    queue, done = deque([seed]), {seed}
    while queue:
        i = queue.popleft()
        for d, j in enumerate(found[i].tolist()):
            if j in done or j not in rings:
                continue
            ring = rings[j]
            back = ring.index(i)
            for k, other in enumerate(ring):
                found[j, (d + 3 + k - back) % 6] = other
            done.add(j)
            if j in inner:
                queue.append(j)
    # What does not agree both ways lies across a fault.
    rows, columns = np.nonzero(found >= 0)
    agrees = found[found[rows, columns], (columns + 3) % 6] == rows
    found[rows[~agrees], columns[~agrees]] = -1
    return found


def _turned(neighbours: Ints, axis: Floats, members: Ints, side: int) -> tuple[Ints, Floats]:
    # Columns turned until the first is the one that is to be v; where each leads on average.
    x, y, z = axis[members].T
    front = -side * np.stack([-z, np.zeros(len(x)), x], axis=1)
    front /= np.maximum(np.linalg.norm(front, axis=1, keepdims=True), 1e-12)
    dorsal = np.array([0.0, 1.0, 0.0]) - y[:, None] * axis[members]
    dorsal /= np.maximum(np.linalg.norm(dorsal, axis=1, keepdims=True), 1e-12)
    own = neighbours[members]
    step = axis[own] - axis[members][:, None]
    level = np.einsum("nkc,nc->nk", step, front)
    up = np.einsum("nkc,nc->nk", step, dorsal)
    size = np.hypot(level, up)
    near_horizon = np.abs(np.arcsin(np.clip(y, -1, 1))) < _POLE_RAD
    if not near_horizon.any():
        near_horizon[:] = True
    counts = (own >= 0) & (size > 0) & near_horizon[:, None]
    weight = np.where(counts, 1 / np.where(size > 0, size, 1), 0.0)
    angle = np.arctan2((level * weight).sum(axis=0), (up * weight).sum(axis=0))
    off = np.abs((angle - _FIRST_RAD + np.pi) % (2 * np.pi) - np.pi)
    first = int(np.argmin(off))
    return np.roll(own, -first, axis=1), np.roll(angle, -first)


def _counted(neighbours: Ints, seed: int, count: int) -> Ints:
    # p and q (2, N), each pair once.
    found = np.full((count, 2), NO_COORDINATE, np.int64)
    found[seed] = 0
    taken, queue = {(0, 0)}, deque([seed])
    steps = _STEPS.tolist()
    while queue:
        i = queue.popleft()
        p, q = found[i].tolist()
        for j, (more_p, more_q) in zip(neighbours[i].tolist(), steps):
            coordinate = (p + more_p, q + more_q)
            if j >= 0 and found[j, 0] == NO_COORDINATE and coordinate not in taken:
                found[j] = coordinate
                taken.add(coordinate)
                queue.append(j)
    return np.asarray(found.T)
