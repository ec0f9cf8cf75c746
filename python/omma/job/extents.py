"""How large what is in a file is, in words, and what is odd about it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# What is so many metres long at most.
_LONG = (
    (0.05, "an insect or a leaf"), (0.5, "a thing on a table"), (3, "a shrub or a piece of ground"),
    (30, "a tree, a room or a plot"), (300, "a garden, a house or a field"),
    (10_000, "a landscape"), (np.inf, "a region"),
)  # fmt: skip
# Larger than this nobody models for an eye, in metres.
_ODD_M = 10_000.0
# A place is so much wider than high, where up is up.
_FLAT = 3.0


def describe_extent(size_m: NDArray[np.floating]) -> str:
    """Of a box (3,), m, along x, y and z: its size, what is so large, and whether it looks as if it
    were in millimetres or had +Z up."""
    x, y, z = (float(one) for one in size_m)
    longest = max(x, y, z)
    text = f"{size_words(size_m)}, as of {_word(longest)}"
    if longest > _ODD_M:
        small = longest / 1000
        text += f"; if it is in millimetres, {small:.4g} m, as of {_word(small)} "
        text += "(--unit mm; --scene-unit mm of a render)"
    if z * _FLAT < min(x, y):
        text += "; it is flat along z, as if +Z were up (--up z; --scene-up z of a render)"
    return text


def size_words(size_m: NDArray[np.floating]) -> str:
    """Lengths, m, along the axes."""
    return " x ".join(f"{float(one):.4g}" for one in size_m) + " m"


def _word(length_m: float) -> str:
    return next(word for most, word in _LONG if length_m <= most)
