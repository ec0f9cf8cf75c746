"""MuJoCo models as worlds: what an eye sees in a physics simulation, and a retina for FlyGym.

A world made of a model has the model's own frame: MuJoCo's +Z is up in it, and nothing is turned.
Lengths are the model's. Needs `mujoco` (``pip install 'omma[mujoco]'``).

Files: `shapes`, `materials` and `cube_maps` lay textures as MuJoCo does, `lamps`, `skins`; `moving`
keeps a world; `retina` answers FlyGym's call, `pictures` that of its pictures.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
