"""Files in and out. Whatever is written is written under another name first and renamed when it is
whole, so that no half of a file is ever left under its final name.
"""

from __future__ import annotations

import io
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye, Scene
from omma.arguments import array_of
from omma.eye_lattice import azimuth_elevation_deg_of

PathLike = str | os.PathLike[str]

# Files of the Open Compound Eye Standard.
OCES_SUFFIXES = (".gltf", ".glb")

# Files that are named where many were left behind; and what ends their names, .TOKEN.partial.
_NAMED = 3
_TAIL = len(".0123456789ab.partial")

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


def open_text(path: PathLike) -> io.TextIOWrapper:
    """The text of a file, to be read as an open one is; line ends are as they stand there.

    Raises:
        omma.Error: it is no regular file (a pipe may never end), cannot be read or is not UTF-8.
    """
    data = _core.read_file(path)
    try:
        data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise Error(
            f"{os.fsdecode(path)}, line {line}: expected UTF-8 text, found other bytes"
        ) from None
    # Decoded again line by line: a million poses are then not in memory as text.
    return io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", newline="")


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
    suffix = Path(name).suffix.lower()
    with WholeFiles() as files:
        if suffix == ".npy" and error_array is None:
            writer: Writer = NpyWriter(files, name, array.shape)
        elif suffix == ".csv":
            writer = CsvWriter(files, name, eye, error_array is not None, array.shape[2])
        elif suffix == ".npy":
            raise Error(f"{name}: a .npy file holds one array; save responses and errors apart")
        else:
            raise Error(f"{name}: expected a name ending in .npy or .csv")
        writer.write(array, error_array, 0)


class WholeFiles:
    """Files that get their names together, when the block ends well, or are removed.

    Written by the engine's one writer: links are followed, permissions of a file that is replaced
    are kept, and everything is on the disk before it gets its name. omma.Error where the system
    refuses, or where a name is that of a directory, a device or a pipe.
    """

    def __init__(self, kept: Mapping[str, int] | None = None) -> None:
        """With ``kept`` what is written stays as NAME.partial where the block does not end well,
        and goes on after so many bytes of each file."""
        self._files = _core.WholeFiles()
        self.kept = kept
        self._numbers: dict[str, int] = {}

    def open(self, name: str) -> WholeFile:
        """A file to write to that will be called ``name``."""
        if self.kept is None:
            return WholeFile(self._files, self._files.open(name))
        begun = self.kept.get(name, 0)
        self._numbers[name] = self._files.open_kept(name, begun)
        return WholeFile(self._files, self._numbers[name], begun > 0)

    def sync(self) -> dict[str, int]:
        """Brings what is kept to the disk; the sizes of these files."""
        return {name: self._files.sync(number) for name, number in self._numbers.items()}

    def __enter__(self) -> WholeFiles:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        # What has no name yet is removed with the object too, should Ctrl-C come right here.
        try:
            if kind is None:
                self._files.finish()
        finally:
            self._files.discard()


class WholeFile:
    """One of `WholeFiles`, as far as NumPy and others need a file."""

    def __init__(self, files: _core.WholeFiles, number: int, begun: bool = False) -> None:
        self._files, self._number, self._begun = files, number, begun

    def write_header(self, data: bytes) -> None:
        """Begin with these bytes, if it has not begun before."""
        if not self._begun:
            self.write(data)

    def write(self, data: Any) -> None:
        """Add bytes, or what can be read as such."""
        self._files.write(self._number, data)

    def close(self) -> None:
        """Nothing more will be written to it. Only needed where there are thousands."""
        self._files.close(self._number)


def check_target(name: str) -> None:
    """Throws omma.Error where a file of that name cannot be made."""
    _core.check_target(name)


def left_behind(names: Sequence[str]) -> list[str]:
    """Warnings of what runs that were killed left of files with these names, and how to remove it.

    Nothing is said of runs that still go on.
    """
    found = _core.left_behind(names)
    if not found:
        return []
    size = sum(bytes_ for _, bytes_ in found) / 1e6
    listed = ", ".join(path for path, _ in found[:_NAMED])
    more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    # One pattern for all files of one run.
    patterns = dict.fromkeys(
        f"{shlex.quote(folder + os.sep if folder else '')}.*{name[-_TAIL:]}"
        for folder, name in (os.path.split(path) for path, _ in found)
    )
    return [
        f"runs that were killed left {size:,.1f} MB behind: {listed}{more}; to remove it: "
        f"rm {' '.join(patterns)}"
    ]


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
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            header, {"descr": "<f4", "fortran_order": False, "shape": tuple(shape)}
        )
        self._file.write_header(header.getvalue())

    def write(
        self, responses: NDArray[np.float32], errors: NDArray[np.float32] | None, first: int
    ) -> None:
        array = errors if self._of_errors else responses
        assert array is not None
        self._file.write(np.ascontiguousarray(array, dtype="<f4").data)


class CsvWriter:
    """A line for each pose and ommatidium; numbers with nine digits, which is all of a float32."""

    def __init__(
        self, files: WholeFiles, name: str, eye: Eye, with_errors: bool, bands: int
    ) -> None:
        self._file = files.open(name)
        columns = list("rgb") if bands == 3 else [f"band_{b}" for b in range(bands)]
        if with_errors:
            columns += [f"{column}_error" for column in columns]
        header = "pose,ommatidium,eye_id,azimuth_deg,elevation_deg"
        self._file.write_header(f"{header},{','.join(columns)}\n".encode())
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
    array = array_of(values, name, dtype=np.float32)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[1] != len(eye) or not 1 <= array.shape[2] <= _core.most_bands:
        expected = f"(P, {len(eye)}, bands)"
        raise Error(f"{name}: expected shape {expected}, found {array.shape}")
    return array
