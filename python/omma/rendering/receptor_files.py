"""Responses of receptors into files: ``omma render --receptors``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import WholeFiles
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_axis
from omma.rendering.response_files import NpyWriter, Writer


class ReceptorCsvWriter:
    """A line for each pose and receptor: pose, ommatidium, eye_id, receptor (the name of its type),
    azimuth_deg, elevation_deg (of where it looks), response, and where asked for response_error."""

    def __init__(self, files: WholeFiles, name: str, eye: Eye, with_errors: bool) -> None:
        self._file = files.open(name)
        header = "pose,ommatidium,eye_id,receptor,azimuth_deg,elevation_deg,response"
        header += ",response_error" if with_errors else ""
        self._file.write_header(f"{header}\n".encode())
        names = [quoted(kind.name) for kind in eye.receptor_types]
        azimuth, elevation = azimuth_elevation_deg_of(receptor_axis(eye))
        self._places = [
            f"{i},{eye.eye_id[i]},{names[t]},{a:.6g},{e:.6g}"
            for i, t, a, e in zip(
                ommatidium_of_receptor(eye), eye.receptor_type, azimuth, elevation, strict=True
            )
        ]

    def write(
        self, responses: NDArray[np.float32], errors: NDArray[np.float32] | None, first: int
    ) -> None:
        columns = [responses] if errors is None else [responses, errors]
        form = ",".join(["%.9g"] * len(columns))
        for number, pose in enumerate(np.stack(columns, axis=-1), start=first):
            lines = [
                f"{number},{place},{form % tuple(values)}\n"
                for place, values in zip(self._places, pose.tolist(), strict=True)
            ]
            self._file.write("".join(lines).encode())


def quoted(text: str) -> str:
    """A text as a field of a CSV file (RFC 4180)."""
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\r\n') else text


def receptor_writers(
    files: WholeFiles, names: Sequence[str], eye: Eye, poses: int, standard_error: bool
) -> tuple[list[Writer], list[str]]:
    """Writers of the files named, and the names of all files written."""
    if len(eye.receptor_type) == 0:
        raise Error(
            f"{eye.path or 'eye'}: expected receptors, found none (.csv eyes can have them, "
            "omma.receptors.assign_receptors makes them)"
        )
    shape = (poses, len(eye.receptor_type))
    writers: list[Writer] = []
    written: list[str] = []
    for name in names:
        suffix = Path(name).suffix.lower()
        if suffix == ".csv":
            writers.append(ReceptorCsvWriter(files, name, eye, standard_error))
        elif suffix == ".npy":
            writers.append(NpyWriter(files, name, shape))
        else:
            raise Error(f"{name}: expected .npy or .csv for responses of receptors")
        written.append(name)
        if suffix == ".npy" and standard_error:
            beside = str(Path(name).with_suffix(".error.npy"))
            writers.append(NpyWriter(files, beside, shape, of_errors=True))
            written.append(beside)
    return writers, written
