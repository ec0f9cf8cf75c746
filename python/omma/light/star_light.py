"""The brightest stars and planets at a time and place, as discs so small that they are points."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from datetime import datetime
from typing import Any

import numpy as np

from omma.base.arguments import checked, within
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.light.bands import Bands
from omma.light.discs import Disc
from omma.light.lights import Light, makes_light
from omma.light.sky_tables import TableSky, check_range
from omma.light.sun_position import load_ephem, observer_at, universal
from omma.light.units import LIGHT_M_PER_S, PHOTONS_PER_JOULE_NM, PLANCK_J_S, Unit, check_unit

# Far smaller than any acceptance, and ten times what single precision tells from nothing.
RADIUS_RAD = 1e-5
# Magnitude 0 at 550 nm: 3640 Jy (Bessell 1979).
_VISUAL_NM, _MAGNITUDE_0_JY = 550.0, 3640.0
_BOLTZMANN_J_PER_K = 1.380649e-23
# B - V by spectral class, ten to a letter from O5 on; from G on of giants, as bright red stars are
# (Allen's Astrophysical Quantities, recalled; tests hold it to single stars).
_CLASSES = (5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65)
_COLOURS = (-0.33, -0.30, -0.17, -0.02, 0.15, 0.30, 0.44, 0.58, 0.86, 1.00, 1.50, 1.56, 1.63)
_BLUE_NM, _BLUE_0_JY = 440.0, 4260.0
# B - V of those that eyes see (Mallama, Krobusek and Pavlov, Icarus 282:19, 2017, recalled).
_PLANETS = {"Mercury": 0.97, "Venus": 0.81, "Mars": 1.43, "Jupiter": 0.87, "Saturn": 1.09}


@checked
@makes_light
def stars(
    date_time: datetime,
    latitude_deg: float,
    longitude_deg: float,
    *,
    faintest_magnitude: float = 3.0,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """The brightest stars and the planets, where -Z is north, without a sky: to be added to one.

    Stars are PyEphem's 108 of the Hipparcos catalogue, with all down to a visual magnitude of 1.6,
    few beyond 2.5; `night_sky_at` has all others, blurred. Planets are Mercury, Venus, Mars,
    Jupiter and Saturn, without moons, rings and the shape of their phase. Each is a disc of 4
    seconds of arc, a planet of its own size where that is more, so that ommatidia ask for it
    instead of finding it by chance; a hundred make a frame some five times as long. Its light is
    that of a black body with the colour (B - V) of its spectral class or of the planet (Mallama et
    al., Icarus 282:19, 2017, recalled), as strong at 550 nm as its magnitude says, behind
    `clear_sky`'s air (air mass by Kasten and Young, Applied Optics 28:4735, 1989); in the
    ultraviolet white stars are weaker than that.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.
        faintest_magnitude: stars and planets that are fainter are left out; -2 to 5.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Returns:
        A light of discs, the brightest first.

    Example:
        >>> from datetime import datetime, timezone
        >>> moment = datetime(2026, 1, 15, 22, tzinfo=timezone.utc)
        >>> few = omma.light.Bands.equal(4)
        >>> starry = omma.light.stars(moment, 52.5, 13.4, bands=few)
        >>> len(starry.discs)    # 54 stars and Jupiter
        55
        >>> night = omma.light.natural_sky_at(moment, 52.5, 13.4, bands=few) + starry

    Raises:
        omma.Error: a time without a time zone or out of range, a number out of range, bands out of
            300 to 700 nm, or PyEphem is not installed.
    """
    moment = universal(date_time)
    within(latitude_deg, "latitude_deg", -90, 90)
    within(longitude_deg, "longitude_deg", -180, 180)
    within(faintest_magnitude, "faintest_magnitude", -2, 5)
    bands = bands or Bands.equal()
    check_unit(unit)
    check_range(bands.wavelength_nm)
    observer = observer_at(moment, latitude_deg, longitude_deg)
    found = []
    for body, temperature in _bodies(observer):
        if body.alt <= 0 or body.mag > faintest_magnitude:
            continue
        elevation, azimuth = np.degrees(body.alt), np.degrees(body.az)
        radius = max(RADIUS_RAD, float(body.radius))

        def arriving(
            nm: Floats, mag: float = body.mag, k: float = temperature, e: float = elevation
        ) -> Floats:
            photons = star_photons(nm, mag, k) * np.exp(-air_mass(e) * air_depth(nm)[0])
            return photons if unit == "photons" else photons / (nm * PHOTONS_PER_JOULE_NM)

        radiance = bands.mean(arriving) / (np.pi * np.sin(radius) ** 2)
        found.append((body.mag, Disc(direction(azimuth, elevation), radius, radiance)))
    found.sort(key=lambda one: one[0])
    return Light(bands, unit, discs=tuple(disc for _, disc in found))


def star_photons(nm: Floats, magnitude: float, temperature: float) -> Floats:
    """Photons m^-2 s^-1 nm^-1 above the air of a black body with a visual magnitude."""
    of_zero = _MAGNITUDE_0_JY * 1e-26 / PLANCK_J_S / _VISUAL_NM
    shape = _planck_photons(nm, temperature) / _planck_photons(_VISUAL_NM, temperature)
    return np.asarray(of_zero * 10 ** (-0.4 * magnitude) * shape)


def _bodies(observer: Any) -> Iterator[tuple[Any, float]]:
    """PyEphem's stars and planets, seen by an observer, each with the temperature of its colour."""
    ephem = load_ephem()
    for name in _names():
        star = ephem.star(name, observer)
        yield star, temperature_k(star._spect)
    for name, colour in _PLANETS.items():
        yield getattr(ephem, name)(observer), temperature_of_colour_k(colour)


def temperature_k(spectral_class: str) -> float:
    """Of a black body with the colour of a class such as B8."""
    place = 10 * "OBAFGKM".index(spectral_class[0]) + int(spectral_class[1])
    return temperature_of_colour_k(float(np.interp(place, _CLASSES, _COLOURS)))


@functools.cache
def temperature_of_colour_k(colour: float) -> float:
    """Of a black body with a B - V, magnitudes."""
    kelvin = np.geomspace(1e5, 2e3, 400)
    return float(np.interp(colour, [black_body_colour(one) for one in kelvin], kelvin))


def black_body_colour(temperature: float) -> float:
    """B - V, magnitudes, between the middles of both bands."""
    nm = np.array([_BLUE_NM, _VISUAL_NM])
    blue, visual = _planck_photons(nm, temperature) * nm / (_BLUE_0_JY, _MAGNITUDE_0_JY)
    return float(-2.5 * np.log10(blue / visual))


def air_mass(elevation_deg: Floats | float) -> Floats:
    """Over that of the zenith (Kasten and Young 1989, recalled)."""
    e = np.asarray(elevation_deg, np.float64)
    return np.asarray(1 / (np.sin(np.radians(e)) + 0.50572 * (e + 6.07995) ** -1.6364))


def _planck_photons(nm: Floats | float, temperature: float) -> Floats:
    x = PLANCK_J_S * LIGHT_M_PER_S / (1e-9 * np.asarray(nm) * _BOLTZMANN_J_PER_K * temperature)
    return np.asarray(np.asarray(nm) ** -4.0 / np.expm1(x))


@functools.cache
def _air() -> tuple[Floats, Floats, Floats]:
    air = TableSky(90.0, 0.1, 300.0)
    nm = np.arange(300.0, 701.0)
    depth = -np.log(air.transmission(nm))
    ozone = 300.0 * np.interp(nm, air.table["fine_nm"], air.table["ozone_depth_per_du"])
    return nm, depth, depth - ozone


def air_depth(nm: Floats) -> tuple[Floats, Floats]:
    """Optical depth upwards of `clear_sky`'s air with its usual haze, and that of what scatters."""
    at, depth, scatters = _air()
    return np.interp(nm, at, depth), np.interp(nm, at, scatters)


@functools.cache
def _names() -> tuple[str, ...]:
    """One name of each of PyEphem's stars, some of which have two."""
    load_ephem()
    from ephem.stars import star, stars

    first: dict[tuple[float, float], str] = {}
    for name in sorted(stars):
        one = star(name)
        first.setdefault((round(one._ra, 6), round(one._dec, 6)), name)
    return tuple(first.values())
