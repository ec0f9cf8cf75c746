"""Clouds before a sky: broken, thin or a deck, that hide it, let it through and scatter light."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import arrays_of, checked, one_of, positive, whole, within
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.light import sky_map
from omma.light.bands import Bands
from omma.light.cie_skies import scattered
from omma.light.cloud_shadow import CloudShadow
from omma.light.discs import Disc
from omma.light.lights import Light, is_under_water, makes_light
from omma.light.skies import CLOUDS_BY_NIGHT, check_not_night, clear_sky
from omma.light.units import Unit

Kind = Literal["cumulus", "cirrus", "deck"]

ROWS, COLUMNS = 91, 360
# Of droplets and crystals in visible light (recalled): the mean cosine of scattering.
_ASYMMETRY = 0.85
# The field of noise that clouds are cut from: a square that repeats, in heights of the layer.
_CELLS, _SIDE = 512, 16.0
# Nodes of its shadow in a cell, which are then closer than half-shade by the sun's disc is wide.
_FINER = 4
# A disc that is weaker than this share of itself is not there.
_LEAST_SHARE = 1e-9


@dataclass(frozen=True)
class _Kind:
    """optical_depth: in the middle of a cloud, upwards, far from its edges.
    edge: over how much of the field's standard deviation it thickens.
    scales: of its shapes along and across, in heights of the layer.
    indicatrix: c, d, e of ISO 15469, how its own light is spread about the sun.
    gradation: what its own light is in the zenith over the horizon.
    """

    optical_depth: float
    edge: float
    scales: tuple[float, float]
    indicatrix: tuple[float, float, float]
    gradation: float


_KINDS = {
    "cumulus": _Kind(20.0, 0.4, (0.8, 0.8), (2.0, -1.5, 0.15), 1.0),
    "cirrus": _Kind(0.3, 0.8, (6.0, 0.8), (16.0, -3.0, 0.3), 1.0),
    "deck": _Kind(20.0, 0.15, (2.5, 1.5), (0.0, -1.0, 0.0), 3.0),
}


@checked
@makes_light
def clouded(
    light: Light,
    cloud_fraction: float,
    kind: Kind = "cumulus",
    *,
    optical_depth: float | None = None,
    polarisation: float = 0.1,
    seed: int = 0,
    shadow_height_m: float | None = None,
) -> Light:
    """A light with clouds before its sky and its discs, such as that of `clear_sky`.

    In a direction of elevation e a cloud of optical depth t upwards lets exp(-t / sin e) of the
    light behind it through, also of the sun's disc, polarised as it is. The rest is scattered; what
    of it comes down is that of a level layer that absorbs nothing (`cloud_transmittance`), column
    by column, and of the colour of what falls on the layer. So thin edges are brighter than thick
    middles. docs/light.md says what is left out.

    Args:
        light: with a sky. The disc that gives most light counts as the sun.
        cloud_fraction: share of the sky's solid angle that is cloud, 0 to 1; 1 is a layer without
            gaps, the same everywhere.
        kind: "cumulus", broken and thick; "cirrus", in streaks and thin; "deck", flat and thick.
        optical_depth: upwards, of the thickest cloud; by default 20, 0.3 and 20.
        polarisation: of the scattered light, its degree over that of the sky behind it, 0 to 1. It
            has that sky's angle, as measured (Hegedüs, Akesson and Horváth 2007: degrees up to
            0.16 below thick clouds).
        seed: of the shapes.
        shadow_height_m: of the layer above the world's origin, 1,000 of fair-weather cumulus: the
            same clouds then cast shadows on the ground (`CloudShadow`), and whoever goes on below
            them comes into the sun. None: all is lit as the world's origin is.

    Example:
        >>> sky = omma.light.clouded(omma.light.clear_sky(40), 0.5, "cumulus", seed=3)
        >>> len(sky.discs), sky.sky.shape[1:4]
        (1, (91, 360, 3))

    Raises:
        omma.Error: a light without a sky or under water, a shadow without a disc that would cast
            it, or a number out of range.
    """
    within(cloud_fraction, "cloud_fraction", 0, 1)
    cloud = _KINDS[one_of(kind, _KINDS, "kind")]
    thickest = cloud.optical_depth
    if optical_depth is not None:
        thickest = positive(optical_depth, "optical_depth")
    within(polarisation, "polarisation", 0, 1)
    whole(seed, "seed", 0, 2**63 - 1)
    if light.sky is None:
        raise Error("light: expected one with a sky, found none")
    if is_under_water(light):
        raise Error(
            "light: expected one above the water, found one under water; give clouds to the light "
            "that under_water is given"
        )
    behind = sky_map.on_grid(
        light._sky_in_bands(), max(ROWS, light.sky.shape[1]), max(COLUMNS, light.sky.shape[2])
    )
    rows, columns = behind.shape[1:3]
    elevation, azimuth = (one.copy() for one in sky_map.sky_nodes(rows, columns))
    depth, cast = _depths(elevation[0], azimuth, cloud_fraction, cloud, thickest, seed)
    sine = np.sin(elevation[0])[:, None]
    through = _passed(depth, sine)
    own = _own_light(light, behind, depth, through, cloud)
    sky = np.array(behind)
    above = behind[0].astype(np.float64)
    sky[0] = through[:, :, None, None] * above
    sky[0, :, :, 0] += own
    if behind.shape[3] == 3:
        degree = above[:, :, 1:] / np.maximum(above[:, :, :1], np.finfo(np.float32).tiny)
        sky[0, :, :, 1:] += polarisation * degree * own[:, :, None]
    discs = tuple(
        Disc(one.direction, one.angular_radius_rad, share * one.radiance, one.limb_darkening)
        for one in light.discs
        if (share := _disc_share(one, depth, azimuth)) > _LEAST_SHARE
    )
    clouds = Light(light.bands, light.unit, sky, discs=discs)
    # The ground is as bright as what falls on it.
    before, after = (sum(one.irradiance()) for one in (light, clouds))
    sky[1] *= np.divide(after, before, out=np.zeros_like(after), where=before > 0)
    shadow = None
    if shadow_height_m is not None:
        shadow = _shadow(light.discs, cast(), positive(shadow_height_m, "shadow_height_m"))
    return replace(
        clouds,
        sky=sky,
        discs=discs if shadow is None else light.discs,
        extinction_per_m=light.extinction_per_m,
        cloud_shadow=shadow,
    )


@checked
def cloudy_sky(
    sun_elevation_deg: float,
    cloud_fraction: float = 0.5,
    kind: Kind = "cumulus",
    *,
    sun_azimuth_deg: float = 0.0,
    seed: int = 0,
    shadow_height_m: float | None = None,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """`clear_sky` with clouds before it: `clouded`, by day and in twilight.

    Args:
        sun_elevation_deg, sun_azimuth_deg, bands, unit: as of `clear_sky`.
        cloud_fraction, kind, seed, shadow_height_m: as of `clouded`.

    Raises:
        omma.Error: a number out of range.
    """
    check_not_night(sun_elevation_deg, CLOUDS_BY_NIGHT)
    clear = clear_sky(sun_elevation_deg, sun_azimuth_deg=sun_azimuth_deg, bands=bands, unit=unit)
    return clouded(clear, cloud_fraction, kind, seed=seed, shadow_height_m=shadow_height_m)


@checked
def cloud_transmittance(optical_depth: ArrayLike, sine: ArrayLike | None = None) -> Floats:
    """Share of what falls on a level cloud that comes out below it, straight and scattered.

    The delta-Eddington approximation (Joseph, Wiscombe and Weinman, J. Atmos. Sci. 33:2452, 1976,
    recalled) for a layer that absorbs nothing over black ground: (2/3 + m + (2/3 - m)
    exp(-(1 - g²) t / m)) / (4/3 + (1 - g) t) with a mean cosine of scattering g = 0.85, m the sine
    of the sun's elevation. Within 0.05 of Monte Carlo for suns above 20 degrees.

    Args:
        optical_depth: t, 0 or more.
        sine: m, above 0 to 1. None: light that is even over the sky.

    Example:
        >>> omma.light.cloud_transmittance([0, 1, 20], 0.5).round(2).tolist()
        [1.0, 0.85, 0.27]

    Raises:
        omma.Error: a number out of range.
    """
    if sine is None:
        (depth,) = arrays_of(optical_depth=optical_depth)
    else:
        depth, m = arrays_of(optical_depth=optical_depth, sine=sine)
    if not np.all(depth >= 0):
        raise Error("optical_depth: expected numbers of 0 or more")
    over = 4 / 3 + (1 - _ASYMMETRY) * depth
    if sine is None:
        x, w = np.polynomial.legendre.leggauss(16)
        each = [wk * (xk + 1) * cloud_transmittance(depth, (xk + 1) / 2) for xk, wk in zip(x, w)]
        return np.asarray(sum(each) / 2)
    if not np.all((m > 0) & (m <= 1)):
        raise Error("sine: expected numbers above 0, at most 1")
    forward = np.exp(-(1 - _ASYMMETRY**2) * depth / m)
    return np.asarray((2 / 3 + m + (2 / 3 - m) * forward) / over)


def _own_light(
    light: Light, behind: sky_map.Map, depth: Floats, through: Floats, cloud: _Kind
) -> Floats:
    """Radiance that clouds scatter down, (rows, columns, B).

    For some optical depths it is found what a layer without gaps of that depth scatters down, as
    what comes out below it less what goes straight through, and how strong the shape of its
    radiance must be for that; between these each direction has that of its own depth.
    """
    rows, columns = depth.shape
    elevation, azimuth = sky_map.sky_nodes(rows, columns)
    e, a = elevation[0][:, None], azimuth[None]
    sine = np.sin(e)
    towards = direction(np.degrees(a), np.degrees(e))
    shape = (1 + (cloud.gradation - 1) * sine) * np.ones_like(a)
    sun = _main_disc(light.discs).direction if light.discs else _brightest(behind, towards)
    shape = shape * scattered(towards @ sun, *cloud.indicatrix)
    weights = sky_map.level_weights(rows, columns)
    rings = behind[0, :, :, 0].sum(axis=1, dtype=np.float64)
    of_sky = weights @ rings
    nodes = np.concatenate([[0.0], np.geomspace(0.01, max(float(depth.max()), 0.02), 16)])
    strengths = []
    for node in nodes[1:]:
        straight = _passed(node, sine)
        down = cloud_transmittance(node) * of_sky - (weights * straight[:, 0]) @ rings
        for disc in light.discs:
            m = float(disc.direction[1])
            if m > 0:
                scattered_down = cloud_transmittance(node, m) - np.exp(-node / m)
                down = down + scattered_down * m * disc.irradiance()
        of_shape = weights @ ((1 - straight) * shape).sum(axis=1)
        strengths.append(np.maximum(down, 0) / of_shape)
    strengths.insert(0, strengths[0])
    each = np.stack([np.interp(depth, nodes, one) for one in np.transpose(strengths)], -1)
    return np.asarray(each * ((1 - through) * shape)[:, :, None])


def _main_disc(discs: tuple[Disc, ...]) -> Disc:
    """The sun, or what gives most light in its place: the moon among stars."""
    return max(discs, key=lambda one: float(np.sum(one.irradiance())))


def _brightest(behind: sky_map.Map, towards: Floats) -> Floats:
    bright = behind[0, :, :, 0].sum(axis=-1)
    return np.asarray(towards[np.unravel_index(int(np.argmax(bright)), bright.shape)])


def _passed(depth: Floats | float, sine: Floats) -> Floats:
    # Along the horizon the way through a cloud is long; a thousand of its heights are enough.
    return np.asarray(np.exp(-depth / np.maximum(sine, 1e-3)))


def _disc_share(disc: Disc, depth: Floats, azimuth: Floats) -> float:
    """How much of a disc comes through what is before its centre."""
    m = float(disc.direction[1])
    if m <= 0:
        return 1.0
    field = np.zeros((2, *depth.shape, 1, 1), np.float32)
    field[0, :, :, 0, 0] = depth
    return float(np.exp(-sky_map.look_up(field, disc.direction)[0, 0] / m))


def _shadow(discs: tuple[Disc, ...], depth: Floats, height_m: float) -> CloudShadow:
    """What a field of optical depths casts: at the world's origin as the sky shows it."""
    if not discs:
        raise Error("shadow_height_m: expected a light with a sun or a moon, found no disc")
    x, y, z = _main_disc(discs).direction
    # The sky's layer comes down towards the horizon, the ground's is level: the sun is behind the
    # same cloud.
    apart = height_m * (1 / max(y, 1e-3) - _layer_distance(y)) if y > 0 else 0.0
    spacing = _SIDE / (_FINER * _CELLS) * height_m
    return CloudShadow(depth.astype(np.float32), spacing, height_m, (apart * x, apart * z))


def _layer_distance(sine: Any) -> Any:
    """Of a flat layer that comes down towards the horizon: how far off, over cos e, in heights."""
    return 1 / (sine + 0.2)


def _depths(
    elevation: Floats, azimuth: Floats, fraction: float, cloud: _Kind, thickest: float, seed: int
) -> tuple[Floats, Callable[[], Floats]]:
    """Optical depths upwards, 0 where there is no cloud: of a sky, (rows, columns), and what makes
    those of the field that it shows, _FINER nodes a cell, or all alike."""
    if fraction in (0, 1):
        even = fraction * thickest
        return np.full((len(elevation), len(azimuth)), even), lambda: np.full((2, 2), even)
    e, a = elevation[:, None], azimuth[None]
    out = np.cos(e) * _layer_distance(np.sin(e))
    noise = _noise(cloud.scales, seed)
    field = _field(noise, out * np.sin(a), -out * np.cos(a))
    ring = np.cos(e) * np.ones_like(a)
    ring[0] /= 2
    ring[-1] = np.cos(np.pi / 2 - (elevation[-1] - elevation[-2]) / 4) / 2
    order = np.argsort(-field, axis=None)
    covered = np.cumsum(ring.ravel()[order]) / ring.sum()
    least = field.ravel()[order][np.searchsorted(covered, fraction)]

    def depth(of: Floats) -> Floats:
        return np.asarray(thickest * -np.expm1(-np.maximum(of - least, 0) / cloud.edge))

    def cast() -> Floats:
        at = np.arange(_FINER * _CELLS) * (_SIDE / (_FINER * _CELLS))
        return depth(_field(noise, *np.meshgrid(at, at)))

    return depth(field), cast


def _noise(scales: tuple[float, float], seed: int) -> Floats:
    """Smooth noise of a standard deviation of 1, as long and wide as ``scales``, which repeats."""
    random = np.random.Generator(np.random.Philox(seed))
    wave = np.fft.fftfreq(_CELLS, _SIDE / _CELLS)
    along, across = wave[None] * scales[0], wave[:, None] * scales[1]
    k = np.hypot(along, across)
    # Shapes of the given size, with ever weaker ones down to a twentieth of it.
    power = k**2 * (0.25 + k**2) ** (-2.6) * np.exp(-((k / 20) ** 2))
    noise = np.fft.fft2(random.standard_normal((_CELLS, _CELLS))) * np.sqrt(power)
    field = np.fft.ifft2(noise).real
    return np.asarray(field / field.std())


def _field(noise: Floats, x: Floats, y: Floats) -> Floats:
    """The noise at places, in heights of the layer."""
    from scipy.ndimage import map_coordinates

    places = [(y / _SIDE % 1) * _CELLS, (x / _SIDE % 1) * _CELLS]
    return np.asarray(map_coordinates(noise, places, order=1, mode="grid-wrap"))
