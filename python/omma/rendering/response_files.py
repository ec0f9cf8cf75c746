"""Responses into files, `.npy` and `.csv`."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import array_of, checked
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import PathLike, WholeFiles, check_ending

# Of `.csv` files, by the variable that they are.
CAMERA_COLUMNS = {"camera_distance": "camera_distance_m", "camera_angle": "camera_angle_deg"}


@checked
def save_responses(
    path: PathLike, responses: ArrayLike, eye: Eye, errors: ArrayLike | None = None
) -> None:
    """Write responses (P, N, C) or (N, C) to `.npy` or `.csv`, by the name's ending.

    `.npy` is the float32 array (P, N, C). `.csv` has a line for each pose and ommatidium: pose,
    ommatidium, eye_id, azimuth_deg, elevation_deg (of its axis in the head: azimuth 0 ahead, to the
    right positive), r, g, b (band_0, band_1, ... where there are not three), and with ``errors``
    r_error, g_error, b_error.

    Raises:
        omma.Error: another ending, responses of another eye, a file that cannot be written.
    """
    name = os.fsdecode(path)
    array = _responses(responses, eye, "responses")
    error_array = None if errors is None else _responses(errors, eye, "errors")
    if error_array is not None and error_array.shape != array.shape:
        raise Error(f"errors: expected shape {array.shape}, found {error_array.shape}")
    check_ending(name, ".npy", ".csv")
    suffix = Path(name).suffix.lower()
    with WholeFiles() as files:
        if suffix == ".npy" and error_array is None:
            writer: Writer = NpyWriter(files, name, array.shape)
        elif suffix == ".csv":
            writer = CsvWriter(files, name, eye, error_array is not None, array.shape[2])
        else:
            raise Error(f"{name}: a .npy file holds one array; save responses and errors apart")
        writer.write(Piece(0, array, error_array))


@dataclass(frozen=True)
class Piece:
    """What was rendered of some poses that follow each other."""

    first: int  # number of the first pose
    responses: NDArray[np.float32]  # (P, N, C), or (P, R) of receptors
    errors: NDArray[np.float32] | None = None  # standard errors of these
    rays: NDArray[np.int32] | None = None  # (P, N), where they differ
    beside: Mapping[str, NDArray[Any]] = field(default_factory=dict)  # (P, ...), by variable

    @property
    def poses(self) -> slice:
        """Which poses these are of all."""
        return slice(self.first, self.first + len(self.responses))

    @property
    def variables(self) -> dict[str, NDArray[Any]]:
        """What there is of each variable, by its name in files."""
        named = {"response": self.responses, "standard_error": self.errors, "rays": self.rays}
        return {name: values for name, values in named.items() if values is not None} | dict(
            self.beside
        )


class Writer(Protocol):
    """Takes the responses of a render piece by piece."""

    def write(self, piece: Piece) -> None: ...


class NpyWriter:
    """One variable as one array (P, ...)."""

    def __init__(
        self,
        files: WholeFiles,
        name: str,
        shape: Sequence[int],
        variable: str = "response",
        dtype: str = "float32",
    ) -> None:
        self._file = files.open(name)
        self._variable = variable
        self._dtype = np.dtype(dtype).newbyteorder("<")
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            header, {"descr": self._dtype.str, "fortran_order": False, "shape": tuple(shape)}
        )
        self._file.write_header(header.getvalue())

    def write(self, piece: Piece) -> None:
        array = np.ascontiguousarray(piece.variables[self._variable], dtype=self._dtype)
        self._file.write(array.data)


class CsvWriter:
    """A line for each pose and ommatidium; numbers with nine digits, which is all of a float32.
    ``with_cameras``: also how near cameras of the capture were."""

    def __init__(
        self,
        files: WholeFiles,
        name: str,
        eye: Eye,
        with_errors: bool,
        bands: int,
        with_cameras: bool = False,
    ) -> None:
        self._file = files.open(name)
        self._with_errors, self._with_cameras = with_errors, with_cameras
        columns = list("rgb") if bands == 3 else [f"band_{b}" for b in range(bands)]
        if with_errors:
            columns += [f"{column}_error" for column in columns]
        if with_cameras:
            columns += CAMERA_COLUMNS.values()
        header = "pose,ommatidium,eye_id,azimuth_deg,elevation_deg"
        self._file.write_header(f"{header},{','.join(columns)}\n".encode())
        azimuth, elevation = azimuth_elevation_deg_of(eye.axis)
        numbered = enumerate(zip(eye.eye_id.tolist(), azimuth, elevation, strict=True))
        self._columns = [f"{i},{which},{a:.6g},{e:.6g}" for i, (which, a, e) in numbered]

    def write(self, piece: Piece) -> None:
        table = piece.responses
        if self._with_errors:
            assert piece.errors is not None
            table = np.concatenate([table, piece.errors], axis=-1)
        if self._with_cameras:
            found = [piece.beside[name] for name in CAMERA_COLUMNS]
            size = (*table.shape[:2], 1)
            each = [np.broadcast_to(one.reshape(len(one), -1, 1), size) for one in found]
            table = np.concatenate([table, *each], axis=-1)
        form = ",".join(["%.9g"] * table.shape[-1])
        for number, pose in enumerate(table, start=piece.first):
            lines = [
                f"{number},{columns},{form % tuple(values)}\n"
                for columns, values in zip(self._columns, pose.tolist(), strict=True)
            ]
            self._file.write("".join(lines).encode())


def _responses(values: ArrayLike, eye: Eye, name: str) -> NDArray[np.float32]:
    array = array_of(values, name, dtype=np.float32)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[1] != len(eye) or not 1 <= array.shape[2] <= _core.most_bands:
        expected = f"(P, {len(eye)}, bands)"
        raise Error(f"{name}: expected shape {expected}, found {array.shape}")
    return array
