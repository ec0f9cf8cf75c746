"""Medulla columns: hexagonal coordinates as connectomes name them, published maps of where columns
look, responses brought onto them, and the arrays that flyvis-like models take.

Files: `coordinates` has the conventions, `maps` the files, `resampling` the weights, `hexal_arrays`
what models take.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
