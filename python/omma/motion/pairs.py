"""Which ommatidia a motion detector compares, and in which direction they lie from each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from omma._core import Error, Eye
from omma.base.arguments import checked, one_of
from omma.base.arrays import Floats, Ints
from omma.base.directions import normalized
from omma.eye.hexagonal import DIRECTIONS, hexagonal_coordinates


@checked
def neighbour_pairs(
    eye: Eye,
    rows: Sequence[str] = ("v", "q", "-p"),
    *,
    by: Literal["surface", "direction"] = "surface",
) -> Ints:
    """Neighbours along rows of the eye's hexagonal lattice, as ordered pairs (E, 2).

    Each pair goes from an ommatidium to the one next to it in the direction of the row, row after
    row. The default three are each pair of neighbours once: in an eye of vertical rows towards
    dorsal, dorsal and front, ventral and front.

    Args:
        rows: of `omma.eye.hexagonal.DIRECTIONS`.
        by: whose lattice, see `omma.eye.hexagonal_coordinates`.

    Example:
        >>> eye = omma.eye.generate_eye(200)
        >>> pairs = omma.motion.neighbour_pairs(eye, ["q", "-p"])
        >>> pairs.shape[1]
        2

    Raises:
        omma.Error: another word for a row or for ``by``; an eye without a hexagonal lattice.
    """
    if isinstance(rows, str) or not isinstance(rows, Sequence) or not rows:
        raise Error(f"rows: expected some of {', '.join(DIRECTIONS)}, found {rows!r:.40}")
    columns = [DIRECTIONS.index(one_of(row, DIRECTIONS, "rows")) for row in rows]
    neighbours = hexagonal_coordinates(eye, by).neighbours
    found = []
    for column in columns:
        first = np.flatnonzero(neighbours[:, column] >= 0)
        found.append(np.stack([first, neighbours[first, column]], axis=1))
    pairs = np.concatenate(found).astype(np.int64)
    if len(pairs) == 0:
        raise Error(
            f"eye: its lattice by {by} has no rows in these directions; expected a hexagonal "
            "lattice, or pairs that are given"
        )
    return pairs


def displacements_rad(eye: Eye, pairs: Ints) -> Floats:
    """Where the two of each pair look from each other: (E, 2, 2), rad.

    [:, 0] is the axis of the second in the frame of the first, right and up along the great circle
    between them; [:, 1] that of the first in the frame of the second.
    """
    axis, right, up = (
        normalized(np.asarray(vectors, np.float64)) for vectors in (eye.axis, eye.right, eye.up)
    )
    found = np.empty((len(pairs), 2, 2))
    for k, (here, there) in enumerate((pairs.T, pairs.T[::-1])):
        angle = np.arctan2(
            np.linalg.norm(np.cross(axis[here], axis[there]), axis=1),
            np.sum(axis[here] * axis[there], axis=1),
        )
        across = np.stack(
            [np.sum(axis[there] * frame[here], axis=1) for frame in (right, up)], axis=1
        )
        length = np.hypot(*across.T)
        found[:, k] = across * (angle / np.where(length > 0, length, 1))[:, None]
    return found
