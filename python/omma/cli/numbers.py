"""Numbers of options that are converted to other units, checked as they are typed."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import typer

from omma._core import Error


def above_zero(option: typer.CallbackParam, value: Any) -> Any:
    """The number of an option, or its numbers, all above 0."""
    return _checked(option, value, "a number above 0", lambda number: number > 0)


def not_below_zero(option: typer.CallbackParam, value: Any) -> Any:
    """The number of an option, 0 or more."""
    return _checked(option, value, "a number of at least 0", lambda number: number >= 0)


def angle(option: typer.CallbackParam, value: Any) -> Any:
    """The number of an option, an angle between two directions."""
    expected = "degrees above 0 and below 180"
    return _checked(option, value, expected, lambda number: 0 < number < 180)


def acceptance_angle(option: typer.CallbackParam, value: Any) -> Any:
    """The number of an option, an acceptance angle."""
    return _checked(option, value, "degrees from 0 to 360", lambda number: 0 <= number <= 360)


def finite(option: typer.CallbackParam, value: Any) -> Any:
    """The number of an option, or its numbers, all finite."""
    return _checked(option, value, "finite numbers", lambda number: True)


def numbers_of(option: str, text: str, count: int) -> list[float]:
    """So many numbers, typed with commas between."""
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise Error(f"{option}: expected {count} numbers with commas between, found {text!r:.60}")
    return values


def _checked(
    option: typer.CallbackParam, value: Any, expected: str, holds: Callable[[float], bool]
) -> Any:
    numbers = value if isinstance(value, (tuple, list)) else () if value is None else (value,)
    for number in numbers:
        if not (math.isfinite(number) and holds(number)):
            raise Error(f"{option.opts[0]}: expected {expected}, found {number:g}")
    return value
