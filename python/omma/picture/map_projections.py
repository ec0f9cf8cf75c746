"""Where directions are on maps of the whole sphere, and back: Mercator, Mollweide, Lambert."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from omma.base.arrays import Floats

Projection = Literal["mercator", "mollweide", "lambert"]
PROJECTIONS: tuple[Projection, ...] = ("mercator", "mollweide", "lambert")

MERCATOR_EDGE = math.radians(80)  # beyond, a degree is stretched more than six times
#: Half the width and half the height of each map.
MAP_HALVES: dict[Projection, tuple[float, float]] = {
    "mercator": (math.pi, math.atanh(math.sin(MERCATOR_EDGE))),
    "mollweide": (2 * math.sqrt(2), math.sqrt(2)),
    "lambert": (2.0, 2.0),
}


def project_directions(directions: Floats, projection: Projection) -> Floats:
    """Where directions (..., 3) in the head's frame, are on a map: (..., 2).

    Mercator: x is the azimuth, y the isometric latitude; Mollweide: x to 2√2, y to √2; Lambert's
    azimuthal equal-area map about straight ahead: the rim, at radius 2, is straight behind (all as
    in J. P. Snyder 1987, USGS Professional Paper 1395).
    """
    x, y, z = np.moveaxis(directions, -1, 0)
    azimuth, elevation = np.arctan2(x, -z), np.arcsin(np.clip(y, -1, 1))
    if projection == "mercator":
        return np.stack([azimuth, np.arctanh(np.clip(y, -1 + 1e-12, 1 - 1e-12))], axis=-1)
    if projection == "mollweide":
        theta = _mollweide_angle(elevation)
        across = 2 * math.sqrt(2) / math.pi * azimuth * np.cos(theta)
        return np.stack([across, math.sqrt(2) * np.sin(theta)], axis=-1)
    stretch = np.sqrt(2 / np.maximum(1 - z, 1e-12))
    return np.stack([stretch * x, stretch * y], axis=-1)


def map_directions(projection: Projection, x: Floats, y: Floats) -> Floats:
    """The directions at points of a map, (..., 3); NaN outside the map."""
    if projection == "mercator":
        azimuth, elevation = x, np.arctan(np.sinh(y))
        good = (np.abs(azimuth) <= np.pi) & (np.abs(elevation) <= MERCATOR_EDGE)
    elif projection == "mollweide":
        sine = np.clip(y / math.sqrt(2), -1, 1)
        theta = np.arcsin(sine)
        level = np.maximum(np.cos(theta), 1e-12)
        azimuth = math.pi * x / (2 * math.sqrt(2) * level)
        elevation = np.arcsin(np.clip((2 * theta + np.sin(2 * theta)) / math.pi, -1, 1))
        good = (np.abs(azimuth) <= np.pi) & (np.abs(y) <= math.sqrt(2))
    else:
        squared = x**2 + y**2
        stretch = np.sqrt(np.maximum(1 - squared / 4, 0))
        directions = np.stack([stretch * x, stretch * y, squared / 2 - 1], axis=-1)
        return np.where((squared <= 4)[..., None], directions, np.nan)
    level = np.cos(elevation)
    directions = np.stack(
        [level * np.sin(azimuth), np.sin(elevation), -level * np.cos(azimuth)], axis=-1
    )
    return np.where(good[..., None], directions, np.nan)


def _mollweide_angle(elevation: Floats) -> Floats:
    # Newton's method for 2θ + sin 2θ = π sin(elevation); from θ = elevation it needs few steps but
    # near the poles, where it halves the error each time.
    theta = np.array(elevation, dtype=np.float64)
    wanted = math.pi * np.sin(elevation)
    for _ in range(40):
        slope = np.maximum(2 + 2 * np.cos(2 * theta), 1e-9)
        theta = np.clip(
            theta - (2 * theta + np.sin(2 * theta) - wanted) / slope, -np.pi / 2, np.pi / 2
        )
    return theta
