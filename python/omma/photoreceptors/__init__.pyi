from .adaptation import logarithmic, naka_rushton
from .events import EVENT, EventSensor, EventState, event_counts
from .filters import FrameFilter, filter_frames, frame_integration_time_s
from .gain_control import VanHaterenSnippe, van_hateren_snippe
from .impulse_response import ImpulseResponse
from .microsaccades import displace_axes, microsaccades_rad
from .monopolar import large_monopolar
from .noise import intrinsic_noise, photon_noise
from .published import published_response

__all__ = [
    "EVENT",
    "EventSensor",
    "EventState",
    "FrameFilter",
    "ImpulseResponse",
    "VanHaterenSnippe",
    "displace_axes",
    "event_counts",
    "filter_frames",
    "frame_integration_time_s",
    "intrinsic_noise",
    "large_monopolar",
    "logarithmic",
    "microsaccades_rad",
    "naka_rushton",
    "photon_noise",
    "published_response",
    "van_hateren_snippe",
]
