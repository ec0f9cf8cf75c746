from .bands import band_from_rgb, primary_spectra

__all__ = [
    "band_from_rgb",
    "primary_spectra",
]
