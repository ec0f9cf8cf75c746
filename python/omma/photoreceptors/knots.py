"""Functions of time that are linear between knots and 0 outside: their integrals, in closed form.

``times`` (K,) grow, ``values`` (K,) are those at them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats

# Below this phase across a segment (rad) the closed form cancels, and its series is taken: the
# first term left out is 1e-13 of the first.
_SMALL_PHASE = 1e-2


def integral(times: Floats, values: Floats) -> float:
    """∫ of all of it."""
    return float(np.sum(np.diff(times) * (values[1:] + values[:-1])) / 2)


def with_crossings(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The same function with a knot wherever it crosses 0."""
    crossing = np.flatnonzero(values[:-1] * values[1:] < 0)
    before, after = values[crossing], values[crossing + 1]
    where = times[crossing] + np.diff(times)[crossing] * (before / (before - after))
    return np.insert(times, crossing + 1, where), np.insert(values, crossing + 1, 0.0)


def cumulative(times: Floats, values: Floats, at: Floats) -> Floats:
    """∫ up to ``at``, of any shape."""
    k, x, rise, before = _segment(times, values, at, np.diff(times) * _means(values))
    return np.asarray(before + x * (values[k] + rise * x / 2))


def first_moment(times: Floats, values: Floats, at: Floats) -> Floats:
    """∫ t f(t) dt up to ``at``, of any shape."""
    width = np.diff(times)
    of_segment = width * times[:-1] * _means(values) + width**2 * (values[:-1] + 2 * values[1:]) / 6
    k, x, rise, before = _segment(times, values, at, of_segment)
    first, start = values[k], times[k]
    return np.asarray(
        before + x * (start * first + x * ((first + start * rise) / 2 + x * rise / 3))
    )


def inverse_of_cumulative(times: Floats, values: Floats, area: Floats) -> Floats:
    """Where the integral has come to ``area``, of a function that is nowhere negative."""
    areas = np.concatenate([[0.0], np.cumsum(np.diff(times) * _means(values))])
    area = np.clip(area, 0.0, areas[-1])
    # Of segments without area the last, so that the next one begins where it does.
    k = np.clip(np.searchsorted(areas, area, side="right") - 1, 0, len(times) - 2)
    # At the very end, the segment that the last area lies in.
    full = area >= areas[-1]
    k = np.where(full, np.searchsorted(areas, areas[-1], side="left") - 1, k)
    width = np.diff(times)[k]
    rise = (values[k + 1] - values[k]) / width
    within = area - areas[k]
    root = np.sqrt(np.maximum(values[k] ** 2 + 2 * rise * within, 0.0))
    # The root of a quadratic that does not cancel where the segment is flat.
    below = values[k] + root
    x = np.divide(2 * within, below, out=np.zeros_like(within), where=below > 0)
    return np.asarray(times[k] + np.clip(x, 0.0, width))


def transfer(times: Floats, values: Floats, angular_hz: Floats) -> Any:
    """∫ f(t) exp(-iωt) dt at ω (F,), rad/s: (F,) complex."""
    width = np.diff(times)
    phase = angular_hz[:, None] * width
    turn = np.exp(-1j * phase)
    # ∫ from 0 to 1 of (1 - x) exp(-iφx) dx and of x exp(-iφx) dx.
    safe = np.where(np.abs(phase) < _SMALL_PHASE, 1.0, phase)
    down = (1 - turn - 1j * safe) / safe**2
    up = (turn * (1 + 1j * safe) - 1) / safe**2
    small = -1j * np.where(np.abs(phase) < _SMALL_PHASE, phase, 0.0)
    series_down = 1 / 2 + small / 6 + small**2 / 24 + small**3 / 120 + small**4 / 720
    series_up = 1 / 2 + small / 3 + small**2 / 8 + small**3 / 30 + small**4 / 144
    near = np.abs(phase) < _SMALL_PHASE
    down, up = np.where(near, series_down, down), np.where(near, series_up, up)
    start = np.exp(-1j * angular_hz[:, None] * times[:-1])
    return np.sum(width * start * (values[:-1] * down + values[1:] * up), axis=1)


def _means(values: Floats) -> Floats:
    return np.asarray((values[1:] + values[:-1]) / 2)


def _segment(
    times: Floats, values: Floats, at: Floats, of_segment: Floats
) -> tuple[NDArray[np.int64], Floats, Floats, Floats]:
    """Where ``at`` lies: the segment, the time since its start, its slope there, and the sum of
    ``of_segment`` before it.
    """
    inside = np.clip(at, times[0], times[-1])
    k = np.clip(np.searchsorted(times, inside, side="right") - 1, 0, len(times) - 2)
    rise = (values[k + 1] - values[k]) / (times[k + 1] - times[k])
    before = np.concatenate([[0.0], np.cumsum(of_segment)])[k]
    return k, np.asarray(inside - times[k]), np.asarray(rise), np.asarray(before)
