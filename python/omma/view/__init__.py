"""A window into the eye: a page in the browser that shows what an animal sees, live; it needs the
extra `omma[view]`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
