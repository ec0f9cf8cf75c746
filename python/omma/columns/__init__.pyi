from .cartridges import cartridge_wiring
from .coordinates import hex_from_pq, hexals, pq_from_hex, pq_from_uv, uv_from_pq
from .eyes import column_pairs, columns_of_eye, eye_of_columns
from .fly import fly_columns, load_column_types, load_eye_map
from .hexal_arrays import flyvis_movie, hexal_columns, to_hexals
from .lattice import Columns
from .maps import load_columns
from .names import find_columns, flywire_names, malecns_names
from .photoreceptors import ColumnRenderer, PhotoreceptorTable, photoreceptor_table
from .resampling import resample, resampling_matrix, seen_by

__all__ = [
    "ColumnRenderer",
    "Columns",
    "PhotoreceptorTable",
    "cartridge_wiring",
    "column_pairs",
    "columns_of_eye",
    "eye_of_columns",
    "find_columns",
    "fly_columns",
    "flywire_names",
    "flyvis_movie",
    "hex_from_pq",
    "hexal_columns",
    "hexals",
    "load_column_types",
    "load_columns",
    "load_eye_map",
    "malecns_names",
    "photoreceptor_table",
    "pq_from_hex",
    "pq_from_uv",
    "resample",
    "resampling_matrix",
    "seen_by",
    "to_hexals",
    "uv_from_pq",
]
