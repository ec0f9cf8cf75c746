"""The files that a render writes: which names will do, and what writes each."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from omma import _core
from omma._core import Error, Eye
from omma.base.addresses import is_address, local_path
from omma.base.files import PathLike, WholeFiles, check_ending, check_kept
from omma.picture.files import Paint, PngWriter, series
from omma.picture.video import VideoWriter, frame_rate
from omma.rendering.label_texts import beside, labels_from_text, labels_text
from omma.rendering.labelled_files import NetcdfWriter, ZarrWriter
from omma.rendering.labels import Labels
from omma.rendering.parquet_files import ParquetWriter
from omma.rendering.receptor_files import ReceptorCsvWriter
from omma.rendering.response_files import CsvColumns, CsvWriter, NpyWriter, Writer

# These are made in full size, or end with an index, so that what is cut off is no file.
WHOLE_SUFFIXES = (".zarr", ".nc", ".parquet", ".mp4")
SUFFIXES = (*WHOLE_SUFFIXES, ".npy", ".csv", ".png")
# Of variables in `.npy` files beside the responses.
_NAMES_BESIDE = {
    "standard_error": "error",
    "camera_distance": "camera_distance",
    "camera_angle": "camera_angle",
}


def output_names(
    outputs: PathLike | Sequence[PathLike],
    standard_error: bool,
    resume: bool,
    inputs: Sequence[PathLike],
    with_cameras: bool = False,
) -> list[str]:
    """The names; omma.Error where one will not do, or is that of an input."""
    several = [outputs] if isinstance(outputs, (str, os.PathLike)) else outputs
    names = [local_path(name) for name in several]
    if not names:
        raise Error("outputs: expected at least one file to write, found none")
    for name in names:
        check_ending(name, *SUFFIXES)
        suffix = Path(name).suffix.lower()
        if Path(name).is_dir() and suffix != ".zarr":
            raise Error(f"{name}: cannot be written: it is a directory")
        if resume and is_address(name):
            raise Error(f"resume: is for files of this system, found {name}")
        if resume and suffix in WHOLE_SUFFIXES:
            raise Error(
                f"resume: is for .npy, .csv and .png, found {name}; .npy with the .json beside it "
                "says as much"
            )
    beside_each = _variables_beside(standard_error, with_cameras)
    every = [file for name in names for file in (name, *_beside(name, beside_each))]
    check_kept(every, inputs)
    return names


def check_series(names: Sequence[str], poses: int, inputs: Sequence[PathLike]) -> None:
    """As of `output_names`, of the pictures that are numbered by pose."""
    if poses < 2:
        return
    files = []
    for name in names:
        if Path(name).suffix.lower() != ".png":
            files.append(name)
        elif not is_address(name):
            folder = os.path.dirname(name) or "."
            there = set(os.listdir(folder)) if os.path.isdir(folder) else set()
            files += [one for one in series(name, poses) if os.path.basename(one) in there]
    check_kept(files, inputs)


def beside_name(name: str, variable: str) -> str:
    """Where another variable than the responses in an `.npy` file goes: beside it."""
    return f"{os.path.splitext(name)[0]}.{_NAMES_BESIDE[variable]}.npy"


def writers_of(
    files: WholeFiles,
    closed: ExitStack,
    names: Sequence[str],
    labels: Labels,
    eye: Eye,
    *,
    receptors: bool,
    standard_error: bool,
    make_paint: Callable[[], Paint],
) -> tuple[list[Writer], list[str]]:
    """Writers of the files named, and the names of all files written; ``closed`` closes those that
    must be."""
    writers: list[Writer] = []
    written: list[str] = []
    shape = labels.shape("response")
    with_cameras = "camera_angle" in labels.variables
    beside_each = _variables_beside(standard_error, with_cameras)
    for name in names:
        suffix = Path(name).suffix.lower()
        if suffix == ".npy":
            writers.append(NpyWriter(files, name, shape))
            parts = {"response": Path(name).name}
            for one in beside_each:
                file, dtype = beside_name(name, one), labels.variables[one][1]
                writers.append(NpyWriter(files, file, labels.shape(one), one, dtype))
                parts[one] = Path(file).name
            files.open(beside(name)).write_header(labels_text(labels, parts).encode())
        elif suffix == ".csv" and receptors:
            columns = CsvColumns.of(labels, standard_error)
            writers.append(ReceptorCsvWriter(files, name, eye, columns))
        elif suffix == ".csv":
            writers.append(CsvWriter(files, name, eye, CsvColumns.of(labels, standard_error)))
        elif suffix == ".png":
            picture = PngWriter(files, name, shape[0], make_paint())
            writers.append(picture)
            written += [picture.name(i) for i in range(shape[0])]
            continue
        elif suffix == ".mp4":
            rate, _ = frame_rate(labels.times_s)
            video = VideoWriter(files, name, shape[0], make_paint(), rate)
            writers.append(closed.enter_context(video))
        elif suffix == ".zarr":
            writers.append(ZarrWriter(files, name, labels))
        elif suffix == ".nc":
            writers.append(NetcdfWriter(files, name, labels))
        else:
            writers.append(ParquetWriter(files, name, labels))
        written += [name, *_beside(name, beside_each)]
    return writers, written


def earlier_files(written: Sequence[str]) -> list[str]:
    """Files of an earlier render that lie beside the `.npy` files among those that are being
    written, and will not be replaced: those that its `.json`, which is still there, says are its
    own. What is at addresses is not looked at."""
    stay = {os.path.realpath(name) for name in written if not is_address(name)}
    found: dict[str, None] = {}
    for name in written:
        if Path(name).suffix.lower() != ".npy" or is_address(name):
            continue
        others = {one: beside_name(name, one) for one in _NAMES_BESIDE}
        about = beside(name)
        there = [
            file
            for file in (*others.values(), about)
            if os.path.isfile(file) and os.path.realpath(file) not in stay
        ]
        if not there or not os.path.isfile(about):
            continue
        try:
            files = labels_from_text(_core.read_file(about), about)[1]
        except Error:  # of somebody else
            continue
        if files.get("response") != os.path.basename(name):
            continue
        own = [file for one, file in others.items() if files.get(one) == os.path.basename(file)]
        found |= dict.fromkeys(file for file in there if file in (*own, about))
    return list(found)


def remove_earlier(files: Sequence[str]) -> list[str]:
    """Removes what `earlier_files` found, and says so."""
    for file in files:
        try:
            os.remove(file)
        except FileNotFoundError:
            continue
        except OSError as error:
            raise Error(
                f"{file}: is of an earlier render and not removed: {error.strerror}"
            ) from None
    if not files:
        return []
    return [f"removed what an earlier render left beside its .npy file: {', '.join(files)}"]


def _variables_beside(standard_error: bool, with_cameras: bool) -> list[str]:
    """Those that have files of their own beside an `.npy` file."""
    cameras = ["camera_distance", "camera_angle"] if with_cameras else []
    return [*(["standard_error"] if standard_error else []), *cameras]


def _beside(name: str, variables: Sequence[str]) -> list[str]:
    """Files that come with one."""
    if Path(name).suffix.lower() != ".npy":
        return []
    return [*(beside_name(name, one) for one in variables), beside(name)]
