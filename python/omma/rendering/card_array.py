"""Responses that stay on a graphics card: an array for renders to write into."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error
from omma.base.arguments import whole
from omma.base.card_arrays import find_on_card, on_host

_MOST = 1 << 31  # of an axis
_MOST_CARD = 1 << 16


class CardArray:
    """A float32 array in C order in the memory of a graphics card.

    ``renderer.render(poses, out=CardArray((poses, ommatidia, bands)))`` leaves responses there, for
    whatever takes ``__cuda_array_interface__`` or DLPack: ``torch.from_dlpack(array)``,
    ``cupy.asarray(array)``, ``jax.dlpack.from_dlpack(array)``. Tensors of those libraries are taken
    as ``out`` themselves. What it holds at first is anything. Its memory is freed when nothing
    refers to it any more.

    Args:
        shape: lengths of its axes.
        card: the ordinal of the card.

    Raises:
        omma.Error: there is no such card that can be used, or not enough memory on it.
    """

    def __init__(self, shape: Sequence[int], card: int = 0) -> None:
        if not isinstance(shape, Iterable):
            found = f"{type(shape).__name__} {shape!r:.40}"
            raise TypeError(f"shape: expected lengths of axes, as (1, 10760, 3), found {found}")
        self.shape = tuple(whole(length, "shape", 1, _MOST) for length in shape)
        if not self.shape:
            raise Error("shape: expected at least one axis, found none")
        self._memory = _core.CardMemory(prod(self.shape), whole(card, "card", 0, _MOST_CARD))

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        # Renders have ended when they return, so that nothing has to be waited for.
        return {
            "version": 3,
            "shape": self.shape,
            "typestr": "<f4",
            "data": (self._memory.at, False),
            "strides": None,
            "stream": None,
        }

    def __dlpack__(self, **asked: Any) -> Any:
        return self._memory.array(self.shape).__dlpack__(**asked)

    def __dlpack_device__(self) -> tuple[int, int]:
        device: tuple[int, int] = self._memory.array(self.shape).__dlpack_device__()
        return device

    def numpy(self) -> NDArray[np.float32]:
        """A copy in the memory of the processor."""
        on_card = find_on_card(self, "array")
        assert on_card is not None
        return on_host(on_card)

    def __repr__(self) -> str:
        return f"<omma.rendering.CardArray {self.shape} of float32 on cuda:{self._memory.card}>"
