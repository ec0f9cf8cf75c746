"""The lit part of the moon, as discs that make it up."""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats
from omma.base.directions import direction, normalized
from omma.light.discs import Disc

MOON_RADIUS_RAD = float(np.radians(0.518 / 2))  # at its mean distance
_MOST_STRIPS, _POINTS = 5, 801


def bright_limb_deg(moon: Floats, sun: Floats) -> float:
    """Which way from the moon's middle its limb is brightest, towards the sun: degrees from up,
    turning to the right as one looks at it. Both are directions (3,)."""
    up = normalized(np.array([0.0, 1.0, 0.0]) - moon[1] * moon)
    right = np.cross(moon, up)
    return float(np.degrees(np.arctan2(sun @ right, sun @ up)))


def moon_discs(
    azimuth_deg: float,
    elevation_deg: float,
    phase_angle_deg: float,
    bright_limb_deg: float | None,
    facing: Floats,
) -> tuple[Disc, ...]:
    """Discs that together give so much (B,) to what faces the moon: the whole one, even, if it is
    not said where its limb is bright, else one to five."""
    middle = direction(azimuth_deg, elevation_deg)
    if bright_limb_deg is None:
        return (_disc(middle, MOON_RADIUS_RAD, facing),)
    # A quarter turn up, which is one down and back where it leads past the zenith.
    up = (
        direction(azimuth_deg, elevation_deg + 90)
        if elevation_deg < 0
        else -direction(azimuth_deg, elevation_deg - 90)
    )
    right = np.cross(middle, up)
    turn = np.radians(bright_limb_deg)
    to_limb = np.cos(turn) * up + np.sin(turn) * right
    along = np.cross(middle, to_limb)
    found = []
    for share, radius, x, y in lit_strips(abs(phase_angle_deg)):
        towards = normalized(middle + np.sin(MOON_RADIUS_RAD) * (x * to_limb + y * along))
        found.append(_disc(towards, MOON_RADIUS_RAD * radius, share * facing))
    return tuple(found)


def lit_strips(phase_angle_deg: float) -> list[tuple[float, float, float, float]]:
    """The lit part in strips across its length, about as long as wide: share of its light, and over
    the moon's radius that of an even disc as spread out, and its centroid, towards the bright limb
    and across.

    The surface scatters by Lommel and Seeliger's law, cos i / (cos i + cos e), which is even for a
    full moon, as it is (Hapke, Theory of Reflectance and Emittance Spectroscopy, recalled).
    """
    side = np.linspace(-1, 1, _POINTS)
    x, y = np.meshgrid(side, side)
    toward_us = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    phase = np.radians(phase_angle_deg)
    toward_sun = toward_us * np.cos(phase) + x * np.sin(phase)
    lit = (toward_us > 0) & (toward_sun > 0)
    light = np.where(lit, toward_sun / np.where(lit, toward_sun + toward_us, 1), 0.0)
    count = int(np.clip(np.round(2 / (1 + np.cos(phase))), 1, _MOST_STRIPS))
    strip = np.minimum(((side + 1) / 2 * count).astype(np.int64), count - 1)
    found = []
    for k in range(count):
        rows = strip == k
        share = float(light[rows].sum() / light.sum())
        own = light[rows] / light[rows].sum()
        at_x, at_y = float(own.sum(axis=0) @ side), float(own.sum(axis=1) @ side[rows])
        spread = float(own.sum(axis=0) @ (side - at_x) ** 2)
        spread += float(own.sum(axis=1) @ (side[rows] - at_y) ** 2)
        # Of an even disc the mean square distance from its middle is half its radius squared.
        found.append((share, float(np.sqrt(2 * spread)), at_x, at_y))
    return found


def _disc(towards: Floats, radius_rad: float, facing: Floats) -> Disc:
    radiance = np.asarray(facing, np.float64) / (np.pi * np.sin(radius_rad) ** 2)
    return Disc(towards, radius_rad, radiance)
