"""Ommatidia that differ from those around them, and in what."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Flags, Floats, Ints
from omma.base.directions import angle_of_chord, normalized
from omma.base.values import value_class
from omma.eye.doubles import doubles
from omma.eye.neighbours import Neighbours, direction_lattice, surface_lattice
from omma.eye.skew import angle_between

# An ommatidium differs from its neighbours where it is this many robust standard deviations above
# the median of its kind. Of a normal distribution one in 10^15 would be.
_OUTLIER_SD = 8.0
# And where it is over these: of |ln(Δφ / that around)|, of angles and of spacings between
# neighbours.
_FLOORS = {"spacing": float(np.log(2)), "axis": 1.5, "position": 1.5}


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Surroundings:
    """The lattices of N ommatidia by axis and by position, and how far neighbours are apart.

    double_of: of which each is a double (`doubles`), -1 where of none: (N,).
    spacing: the mean angle to the neighbours in direction: (N,), NaN where there are none.
    on_surface, facet_spacing: the mean angle and distance to the neighbours on the surface.
    angles, lengths: of each pair of neighbours in direction and on the surface.
    """

    double_of: Ints
    directions: Neighbours
    surface: Neighbours
    angles: Floats
    lengths: Floats
    spacing: Floats
    on_surface: Floats
    facet_spacing: Floats


def surroundings(position: Floats, axis: Floats, eye_id: NDArray[np.int32]) -> Surroundings:
    """What lies around ommatidia at ``position`` (N, 3) that look along ``axis`` (N, 3), each
    eye's for itself."""
    double_of = doubles(position, axis, eye_id)
    directions = direction_lattice(axis, eye_id, double_of)
    surface = surface_lattice(position, eye_id, double_of)
    angles = angle_of_chord(_pair_lengths(axis, directions.pairs))
    lengths = _pair_lengths(position, surface.pairs)
    return Surroundings(
        double_of,
        directions,
        surface,
        angles,
        lengths,
        directions.mean_over_pairs(angles),
        surface.mean_over_pairs(angle_of_chord(_pair_lengths(axis, surface.pairs))),
        surface.mean_over_pairs(lengths),
    )


def outliers(
    position: Floats, axis: Floats, eye_id: NDArray[np.int32], around: Surroundings
) -> NDArray[np.str_]:
    """In what each differs from its neighbours: (N,), "", or "spacing", "axis" or "position", or
    several joined by "+". `omma.eye.measure_eye` has the rule."""
    found = _differing(position, axis, eye_id, around)
    _leave_what_is_out_of_place(found, position, axis, eye_id, around)
    cause = found["axis"] | found["position"]
    rest = np.flatnonzero(~cause)
    if cause.any() and len(rest):
        # Those near a wrong one seem to differ as well: what counts is what they are without it.
        without = (position[rest], axis[rest], eye_id[rest])
        again = _differing(*without, surroundings(*without))
        for name, which in again.items():
            found[name][rest] &= which
    reasons = np.full(len(axis), "", dtype="<U24")
    for name, which in found.items():
        for i in np.flatnonzero(which):
            reasons[i] = f"{reasons[i]}+{name}" if reasons[i] else name
    return reasons


def angle_or_nan(vectors: Floats, directions: Floats) -> Floats:
    """The angle between ``vectors`` and unit ``directions``; NaN where a vector is zero."""
    # The lengths are metres, so that rounding leaves less than 1e-12.
    length = np.linalg.norm(vectors, axis=1)
    return np.where(length > 1e-12, angle_between(vectors, directions), np.nan)


def _differing(
    position: Floats, axis: Floats, eye_id: NDArray[np.int32], around: Surroundings
) -> dict[str, Flags]:
    directions, surface = around.directions, around.surface
    usual = _median_over_neighbours(around.spacing, directions)
    # On a stretched surface those beside an ommatidium look farther apart than the nearest axes do.
    beside = _median_over_neighbours(around.on_surface, surface)
    facets = _median_over_neighbours(around.facet_spacing, surface)
    for which in np.unique(eye_id):
        # One that is off the surface has no neighbours on it.
        off = (eye_id == which) & np.isnan(facets)
        known = facets[(eye_id == which) & ~off]
        facets[off] = np.median(known) if len(known) else np.nan
    # One without neighbours is infinitely far from them.
    alone = np.isnan(around.spacing)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = {
            "spacing": np.where(alone, np.inf, np.abs(np.log(around.spacing / usual))),
            "axis": angle_or_nan(surface.mean_over_neighbours(axis), axis) / beside,
            "position": np.linalg.norm(position - directions.mean_over_neighbours(position), axis=1)
            / facets,
        }
    found = {name: np.zeros(len(axis), bool) for name in values}
    for name, value in values.items():
        for which in np.unique(eye_id):
            members = np.flatnonzero((eye_id == which) & ~np.isnan(value))
            if np.isfinite(value[members]).sum() < 8:
                continue
            middle = np.median(value[members])
            sd = 1.4826 * np.median(np.abs(value[members] - middle))
            found[name][members] = value[members] > max(middle + _OUTLIER_SD * sd, _FLOORS[name])
    return found


def _leave_what_is_out_of_place(
    found: dict[str, Flags],
    position: Floats,
    axis: Floats,
    eye_id: NDArray[np.int32],
    around: Surroundings,
) -> None:
    """Of those whose axis and position do not go together, leave the one that is out of place.

    Where an axis is wrong, nobody looks where it should, by those beside it on the surface; and
    where it should sit, by those that look beside it, others sit. Where a position is wrong, it is
    the other way round.
    """
    both = np.flatnonzero(found["axis"] & found["position"])
    should_look = normalized(around.surface.mean_over_neighbours(axis)[both])
    should_sit = around.directions.mean_over_neighbours(position)[both]
    usual_angle = _usual_nearest(around.angles, around.directions)
    usual_length = _usual_nearest(around.lengths, around.surface)
    for which in np.unique(eye_id[both]):
        eye = np.flatnonzero(eye_id == which)
        mine = np.flatnonzero(eye_id[both] == which)
        without_axis = _room(should_look[mine], both[mine], axis, eye, usual_angle)
        without_place = _room(should_sit[mine], both[mine], position, eye, usual_length)
        found["position"][both[mine[without_axis > without_place]]] = False
        found["axis"][both[mine[without_place > without_axis]]] = False


def _room(expected: Floats, ones: Ints, points: Floats, eye: Ints, usual: Floats) -> Floats:
    """How far from where each of ``ones`` is ``expected`` the nearest other of its eye is, over
    what is usual there."""
    from scipy.spatial import cKDTree

    distance, index = cKDTree(points[eye]).query(expected, 2)
    other = np.where(eye[index[:, 0]] == ones, 1, 0)[:, None]
    nearest = eye[np.take_along_axis(index, other, 1)[:, 0]]
    return np.asarray(np.take_along_axis(distance, other, 1)[:, 0] / usual[nearest])


def _usual_nearest(distances: Floats, lattice: Neighbours) -> Floats:
    """The median over neighbours of the distance to the nearest one: (N,)."""
    nearest = np.full(len(lattice.border), np.inf)
    for end in lattice.pairs.T:
        np.minimum.at(nearest, end, distances)
    return _median_over_neighbours(nearest, lattice)


def _pair_lengths(points: Floats, pairs: Ints) -> Floats:
    return np.asarray(np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1))


def _median_over_neighbours(values: Floats, lattice: Neighbours) -> Floats:
    both = np.concatenate([lattice.pairs, lattice.pairs[:, ::-1]])
    order = np.lexsort((values[both[:, 1]], both[:, 0]))
    sorted_values = values[both[order, 1]]
    count = np.bincount(both[:, 0], minlength=len(values))
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    some = count > 0
    low, high = start + (count - 1) // 2, start + count // 2
    median = np.full(len(values), np.nan)
    median[some] = (sorted_values[low[some]] + sorted_values[high[some]]) / 2
    return np.asarray(median[lattice.first])
