"""Frames filtered in time by an impulse response: all at once, or one by one for closed loops.

Between frames light is taken to go in a straight line, so that each frame's weight is the exact
integral of h times a triangle around it. Light that stood still between frames would be later by
half a frame, and off by a multiple of the interval; so it is off by its square only.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, expect, positive
from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip
from omma.photoreceptors.impulse_response import ImpulseResponse

# Share of |h| that may be cut off after the last frame; weights are rescaled so that steady light
# is kept.
_LEFT_OUT = 1e-7
# More frames than that in one response are a frame rate in the wrong unit.
_MOST_FRAMES = 20_000
# Frames convolved at a time: few, as the Toeplitz matrix is dense.
_ROWS = 256


def frame_weights(h: ImpulseResponse, frame_rate_hz: float) -> Floats:
    """What each frame counts in a response: (K,), the newest first; they add up to 1.

    Raises:
        omma.Error: a frame rate at which the response takes more than 20,000 frames.
    """
    interval = 1 / positive(frame_rate_hz, "frame_rate_hz")
    end = h.times_s[-1] if h.shape == "table" else float(h.quantile(1 - _LEFT_OUT))
    if not end < _MOST_FRAMES * interval:
        raise Error(
            f"frame_rate_hz: expected at most {_MOST_FRAMES / end:.3g} for a response of "
            f"{end:.3g} s, found {frame_rate_hz:g}"
        )
    edges = np.arange(int(np.ceil(end / interval)) + 1) * interval
    area, moment = np.diff(h.cumulative(edges)), np.diff(h.first_moment_s(edges)) / interval
    # In interval k light is frame k's at its start and frame k + 1's at its end.
    towards_next = moment - np.arange(len(area)) * area
    weights = np.append(area - towards_next, 0.0) + np.insert(towards_next, 0, 0.0)
    return np.asarray(weights / np.sum(weights))


@checked
def frame_integration_time_s(h: ImpulseResponse, frame_rate_hz: float) -> float:
    """Over which photons of each frame are to be counted so that `filter_frames` leaves the noise
    that h leaves of photons which come at any time: Σ w² / ∫ h², of the weights w of frames, s.

    With it the variance in steady light of L photons per second is L ∫ h², in photons per second
    squared, at any frame rate. Far above the frequencies that h keeps it is 1 / frame rate. Near
    them straight lines between frames average noise away too, and it is less: of a Gaussian of
    standard deviation σ it is (1 - 1/(12 σ² rate²)) / rate, to first order.

    Args:
        h: the impulse response.
        frame_rate_hz: frames per second.

    Example:
        >>> h = omma.photoreceptors.published_response("bumblebee green")
        >>> per_frame = omma.photoreceptors.frame_integration_time_s(h, 100.0)
        >>> round(per_frame * 100, 2)
        0.66

    Raises:
        omma.Error: a frame rate that is not above 0, or at which the response takes more than
            20,000 frames.
    """
    expect(h, ImpulseResponse, "h", "omma.photoreceptors.ImpulseResponse.howard makes one")
    return float(h.integration_time_s * np.sum(frame_weights(h, frame_rate_hz) ** 2))


@checked
def filter_frames(
    responses: ArrayLike,
    frame_rate_hz: float,
    h: ImpulseResponse,
    axis: int = 0,
    before: ArrayLike | None = None,
) -> NDArray[Any]:
    """Responses as photoreceptors have them, whose impulse response is ``h``: at each frame
    ∫ h(τ) R(t - τ) dτ, with R in straight lines between frames.

    A flicker of frequency f keeps H(f) of it, times sinc²(f / frame rate) for the straight lines:
    at 26 frames a period 0.5 % less, at 8 frames 5 %. Noise between frames is averaged too:
    `frame_integration_time_s` is the time over which to count each frame's photons.

    Args:
        responses: of any shape; frames along ``axis``.
        frame_rate_hz: frames per second.
        h: the impulse response; the exponential and the others alike are convolved.
        axis: that of the frames.
        before: what was seen before the first frame, in the shape of a frame or one number (0:
            darkness). None: the first frame stood there.

    Returns:
        Of the same shape; float32 where ``responses`` is, else float64.

    Raises:
        omma.Error: no frames, numbers that are not finite, a frame rate that is not above 0.

    Warns:
        UserWarning: a frame rate below 1 Hz.
    """
    expect(h, ImpulseResponse, "h", "omma.photoreceptors.ImpulseResponse.howard makes one")
    warn_of_slip("frames per second", positive(frame_rate_hz, "frame_rate_hz"), "frame_rate_hz")
    given = array_of(responses, "responses", dtype=None)
    frames = _frames_first(given, axis)
    first = frames[0] if before is None else _frame_of(before, frames.shape[1:], "before")
    flat, earlier = frames.reshape(len(frames), -1), first.reshape(1, -1)
    if h.shape == "exponential":
        from scipy.signal import lfilter

        decay, newest, older = _recursion(h, frame_rate_hz)
        state = (older + decay) * earlier
        filtered, _ = lfilter([newest, older], [1.0, -decay], flat, axis=0, zi=state)
    else:
        weights = frame_weights(h, frame_rate_hz)
        filtered = _convolve(np.concatenate([*[earlier] * (len(weights) - 1), flat]), weights)
    dtype = np.float32 if given.dtype == np.float32 else np.float64
    return np.asarray(np.moveaxis(filtered.reshape(frames.shape), 0, axis), dtype)


def _recursion(h: ImpulseResponse, frame_rate_hz: float) -> tuple[float, float, float]:
    """What the last response, the newest frame and the one before count in that of an exponential,
    which forgets at the same rate forever; they add up to 1.
    """
    interval = 1 / positive(frame_rate_hz, "frame_rate_hz")
    older = float(h.first_moment_s(interval)) / interval
    return float(np.exp(-interval / h.time_s)), float(h.cumulative(interval)) - older, older


def _convolve(padded: Floats, weights: Floats) -> Floats:
    """Sums of ``weights`` (K,) times the rows up to each, from row K - 1 on: (T - K + 1, N)."""
    taps, count = len(weights), len(padded) - len(weights) + 1
    result = np.empty((count, padded.shape[1]))
    size = min(_ROWS, count)
    toeplitz = np.zeros((size, size + taps - 1))
    for row in range(size):
        toeplitz[row, row : row + taps] = weights[::-1]
    for start in range(0, count, size):
        rows = min(size, count - start)
        some = padded[start : start + rows + taps - 1]
        result[start : start + rows] = toeplitz[:rows, : len(some)] @ some
    return result


class FrameFilter:
    """`filter_frames` one frame at a time, with what was seen before as its state: for closed
    loops. Both give the same within 1e-12 of the largest response.

    An exponential needs the last response only, whatever its time constant; others keep as many
    frames as their response lasts.

    Args:
        h: the impulse response.
        frame_rate_hz: frames per second.
        before: what was seen before the first frame, in its shape or one number (0: darkness).
            None: the first frame stood there.

    Raises:
        omma.Error: a frame rate that is not above 0, or so high that the response takes more than
            20,000 frames.

    Warns:
        UserWarning: a frame rate below 1 Hz.
    """

    def __init__(
        self, h: ImpulseResponse, frame_rate_hz: float, before: ArrayLike | None = None
    ) -> None:
        expect(h, ImpulseResponse, "h", "omma.photoreceptors.ImpulseResponse.howard makes one")
        warn_of_slip("frames per second", positive(frame_rate_hz, "frame_rate_hz"), "frame_rate_hz")
        self._what = f"{h!r}, {positive(frame_rate_hz, 'frame_rate_hz'):g}"
        self._before = before
        self._decay = 0.0
        if h.shape == "exponential":
            self._decay, *weights = _recursion(h, frame_rate_hz)
            self._weights = np.array(weights)
        else:
            self._weights = frame_weights(h, frame_rate_hz)
        self._past: Floats | None = None  # (K, n), a ring: what was seen
        self._newest = 0
        self._response = np.empty(0)  # (n,), the last one

    def __repr__(self) -> str:
        return f"FrameFilter({self._what})"

    def filter(self, frame: ArrayLike) -> NDArray[Any]:
        """The response to all frames up to this one: of its shape; float32 where it is, else
        float64.

        Raises:
            omma.Error: a frame of another shape than the first, or numbers that are not finite.
        """
        given = array_of(frame, "frame", dtype=None)
        seen = _finite(given, "frame").ravel()
        if self._past is None:
            self._shape = given.shape
            first = seen
            if self._before is not None:
                first = _frame_of(self._before, given.shape, "before").ravel()
            self._past = np.repeat(first[None], len(self._weights), axis=0)
            self._response = first.copy()
        if given.shape != self._shape:
            raise Error(f"frame: expected shape {self._shape}, found {given.shape}")
        count = len(self._weights)
        self._newest = (self._newest - 1) % count
        self._past[self._newest] = seen
        # Rows are from the newest on, around the ring.
        response = np.roll(self._weights, self._newest) @ self._past
        if self._decay > 0:
            response += self._decay * self._response
        self._response = response
        dtype = np.float32 if given.dtype == np.float32 else np.float64
        return np.array(response.reshape(self._shape), dtype)


def _frames_first(given: NDArray[Any], axis: int) -> Floats:
    if given.ndim == 0 or not -given.ndim <= axis < given.ndim:
        raise Error(f"axis: expected one of {given.ndim} axes of responses, found {axis}")
    if given.shape[axis] == 0:
        raise Error("responses: expected frames, found none")
    return np.moveaxis(_finite(given, "responses"), axis, 0)


def _frame_of(value: ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    given = array_of(value, name)
    if given.shape not in ((), shape):
        raise Error(
            f"{name}: expected a number or the shape of a frame, {shape}, found {given.shape}"
        )
    return np.broadcast_to(_finite(given, name), shape)


def _finite(given: NDArray[Any], name: str) -> Floats:
    found = given.astype(np.float64, copy=False)
    if not np.all(np.isfinite(found)):
        raise Error(f"{name}: expected finite numbers")
    return found
