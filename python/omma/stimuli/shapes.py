"""Surfaces that stimuli are made of, and how they are turned and placed.

A pattern on the sphere has a frame of its own, in which it drifts to the right about +Y: longitude
0 is ahead, towards -Z, and grows to the right. `drifted` turns that frame so that to the right
becomes the direction of motion asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.scene.paint import Surface
from omma.scene.solids import upright

# Radius of what lies on a sphere, m: so large that ommatidia's distances from the middle of the
# head, some millimetres, shift nothing by more than a tenth of a degree.
SPHERE_RADIUS_M = 2.0
# A mesh's squares, at most.
_STEP_DEG = 1.0


def sphere_patch(
    longitude_deg: tuple[float, float], latitude_deg: tuple[float, float]
) -> tuple[Surface, Floats]:
    """Part of a sphere of `SPHERE_RADIUS_M`, seen from within, and its vertices' longitude and
    latitude, degrees, (V, 2). Texture coordinates go from 0 to 1, v downwards."""
    (left, right), (low, high) = longitude_deg, latitude_deg
    columns = max(int(np.ceil((right - left) / _STEP_DEG)), 1)
    rows = max(int(np.ceil((high - low) / _STEP_DEG)), 1)
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    longitude, latitude = left + (right - left) * u, high - (high - low) * v
    # The first and the last column are the same to the last bit where they meet.
    closed = np.where((u == 1) & (right - left == 360), left, longitude)
    positions = SPHERE_RADIUS_M * directions_of(closed, latitude)
    corners = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    a, b = corners[:-1, :-1], corners[:-1, 1:]
    c, d = corners[1:, :-1], corners[1:, 1:]
    triangles = np.stack([np.stack([a, c, d], -1), np.stack([a, d, b], -1)], 2).reshape(-1, 3)
    flat = positions.reshape(-1, 3)
    edges = flat[triangles[:, 1:]] - flat[triangles[:, :1]]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    triangles = triangles[area > 1e-12]  # at a pole one of the two has none
    surface = flat, triangles, np.stack([u, v], -1).reshape(-1, 2)
    return surface, np.stack([longitude, latitude], -1).reshape(-1, 2)


def polygon_radius_m(radius_m: float, corners: int) -> float:
    """Of the corners of a regular polygon whose area is a circle's."""
    angle = 2 * np.pi / corners
    return float(radius_m * np.sqrt(angle / np.sin(angle)))


def directions_of(longitude_deg: Floats | float, latitude_deg: Floats | float) -> Floats:
    """(..., 3); exact at the poles and at longitude 0."""
    longitude, latitude = np.radians(longitude_deg), np.radians(latitude_deg)
    across = np.where(np.abs(latitude_deg) == 90, 0.0, np.cos(latitude))
    x, z = across * np.sin(longitude), -across * np.cos(longitude)
    return np.stack(np.broadcast_arrays(x, np.sin(latitude), z), -1)


def drifted(drift_deg: Floats, direction_deg: float) -> Floats:
    """``world_from_pattern`` (T, 4, 4) of a pattern that has drifted by so many degrees (T,).

    Args:
        direction_deg: where to, as seen ahead: 0 is to the right, 90 upwards.
    """
    angle = np.radians(drift_deg)
    transforms = np.zeros((len(drift_deg), 4, 4))
    # To the right is about -Y.
    transforms[:, 0, 0] = transforms[:, 2, 2] = np.cos(angle)
    transforms[:, 0, 2], transforms[:, 2, 0] = -np.sin(angle), np.sin(angle)
    transforms[:, 1, 1] = transforms[:, 3, 3] = 1
    return np.asarray(roll(direction_deg) @ transforms)


def roll(direction_deg: float) -> Floats:
    """(4, 4), which turns +X towards +Y, so that what went to the right goes that way."""
    angle = np.radians(direction_deg)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return turn


def longitude_latitude_deg(
    directions: Floats, drift_deg: float, direction_deg: float
) -> tuple[Floats, Floats]:
    """Where in the pattern's frame directions (..., 3) of the world lie, by how much it drifted."""
    x, y, z = np.moveaxis(
        directions @ drifted(np.array([drift_deg]), direction_deg)[0, :3, :3], -1, 0
    )
    return np.degrees(np.arctan2(x, -z)), np.degrees(np.arctan2(y, np.hypot(x, z)))


def facing_origin(directions: Floats, distance_m: Floats) -> Floats:
    """Transforms (T, 4, 4) to directions (T, 3) from which +Z looks at the origin."""
    transforms = np.zeros((len(directions), 4, 4))
    z = -directions
    # Up is +Y, or -Z for what is straight above or below.
    steep = np.hypot(z[:, 0], z[:, 2]) < 1e-9
    above = np.where(steep[:, None], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0])
    x = np.cross(above, z)
    x = normalized(x)
    transforms[:, :3, 0], transforms[:, :3, 1], transforms[:, :3, 2] = x, np.cross(z, x), z
    transforms[:, :3, 3] = distance_m[:, None] * directions
    transforms[:, 3, 3] = 1
    return transforms


def grey(row: NDArray[np.float64]) -> NDArray[np.float32]:
    """A picture (H, W, 3) of radiances (W,) or (H, W), linear."""
    picture = np.atleast_2d(row).astype(np.float32)
    return np.repeat(picture[..., None], 3, axis=2)


def polygon(radius_m: float, corners: int) -> tuple[Floats, NDArray[np.int64]]:
    """A regular one around the origin that faces +Z: positions (V, 3) and triangles (T, 3)."""
    angle = 2 * np.pi * np.arange(corners) / corners
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(corners)], -1)
    here = 1 + np.arange(corners)
    triangles = np.stack([np.zeros(corners, int), here, 1 + here % corners], -1)
    return radius_m * np.concatenate([np.zeros((1, 3)), rim]), triangles


def right_and_up(center_m: Floats) -> tuple[Floats, Floats]:
    """Directions along a plane that looks at the origin from its middle (3,): to the right and
    upwards as seen in front.

    Of one whose middle lies more than 45° above or below the horizon as a head has them that looks
    ahead: +x to the right and ahead, -z along the plane, alike for a ceiling and the ground.
    """
    x, y, z = center_m
    facing = -center_m / np.linalg.norm(center_m)
    if abs(y) <= np.hypot(x, z):
        return upright(facing)
    ahead = normalized(np.array([0.0, 0.0, -1.0]) + facing[2] * facing)
    return np.cross(ahead, -np.sign(y) * facing), ahead
