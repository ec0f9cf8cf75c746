from .detectors import DetectorArray, DetectorState, detector_array
from .gratings import best_frequency_hz, grating_response
from .looming import ARMS, LoomingCells, expansion, looming_cells
from .pairs import neighbour_pairs
from .tracks import Track, load_track
from .walking import GroundAt, ground_at, place_on, walk_on

__all__ = [
    "ARMS",
    "DetectorArray",
    "DetectorState",
    "GroundAt",
    "LoomingCells",
    "Track",
    "best_frequency_hz",
    "detector_array",
    "expansion",
    "grating_response",
    "ground_at",
    "load_track",
    "looming_cells",
    "neighbour_pairs",
    "place_on",
    "walk_on",
]
