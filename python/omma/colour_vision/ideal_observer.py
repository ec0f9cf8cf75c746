"""How well an ideal observer tells two things apart that differ by photons that come by chance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.colour_vision.catches import as_catches, pair_of


@checked
def d_prime(target: ArrayLike, background: ArrayLike, *, dark: ArrayLike = 0.0) -> Floats:
    """How far apart the counts of two things are, in standard deviations: (...).

    d'² = Σ (N_T - N_B)² / N, summed over receptors that count Poisson numbers of these means, with
    N the mean of both plus what is counted in the dark. That is the most of any sum of counts, each
    with a weight of its own, for an observer who knows both means (difference of the means over the
    root mean square of both deviations: Green & Swets 1966, Signal detection theory and
    psychophysics; photons as what limits it: Rose 1942, Proc IRE 30:293; de Vries 1943, Physica
    10:553; both recalled). Receptors and times add up in squares.

    Args:
        target, background: (..., R), mean photons of each receptor in the time over which a
            decision adds up.
        dark: (R,) or a number: counts without light, of spontaneous isomerisations.

    Example:
        >>> float(omma.colour_vision.d_prime([110.0] * 4, [90.0] * 4))
        4.0

    Raises:
        omma.Error: numbers that are negative or not finite, or shapes that do not go together.
    """
    seen, behind = pair_of(target, background, ("target", "background"))
    without = array_of(dark, "dark")
    if without.shape not in ((), seen.shape[-1:]):
        raise Error(f"dark: expected one number or {seen.shape[-1]}, found shape {without.shape}")
    as_catches(np.atleast_1d(without), "dark")
    counted = (seen + behind) / 2 + without
    # Where nothing is ever counted, nothing is told.
    terms = (seen - behind) ** 2 / np.where(counted > 0, counted, 1.0)
    return np.asarray(np.sqrt(terms.sum(axis=-1)))


@checked
def proportion_correct(d_prime: ArrayLike) -> Floats:
    """How often an observer with this d' is right who has to say which of two was the target:
    Φ(d'/√2), 0.5 for 0, 0.76 for 1 (Green & Swets 1966).

    Args:
        d_prime: (...), from 0 on.

    Example:
        >>> omma.colour_vision.proportion_correct([0.0, 1.0, 2.0]).round(3).tolist()
        [0.5, 0.76, 0.921]

    Raises:
        omma.Error: numbers that are negative or not numbers.
    """
    given = array_of(d_prime, "d_prime")
    if not np.all(given >= 0):
        raise Error("d_prime: expected numbers from 0 on")
    right = [0.5 * (1 + math.erf(one / 2)) for one in given.ravel()]
    return np.array(right).reshape(given.shape)
