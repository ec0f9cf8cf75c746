"""Skies that are computed: uniform, clear by day, in twilight and by moon, overcast; and none.

With clouds: clouds.py; the CIE's: cie_skies.py; of any sun: nights.py; night: dark_skies.py.
"""

from __future__ import annotations

from datetime import datetime

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, positive, within
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.light.bands import Bands
from omma.light.discs import Disc
from omma.light.haze_kinds import HazeKind
from omma.light.lights import MOST_AZIMUTH_DEG, Light, check_not_lost, makes_light
from omma.light.moon_discs import moon_discs
from omma.light.sky_map import sky_nodes
from omma.light.sky_stored import sun_limb_darkening
from omma.light.sky_tables import (
    LOWEST_SUN_DEG,
    SUN_DIAMETER_DEG,
    check_range,
    clear_sky_map,
)
from omma.light.sun_position import sun_position
from omma.light.units import Unit, check_unit

CLEAR_SKY_AEROSOL = 0.1  # of `clear_sky`, where nothing is said
# What goes on where clouds before a clear sky end with it.
CLOUDS_BY_NIGHT = "in Python, omma.light.clouded before omma.light.natural_sky"

# Visual magnitudes of the sun and of the full moon, and how much a moon that is not full loses
# (Allen, Astrophysical Quantities, 3rd edition, 1973), good to 150 degrees of phase angle.
_SUN_MAGNITUDE, _FULL_MOON_MAGNITUDE = -26.74, -12.73
_MOST_PHASE_DEG = 150.0
# How the moon reflects, as a power of the wavelength, by phase angle, degrees: fitted to the disc's
# reflectances at 350 to 704 nm of Kieffer and Stone (Astron. J. 129:2887, 2005, table 4), from
# which each is 5 % rms off, as are their bands from each other.
_MOON_PHASES_DEG, _MOON_POWERS = (5, 30, 60, 90), (0.95, 1.13, 1.24, 1.30)
_VISUAL_NM = 550.0


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
    check_not_lost([each], "radiance")
    if not (np.isfinite(below) and below >= 0):
        raise Error(f"below: expected a number of at least 0, found {below}")
    sky = np.empty((2, 2, 4, 1, len(bands)), np.float32)
    sky[0], sky[1] = each, below * each
    return Light(bands, unit, sky)


@checked
@makes_light
def lamps(*, bands: Bands | None = None, unit: Unit = "photons") -> Light:
    """No light from afar: a world is lit by the lamps of its scene (KHR_lights_punctual) and by its
    surfaces that shine, before a black sky.

    Args:
        bands: by default 12 of 25 nm from 400 to 700 nm, as candelas say nothing of ultraviolet.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.
    """
    return Light(bands or Bands.equal(12, 400.0, 700.0), unit)


@checked
@makes_light
def clear_sky(
    sun_elevation_deg: float,
    *,
    sun_azimuth_deg: float = 0.0,
    aerosol: float = CLEAR_SKY_AEROSOL,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    height_m: float = 0.0,
    haze_kind: HazeKind = "rural",
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A sky without clouds and its sun, by day and in twilight, polarised.

    From tables of radiative transfer with all orders of scattering, ozone and haze; docs/light.md
    says how they were made and how exact they are. The sun's disc is 0.533° wide and darker towards
    its limb. Below the horizon is even ground.

    Args:
        sun_elevation_deg: of the sun's centre, without refraction, -8 to 90.
        sun_azimuth_deg: from -Z to the right (from north to the east, where -Z is north).
        aerosol: optical depth of haze at 550 nm above the land, 0 to 0.3; at a height less, as
            there is less air.
        ozone_du: in a column of air, 200 to 450 Dobson units.
        albedo: share of light that the land around gives back, 0 to 1.
        height_m: of the land around above the sea, 0 to 5000. Air is that of the US Standard
            Atmosphere 1976: 0.785 of the sea's at 2000 m.
        haze_kind: "rural"; and with the sun from 10 degrees on "urban", with soot; "maritime", of
            sea salt; or "smoke" of forests, up to 0.219. docs/light.md says what is theirs.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: "photons" m⁻² s⁻¹ sr⁻¹ nm⁻¹ or "watts" m⁻² sr⁻¹ nm⁻¹.

    Raises:
        omma.Error: a number out of the tables' range, or bands out of 300 to 700 nm.
    """
    check_not_night(sun_elevation_deg, "natural_sky")
    bands = bands or Bands.equal()
    check_unit(unit)
    check_range(bands.wavelength_nm)
    sky, sun = clear_sky_map(
        bands.wavelength_nm,
        bands.weight,
        sun_elevation_deg,
        sun_azimuth_deg,
        aerosol=aerosol,
        ozone_du=ozone_du,
        albedo=albedo,
        height_m=height_m,
        haze_kind=haze_kind,
        unit=unit,
        width_nm=1.0 if bands.cell_nm is None else bands.cell_nm,
    )
    limb = bands.mean(sun_limb_darkening)
    radius = float(np.radians(SUN_DIAMETER_DEG / 2))
    discs = _disc(sun_elevation_deg, sun_azimuth_deg, radius, sun, limb)
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
    height_m: float = 0.0,
    haze_kind: HazeKind = "rural",
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """`clear_sky` at a time and place, where -Z is north: the sun stands where `sun_position` says.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.
        aerosol, ozone_du, albedo, height_m, haze_kind, bands, unit: as of `clear_sky`.

    Raises:
        omma.Error: a time without a time zone or out of range, a latitude or longitude out of
            range, a sun that the tables do not have, or PyEphem is not installed.
    """
    sun = sun_position(date_time, latitude_deg, longitude_deg)
    if sun.elevation_deg < LOWEST_SUN_DEG:
        raise Error(
            f"date_time: expected one when the sun stands at {LOWEST_SUN_DEG:g} degrees or higher, "
            f"found {sun.elevation_deg:.1f} degrees; natural_sky_at goes on into the night"
        )
    return clear_sky(
        sun.elevation_deg,
        sun_azimuth_deg=sun.azimuth_deg,
        aerosol=aerosol,
        ozone_du=ozone_du,
        albedo=albedo,
        height_m=height_m,
        haze_kind=haze_kind,
        bands=bands,
        unit=unit,
    )


@checked
@makes_light
def moonlit_sky(
    moon_elevation_deg: float,
    *,
    moon_azimuth_deg: float = 0.0,
    phase_angle_deg: float = 0.0,
    bright_limb_deg: float | None = None,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    height_m: float = 0.0,
    haze_kind: HazeKind = "rural",
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A clear sky by moonlight: `clear_sky` with the moon instead of the sun.

    Its strength is that of the visual magnitudes of sun and moon, -26.74 and -12.73 when it is
    full, which is 2.5e-6 at 550 nm, less 0.026 |φ| + 4e-9 φ⁴ magnitudes at a phase angle of φ
    degrees (Allen 1973). It is redder than the sun, by the wavelength to the power 0.95 when it is
    full to 1.3 when it is half (after Kieffer and Stone 2005). The disc is 0.518° wide and even.
    With ``bright_limb_deg`` one to five smaller ones stand for the part of it that is lit, with its
    light, its centroid and how far it is spread out. What light of stars and of the air itself
    there is comes by `night_sky`.

    Args:
        moon_elevation_deg, moon_azimuth_deg: of its centre, as of the sun in `clear_sky`.
        phase_angle_deg: between sun and observer, seen from the moon: 0 is full, 90 half; to 150.
        bright_limb_deg: where its limb is brightest, towards the sun: from up, turning to the right
            as one looks at it. None: the disc is whole, as bright in the mean as its lit part makes
            it.
        aerosol, ozone_du, albedo, height_m, haze_kind, bands, unit: as of `clear_sky`.

    Raises:
        omma.Error: a number out of range.
    """
    within(moon_elevation_deg, "moon_elevation_deg", LOWEST_SUN_DEG, 90)
    within(moon_azimuth_deg, "moon_azimuth_deg", -MOST_AZIMUTH_DEG, MOST_AZIMUTH_DEG)
    within(phase_angle_deg, "phase_angle_deg", -_MOST_PHASE_DEG, _MOST_PHASE_DEG)
    if bright_limb_deg is not None:
        within(bright_limb_deg, "bright_limb_deg", -360, 360)
    sunlit = clear_sky(
        moon_elevation_deg,
        sun_azimuth_deg=moon_azimuth_deg,
        aerosol=aerosol,
        ozone_du=ozone_du,
        albedo=albedo,
        height_m=height_m,
        haze_kind=haze_kind,
        bands=bands,
        unit=unit,
    )
    phase = abs(phase_angle_deg)
    loss = _FULL_MOON_MAGNITUDE - _SUN_MAGNITUDE + 0.026 * phase + 4e-9 * phase**4
    power = float(np.interp(phase, _MOON_PHASES_DEG, _MOON_POWERS))
    share = 10 ** (-0.4 * loss) * sunlit.bands.mean(lambda nm: (nm / _VISUAL_NM) ** power)
    found = [share * one.irradiance() for one in sunlit.discs]
    discs: tuple[Disc, ...] = ()
    if found and np.any(found[0] > 0):
        at = moon_azimuth_deg, moon_elevation_deg
        discs = moon_discs(*at, phase_angle_deg, bright_limb_deg, found[0])
    sky = sunlit.sky * share.astype(np.float32)  # type: ignore[operator]
    return Light(sunlit.bands, unit, sky, discs=discs)


@checked
@makes_light
def overcast_sky(
    sun_elevation_deg: float,
    *,
    cloud_transmittance: float = 0.25,
    aerosol: float = 0.1,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    height_m: float = 0.0,
    haze_kind: HazeKind = "rural",
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
        aerosol, ozone_du, albedo, height_m, haze_kind, bands, unit: as of `clear_sky`.

    Raises:
        omma.Error: a number out of range.
    """
    if positive(cloud_transmittance, "cloud_transmittance") > 1:
        raise Error(f"cloud_transmittance: expected at most 1, found {cloud_transmittance}")
    check_not_night(sun_elevation_deg, CLOUDS_BY_NIGHT)
    clear = clear_sky(
        sun_elevation_deg,
        aerosol=aerosol,
        ozone_du=ozone_du,
        albedo=albedo,
        height_m=height_m,
        haze_kind=haze_kind,
        bands=bands,
        unit=unit,
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


def check_not_night(sun_elevation_deg: float, onwards: str) -> None:
    """omma.Error where the sun is below the tables' lowest, which says what goes ``onwards``."""
    if -90 <= sun_elevation_deg < LOWEST_SUN_DEG:
        raise Error(
            f"sun_elevation_deg: expected {LOWEST_SUN_DEG:g} to 90, found {sun_elevation_deg:g}; "
            f"{onwards} goes on into the night"
        )


def _disc(
    elevation_deg: float, azimuth_deg: float, radius_rad: float, facing: Floats, limb: Floats | None
) -> tuple[Disc, ...]:
    """A disc that gives so much (B,) to what faces it; none where that is nothing."""
    if not np.any(facing > 0):
        return ()
    radiance = np.asarray(facing, np.float64) / (np.pi * np.sin(radius_rad) ** 2)
    return (Disc(direction(azimuth_deg, elevation_deg), radius_rad, radiance, limb),)
