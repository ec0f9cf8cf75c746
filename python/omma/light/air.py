"""Air between surfaces: haze, mist and fog, which hide what is far behind the sky's horizon."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, within
from omma.base.arrays import Floats
from omma.base.warn import warn_caller
from omma.light import sky_map
from omma.light.lights import Light, is_under_water, makes_light
from omma.light.skies import CLEAR_SKY_AEROSOL
from omma.light.sky_height import AIR_HEIGHT_M, air_above
from omma.light.sky_stored import depths_of_air_and_haze

# Makers that say what air their sky has, by the same arguments and defaults; makers and methods
# whose light has the air of the one that they were given.
_OWN_AIR = ("clear_sky", "moonlit_sky", "natural_sky", "natural_sky_at")
_SAME_AIR = ("with_air", "clouded", "plus", "scaled", "turned")
# Contrast at the meteorological optical range (CIE e-ILV 17-31-018).
_LEAST_CONTRAST = 0.05
_VISIBILITY_NM = 550.0
_VISIBILITIES_M = (1.0, 250e3)
_MOST_ANGSTROM = 4.1
# Visibilities below the first are fog; fogs have seldom less than the second.
_FOG_M, _LEAST_FOG_M = 1000.0, 10.0
_HEIGHTS_M = (0.0, 20e3)
# Mean cosine of the angle by which droplets of fog turn light (clouds' is 0.85 in the visible:
# Slingo 1989, recalled).
_FOG_COSINE = 0.85
# Rows of a sky that is seen through a layer, at least: what is left of it changes fast low down.
_ROWS = 361
# In which haze would be, were it as thick all the way up as at the ground: that of the tables of
# `clear_sky`, which thins out exponentially (bench/notes/clear-sky.md).
_HAZE_HEIGHT_M = 2000.0


@checked
@makes_light
def with_air(
    light: Light,
    visibility_m: float | None = None,
    *,
    layer_height_m: float | None = None,
    angstrom: float | None = None,
    extinction_per_m: ArrayLike | None = None,
) -> Light:
    """A light with air between surfaces: haze, mist, fog.

    Over a distance d air of extinction σ leaves exp(-σ d) of what a surface sends, and shows the
    sky at the horizon for the rest, with its polarisation. So contrast to the horizon falls by
    exp(-σ d) (Koschmieder 1924). Light from afar is as it is: skies are seen through their air;
    or, with ``layer_height_m``, through a layer of this air too.

    Args:
        light: with a sky; air without one shows black.
        visibility_m: meteorological optical range, at which 0.05 of the contrast is left at 550 nm
            (CIE e-ILV 17-31-018): 3.0 / σ; 1 m to 250 km. Below 1 km it is fog. None: the air and
            the haze that the sky of ``light`` was computed with, if it is one of `clear_sky`,
            `moonlit_sky`, `natural_sky` or `natural_sky_at`.
        layer_height_m: how high this air reaches above the animal, 0 to 20 km, with visibility_m
            or extinction_per_m. At an elevation e the sky and its discs are dimmed by T =
            exp(-σ h / sin e), and the sky has (1 - T) J besides, J even, unpolarised, and such
            that level ground gets 2 / (2 + 0.15 σ h) of what it had: what a layer that only
            scatters lets through (two streams; 0.15 is 1 less droplets' mean cosine). So what
            stands high vanishes too. None or 0: the sky is as it was.
        angstrom: how σ falls with wavelength, σ ~ wavelength^-angstrom, 0 to 4.1. None: as Kim,
            McArthur and Korevaar (Proc. SPIE 4214:26, 2001) have it by visibility: 0 up to 500 m,
            then rising to 0.5 at 1 km and 1.3 at 6 km, 1.6 from 50 km on.
        extinction_per_m: σ as measured, a number or (B,), instead of both.

    Example:
        >>> fog = omma.light.with_air(omma.light.overcast_sky(30.0), visibility_m=200)
        >>> float(fog.extinction_per_m[0]).__round__(4)
        0.015
        >>> clear = omma.light.with_air(omma.light.clear_sky(30.0, aerosol=0.05))
        >>> km = 3.0 / clear.extinction_per_m / 1000
        >>> km[[0, 8, 15]].round().tolist()    # visibility at 312, 512 and 688 nm
        [18.0, 70.0, 130.0]

    Warns:
        UserWarning: fog of no given height, as its sky stays clear; visibility below 10 m.

    Raises:
        omma.Error: a number out of range, several of the three, none and a sky that does not say
            what air it has, or a light under water.
    """
    if is_under_water(light):
        raise Error(
            "light: expected one above the water, found one under water, where water lies between "
            "surfaces; air above it is of the light that under_water is given"
        )
    height = 0.0
    if layer_height_m is not None:
        height = within(layer_height_m, "layer_height_m", *_HEIGHTS_M)
    if extinction_per_m is not None:
        if visibility_m is not None or angstrom is not None:
            raise Error("extinction_per_m: expected it alone, found visibility_m or angstrom too")
        given = array_of(extinction_per_m, "extinction_per_m")
        extinction = np.full(len(light.bands), given) if given.ndim == 0 else given
    elif visibility_m is not None:
        within(visibility_m, "visibility_m", *_VISIBILITIES_M)
        _warn_of_fog(visibility_m, layer_height_m)
        power = _kim_exponent(visibility_m / 1000) if angstrom is None else angstrom
        within(power, "angstrom", 0, _MOST_ANGSTROM)
        at_550 = -np.log(_LEAST_CONTRAST) / visibility_m
        extinction = light.bands.mean(lambda nm: at_550 * (nm / _VISIBILITY_NM) ** -power)
    elif angstrom is not None:
        raise Error("angstrom: goes with visibility_m, found none")
    elif layer_height_m is not None:
        raise Error("layer_height_m: goes with visibility_m or extinction_per_m, found none")
    else:
        extinction = light.bands.mean(_of_clear_sky(*_air_of(light)))
    light = replace(light, extinction_per_m=extinction)
    return _through_layer(light, extinction * height) if height > 0 else light


def _warn_of_fog(visibility_m: float, layer_height_m: float | None) -> None:
    if visibility_m < _LEAST_FOG_M:
        warn_caller(
            f"visibility_m: {visibility_m:g} m is less than fogs have; is it in kilometres?",
            UserWarning,
        )
    elif visibility_m < _FOG_M and layer_height_m is None:
        warn_caller(
            "visibility_m: this is fog, and the sky stays as it was, so that what stands high "
            "before it does not vanish: say how high the fog reaches, as "
            "layer_height_m=100, or layer_height_m=0 if that is meant",
            UserWarning,
        )


def _through_layer(light: Light, depth: Floats) -> Light:
    """A light as it is below a layer of that optical depth, (B,), which scatters only."""
    discs = tuple(
        replace(one, radiance=one.radiance * _left(depth, one.direction[1:2])[0])
        for one in light.discs
    )
    if light.sky is None and not discs:
        return light
    dark = np.zeros((2, 2, 4, 1, len(light.bands)), np.float32)
    before = dark if light.sky is None else light._sky_in_bands()
    rows, columns = max(_ROWS, before.shape[1]), before.shape[2]
    sky = sky_map.on_grid(before, rows, columns).copy()
    left = _left(depth, np.sin(sky_map.sky_nodes(rows, columns)[0][0]))
    sky[0] *= left[:, None, None]
    straight = replace(light, sky=sky, band_from_channel=None, discs=discs)
    weights = sky_map.level_weights(rows, columns)[:, None] * columns
    passed = 2 / (2 + (1 - _FOG_COSINE) * depth)
    scattered = passed * sum(light.irradiance()) - sum(straight.irradiance())
    even = np.maximum(scattered, 0) / np.maximum((weights * (1 - left)).sum(axis=0), 1e-12)
    sky[0, :, :, 0] += ((1 - left) * even)[:, None]
    return replace(straight, sky=sky)


def _left(depth: Floats, sine: Floats) -> Floats:
    """What a layer leaves of light from elevations of these sines: (N, B)."""
    return np.asarray(np.exp(-depth / np.maximum(sine, 1e-9)[:, None]) * (sine > 0)[:, None])


def _kim_exponent(visibility_km: float) -> float:
    if visibility_km >= 50:
        return 1.6
    if visibility_km >= 6:
        return 1.3
    if visibility_km >= 1:
        return 0.16 * visibility_km + 0.34
    return max(0.0, visibility_km - 0.5)


def _of_clear_sky(aerosol: float, height_m: float, haze_kind: str) -> Callable[[Floats], Floats]:
    """Extinction, m⁻¹, by wavelength of the air at the ground under a clear sky."""
    pressure, warmth = air_above(height_m)
    dense = pressure / warmth

    def extinction_per_m(nm: Floats) -> Floats:
        air, haze = depths_of_air_and_haze(nm, haze_kind)
        return dense * air / AIR_HEIGHT_M + aerosol * haze / _HAZE_HEIGHT_M

    return extinction_per_m


def _air_of(light: Light) -> tuple[float, float, str]:
    """Haze that a light's sky was computed with, height of the ground, m, and the kind of haze."""
    recipe = light.recipe
    while recipe is not None:
        name, arguments = recipe
        if name in _OWN_AIR:
            aerosol = arguments.get("aerosol", CLEAR_SKY_AEROSOL)
            height_m = float(arguments.get("height_m", 0.0))
            return float(aerosol), height_m, arguments.get("haze_kind", "rural")
        recipe = arguments["light"].recipe if name in _SAME_AIR else None
    raise Error(
        "visibility_m: expected a number, such as 27e3, or extinction_per_m, as only lights of "
        f"{', '.join(_OWN_AIR)} say how much air and haze there are: found {light!r:.80}"
    )
