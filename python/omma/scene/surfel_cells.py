"""Points in the order of a grid, and how fine a grid leaves how many of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Along each axis, so that three numbers are a key of 63 bits.
_BITS = 21
# Points of which all are counted; of more, those in a sixteenth of the coarse cells.
_COUNTED = 10_000_000
_COARSE_BITS = 6


def in_cells(positions: NDArray[np.float32]) -> NDArray[np.intp]:
    """The order of the points along a Morton curve: what is near in space is near in memory, for
    the search of neighbours and for rays."""
    low = positions.min(axis=0)
    size = max(float((positions.max(axis=0) - low).max()), 1e-30)
    key = np.zeros(len(positions), np.uint64)
    for axis in range(3):
        index = (positions[:, axis] - low[axis]).astype(np.float64) * ((1 << _BITS) - 1) / size
        key |= _spread(index.astype(np.uint64)) << np.uint64(axis)
    return np.argsort(key, kind="stable")


def _spread(bits: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Two zeros after each of 21 bits."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
    return bits


def fitting_voxel_m(positions: NDArray[np.float32], fit: int) -> float:
    """A side of cells of which at most so many hold points."""
    low = positions.min(axis=0).astype(np.float64)
    size = max(float((positions.max(axis=0) - low).max()), 1e-9)
    side: float = size / max(fit, 1) ** 0.5 / 4
    while _cells(positions, low, max(side, size / (1 << (_BITS - 1)))) > fit and side < size:
        side *= 1.25
    return side


def _cells(positions: NDArray[np.float32], low: NDArray[np.float64], side: float) -> int:
    """How many cells hold points, roughly where there are many."""
    index = ((positions - low) / side).astype(np.int64)
    times = 1
    if len(positions) > _COUNTED:
        times = 16
        coarse = index >> _COARSE_BITS
        index = index[(coarse @ np.array([73856093, 19349663, 83492791])) % times == 0]
    key = (index[:, 0] << (2 * _BITS)) | (index[:, 1] << _BITS) | index[:, 2]
    return times * len(np.unique(key))
