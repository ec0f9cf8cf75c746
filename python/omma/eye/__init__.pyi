from .acceptance_files import load_acceptance
from .angles import acute_angle, angle_table, load_angle_table, outline, window
from .change import (
    ConvertedEye,
    convert_eye,
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
from .hexagonal import DIRECTIONS, NO_COORDINATE, HexagonalCoordinates, hexagonal_coordinates
from .lattice import (
    Lattice,
    LatticeCheck,
    azimuth_elevation_deg_of,
    check_lattice,
    direction,
    lay_directions,
)
from .measures import EyeMeasures, measure_eye
from .on_surface import eye_on_surface, lay_on_surface, skew_rad, squeeze_for_skew, squeezed
from .properties import PROPERTIES
from .report import eye_summary, eye_table, save_eye_table
from .scan_import import ImportedEye, LensConeEye, import_lens_cone, import_oda
from .superposition import (
    Wiring,
    fly_receptors,
    neural_superposition_wiring,
    pool,
    superposition_facets,
)
from .surfaces import ellipsoid, load_surface, mesh_surface, sphere

__all__ = [
    "AcuteZone",
    "ConvertedEye",
    "DIRECTIONS",
    "EyeMeasures",
    "HexagonalCoordinates",
    "ImportedEye",
    "Lattice",
    "LatticeCheck",
    "LensConeEye",
    "NO_COORDINATE",
    "PROPERTIES",
    "Wiring",
    "acceptance_from_facets",
    "acute_angle",
    "acute_zones",
    "angle_table",
    "azimuth_elevation_deg_of",
    "check_lattice",
    "convert_eye",
    "direction",
    "ellipsoid",
    "eye_file_heads",
    "eye_file_losses",
    "eye_on_surface",
    "eye_summary",
    "eye_table",
    "facet_diameters_m",
    "fly_receptors",
    "generate_eye",
    "hexagonal_coordinates",
    "import_lens_cone",
    "import_oda",
    "join_eyes",
    "lay_directions",
    "lay_on_surface",
    "load_acceptance",
    "load_angle_table",
    "load_surface",
    "measure_eye",
    "merge_eyes",
    "mesh_surface",
    "mirror_eye",
    "neural_superposition_wiring",
    "outline",
    "pair_of_eyes",
    "place_on_head",
    "pool",
    "rescale_eye",
    "save_eye_table",
    "set_acceptance",
    "set_facets",
    "skew_rad",
    "sphere",
    "split_eye",
    "squeeze_for_skew",
    "squeezed",
    "superposition_facets",
    "window",
]
