"""Arrays of NumPy, by what they hold."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

_ALIGNMENT_BYTES = 64


def new_floats(shape: tuple[int, ...]) -> Floats32:
    """An array of single precision to write to, which begins at a multiple of 64 bytes: JAX copies
    all others that it is handed over."""
    count = math.prod(shape)
    whole = np.empty(count + _ALIGNMENT_BYTES // 4, np.float32)
    first = -whole.__array_interface__["data"][0] % _ALIGNMENT_BYTES // 4
    return whole[first : first + count].reshape(shape)
