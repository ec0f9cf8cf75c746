"""Impulse responses of photoreceptors: what a flash of light makes of them, over time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of, positive, within
from omma.base.arrays import Floats
from omma.base.slips import refuse_slip
from omma.base.values import value_class
from omma.photoreceptors import knots

SHAPES = ("howard", "exponential", "box", "table")

# Of a response that never ends, the share of |h| that may lie after `duration_s`.
_LEFT_OUT = 1e-4
# A table whose last value is above this share of its largest breaks off; below, it is noise.
_ENDS_BELOW = 0.01
# Where positive and negative lobes cancel to less than this, weights of ±1/share are only noise.
_LEAST_NET_SHARE = 0.01
# Trapezoids over a Gaussian of ± this many standard deviations converge faster than any power; what
# lies beyond is 1e-17.
_DEVIATIONS = 8.5


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class ImpulseResponse:
    """The response h(t) to a flash at t = 0, per second, with integral 1; 0 before the flash.

    Made by `howard`, `exponential`, `box` or `table`. A receptor's response to light L(t) is
    R(t) = ∫ h(τ) L(t - τ) dτ, so that steady light of 1 gives 1.

    shape: "howard", "exponential", "box" or "table".
    time_s: the time to the peak, the time constant or the duration; 0 of a table.
    sigma: width of a log-normal; 0 of others.
    times_s, values: (K,) knots of a table, per second, with integral 1; empty of others.
    """

    shape: str
    time_s: float = 0.0
    sigma: float = 0.0
    times_s: tuple[float, ...] = field(default=())
    values: tuple[float, ...] = field(default=())

    def __post_init__(self) -> None:
        one_of(self.shape, SHAPES, "shape")
        if self.shape != "table":
            _check_time(self.time_s, "time_s")
            if self.shape == "howard":
                within(self.sigma, "sigma", 0.01, 1.0)
            if len(self.times_s) or len(self.values):
                raise Error(f"times_s: expected none, as the shape is {self.shape}")
            object.__setattr__(self, "time_s", float(self.time_s))
            object.__setattr__(self, "sigma", float(self.sigma))
            return
        times, values = _checked_table(self.times_s, self.values)
        object.__setattr__(self, "times_s", tuple(times.tolist()))
        object.__setattr__(self, "values", tuple(values.tolist()))

    @staticmethod
    @checked
    def howard(time_to_peak_s: float, sigma: float) -> ImpulseResponse:
        """A log-normal, exp{-[ln(t/t_p)]²/2σ²}: the two-parameter fit to photoreceptors of insects
        (Howard, Dubs and Payne 1984, J Comp Physiol A 154:707).

        Args:
            time_to_peak_s: t_p, when it is largest, s.
            sigma: σ, without unit, 0.01 to 1; wider ones hardly end.

        Example:
            >>> h = omma.photoreceptors.ImpulseResponse.howard(0.010, 0.3)
            >>> f"{1e3 * h.full_width_s:.3f} ms"
            '7.212 ms'

        Raises:
            omma.Error: a time or a width out of range.
        """
        _check_time(time_to_peak_s, "time_to_peak_s")
        return ImpulseResponse("howard", time_to_peak_s, sigma)

    @staticmethod
    @checked
    def exponential(time_constant_s: float) -> ImpulseResponse:
        """exp(-t/τ)/τ, a low-pass filter of first order.

        Raises:
            omma.Error: a time constant that is not above 0, or above 5 s.
        """
        _check_time(time_constant_s, "time_constant_s")
        return ImpulseResponse("exponential", time_constant_s)

    @staticmethod
    @checked
    def box(duration_s: float) -> ImpulseResponse:
        """The mean over a time, as a camera's shutter takes it.

        Raises:
            omma.Error: a duration that is not above 0, or above 5 s.
        """
        _check_time(duration_s, "duration_s")
        return ImpulseResponse("box", duration_s)

    @staticmethod
    @checked
    def table(times_s: ArrayLike, values: ArrayLike) -> ImpulseResponse:
        """Linear between knots, 0 outside: a response that was measured.

        Values may be negative (a response that undershoots), and are scaled to integral 1.

        Args:
            times_s: (K,), two or more, growing, from 0 on, s.
            values: (K,), in any unit; the last one 0, or within 1 % of the largest.

        Raises:
            omma.Error: times that do not grow, lie before the flash or beyond 5 s; values that are
                not finite, are negative everywhere, do not come back to 0 (the response does not
                end), or whose negative part takes away all but a hundredth of the positive.
        """
        times = array_of(times_s, "times_s", (None,))
        given = array_of(values, "values", (None,))
        return ImpulseResponse("table", 0.0, 0.0, tuple(times.tolist()), tuple(given.tolist()))

    def eval(self, times_s: ArrayLike) -> Any:
        """h at times after the flash of any shape, s: per second; 0 before it."""
        t = _times(times_s)
        if self.shape == "table":
            times, values = self._knots
            return np.interp(t, times, values, left=0.0, right=0.0)
        if self.shape == "box":
            return np.where((t >= 0) & (t < self.time_s), 1 / self.time_s, 0.0)
        if self.shape == "exponential":
            return np.where(t >= 0, np.exp(-np.maximum(t, 0) / self.time_s) / self.time_s, 0.0)
        s = self.sigma
        area = self.time_s * s * np.sqrt(2 * np.pi) * np.exp(s**2 / 2)
        return np.exp(-(self._log_time(t) ** 2) / (2 * s**2)) / area

    def cumulative(self, times_s: ArrayLike) -> Any:
        """∫ h from 0 to times of any shape, s: the response to a step of light."""
        t = _times(times_s)
        if self.shape == "table":
            return knots.cumulative(*self._knots, t)
        x = np.maximum(t, 0) / self.time_s
        if self.shape == "box":
            return np.minimum(x, 1.0)
        if self.shape == "exponential":
            return -np.expm1(-x)
        from scipy.special import ndtr

        return ndtr(self._log_time(t) / self.sigma - self.sigma)

    def first_moment_s(self, times_s: ArrayLike) -> Any:
        """∫ τ h(τ) dτ from 0 to times of any shape, s; up to ``inf`` it is the mean delay."""
        t = _times(times_s)
        if self.shape == "table":
            return knots.first_moment(*self._knots, t)
        if self.shape == "box":
            return np.clip(t, 0, self.time_s) ** 2 / (2 * self.time_s)
        if self.shape == "exponential":
            # At infinity the second term is 0 too, where it would be computed as inf times 0.
            x = np.clip(t / self.time_s, 0, 1000.0)
            return self.time_s * (-np.expm1(-x) - x * np.exp(-x))
        from scipy.special import ndtr

        mean = self.time_s * np.exp(1.5 * self.sigma**2)
        return mean * ndtr(self._log_time(t) / self.sigma - 2 * self.sigma)

    def quantile(self, u: ArrayLike) -> Any:
        """The time up to which a share ``u`` of |h| lies, s; the inverse of `cumulative` where h is
        nowhere negative.

        Args:
            u: of any shape, 0 to 1; 1 is ``inf`` where h does not end.

        Raises:
            omma.Error: shares beyond 0 to 1.
        """
        share = array_of(u, "u")
        if not np.all((share >= 0) & (share <= 1)):
            raise Error("u: expected shares from 0 to 1")
        if self.shape == "table":
            times, size = self._knots_of_size
            area = share * knots.integral(times, size)
            return knots.inverse_of_cumulative(times, size, area)
        if self.shape == "box":
            return self.time_s * share
        if self.shape == "exponential":
            with np.errstate(divide="ignore"):
                return -self.time_s * np.log1p(-share)
        from scipy.special import ndtri

        return self.time_s * np.exp(self.sigma * (self.sigma + ndtri(share)))

    def sample(self, u: ArrayLike) -> tuple[Any, Any]:
        """Times drawn from |h| and what each counts: the mean of weight × L(t - time) over ``u``
        that is even from 0 to 1 is the response.

        Args:
            u: of any shape, from 0 to below 1.

        Returns:
            Times of the shape of ``u``, s, and weights of the same shape: 1 everywhere where h is
            nowhere negative, else ± the integral of |h| with the sign of h.
        """
        times = self.quantile(u)
        if self.shape != "table" or min(self.values) >= 0:
            return times, np.ones_like(times)
        total = knots.integral(*self._knots_of_size)
        return times, np.where(self.eval(times) < 0, -total, total)

    def transfer(self, frequency_hz: ArrayLike) -> Any:
        """H(f) = ∫ h(t) exp(-2πift) dt at frequencies of any shape, Hz: complex, 1 at 0.

        Its modulus says what is left of a flicker's amplitude, its argument (negative, as responses
        are late) by how much it is behind. In closed form but for the log-normal, which has none
        and is integrated to about 1e-12.
        """
        frequency = array_of(frequency_hz, "frequency_hz", finite=True)
        w = 2 * np.pi * frequency
        if self.shape == "exponential":
            return 1 / (1 + 1j * w * self.time_s)
        if self.shape == "box":
            return np.sinc(frequency * self.time_s) * np.exp(-0.5j * w * self.time_s)
        if self.shape == "table":
            return knots.transfer(*self._knots, w.ravel()).reshape(w.shape)
        found = [self._howard_transfer(one) for one in w.ravel()]
        return np.array(found, complex).reshape(w.shape)

    @property
    def duration_s(self) -> float:
        """When it ends, or, where it never does, up to when all but 1e-4 of |h| lies, s."""
        if self.shape == "table":
            return self.times_s[-1]
        return self.time_s if self.shape == "box" else float(self.quantile(1 - _LEFT_OUT))

    @property
    def integration_time_s(self) -> float:
        """1/∫ h²: photons that come by chance make the same noise in the response as their number
        does that is counted over this time, s.

        It is longer than the full width at half maximum, which
        `omma.species.Species.integration_time_s` gives: 1.58 times for a log-normal of σ 0.3, 1.51
        times for a Gaussian. Count photons by this one to have the noise that a filter leaves.
        """
        if self.shape == "howard":
            s = self.sigma
            return float(2 * np.sqrt(np.pi) * s * self.time_s * np.exp(0.75 * s**2))
        if self.shape == "table":
            times, values = self._knots
            squares = values[:-1] ** 2 + values[:-1] * values[1:] + values[1:] ** 2
            return float(3 / np.sum(np.diff(times) * squares))
        return self.time_s if self.shape == "box" else 2 * self.time_s

    @property
    def time_to_peak_s(self) -> float:
        """When h is largest, s; of several such times the first."""
        if self.shape == "howard":
            return self.time_s
        return self.times_s[int(np.argmax(self.values))] if self.shape == "table" else 0.0

    @property
    def full_width_s(self) -> float:
        """How long h is above half its largest value, around its peak, s."""
        if self.shape == "howard":
            return float(2 * self.time_s * np.sinh(self.sigma * np.sqrt(2 * np.log(2))))
        if self.shape == "exponential":
            return float(self.time_s * np.log(2))
        if self.shape == "box":
            return self.time_s
        times, values = self._knots
        peak = int(np.argmax(values))
        above = values - values[peak] / 2
        after = np.flatnonzero(above[peak:] < 0)
        before = np.flatnonzero(above[: peak + 1] < 0)
        end, start = times[-1], times[0]
        if len(after):
            k = peak + int(after[0])
            end = np.interp(0.0, above[[k, k - 1]], times[[k, k - 1]])
        if len(before):
            k = int(before[-1])
            start = np.interp(0.0, above[[k, k + 1]], times[[k, k + 1]])
        return float(end - start)

    @property
    def _knots(self) -> tuple[Floats, Floats]:
        return np.array(self.times_s), np.array(self.values)

    @property
    def _knots_of_size(self) -> tuple[Floats, Floats]:
        """Those of |h|."""
        times, values = knots.with_crossings(*self._knots)
        return times, np.abs(values)

    def _log_time(self, t: Floats) -> Floats:
        """ln(t / t_p), -inf up to the flash."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(np.maximum(t, 0.0) / self.time_s))

    def _howard_transfer(self, angular_hz: float) -> complex:
        """The mean of exp(-iωt) over the log-normal: over z, t = t_p exp(σ² + σz), z normal."""
        s = self.sigma
        # So fine that the phase turns by less than half a radian a step even at +5 deviations,
        # beyond which less than 1e-6 lies that then turns to and fro.
        turn = abs(angular_hz) * self.time_s * s * np.exp(s**2 + 5 * s)
        count = int(np.clip(2 * _DEVIATIONS * 2 * turn, 512, 200_000))
        z = np.linspace(-_DEVIATIONS, _DEVIATIONS, count)
        t = self.time_s * np.exp(s * (s + z))
        weight = np.exp(-(z**2) / 2)
        return complex(np.sum(weight * np.exp(-1j * angular_hz * t)) / np.sum(weight))


def _check_time(value: float, name: str) -> None:
    refuse_slip("impulse response", positive(value, name), name)


def _times(times_s: ArrayLike) -> Floats:
    times = array_of(times_s, "times_s")
    if np.any(np.isnan(times)):
        raise Error("times_s: expected times, found NaN")
    return times


def _checked_table(times_s: ArrayLike, values: ArrayLike) -> tuple[Floats, Floats]:
    """The knots of a table, with integral 1."""
    times = array_of(times_s, "times_s", (None,))
    given = array_of(values, "values", (None,))
    if len(times) < 2 or len(times) != len(given):
        raise Error(
            f"values: expected one for each of at least 2 times, found {len(given)} for "
            f"{len(times)} times"
        )
    for name, array in (("times_s", times), ("values", given)):
        bad = np.flatnonzero(~np.isfinite(array))
        if len(bad):
            raise Error(f"{name}: expected finite numbers, found {array[bad[0]]} at [{bad[0]}]")
    if times[0] < 0:
        raise Error(f"times_s: expected times from the flash at 0 on, found {times[0]:g} at [0]")
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        k = int(back[0]) + 1
        raise Error(f"times_s: expected times that grow, found {times[k]:g} at [{k}]")
    _check_time(float(times[-1]), "times_s")
    largest = np.max(np.abs(given))
    if np.max(given) <= 0:
        raise Error("values: expected a response that is somewhere above 0, found none")
    if abs(given[-1]) > _ENDS_BELOW * largest:
        raise Error(
            f"values: expected a response that ends, found {given[-1] / largest:.3g} of the "
            f"largest value at the last time, {times[-1]:g} s"
        )
    area = knots.integral(times, given)
    crossed, size = knots.with_crossings(times, given)
    whole_area = knots.integral(crossed, np.abs(size))
    if not area >= _LEAST_NET_SHARE * whole_area or not np.isfinite(whole_area):
        raise Error(
            "values: expected an integral above 0, at least "
            f"{_LEAST_NET_SHARE:g} of that of their size, found {area:g} of {whole_area:g}"
        )
    return times, given / area
