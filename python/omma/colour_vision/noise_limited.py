"""Distances between colours where receptor noise limits what is told apart, in just-noticeable
differences: Vorobyev & Osorio 1998, Proc R Soc B 265:351.

Of N receptor classes with signals f and noise e, the distance is the largest signal-to-noise ratio
of any mechanism that is blind to what all classes have in common,

    ΔS² = Δfᵀ Aᵀ (A E Aᵀ)⁻¹ A Δf

with E = diag(e²) and rows of A that are N - 1 differences of classes (Clark, Santer & Brebner 2017,
R Soc Open Sci 4:170712; Pike 2012, Methods Ecol Evol 3:656). That is the weighted variance

    ΔS² = Σ w_i (Δf_i - Σ w Δf / Σ w)²,  w = 1/e²

which is what is computed here. For two, three and four classes it is the formulas of Vorobyev &
Osorio.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of, whole, within
from omma.base.arrays import Floats
from omma.colour_vision.catches import MOST, as_catches, pair_of

# What of a catch is a receptor's signal.
Signal = Literal["log", "linear"]
# Wide enough for every animal, narrow enough for squares. What is above 1, noise beyond the signal
# itself, is meant per cent.
_LEAST_WEBER, _MOST_WEBER = 1e-9, 1.0


@checked
def class_noise(weber_fraction: float, density: ArrayLike, *, reference: int = -1) -> Floats:
    """The noise e of each receptor class, relative to its signal: (N,).

    e_i = ω √(η_ref / η_i): classes of which more receptors are pooled have less noise. ω is the
    Weber fraction of the reference class, all its receptors pooled (Vorobyev & Osorio 1998).

    Args:
        weber_fraction: ω, above 0, at most 1; 0.1 or so, of animals in daylight.
        density: (N,), relative numbers η of receptors of each class.
        reference: which class ω is of; -1, the last.

    Example:
        >>> omma.colour_vision.class_noise(0.1, [1, 2, 2, 4]).round(4).tolist()
        [0.2, 0.1414, 0.1414, 0.1]

    Raises:
        omma.Error: numbers that are not above 0, a Weber fraction above 1, no such class.
    """
    fraction = _weber(weber_fraction)
    pooled = _noise(density, "density")
    which = whole(reference, "reference", -len(pooled), len(pooled) - 1)
    with np.errstate(over="ignore"):
        return np.asarray(fraction * np.sqrt(pooled[which] / pooled))


@checked
def noise_limited_distance(
    first: ArrayLike,
    second: ArrayLike,
    noise: ArrayLike,
    *,
    signal: Signal = "log",
    photon_noise: bool = False,
    adapting: ArrayLike | None = None,
) -> Floats:
    """How far two colours are apart, in just-noticeable differences: (...).

    Where it is 1, they are just told apart. What all receptor classes have in common counts for
    nothing: the intensity of the light, with logarithms. One class alone sees no colours, 0.

    Args:
        first, second: (..., N), catches of the colours; above 0 with logarithms.
        noise: (N,), e of each class, as `class_noise` gives it; of one at least at most 1.
        signal: "log": f = ln Q, Fechner's law, so that noise is a Weber fraction. "linear": f =
            Q / Q_adapting, for colours near the background (both in Vorobyev & Osorio 1998).
        photon_noise: catches are photons, in the time over which a decision adds up; their noise
            is added, as for a receptor that catches the mean of both: of logarithms e² +
            2/(Q_A + Q_B) (so Vorobyev et al. 1998, J Comp Physiol A 183:621, and pavo's
            ``noise="quantum"``), of linear signals e² + (Q_A + Q_B)/(2 Q_adapting²).
        adapting: (N,), what the classes catch of the background, by which linear signals are
            divided; None: they are already. Logarithms do not need it, as it cancels out.

    Example:
        >>> noise = omma.colour_vision.class_noise(0.13, [1, 1, 1])
        >>> one, other = [0.2, 0.5, 0.5], [0.5, 0.5, 0.5]
        >>> float(omma.colour_vision.noise_limited_distance(one, other, noise).round(2))
        5.75

    Raises:
        omma.Error: catches that are negative or not finite, that are 0 where their logarithm is
            asked for, other numbers of classes, noise above 1 of all of them, photon noise of
            linear signals without ``adapting``.
    """
    expect_fractions(noise)
    return distance_of_many(
        first, second, noise, signal=signal, photon_noise=photon_noise, adapting=adapting
    )


def distance_of_many(
    first: ArrayLike, second: ArrayLike, noise: ArrayLike, *, signal: Signal, photon_noise: bool,
    adapting: ArrayLike | None = None,
) -> Floats:  # fmt: skip
    """`noise_limited_distance` by noise that may be above 1 in all classes that are looked at."""
    logarithmic = one_of(signal, ("log", "linear"), "signal") == "log"
    one, other = pair_of(first, second, ("first", "second"), above_zero=logarithmic)
    classes = one.shape[-1]
    variance = _noise(noise, "noise", classes) ** 2
    if logarithmic:
        difference = np.log(one) - np.log(other)
        scale = np.ones(classes)
    else:
        if photon_noise and adapting is None:
            raise Error("adapting: expected photons of the background, by which photons are judged")
        by = np.ones(classes)
        if adapting is not None:
            by = _noise(adapting, "adapting", classes)
        with np.errstate(over="ignore"):
            difference = (one - other) / by
            scale = ((one + other) / 2 / by) ** 2
    if photon_noise:
        # Var(Q)/Q² of the mean catch; of linear signals times the square of their mean.
        total = one + other
        if not np.all(total > 0):
            raise Error("first, second: expected photons above 0 in each class of one of them")
        with np.errstate(over="ignore"):
            variance = variance + scale * 2 / total
    return _weighted_spread(difference, variance)


@checked
def achromatic_distance(
    first: ArrayLike, second: ArrayLike, weber_fraction: float, *, photon_noise: bool = False
) -> Floats:
    """How far the catches of one receptor class are apart, in just-noticeable differences: (...).

    |ln Q_A - ln Q_B| / e, e the Weber fraction of that class, with photon noise as of
    `noise_limited_distance` (Siddiqi et al. 2004, J Exp Biol 207:2471).

    Args:
        first, second: (...), catches; above 0.
        weber_fraction: of the class; above 0, at most 1.
        photon_noise: catches are photons, whose noise is added.

    Example:
        >>> float(omma.colour_vision.achromatic_distance(0.2, 0.5, 0.13).round(2))
        7.05

    Raises:
        omma.Error: numbers that are not above 0, a Weber fraction above 1, or shapes that do not go
            together.
    """
    fraction = _weber(weber_fraction)
    return distance_of_one(first, second, fraction, photon_noise=photon_noise)


def distance_of_one(
    first: ArrayLike, second: ArrayLike, noise: float, *, photon_noise: bool
) -> Floats:
    """`achromatic_distance` by the noise of a class, which may be above 1 where few are pooled."""
    one, other = pair_of(
        array_of(first, "first")[..., None], array_of(second, "second")[..., None],
        ("first", "second"), above_zero=True,
    )  # fmt: skip
    variance = noise**2 + (2 / (one + other) if photon_noise else 0.0)
    return np.asarray((np.abs(np.log(one) - np.log(other)) / np.sqrt(variance))[..., 0])


@checked
def noise_limited_coordinates(catches: ArrayLike, noise: ArrayLike) -> Floats:
    """Colours as points (..., N - 1) whose distances are just-noticeable differences.

    Distances between them are those of `noise_limited_distance` of logarithms, without photon
    noise; where the axes point is a convention (Pike 2012): the first lies between the first two
    classes, each other between those before and the next class, which is its positive end. Where
    all catches are equal they are 0.

    Args:
        catches: (..., N), above 0, of at least two classes.
        noise: (N,), e of each class, as `class_noise` gives it; of one at least at most 1.

    Example:
        >>> noise = omma.colour_vision.class_noise(0.1, [1, 2])
        >>> points = omma.colour_vision.noise_limited_coordinates([[0.5, 0.5], [0.2, 0.5]], noise)
        >>> points.round(3).tolist()
        [[0.0], [5.29]]

    Raises:
        omma.Error: numbers that are not above 0, fewer than two classes or another number of them,
            noise above 1 of all of them.
    """
    expect_fractions(noise)
    seen = as_catches(catches, "catches", above_zero=True)
    classes = seen.shape[-1]
    if classes < 2:
        raise Error("catches: expected at least two receptor classes, found 1")
    weight = _noise(noise, "noise", classes) ** -2.0
    signal = np.log(seen)
    before = np.cumsum(weight)
    mean = np.cumsum(weight * signal, axis=-1) / before
    # Two weights that are far apart by their common mean, w1 w2/(w1 + w2) (f2 - f1)².
    reduced = np.sqrt(before[:-1] * weight[1:] / before[1:])
    return np.asarray(reduced * (signal[..., 1:] - mean[..., :-1]))


def _weighted_spread(difference: Floats, variance: Floats) -> Floats:
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        # Relative to the least noise, so that squares of small ones stay within range.
        least = np.min(variance, axis=-1, keepdims=True)
        weight = least / variance
        mean = (weight * difference).sum(axis=-1, keepdims=True)
        mean /= weight.sum(axis=-1, keepdims=True)
        squares = (weight * (difference - mean) ** 2).sum(axis=-1)
        return np.asarray(np.sqrt(squares / least[..., 0]))


def _weber(weber_fraction: float) -> float:
    try:
        return within(weber_fraction, "weber_fraction", _LEAST_WEBER, _MOST_WEBER)
    except Error as error:
        meant = ""
        if _MOST_WEBER < weber_fraction <= 100:
            meant = f"; {weber_fraction:g} per cent would be {weber_fraction / 100:g}"
        raise Error(f"{error}{meant}") from None


def expect_fractions(noise: ArrayLike) -> None:
    """Raise `omma.Error` where the noise of all classes is above 1, as in per cent."""
    numbers = array_of(noise, "noise", (None,))
    if len(numbers) and numbers.min() > _MOST_WEBER:
        raise Error(
            f"noise: expected that of one class at least to be at most {_MOST_WEBER:g}, found "
            f"{numbers.min():g} or more; {numbers.min():g} per cent would be "
            f"{numbers.min() / 100:g}"
        )


def _noise(value: ArrayLike, name: str, classes: int | None = None) -> Floats:
    """Finite numbers (N,) above 0."""
    numbers = array_of(value, name, (classes,))
    if len(numbers) == 0 or not np.all((numbers >= 1 / MOST) & (numbers <= MOST)):
        raise Error(f"{name}: expected finite numbers above 0, one for each receptor class")
    return numbers
