"""Responses of receptors into files: ``omma render --receptors``."""

from __future__ import annotations

import numpy as np

from omma._core import Eye
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import WholeFiles
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_axis
from omma.rendering.response_files import CsvColumns, Piece


class ReceptorCsvWriter:
    """A line for each pose and receptor: pose, ommatidium, eye_id, receptor (the name of its type),
    azimuth_deg, elevation_deg (of where it looks), then time and unit as in responses of
    ommatidia, response, and where asked for response_error."""

    def __init__(self, files: WholeFiles, name: str, eye: Eye, columns: CsvColumns) -> None:
        self._file = files.open(name)
        self._columns = columns
        self._file.write_header(columns.header("receptor,azimuth_deg,elevation_deg"))
        names = [quoted(kind.name) for kind in eye.receptor_types]
        azimuth, elevation = azimuth_elevation_deg_of(receptor_axis(eye))
        self._sites = [
            f"{i},{eye.eye_id[i]},{names[t]},{a:.6g},{e:.6g}"
            for i, t, a, e in zip(
                ommatidium_of_receptor(eye), eye.receptor_type, azimuth, elevation, strict=True
            )
        ]

    def write(self, piece: Piece) -> None:
        columns = [piece.responses] if piece.errors is None else [piece.responses, piece.errors]
        for number, pose in enumerate(np.stack(columns, axis=-1), start=piece.first):
            self._file.write(self._columns.lines(number, self._sites, pose))


def quoted(text: str) -> str:
    """A text as a field of a CSV file (RFC 4180)."""
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\r\n') else text
