"""Neutral points of skies, where nothing is polarised, and whose they are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats, Ints
from omma.base.directions import azimuth_elevation_deg_of, direction
from omma.light.lights import Light, is_made_by, is_under_water
from omma.light.nights import is_moonlit, twilight_share
from omma.light.sky_tables import LOWEST_SUN_DEG
from omma.light.sun_position import moon_position, sun_position

_PIXELS = 241  # across a sky, whose cells are searched
# A cell about a point, and a little around it, is cut into so many across, so often: to 0.004°.
_FINER, _ROUNDS = 6, 4
_MOST_LEFT = 0.01  # polarised of the light at a neutral point
# So much is polarised so far from a neutral point of a clear sky in ultraviolet and blue; less of
# hazy ones at long wavelengths, and in clouds.
_AROUND_DEG, _LEAST_AROUND = 6.0, 0.02
# From the sun or from the point opposite: of clear skies of all suns, bands and hazes that there
# are tables of, Babinet's are up to 28 degrees away, Brewster's up to 37 and Arago's up to 31.
_MOST_AWAY_DEG = 45.0
# Beside the meridian of whose they are: what a sky that is the same on both sides has on it is
# found to 0.01 degrees.
_MOST_BESIDE_DEG = 3.0

# "sun", "moon" or, of a disc of numbers, "", with azimuth and elevation, degrees.
Body = tuple[str, float, float]


def neutral_points(light: Light, band: int) -> list[tuple[str, Floats]]:
    """Where in the sky nothing is polarised: names and directions (3,).

    Of a sky of the sun or the moon alone those on its meridian, from the horizon below it over the
    zenith. Within 45° above it is Babinet's, below it Brewster's, above the point opposite Arago's;
    elsewhere, and under water, where the surface polarises too, "". Of a sky of both by night and
    in twilight all that there are; one on the meridian of either has its name with "of the sun" or
    "of the moon".

    A sky that is no longer as it was made may have clouds, in which polarisation is too weak to
    have a neutral point that anyone could see, though it still is 0 there; so have nights.
    """
    bodies = _bodies(light)
    if light.sky is None or light.sky.shape[3] == 1 or not bodies:
        return []
    # The light of a night hides that of a twilight that fades.
    is_changed = (
        light.recipe is None
        or len(bodies) > 1
        or bodies[0][2] < LOWEST_SUN_DEG
        or is_under_water(light)
        or is_made_by(light, "clouded", "plus")
    )
    found = []
    for towards in _zeros(light, band):
        places = [_on_meridian(towards, one) for one in bodies]
        beside = [abs(across) for _, across in places]
        if len(bodies) == 1 and beside[0] > _MOST_BESIDE_DEG:
            continue
        if is_changed and _polarised_around(light, band, towards) < _LEAST_AROUND:
            continue
        near = [k for k, one in enumerate(beside) if one <= _MOST_BESIDE_DEG]
        name = ""
        if len(near) == 1 and not is_under_water(light):
            whose, _, elevation = bodies[near[0]]
            along = places[near[0]][0]
            name = _name(along - elevation, 180 + elevation - along)
            name += f" of the {whose}" if name and len(bodies) > 1 else ""
        found.append((places[0][0], name, towards))
    found.sort(key=lambda one: one[0])
    return [(name, towards) for _, name, towards in found]


def _bodies(light: Light) -> list[Body]:
    """What lights a sky, the sun by day alone; also a sun that has set, of a sky made for it."""
    found = _all_bodies(light)
    up = [one for one in found if one[0] == "sun" and one[2] > 0]
    return list(dict.fromkeys(up or found))


def _all_bodies(light: Light) -> list[Body]:
    name, given = light.recipe or ("", {})
    parts = [one for one in given.values() if isinstance(one, Light)]
    if parts:
        turn = float(given["azimuth_deg"]) if name == "turned" else 0.0
        return [(who, a + turn, e) for part in parts for who, a, e in _all_bodies(part)]
    if name in ("clear_sky", "natural_sky"):
        azimuth = float(given.get("sun_azimuth_deg", 0))
        return [("sun", azimuth, float(given["sun_elevation_deg"]))]
    if name == "moonlit_sky":
        azimuth = float(given.get("moon_azimuth_deg", 0))
        return [("moon", azimuth, float(given["moon_elevation_deg"]))]
    if name == "natural_sky_at":
        at = given["date_time"], given["latitude_deg"], given["longitude_deg"]
        sun, moon = sun_position(*at), moon_position(*at)
        both = [("sun", sun.azimuth_deg, sun.elevation_deg)]
        both = both if twilight_share(sun.elevation_deg) > 0 else []
        return both + [("moon", moon.azimuth_deg, moon.elevation_deg)] * is_moonlit(moon)
    if light.sky is None or light.sky.shape[3] == 1 or not light.discs:
        return []
    towards = azimuth_elevation_deg_of(light.discs[0].direction)
    return [("", float(towards[0]), float(towards[1]))]


def _on_meridian(towards: Floats, body: Body) -> tuple[float, float]:
    """How far along a body's meridian, from the horizon below it, and beside it; degrees."""
    ahead, right = direction([body[1], body[1] + 90], 0)
    return (
        float(np.degrees(np.arctan2(towards[1], towards @ ahead))),
        float(np.degrees(np.arcsin(np.clip(towards @ right, -1, 1)))),
    )


def _name(from_body_deg: float, from_opposite_deg: float) -> str:
    """Of a neutral point so far up from what lights the sky, and from the point opposite to it."""
    if abs(from_body_deg) <= _MOST_AWAY_DEG:
        return "Babinet" if from_body_deg > 0 else "Brewster"
    return "Arago" if 0 < from_opposite_deg <= _MOST_AWAY_DEG else ""


def _zeros(light: Light, band: int) -> list[Floats]:
    """Directions of a sky where Q and U are both 0: about such a point the electric vector turns by
    half a turn or more, so that Q + iU goes round once about the corners of its cell."""
    span = np.linspace(-1, 1, _PIXELS)
    found = []
    for row, column in _turning(_on_map(light, band, span, span)[0]):
        x, y = span[column : column + 2], span[row : row + 2]
        for _ in range(_ROUNDS):
            # A point on an edge may be found in the cell beside.
            around = (x[1] - x[0]) / _FINER
            x, y = (np.linspace(one[0] - around, one[1] + around, _FINER + 1) for one in (x, y))
            inside = _turning(_on_map(light, band, x, y)[0])
            row, column = inside[0] if len(inside) else (_FINER // 2, _FINER // 2)
            x, y = x[column : column + 2], y[row : row + 2]
        middle = np.array([x.mean()]), np.array([y.mean()])
        if _on_map(light, band, *middle)[1][0, 0] <= _MOST_LEFT:
            found.append(_towards(*middle)[0, 0])
    return found


def _turning(z: NDArray[np.complex128]) -> Ints:
    """Rows and columns, (N, 2), of cells about whose corners (rows, columns) z turns."""
    along = np.angle(z[:, 1:] * z[:, :-1].conj())
    up = np.angle(z[1:] * z[:-1].conj())
    turned = along[:-1] + up[:, 1:] - along[1:] - up[:, :-1]
    known = np.isfinite(turned)
    return np.argwhere(known & (np.abs(np.where(known, turned, 0)) > np.pi))


def _on_map(light: Light, band: int, x: Floats, y: Floats) -> tuple[Any, Floats]:
    """Q + iU, (len(y), len(x)), by an axis that is the same all over the map, and the degree of
    polarisation; NaN below the horizon and where there is no polarised light."""
    stokes = light._radiance_of(_towards(x, y), [band])[..., 0]
    own = stokes[..., 1] + 1j * stokes[..., 2]
    unknown = (np.hypot(x, y[:, None]) > 1) | (own == 0)
    # Up is towards the middle of the map, right in its middle as from the north.
    turned = own * np.exp(-2j * np.arctan2(x, y[:, None]))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(unknown, np.nan, turned), np.abs(own) / stokes[..., 0]


def _towards(x: Floats, y: Floats) -> Floats:
    """Directions (len(y), len(x), 3) of a map: the horizon is 1 from its middle, the zenith."""
    east, north = np.meshgrid(x, y)
    above = np.maximum(90 - 90 * np.hypot(east, north), 0)
    return direction(np.degrees(np.arctan2(east, north)), above)


def _polarised_around(light: Light, band: int, towards: Floats) -> float:
    """The most that is polarised on the way to some degrees beside a direction; on half of all ways
    there is more."""
    azimuth = float(azimuth_elevation_deg_of(towards)[0])
    right = direction(azimuth + 90, 0.0)
    up = np.cross(right, towards)
    turn = (np.arange(16) + 0.5) * np.pi / 8
    out = np.radians(_AROUND_DEG) * np.array([1 / 3, 2 / 3, 1])[:, None, None]
    sideways = np.cos(turn)[:, None] * right + np.sin(turn)[:, None] * up
    beside = np.cos(out) * towards + np.sin(out) * sideways
    stokes = light._radiance_of(beside, [band])[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        degree = np.hypot(stokes[..., 1], stokes[..., 2]) / stokes[..., 0]
    degree = np.where(beside[..., 1] > 0, np.nan_to_num(degree), 0.0)
    return float(np.median(degree.max(axis=0)))
