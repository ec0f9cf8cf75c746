from .coordinates import hex_from_pq, hexals, pq_from_hex, pq_from_uv, uv_from_pq
from .eyes import column_pairs, columns_of_eye, eye_of_columns
from .hexal_arrays import hexal_columns, to_hexals
from .lattice import Columns
from .maps import load_columns
from .resampling import resample, resampling_matrix, seen_by

__all__ = [
    "Columns",
    "column_pairs",
    "columns_of_eye",
    "eye_of_columns",
    "hex_from_pq",
    "hexal_columns",
    "hexals",
    "load_columns",
    "pq_from_hex",
    "pq_from_uv",
    "resample",
    "resampling_matrix",
    "seen_by",
    "to_hexals",
    "uv_from_pq",
]
