from .detectors import DetectorArray, DetectorState, detector_array
from .gratings import best_frequency_hz, grating_response
from .looming import ARMS, LoomingCells, expansion, looming_cells
from .pairs import neighbour_pairs

__all__ = [
    "ARMS",
    "DetectorArray",
    "DetectorState",
    "LoomingCells",
    "best_frequency_hz",
    "detector_array",
    "expansion",
    "grating_response",
    "looming_cells",
    "neighbour_pairs",
]
