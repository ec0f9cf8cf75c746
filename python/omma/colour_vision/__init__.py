"""Colours as animals tell them apart: from the photons that receptors catch to distances between
colours, colour spaces, and what an ideal observer detects from how far away.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
