"""Closed loops: an eye, a way to move and a reward as a Gymnasium environment, or as many of them
whose frames are rendered in one call.

`loop` is what a loop is, `episodes` are its runs, one after another or all in arrays (`states`);
they know nothing of Gymnasium. `environments` has the two classes, imported only where Gymnasium is
installed.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
