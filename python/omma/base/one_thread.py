"""Products of matrices on one thread. The library behind NumPy starts all its threads for large
ones, which wait for each other in loops: on a machine with other work that takes many times as long
as one thread does, and takes the processor from that work.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# OpenBLAS takes one thread up to so many multiplications (4 x 65,536: its interface/gemm.c).
_MOST_MULTIPLICATIONS = 1 << 18


def product(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """``a @ b`` of (..., K) and (K, N), in pieces that take one thread each."""
    rows, columns = a.reshape(-1, a.shape[-1]), b.shape[1]
    out = np.empty((len(rows), columns), np.result_type(a, b))
    step = max(1, _MOST_MULTIPLICATIONS // max(1, b.size))
    for first in range(0, len(rows), step):
        np.matmul(rows[first : first + step], b, out=out[first : first + step])
    return out.reshape(*a.shape[:-1], columns)
