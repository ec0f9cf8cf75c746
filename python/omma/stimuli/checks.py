"""Checks of the parameters that several stimuli share."""

from __future__ import annotations

from typing import Any

from omma._core import Error
from omma.base.arguments import within

# Faster than anything that is shown to animals, and slow enough to be computed exactly.
_MOST_HZ, _MOST_DEG_S = 1e5, 1e6


def keep(stimulus: Any, **values: Any) -> None:
    """Put checked values into the fields of a frozen dataclass."""
    for name, value in values.items():
        object.__setattr__(stimulus, name, value)


def radiance_of(value: float, name: str) -> float:
    """A radiance, 0 to 1e6."""
    return within(value, name, 0.0, 1e6)


def frequency_hz(value: float, name: str) -> float:
    """A temporal frequency, Hz, of either sign."""
    return within(value, name, -_MOST_HZ, _MOST_HZ)


def angular_speed(value: float, name: str) -> float:
    """An angular speed, degrees/s, of either sign."""
    return within(value, name, -_MOST_DEG_S, _MOST_DEG_S)


def angle_deg(value: float, name: str) -> float:
    """An angle of any number of turns, within reason."""
    return within(value, name, -3600.0, 3600.0)


def length_m(value: float, name: str) -> float:
    """A length above 0, m."""
    return within(value, name, 1e-6, 1e6)


def name_of(value: str, name: str) -> str:
    """A name that is not empty."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected a text, found {type(value).__name__} {value!r:.40}")
    if not value or not value.isprintable():
        raise Error(f"{name}: expected a text of printable characters, found {value!r:.40}")
    return value
