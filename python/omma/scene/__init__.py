"""Scenes and worlds: what there is to see, its cameras, and things in it that move.
`omma.load_scene` reads a scene, `omma.World` makes it ready to be seen.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
