"""Photons and watts: what spectral radiance in one unit is in the other, exactly."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import arrays_of, checked, one_of

# "photons": photons m^-2 s^-1 sr^-1 nm^-1; "watts": W m^-2 sr^-1 nm^-1.
Unit = Literal["photons", "watts"]

# Exact in the SI of 2019: Planck's constant (J s) and the speed of light (m/s).
PLANCK_J_S = 6.62607015e-34
LIGHT_M_PER_S = 299792458.0

# Photons per joule, of light of 1 nm; in proportion to the wavelength.
PHOTONS_PER_JOULE_NM = 1e-9 / (PLANCK_J_S * LIGHT_M_PER_S)


@checked
def photons_from_watts(watts: ArrayLike, wavelength_nm: ArrayLike) -> Any:
    """Photons per second in watts of light, per whatever else: watts · λ / (h c), about
    5.0341e15 · λ[nm] a watt. Arrays broadcast.

    Example:
        >>> f"{omma.light.photons_from_watts(1.0, 500):.6g}"
        '2.51706e+18'

    Raises:
        omma.Error: wavelengths that are not above 0, or shapes that do not go together.
    """
    watts, nm = arrays_of(watts=watts, wavelength_nm=_wavelengths(wavelength_nm))
    return watts * nm * PHOTONS_PER_JOULE_NM


@checked
def watts_from_photons(photons: ArrayLike, wavelength_nm: ArrayLike) -> Any:
    """Watts in photons per second, per whatever else: photons · h c / λ. Arrays broadcast.

    Raises:
        omma.Error: wavelengths that are not above 0, or shapes that do not go together.
    """
    photons, nm = arrays_of(photons=photons, wavelength_nm=_wavelengths(wavelength_nm))
    return photons / (nm * PHOTONS_PER_JOULE_NM)


def check_unit(unit: str) -> str:
    """The unit where it is one; omma.Error names the two there are."""
    return one_of(unit, ("photons", "watts"), "unit")


def _wavelengths(wavelength_nm: ArrayLike) -> NDArray[np.float64]:
    (nm,) = arrays_of(wavelength_nm=wavelength_nm)
    if not np.all(nm > 0):
        raise Error("wavelength_nm: expected wavelengths above 0")
    return nm
