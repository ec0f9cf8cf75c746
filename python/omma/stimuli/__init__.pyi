from .bars import Bar, edge
from .discs import LoomingDisc, Target
from .dots import RandomDots, Starfield
from .gratings import DrumGrating, PlaneGrating, SphereGrating, optomotor_drum
from .leds import LedArena
from .panoramas import NoisePanorama

__all__ = [
    "Bar",
    "DrumGrating",
    "LedArena",
    "LoomingDisc",
    "NoisePanorama",
    "PlaneGrating",
    "RandomDots",
    "SphereGrating",
    "Starfield",
    "Target",
    "edge",
    "optomotor_drum",
]
