"""Clear nights without sun, moon and lamps: as measured far from the Milky Way, and by time and
place with the Milky Way and the zodiacal light.
"""

from __future__ import annotations

from datetime import datetime

import numpy as np

from omma.base.arguments import checked, within
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.light.bands import Bands
from omma.light.lights import Light, makes_light
from omma.light.sky_map import level_weights, sky_nodes
from omma.light.sky_stored import sun_spectrum
from omma.light.sky_tables import TableSky, check_range
from omma.light.star_light import air_depth, air_mass
from omma.light.star_maps import (
    ECLIPTIC_FROM_EQUATORIAL,
    GALACTIC_FROM_EQUATORIAL,
    ZODIACAL_POLE_S10,
    equatorial_from_horizon,
    starlight_s10,
    sun_longitude_rad,
    zodiacal_s10,
)
from omma.light.sun_position import universal
from omma.light.units import PHOTONS_PER_JOULE_NM, PLANCK_J_S, Unit, check_unit

_ROWS, _COLUMNS = 91, 180
# One S10 over the sun's irradiance, for each steradian: of a sun of magnitude -26.74 (Leinert et
# al. 1998, page 4).
_S10_PER_SR = 6.61e-12
# Starlight over sunlight: medians of Pioneer's maps are 73.8 S10 at 437.0 and 100.8 at 644.1 nm.
_BLUE_NM = 437.0
_STAR_POWER = float(np.log(100.8 / 73.8) / np.log(644.1 / _BLUE_NM))
# How much redder the zodiacal light is, by degrees from the sun: over the logarithm to base 10 of
# the wavelength over 500 nm; below 500 nm half as much again (Leinert et al. 1998, equation 22).
_REDDENING = ((30.0, 90.0), (0.8, 0.6))
# S10 where the dark zenith was measured, between stars: of galaxies and of dust among the stars
# (quoted of Benn and Ellison 1998); and means of the sky at night, of which the air scatters some.
_DARK_S10, _USUAL_STARS_S10, _USUAL_DUST_S10 = 11.0, 118.0, 110.0

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
    rows = _ROWS
    slant = _slant(np.linspace(0, 90, rows))
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
def night_sky_at(
    date_time: datetime,
    latitude_deg: float,
    longitude_deg: float,
    *,
    airglow: float = 1.0,
    albedo: float = 0.1,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A clear sky without sun, moon and lamps at a time and place, where -Z is north: the Milky Way
    and all other stars but those of `stars`, the zodiacal light, and the glow of the air. Planets
    come with `stars` too.

    Stars fainter than 6.5 magnitudes and the dust that they light are Pioneer 10's map at 440 nm,
    on nodes 4 to 10 degrees apart (Toller 1981; Leinert et al., Astron. Astrophys. Suppl. Ser.
    127:1, 1998, table 35); Hipparcos's stars from there up to those of `stars` are spread over the
    same nodes. Both have the sun's spectrum, above 437 nm times the wavelength to the power 0.80.
    The zodiacal light is the mean of a year by ecliptic latitude and longitude from the sun
    (table 16), redder than the sun (equation 22). The air dims both and scatters some of them
    elsewhere, once and evenly. Airglow is what `night_sky` has more than they give there; lower
    down it grows as in `night_sky`. Unpolarised.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.
        airglow: over that at sunspot minimum, 0 to 10; at maximum some 1.7.
        albedo: share of light that the land around gives back, 0 to 1.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Example:
        >>> from datetime import datetime, timezone
        >>> moment = datetime(2026, 7, 15, 20, tzinfo=timezone.utc)
        >>> green = omma.light.Bands.from_edges([540, 560])
        >>> night = omma.light.night_sky_at(moment, -24, 28, bands=green)
        >>> seen = night.radiance(omma.eye.direction([130, 330], [80, 60]))[:, 0, 0]
        >>> f"{seen[0] / seen[1]:.1f}"    # the Milky Way's middle, over beside it
        '2.5'

    Raises:
        omma.Error: a time without a time zone or out of range, a number out of range, bands out of
            300 to 700 nm, or PyEphem is not installed.
    """
    moment = universal(date_time)
    within(latitude_deg, "latitude_deg", -90, 90)
    within(longitude_deg, "longitude_deg", -180, 180)
    within(airglow, "airglow", 0, 10)
    within(albedo, "albedo", 0, 1)
    bands = bands or Bands.equal()
    check_unit(unit)
    check_range(bands.wavelength_nm)
    elevation, azimuth = (np.degrees(one) for one in sky_nodes(_ROWS, _COLUMNS))
    above_deg = elevation[0]
    towards = direction(azimuth, above_deg[:, None])
    equatorial = towards @ equatorial_from_horizon(moment, latitude_deg, longitude_deg).T
    stars = starlight_s10(equatorial @ GALACTIC_FROM_EQUATORIAL.T)
    sun_rad = sun_longitude_rad(moment)
    ecliptic = equatorial @ ECLIPTIC_FROM_EQUATORIAL.T
    dust = zodiacal_s10(ecliptic, sun_rad)
    sunwards = ecliptic @ [np.cos(sun_rad), np.sin(sun_rad), 0.0]
    redder = np.interp(np.degrees(np.arccos(np.clip(sunwards, -1, 1))), *_REDDENING)

    def parts(nm: Floats) -> Floats:
        """Of a unit of stars, of white dust and of its reddening; scattered light; airglow."""
        sun, reddening, starry = _spectra(bands, nm)
        depth, scatters = (one[:, None] for one in air_depth(nm))
        mass = air_mass(above_deg)
        through = np.exp(-depth * mass)
        whole = stars.mean(axis=1) * starry[:, None] + dust.mean(axis=1) * (
            1 + _REDDENING[1][1] * reddening[:, None]
        )
        from_air = _scattered(whole, above_deg, depth, scatters)
        slant = _slant(above_deg)
        glow = airglow * _airglow_photons(bands, nm)[:, None] / sun[:, None]
        glow = glow * slant * np.exp(-depth * (slant - 1))
        each = np.stack([starry[:, None] * through, through, reddening[:, None] * through,
                         from_air + glow])  # fmt: skip
        photons = sun[:, None, None] * np.moveaxis(each, 0, 1)
        return np.asarray(
            photons if unit == "photons" else photons / (nm * PHOTONS_PER_JOULE_NM)[:, None, None]
        )

    of_stars, of_dust, of_red, even = np.moveaxis(bands.mean(parts), 1, 0)[..., None]
    above = stars * of_stars + dust * (of_dust + redder * of_red) + even
    sky = np.empty((2, _ROWS, _COLUMNS, 1, len(bands)), np.float32)
    sky[0, :, :, 0] = np.moveaxis(above, 0, -1)
    level = level_weights(_ROWS, _COLUMNS) @ above.sum(axis=2).T
    sky[1] = albedo / np.pi * level
    return Light(bands, unit, sky)


def _spectra(bands: Bands, nm: Floats) -> tuple[Floats, Floats, Floats]:
    """Photons of a unit of S10 with the sun's spectrum, what a reddening of 1 adds to it, and
    starlight over it."""
    sun = _S10_PER_SR * sun_spectrum(nm, "photons", 1.0 if bands.cell_nm is None else bands.cell_nm)
    decades = np.log10(nm / 500)
    starry = np.maximum(nm / _BLUE_NM, 1) ** _STAR_POWER
    return sun, np.where(nm < 500, 1.5, 1.0) * decades, starry


def _scattered(whole: Floats, above_deg: Floats, depth: Floats, scatters: Floats) -> Floats:
    """What air sends down of what comes from above it, (K, rows) by elevation (rows,): half of what
    it scatters of the light on a level, from everywhere as much as there is air."""
    up = np.radians(above_deg)
    level = np.sin(up) * np.cos(up)
    taken = 1 - np.exp(-depth * air_mass(above_deg))
    half = 0.5 * scatters / depth * (((whole * taken) @ level) / (taken @ level))[:, None]
    return np.asarray(half * taken)


def _airglow_photons(bands: Bands, nm: Floats) -> Floats:
    """In the zenith at sunspot minimum: what was measured there, less the rest of it."""
    sun, reddening, starry = _spectra(bands, nm)
    depth, scatters = (one[:, None] for one in air_depth(nm))
    rest = (1 + _REDDENING[1][1] * reddening)[:, None]
    dark = ZODIACAL_POLE_S10 * rest + _DARK_S10 * starry[:, None]
    usual = _USUAL_DUST_S10 * rest + _USUAL_STARS_S10 * starry[:, None]
    above_deg = np.linspace(0, 90, _ROWS)
    scattered = _scattered(usual * np.ones(_ROWS), above_deg, depth, scatters)[:, -1]
    far = sun * (dark[:, 0] * np.exp(-depth[:, 0]) + scattered)
    return np.asarray(np.maximum(_zenith_photons(nm) - far, 0))


def _slant(above_deg: Floats) -> Floats:
    """Of a glowing layer, over the zenith's (Krisciunas and Schaefer 1991)."""
    return np.asarray((1 - 0.96 * np.cos(np.radians(above_deg)) ** 2) ** -0.5)


def _zenith_photons(nm: Floats) -> Floats:
    known = [*_ULTRAVIOLET]
    for at, jansky, magnitudes in _BRIGHTNESS:
        flux = jansky * 10 ** (-0.4 * magnitudes) * _PHOTONS_PER_JY / at
        known.append((at, flux * _SQUARE_SECONDS_PER_SR))
    at, photons = np.transpose(known)
    return np.asarray(np.exp(np.interp(nm, at, np.log(photons))))
