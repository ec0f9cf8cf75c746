"""Moving stimuli of experiments on vision: each a world with parameters and time, and what an
ommatidium must answer to it, from a closed form or a quadrature.

`stimulus` is what all share, `turning` and `discs_seen` what some do, `shown` says whether a world
shows one, `leds_told` what an arena of LEDs makes of one, `checks` are those of their parameters,
`gaussian` the quadratures; the other files hold a family each. A new stimulus is a frozen dataclass
with `_scene`, `_transforms` and `_radiance`, which calls `check_fields`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
