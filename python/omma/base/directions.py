"""Directions as vectors of length 1 in the head's frame, and as azimuth and elevation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, arrays_of, checked
from omma.base.arrays import Floats


@checked
def direction(azimuth_deg: ArrayLike, elevation_deg: ArrayLike) -> Floats:
    """Directions (..., 3) of length 1 in the head frame; azimuth 0 is ahead and grows to the
    right. Elevations are -90 to 90.

    Raises:
        omma.Error: an elevation beyond these, or what is no number.
    """
    azimuth, elevation = arrays_of(azimuth_deg=azimuth_deg, elevation_deg=elevation_deg)
    beyond = np.abs(elevation) > 90 + 1e-6  # 90 is what rounding may leave a little more of
    if beyond.any():
        raise Error(f"elevation_deg: expected -90 to 90, found {elevation[beyond].flat[0]:.6g}")
    a, e = np.radians(azimuth), np.radians(elevation)
    return np.stack([np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)], axis=-1)


@checked
def azimuth_elevation_deg_of(directions: ArrayLike) -> tuple[Floats, Floats]:
    """Azimuth (-180 to 180) and elevation of directions (..., 3), degrees."""
    vectors = array_of(directions, "directions", (..., 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    # Adding 0 turns -0 into 0.
    return np.degrees(np.arctan2(x, -z)) + 0.0, np.degrees(np.arctan2(y, np.hypot(x, z))) + 0.0


def angle_of_chord(length: Floats | float) -> Floats:
    """The angle, rad, between directions whose points on the unit sphere are so far apart."""
    # By rounding that may be more than 2.
    return np.asarray(2 * np.arcsin(np.minimum(length / 2, 1)))


def normalized(vectors: Floats) -> Floats:
    """Vectors (..., 3) at length 1."""
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    # To the bits of `np.linalg.norm`, whose sums along so short an axis are slow.
    return np.asarray(vectors / np.sqrt(x * x + y * y + z * z)[..., None])


def tangents(axis: Floats) -> tuple[Floats, Floats]:
    """Two directions across an axis (3,) and each other."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    right = np.cross(helper, axis)
    right /= np.linalg.norm(right)
    return right, np.cross(axis, right)
