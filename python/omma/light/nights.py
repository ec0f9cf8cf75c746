"""Skies of the night and of every sun: what glows without sun and moon, and twilight down to it."""

from __future__ import annotations

from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from omma.base.arguments import checked, within
from omma.light.bands import Bands
from omma.light.lights import Light, makes_light
from omma.light.skies import clear_sky, moonlit_sky
from omma.light.sky_map import level_weights, sky_nodes
from omma.light.sky_tables import LOWEST_SUN_DEG, TableSky, check_range
from omma.light.sun_position import moon_position, sun_position
from omma.light.units import PHOTONS_PER_JOULE_NM, PLANCK_J_S, Unit, check_unit

Floats = NDArray[np.float64]

# Of a moonless zenith: effective wavelength, nm, the flux of magnitude 0, Jy (Bessell 1979), and
# magnitudes per square second of arc (Benn and Ellison 1998, La Palma, at sunspot minimum).
_BRIGHTNESS = ((360, 1810, 22.0), (440, 4260, 22.7), (550, 3640, 21.9), (640, 3080, 21.0),
               (790, 2550, 20.0))  # fmt: skip
# Below, where they have only few data, as their spectrum is extrapolated for telescopes of
# Cherenkov light: photons m^-2 s^-1 sr^-1 nm^-1.
_ULTRAVIOLET = ((300, 1e6), (315, 6.12e8), (330, 1.95e9))
# 1e-26 W m^-2 Hz^-1 in photons m^-2 s^-1 for each interval of 1 of the wavelength's logarithm.
_PHOTONS_PER_JY = 1e-26 / PLANCK_J_S
_SQUARE_SECONDS_PER_SR = (180 * 3600 / np.pi) ** 2

# log10 of the illuminance of level ground, lux, by powers of elevation over 90 degrees, from -5 to
# -12 and from there to -18 degrees (Seidelmann, Explanatory Supplement to the Astronomical Almanac,
# 1992; Vallado, Fundamentals of Astrodynamics, table 5-1).
_CIVIL, _LATE = (2.70, 12.17, -431.69, -1899.83), (13.84, 262.72, 1447.42, 2797.93)
_LAST_DEG = -18.0


@checked
@makes_light
def night_sky(*, albedo: float = 0.1, bands: Bands | None = None, unit: Unit = "photons") -> Light:
    """A clear sky without sun, moon and lamps: what the air, dust between the planets and stars too
    faint to be told from each other send, unpolarised.

    As measured in the zenith far from the Milky Way and the zodiac at sunspot minimum, U 22.0, B
    22.7, V 21.9, R 21.0 magnitudes per square second of arc (Benn and Ellison, La Palma Technical
    Note 115, 1998); at sunspot maximum and near the zodiac it is 1.4 times as bright (`scaled`).
    Lower down it is brighter as a layer's glow seen aslant and dimmed by the air before it:
    X exp(-t (X - 1)), X = (1 - 0.96 cos² e)^(-1/2) (Krisciunas and Schaefer, PASP 103:1033, 1991),
    with t of `clear_sky`'s air. Below 330 nm it is extrapolated. Lines of airglow are spread out.

    Args:
        albedo: share of light that the land around gives back, 0 to 1.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Example:
        >>> night = omma.light.night_sky(bands=omma.light.Bands.from_edges([540, 560]))
        >>> f"{night.radiance((0, 1, 0))[0, 0]:.1e}"
        '7.4e+09'

    Raises:
        omma.Error: an albedo out of range, or bands out of 300 to 700 nm.
    """
    bands = bands or Bands.equal()
    check_unit(unit)
    within(albedo, "albedo", 0, 1)
    check_range(bands.wavelength_nm)
    rows = 91
    sine = np.sin(sky_nodes(rows, 4)[0][0])
    slant = (1 - 0.96 * (1 - sine**2)) ** -0.5
    air = TableSky(90.0, 0.1, 300.0)

    def towards(nm: Floats) -> Floats:
        zenith = _zenith_photons(nm)
        if unit == "watts":
            zenith = zenith / (nm * PHOTONS_PER_JOULE_NM)
        depth = -np.log(air.transmission(nm))
        return np.asarray((zenith * slant[:, None] * np.exp(-depth * (slant[:, None] - 1))).T)

    above = bands.mean(towards).T
    sky = np.empty((2, rows, 4, 1, len(bands)), np.float32)
    sky[0, :, :, 0] = above[:, None]
    sky[1] = albedo / np.pi * 4 * (level_weights(rows, 4) @ above)
    return Light(bands, unit, sky)


@checked
@makes_light
def natural_sky(
    sun_elevation_deg: float,
    *,
    sun_azimuth_deg: float = 0.0,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A clear sky of any sun, from noon over twilight to the night: `clear_sky` and `night_sky`.

    From -8 degrees down, where `clear_sky` ends, its sky is dimmed as the light on level ground is
    by night sky and sun in the Astronomical Almanac's supplement (Seidelmann 1992), less that at
    -18 degrees; its colours and its pattern stay. Below -18 degrees it is the night alone.

    Args:
        sun_elevation_deg: of the sun's centre, without refraction, -90 to 90.
        sun_azimuth_deg, aerosol, ozone_du, albedo, bands, unit: as of `clear_sky`.

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
        bands=bands,
        unit=unit,
    )
    night = night_sky(albedo=albedo, bands=bands, unit=unit)
    share = twilight_share(sun_elevation_deg)
    return night if share == 0 else sunlit.scaled(share) + night


@checked
def natural_sky_at(
    date_time: datetime,
    latitude_deg: float,
    longitude_deg: float,
    *,
    albedo: float = 0.1,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A clear sky at any time and place, where -Z is north: `natural_sky` with the sun where
    `sun_position` says, and `moonlit_sky` with the moon where `moon_position` says. Bright stars
    are added by ``+ omma.light.stars(date_time, ...)``.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.
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
    light = natural_sky(
        sun.elevation_deg, sun_azimuth_deg=sun.azimuth_deg, albedo=albedo, bands=bands, unit=unit
    )
    if moon.elevation_deg < LOWEST_SUN_DEG or abs(moon.phase_angle_deg) > 150:
        return light
    moonlit = moonlit_sky(
        moon.elevation_deg,
        moon_azimuth_deg=moon.azimuth_deg,
        phase_angle_deg=moon.phase_angle_deg,
        albedo=albedo,
        bands=bands,
        unit=unit,
    )
    return light + moonlit


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


def _zenith_photons(nm: Floats) -> Floats:
    known = [*_ULTRAVIOLET]
    for at, jansky, magnitudes in _BRIGHTNESS:
        flux = jansky * 10 ** (-0.4 * magnitudes) * _PHOTONS_PER_JY / at
        known.append((at, flux * _SQUARE_SECONDS_PER_SR))
    at, photons = np.transpose(known)
    return np.asarray(np.exp(np.interp(nm, at, np.log(photons))))
