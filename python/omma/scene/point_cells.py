"""What is kept of points while a file of them is read: all, or one for each cell of a grid."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error

Columns = dict[str, NDArray[Any]]

# Cells along each axis: three of these numbers are a key of 63 bits.
_CELLS = 1 << 21


class AllPoints:
    """All of them, in the file's order."""

    def __init__(self) -> None:
        self._pieces: list[Columns] = []

    def add(self, piece: Columns) -> None:
        self._pieces.append(piece)

    def columns(self) -> Columns:
        """Of all pieces; what one of them lacks, none has. Each piece is let go of on the way."""
        names = set.intersection(*(set(one) for one in self._pieces)) if self._pieces else set()
        return {
            name: np.concatenate([one.pop(name) for one in self._pieces]) for name in sorted(names)
        }


class CellMeans:
    """The mean of the points in each cell of a grid, of which only cells that hold some are kept.

    Colours are means of linear light, normals means of their directions, labels those of most
    points. Memory grows with the number of cells, not of points: sums of new pieces wait until they
    are as many as what has been summed up, so that each is sorted a few times only.
    """

    def __init__(self, cell_m: float) -> None:
        self._cell_m = cell_m
        self._base: NDArray[np.int64] | None = None
        self._waiting: list[Columns] = []
        self._rows = [0, 0]  # summed up, waiting

    def add(self, piece: Columns) -> None:
        index = np.floor(piece["positions"].astype(np.float64) / self._cell_m)
        if self._base is None:
            self._base = index.min(axis=0).astype(np.int64) - _CELLS // 2
        index -= self._base
        if not ((index >= 0) & (index < _CELLS)).all():
            raise Error(
                f"voxel_m: expected cells of which the points fill fewer than {_CELLS // 2:,} from "
                f"end to end, found {self._cell_m:g}"
            )
        axes = index.astype(np.int64)
        key = (axes[:, 0] * _CELLS + axes[:, 1]) * _CELLS + axes[:, 2]
        sums: Columns = {"key": key, "count": np.ones(len(key))}
        sums["label"] = piece.get("labels", np.zeros(len(key), np.int32))
        sums.update({name: one for name, one in piece.items() if name != "labels"})
        self._has_labels = "labels" in piece
        self._waiting.append(_summed(sums, by_label=True))
        self._rows[1] += len(self._waiting[-1]["key"])
        if self._rows[1] > max(self._rows[0], 1 << 20):
            self._sum_up()

    def columns(self) -> Columns:
        """Means of each cell, by the cells' order along x, y and z."""
        if not self._waiting:
            return {}
        self._sum_up()
        (sums,) = self._waiting
        self._waiting = []
        # Of each cell's labels the one with most points, of as many the lowest.
        order = np.lexsort((sums["label"], -sums["count"], sums["key"]))
        first = np.flatnonzero(np.diff(sums["key"][order], prepend=-1))
        labels = sums["label"][order[first]]
        means = _summed(sums, by_label=False)
        count = means.pop("count")
        del means["key"], means["label"]
        found = {
            name: (one / (count if one.ndim == 1 else count[:, None])).astype(np.float32)
            for name, one in means.items()
        }
        if self._has_labels:
            found["labels"] = labels
        return found

    def _sum_up(self) -> None:
        names = set.intersection(*(set(one) for one in self._waiting))
        together = {
            name: np.concatenate([one.pop(name) for one in self._waiting]) for name in names
        }
        self._waiting = [_summed(together, by_label=True)]
        self._rows = [len(self._waiting[0]["key"]), 0]


def _summed(rows: Columns, by_label: bool) -> Columns:
    """Sums of the rows with the same key, and label, ordered by these."""
    keys = (rows["label"], rows["key"]) if by_label else (rows["key"],)
    order = np.lexsort(keys) if by_label else np.argsort(rows["key"], kind="stable")
    is_new = np.zeros(len(order), bool)
    is_new[:1] = True
    for key in keys:
        ordered = key[order]
        is_new[1:] |= ordered[1:] != ordered[:-1]
    first = np.flatnonzero(is_new)
    summed: Columns = {name: rows[name][order[first]] for name in ("key", "label")}
    for name in rows.keys() - summed.keys():
        summed[name] = np.add.reduceat(rows[name][order].astype(np.float64), first, axis=0)
    return summed
