from .bands import band_from_rgb, primary_spectra
from .spectrum import Spectrum

__all__ = [
    "Spectrum",
    "band_from_rgb",
    "primary_spectra",
]
