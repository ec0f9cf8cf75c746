"""Light by a measured irradiance: a sky that is the same everywhere."""

from __future__ import annotations

from typing import Literal

import numpy as np

from omma._core import Spectrum
from omma.base.arguments import checked, one_of
from omma.base.slips import warn_of_slip
from omma.light.bands import Bands
from omma.light.lights import Light, makes_light
from omma.light.skies import uniform_sky
from omma.light.units import Unit, check_unit, photons_from_watts, watts_from_photons

IrradianceUnit = Literal["watts", "microwatts_per_cm2", "photons", "micromoles"]

# Exact in the SI of 2019.
_AVOGADRO = 6.02214076e23
# To W or photons/s, m^-2 nm^-1.
_UNITS: dict[str, tuple[Unit, float]] = {
    "watts": ("watts", 1.0),
    "microwatts_per_cm2": ("watts", 1e-2),
    "photons": ("photons", 1.0),
    "micromoles": ("photons", 1e-6 * _AVOGADRO),
}


@makes_light
@checked
def measured_sky(
    irradiance: Spectrum,
    irradiance_unit: IrradianceUnit,
    *,
    bands: Bands | None = None,
    unit: Unit = "photons",
) -> Light:
    """A sky of the same radiance everywhere above the horizon, L = E/π, so that level ground gets
    the spectral irradiance E that was measured there. Unpolarised; below the horizon it is dark.

    What a cosine-corrected spectrometer measures says how much light there is, not from where: of
    shade, of an overcast sky and of matt samples seen from above it is the light; the sun's
    direction and its shadows are not in it.

    Args:
        irradiance: of level ground, as `load_spectra` reads it with unit="as_is".
        irradiance_unit: what its numbers are, all per nm: "watts" W m⁻², "microwatts_per_cm2"
            µW cm⁻², as Ocean Optics writes, "photons" m⁻² s⁻¹, "micromoles" µmol photons m⁻² s⁻¹.
        bands: by default 16 of 25 nm from 300 to 700 nm.
        unit: of the light, "photons" or "watts"; converted at the spectrum's wavelengths.

    Example:
        >>> white = omma.light.Spectrum([300, 700], [3.0, 3.0])
        >>> sky, discs = omma.light.measured_sky(white, "photons").irradiance()
        >>> float(sky[0]).__round__(4)
        3.0

    Raises:
        omma.Error: another unit, or a spectrum that does not reach over all bands.

    Warns:
        UserWarning: more than 5 W m⁻² nm⁻¹, twice what the sun has outside of the air.
    """
    given, factor = _UNITS[one_of(irradiance_unit, _UNITS, "irradiance_unit")]
    check_unit(unit)
    nm, values = irradiance.wavelength_nm, factor * irradiance.value
    watts = values if given == "watts" else watts_from_photons(values, nm)
    warn_of_slip("irradiance", watts, f"irradiance, in {irradiance_unit}")
    if given != unit:
        convert = photons_from_watts if unit == "photons" else watts_from_photons
        values = convert(values, nm)
    bands = bands or Bands.equal()
    return uniform_sky(bands.mean(values / np.pi, nm), below=0.0, bands=bands, unit=unit)
