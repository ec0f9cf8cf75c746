"""Whole jobs, from files to files. `omma.render_file` is what the command `omma render` does."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
