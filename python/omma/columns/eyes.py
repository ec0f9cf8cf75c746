"""Columns of an eye's own ommatidia, an eye that looks where columns do, and pairs of columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import checked, one_of
from omma.base.arrays import Ints
from omma.columns.lattice import Columns, expect_columns
from omma.eye.files import warn_of_unusual
from omma.eye.hexagonal import hexagonal_coordinates

# Steps in p and q; v = p + q.
_STEPS = {"v": (1, 1), "p": (1, 0), "q": (0, 1), "-v": (-1, -1), "-p": (-1, 0), "-q": (0, -1)}


@checked
def columns_of_eye(
    eye: Eye, by: Literal["surface", "direction"] = "surface"
) -> tuple[Columns, Ints]:
    """The column of each ommatidium that has coordinates in the lattice of its eye.

    With neural superposition a column's light is that of the receptors that look the way of its
    ommatidium, so that it looks where that does.

    Args:
        by: whose lattice, see `omma.eye.hexagonal_coordinates`.

    Returns:
        (columns, ommatidium): ommatidium (M,), of which each column is.

    Example:
        >>> columns, ommatidium = omma.columns.columns_of_eye(omma.species.drosophila().eye)
        >>> len(columns) == len(ommatidium) > 1400
        True

    Raises:
        omma.Error: an eye without a hexagonal lattice, or another word for ``by``.
    """
    found = hexagonal_coordinates(eye, by)
    ommatidium = np.flatnonzero(found.known)
    if len(ommatidium) == 0:
        raise Error("eye: expected a hexagonal lattice, found none")
    axis = eye.axis[ommatidium].astype(np.float64)
    columns = Columns(found.p[ommatidium], found.q[ommatidium], found.side[ommatidium], axis)
    return columns, ommatidium


@checked
def eye_of_columns(columns: Columns, acceptance_angle_rad: ArrayLike) -> Eye:
    """An eye with one ommatidium for each column, in their order, to render where they look.

    Args:
        acceptance_angle_rad: of all, or (M,) of each.

    Raises:
        omma.Error: what `omma.Eye` refuses.
    """
    expect_columns(columns)
    nowhere = np.zeros((len(columns), 3))
    side = (columns.side > 0).astype(int)
    eye = Eye(nowhere, columns.axis, acceptance_angle_rad, eye_id=side)
    warn_of_unusual(eye)
    return eye


@checked
def column_pairs(columns: Columns, rows: Sequence[str] = ("v", "q", "-p")) -> Ints:
    """Neighbouring columns of an eye as ordered pairs (E, 2), row after row: for
    `omma.motion.detector_array`.

    Args:
        rows: directions from the first to the second: v (dorsal, p + q), p, q, -v, -p, -q.

    Raises:
        omma.Error: another word for a row, or no neighbours.
    """
    expect_columns(columns)
    if not isinstance(rows, (list, tuple)) or not rows:
        raise Error(f"rows: expected some of {', '.join(_STEPS)}, found {rows!r:.40}")
    columns_of_eye = zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist(), strict=True)
    index = {column: k for k, column in enumerate(columns_of_eye)}
    pairs = []
    for row in rows:
        more_p, more_q = _STEPS[one_of(row, _STEPS, "rows")]
        for (side, p, q), first in index.items():
            second = index.get((side, p + more_p, q + more_q))
            if second is not None:
                pairs.append((first, second))
    if not pairs:
        raise Error(f"columns: expected neighbours along {', '.join(rows)}, found none")
    return np.array(pairs, np.int64)
