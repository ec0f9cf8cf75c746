"""The two filters of a motion detector, a high-pass and a delay, from frame to frame.

Of an input x, slow is its low-pass, τ_H slow' = x - slow, so that x - slow is the high-pass; late
is the low-pass of that, τ late' = x - slow - late. Between two frames x is taken as a straight
line; for such an input the steps are exact, whatever the time constants are to the frame.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import positive
from omma.base.arrays import Floats

Complex = NDArray[np.complex128]

# Limits of the frame interval over a time constant: beyond, a filter does nothing or all.
_LEAST, _MOST = 1e-6, 1e4


class FilterStep(NamedTuple):
    """What is added from a frame to the next, in gains: of differences only, so that what stands
    still stays as it is to the bit.

    slow gains slow_gain (x - slow) + slow_rise (rise of x), late late_gain (x - slow - late) +
    late_more (x - slow) + late_rise (rise of x), all as they were at the frame before.
    """

    slow_gain: float
    slow_rise: float
    late_gain: float
    late_more: float
    late_rise: float


def filter_step(tau_s: float, high_pass_tau_s: float | None, frame_rate_hz: float) -> FilterStep:
    """The step of a delay and a high-pass from frame to frame; without one, slow stays as it is.

    Raises:
        omma.Error: a number that is not above 0, or time constants that are no match for the rate.
    """
    from scipy.linalg import expm

    rate = positive(frame_rate_hz, "frame_rate_hz")
    shares = []
    for name, tau in (("tau_s", tau_s), ("high_pass_tau_s", high_pass_tau_s)):
        if tau is None:
            shares.append(0.0)
            continue
        frames = positive(tau, name) * rate
        if not 1 / _MOST <= frames <= 1 / _LEAST:
            raise Error(
                f"{name}: expected {1 / _MOST:g} to {1 / _LEAST:g} frames of 1/{rate:g} s, found "
                f"{frames:g}"
            )
        shares.append(1 / frames)
    late, slow = shares
    # The solution over one frame is the matrix exponential of the system with state (late, slow,
    # input, slope of the input).
    matrix = np.array(
        [
            [-late, -late, late, 0],
            [0, -slow, slow, 0],
            [0, 0, 0, 1],
            [0, 0, 0, 0],
        ]
    )
    made = expm(matrix)
    late_gain = -math.expm1(-late)
    # Without a high-pass late follows x alone, and there is no more.
    late_more = 0.0 if high_pass_tau_s is None else float(made[0, 2]) - late_gain
    return FilterStep(
        -math.expm1(-slow), float(made[1, 3]), late_gain, late_more, float(made[0, 3])
    )


def transfer(step: FilterStep, angle_rad: Floats) -> tuple[Complex, Complex]:
    """What becomes of a sinusoid that turns by so much from frame to frame: the high-pass (the
    input itself where there is none), and the delayed high-pass, as complex factors."""
    z = np.exp(1j * angle_rad).astype(np.complex128)
    rise = z - 1
    if step.slow_gain == 0:
        slow = np.zeros_like(z)
    else:
        slow = (step.slow_gain + step.slow_rise * rise) / (rise + step.slow_gain)
    high = 1 - slow
    late = (step.late_gain + step.late_more) * high + step.late_rise * rise
    return high, late / (rise + step.late_gain)
