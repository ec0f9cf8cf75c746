"""Columns as a value: which they are, of which eye, and where they look."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, expect
from omma.base.arrays import Floats, Ints
from omma.base.values import value_class


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Columns:
    """M medulla columns with their viewing directions; no two of an eye have the same (p, q).

    Attributes:
        p, q: (M,), hexagonal coordinates: in the eye of a fly +p leads dorsal and to the back, +q
            dorsal and to the front, p + q dorsal; the six next to a column are one step along p, q
            or both together away. Left and right eyes are mirror images.
        side: (M,), -1 in the left eye, 1 in the right one.
        axis: (M, 3), directions in the head's frame: +X right, +Y up, -Z ahead.
        taken_from: for each quantity what it was called in the file that they are from.
    """

    p: Ints
    q: Ints
    side: Ints
    axis: Floats
    taken_from: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        axis = array_of(self.axis, "axis", (None, 3))
        for name in ("p", "q", "side"):
            values = array_of(getattr(self, name), name, (len(axis),), np.int64)
            object.__setattr__(self, name, values)
        if not np.isin(self.side, (-1, 1)).all():
            raise Error("side: expected -1 (left) or 1 (right)")
        length = np.linalg.norm(axis, axis=1)
        wrong = np.flatnonzero(~(np.isfinite(length) & (length > 0)))
        if len(wrong):
            raise Error(
                f"axis: expected directions, found {axis[wrong[0]].tolist()} in row {wrong[0]}"
            )
        object.__setattr__(self, "axis", axis / length[:, None])
        twice = self._twice()
        if twice is not None:
            first, second = twice
            raise Error(
                f"p, q: expected each column of an eye once, found p = {self.p[first]}, q = "
                f"{self.q[first]} in rows {first} and {second}"
            )

    def __len__(self) -> int:
        """How many columns there are."""
        return len(self.axis)

    def chosen(self, which: ArrayLike) -> Columns:
        """Those of a mask (M,) bool, or of indices."""
        index = np.asarray(which)
        if index.dtype == bool and index.shape != (len(self),):
            raise Error(f"which: expected shape ({len(self)},), found {index.shape}")
        if index.dtype != bool:
            index = array_of(index, "which", (None,), np.int64)
            if len(index) and not (0 <= index.min() and index.max() < len(self)):
                raise Error(f"which: expected indices from 0 to {len(self) - 1}")
        return Columns(
            self.p[index], self.q[index], self.side[index], self.axis[index], self.taken_from
        )

    def _twice(self) -> tuple[int, int] | None:
        # Two rows of the same column.
        key = np.stack([self.side, self.p, self.q], axis=1)
        order = np.lexsort(key.T)
        same = np.flatnonzero((key[order][1:] == key[order][:-1]).all(axis=1))
        return None if len(same) == 0 else (int(order[same[0]]), int(order[same[0] + 1]))


def expect_columns(columns: object) -> None:
    """TypeError where they are none."""
    expect(columns, Columns, "columns", "omma.columns.load_columns gives some")
