"""Motion from responses: Hassenstein-Reichardt detectors between ommatidia, what they answer to
gratings, and what looms; and motion of heads that walk on the ground.

`looming` has the cells that pool detectors. All of that reads the eye's lattice, nothing of the
renderer. `walking` places bodies on the ground, by rays (`ground_rays`) under their legs
(`footing`), along `tracks`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
