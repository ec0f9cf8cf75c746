"""Checks of arguments that several functions share."""

from __future__ import annotations

import operator
from typing import Any

from omma._core import Error


def whole(value: Any, name: str, low: int, high: int) -> int:
    """``value`` as an int from ``low`` to ``high``; TypeError or omma.Error names the argument."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(
            f"{name}: expected a whole number, found {type(value).__name__} {value!r:.40}"
        ) from None
    if not low <= number <= high:
        raise Error(f"{name}: expected {low} to {high}, found {number}")
    return number


def positive(value: float, name: str) -> float:
    """``value`` where it is a finite number above 0; omma.Error names the argument."""
    if not (isinstance(value, (int, float)) and 0 < value < float("inf")):
        raise Error(f"{name}: expected a number above 0, found {value!r:.40}")
    return float(value)
