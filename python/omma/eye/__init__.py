"""Eyes: made from densities, surfaces and scans, changed, measured, read and written. Lenses and
rhabdoms are `omma.Acceptance`; animals are in `omma.species`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
