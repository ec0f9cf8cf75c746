from . import angles, hexagonal, lattice, scans, skew, superposition, surfaces
from .acceptance_files import load_acceptance
from .angles import acute_angle, window
from .change import (
    join_eyes,
    merge_eyes,
    mirror_eye,
    pair_of_eyes,
    place_on_head,
    rescale_eye,
    set_acceptance,
    split_eye,
)
from .design import AcuteZone, acute_zones, generate_eye
from .facets import acceptance_from_facets, facet_diameters_m, set_facets
from .files import eye_file_heads, eye_file_losses
from .hexagonal import hexagonal_coordinates
from .lattice import azimuth_elevation_deg_of, direction, lay_directions
from .measures import EyeMeasures, measure_eye
from .old_files import ConvertedEye, convert_eye
from .on_surface import eye_on_surface, lay_on_surface
from .properties import PROPERTIES
from .report import eye_summary, eye_table, save_eye_table

__all__ = [
    "PROPERTIES",
    "AcuteZone",
    "ConvertedEye",
    "EyeMeasures",
    "acceptance_from_facets",
    "acute_angle",
    "acute_zones",
    "angles",
    "azimuth_elevation_deg_of",
    "convert_eye",
    "direction",
    "eye_file_heads",
    "eye_file_losses",
    "eye_on_surface",
    "eye_summary",
    "eye_table",
    "facet_diameters_m",
    "generate_eye",
    "hexagonal",
    "hexagonal_coordinates",
    "join_eyes",
    "lattice",
    "lay_directions",
    "lay_on_surface",
    "load_acceptance",
    "measure_eye",
    "merge_eyes",
    "mirror_eye",
    "pair_of_eyes",
    "place_on_head",
    "rescale_eye",
    "save_eye_table",
    "scans",
    "set_acceptance",
    "set_facets",
    "skew",
    "split_eye",
    "superposition",
    "surfaces",
    "window",
]
