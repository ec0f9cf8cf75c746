"""Scenes and worlds: what there is to see, its cameras, and things in it that move.
`load_scene` reads a scene and `save_scene` writes one; `omma.Scene` makes one of `Mesh`, `Material`
and the other parts, `box`, `sphere`, `cylinder`, `plane`, `disc`, `drum` and `corridor` of sizes;
`merge_scenes` puts several into one. `omma.World` makes a scene ready to be seen;
`devices` says what there is to see it with.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
