"""The dynamic model of a blowfly's photoreceptors: low-pass filters, two divisive feedback loops
and a static nonlinearity (van Hateren and Snippe 2001, Vision Res 41:1851).

Numbers are those of the authors' program, as Gabbiani and Cox carried it over for "Mathematics for
Neuroscientists" (fly_phot9.m). There both loops hand on a millisecond late and the last filter is a
millisecond early; here loops do not wait, and the last filter is a millisecond late: the same, and
at any frame rate.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import checked, positive
from omma.base.arrays import Floats
from omma.photoreceptors.adaptation import light_of
from omma.photoreceptors.filters import FrameFilter
from omma.photoreceptors.impulse_response import ImpulseResponse

# Phototransduction: three low-pass filters of first order one after another.
PRE_TIME_S, PRE_ORDER = 1.69e-3, 3
# The first loop divides by its own output, filtered: the square root of steady light.
FAST_TIME_S = 71.8e-3
# The second divides by K1 exp(K2 × its own output, filtered).
K1, K2 = 0.689, 9.07
# Its filter remembers as the square root of time: low-pass filters whose time constants are a
# factor of 4 apart, 1/16 ms to 17 min, each with the weight √τ.
SLOW_TIMES_S = 1e-3 * 4.0 ** np.arange(-2, 11)
SLOW_WEIGHTS = np.sqrt(SLOW_TIMES_S) / np.sum(np.sqrt(SLOW_TIMES_S))
# The membrane: t¹¹ exp(-t/τ), after a millisecond; and mV of the largest response: 0.01284 mV × 11!
# × τ in ms, over the 4096 of the program's transform.
POST_TIME_S, POST_POWER, POST_LATENCY_S = 0.535e-3, 11, 1e-3
MAXIMUM_MV = 66.94

# The loops are run in steps of about a millisecond, as published, or shorter; between frames that
# are further apart than this nothing is known of light that they would answer.
_STEP_S = 1e-3
_LONGEST_INTERVAL_S = 1.0
# Light below this counts as this: the square root has no darkness to divide by.
_DARKEST = 0.01
# The exponential of the second loop ends where the program's does.
_LARGEST_EXPONENT = 18.0
# The membrane's response is over after that, to 1e-7.
_POST_END_S = 0.022


@checked
def van_hateren_snippe(
    intensities: ArrayLike, frame_rate_hz: float, before: ArrayLike | None = None
) -> Floats:
    """The receptor potential of blowfly photoreceptors, which adapt: mV above the resting potential
    in the dark.

    Args:
        intensities: (F, ...), frames first, of which receptors one by one are filtered. In the
            model's unit, of which a scene by day has about 600 in the mean; below 0.01 counts as
            0.01.
        frame_rate_hz: frames per second; between frames light goes in a straight line, and the
            model in steps of about a millisecond.
        before: to what receptors are adapted: what they saw for hours before the first frame, in
            the shape of a frame or one number. None: the first frame.

    Returns:
        Of the same shape, mV.

    Raises:
        omma.Error: no frames, intensities that are negative or not finite, a frame rate below
            1 Hz.
    """
    given = light_of(intensities, "intensities")
    if given.ndim == 0 or len(given) == 0:
        raise Error("intensities: expected frames along the first axis, found none")
    receptors = VanHaterenSnippe(frame_rate_hz, before)
    return np.array([receptors.filter(frame) for frame in given])


class VanHaterenSnippe:
    """`van_hateren_snippe` one frame at a time, with what the receptors are adapted to as its
    state: for closed loops. Both give the same.

    Args:
        frame_rate_hz: frames per second.
        before: what was seen for hours before the first frame, in its shape or one number. None:
            the first frame.

    Raises:
        omma.Error: a frame rate below 1 Hz.
    """

    def __init__(self, frame_rate_hz: float, before: ArrayLike | None = None) -> None:
        interval = 1 / positive(frame_rate_hz, "frame_rate_hz")
        if interval > _LONGEST_INTERVAL_S:
            raise Error(f"frame_rate_hz: expected 1 or more, found {frame_rate_hz:g}")
        self._steps = max(1, round(interval / _STEP_S))
        self._step_s = interval / self._steps
        self._before = before
        self._seen: Floats | None = None

    def __repr__(self) -> str:
        return f"VanHaterenSnippe(frame_rate_hz={1 / (self._steps * self._step_s):g})"

    def filter(self, frame: ArrayLike) -> Floats:
        """The receptor potential after this frame: of its shape, mV.

        Raises:
            omma.Error: a frame of another shape than the first, intensities that are negative or
                not finite.
        """
        given = _light(frame, "frame")
        if self._seen is None:
            start = given
            if self._before is not None:
                start = _light(self._before, "before")
                if start.shape not in ((), given.shape):
                    raise Error(
                        f"before: expected a number or the shape of a frame, {given.shape}, found "
                        f"{start.shape}"
                    )
            self._adapt_to(np.broadcast_to(start, given.shape))
        assert self._seen is not None
        if given.shape != self._seen.shape:
            raise Error(f"frame: expected shape {self._seen.shape}, found {given.shape}")
        rise = (given - self._seen) / self._steps
        for _ in range(self._steps):
            self._seen = self._seen + rise
            potential = self._advance(self._seen)
        self._seen = given
        return np.asarray(MAXIMUM_MV * potential)

    def _adapt_to(self, light: Floats) -> None:
        """The state after this light for hours: √I, and x with K1 x exp(K2 x) = √I."""
        from scipy.special import lambertw

        self._seen = light.copy()
        root = np.sqrt(light)
        adapted = lambertw(K2 * root / K1).real / K2
        self._pre = np.broadcast_to(light, (PRE_ORDER, *light.shape)).copy()
        self._fast = root
        self._divided = root
        self._slow = np.broadcast_to(adapted, (len(SLOW_TIMES_S), *light.shape)).copy()
        self._slow_input = adapted
        saturated = adapted / (1 + adapted)
        self._post = FrameFilter(_membrane(), 1 / self._step_s, before=saturated)

    def _advance(self, light: Floats) -> Any:
        """One step: the response relative to the largest."""
        keep = np.exp(-self._step_s / PRE_TIME_S)
        for k in range(PRE_ORDER):
            light = self._pre[k] = (1 - keep) * light + keep * self._pre[k]
        # Both loops divide by what they gave until the step before.
        keep = np.exp(-self._step_s / FAST_TIME_S)
        self._fast = (1 - keep) * self._divided + keep * self._fast
        self._divided = light / self._fast
        keeps = np.exp(-self._step_s / SLOW_TIMES_S).reshape(-1, *[1] * light.ndim)
        self._slow = (1 - keeps) * self._slow_input + keeps * self._slow
        exponent = K2 * np.tensordot(SLOW_WEIGHTS, self._slow, 1)
        gain = K1 * np.exp(np.minimum(exponent, _LARGEST_EXPONENT))
        self._slow_input = self._divided / gain
        return self._post.filter(self._slow_input / (1 + self._slow_input))


@functools.cache
def _membrane() -> ImpulseResponse:
    times = np.linspace(0, _POST_END_S, 441)
    x = times / POST_TIME_S
    values = (x / POST_POWER) ** POST_POWER * np.exp(POST_POWER - x)
    values[-1] = 0.0
    latency = POST_LATENCY_S + times
    return ImpulseResponse.table(latency, values)


def _light(value: ArrayLike, name: str) -> Floats:
    return np.maximum(light_of(value, name), _DARKEST)
