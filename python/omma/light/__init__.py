"""Light: bands of wavelengths, spectra, skies and what else a world is lit by in absolute units,
and what red, green and blue stand for.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
