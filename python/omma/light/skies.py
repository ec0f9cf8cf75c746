"""Skies that are computed: uniform, clear by day, in twilight and by moon, and overcast."""

from __future__ import annotations

from datetime import datetime

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, positive, within
from omma.base.directions import direction
from omma.light.bands import Bands
from omma.light.lights import Disc, Light, makes_light
from omma.light.sky_map import sky_nodes
from omma.light.sun_position import sun_position
from omma.light.units import Unit, check_unit

Floats = NDArray[np.float64]

_SUN_RADIUS_RAD = float(np.radians(0.533 / 2))  # at its mean distance
_MOON_RADIUS_RAD = float(np.radians(0.518 / 2))

# Mean radiance of the sun's disc over that at its centre (Neckel and Labs, Solar Physics 153:91,
# 1994, table 1), between its lines. That of 1 - u (1 - mu) is 1 - u/3.
_LIMB_NM = (
    303.3,
    329.9,
    349.9,
    374.1,
    402.0,
    427.9,
    457.3,
    492.9,
    541.8,
    579.9,
    611.0,
    669.4,
    700.9,
)
_MEAN_OVER_CENTRE = (
    0.6826, 0.7116, 0.7260, 0.7288, 0.7303, 0.7495, 0.7651, 0.7823, 0.8002, 0.8125, 0.8221, 0.8360,
    0.8434,
)  # fmt: skip

# Visual magnitudes of the sun and of the full moon, and how much a moon that is not full loses
# (Allen, Astrophysical Quantities, 3rd edition, 1973), good to 150 degrees of phase angle.
_SUN_MAGNITUDE, _FULL_MOON_MAGNITUDE = -26.74, -12.73
_MOST_PHASE_DEG = 150.0


@checked
@makes_light
def uniform_sky(
    radiance: ArrayLike = 1.0,
    *,
    below: float = 1.0,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """Light that is the same from everywhere, unpolarised.

    Args:
        radiance: a number for all bands, or (B,). In photons, a number means equal numbers of
            photons at all wavelengths.
        below: what comes from below the horizon, as a share of that; 0: from above only.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Raises:
        omma.Error: radiances that are negative or not finite, or not one for each band.
    """
    bands = bands or Bands.equal()
    each = array_of(radiance, "radiance")
    if each.shape not in ((), (len(bands),)):
        raise Error(f"radiance: expected one number or {len(bands)}, found shape {each.shape}")
    if not np.all(np.isfinite(each)) or np.any(each < 0):
        raise Error("radiance: expected finite numbers of at least 0")
    if not (np.isfinite(below) and below >= 0):
        raise Error(f"below: expected a number of at least 0, found {below}")
    sky = np.empty((2, 2, 4, 1, len(bands)), np.float32)
    sky[0], sky[1] = each, below * each
    return Light(bands, unit, sky)


@checked
@makes_light
def clear_sky(
    sun_elevation_deg: float,
    sun_azimuth_deg: float = 0.0,
    *,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A sky without clouds and its sun, by day and in twilight, polarised.

    From tables of radiative transfer with all orders of scattering, ozone and haze; docs/light.md
    says how they were made and how exact they are. The sun's disc is 0.533° wide, darker towards
    its limb (Neckel and Labs 1994). Below the horizon is even ground.

    Args:
        sun_elevation_deg: of the sun's centre, without refraction.
        sun_azimuth_deg: from -Z to the right (from north to the east, where -Z is north).
        aerosol: optical depth of haze at 550 nm.
        ozone_du: in a column of air, Dobson units.
        albedo: share of light that the land around gives back, 0 to 1.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Raises:
        omma.Error: a number out of the tables' range, or bands out of 300 to 700 nm.
    """
    bands = bands or Bands.equal()
    check_unit(unit)
    if not np.isfinite(sun_azimuth_deg):
        raise Error(f"sun_azimuth_deg: expected a finite angle, found {sun_azimuth_deg}")
    # Here, as it reads tables.
    from omma.light.sky_tables import clear_sky_map

    sky, sun = clear_sky_map(
        bands.wavelength_nm,
        bands.weight,
        sun_elevation_deg,
        sun_azimuth_deg,
        aerosol=aerosol,
        ozone_du=ozone_du,
        albedo=albedo,
        unit=unit,
    )
    limb = bands.mean(lambda nm: 3 * (1 - np.interp(nm, _LIMB_NM, _MEAN_OVER_CENTRE)))
    discs = _disc(sun_elevation_deg, sun_azimuth_deg, _SUN_RADIUS_RAD, sun, limb)
    return Light(bands, unit, sky, discs=discs)


@checked
def clear_sky_at(
    date_time: datetime,
    latitude_deg: float,
    longitude_deg: float,
    *,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """`clear_sky` at a time and place, where -Z is north: the sun stands where `sun_position` says.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.
        aerosol, ozone_du, albedo, bands, unit: as of `clear_sky`.

    Raises:
        omma.Error: a time without a time zone or out of range, a place out of range, a sun that
            the tables do not have, or PyEphem is not installed.
    """
    elevation, azimuth = sun_position(date_time, latitude_deg, longitude_deg)
    return clear_sky(
        elevation,
        azimuth,
        aerosol=aerosol,
        ozone_du=ozone_du,
        albedo=albedo,
        bands=bands,
        unit=unit,
    )


@checked
@makes_light
def moonlit_sky(
    moon_elevation_deg: float,
    moon_azimuth_deg: float = 0.0,
    *,
    phase_angle_deg: float = 0.0,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A clear sky by moonlight: `clear_sky` with the moon in the sun's place.

    Its strength is that of the visual magnitudes of sun and moon, -26.74 and -12.73 when it is
    full, which is 2.5e-6, less 0.026 |φ| + 4e-9 φ⁴ magnitudes at a phase angle of φ degrees (Allen
    1973). The disc is 0.518° wide and even. That the moon is redder than the sun, that not all of
    its disc is lit, and what light of stars and of the air itself there is, are left out.

    Args:
        moon_elevation_deg, moon_azimuth_deg: of its centre, as of the sun in `clear_sky`.
        phase_angle_deg: between sun and observer, seen from the moon: 0 is full, 90 half; to 150.
        aerosol, ozone_du, albedo, bands, unit: as of `clear_sky`.

    Raises:
        omma.Error: a number out of range.
    """
    within(phase_angle_deg, "phase_angle_deg", -_MOST_PHASE_DEG, _MOST_PHASE_DEG)
    sunlit = clear_sky(
        moon_elevation_deg, moon_azimuth_deg, aerosol=aerosol, ozone_du=ozone_du, albedo=albedo,
        bands=bands, unit=unit,
    )  # fmt: skip
    phase = abs(phase_angle_deg)
    loss = _FULL_MOON_MAGNITUDE - _SUN_MAGNITUDE + 0.026 * phase + 4e-9 * phase**4
    moonlit = sunlit.scaled(10 ** (-0.4 * loss))
    found = [one.irradiance() for one in moonlit.discs]
    discs: tuple[Disc, ...] = ()
    if found:
        discs = _disc(moon_elevation_deg, moon_azimuth_deg, _MOON_RADIUS_RAD, found[0], None)
    return Light(moonlit.bands, unit, moonlit.sky, discs=discs)


@checked
@makes_light
def overcast_sky(
    sun_elevation_deg: float,
    *,
    cloud_transmittance: float = 0.25,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A sky that is all cloud, unpolarised: radiance L_z (1 + 2 sin e) / 3 at an elevation e.

    The shape is the CIE's (Moon and Spencer 1942; CIE S 011). The cloud lets through the same share
    at all wavelengths of what would fall on level ground from sun and sky without it, by default
    0.25 (Kasten and Czeplak, Solar Energy 24:177, 1980, for eight oktas): droplets are far larger
    than wavelengths. That light goes to and fro between cloud and air, which makes real ones bluer
    by some percent, is left out. Below the horizon is even ground.

    Args:
        sun_elevation_deg: of the sun behind the cloud.
        cloud_transmittance: above 0, at most 1.
        aerosol, ozone_du, albedo, bands, unit: as of `clear_sky`.

    Raises:
        omma.Error: a number out of range.
    """
    if positive(cloud_transmittance, "cloud_transmittance") > 1:
        raise Error(f"cloud_transmittance: expected at most 1, found {cloud_transmittance}")
    clear = clear_sky(
        sun_elevation_deg, aerosol=aerosol, ozone_du=ozone_du, albedo=albedo, bands=bands, unit=unit
    )
    level = cloud_transmittance * sum(clear.irradiance())
    rows = 91
    elevation, _ = sky_nodes(rows, 4)
    shape = np.stack([(1 + 2 * np.sin(elevation[0])) / 3, np.zeros(rows)])
    sky = np.empty((2, rows, 4, 1, len(clear.bands)), np.float32)
    # A sky of this shape with 1 in the zenith gives 7/9 pi on level ground.
    sky[:] = shape[:, :, None, None, None] * level / (7 / 9 * np.pi)
    sky[1] = albedo * level / np.pi
    return Light(clear.bands, unit, sky)


def _disc(
    elevation_deg: float, azimuth_deg: float, radius_rad: float, facing: Floats, limb: Floats | None
) -> tuple[Disc, ...]:
    """A disc that gives so much (B,) to what faces it; none where that is nothing."""
    if not np.any(facing > 0):
        return ()
    radiance = np.asarray(facing, np.float64) / (np.pi * np.sin(radius_rad) ** 2)
    return (Disc(direction(azimuth_deg, elevation_deg), radius_rad, radiance, limb),)
