"""Rows of an array that a caller chooses: by number, by several numbers, or by a mask."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.arguments import array_of


def is_one(value: Any) -> bool:
    """Whether it is a single thing, no list or array of several."""
    several = hasattr(value, "__len__") and not isinstance(value, (str, bytes))
    return not several or getattr(value, "ndim", 1) == 0


def row_of(value: Any, name: str, count: int) -> int:
    """One of ``count`` rows; below 0 from the end.

    Raises:
        TypeError: no whole number, as True and False are none here.
        IndexError: there is no such row.
    """
    try:
        if isinstance(value, (bool, np.bool_)):  # which Python takes for 0 and 1
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise TypeError(
            f"{name}: expected a whole number, indices or a mask ({count},), found "
            f"{type(value).__name__} {value!r:.40}"
        ) from None
    if not -count <= number < count:
        raise IndexError(f"{name}: expected {-count} to {count - 1}, found {number}")
    return number % count


def rows_of(value: Any, name: str, count: int) -> NDArray[np.int64]:
    """Those of ``count`` rows that indices name, in their order, below 0 from the end; or those of
    a mask (count,) that are True.

    Raises:
        omma.Error: a mask of another length, fractions, texts, another shape.
        IndexError: there is no such row.
    """
    given = array_of(value, name, (None,), dtype=None)
    if given.dtype == bool:
        return np.flatnonzero(array_of(given, f"{name}, a mask", (count,), np.bool_))
    rows = array_of(given, name, dtype=np.int64)
    outside = np.flatnonzero((rows < -count) | (rows >= count))
    if len(outside):
        found = rows[outside[0]]
        raise IndexError(f"{name}: expected {-count} to {count - 1}, found {found}")
    return np.asarray(np.where(rows < 0, rows + count, rows), np.int64)
