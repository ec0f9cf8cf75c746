"""Light under water: the sky through Snell's window, and what the water itself scatters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Spectrum
from omma.base.arguments import array_of, as_named, checked, one_of, within
from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.base.warn import warn_caller
from omma.light import sky_map
from omma.light.bands import Bands
from omma.light.discs import SMALLEST_DISC_RAD, Disc
from omma.light.lights import Light, is_under_water, makes_light
from omma.light.sky_tables import check_range
from omma.light.water_types import (
    ABSORPTION,
    BACK,
    scattering_by_molecules,
    scattering_by_particles,
)

_DEEPEST_M = 1000.0
_INDICES = (1.3, 1.4)
# Particles: Fournier and Forand's phase function with this relative index and slope, which make
# 0.0183 of the light turn back as in Petzold's mean of measurements (Mobley, Sundman and Boss,
# Appl. Opt. 41:1035, 2002; recalled, the share is tested).
_PARTICLE_INDEX, _PARTICLE_SLOPE = 1.10, 3.5835
# Light that particles turn by less goes on as if it had not been scattered.
_FORWARD_RAD = np.radians(45.0)
# Molecules: 1 + (1 - d) / (1 + d) cos² of the angle, with d = 0.09 (Morel 1974).
_MOLECULES = (1 - 0.09) / (1 + 0.09)
_ANGLES = np.linspace(0, np.pi, 1801)

# How often light may be scattered on its way down, b z, for one scattering to tell its radiance to
# a third (docs/light.md).
_MOST_SCATTERED = 6.0

# Rows of the map, at least. Columns at which scattering is computed, rings of the sky from which it
# is, and directions across each.
_ROWS, _COLUMNS, _RINGS, _FINE = 181, 72, 18, 5


@dataclass(frozen=True)
class _Water:
    """Of each band, m⁻¹, (B,): absorption; scattering by particles and by molecules."""

    absorption: Floats
    particles: Floats
    molecules: Floats

    @property
    def extinction(self) -> Floats:
        return self.absorption + self.particles + self.molecules

    @property
    def loss(self) -> Floats:
        """What a beam loses with all that counts as scattered out of it."""
        kept = 2 * np.pi * _ANGLES[1] * _particle_phase(_ANGLES) @ np.sin(_ANGLES)
        return np.asarray(self.absorption + kept * self.particles + self.molecules)

    @property
    def wide_loss(self) -> Floats:
        """What light loses that comes from many sides, so that only what turns back is missing
        (a + b_b: Gordon, Appl. Opt. 12:2803, 1973)."""
        return np.asarray(self.absorption + BACK * self.particles + self.molecules / 2)


@checked
@makes_light
def under_water(
    light: Light,
    depth_m: float,
    water: str | None = None,
    *,
    absorption_per_m: Spectrum | ArrayLike | None = None,
    scattering_per_m: Spectrum | ArrayLike | None = None,
    refractive_index: float = 1.34,
) -> Light:
    """What an animal under a level water surface has around it, of a light above.

    Within Snell's window, sin θ < 1/n, is the sky of the refracted direction, n² (1 - R) times as
    bright, polarised by Fresnel's transmission. Around it and below is light that water scattered
    once; above the horizon also such light from below, which the surface reflects. Surfaces fade
    with distance by exp(-c d), c = a + b (Duntley, J. Opt. Soc. Am. 53:214, 1963), as with
    `with_air`. The water is as deep as light reaches and the same everywhere. docs/light.md says
    what is left out.

    Args:
        light: above the water, with a sky; what it has below its horizon does not count.
        depth_m: of the animal below the surface, 0 to 1000 m. The light is that of this depth.
        water: its type after Jerlov: "I", "IA", "IB", "II", "III" (ocean, from the clearest),
            "1C", "3C", "5C", "7C", "9C" (coast). None: "IB", unless it is given as measured.
        absorption_per_m: a as measured, above 0, a number, (B,) or a spectrum; with
            ``scattering_per_m``, instead of ``water``.
        scattering_per_m: b as measured, given alike. Up to what pure sea water scatters it is
            by molecules, the rest by particles.
        refractive_index: n of the water, 1.3 to 1.4, for all bands.

    Example:
        >>> bands = omma.light.Bands.equal(8, 400, 700)
        >>> noon = omma.light.clear_sky(60.0, bands=bands)
        >>> reef = omma.light.under_water(noon, 5.0, "IB")
        >>> reef.extinction_per_m.round(2)
        array([0.18, 0.17, 0.17, 0.18, 0.21, 0.35, 0.44, 0.57])

    Warns:
        UserWarning: so turbid and deep that the light is more than a third too bright.

    Raises:
        omma.Error: a light without a sky, one that is under water already or with shadows of
            clouds, an unknown type, bands beyond 300 to 700 nm, a number out of range, one of a and
            b without the other, or both and a type.
    """
    within(depth_m, "depth_m", 0, _DEEPEST_M)
    n = within(refractive_index, "refractive_index", *_INDICES)
    if light.sky is None:
        raise Error("light: expected one with a sky, found none")
    if is_under_water(light):
        raise Error("light: expected one above the water, found one under water")
    if light.cloud_shadow is not None:
        raise Error("light: expected one whose clouds cast no shadows, found a cloud_shadow")
    check_range(light.bands.wavelength_nm)
    if absorption_per_m is None and scattering_per_m is None:
        kind = one_of("IB" if water is None else water, ABSORPTION, "water")
        medium = _of_type(kind, light.bands)
    elif water is not None:
        raise Error("water: expected none beside absorption_per_m and scattering_per_m")
    elif absorption_per_m is None or scattering_per_m is None:
        raise Error("absorption_per_m, scattering_per_m: expected both or none of them")
    else:
        medium = _as_measured(absorption_per_m, scattering_per_m, light.bands)
    often = float(np.max(medium.particles)) * depth_m
    if often > _MOST_SCATTERED:
        warn_caller(
            f"depth_m: at {depth_m:g} m light has been scattered {often:.0f} times on its way; "
            f"beyond {_MOST_SCATTERED:g} it comes out too bright (docs/light.md, under water)",
            UserWarning,
        )
    # Just below the surface, and then at the depth.
    discs = tuple(_refracted(one, n) for one in light.discs if one.direction[1] > 0)
    above = light._sky_in_bands()
    sky = _sky_under(above, discs, medium, depth_m, n)
    dimmed = tuple(
        replace(one, radiance=one.radiance * np.exp(-medium.loss * depth_m / one.direction[1]))
        for one in discs
    )
    return Light(light.bands, light.unit, sky, discs=dimmed, extinction_per_m=medium.extinction)


def _of_type(kind: str, bands: Bands) -> _Water:
    return _Water(
        bands.mean(*ABSORPTION[kind]),
        bands.mean(lambda nm: scattering_by_particles(kind, nm)),
        bands.mean(scattering_by_molecules),
    )


def _as_measured(
    absorption: Spectrum | ArrayLike, scattering: Spectrum | ArrayLike, bands: Bands
) -> _Water:
    given = []
    for name, one in (("absorption_per_m", absorption), ("scattering_per_m", scattering)):
        with as_named(spectrum=name):
            values = bands.mean(one) if isinstance(one, Spectrum) else array_of(one, name)
        if values.shape not in ((), (len(bands),)):
            raise Error(
                f"{name}: expected a number, ({len(bands)},) or a spectrum, found {values.shape}"
            )
        least = 1e-9 if name == "absorption_per_m" else 0.0
        if not np.all((values >= least) & (values <= 500)):
            raise Error(f"{name}: expected {least:g} to 500 per m, found {values.tolist()!r:.60}")
        given.append(np.full(len(bands), values) if values.ndim == 0 else values)
    molecules = np.minimum(given[1], bands.mean(scattering_by_molecules))
    return _Water(given[0], given[1] - molecules, molecules)


def _fournier_forand(angle: Floats) -> Floats:
    """Phase function, sr⁻¹ (Fournier and Forand 1994; the form of Fournier and Jonasz, Proc. SPIE
    3761:62, 1999), of particles that are as many as size^-slope."""
    v = (3 - _PARTICLE_SLOPE) / 2
    sine = np.sin(np.maximum(angle, 1e-6) / 2) ** 2
    most = 4 / (3 * (_PARTICLE_INDEX - 1) ** 2)
    d = most * sine
    d_v, most_v = d**v, most**v
    forward = v * (1 - d) - (1 - d_v) + (d * (1 - d_v) - v * (1 - d)) / sine
    back = (1 - most_v) / (16 * np.pi * (most - 1) * most_v) * (3 * np.cos(angle) ** 2 - 1)
    return np.asarray(forward / (4 * np.pi * (1 - d) ** 2 * d_v) + back)


def _particle_phase(angle: Floats) -> Floats:
    """Of what particles scatter, but for what goes on: not above its value at 45°."""
    return _fournier_forand(np.maximum(angle, _FORWARD_RAD))


def _fresnel(cos_water: Floats, n: float) -> tuple[Floats, Floats, Floats]:
    """Transmitted shares T_s and T_p between air and water, by the cosine in water; and the cosine
    in air, 0 beyond the critical angle, where both are 0."""
    cos_water = np.maximum(cos_water, 1e-9)
    sine = n * np.sqrt(np.maximum(1 - cos_water**2, 0))
    cos_air = np.sqrt(np.maximum(1 - sine**2, 0))
    across = ((cos_air - n * cos_water) / (cos_air + n * cos_water)) ** 2
    along = ((n * cos_air - cos_water) / (n * cos_air + cos_water)) ** 2
    return 1 - across, 1 - along, cos_air


def _refracted(disc: Disc, n: float) -> Disc:
    """A disc as it is just below the surface: round, of the solid angle that its middle has."""
    cos_air = float(disc.direction[1])
    level = disc.direction * (1, 0, 1) / n
    cos_water = float(np.sqrt(1 - level @ level))
    t_s, t_p, _ = _fresnel(np.array(cos_water), n)
    narrower = np.sqrt(cos_air / (n**2 * cos_water))
    radius = max(disc.angular_radius_rad * narrower, SMALLEST_DISC_RAD)
    spread = (np.sin(disc.angular_radius_rad) * narrower / np.sin(radius)) ** 2
    return replace(
        disc,
        direction=level + (0, cos_water, 0),
        angular_radius_rad=radius,
        radiance=disc.radiance * float(n**2 * (t_s + t_p) / 2 * spread),
    )


def _transmitted(stokes: Floats, t_s: Floats, t_p: Floats) -> Floats:
    """Stokes vectors (..., 1 or 3, B) through the surface, of unchanged solid angle: (..., 3, B).
    Q > 0 is light that swings in the vertical plane, which is that of incidence."""
    t_s, t_p = t_s[..., None], t_p[..., None]
    intensity = stokes[..., 0, :]
    q, u = (stokes[..., 1, :], stokes[..., 2, :]) if stokes.shape[-2] == 3 else (0.0, 0.0)
    return np.stack(
        [
            ((t_p + t_s) * intensity + (t_p - t_s) * q) / 2,
            ((t_p - t_s) * intensity + (t_p + t_s) * q) / 2,
            np.sqrt(t_s * t_p) * u + 0 * intensity,
        ],
        axis=-2,
    )


def _sky_under(
    above: sky_map.Map, discs: tuple[Disc, ...], medium: _Water, depth_m: float, n: float
) -> sky_map.Map:
    """The map at a depth; discs as they are just below the surface."""
    rows, columns = max(_ROWS, above.shape[1]), max(_COLUMNS, above.shape[2])
    elevation, azimuth = sky_map.sky_nodes(rows, columns)
    up = np.sin(elevation[0])
    t_s, t_p, cos_air = _fresnel(up, n)
    refracted = direction(np.degrees(azimuth), np.degrees(np.arcsin(cos_air))[:, None])
    seen = n**2 * _transmitted(sky_map.look_up(above, refracted), t_s[:, None], t_p[:, None])
    scattered, rising = _scattered(_rings(above, n), discs, medium, depth_m, rows)
    # At the horizon the way to the surface has no end.
    through = np.exp(-medium.loss * depth_m / np.maximum(up, 1e-9)[:, None])
    own = scattered.copy()
    own[0] += (1 - (t_s + t_p) / 2)[:, None, None] * rising * through[:, None]
    sky = np.zeros((2, rows, columns, 3, len(medium.absorption)), np.float32)
    own_map = own[..., None, :].astype(np.float32)
    sky[:, :, :, :1] = sky_map.on_grid(own_map, rows, columns)
    sky[0] += seen * through[:, None, None]
    return sky


def _rings(above: sky_map.Map, n: float) -> list[tuple[float, Floats]]:
    """The sky's light just below the surface, by elevation: the cosine from the vertical, and
    radiance times solid angle by azimuth, that of columns (columns, B)."""
    tall, wide = _RINGS * _FINE, _COLUMNS * _FINE
    elevation = (np.arange(tall) + 0.5) * np.pi / 2 / tall
    azimuth = (np.arange(wide) - _FINE // 2) * 2 * np.pi / wide
    cos_air = np.sin(elevation)
    cos_water = np.sqrt(1 - (1 - cos_air**2) / n**2)
    t_s, t_p, _ = _fresnel(cos_water, n)
    towards = direction(np.degrees(azimuth), np.degrees(elevation)[:, None])
    below = _transmitted(sky_map.look_up(above, towards), t_s[:, None], t_p[:, None])[..., 0, :]
    solid_angle = np.cos(elevation) * (np.pi / 2 / tall) * (2 * np.pi / wide)
    below *= (solid_angle * cos_air / cos_water)[:, None, None]
    flux = below.reshape(_RINGS, _FINE, _COLUMNS, _FINE, -1).sum(axis=(1, 3))
    return list(zip(cos_water.reshape(_RINGS, _FINE).mean(axis=1).tolist(), flux))


def _scattered(
    rings: list[tuple[float, Floats]],
    discs: tuple[Disc, ...],
    medium: _Water,
    depth_m: float,
    rows: int,
) -> tuple[Floats, Floats]:
    """Light that was scattered once, as it is seen at a depth in directions of the map (2, rows,
    columns, B); and what rises to the surface by how steeply, (rows, columns, B).

    Along a line of sight that reaches the surface after z / μ, from light that comes at μ' to the
    vertical: z / μ (exp(-c z / μ') - exp(-c z / μ)) / (c z / μ - c z / μ'). Downward, where the
    line has no end, exp(-c z / μ') / (c (1 + μ / μ')).
    """
    elevation, azimuth = sky_map.sky_nodes(rows, _COLUMNS)
    views = direction(np.degrees(azimuth), np.degrees(elevation)[..., None])
    up = np.sin(elevation[0])[:, None]
    scattered = np.zeros((*views.shape[:-1], len(medium.wide_loss)))
    rising = np.zeros(scattered.shape[1:])

    def add(cos: float, source: Floats) -> None:
        to_surface, endless, arriving = _lengths(up, cos, medium.wide_loss, depth_m)
        scattered[0] += to_surface[:, None] * source[0]
        scattered[1] += (endless * arriving)[:, None] * source[1]
        rising[:] += endless[:, None] * source[1]

    for cos, flux in rings:
        # About the vertical only the azimuth between source and view counts: a convolution.
        ahead = direction(0.0, np.degrees(np.arcsin(cos)))
        about = np.fft.rfft(flux, axis=0)
        shares = [np.fft.rfft(one, axis=2)[..., None] * about for one in _turned(views @ ahead)]
        mixed = medium.particles * shares[0] + medium.molecules * shares[1]
        add(cos, np.fft.irfft(mixed, _COLUMNS, axis=2))
    for disc in discs:
        particles, molecules = (one[..., None] for one in _turned(views @ disc.direction))
        by_both = medium.particles * particles + medium.molecules * molecules
        add(float(disc.direction[1]), disc.irradiance() * by_both)
    return scattered, rising


def _turned(cosine: Floats) -> tuple[Floats, Floats]:
    """The phase functions of particles and of molecules by the cosine of the angle, sr⁻¹."""
    angle = np.arccos(np.clip(cosine, -1, 1))
    molecules = (1 + _MOLECULES * cosine**2) / (4 * np.pi * (1 + _MOLECULES / 3))
    return np.interp(angle, _ANGLES, _particle_phase(_ANGLES)), molecules


def _lengths(up: Floats, cos: float, loss: Floats, depth_m: float) -> tuple[Floats, Floats, Floats]:
    """Lengths, m, over which a source counts that falls with depth: on the way to the surface,
    (rows, B), without end from the surface down, (rows, B); and what is left of it at the depth."""
    endless = 1 / (loss * (1 + up / cos))
    arriving = np.exp(-loss * depth_m / cos)
    slant, own = loss * depth_m / np.maximum(up, 1e-9), loss * depth_m / cos
    apart = np.maximum(np.abs(slant - own), 1e-12)
    to_surface = slant / loss * np.exp(-np.minimum(slant, own)) * -np.expm1(-apart) / apart
    to_surface[0] = endless[0] * arriving  # level: the surface is never reached
    return to_surface, endless, arriving
