"""How many rays a scene needs: variance over positions and turns, aliasing, bounds around
responses, speed.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
