"""Eyes of animals, from published numbers: what is measured, interpolated and assumed is said.

Each function gives a `Species`: the whole head (both eyes), its facts and their sources. The
numbers are in one table, `facts()`; docs/species.md says how to read it. Only assumed shapes, such
as outlines of fields of view and where blends begin and end, stand in the code. The eyes are stored
with the package; `build` grows one anew.

    bee = omma.species.honeybee_worker()
    renderer = omma.Renderer(scene, bee.eye)
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
