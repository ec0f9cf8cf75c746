"""Lenses and tips of crystalline cones marked in a scan: which belong to which eye of the head,
which tip to which lens, and whether the axes so made point out of the head."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omma._core import Error, Eye
from omma.base.arrays import Floats, Ints
from omma.base.progress import Progress

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


# Points further apart than this many spacings are in different groups. A lattice with a few points
# missing has gaps of two or three; the eyes of flies and bees are twenty and more apart.
_APART = 4.0
# Smaller groups are no eyes but strays: marks set wrongly, or a torn-off rim.
_LEAST_POINTS, _LEAST_FRACTION = 12, 0.1

_MOST_ROUNDS = 20  # of fitting and matching; a few are usual

# Lenses and tips are swapped where more than this share of axes points into the head, and lenses
# are closer together than tips by more than marks set by hand are off.
_SWAPPED_INWARD, _SWAPPED_NARROWER = 0.9, 0.99

# The origin is off the midline by more than heads are uneven where that is over this share of the
# distance between both eyes.
_OFF_MIDLINE = 0.05


def split_eyes(lens: Floats, cone: Floats, right: Floats) -> tuple[Ints, Ints]:
    """The eye of each lens (N,) and of each tip (M,): all 0 where there is one eye; of two that lie
    apart 0 is the left one, 1 the right one.

    Args:
        right: (3,), the direction to the animal's right in the scan.

    Raises:
        omma.Error: more than two groups of points; not as many of lenses as of tips; two that do
            not lie to the left and right of each other.
    """
    lens_group, cone_group = _groups(lens), _groups(cone)
    sizes = [np.bincount(group) for group in (lens_group, cone_group)]
    if len(sizes[0]) == 1 and len(sizes[1]) == 1:
        return lens_group, cone_group
    found = " and ".join(
        f"{what} in {len(size)} ({', '.join(f'{n:,}' for n in size)})"
        for what, size in zip(("lenses", "tips"), sizes, strict=True)
    )
    if len(sizes[0]) != 2 or len(sizes[1]) != 2:
        raise Error(
            "lenses and cones: expected points of one eye, or of two that lie apart, found "
            f"{found} groups; import each eye from points of its own and join them with merge_eyes"
        )
    middles = [
        np.stack([points[group == which].mean(axis=0) for which in (0, 1)])
        for points, group in ((lens, lens_group), (cone, cone_group))
    ]
    apart = middles[0][1] - middles[0][0]
    sideways = float(apart @ right) / float(np.linalg.norm(apart))
    if abs(sideways) < np.sqrt(0.5):
        x, y, z = apart / np.linalg.norm(apart)
        raise Error(
            f"lenses and cones: found {found} groups, apart along ({x:.2f}, {y:.2f}, {z:.2f}) in "
            "the scan, and expected a left and a right eye there, but ahead and up say that the "
            f"animal's right is ({right[0]:.2f}, {right[1]:.2f}, {right[2]:.2f}); say where its "
            "front and upper side are in the scan (ahead, up), or import each group from points "
            "of its own"
        )
    order = [np.argsort(middle @ right) for middle in middles]
    return np.argsort(order[0])[lens_group], np.argsort(order[1])[cone_group]


def _groups(points: Floats) -> Ints:
    """Groups that lie apart, numbered from 0: (N,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    near = min(9, len(points))
    distance, index = tree.query(points, k=near)
    linked = distance <= _APART * np.median(distance[:, 1])
    rows = np.repeat(np.arange(len(points)), near)[linked.ravel()]
    graph = coo_array((np.ones(len(rows)), (rows, index[linked])), shape=(len(points), len(points)))
    group = connected_components(graph, directed=False)[1]
    size = np.bincount(group)
    large = np.flatnonzero(size >= max(_LEAST_POINTS, _LEAST_FRACTION * size.max()))
    if len(large) < 2:
        return np.zeros(len(points), np.int64)
    members = np.flatnonzero(np.isin(group, large))
    # A stray belongs to the group whose point is the nearest.
    nearest = members[cKDTree(points[members]).query(points)[1]]
    return np.asarray(np.searchsorted(large, group[nearest]), dtype=np.int64)


def match_tips(lens: Floats, cone: Floats, tell: Progress) -> tuple[Ints, Ints, Floats]:
    """Indices of the pairs of one eye by lens, and how far each tip is from where a smooth map of
    the lenses' positions (a polynomial of second order, fitted and matched in turn) says it should
    be.

    Lenses and tips are matched one to one with the least sum of squared distances under the map.
    ``tell`` is told the finished fraction, of the most rounds that it may take.
    """
    from scipy.spatial import cKDTree

    middle = lens.mean(axis=0)
    size = np.linalg.norm(lens - middle, axis=1).max()
    if not size > 0:
        raise Error("lenses: expected points apart from one another, found one position")
    # The first guess: the lenses' cloud shrunk and moved to that of the tips.
    shrink = np.sqrt(np.var(cone, axis=0).sum() / np.var(lens, axis=0).sum())
    predicted = (lens - middle) * shrink + cone.mean(axis=0)
    x, y, z = ((lens - middle) / size).T
    terms = np.stack([np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x], axis=1)
    tree = cKDTree(cone)
    pairs = _assign(predicted, cone, tree)
    for done in range(_MOST_ROUNDS):
        tell(done / _MOST_ROUNDS)
        which_lens, which_cone = pairs
        missed = np.linalg.norm(predicted[which_lens] - cone[which_cone], axis=1)
        good = missed <= 3 * np.median(missed) + 1e-12
        fitted = np.linalg.lstsq(terms[which_lens][good], cone[which_cone][good], rcond=None)[0]
        predicted = terms @ fitted
        before, pairs = pairs, _assign(predicted, cone, tree)
        if np.array_equal(before, pairs):
            break
    which_lens, which_cone = pairs
    return which_lens, which_cone, np.linalg.norm(predicted[which_lens] - cone[which_cone], axis=1)


def _assign(predicted: Floats, cone: Floats, tree: cKDTree) -> tuple[Ints, Ints]:
    """One to one, with the least sum of squared distances among near candidates."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import min_weight_full_bipartite_matching

    candidates = 8
    while True:
        candidates = min(candidates, len(cone))
        distance, index = tree.query(predicted, k=candidates)
        rows = np.repeat(np.arange(len(predicted)), candidates)
        # A weight of 0 would mean no edge.
        weights = np.square(distance.ravel() / (distance.max() or 1.0)) + 1e-12
        graph = csr_array((weights, (rows, index.ravel())), shape=(len(predicted), len(cone)))
        try:
            lens, matched = min_weight_full_bipartite_matching(graph)
        except ValueError:  # some have only candidates that others need
            if candidates == len(cone):
                raise
            candidates *= 4
            continue
        order = np.argsort(lens)
        return lens[order].astype(np.int64), matched[order].astype(np.int64)


def checked_outward(lens: Floats, tip: Floats, of_eye: str) -> list[str]:
    """What there is to note of axes from tips to lenses, of one eye, that point into the head.

    Raises:
        omma.Error: lenses and cones are swapped.
    """
    inward = ((lens - tip) * (sphere_centre(lens) - lens)).sum(axis=1) > 0
    # Axes that come together have lenses closer to each other than tips.
    narrower = np.sqrt(np.var(lens, axis=0).sum() / np.var(tip, axis=0).sum())
    if inward.mean() > _SWAPPED_INWARD and narrower < _SWAPPED_NARROWER:
        raise Error(
            f"lenses and cones: expected axes that point out of the head, from the cones' tips to "
            f"the lenses, found {int(inward.sum()):,} of {len(lens):,} {of_eye}that point into it, "
            f"and lenses {100 * (1 - narrower):.2g} % closer together than tips; are lenses and "
            "cones swapped?"
        )
    if not inward.any():
        return []
    return [
        f"Looks wrong: {int(inward.sum()):,} of {len(lens):,} axes {of_eye}point into the head, "
        "towards the middle of the sphere that fits the lenses. They were left as they are."
    ]


def off_the_midline(eye: Eye) -> list[str]:
    """What there is to note of both eyes of a head, 0 and 1, whose origin is that of a scan: where
    it is off their midline, or further off the middle between them than they are apart."""
    left, right = (eye.position_m[eye.eye_id == k].mean(axis=0, dtype=np.float64) for k in (0, 1))
    middle, apart = (left + right) / 2, float(np.linalg.norm(right - left))
    if abs(middle[0]) <= _OFF_MIDLINE * apart and np.linalg.norm(middle) <= apart:
        return []
    middle = np.round(middle, 9) + 0.0  # without rounding of single precision, and no -0
    x, y, z = middle * 1e3
    back = ", ".join(f"{0 - value:.4g}" for value in middle)
    return [
        f"The origin is that of the scan: the middle between both eyes is at ({x:.4g}, {y:.4g}, "
        f"{z:.4g}) mm. Skew from the head's centre is measured from the origin; "
        f"place_on_head(eye, ({back})) puts that middle there."
    ]


def sphere_centre(position: Floats) -> Floats:
    """Centre of the sphere that fits the points best in the sense of |p|^2 - r^2."""
    system = np.concatenate([2 * position, np.ones((len(position), 1))], axis=1)
    solution = np.linalg.lstsq(system, np.square(position).sum(axis=1), rcond=None)[0]
    return np.asarray(solution[:3], dtype=np.float64)
