"""What an eye sees and what it does not: visual field, binocular overlap, blind zones.

A direction is in the field of an eye where it lies in a triangle of the lattice of its axes, or
within half the local interommatidial angle of an axis: so each ommatidium brings its own cell, and
those at the border end half a cell out. Acceptance angles play no part in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Flags, Floats
from omma.base.directions import angle_of_chord, azimuth_elevation_deg_of, normalized
from omma.base.spirals import fibonacci_lattice, golden_angles
from omma.base.values import value_class
from omma.eye.neighbours import Neighbours

# Directions that the sphere is asked in: 0.57° apart, each 0.1 msr.
_DIRECTIONS = 1 << 17
#: What no ommatidium sees is a gap between neighbours only where it is smaller than a cell, and
#: than 1 % of the sphere: cells of a few ommatidia are as large as continents.
MOST_GAP_SR = 0.01 * 4 * np.pi


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class BlindZone:
    """A connected region that no eye sees.

    ``azimuth_deg`` and ``elevation_deg`` are of the middle of the widest cone that fits into it,
    ``radius_deg`` is half the width of that cone.
    """

    solid_angle_sr: float
    azimuth_deg: float
    elevation_deg: float
    radius_deg: float


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Field:
    """Solid angles, sr: of each eye's field (by eye id), of what any eye sees, of what at least two
    see, of what none sees; and the regions of that, the largest first. ``blind_sr`` has those too
    that are too small to be listed."""

    eyes_sr: dict[int, float]
    seen_sr: float
    binocular_sr: float
    blind_sr: float
    blind_zones: tuple[BlindZone, ...]


def field_of_view(
    axis: Floats, eye_id: NDArray[np.int32], lattice: Neighbours, spacing_rad: Floats
) -> Field:
    """The field of the axes (N, 3) with that lattice and local interommatidial angle (N,), rad.

    Directions are tried 0.57° apart; solid angles are within about 0.2 % of the sphere's 4π. Blind
    regions of less than the largest ommatidial cell (of which more than 1 % of the sphere does not
    count), or than 1 msr, are not listed.
    """
    directions = sphere_directions(_DIRECTIONS)
    each = 4 * np.pi / len(directions)
    times = np.zeros(len(directions), np.int64)
    eyes = {}
    for which in np.unique(eye_id).tolist():
        seen = in_field(directions, axis, eye_id, which, lattice, spacing_rad)
        eyes[which] = float(seen.sum() * each)
        times += seen
    cell = float(np.nanmax(spacing_rad, initial=0.0)) ** 2 * np.sqrt(3) / 2
    blind = times == 0
    return Field(
        eyes_sr=eyes,
        seen_sr=float((times > 0).sum() * each),
        binocular_sr=float((times > 1).sum() * each),
        blind_sr=float(blind.sum() * each),
        blind_zones=_zones(directions, blind, each, min(max(cell, 1e-3), MOST_GAP_SR)),
    )


def in_field(
    directions: Floats,
    axis: Floats,
    eye_id: NDArray[np.int32],
    which: int,
    lattice: Neighbours,
    spacing_rad: Floats,
) -> Flags:
    """Whether directions (K, 3) are in the field of the eye ``which``: (K,)."""
    from scipy.spatial import cKDTree

    members = np.flatnonzero(eye_id == which)
    own = normalized(axis[members])
    near = min(3, len(members))
    distance, index = cKDTree(own).query(directions, k=near)
    distance, index = distance.reshape(-1, near), index.reshape(-1, near)
    half = np.nan_to_num(spacing_rad[members]) / 2
    angle = angle_of_chord(distance[:, 0])
    seen = np.asarray(angle <= half[index[:, 0]])
    corners, count = _triangles_at(lattice, len(axis))
    vertices = normalized(axis)
    ends = vertices[lattice.triangles]
    reach = np.linalg.norm(ends - np.roll(ends, 1, axis=1), axis=2).max(initial=0.0)
    hopeless = distance[:, 0] > reach  # further from all corners than any triangle is long
    # In a flat triangle the nearest axis may be none of its corners, but one of the next is.
    for k in range(near):
        at = lattice.first[members[index[:, k]]]
        for slot in range(corners.shape[1]):
            open_ = np.flatnonzero(~seen & ~hopeless & (count[at] > slot))
            if len(open_) == 0:
                break
            a, b, c = vertices[corners[at[open_], slot]].transpose(1, 0, 2)
            p = directions[open_]
            inside = np.ones(len(open_), bool)
            for one, other in ((a, b), (b, c), (c, a)):
                inside &= np.sum(np.cross(one, other) * p, axis=1) >= -1e-12
            seen[open_] = inside
    return seen


def sphere_directions(count: int) -> Floats:
    """``count`` directions spread evenly over the sphere, each for the same solid angle: the
    Fibonacci lattice, from the top down, beginning ahead."""
    behind, right, up = fibonacci_lattice(golden_angles(count)).T
    return np.column_stack([right, up, -behind])


def _triangles_at(lattice: Neighbours, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    # The triangles at each point, (N, most at one, 3), and how many there are.
    flat = lattice.triangles.ravel()
    order = np.argsort(flat, kind="stable")
    number = np.bincount(flat, minlength=count)
    start = np.concatenate([[0], np.cumsum(number)[:-1]])
    most = int(number.max(initial=0))
    table = np.zeros((count, most, 3), np.int64)
    slot = np.arange(len(flat)) - start[flat[order]]
    table[flat[order], slot] = lattice.triangles[order // 3]
    return table, number


def _zones(directions: Floats, blind: Flags, each: float, least_sr: float) -> tuple[BlindZone, ...]:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not blind.any():
        return ()
    step = np.sqrt(each)
    tree = cKDTree(directions)
    near = tree.query(directions, k=7)[1][:, 1:]
    one, other = np.repeat(np.arange(len(near)), near.shape[1]), near.ravel()
    inner = blind[one] & blind[other]
    graph = coo_matrix(
        (np.ones(int(inner.sum())), (one[inner], other[inner])), shape=(len(near),) * 2
    )
    _, label = connected_components(graph, directed=False)
    number, count = np.unique(label[blind], return_counts=True)
    rim = directions[np.unique(other[blind[one] & ~blind[other]])]
    zones = []
    for zone, many in zip(number.tolist(), count.tolist(), strict=True):
        if many * each < least_sr:
            continue
        inside = directions[label == zone]
        direction, radius = _widest_cone(inside, rim, step)
        azimuth, elevation = azimuth_elevation_deg_of(direction)
        zones.append(
            BlindZone(many * each, float(azimuth), float(elevation), float(np.degrees(radius)))
        )
    return tuple(sorted(zones, key=lambda zone: -zone.solid_angle_sr))


def _widest_cone(inside: Floats, rim: Floats, step: float) -> tuple[Floats, float]:
    """The direction furthest from the rim, and how far it is from the border, rad."""
    from scipy.spatial import cKDTree

    if len(rim) == 0:
        return inside[0], float(np.pi)
    tree = cKDTree(rim)
    # All points of a rim are about as far from the middle, which makes the search slow: first every
    # 16th, about four steps apart, then those near the best.
    some = inside[::16]
    distance = tree.query(some)[0]
    good = some[distance >= distance.max() - 8 * step]
    close = cKDTree(good).query(inside, distance_upper_bound=8 * step)[0] < np.inf
    fine = inside[close]
    distance = tree.query(fine)[0]
    best = int(distance.argmax())
    # The border is between the last direction that is seen and the first that is not.
    radius = float(angle_of_chord(distance[best])) - step / 2
    return fine[best], float(max(radius, 0.0))
