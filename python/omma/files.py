"""Files in and out. Whatever is written is written under another name first and renamed when it is
whole, so that no half of a file is ever left under its final name.
"""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable, Sequence
from io import BufferedWriter
from pathlib import Path
from types import TracebackType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye, Scene
from omma.eye_lattice import azimuth_elevation_deg_of

PathLike = str | os.PathLike[str]

# Files of the Open Compound Eye Standard.
OCES_SUFFIXES = (".gltf", ".glb")

METRES_PER_UNIT = {"mm": 1e-3, "um": 1e-6, "m": 1.0}


def metres_per_unit(unit: str | float) -> float:
    """Metres in a unit of length: "mm", "um", "m", or already a number of metres."""
    if isinstance(unit, str) and unit in METRES_PER_UNIT:
        return METRES_PER_UNIT[unit]
    try:
        metres = float(unit)
    except (TypeError, ValueError):
        metres = 0.0
    if not (metres > 0 and np.isfinite(metres)):
        raise Error(f"unit: expected mm, um, m or a number of metres, found {unit!r}")
    return metres


def load_scene(
    path: PathLike,
    scene_index: int | None = None,
    *,
    color_rule: str = "gltf",
    progress: Callable[[float], object] | None = None,
) -> Scene:
    """Read a glTF 2.0 scene, `.gltf` or `.glb`.

    Other Python threads run meanwhile, and Ctrl-C stops the work within a second.

    Args:
        path: the file.
        scene_index: which of the file's scenes; None takes its default.
        color_rule: "gltf" takes colours as glTF 2.0 says: textures are sRGB, factors and vertex
            colours linear, and they multiply. "compoundray" is for comparison with work done with
            CompoundRay: vertex colours to the power 2.2 in place of all else, or else the factor
            times the texture to the power 2.2; everything opaque and seen from both sides
            (BrainsOnBoard/compound-ray, libEyeRenderer3/shaders.cu).
        progress: called with the finished share (0 to 1), roughly, a few times a second. What it
            raises ends the loading and is raised here.

    Raises:
        omma.Error: the file is missing, broken or needs an extension that is not supported; it
            names the file and what is wrong. What was only passed over is in ``Scene.warnings``.
        KeyboardInterrupt: Ctrl-C.
    """
    if scene_index is not None and scene_index < 0:
        raise Error(f"scene_index: expected 0 or more, found {scene_index}")
    index = -1 if scene_index is None else scene_index
    return _core.load_scene(path, index, color_rule, progress)


def load_eye(path: PathLike, unit: str | float = "mm", *, head: str | int | None = None) -> Eye:
    """Read an eye; the ending of the name says which format it is (docs/eye-files.md).

    `.csv`: a line for each ommatidium, columns with names that say the unit; it keeps everything.
    `.gltf`, `.glb`: the Open Compound Eye Standard (glTF extension ``OCES_eyes``), with everything
    that Omma wrote. Anything else is an `.eye` file: position x y z, axis x y z, acceptance angle
    (rad), focal offset; spaces, tabs or commas; comments from ``#``; its frame is x right, y up, z
    forward, while `Eye` has forward along -Z.

    Args:
        unit: unit of lengths in an `.eye` file: "mm", "um", "m" or a number of metres. The other
            formats say theirs themselves.
        head: name or number of the head whose eyes are meant, where an OCES file has several.

    Raises:
        omma.Error: the file is missing or wrong; it names the file and the place in it.
    """
    metres = metres_per_unit(unit)
    if head is not None and Path(os.fsdecode(path)).suffix.lower() not in OCES_SUFFIXES:
        raise Error(f"{os.fsdecode(path)}: only .gltf and .glb files have heads to choose from")
    return _core.load_eye(path, metres, "" if head is None else str(head))


def eye_file_heads(path: PathLike) -> list[str]:
    """The names of the heads in an OCES file (`.gltf`, `.glb`) that are enabled; none where a glTF
    file has no eyes.

    Raises:
        omma.Error: the file is missing or wrong.
    """
    return _core.eye_file_heads(path)


def save_eye(path: PathLike, eye: Eye, unit: str | float = "mm", *, lossy: bool = False) -> None:
    """Write an eye, in the format that the ending of the name says; `load_eye` reads it back.

    `.csv`, `.gltf` and `.glb` keep everything, to the last bit. An `.eye` file, with lengths in
    ``unit``, has place for position, axis, acceptance angle and focal offset only.

    Args:
        lossy: write an `.eye` file although the eye has more than it can hold, which is then lost.
            `eye_file_losses` says what.

    Raises:
        omma.Error: the file cannot be written; it cannot hold all of the eye and ``lossy`` is not
            said: the error names what would be lost.
    """
    _core.save_eye(path, eye, metres_per_unit(unit), lossy)


def eye_file_losses(path: PathLike, eye: Eye) -> list[str]:
    """What of an eye a file of that name has no place for, a few words each; empty where all is
    kept.
    """
    return _core.eye_file_losses(path, eye)


def save_responses(
    path: PathLike, responses: ArrayLike, eye: Eye, errors: ArrayLike | None = None
) -> None:
    """Write responses (P, N, C) or (N, C) to `.npy` or `.csv`, by the name's ending.

    `.npy` is the float32 array (P, N, C). `.csv` has a line for each pose and ommatidium: pose,
    ommatidium, eye_id, azimuth_deg, elevation_deg (of its axis in the head: azimuth 0 ahead, to the
    right positive), r, g, b, and with ``errors`` r_error, g_error, b_error.

    Raises:
        omma.Error: another ending, responses of another eye, a file that cannot be written.
    """
    name = os.fsdecode(path)
    array = _responses(responses, eye, "responses")
    error_array = None if errors is None else _responses(errors, eye, "errors")
    if error_array is not None and error_array.shape != array.shape:
        raise Error(f"errors: expected shape {array.shape}, found {error_array.shape}")
    suffix = Path(name).suffix.lower()
    with WholeFiles() as files:
        if suffix == ".npy" and error_array is None:
            writer: Writer = NpyWriter(files, name, array.shape)
        elif suffix == ".csv":
            writer = CsvWriter(files, name, eye, error_array is not None)
        elif suffix == ".npy":
            raise Error(f"{name}: a .npy file holds one array; save responses and errors apart")
        else:
            raise Error(f"{name}: expected a name ending in .npy or .csv")
        writer.write(array, error_array, 0)


class WholeFiles:
    """Files that get their names together, when the block ends well, or are removed."""

    def __init__(self) -> None:
        self._open: list[tuple[BufferedWriter, Path, Path]] = []

    def open(self, name: str) -> BufferedWriter:
        """A file to write to that will be called ``name``."""
        check_target(name)
        target = Path(name)
        # The ending stays, because it says what is inside.
        temporary = target.parent / f".{target.stem}.{uuid.uuid4().hex[:12]}{target.suffix}"
        try:
            file = temporary.open("xb")
        except OSError as error:
            raise Error(f"{name}: cannot be written: {error.strerror}") from None
        self._open.append((file, temporary, target))
        return file

    def __enter__(self) -> WholeFiles:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        name = ""
        try:
            for file, _, target in self._open:
                name = str(target)
                file.close()
            if kind is None:
                for _, temporary, target in self._open:
                    name = str(target)
                    temporary.replace(target)
        except OSError as failure:
            # Closing flushes, so a full disk may show only here.
            if kind is None:
                raise Error(f"{name}: cannot be written: {failure.strerror}") from None
        finally:
            for _, temporary, _ in self._open:
                temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.filename is None and self._open:
            raise Error(f"{self._names()}: cannot be written: {error.strerror}") from None

    def _names(self) -> str:
        return ", ".join(str(target) for _, _, target in self._open)


def check_target(name: str) -> None:
    """Throws omma.Error where a file of that name cannot be made."""
    if Path(name).is_dir():
        raise Error(f"{name}: cannot be written: it is a directory")
    if not Path(name).parent.is_dir():
        raise Error(f"{name}: cannot be written: there is no directory {Path(name).parent}")


def make_directory(directory: Path) -> None:
    """Makes a directory and what is above it; omma.Error where that cannot be."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Error(f"{directory}: cannot be made: {error.strerror}") from None


class Writer(Protocol):
    """Takes the responses of a render piece by piece."""

    def write(
        self, responses: NDArray[np.float32], errors: NDArray[np.float32] | None, first: int
    ) -> None:
        """Responses (P, N, C) of poses number ``first`` and on, and their standard errors."""


class NpyWriter:
    """One float32 array (P, N, C); ``of_errors`` writes the standard errors instead."""

    def __init__(
        self, files: WholeFiles, name: str, shape: Sequence[int], of_errors: bool = False
    ) -> None:
        self._file = files.open(name)
        self._of_errors = of_errors
        np.lib.format.write_array_header_1_0(
            self._file, {"descr": "<f4", "fortran_order": False, "shape": tuple(shape)}
        )

    def write(
        self, responses: NDArray[np.float32], errors: NDArray[np.float32] | None, first: int
    ) -> None:
        array = errors if self._of_errors else responses
        assert array is not None
        self._file.write(np.ascontiguousarray(array, dtype="<f4").data)


class CsvWriter:
    """A line for each pose and ommatidium; numbers with nine digits, which is all of a float32."""

    def __init__(self, files: WholeFiles, name: str, eye: Eye, with_errors: bool) -> None:
        self._file = files.open(name)
        header = "pose,ommatidium,eye_id,azimuth_deg,elevation_deg,r,g,b"
        self._file.write(
            (header + (",r_error,g_error,b_error" if with_errors else "") + "\n").encode()
        )
        azimuth, elevation = azimuth_elevation_deg(eye)
        numbered = enumerate(zip(eye.eye_id.tolist(), azimuth, elevation, strict=True))
        self._places = [f"{i},{which},{a:.6g},{e:.6g}" for i, (which, a, e) in numbered]

    def write(
        self, responses: NDArray[np.float32], errors: NDArray[np.float32] | None, first: int
    ) -> None:
        table = responses if errors is None else np.concatenate([responses, errors], axis=-1)
        form = ",".join(["%.9g"] * table.shape[-1])
        for number, pose in enumerate(table, start=first):
            lines = [
                f"{number},{place},{form % tuple(values)}\n"
                for place, values in zip(self._places, pose.tolist(), strict=True)
            ]
            self._file.write("".join(lines).encode())


def azimuth_elevation_deg(eye: Eye) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Azimuth (0 ahead, to the right positive) and elevation of each axis: (N,), degrees."""
    return azimuth_elevation_deg_of(eye.axis)


def _responses(values: ArrayLike, eye: Eye, name: str) -> NDArray[np.float32]:
    array = np.asarray(values, dtype=np.float32)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[1:] != (len(eye), _core.channel_count):
        expected = f"(P, {len(eye)}, {_core.channel_count})"
        raise Error(f"{name}: expected shape {expected}, found {array.shape}")
    return array
