"""Skies of every sun: twilight down to the night, which is in dark_skies.py."""

from __future__ import annotations

from datetime import datetime
from typing import Any

import numpy as np

from omma.base.arguments import checked, within
from omma.base.directions import direction
from omma.light.bands import Bands
from omma.light.dark_skies import night_sky, night_sky_at
from omma.light.haze_kinds import HazeKind
from omma.light.lights import Light, makes_light
from omma.light.moon_discs import bright_limb_deg
from omma.light.skies import clear_sky, moonlit_sky
from omma.light.sky_tables import LOWEST_SUN_DEG
from omma.light.sun_position import MoonPosition, moon_position, sun_position
from omma.light.units import Unit

# log10 of the illuminance of level ground, lux, by powers of elevation over 90 degrees, from -5 to
# -12 and from there to -18 degrees (Seidelmann, Explanatory Supplement to the Astronomical Almanac,
# 1992; Vallado, Fundamentals of Astrodynamics, table 5-1).
_CIVIL, _LATE = (2.70, 12.17, -431.69, -1899.83), (13.84, 262.72, 1447.42, 2797.93)
_LAST_DEG = -18.0
_MOST_PHASE_DEG = 150.0  # of a moon that counts


@checked
@makes_light
def natural_sky(
    sun_elevation_deg: float,
    *,
    sun_azimuth_deg: float = 0.0,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    height_m: float = 0.0,
    haze_kind: HazeKind = "rural",
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A clear sky of any sun, from noon over twilight to the night: `clear_sky` and `night_sky`.

    From -8 degrees down, where `clear_sky` ends, its sky is dimmed as the light on level ground is
    by night sky and sun in the Astronomical Almanac's supplement (Seidelmann 1992), less that at
    -18 degrees; its colours and its pattern stay. Below -18 degrees it is the night alone.

    Args:
        sun_elevation_deg: of the sun's centre, without refraction, -90 to 90.
        sun_azimuth_deg, aerosol, ozone_du, albedo, height_m, haze_kind, bands, unit: as of
            `clear_sky`.

    Raises:
        omma.Error: a number out of range.
    """
    within(sun_elevation_deg, "sun_elevation_deg", -90, 90)
    sunlit = clear_sky(
        max(sun_elevation_deg, LOWEST_SUN_DEG),
        sun_azimuth_deg=sun_azimuth_deg,
        aerosol=aerosol,
        ozone_du=ozone_du,
        albedo=albedo,
        height_m=height_m,
        haze_kind=haze_kind,
        bands=bands,
        unit=unit,
    )
    night = night_sky(albedo=albedo, bands=bands, unit=unit)
    share = twilight_share(sun_elevation_deg)
    return night if share == 0 else sunlit.scaled(share) + night


@checked
@makes_light
def natural_sky_at(
    date_time: datetime,
    latitude_deg: float,
    longitude_deg: float,
    *,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    height_m: float = 0.0,
    haze_kind: HazeKind = "rural",
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A clear sky at any time and place, where -Z is north: `clear_sky` with the sun where
    `sun_position` says, going over into `night_sky_at` as in `natural_sky`, and `moonlit_sky` with
    the moon where `moon_position` says. A moon whose phase angle is beyond 150 degrees, so that 7 %
    of it or less are lit, or more than 8 degrees below the horizon, is left out. Bright stars and
    planets are added by ``+ omma.light.stars(date_time, ...)``.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.
        aerosol, ozone_du, height_m, haze_kind: as of `clear_sky`, of what sun and moon light; the
            night's own glow is seen through its usual air.
        albedo, bands, unit: as of `clear_sky`.

    Example:
        >>> from datetime import date, timedelta
        >>> place = 52.5, 13.4
        >>> late = omma.light.dusk(date(2026, 8, 27), *place, "nautical") + timedelta(minutes=10)
        >>> few = omma.light.Bands.equal(4)
        >>> light = omma.light.natural_sky_at(late, *place, bands=few)
        >>> len(light.discs)    # the moon, a day before it is full
        1

    Raises:
        omma.Error: a time without a time zone or out of range, a latitude or longitude out of
            range, or PyEphem is not installed.
    """
    sun = sun_position(date_time, latitude_deg, longitude_deg)
    moon = moon_position(date_time, latitude_deg, longitude_deg)
    light = night_sky_at(
        date_time, latitude_deg, longitude_deg, albedo=albedo, bands=bands, unit=unit
    )
    air: dict[str, Any] = {"aerosol": aerosol, "ozone_du": ozone_du, "albedo": albedo}
    air |= {"height_m": height_m, "haze_kind": haze_kind, "bands": bands, "unit": unit}
    share = twilight_share(sun.elevation_deg)
    if share > 0:
        light = light + share * clear_sky(
            max(sun.elevation_deg, LOWEST_SUN_DEG),
            sun_azimuth_deg=sun.azimuth_deg,
            **air,
        )
    if not is_moonlit(moon):
        return light
    moonlit = moonlit_sky(
        moon.elevation_deg,
        moon_azimuth_deg=moon.azimuth_deg,
        phase_angle_deg=moon.phase_angle_deg,
        bright_limb_deg=bright_limb_deg(
            direction(moon.azimuth_deg, moon.elevation_deg),
            direction(sun.azimuth_deg, sun.elevation_deg),
        ),
        **air,
    )
    return light + moonlit


def is_moonlit(moon: MoonPosition) -> bool:
    """Whether a sky of `natural_sky_at` has the light of its moon."""
    return moon.elevation_deg >= LOWEST_SUN_DEG and abs(moon.phase_angle_deg) <= _MOST_PHASE_DEG


def twilight_share(sun_elevation_deg: float) -> float:
    """Of the twilight at -8 degrees, what there is under a sun at another elevation: 1 above it, 0
    from -18 degrees down."""
    if sun_elevation_deg >= LOWEST_SUN_DEG:
        return 1.0
    last = _lux(_LAST_DEG)
    return max(0.0, (_lux(sun_elevation_deg) - last) / (_lux(LOWEST_SUN_DEG) - last))


def _lux(elevation_deg: float) -> float:
    # The two polynomials differ by 2 % at -12 degrees; between -11.5 and -12.5 one goes over into
    # the other.
    powers = (max(elevation_deg, _LAST_DEG) / 90) ** np.arange(4)
    along = np.clip(-11.5 - elevation_deg, 0, 1)
    return float(10 ** ((1 - along) * (powers @ _CIVIL) + along * (powers @ _LATE)))
