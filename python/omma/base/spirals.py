"""Spirals whose points are a golden angle on from each other, which spread evenly (Vogel 1979, Math
Biosci 44:179)."""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats

GOLDEN_ANGLE_RAD = np.pi * (3 - np.sqrt(5))


def golden_angles(count: int) -> Floats:
    """Angles (count,), rad, each a golden angle on from the last; from `GOLDEN_ANGLE_RAD` times
    numbers they differ by rounding, on which the bits of results depend."""
    return np.asarray(np.arange(count) * np.pi * (3 - np.sqrt(5)))


def golden_angles_back(count: int) -> Floats:
    """Angles (count,), rad, each a golden angle back from the last, or 2π times the golden ratio
    on; half of that to the first."""
    steps = np.arange(count, dtype=np.float64) + 0.5
    return np.asarray(np.pi * (1 + np.sqrt(5)) * steps)


def fibonacci_lattice(turn_rad: Floats) -> Floats:
    """Directions (N, 3), each for the same solid angle, from +Z to -Z, turned about Z by angles
    (N,) from +X, of which each is a golden angle from the last."""
    count = len(turn_rad)
    height = 1 - (2 * np.arange(count) + 1) / count
    level = np.sqrt(1 - height**2)
    return np.column_stack([level * np.cos(turn_rad), level * np.sin(turn_rad), height])
