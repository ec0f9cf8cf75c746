"""Data sets as jobs: millions of views of scenes, in one Zarr store that training code reads.

A job is a TOML file; `run` makes its views and goes on where it was cut off; `Views` reads them
(docs/datasets.md).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
