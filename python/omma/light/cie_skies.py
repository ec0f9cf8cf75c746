"""The fifteen standard skies of the CIE: how bright a sky is over its zenith, by direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import arrays_of, as_named, checked, whole, within
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.light.bands import Bands
from omma.light.lights import MOST_AZIMUTH_DEG, Light, makes_light
from omma.light.sky_map import irradiance, sky_nodes
from omma.light.units import Unit

TYPES = 15
# ISO 15469:2004 / CIE S 011:2003, table 1: a, b of the gradation, c, d, e of the indicatrix.
_STANDARD = np.array(
    [
        (4, -0.7, 0, -1, 0),
        (4, -0.7, 2, -1.5, 0.15),
        (1.1, -0.8, 0, -1, 0),
        (1.1, -0.8, 2, -1.5, 0.15),
        (0, -1, 0, -1, 0),
        (0, -1, 2, -1.5, 0.15),
        (0, -1, 5, -2.5, 0.3),
        (0, -1, 10, -3, 0.45),
        (-1, -0.55, 2, -1.5, 0.15),
        (-1, -0.55, 5, -2.5, 0.3),
        (-1, -0.55, 10, -3, 0.45),
        (-1, -0.32, 10, -3, 0.45),
        (-1, -0.32, 16, -3, 0.3),
        (-1, -0.15, 16, -3, 0.3),
        (-1, -0.15, 24, -2.8, 0.15),
    ]
)


@checked
def cie_relative_luminance(
    sky_type: int,
    sun_elevation_deg: float,
    elevation_deg: ArrayLike,
    from_sun_azimuth_deg: ArrayLike = 0.0,
) -> Floats:
    """Luminance of a standard sky over that of its zenith, by direction; arrays broadcast.

    Args:
        sky_type: 1 to 15 of ISO 15469:2004 (CIE S 011): steeply graded overcast (1), uniform
            (5), partly cloudy (6 to 10) to clear (11, 12) and turbid (13 to 15).
        sun_elevation_deg: 0 to 90.
        elevation_deg: of the directions, 0 to 90.
        from_sun_azimuth_deg: of the directions, from the sun's.

    Example:
        >>> omma.light.cie_relative_luminance(1, 30, [0, 45, 90]).round(3).tolist()
        [0.335, 0.833, 1.0]

    Raises:
        omma.Error: a type or an elevation out of range.
    """
    whole(sky_type, "sky_type", 1, TYPES)
    within(sun_elevation_deg, "sun_elevation_deg", 0, 90)
    elevation, azimuth = arrays_of(
        elevation_deg=elevation_deg, from_sun_azimuth_deg=from_sun_azimuth_deg
    )
    if not np.all((elevation >= 0) & (elevation <= 90)):
        raise Error("elevation_deg: expected 0 to 90")
    if not np.all(np.isfinite(azimuth)):
        raise Error("from_sun_azimuth_deg: expected finite numbers")
    a, b, *indicatrix = _STANDARD[sky_type - 1]
    sine = np.sin(np.radians(elevation))
    # exp(b / sin) is 0 on the horizon, as b is below 0.
    graded = (1 + a * np.exp(b / np.maximum(sine, 1e-3))) / (1 + a * np.exp(b))
    towards_sun = direction(0, sun_elevation_deg)
    cosine = direction(azimuth, elevation) @ towards_sun
    return np.asarray(
        graded * scattered(cosine, *indicatrix) / scattered(towards_sun[1], *indicatrix)
    )


def scattered(cosine: ArrayLike, c: float, d: float, e: float) -> Floats:
    """The standard's indicatrix: 1 + c (exp(d χ) - exp(d π/2)) + e cos² χ, at an angle χ from the
    sun."""
    chi = np.arccos(np.clip(cosine, -1, 1))
    return np.asarray(1 + c * (np.exp(d * chi) - np.exp(d * np.pi / 2)) + e * np.cos(chi) ** 2)


@checked
@makes_light
def cie_sky(
    sky_type: int,
    sun_elevation_deg: float,
    *,
    sun_azimuth_deg: float = 0.0,
    level_share: float = 0.25,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A standard sky of the CIE without a sun's disc, unpolarised, of one colour.

    The standard says how luminances compare. How strong the sky is and its spectrum, that of the
    clear day on level ground, are added here.

    Args:
        sky_type: 1 to 15, as of `cie_relative_luminance`.
        sun_elevation_deg: 0 to 90.
        sun_azimuth_deg: as of `clear_sky`.
        level_share: what falls on level ground, over what falls on it by `clear_sky` from sun and
            sky together; above 0, at most 1.
        bands, unit: as of `clear_sky`.

    Raises:
        omma.Error: a number out of range.
    """
    from omma.light.skies import overcast_sky

    whole(sky_type, "sky_type", 1, TYPES)
    within(sun_elevation_deg, "sun_elevation_deg", 0, 90)
    within(sun_azimuth_deg, "sun_azimuth_deg", -MOST_AZIMUTH_DEG, MOST_AZIMUTH_DEG)
    with as_named(cloud_transmittance="level_share"):
        even = overcast_sky(
            sun_elevation_deg, cloud_transmittance=level_share, bands=bands, unit=unit
        )
    rows, columns = 91, 360
    elevation, azimuth = sky_nodes(rows, columns)
    shape = cie_relative_luminance(
        sky_type,
        sun_elevation_deg,
        np.degrees(elevation[0])[:, None],
        np.degrees(azimuth) - sun_azimuth_deg,
    )
    sky = np.zeros((2, rows, columns, 1, len(even.bands)), np.float32)
    sky[0] = shape[:, :, None, None]
    sky[0] *= even.irradiance()[0] / irradiance(sky, np.array([0.0, 1.0, 0.0]))
    sky[1] = even.sky[1, :1, :1]  # type: ignore[index]
    return Light(even.bands, unit, sky)
