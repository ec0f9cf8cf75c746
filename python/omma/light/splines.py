"""Cubic splines as matrices, of few nodes: SciPy's takes longer to import than a sky to make."""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats


def spline_through(
    nodes: Floats, values: Floats, at: Floats, *, is_periodic: bool = False
) -> Floats:
    """Cubic splines through values (N, M) at nodes (N,), ascending, 4 or more: (K, M) at (K,).

    The third derivative goes on through the second node and the last but one; or all goes on from
    the last node to the first, where values are the same, and ``at`` is between them.
    """
    step = np.diff(nodes)
    rise = np.diff(values, axis=0) / step[:, None]
    count = len(nodes)
    # Of the second derivatives at the nodes.
    system = np.zeros((count, count))
    right = np.zeros(values.shape)
    k = np.arange(1, count - 1)
    system[k, k - 1], system[k, k + 1] = step[:-1], step[1:]
    system[k, k] = 2 * (step[:-1] + step[1:])
    right[1:-1] = 6 * np.diff(rise, axis=0)
    if is_periodic:
        system[0, [0, -1]] = 1, -1
        system[-1, [-2, -1, 0, 1]] = step[-1], 2 * step[-1], 2 * step[0], step[0]
        right[-1] = 6 * (rise[0] - rise[-1])
    else:
        for row, one, other in ((0, step[0], step[1]), (-1, step[-2], step[-1])):
            ends = slice(0, 3) if row == 0 else slice(-3, None)
            system[row, ends] = other, -(one + other), one
    bend = np.linalg.solve(system, right)
    piece = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, count - 2)
    along, width = (at - nodes[piece])[:, None], step[piece][:, None]
    low, high = bend[piece], bend[piece + 1]
    slope = rise[piece] - width * (2 * low + high) / 6
    cubic = along**3 * (high - low) / (6 * width)
    return np.asarray(values[piece] + along * slope + along**2 * low / 2 + cubic)
