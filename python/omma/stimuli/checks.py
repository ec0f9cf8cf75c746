"""Checks of the parameters of stimuli."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

from omma._core import Error
from omma.base.arguments import one_of, whole, within

# A range, or a function of a value and its name to the value as it is kept.
Check = tuple[float, float] | Callable[[Any, str], Any]


def check_fields(stimulus: Any, **own: Check) -> None:
    """Put the checked parameters of a stimulus, a frozen dataclass, in their fields, one after the
    other.

    Args:
        own: of each that does not mean the same in all stimuli, how to check it.
    """
    for name in [one.name for one in fields(stimulus)]:
        check, value = own.get(name) or _SHARED[name], getattr(stimulus, name)
        checked = within(value, name, *check) if isinstance(check, tuple) else check(value, name)
        object.__setattr__(stimulus, name, checked)
    if getattr(stimulus, "mean", 1.0) == 0 and stimulus.contrast > 0:
        raise Error(
            "mean: expected a radiance above 0, to which the contrast is relative, found 0 "
            f"(contrast {stimulus.contrast:g})"
        )


def radiance_of(value: float, name: str) -> float:
    """A radiance, 0 to 1e6."""
    return within(value, name, 0.0, 1e6)


def angular_speed(value: float, name: str) -> float:
    """An angular speed, degrees/s, of either sign."""
    return within(value, name, -1e6, 1e6)


def angle_deg(value: float, name: str) -> float:
    """An angle of any number of turns, within reason."""
    return within(value, name, -3600.0, 3600.0)


def length_m(value: float, name: str) -> float:
    """A length above 0, m."""
    return within(value, name, 1e-6, 1e6)


def whole_from(low: int, high: int) -> Check:
    """A whole number in a range."""
    return lambda value, name: whole(value, name, low, high)


def chosen_from(*choices: str) -> Check:
    """One of some words."""
    return lambda value, name: one_of(value, choices, name)


def _name_of(value: str, name: str) -> str:
    """A name that is not empty."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected a text, found {type(value).__name__} {value!r:.40}")
    if not value or not value.isprintable():
        raise Error(f"{name}: expected a text of printable characters, found {value!r:.40}")
    return value


# Rates are at most faster than anything that is shown to animals, and slow enough to be computed
# exactly.
_SHARED: dict[str, Check] = {
    "azimuth_deg": angle_deg,
    "direction_deg": angle_deg,
    "phase_deg": angle_deg,
    "elevation_deg": (-90.0, 90.0),
    "speed_deg_s": angular_speed,
    "temporal_frequency_hz": (-1e5, 1e5),
    "waveform": chosen_from("sine", "square"),
    "contrast": (0.0, 1.0),
    "mean": radiance_of,
    "background": radiance_of,
    "seed": whole_from(0, (1 << 63) - 1),
    "name": _name_of,
}
