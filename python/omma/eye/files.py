"""Eyes from files and into them (docs/eyes.md)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from omma import _core
from omma._core import Error, Eye
from omma.base.addresses import expect_local
from omma.base.arguments import checked
from omma.base.files import PathLike, metres_per_unit
from omma.base.warn import warn_caller

# Files of the Open Compound Eye Standard.
OCES_SUFFIXES = (".gltf", ".glb")
# Files that eyes are written to.
EYE_SUFFIXES = (".csv", *OCES_SUFFIXES, ".eye")


@checked
def load_eye(path: PathLike, unit: str | float = "mm", *, head: str | int | None = None) -> Eye:
    """Read an eye; the ending of the name says which format it is (docs/eyes.md).

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
        omma.Error: the file is missing or wrong; it names the file and says where in it.

    Warns:
        UserWarning: numbers that no animal has, mostly in another unit.
    """
    metres = metres_per_unit(unit)
    if head is not None and Path(os.fsdecode(path)).suffix.lower() not in OCES_SUFFIXES:
        raise Error(f"{os.fsdecode(path)}: only .gltf and .glb files have heads to choose from")
    eye = _core.load_eye(path, metres, "" if head is None else str(head))
    warn_of_unusual(eye)
    return eye


def load_head(paths: Sequence[PathLike], unit: str | float = "mm") -> Eye:
    """The eye of a file, or one head of the eyes of several."""
    eyes = [load_eye(path, unit) for path in paths]
    return eyes[0] if len(eyes) == 1 else _core.merge_eyes(eyes)


def warn_of_unusual(eye: Eye) -> None:
    """Tell the caller of the package which numbers of an eye no animal has: slips of units,
    mostly."""
    for sentence in _core.unusual_of(eye):
        warn_caller(f"{eye.path or 'eye'}: {sentence}", UserWarning)


@checked
def eye_file_heads(path: PathLike) -> list[str]:
    """The names of the heads in an OCES file (`.gltf`, `.glb`) that are enabled; none where a glTF
    file has no eyes.

    Raises:
        omma.Error: the file is missing or wrong.
    """
    return _core.eye_file_heads(path)


@checked
def save_eye(path: PathLike, eye: Eye, unit: str | float = "mm", *, lossy: bool = False) -> None:
    """Write an eye, in the format that the ending of the name says; `load_eye` reads it back.

    `.csv`, `.gltf` and `.glb` keep everything, to the last bit. An `.eye` file, with lengths in
    ``unit``, holds position, axis, acceptance angle and focal offset only.

    Args:
        lossy: write an `.eye` file although the eye has more than it can hold, which is then lost.
            `eye_file_losses` says what.

    Raises:
        omma.Error: another ending; the file cannot be written; it cannot hold all of the eye and
            ``lossy`` is not said: the error names what would be lost.
    """
    _core.save_eye(expect_local(path, "an eye"), eye, metres_per_unit(unit), lossy)


@checked
def eye_file_losses(path: PathLike, eye: Eye) -> list[str]:
    """What of an eye a file of that name cannot hold, a few words each; empty where all is
    kept.
    """
    return _core.eye_file_losses(path, eye)
