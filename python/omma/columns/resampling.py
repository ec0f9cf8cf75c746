"""Responses of an eye's ommatidia brought onto columns, with weights that the caller can read."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, one_of, positive
from omma.base.arrays import Floats, Ints
from omma.base.directions import angle_of_chord, normalized
from omma.base.slips import warn_of_slip
from omma.columns.lattice import Columns, expect_columns

# Beyond twice the full width at half maximum a Gaussian is below 2e-5.
_CUT = 2.0
_AROUND = 6  # neighbours whose mean distance says how large an ommatidium's share of the field is


@checked
def resampling_matrix(
    eye: Eye,
    columns: Columns,
    weights: Literal["gaussian", "nearest"] = "gaussian",
    *,
    width_rad: float | None = None,
    reach_rad: float | None = None,
) -> csr_array:
    """The weights with which an eye's ommatidia make up what columns see; each row sums to 1.

    ``gaussian``: w ∝ Ω exp(-4 ln2 (θ/width)²), θ the angle between the column and the ommatidium,
    cut off at twice the width; Ω, the ommatidium's share of the field, is the mean square of its
    angles to its six nearest neighbours, so that where ommatidia are dense they do not count more.
    It widens what is seen: ommatidia of acceptance angle Δρ make columns of √(Δρ² + width²).
    ``nearest``: the ommatidium nearest to the column, alone.

    Where the eye is two eyes, columns are made up of ommatidia of their own side.

    Args:
        width_rad: full width at half maximum of the Gaussian; None: the eye's median acceptance
            angle.
        reach_rad: how far a column may look from the nearest ommatidium; None: twice the median
            angle between an ommatidium and the nearest other.

    Returns:
        (M, N) sparse (`scipy.sparse.csr_array`), for `resample`.

    Raises:
        omma.Error: columns that look where the eye does not (`seen_by` says which), an argument out
            of its range, another word for ``weights``.

    Warns:
        UserWarning: a width above 60° or below 0.02°, mostly degrees.
    """
    expect_columns(columns)
    one_of(weights, ("gaussian", "nearest"), "weights")
    axes = normalized(np.asarray(eye.axis, np.float64))
    reach = _reach(axes, reach_rad)
    width = _width(eye, width_rad) if weights == "gaussian" else 0.0
    rows, indices, values = [], [], []
    for members, served in _groups(eye, columns):
        tree, share = _tree(axes[members])
        angle, nearest = _nearest(tree, columns.axis[served])
        far = served[angle > reach]
        if len(far):
            raise Error(
                f"columns: {len(far)} of {len(columns)} look further than "
                f"{math.degrees(reach):.1f}° from any ommatidium, the first p = "
                f"{columns.p[far[0]]}, q = {columns.q[far[0]]} (omma.columns.seen_by)"
            )
        near = [[k] for k in nearest.tolist()]
        if weights == "gaussian":
            within = tree.query_ball_point(columns.axis[served], _chord(_CUT * width))
            # Where the Gaussian is narrower than the lattice, the nearest is all there is.
            near = [sorted(some) or one for some, one in zip(within, near, strict=True)]
        for row, some in zip(served.tolist(), near, strict=True):
            here = np.array(some)
            weight = np.ones(len(here))
            if weights == "gaussian" and len(here) > 1:
                beside = axes[members[here]] - columns.axis[row]
                apart = angle_of_chord(np.linalg.norm(beside, axis=1))
                exponent = -4 * math.log(2) * (apart / width) ** 2
                weight = share[here] * np.exp(exponent - exponent.max())
            rows.append(np.full(len(here), row))
            indices.append(members[here])
            values.append(weight / weight.sum())
    return _sparse(rows, indices, values, (len(columns), len(axes)))


@checked
def resample(responses: ArrayLike, matrix: csr_array) -> Floats:
    """Responses (..., N, C) of an eye as those of columns (..., M, C), by `resampling_matrix`.

    Raises:
        omma.Error: another number of ommatidia.
    """
    if len(getattr(matrix, "shape", ())) != 2 or not hasattr(matrix, "__matmul__"):
        raise TypeError(f"matrix: expected one of resampling_matrix, found {matrix!r:.40}")
    count = matrix.shape[1]
    given = array_of(responses, "responses", (..., count, "C"), dtype=None)
    moved = np.moveaxis(given, -2, 0)
    made = matrix @ moved.reshape(count, -1).astype(np.float64)
    return np.moveaxis(np.asarray(made).reshape(-1, *moved.shape[1:]), 0, -2)


@checked
def seen_by(eye: Eye, columns: Columns, reach_rad: float | None = None) -> NDArray[np.bool_]:
    """Which columns look where the eye does: (M,), for `Columns.chosen`.

    Args:
        reach_rad: as of `resampling_matrix`.
    """
    expect_columns(columns)
    axes = normalized(np.asarray(eye.axis, np.float64))
    reach = _reach(axes, reach_rad)
    found = np.zeros(len(columns), bool)
    for members, served in _groups(eye, columns):
        angle, _ = _nearest(_tree(axes[members])[0], columns.axis[served])
        found[served] = angle <= reach
    return found


def _groups(eye: Eye, columns: Columns) -> list[tuple[Ints, Ints]]:
    """Which ommatidia make up which columns."""
    which = np.unique(eye.eye_id)
    everybody = np.arange(len(eye)), np.arange(len(columns))
    if len(which) == 1:
        return [everybody]
    right = np.zeros(len(eye), bool)
    for one in which:
        members = eye.eye_id == one
        right[members] = eye.axis[members, 0].mean() >= 0
    found = []
    for is_right in (False, True):
        members = np.flatnonzero(right == is_right)
        served = np.flatnonzero((columns.side > 0) == is_right)
        if len(served) and not len(members):
            raise Error("eye: expected ommatidia on both sides, found them on one")
        if len(served):
            found.append((members, served))
    return found


def _reach(axes: Floats, given: float | None) -> float:
    if given is not None:
        return positive(given, "reach_rad")
    if len(axes) < 2:
        raise Error("reach_rad: expected a number, as the eye has but one ommatidium")
    from scipy.spatial import cKDTree

    return float(2 * np.median(angle_of_chord(cKDTree(axes).query(axes, 2)[0][:, 1])))


def _width(eye: Eye, given: float | None) -> float:
    if given is not None:
        warn_of_slip("acceptance angle", positive(given, "width_rad"), "width_rad")
        return given
    median = float(np.median(eye.acceptance_angle_rad))
    if median <= 0:
        raise Error("width_rad: expected a number, as the eye's acceptance angles are 0")
    return median


def _tree(axes: Floats):  # type: ignore[no-untyped-def]  # SciPy has no types of its own
    """For searches among these directions, and the share of the field that each has."""
    from scipy.spatial import cKDTree

    tree = cKDTree(axes)
    if len(axes) == 1:
        return tree, np.ones(1)
    apart = np.atleast_2d(tree.query(axes, min(_AROUND, len(axes) - 1) + 1)[0])[:, 1:]
    return tree, np.square(angle_of_chord(apart)).mean(axis=1)


def _nearest(tree, axes: Floats) -> tuple[Floats, Ints]:  # type: ignore[no-untyped-def]
    chord, index = tree.query(axes)
    return angle_of_chord(chord), index


def _chord(angle_rad: float) -> float:
    return 2 * math.sin(min(angle_rad, math.pi) / 2)


def _sparse(
    rows: list[Ints], indices: list[Ints], values: list[Floats], shape: tuple[int, int]
) -> csr_array:
    if not rows:
        return csr_array(shape)
    at = np.concatenate(rows), np.concatenate(indices)
    return csr_array((np.concatenate(values), at), shape=shape)
