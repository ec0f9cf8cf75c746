"""Responses as tidy tables, `.parquet`: a row for each pose and ommatidium, or receptor.

What a column cannot say (poses, attributes) is in the schema's metadata, as JSON under "omma".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from omma._core import Error
from omma.base.files import WholeFiles, named_in_errors
from omma.rendering.label_texts import labels_text
from omma.rendering.labelled_files import load_package
from omma.rendering.labels import Labels
from omma.rendering.response_files import CAMERA_COLUMNS, Piece

METADATA = b"omma"

# Rows that are in memory as a table at once, and that a reader takes at once.
_GROUP_ROWS = 1 << 18
# Their positions are in the schema, which readers have in memory as a whole, and at most 100 MB of.
_MOST_POSES = 200_000


class ParquetWriter:
    """Columns: pose; ommatidium, or receptor and its ommatidium; eye, azimuth, elevation and what
    else is known of each; then the responses, their errors (NAME_error), rays, and how near cameras
    of the capture were."""

    def __init__(self, files: WholeFiles, name: str, labels: Labels) -> None:
        self._arrow = load_package("pyarrow", name)
        parquet = load_package("pyarrow.parquet", name)
        dimensions = labels.variables["response"][0]
        poses, self._rows = labels.shape("response")[:2]
        if poses > _MOST_POSES:
            raise Error(
                f"{name}: expected at most {_MOST_POSES:,} poses for .parquet, found {poses:,}; "
                ".zarr and .nc take any number"
            )
        self._sites = {
            coordinate: values
            for coordinate, (along, values, _) in labels.coordinates.items()
            if along == (dimensions[1],)
        }
        self._columns = columns_of(labels)
        arrow = self._arrow
        kinds = {"pose": arrow.int32()} | {
            site: arrow.string()
            if values.dtype.kind == "U"
            else arrow.from_numpy_dtype(values.dtype)
            for site, values in self._sites.items()
        }
        for variable, columns in self._columns.items():
            kind = arrow.from_numpy_dtype(np.dtype(labels.variables[variable][1]))
            kinds |= dict.fromkeys(columns, kind)
        metadata = {METADATA: labels_text(labels, {}).encode()}
        self._schema = arrow.schema(list(kinds.items()), metadata=metadata)
        self._name = name
        self._writer = parquet.ParquetWriter(files.path_of(name), self._schema)
        files.at_end(self._close)

    def write(self, piece: Piece) -> None:
        count = max(1, _GROUP_ROWS // max(1, self._rows))
        values = piece.variables
        for begin in range(0, len(piece.responses), count):
            rows = {name: array[begin : begin + count] for name, array in values.items()}
            self._write(rows, piece.first + begin)

    def _write(self, values: dict[str, np.ndarray[Any, Any]], first: int) -> None:
        poses = len(values["response"])
        columns: dict[str, Any] = {
            "pose": np.repeat(np.arange(first, first + poses, dtype=np.int32), self._rows)
        }
        columns |= {site: np.tile(array, poses) for site, array in self._sites.items()}
        for variable, names in self._columns.items():
            # What a pose has one of stands in each of its rows.
            of_poses = values[variable].reshape(poses, -1, len(names))
            each = np.broadcast_to(of_poses, (poses, self._rows, len(names)))
            table = each.reshape(poses * self._rows, len(names))
            columns |= {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)}
        with named_in_errors(self._name):
            self._writer.write_table(self._arrow.table(columns, schema=self._schema))

    def _close(self) -> None:
        with named_in_errors(self._name):
            self._writer.close()


def columns_of(labels: Labels) -> dict[str, list[str]]:
    """Names of the columns that each variable has."""
    bands = labels.coordinates["band"][1].tolist() if "band" in labels.coordinates else ["response"]
    columns = {"response": bands}
    if "standard_error" in labels.variables:
        columns["standard_error"] = [f"{band}_error" for band in bands]
    for variable in ("rays", *CAMERA_COLUMNS):
        if variable in labels.variables:
            columns[variable] = [variable]
    return columns
