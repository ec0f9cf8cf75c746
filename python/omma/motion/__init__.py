"""Motion from responses: Hassenstein-Reichardt detectors between ommatidia, what they answer to
gratings, and what looms.

`looming` has the cells that pool detectors. All of it reads the eye's lattice, nothing of the
renderer.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
