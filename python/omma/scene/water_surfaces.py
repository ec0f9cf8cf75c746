"""Water seen from above, as a material: what its waves mirror and what comes out of it.

Below the surface the water, and a bottom, send back a share R of the light that goes down, alike in
all directions. Of what comes up the surface throws a share i back, more than of what comes down, as
all beyond the critical angle is mirrored: 1 - i = (1 - e) / n², with e the share that it mirrors of
uniform light from above. So of what has got in

    rho = R (1 - i) (1 + i R + (i R)² + ...) = R (1 - i) / (1 - i R)

comes out again. That is the `reflectance` of a material's base, and what Omma makes of it,
rho / pi (1 - E(o)) (1 - E(w)) / (1 - e) (src/physics/surface/scatter.h), is for a level surface
t(o) t(w) / n² R / (1 - i R) / pi: light refracted in, sent back and refracted out, at all angles.
"""

from __future__ import annotations

import numpy as np

from omma._core import Error, Material, Spectrum
from omma.base.arguments import checked, one_of, within
from omma.base.arrays import Floats
from omma.light.water_types import (
    ABSORPTION,
    BACK,
    TURNED,
    scattering_by_molecules,
    scattering_by_particles,
)
from omma.scene.facets import surface_albedo
from omma.scene.materials import natural_materials
from omma.scene.reflectances import check_reach
from omma.scene.spectrum_colours import linear_srgb, luminance

_NM = np.arange(300.0, 701.0, 5.0)
_DEEPEST_M = 1000.0
_INDICES = (1.3, 1.4)
# Cox and Munk (J. Opt. Soc. Am. 44:838, 1954): the mean square of slopes in all directions is this
# + this times the wind 12.5 m above the sea, up to so many m/s (as public transcriptions have it).
_CALM, _PER_WIND, _MOST_WIND = 0.003, 0.00512, 14.0
# No wave is steeper than 30 degrees, where it breaks (Stokes 1880; recalled).
_STEEPEST = float(np.tan(np.radians(30.0)) ** 2)
# What endless water sends up is this times X = b_b / (a + b_b) (Morel and Prieur, Limnol. Oceanogr.
# 22:709, 1977; recalled).
_SENT_UP = 0.33
# Where X is above 0.072 it is more: pi times the radiance that goes straight up over what goes
# down, under suns whose light goes down at a cosine of 0.86, the mean of an even sky (Albert and
# Mobley, Opt. Express 11:2873, 2003, as the package bio_optics has it); this times a polynomial.
_TURBID = np.pi * 0.0512 * (1 + 0.4021) * (1 + 0.1098 / 0.86)
_BY_SHARE = (1.0, 4.6659, -7.8387, 5.4571)
# K = this (a + b_b), of the way down and up again: found here with photons (docs/materials.md).
_DOWN = 1.3


@checked
def water(
    kind: str | None = None,
    *,
    wind_m_per_s: float | None = None,
    mean_square_slope: float | None = None,
    depth_m: float | None = None,
    bottom: str | float | Spectrum | None = None,
    absorption_per_m: Spectrum | float | None = None,
    scattering_per_m: Spectrum | float | None = None,
    refractive_index: float = 1.34,
) -> Material:
    """Water seen from above, as a material of scenes, for worlds that are lit.

    Its surface mirrors as Fresnel says and polarises, level or with slopes of waves
    (`wave_roughness`). Just below it the water sends up R of the light that goes down, 0.33
    b_b / (a + b_b) (Morel and Prieur 1977), of turbid water more (Albert and Mobley 2003), or with
    a bottom of reflectance A at depth z R + (A - R) exp(-2 K z), K = 1.3 (a + b_b) (Maritorena,
    Morel and Gentili 1994, eq. 9a). Light is refracted in and out. docs/materials.md says how exact
    that is.

    Args:
        kind: the water's type after Jerlov: "I", "IA", "IB", "II", "III" (ocean, from the
            clearest), "1C", "3C", "5C", "7C", "9C" (coast), as of `omma.light.under_water`. None:
            "IB", unless it is given as measured.
        wind_m_per_s: 12.5 m above the water, 0 to 14. 0 or None: it is level.
        mean_square_slope: of the waves, in all directions together, instead of a wind.
        depth_m: of the bottom, 0 to 1000 m. None: no light comes back from there.
        bottom: what lies there: the name of a natural material, whose diffuse reflectance counts,
            a reflectance from 400 nm or below to 700 nm, or one number for all wavelengths.
        absorption_per_m: a as measured, with ``scattering_per_m``, instead of ``kind``: a spectrum,
            or one number for all wavelengths.
        scattering_per_m: b as measured. Up to what pure sea water scatters it is by molecules, of
            which half goes back, the rest by particles, of which 0.0183 does.
        refractive_index: n of the water, 1.3 to 1.4, for all wavelengths.

    Example:
        >>> lake = omma.scene.water("3C", wind_m_per_s=4)
        >>> shore = omma.scene.water("IB", depth_m=2, bottom="sand")
        >>> [round(float(one.reflectance.value[40]), 3) for one in (lake, shore)]   # at 500 nm
        [0.015, 0.163]

    Raises:
        omma.Error: an unknown type or bottom, a number out of range, a bottom without a depth or a
            depth without a bottom, both a wind and slopes, a or b alone or beside a type, spectra
            that do not reach over 400 to 700 nm or hold what cannot be.
    """
    n = within(refractive_index, "refractive_index", *_INDICES)
    roughness = _roughness(wind_m_per_s, mean_square_slope)
    nm, a, molecules, particles = _inside(kind, absorption_per_m, scattering_per_m)
    back = BACK * particles + molecules / 2
    below = _sent_up(back / (a + back))
    if bottom is not None or depth_m is not None:
        nm, below = _above_bottom(nm, below, _DOWN * (a + back), depth_m, bottom)
    reflectance = leaving(below, surface_albedo(roughness**2, n), n)
    color = linear_srgb(nm, reflectance)
    return Material(
        "water" if absorption_per_m is not None else f"water {kind or 'IB'}",
        base_color=color,
        ior=n,
        roughness=roughness,
        reflectance=Spectrum(nm, reflectance),
        spectral_luminance=luminance(color) or 1.0,  # black: any does
    )


@checked
def water_volume(
    kind: str | None = None,
    *,
    wind_m_per_s: float | None = None,
    mean_square_slope: float | None = None,
    absorption_per_m: Spectrum | float | None = None,
    scattering_per_m: Spectrum | float | None = None,
    refractive_index: float = 1.34,
) -> Material:
    """Water that one looks into, as the material of its surface: a level mesh or one with waves,
    whose front is above.

    What lies below is a part of the scene. Rays from the eye bend at the surface by Snell's law, at
    the facets of waves by theirs (`wave_roughness`); it mirrors and polarises as Fresnel says. The
    water takes

        k = a + b of molecules + 0.109 b of particles

    of light on its way, per m: what particles turn by less than 45 degrees counts as not scattered
    (as of `omma.light.under_water`). It gives no light of its own, so far things get dark, not
    veiled: for deep water take `water`. docs/materials.md says what else is left out.

    Args:
        kind: the water's type after Jerlov, as of `water`. None: "IB", unless it is given as
            measured.
        wind_m_per_s: 12.5 m above the water, 0 to 14. 0 or None: its facets are those of the mesh.
        mean_square_slope: of the waves, in all directions together, instead of a wind.
        absorption_per_m: a as measured, with ``scattering_per_m``, instead of ``kind``: a spectrum,
            or one number for all wavelengths.
        scattering_per_m: b as measured. Up to what pure sea water scatters it is by molecules.
        refractive_index: n of the water, 1.3 to 1.4, for all wavelengths.

    Example:
        >>> pool = omma.scene.water_volume("IB")
        >>> scene = omma.scene.plane((8, 8)).replace(materials=[pool])

    Raises:
        omma.Error: an unknown type, a number out of range, both a wind and slopes, a or b alone or
            beside a type, spectra that do not reach over 400 to 700 nm or hold what cannot be.
    """
    n = within(refractive_index, "refractive_index", *_INDICES)
    roughness = _roughness(wind_m_per_s, mean_square_slope)
    nm, a, molecules, particles = _inside(kind, absorption_per_m, scattering_per_m)
    return Material(
        "water" if absorption_per_m is not None else f"water {kind or 'IB'}",
        ior=n,
        roughness=roughness,
        transmission=1.0,
        thickness_m=1.0,
        absorption_per_m=Spectrum(nm, a + molecules + TURNED * particles),
        reflectance=Spectrum(nm[[0, -1]], np.ones(2)),
    )


@checked
def wave_roughness(
    wind_m_per_s: float | None = None, *, mean_square_slope: float | None = None
) -> float:
    """The roughness of a material, as in glTF, whose facets slope as water's waves do.

    Slopes at sea are normally distributed, with mean square m = 0.003 + 0.00512 U in all directions
    together (Cox and Munk 1954). Those of Omma's facets follow GGX; its alpha, the square of the
    roughness, is the root of m, so that as many facets are level as at sea: glitter is as bright
    in its middle. It is narrower there by a quarter, and its tails are longer (docs/materials.md).

    Args:
        wind_m_per_s: U, 12.5 m above the water, 0 to 14; 0 is a level surface, without swell.
        mean_square_slope: m instead, 0 to 1/3: waves break where they slope by 30 degrees.

    Example:
        >>> pond = omma.scene.natural_material("pond water")
        >>> windy = pond.replace(roughness=omma.scene.wave_roughness(3.0))
        >>> round(windy.roughness, 3)
        0.368

    Raises:
        omma.Error: a number out of range, or both or none of them.
    """
    if (wind_m_per_s is None) == (mean_square_slope is None):
        found = "none" if wind_m_per_s is None else "both"
        raise Error(f"wind_m_per_s, mean_square_slope: expected one of them, found {found}")
    if mean_square_slope is not None:
        mean_square = within(mean_square_slope, "mean_square_slope", 0, _STEEPEST)
    elif wind_m_per_s is not None:
        wind = within(wind_m_per_s, "wind_m_per_s", 0, _MOST_WIND)
        mean_square = _CALM + _PER_WIND * wind if wind > 0 else 0.0
    return float(mean_square**0.25)


def _roughness(wind_m_per_s: float | None, mean_square_slope: float | None) -> float:
    if wind_m_per_s is None and mean_square_slope is None:
        return 0.0
    return wave_roughness(wind_m_per_s, mean_square_slope=mean_square_slope)


def leaving(below: Floats, albedo: float, n: float) -> Floats:
    """Of light that has got in, the share that comes out again, (W,): rho, by what the water sends
    back below the surface and what the surface mirrors of uniform light."""
    inside = 1 - (1 - albedo) / n**2
    return np.asarray(below * (1 - inside) / (1 - inside * below))


def _sent_up(share: Floats) -> Floats:
    """R of endless water by b_b / (a + b_b)."""
    turbid = _TURBID * np.polynomial.polynomial.polyval(share, _BY_SHARE)
    return np.asarray(share * np.maximum(_SENT_UP, turbid))


def _inside(
    kind: str | None, absorption: Spectrum | float | None, scattering: Spectrum | float | None
) -> tuple[Floats, Floats, Floats, Floats]:
    """Wavelengths, nm, and what the water absorbs there, and what its molecules and particles
    scatter, m⁻¹, (W,) each."""
    if absorption is None and scattering is None:
        kind = one_of("IB" if kind is None else kind, ABSORPTION, "kind")
        values, nodes = ABSORPTION[kind]
        particles, molecules = scattering_by_particles(kind, _NM), scattering_by_molecules(_NM)
        return _NM, np.interp(_NM, nodes, values), molecules, particles
    if kind is not None:
        raise Error("kind: expected none beside absorption_per_m and scattering_per_m")
    if absorption is None or scattering is None:
        raise Error("absorption_per_m, scattering_per_m: expected both or none of them")
    absorption, scattering = _spectrum(absorption), _spectrum(scattering)
    for name, one, least in (
        ("absorption_per_m", absorption, 1e-9),
        ("scattering_per_m", scattering, 0.0),
    ):
        check_reach(one, name)
        if not np.all((one.value >= least) & (one.value <= 500)):
            raise Error(
                f"{name}: expected {least:g} to 500 per m, found {one.value.min():g} to "
                f"{one.value.max():g}"
            )
    nm = _from(max(absorption.wavelength_nm[0], scattering.wavelength_nm[0]))
    whole = _at(nm, scattering)
    molecules = np.minimum(whole, scattering_by_molecules(nm))
    return nm, _at(nm, absorption), molecules, whole - molecules


def _spectrum(value: Spectrum | float) -> Spectrum:
    """A number stands for all wavelengths."""
    if isinstance(value, Spectrum):
        return value
    return Spectrum(_NM[[0, -1]], np.full(2, float(value)))


def _above_bottom(
    nm: Floats,
    deep: Floats,
    falls: Floats,
    depth_m: float | None,
    bottom: str | float | Spectrum | None,
) -> tuple[Floats, Floats]:
    """Wavelengths, and what comes up below the surface of what goes down, with a bottom.

    deep: the same of endless water. falls: K, m⁻¹.
    """
    if depth_m is None:
        raise Error("depth_m: expected that of the bottom, found None")
    if bottom is None:
        raise Error("bottom: expected what lies at depth_m, found None")
    depth = within(depth_m, "depth_m", 0, _DEEPEST_M)
    if isinstance(bottom, str):
        ground = {name: one for name, one in natural_materials().items() if "water" not in name}
        one = ground[one_of(bottom, ground, "bottom", ", a spectrum or 0 to 1")]
        albedo = Spectrum(one.wavelength_nm, one.reflectance)
    elif isinstance(bottom, Spectrum):
        check_reach(bottom, "bottom")
        if bottom.value.max() > 1:
            raise Error(f"bottom: expected a reflectance of 0 to 1, found {bottom.value.max():g}")
        albedo = bottom
    else:
        if not 0 <= bottom <= 1:
            raise Error(
                "bottom: expected the name of a natural material, a spectrum of its reflectance or "
                f"one number from 0 to 1, found {bottom!r:.40}"
            )
        albedo = _spectrum(bottom)
    common = _from(max(nm[0], albedo.wavelength_nm[0]))
    deep, falls = np.interp(common, nm, deep), np.interp(common, nm, falls)
    return common, deep + (_at(common, albedo) - deep) * np.exp(-2 * falls * depth)


def _from(low_nm: float) -> Floats:
    """Wavelengths of a material from there on."""
    return np.unique(np.maximum(_NM, low_nm))


def _at(nm: Floats, spectrum: Spectrum) -> Floats:
    return np.interp(nm, spectrum.wavelength_nm, spectrum.value)
