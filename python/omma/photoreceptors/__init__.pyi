from .filters import FrameFilter, filter_frames
from .impulse_response import ImpulseResponse
from .noise import intrinsic_noise, photon_noise

__all__ = [
    "FrameFilter",
    "ImpulseResponse",
    "filter_frames",
    "intrinsic_noise",
    "photon_noise",
]
