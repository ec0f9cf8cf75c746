"""Glitter and mirrored skies of waves, computed from their slopes: independent of the engine."""

import numpy as np

N = 1.34
SUN_RAD, SUN_RADIANCE = float(np.radians(0.533 / 2)), 1e5


def shares(cosine):
    """R_s and R_p from above, by Fresnel's formulas in angles."""
    air = np.arccos(np.clip(cosine, 0, 1 - 1e-12))
    inside = np.arcsin(np.sin(air) / N)
    return (np.sin(air - inside) / np.sin(air + inside)) ** 2, (
        np.tan(air - inside) / np.tan(air + inside)
    ) ** 2


def mirrored(cosine):
    return sum(shares(cosine)) / 2


def towards(elevation_deg, azimuth_deg=0.0):
    """Unit vectors (..., 3), azimuth from -Z to +X."""
    e, a = np.radians(elevation_deg), np.radians(azimuth_deg)
    return np.stack(
        np.broadcast_arrays(np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)), axis=-1
    )


def by_slopes(viewer, light, mean_square, *, normal=False):
    """Radiance of glitter for light of irradiance 1 across its way, per sr: of facets whose slopes
    follow GGX and that hide each other, or of normally distributed ones that do not (Cox and Munk
    1954). Directions (..., 3)."""
    half = viewer + light
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    up = half[..., 1]
    slope2 = 1 / up**2 - 1
    if normal:
        density, seen = np.exp(-slope2 / mean_square) / (np.pi * mean_square), 1.0
    else:
        density = 1 / (np.pi * mean_square * (1 + slope2 / mean_square) ** 2)
        hidden = [
            (np.sqrt(1 + mean_square * (1 / one[..., 1] ** 2 - 1)) - 1) / 2
            for one in (viewer, light)
        ]
        seen = 1 / (1 + hidden[0] + hidden[1])
    fresnel = mirrored((half * light).sum(axis=-1))
    return np.where(light[..., 1] > 0, fresnel * density * seen / (4 * viewer[..., 1] * up**4), 0)


def hemisphere(rows=400, columns=200):
    """Directions above the horizon and solid angles, even in the sine of elevation."""
    sine = (np.arange(rows) + 0.5) / rows
    azimuth = (np.arange(columns) + 0.5) / columns * 360
    return towards(np.degrees(np.arcsin(sine))[:, None], azimuth), 2 * np.pi / rows / columns


def on_sun(elevation_deg, steps=10):
    """Directions all over the sun's disc, even by area, (steps, steps, 3)."""
    out = SUN_RAD * np.sqrt((np.arange(steps) + 0.5) / steps)[:, None]
    turn = 2 * np.pi * (np.arange(steps) + 0.5) / steps
    middle = towards(elevation_deg)
    side, up = np.array([1.0, 0, 0]), np.cross([1.0, 0, 0], middle)
    points = middle + np.tan(out)[..., None] * (
        np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * up
    )
    return points / np.linalg.norm(points, axis=-1, keepdims=True)


def glitter(viewers, sun_deg, mean_square, **how):
    """Radiance of glitter (K,) for a sun ahead at an elevation, seen from `viewers` (K, 3)."""
    across = SUN_RADIANCE * np.pi * np.sin(SUN_RAD) ** 2
    points = on_sun(sun_deg)
    return across * np.array([by_slopes(one, points, mean_square, **how).mean() for one in viewers])


def half_width(angle_deg, radiance):
    """Where it has fallen to half of its first value."""
    k = int(np.argmax(radiance < radiance[0] / 2))
    return float(np.interp(-radiance[0] / 2, -radiance[k - 1 : k + 1], angle_deg[k - 1 : k + 1]))
