"""Arrays of other libraries (PyTorch, JAX, ...) as NumPy's, by DLPack: the same memory, no copy,
but for those on a graphics card, which are copied."""

from __future__ import annotations

from typing import Any

import numpy as np

from omma._core import Error
from omma.base.card_arrays import find_on_card

# DLPack device types whose memory this process can read.
_CPU = 1


def as_numpy(value: Any, name: str) -> Any:
    """``value`` as NumPy reads it, where it is another library's array; anything else as it is.

    Raises:
        omma.Error: it lies in the memory of another device, or cannot be handed over; it names the
            argument.
    """
    if isinstance(value, (np.ndarray, np.generic)):
        return value
    on_card = find_on_card(value, name)
    if on_card is not None:
        return on_card.copy()
    if not hasattr(value, "__dlpack__"):
        return value
    found = f"{type(value).__module__.split('.')[0]}'s {type(value).__name__}"
    try:
        device = int(value.__dlpack_device__()[0])
        array = np.from_dlpack(value) if device == _CPU else None
    except (BufferError, RuntimeError, TypeError, ValueError) as error:
        reason = str(error).split("\n")[0]
        raise Error(
            f"{name}: expected an array that DLPack can hand over, found {found}: {reason}"
        ) from None
    if array is None:
        raise Error(
            f"{name}: expected an array in the memory of the CPU, found {found} on another device "
            f"(DLPack's device type {device}); bring it to the CPU first"
        )
    return array if array.flags.writeable else _writable(value, array)


def _writable(value: Any, array: Any) -> Any:
    # Before DLPack 1 nothing says whether memory is writable, and NumPy takes it as read-only; a
    # library that gives the same memory as a NumPy array says so by that.
    if hasattr(value, "__array__"):
        other = np.asarray(value)
        same = other.dtype == array.dtype and other.shape == array.shape
        if same and other.flags.writeable and np.may_share_memory(other, array):
            return other
    return array
