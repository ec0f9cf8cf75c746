from .filters import FrameFilter, filter_frames
from .impulse_response import ImpulseResponse

__all__ = [
    "FrameFilter",
    "ImpulseResponse",
    "filter_frames",
]
