"""Closed loops: an eye, a way to move and a reward as a Gymnasium environment, or as many of them
whose frames are rendered in one call.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
