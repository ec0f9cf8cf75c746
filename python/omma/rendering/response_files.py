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
from omma.rendering.labels import RGB, Labels, band_names, unit_of
from omma.scene.world import World

# Of `.csv` files, by the variable that they are.
CAMERA_COLUMNS = {"camera_distance": "camera_distance_m", "camera_angle": "camera_angle_deg"}
# When a pose is, and the unit of responses that are not relative.
TIME_COLUMN, UNIT_COLUMN = "time_s", "unit"


@checked
def save_responses(
    path: PathLike,
    responses: ArrayLike,
    eye: Eye,
    errors: ArrayLike | None = None,
    *,
    world: World | None = None,
) -> None:
    """Write responses (P, N, C) or (N, C) to `.npy` or `.csv`, by the name's ending.

    `.npy` is the float32 array (P, N, C). `.csv` has a line for each pose and ommatidium: pose,
    ommatidium, eye_id, azimuth_deg, elevation_deg (of its axis in the head: azimuth 0 ahead, to the
    right positive), a column for each band, and with ``errors`` one more for each, NAME_error. A
    cell is empty where a number is NaN.

    Args:
        world: that was rendered, which tells what the bands of a `.csv` are called: in light by the
            middle of each, ``350 nm``, with a column ``unit`` before them; without, r, g, b; and
            band_0, band_1, ... where it has ``band_from_rgb``. None: nothing says what the bands
            are, so that they are band_0, band_1, ..., also where there are three.

    Raises:
        omma.Error: another ending, responses of another eye, bands that are not those of the world,
            a file that cannot be written.
    """
    name = os.fsdecode(path)
    array = _responses(responses, eye, "responses")
    error_array = None if errors is None else _responses(errors, eye, "errors")
    if error_array is not None and error_array.shape != array.shape:
        raise Error(f"errors: expected shape {array.shape}, found {error_array.shape}")
    bands = array.shape[2]
    if world is not None and world.bands != bands:
        raise Error(f"world: expected one of {bands} bands as the responses, found {world.bands}")
    check_ending(name, ".npy", ".csv")
    suffix = Path(name).suffix.lower()
    with WholeFiles() as files:
        if suffix == ".npy" and error_array is None:
            writer: Writer = NpyWriter(files, name, array.shape)
        elif suffix == ".csv":
            names = [f"band_{b}" for b in range(bands)] if world is None else band_names(world)
            unit = "1" if world is None else unit_of(world)
            columns = CsvColumns(names, unit, with_errors=error_array is not None)
            writer = CsvWriter(files, name, eye, columns)
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


@dataclass(frozen=True)
class CsvColumns:
    """What a `.csv` file has beside the pose and where each ommatidium, or receptor, looks."""

    bands: Sequence[str]
    """Names of the columns of responses, red, green and blue as `band_names` has them."""
    unit: str = "1"
    """Of responses: a column where it is another."""
    with_errors: bool = False
    with_cameras: bool = False
    """Whether how near cameras of the capture were is there."""
    times_s: NDArray[np.float64] | None = None
    """When each pose is, a column where it is known."""

    @staticmethod
    def of(labels: Labels, with_errors: bool) -> CsvColumns:
        """Of responses with these labels."""
        _, _, about = labels.variables["response"]
        bands = labels.coordinates["band"][1].tolist() if "band" in labels.coordinates else []
        return CsvColumns(
            bands or ["response"],
            about["units"],
            with_errors,
            "camera_angle" in labels.variables,
            labels.coordinates["time"][1] if "time" in labels.coordinates else None,
        )

    def header(self, sites: str) -> bytes:
        """The first line; ``sites``: what each ommatidium has."""
        bands = list("rgb") if tuple(self.bands) == RGB else list(self.bands)
        columns = [] if self.times_s is None else [TIME_COLUMN]
        columns += [] if self.unit == "1" else [UNIT_COLUMN]
        columns += bands + ([f"{band}_error" for band in bands] if self.with_errors else [])
        columns += CAMERA_COLUMNS.values() if self.with_cameras else []
        return f"pose,ommatidium,eye_id,{sites},{','.join(columns)}\n".encode()

    def lines(self, number: int, sites: Sequence[str], table: NDArray[Any]) -> bytes:
        """Those of one pose: its numbers (N, columns) after what each of N sites has, with nine
        digits, which is all of a float32, and nothing for NaN."""
        time = "" if self.times_s is None else f",{self.times_s[number]:.15g}"
        before = time if self.unit == "1" else f"{time},{self.unit}"
        form = ",%.9g" * table.shape[-1]
        return "".join(
            f"{number},{site}{before}{(form % tuple(values)).replace(',nan', ',')}\n"
            for site, values in zip(sites, table.tolist(), strict=True)
        ).encode()


class CsvWriter:
    """A line for each pose and ommatidium."""

    def __init__(self, files: WholeFiles, name: str, eye: Eye, columns: CsvColumns) -> None:
        self._file = files.open(name)
        self._columns = columns
        self._file.write_header(columns.header("azimuth_deg,elevation_deg"))
        azimuth, elevation = azimuth_elevation_deg_of(eye.axis)
        numbered = enumerate(zip(eye.eye_id.tolist(), azimuth, elevation, strict=True))
        self._sites = [f"{i},{which},{a:.6g},{e:.6g}" for i, (which, a, e) in numbered]

    def write(self, piece: Piece) -> None:
        table = piece.responses
        if self._columns.with_errors:
            assert piece.errors is not None
            table = np.concatenate([table, piece.errors], axis=-1)
        if self._columns.with_cameras:
            found = [piece.beside[name] for name in CAMERA_COLUMNS]
            size = (*table.shape[:2], 1)
            each = [np.broadcast_to(one.reshape(len(one), -1, 1), size) for one in found]
            table = np.concatenate([table, *each], axis=-1)
        for number, pose in enumerate(table, start=piece.first):
            self._file.write(self._columns.lines(number, self._sites, pose))


def _responses(values: ArrayLike, eye: Eye, name: str) -> NDArray[np.float32]:
    array = array_of(values, name, dtype=np.float32)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[1] != len(eye) or not 1 <= array.shape[2] <= _core.most_bands:
        message = f"{name}: expected shape (P, {len(eye)}, bands), found {array.shape}"
        if array.ndim == 4 and array.shape[1:3] == (len(eye), 3):
            message += (
                f"; of Stokes vectors {name}[:, :, 0] is the intensity, and numpy.save keeps all "
                "three"
            )
        raise Error(message)
    return array
