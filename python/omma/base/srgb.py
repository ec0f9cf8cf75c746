"""The curve of sRGB (IEC 61966-2-1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def linear_of_srgb(value: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    """Linear light of sRGB values, 0 to 1, of the same type; above 1 it goes on as there."""
    low, high = value / 12.92, ((np.maximum(value, 0) + 0.055) / 1.055) ** 2.4
    return np.where(value <= 0.04045, low, high)


def srgb_of_linear(value: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    """sRGB values of linear light, 0 to 1: the way back."""
    low, high = value * 12.92, 1.055 * np.maximum(value, 0) ** (1 / 2.4) - 0.055
    return np.where(value <= 0.0031308, low, high)
