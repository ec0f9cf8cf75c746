"""Light in bands of wavelengths: what red, green and blue stand for, and what they are in bands;
spectra."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
