"""Photoreceptors in time: impulse responses, filters over frames, noise, adaptation, the large
monopolar cells behind them, ON and OFF events, rhabdomeres that move. Nothing of it is on unless it
is called.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
