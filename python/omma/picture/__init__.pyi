from .acceptance_plots import plot_acceptance
from .band_colours import bands_to_rgb
from .cameras import camera_eye, display
from .capture_plots import plot_capture_cameras
from .drawing import draw_eye
from .eye_maps import plot_eye_maps
from .fields import field_ids
from .frame import framed
from .id_maps import (
    encode_ids,
    equirectangular,
    equirectangular_ids,
    paint,
    side_by_side,
)
from .poster import plot_poster, plot_species
from .projections import PROJECTIONS, project, projection_ids
from .response_plots import plot_responses
from .sky_plots import plot_sky

__all__ = [
    "PROJECTIONS",
    "bands_to_rgb",
    "camera_eye",
    "display",
    "draw_eye",
    "encode_ids",
    "equirectangular",
    "equirectangular_ids",
    "field_ids",
    "framed",
    "paint",
    "plot_acceptance",
    "plot_capture_cameras",
    "plot_eye_maps",
    "plot_poster",
    "plot_responses",
    "plot_sky",
    "plot_species",
    "project",
    "projection_ids",
    "side_by_side",
]
