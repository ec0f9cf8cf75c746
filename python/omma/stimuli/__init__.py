"""Moving stimuli of experiments on vision: each a world with parameters and time, and what an
ommatidium must answer to it, from a closed form or a quadrature.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
