"""How wrong catches are because light is in bands: how many bands, and which, are enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye, ReceptorType
from omma.base.arguments import array_of, checked, whole
from omma.base.arrays import Floats
from omma.base.values import value_class
from omma.light.bands import Bands
from omma.light.lights import Light
from omma.receptors.sensitivity import receptor_matrix

# What stands for the truth: bands of 5 nm, so fine that halving them changes catches by 0.1 %.
_FINE = 80
_LOW_NM, _HIGH_NM = 300.0, 700.0
# Catches below this share of the largest are of no account: what is a receptor blind to.
_LEAST_SHARE = 1e-3


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class BandError:
    """How far catches in bands are from those in bands of 5 nm.

    relative_error: (spectra of light, reflectances, receptor types); NaN where next to nothing is
        caught. Spectra are the sky and then the discs, of each light.
    """

    relative_error: Floats

    @property
    def rms(self) -> float:
        """Root mean square of all."""
        return float(np.sqrt(np.nanmean(self.relative_error**2)))

    @property
    def worst(self) -> float:
        """The largest, without its sign."""
        return float(np.nanmax(np.abs(self.relative_error)))

    def __repr__(self) -> str:
        return f"BandError({100 * self.rms:.2g} % rms, at worst {100 * self.worst:.2g} %)"


@checked
def band_error(
    light: Light | Sequence[Light],
    receptors: Eye | ReceptorType | Sequence[ReceptorType],
    bands: Bands | None = None,
    reflectances: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    reflections: int = 1,
) -> BandError:
    """The error of catches that a choice of bands makes.

    In bands, light that falls on a surface and what the surface gives back are multiplied as means
    over each band, which leaves out how they go together inside of it. Here that is compared with
    bands of 5 nm, for the spectra that a light's sky and discs give to level ground.

    Args:
        light: one or several, such as the suns of a day.
        receptors: types, or an eye, for those it has.
        bands: which; by default 16 of 25 nm from 300 to 700 nm.
        reflectances: wavelengths (N,), nm, and values (K, N), 0 to 1, linear between, from 300 to
            700 nm. None: `natural_reflectances`, five that are made up.
        reflections: how often light is reflected, each time by the same.

    Example:
        >>> bee = omma.species.honeybee_worker().eye
        >>> light = omma.light.uniform_sky()
        >>> omma.receptors.band_error(light, bee, omma.light.Bands.equal(4)).rms > 0.05
        True

    Raises:
        omma.Error: a light that cannot be made in other bands, reflectances out of range or that do
            not reach from 300 to 700 nm.
    """
    bands = bands or Bands.equal()
    count = whole(reflections, "reflections", 0, 100)
    fine = Bands.equal(_FINE, _LOW_NM, _HIGH_NM)
    nm, rows = natural_reflectances() if reflectances is None else _checked(reflectances)
    lights = [light] if isinstance(light, Light) else list(light)
    if not lights:
        raise Error("light: expected at least one, found none")

    def catches(of: Bands) -> Floats:
        spectra = np.concatenate([_spectra(one.in_bands(of)) for one in lights])
        given_back = of.mean(rows.T, nm).T ** count
        matrix = receptor_matrix(receptors, bands=of)
        return np.asarray(np.einsum("lb,kb,tb->lkt", spectra, given_back, matrix))

    truth = catches(fine)
    error = np.full(truth.shape, np.nan)
    seen = truth > _LEAST_SHARE * truth.max(axis=(1, 2), keepdims=True)
    error[seen] = catches(bands)[seen] / truth[seen] - 1
    return BandError(error)


@checked
def natural_reflectances() -> tuple[Floats, Floats]:
    """Five smooth reflectances like those of natural things, made up: wavelengths (N,), nm, and
    values (5, N): a green leaf, soil, a white flower that absorbs ultraviolet, a yellow one that
    reflects it and a blue one.

    Steps of flowers rise from 10 to 90 % within 35 nm, as those of many do.
    """
    nm = np.arange(_LOW_NM, _HIGH_NM + 1.0)

    def step(at: float, width: float = 8.0) -> Floats:
        return np.asarray(1 / (1 + np.exp(-(nm - at) / width)))

    def bump(at: float, width: float) -> Floats:
        return np.asarray(np.exp(-(((nm - at) / width) ** 2)))

    rows = [
        0.04 + 0.10 * bump(552, 38) + 0.35 * step(705),
        0.05 + 0.30 * (nm - _LOW_NM) / (_HIGH_NM - _LOW_NM),
        0.06 + 0.70 * step(400),
        0.04 + 0.30 * bump(350, 30) + 0.60 * step(515),
        0.05 + 0.35 * bump(445, 45) + 0.30 * step(670),
    ]
    return nm, np.array(rows)


def _spectra(light: Light) -> Floats:
    """What the sky and each disc give to level ground: (spectra, B); those that are not dark."""
    sky, _ = light.irradiance()
    discs = [one.irradiance() * max(float(one.direction[1]), 0.0) for one in light.discs]
    found = [one for one in (sky, *discs) if np.any(one > 0)]
    if not found:
        raise Error("light: expected one that is not dark from above")
    return np.array(found)


def _checked(reflectances: tuple[ArrayLike, ArrayLike]) -> tuple[Floats, Floats]:
    try:
        given_nm, given = reflectances
    except (TypeError, ValueError):
        raise Error("reflectances: expected wavelengths and values, two arrays") from None
    nm = array_of(given_nm, "reflectances[0]", (None,))
    rows = array_of(given, "reflectances[1]", (None, len(nm)))
    if not (np.all(rows >= 0) and np.all(rows <= 1)) or len(rows) == 0:
        raise Error("reflectances[1]: expected at least one row of numbers from 0 to 1")
    return nm, rows
