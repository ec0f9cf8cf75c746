"""Arrays in the memory of a graphics card, as PyTorch, CuPy, JAX, Numba and Warp hand them over: by
``__cuda_array_interface__`` (numba.readthedocs.io/en/stable/cuda/cuda_array_interface.html)."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error


@dataclass(frozen=True)
class OnCard:
    """An array on a card, in C order."""

    value: Any
    """The other library's."""
    card: int
    """The ordinal of the card."""
    at: int
    """Its address on the card."""
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    stream: int | None
    """CUDA's stream that it may be used in, 0 the default one; None: its library does not say."""
    writable: bool

    @property
    def span(self) -> _core.CardSpan:
        """It as the engine takes it."""
        return _core.CardSpan(self.card, self.at, prod(self.shape), self.stream)

    @property
    def bytes(self) -> int:
        """Its size."""
        return prod(self.shape) * self.dtype.itemsize

    def copy(self) -> NDArray[Any]:
        """What it holds, as NumPy's, when all that was asked of the card is done."""
        array = np.empty(self.shape, self.dtype)
        _core.card_read(self.card, self.at, array.reshape(-1).view(np.uint8))
        return array

    def write(self, array: NDArray[Any]) -> None:
        """Give it the numbers of an array of the same shape and type."""
        _core.card_write(self.card, self.at, np.ascontiguousarray(array).reshape(-1).view(np.uint8))


def on_host(array: NDArray[Any] | OnCard) -> NDArray[Any]:
    """An array as NumPy's: itself, or a copy of what is on a card."""
    return array.copy() if isinstance(array, OnCard) else array


def returned_of(array: NDArray[Any] | OnCard) -> Any:
    """An array as callers get it back: as NumPy's, or what they gave of a card."""
    return array.value if isinstance(array, OnCard) else array


def share_memory(one: NDArray[Any] | OnCard, other: NDArray[Any] | OnCard) -> bool:
    """Whether two arrays have memory in common."""
    if isinstance(one, OnCard) and isinstance(other, OnCard):
        return one.at < other.at + other.bytes and other.at < one.at + one.bytes
    if isinstance(one, OnCard) or isinstance(other, OnCard):
        return False
    return bool(np.shares_memory(one, other))


def find_on_card(value: Any, name: str) -> OnCard | None:
    """``value`` where it is an array on a card; else None.

    Raises:
        omma.Error: it is on one, and not in C order, masked, not of numbers, or its library does
            not hand it over; it names the argument.
    """
    if isinstance(value, (np.ndarray, np.generic)):
        return None
    try:
        given = getattr(value, "__cuda_array_interface__", None)
    except (RuntimeError, ValueError) as error:
        raise Error(
            f"{name}: expected an array that its library hands over, found {_named(value)}: "
            + str(error).split("\n")[0]
        ) from None
    if not isinstance(given, dict):
        return None
    try:
        shape = tuple(int(length) for length in given["shape"])
        dtype, (at, read_only) = np.dtype(given["typestr"]), given["data"]
    except (KeyError, TypeError, ValueError) as error:
        raise Error(
            f"{name}: expected __cuda_array_interface__ with shape, typestr and data, found "
            f"{_named(value)}'s without: {error}"
        ) from None
    if not _in_c_order(shape, given.get("strides"), dtype.itemsize):
        raise Error(f"{name}: expected an array in C order, found {_named(value)} that is not")
    if given.get("mask") is not None or dtype.kind not in "biuf":
        raise Error(f"{name}: expected an array of numbers, found {_named(value)} of {dtype}")
    if 0 in shape:
        raise Error(f"{name}: expected numbers, found {_named(value)} of shape {shape}")
    try:
        card = _core.card_of(at)
    except Error as error:
        raise Error(f"{name}: {error}") from None
    return OnCard(value, card, int(at), shape, dtype, _stream(given), not read_only)


def _in_c_order(shape: tuple[int, ...], strides: Any, step: int) -> bool:
    if strides is None:
        return True
    for length, stride in zip(reversed(shape), reversed(strides)):
        if length > 1 and stride != step:
            return False
        step *= length
    return True


def _stream(given: dict[str, Any]) -> int | None:
    # Before version 3 nobody says; from then on none means that nothing has to be waited for.
    if int(given.get("version", 0)) < 3:
        return None
    return int(given.get("stream") or 0)


def _named(value: Any) -> str:
    return f"{type(value).__module__.split('.')[0]}'s {type(value).__name__}"
