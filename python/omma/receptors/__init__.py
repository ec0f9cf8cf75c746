"""Receptors: their sensitivities to wavelengths, the light that they catch, their microvilli, and
which ommatidium has which.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
