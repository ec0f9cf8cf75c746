"""Which way up pictures of files are: cameras keep pixels as their sensor read them, and say beside
them, in EXIF, how they are to be turned. The engine reads pixels as they are kept, as glTF wants it
of textures.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from omma._core import Image
from omma.base.files import PathLike

# What each orientation of EXIF 2.32 (tag 274) asks for.
TURNS = {
    1: "as it is kept",
    2: "mirrored",
    3: "turned by 180°",
    4: "mirrored, upside down",
    5: "mirrored and turned by 90° to the left",
    6: "turned by 90° to the right",
    7: "mirrored and turned by 90° to the right",
    8: "turned by 90° to the left",
}
_TAG, _SHORT = 274, 3
_EXIF = b"Exif\0\0"


def load_upright(path: PathLike) -> Image:
    """The picture of a file, turned as its EXIF says.

    Raises:
        omma.Error: there is no such picture.
    """
    image = Image(os.fspath(path))
    orientation = orientation_of(path)
    if orientation == 1:
        return image
    return Image(np.ascontiguousarray(_turned(image.pixels, orientation)), image.name)


def orientation_of(path: PathLike) -> int:
    """The orientation, 1 to 8, that the EXIF of a JPEG, PNG or WebP file says; 1 where it says
    none, or cannot be read, which is told where its pixels are."""
    try:
        with open(path, "rb") as file:
            said = [_orientation_in(block.removeprefix(_EXIF)) for block in _exif_blocks(file)]
    except OSError:
        return 1
    return next((one for one in said if one in TURNS), 1)


def _turned(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    down = -1 if orientation in (3, 4, 7, 8) else 1
    right = -1 if orientation in (2, 3, 6, 7) else 1
    return pixels[::down, ::right]


def _exif_blocks(file: BinaryIO) -> Iterator[bytes]:
    """The blocks of EXIF of a file, as far as it is whole."""
    begins = file.read(12)
    if begins.startswith(b"\xff\xd8"):
        file.seek(2)
        yield from _of_jpeg(file)
    elif begins.startswith(b"\x89PNG"):
        file.seek(8)
        yield from _of_chunks(file, b"eXIf")
    elif begins.startswith(b"RIFF") and begins.endswith(b"WEBP"):
        yield from _of_chunks(file, b"EXIF")


def _of_jpeg(file: BinaryIO) -> Iterator[bytes]:
    """Of the segments before the pixels those of EXIF."""
    while len(head := file.read(4)) == 4 and head[0] == 0xFF and head[1] != 0xDA:
        length = int.from_bytes(head[2:], "big") - 2
        if length < 0:
            return
        block = file.read(length)
        if head[1] == 0xE1 and block.startswith(_EXIF):
            yield block


def _of_chunks(file: BinaryIO, wanted: bytes) -> Iterator[bytes]:
    """Of the chunks of a PNG or WebP file those of a kind, which name the format."""
    is_png = wanted == b"eXIf"
    while len(head := file.read(8)) == 8:
        kind, size = (head[4:], head[:4]) if is_png else (head[:4], head[4:])
        length = int.from_bytes(size, "big" if is_png else "little")
        after = 4 if is_png else length % 2
        if kind == wanted:
            yield file.read(length)
            file.seek(after, os.SEEK_CUR)
        else:
            file.seek(length + after, os.SEEK_CUR)


def _orientation_in(tiff: bytes) -> int:
    """What EXIF says, which is a TIFF file without pixels; 0 where it says none."""
    if tiff[:2] not in (b"II", b"MM"):
        return 0
    order: Literal["little", "big"] = "little" if tiff[:2] == b"II" else "big"

    def number(at: int, size: int) -> int:
        return int.from_bytes(tiff[at : at + size], order)

    first = number(4, 4)
    for entry in range(first + 2, first + 2 + 12 * number(first, 2), 12):
        if number(entry, 2) == _TAG and number(entry + 2, 2) == _SHORT:
            return number(entry + 8, 2)
    return 0
