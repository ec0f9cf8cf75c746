"""Static nonlinearities of photoreceptors: what steady light makes of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats


@checked
def naka_rushton(
    catches: ArrayLike, half: float, exponent: float = 1.0, maximum: float = 1.0
) -> Any:
    """maximum × cⁿ / (cⁿ + halfⁿ): a response that saturates (Naka and Rushton 1966, J Physiol
    185:536).

    Args:
        catches: of any shape, from 0 on, in any unit.
        half: the catch that gives half of the maximum, in their unit.
        exponent: n; steepness.
        maximum: what the brightest light gives.

    Raises:
        omma.Error: catches that are negative or not finite, or numbers that are not above 0.
    """
    ratio = light_of(catches, "catches") / positive(half, "half")
    power = positive(exponent, "exponent")
    largest = positive(maximum, "maximum")
    # Of the two forms the one that does not overflow.
    bright = ratio > 1
    small = np.where(bright, 1 / np.where(bright, ratio, 1.0), ratio) ** power
    return largest * np.where(bright, 1.0, small) / (1 + small)


@checked
def logarithmic(catches: ArrayLike, dark: float, gain: float = 1.0) -> Any:
    """gain × ln(1 + c/dark): linear in dim light, the logarithm in bright, so that equal contrasts
    give equal steps (Weber and Fechner).

    Args:
        catches: of any shape, from 0 on, in any unit.
        dark: the catch from which on it is rather logarithmic, in their unit.
        gain: what an e-fold more of bright light adds.

    Raises:
        omma.Error: catches that are negative or not finite, or numbers that are not above 0.
    """
    return positive(gain, "gain") * np.log1p(light_of(catches, "catches") / positive(dark, "dark"))


def light_of(value: ArrayLike, name: str) -> Floats:
    """``value`` where it is light: numbers from 0 on; omma.Error names the argument."""
    given = array_of(value, name)
    bad = np.argwhere(~(np.isfinite(given) & (given >= 0)))
    if len(bad):
        where = ", ".join(map(str, bad[0]))
        found = given[tuple(bad[0])]
        raise Error(f"{name}: expected numbers from 0 on, found {found:g} at [{where}]")
    return given
