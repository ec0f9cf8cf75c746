"""Receptors: what they are sensitive to, what they make of RGB, and rendering what they answer.

`omma.receptors.ReceptorType` says what a receptor is, `Eye` which ommatidium has which; here is
what follows.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma._core import ReceptorType as ReceptorType
from omma.base.arguments import array_of, arrays_of, checked
from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip
from omma.light.bands import Bands, band_means
from omma.receptors.solid_angles import (
    Field,
    receptor_coupling_efficiency,
    receptor_solid_angle_sr,
)

Responses = NDArray[np.float32]

# Light that receptors are asked about.
_RECEPTOR_RANGE_NM = (300.0, 700.0)
# Mixes of red, green and blue by the words that a world with a light takes, too.
_MIXES = {"dark": (0.0, 0.0, 0.0), "as_blue": (0.0, 0.0, 1.0)}


@checked
def spectral_sensitivity(receptor: ReceptorType | float, wavelength_nm: ArrayLike) -> Any:
    """Relative sensitivity to equal numbers of photons, at wavelengths of any shape, nm.

    ``receptor`` is a type, or the wavelength (nm) where a visual pigment's alpha band peaks. A type
    with a table is linear between its knots and 0 outside. A pigment's absorbance a is the template
    of Govardovskii et al. 2000, see `govardovskii`. Where the rhabdom's absorption k and length l
    are known, it is what the rhabdom absorbs, [1 - exp(-k l a)] / [1 - exp(-k l)]: broader, as the
    pigment screens itself.

    Raises:
        omma.Error: a peak that is out of range, or a type that has neither peak nor table.
    """
    if not isinstance(receptor, ReceptorType):
        receptor = ReceptorType("", peak_wavelength_nm=float(receptor))
    nm = array_of(wavelength_nm, "wavelength_nm")
    return _core.spectral_sensitivity(receptor, np.ascontiguousarray(nm.ravel())).reshape(nm.shape)


@checked
def govardovskii(
    peak_wavelength_nm: float, wavelength_nm: ArrayLike, *, alpha: bool = True, beta: bool = True
) -> Any:
    """Absorbance of a visual pigment with chromophore A1, relative to the peak of its alpha band.

    Template of Govardovskii, Fyhrquist, Reuter, Kuzmin and Donner (Vis Neurosci 17:509, 2000). With
    x = λmax/λ the alpha band is 1/{exp[69.7(a - x)] + exp[28(0.922 - x)] + exp[-14.9(1.104 - x)]
    + 0.674}, a = 0.8795 + 0.0459 exp[-(λmax - 300)²/11940]; the beta band is
    0.26 exp{-[(λ - 189 - 0.315 λmax)/(0.195 λmax - 40.5)]²}. Wavelengths in nm, of any shape.

    Raises:
        omma.Error: a peak outside of 300 to 800 nm.
    """
    peak = ReceptorType("", peak_wavelength_nm=float(peak_wavelength_nm)).peak_wavelength_nm
    if peak == 0:
        raise Error("peak_wavelength_nm: expected 300 to 800 nm, found 0")
    nm = array_of(wavelength_nm, "wavelength_nm")
    bands = _core.pigment_bands(peak, np.ascontiguousarray(nm.ravel()))
    return (alpha * bands[0] + beta * bands[1]).reshape(nm.shape)


@checked
def receptor_matrix(
    types: Eye | ReceptorType | Sequence[ReceptorType],
    ultraviolet: ArrayLike | None = None,
    *,
    edges_nm: ArrayLike | None = None,
    bands: Bands | None = None,
) -> Floats:
    """What receptors make of linear sRGB: (T, 3), weights of red, green and blue by type; or of
    bands of light: (T, B).

    A weight is the share of a receptor's sensitivity, over 300 to 700 nm, that lies under the
    spectrum of that primary (docs/receptors.md; the three add up to a flat white from 400 to 700
    nm), or within that band. So a row's sum is the receptor's share of the light that we can see:
    of a honeybee's green receptor 0.79, of its blue one 0.60, and 0.004 of its ultraviolet one,
    where RGB says nothing.

    Args:
        types: receptor types, or an eye, for those it has.
        ultraviolet: what there is from 300 to 400 nm: "dark", nothing, as None; "as_blue", as much
            as blue; or (3,), a mix of the channels: (0, 0, 0.1) says a tenth of blue. For each type
            the same.
        edges_nm: (B + 1,), ascending, nm, of the bands of a world (`band_from_rgb`); the light in a
            band counts as the same at all its wavelengths. Not together with ``ultraviolet``.
        bands: those of a world with light, instead of edges. Of bands that are no intervals, each
            sensitivity is that sum of their weights which comes nearest (least squares).

    Example:
        >>> eye = omma.species.honeybee_worker().eye
        >>> [one.name for one in eye.receptor_types]
        ['ultraviolet', 'blue', 'green']
        >>> omma.receptors.receptor_matrix(eye).shape  # types and red, green, blue
        (3, 3)

    Raises:
        omma.Error: no sensitivity, weights of another shape, negative or not finite, or edges that
            do not ascend.
    """
    if isinstance(types, Eye):
        types = types.receptor_types
    elif isinstance(types, ReceptorType):
        types = [types]
    if edges_nm is not None or bands is not None:
        given = "edges_nm" if bands is None else "bands"
        if ultraviolet is not None:
            raise Error(f"ultraviolet: is for RGB; not together with {given}")
        if bands is not None and edges_nm is not None:
            raise Error("edges_nm: not together with bands, which say where they are")
        if edges_nm is not None:
            bands = Bands.from_edges(edges_nm)
        assert bands is not None
        chosen = bands
        shares = of_each_sensitivity(
            types, lambda one: _band_weights(one, chosen) / sensitivity_integral_nm(one)
        )
        return np.array(shares, np.float64).reshape(len(shares), len(bands))
    mix = ultraviolet_mix("dark" if ultraviolet is None else ultraviolet)
    rows = [_core.receptor_weights(one, mix.tolist()) for one in types]
    return np.array(rows, np.float64).reshape(len(rows), 3)


def ultraviolet_mix(ultraviolet: ArrayLike) -> Floats:
    """(3,), red, green and blue of which light below 400 nm is made: of a word or of numbers.

    Raises:
        omma.Error: another word or shape, negative or not finite.
    """
    if isinstance(ultraviolet, str):
        if ultraviolet not in _MIXES:
            raise Error(
                f'ultraviolet: expected "dark", "as_blue" or weights of red, green, blue, found '
                f"{ultraviolet!r:.40}"
            )
        return np.array(_MIXES[ultraviolet])
    mix = array_of(ultraviolet, "ultraviolet")
    if mix.shape != (3,) or not np.all(np.isfinite(mix)) or np.any(mix < 0):
        raise Error(
            f"ultraviolet: expected weights of red, green, blue, at least 0, found {mix.tolist()}"
        )
    return mix


def of_each_sensitivity(
    types: Sequence[ReceptorType], function: Callable[[ReceptorType], Any]
) -> list[Any]:
    """The function of each type, asked once for those that differ in where they look alone, of
    which a fly has hundreds."""
    known: dict[Any, Any] = {}
    found = []
    for one in types:
        key = (
            one.peak_wavelength_nm,
            one.absorption_per_m * one.length_m,
            tuple(one.wavelength_nm),
            tuple(one.sensitivity),
        )
        if key not in known:
            known[key] = function(one)
        found.append(known[key])
    return found


def sensitivity_integral_nm(receptor: ReceptorType) -> float:
    """∫ S dλ from 300 to 700 nm of a relative spectral sensitivity, nm.

    Raises:
        omma.Error: there is no sensitivity there.
    """
    low, high = _RECEPTOR_RANGE_NM
    of_type = functools.partial(spectral_sensitivity, receptor)
    whole = float(band_means(np.array([low, high]), of_type)[0] * (high - low))
    if not whole > 0:
        raise Error(
            f"receptor type {receptor.name!r}: expected a sensitivity between {low:g} and "
            f"{high:g} nm, found none"
        )
    return whole


def _band_weights(receptor: ReceptorType, bands: Bands) -> Floats:
    """What each band adds to ∫ S L dλ, for light of 1 per nm in it: (B,), nm."""
    of_type = functools.partial(spectral_sensitivity, receptor)
    if bands.edges_nm is not None:
        return band_means(bands.edges_nm, of_type) * bands.widths_nm
    # S as a sum of the bands' weights per nm: by the normal equations of least squares.
    products = (bands.weight / bands.steps_nm) @ bands.weight.T
    found = np.linalg.lstsq(products, bands.weight @ of_type(bands.wavelength_nm), rcond=None)[0]
    return np.asarray(found)


@checked
def optical_sensitivity(
    facet_diameter_m: ArrayLike,
    acceptance_angle_rad: ArrayLike,
    length_m: ArrayLike,
    absorption_per_m: ArrayLike,
    *,
    monochromatic: bool = False,
) -> Any:
    """Optical sensitivity S to an extended scene, m² sr; arrays broadcast. 1 µm² sr is 1e-12 m² sr.

    S = (π/4)² D² Δρ² F (Land 1981, in Handbook of sensory physiology VII/6B), with the share of
    white light that the rhabdom absorbs F = kl/(2.3 + kl) (Warrant and Nilsson, Vision Res 38:195,
    1998), or of light at the pigment's peak 1 - exp(-kl). With k = 0.0067 per µm this gives what is
    published for honeybees (J Exp Biol 212:2448, table 1).

    This is the number that is published, with Land's solid angle (π/4) Δρ². What an ommatidium of
    Gaussian acceptance receives is 1.44 times as much: `solid_angle_sr`, by which `photon_catch`
    goes. The caller is warned of numbers that are no animal's, mostly in another unit.
    """
    diameter, angle, length, absorption = arrays_of(
        facet_diameter_m=facet_diameter_m,
        acceptance_angle_rad=acceptance_angle_rad,
        length_m=length_m,
        absorption_per_m=absorption_per_m,
    )
    for what, values, name in (
        ("diameter", diameter, "facet_diameter_m"),
        ("acceptance angle", angle, "acceptance_angle_rad"),
        ("rhabdom length", length, "length_m"),
        ("absorption", absorption, "absorption_per_m"),
    ):
        known = values[values > 0]  # 0 where it is not known
        for value in {float(known.min()), float(known.max())} if known.size else ():
            warn_of_slip(what, value, name)
    area, solid_angle = np.pi / 4 * diameter**2, np.pi / 4 * angle**2
    return area * solid_angle * _absorbed(absorption * length, monochromatic)


def _absorbed(depth: Floats, monochromatic: bool) -> Floats:
    return np.asarray(-np.expm1(-depth) if monochromatic else depth / (2.3 + depth))


@checked
def receptor_optical_sensitivity(
    eye: Eye, *, monochromatic: bool = False, field: Field = "land"
) -> Floats:
    """`optical_sensitivity` of each receptor of an eye: (R,), m² sr.

    D is the facet's diameter, or of superposition eyes the aperture's, through whose facets light
    comes to one rhabdom (Land 1981). NaN where it or the receptor's absorption or length is not
    known.

    Args:
        monochromatic: of light at the pigment's peak, instead of white.
        field: "land", (π/4) Δρ², as published; "acceptance", ∫ S dω of its own acceptance, times
            its `Acceptance.coupling_efficiency`.

    Raises:
        omma.Error: what `receptor_solid_angle_sr` raises.
    """
    types, of = eye.receptor_types, eye.receptor_type
    gathers = np.where(eye.aperture_diameter_m > 0, eye.aperture_diameter_m, eye.facet_diameter_m)
    diameter = gathers[ommatidium_of_receptor(eye)].astype(np.float64)
    length = np.array([t.length_m for t in types])[of]
    absorption = np.array([t.absorption_per_m for t in types])[of]
    area = np.pi / 4 * diameter**2
    solid_angle = receptor_solid_angle_sr(eye, field=field)
    if field == "acceptance":
        solid_angle = solid_angle * receptor_coupling_efficiency(eye)
    found = area * solid_angle * _absorbed(absorption * length, monochromatic)
    return np.where((diameter > 0) & (length > 0) & (absorption > 0), found, np.nan)


@checked
def ommatidium_of_receptor(eye: Eye) -> NDArray[np.int64]:
    """Which ommatidium a receptor belongs to: (R,)."""
    return np.repeat(np.arange(len(eye)), np.diff(eye.first_receptor))


@checked
def microvillus_direction(eye: Eye) -> Floats:
    """Where each receptor's microvilli point: (R, 3), directions in the head frame, across the
    direction it looks in. Their sign means nothing: microvilli have an axis, not a sense.

    Raises:
        omma.Error: the eye has no receptors.
    """
    views, view = _core.receptor_views(eye)
    angles = np.array([t.microvillus_angle_rad for t in eye.receptor_types])[eye.receptor_type]
    up, right = views.up[view].astype(np.float64), views.right[view].astype(np.float64)
    return np.asarray(np.cos(angles)[:, None] * up + np.sin(angles)[:, None] * right)


@checked
def receptor_axis(eye: Eye) -> NDArray[np.float32]:
    """Where each receptor looks: (R, 3), directions in the head frame.

    Raises:
        omma.Error: the eye has no receptors.
    """
    views, view = _core.receptor_views(eye)
    return np.asarray(views.axis[view])
