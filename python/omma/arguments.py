"""Checks of arguments that several functions share."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

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


def expect(value: object, kind: type, name: str, hint: str) -> None:
    """TypeError where ``value`` is no ``kind``; ``hint`` says where to get one."""
    if not isinstance(value, kind):
        found = type(value).__name__
        raise TypeError(f"{name}: expected omma.{kind.__name__}, found {found} ({hint})")


def output_array(out: Any, shape: tuple[int, ...], name: str) -> NDArray[np.float32]:
    """``out`` where the engine can write to it, a new array where it is None."""
    if out is None:
        return np.empty(shape, np.float32)
    if not isinstance(out, np.ndarray) or out.dtype != np.float32:
        found = f"{out.dtype} array" if isinstance(out, np.ndarray) else type(out).__name__
        raise TypeError(f"{name}: expected a float32 array of shape {shape}, found {found}")
    if out.shape != shape:
        raise Error(f"{name}: expected shape {shape}, found {out.shape}")
    if not out.flags.c_contiguous or not out.flags.writeable or not out.flags.aligned:
        raise Error(f"{name}: expected a C-contiguous array that can be written to")
    return out
