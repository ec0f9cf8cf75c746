"""Responses of receptors into files: ``omma render --receptors``."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.eye_lattice import azimuth_elevation_deg_of
from omma.files import NpyWriter, WholeFiles, Writer
from omma.poses import Matrices
from omma.receptors import ommatidium_of_receptor, receptor_axis
from omma.renderer import Renderer

_CHUNK_BYTES = 64 << 20


class ReceptorCsvWriter:
    """A line for each pose and receptor: pose, ommatidium, eye_id, receptor (the name of its type),
    azimuth_deg, elevation_deg (of where it looks), response, and where asked for response_error."""

    def __init__(self, files: WholeFiles, name: str, eye: Eye, with_errors: bool) -> None:
        self._file = files.open(name)
        header = "pose,ommatidium,eye_id,receptor,azimuth_deg,elevation_deg,response"
        self._file.write((header + (",response_error" if with_errors else "") + "\n").encode())
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
            "omma.assign_receptors makes them)"
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


def render_receptors_into(
    writers: Sequence[Writer],
    renderer: Renderer,
    poses: Matrices,
    ultraviolet: ArrayLike | None,
    standard_error: bool,
    tell: Callable[[str, float | None], object],
) -> float:
    """Render piece by piece into the writers; seconds spent rendering."""
    chunk = max(1, _CHUNK_BYTES // (4 * len(renderer.eye.receptor_type)))
    seconds = 0.0
    for first in range(0, len(poses), chunk):
        piece = poses[first : first + chunk]

        def share(done: float, first: int = first, count: int = len(piece)) -> None:
            tell("Rendering", (first + done * count) / len(poses))

        start = time.perf_counter()
        errors = None
        if standard_error:
            responses, errors = renderer.render_receptors(
                piece,
                ultraviolet=ultraviolet,
                standard_error=True,
                first_pose=first,
                progress=share,
            )
        else:
            responses = renderer.render_receptors(
                piece, ultraviolet=ultraviolet, first_pose=first, progress=share
            )
        seconds += time.perf_counter() - start
        tell("Writing", (first + len(piece)) / len(poses))
        for writer in writers:
            writer.write(responses, errors, first)
    return seconds
