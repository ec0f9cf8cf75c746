"""Noise of photons and of what is behind them, the same for the same seed, however frames are cut
into pieces.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, positive, whole
from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip

# From here on a Poisson number is drawn as a normal one: it differs from it by a skewness of 1e-5,
# while drawing it directly would lose its digits.
_MANY = 1e10
# Counts above are no longer whole numbers in double precision.
_MOST = 9e15
# Numbers of a frame are drawn from a generator of its own, a stream for each kind of noise.
_PHOTONS, _INTRINSIC = 0, 1


@checked
def photon_noise(
    catches: ArrayLike,
    seed: int,
    *,
    photons_per_s: ArrayLike | None = None,
    integration_time_s: ArrayLike | None = None,
    first_frame: int = 0,
) -> Floats:
    """Photons as they come, by chance: Poisson numbers with these means.

    Without ``photons_per_s`` they are catches, as `omma.receptors.photon_catch` gives them for a
    world lit in photons, and numbers of photons come back. With it they are responses in relative
    units, and responses come back: a Poisson number of mean R × photons_per_s ×
    integration_time_s, divided by the latter two.

    With one seed conditions share their noise: a frame of 1,020 photons has nearly the deviation
    that one of 1,000 has, so that the two differ by far less than photons do, and seem five times
    as easy to tell apart as they are. What is compared has a seed for each condition.

    Args:
        catches: (F, ...), frames first: mean photons in the time over which a receptor adds up, or
            responses.
        seed: 0 to 2⁶⁴ - 1; another one for each condition and each trial.
        photons_per_s: that a receptor absorbs at a response of 1; a number, or one for each, that
            goes with the shape of a frame.
        integration_time_s: over which it adds up: 1 / frame rate where frames are filtered
            afterwards, else `ImpulseResponse.integration_time_s`; a number, or one for each.
        first_frame: number of the first frame. Frames by themselves or in pieces, numbered on, get
            the numbers that they have in the whole.

    Returns:
        Of the same shape.

    Example:
        >>> dim, bright = (
        ...     omma.photoreceptors.photon_noise(np.full((2000, 5), photons), seed)
        ...     for seed, photons in enumerate([1000.0, 1020.0])
        ... )
        >>> bool(abs((bright - dim).var() / (1000 + 1020) - 1) < 0.1)
        True

    Raises:
        omma.Error: catches that are negative, not finite or more than 9e15 photons; only one of
            ``photons_per_s`` and ``integration_time_s``, or one that is not above 0 or of another
            shape.

    Warns:
        UserWarning: an integration time above 5 s.
    """
    if (photons_per_s is None) != (integration_time_s is None):
        raise Error("photon_noise: expected both of photons_per_s and integration_time_s, or none")
    given = _frames(catches, "catches")
    unit: Floats | float = 1.0
    if photons_per_s is not None and integration_time_s is not None:
        shape = given.shape[1:]
        times = _of_receptors(integration_time_s, "integration_time_s", shape)
        unit = _of_receptors(photons_per_s, "photons_per_s", shape) * times
        if times.size:
            warn_of_slip("integration time", float(times.max()), "integration_time_s")
    mean = given * unit
    bad = np.argwhere(~((mean >= 0) & (mean <= _MOST)))
    if len(bad):
        where = ", ".join(map(str, bad[0]))
        raise Error(
            f"catches: expected 0 to {_MOST:g} photons, found {mean[tuple(bad[0])]:g} at [{where}]"
        )
    drawn = np.empty_like(mean)
    for frame, generator in _generators(len(mean), seed, first_frame, _PHOTONS):
        drawn[frame] = generator.poisson(np.minimum(mean[frame], _MANY))
        many = mean[frame] > _MANY
        if np.any(many):
            large = mean[frame][many]
            drawn[frame][many] = np.rint(
                large + np.sqrt(large) * generator.standard_normal(len(large))
            )
    return drawn / unit


@checked
def intrinsic_noise(
    responses: ArrayLike, deviation: ArrayLike, seed: int, *, first_frame: int = 0
) -> Floats:
    """Responses with the noise that receptors have of themselves: normal, independent from receptor
    to receptor and frame to frame, whatever the light.

    What it is in truth (spontaneous isomerisations, bumps of unequal size, channels, synapses)
    differs between cells; a value comes from a recording. Noise that is correlated in time is this
    of zeros, filtered by `filter_frames`.

    Args:
        responses: (F, ...), frames first.
        deviation: standard deviation, in the unit of the responses; a number, or one that goes
            with the shape of a frame.
        seed: 0 to 2⁶⁴ - 1; with the same one it is independent of `photon_noise`, and the very same
            numbers are added to other responses: another one for each condition and each trial.
        first_frame: number of the first frame, as for `photon_noise`.

    Raises:
        omma.Error: numbers that are not finite, a deviation that is negative or of another shape.
    """
    given = _frames(responses, "responses")
    size = array_of(deviation, "deviation")
    if not np.all(np.isfinite(size) & (size >= 0)):
        raise Error("deviation: expected finite numbers from 0 on")
    if not np.all(np.isfinite(given)):
        raise Error("responses: expected finite numbers")
    size = _broadcast(size, "deviation", given.shape[1:])
    noisy = np.empty_like(given)
    for frame, generator in _generators(len(given), seed, first_frame, _INTRINSIC):
        noisy[frame] = given[frame] + size * generator.standard_normal(given.shape[1:])
    return noisy


def _of_receptors(value: ArrayLike, name: str, shape: tuple[int, ...]) -> Floats:
    """Numbers above 0, of the shape of a frame."""
    given = array_of(value, name)
    if given.ndim == 0:
        return np.broadcast_to(positive(float(given), name), shape)
    bad = given[~(np.isfinite(given) & (given > 0))]
    if len(bad):
        raise Error(f"{name}: expected finite numbers above 0, found {bad[0]:g}")
    return _broadcast(given, name, shape)


def _broadcast(given: Floats, name: str, shape: tuple[int, ...]) -> Floats:
    try:
        return np.broadcast_to(given, shape)
    except ValueError:
        raise Error(
            f"{name}: expected a shape that goes with {shape}, found {given.shape}"
        ) from None


def _frames(value: ArrayLike, name: str) -> Floats:
    given = array_of(value, name)
    if given.ndim == 0:
        raise Error(f"{name}: expected frames along the first axis, found one number")
    return given


def _generators(
    count: int, seed: int, first_frame: int, kind: int
) -> Iterator[tuple[int, np.random.Generator]]:
    """(0, its generator), (1, ...) of frames from ``first_frame`` on."""
    key = whole(seed, "seed", 0, (1 << 64) - 1)
    first = whole(first_frame, "first_frame", 0, (1 << 63) - 1)
    for frame in range(count):
        philox = np.random.Philox(
            key=np.array([key, first + frame], np.uint64),
            counter=np.array([0, 0, 0, kind], np.uint64),
        )
        yield frame, np.random.Generator(philox)
