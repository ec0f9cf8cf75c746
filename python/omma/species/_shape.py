"""What the models have in common: blends over directions, fields of view, ellipsoids."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from omma._core import Acceptance, Eye
from omma.base.arrays import Floats
from omma.base.directions import azimuth_elevation_deg_of, direction
from omma.base.progress import Stage
from omma.eye.facets import facet_diameters_m, set_facets
from omma.eye.lattice import lay_directions
from omma.eye.on_surface import eye_on_surface
from omma.eye.skew import squeezed
from omma.eye.surfaces import ellipsoid
from omma.species.facts import number


def smooth_step(x: Floats, low: float, high: float) -> Floats:
    """0 below ``low``, 1 above ``high``, a cubic between."""
    fraction = np.clip((x - low) / (high - low), 0.0, 1.0)
    return np.asarray(fraction * fraction * (3 - 2 * fraction))


def blended(first: float | Floats, second: float | Floats, fraction: Floats) -> Floats:
    """From ``first`` (share 0) to ``second`` (share 1), evenly on a logarithmic scale."""
    return np.asarray(np.exp((1 - fraction) * np.log(first) + fraction * np.log(second)))


def angle_from(directions: Floats, azimuth_deg: float, elevation_deg: float) -> Floats:
    """Angles (K,) between directions (K, 3) and the one given, radians."""
    towards = direction(azimuth_deg, elevation_deg)
    # Near 0 the cosine alone would lose half the digits.
    across = np.linalg.norm(np.cross(directions, towards), axis=1)
    return np.asarray(np.arctan2(across, directions @ towards))


def elevation_rad(directions: Floats) -> Floats:
    """Elevation (K,) of directions (K, 3)."""
    return np.asarray(np.radians(azimuth_elevation_deg_of(directions)[1]))


def oval(
    azimuth_deg: tuple[float, float], elevation_deg: tuple[float, float]
) -> Callable[[Floats], NDArray[np.bool_]]:
    """A field of view with a smooth outline: an ellipse in azimuth and elevation."""
    middle = np.array([sum(azimuth_deg) / 2, sum(elevation_deg) / 2])
    half = np.array([azimuth_deg[1] - azimuth_deg[0], elevation_deg[1] - elevation_deg[0]]) / 2

    def seen(directions: Floats) -> NDArray[np.bool_]:
        azimuth, elevation = azimuth_elevation_deg_of(directions)
        across = (azimuth - middle[0] + 180) % 360 - 180
        inside = (across / half[0]) ** 2 + ((elevation - middle[1]) / half[1]) ** 2 <= 1
        return np.asarray(inside, dtype=bool)

    return seen


def on_ellipsoid(
    animal: str,
    axis: Floats,
    towards_deg: tuple[float, float],
    facet: str,
    fraction: float = 0.5,
    angle_at: Callable[[Floats], Floats] | None = None,
) -> Eye:
    """A right eye of these axes (N, 3), its lenses on an ellipsoid that spans less than the axes.

    A lens sits on the unit sphere where its axis is, but ``surface_squeeze`` times as far from
    ``towards_deg`` (azimuth, elevation); the sphere is then stretched to the table's shape. Its
    size follows from the facets: the quantile ``fraction`` of the diameters is the table's
    ``facet``. With ``angle_at``, relative angles between axes over the angle from ``towards_deg``,
    positions are squeezed more where those are wide, so that facets differ less than angles do.
    """
    shape, centre = (
        np.array([number(animal, f"eye_{what}_{way}") for way in ("right", "up", "forward")])
        for what in ("shape", "centre")
    )
    centre = centre * [1.0, 1.0, -1.0]
    towards, squeeze = direction(*towards_deg), number(animal, "surface_squeeze")
    normal = squeezed(towards, squeeze)
    if angle_at is not None:
        normal = _evened(towards, squeeze, angle_at, float(np.arccos(axis @ towards).max()))
    # The ellipsoid's normal at the stretched point p is along p over the shape's squares.
    eye = eye_on_surface(
        axis, ellipsoid((shape * 1e-3).tolist()), normal=lambda axes: normal(axes) / shape, eye_id=1
    )
    size = number(animal, facet) / np.quantile(facet_diameters_m(eye), fraction)
    return set_facets(eye.replace(position_m=centre + size * eye.position_m))


def _evened(
    towards: Floats, squeeze: float, angle_at: Callable[[Floats], Floats], most_rad: float
) -> Callable[[Floats], Floats]:
    # The normal's angle grows by 1/Δφ per angle of the axis, to ``squeeze`` times the most.
    grid = np.linspace(0.0, most_rad, 1001)
    slope = 1 / angle_at(grid)
    turned = np.concatenate([[0.0], np.cumsum(slope[1:] + slope[:-1])])
    turned *= squeeze * most_rad / turned[-1]

    def normal(directions: Floats) -> Floats:
        along = directions @ towards
        across = directions - along[:, None] * towards
        size = np.linalg.norm(across, axis=1)
        angle = np.interp(np.arctan2(size, along), grid, turned)
        across /= np.maximum(size, 1e-300)[:, None]
        return np.asarray(np.cos(angle)[:, None] * towards + np.sin(angle)[:, None] * across)

    return normal


def graded(width_rad: Floats, levels: int = 64) -> list[Acceptance]:
    """Gaussians of these widths (N,), in at most ``levels`` classes of equal ratio."""
    low, high = float(width_rad.min()), float(width_rad.max())
    if high / low < 1 + 1e-9:
        return [Acceptance.gaussian(low)] * len(width_rad)
    step = math.log(high / low) / (levels - 1)
    kind = np.round(np.log(width_rad / low) / step).astype(int)
    classes = [Acceptance.gaussian(low * math.exp(step * k)) for k in range(levels)]
    return [classes[k] for k in kind]


def degrees(animal: str, quantity: str) -> float:
    """A number of the table that is an angle, in degrees."""
    return float(np.degrees(number(animal, quantity)))


def laid(
    animal: str,
    horizontal_rad: Callable[[Floats], Floats],
    vertical_rad: Callable[[Floats], Floats] | None,
    field_of_view: Callable[[Floats], NDArray[np.bool_]],
    progress: Stage | None = None,
    count: str = "ommatidia",
) -> Floats:
    """Directions (N, 3) of a right eye with as many ommatidia as the table says."""
    return lay_directions(
        horizontal_rad,
        vertical_rad,
        field_of_view=field_of_view,
        count=round(number(animal, count)),
        progress=progress,
    ).directions
