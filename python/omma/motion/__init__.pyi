from .detectors import DetectorArray, DetectorState, detector_array
from .gratings import best_frequency_hz, grating_response
from .pairs import neighbour_pairs

__all__ = [
    "DetectorArray",
    "DetectorState",
    "best_frequency_hz",
    "detector_array",
    "grating_response",
    "neighbour_pairs",
]
