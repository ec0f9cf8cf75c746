"""Which way up pictures of files are: cameras keep pixels as their sensor read them, and say beside
them, in EXIF, how they are to be turned. The engine reads pixels as they are kept, as glTF wants it
of textures.
"""

from __future__ import annotations

import os
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image
from omma.base.files import PathLike
from omma.base.gpano import expect_whole_sphere
from omma.base.picture_blocks import BlockNames, picture_blocks

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
_BEGIN = b"Exif\0\0"
_EXIF = BlockNames(_BEGIN, b"eXIf", b"EXIF")


def load_upright(path: PathLike) -> Image:
    """The picture of all that is around in a file, turned as its EXIF says.

    Raises:
        omma.Error: there is no such picture, a pixel is not finite, or its GPano says that it is a
            part of the sphere or not equirectangular.

    Warns:
        UserWarning: its GPano says that the camera was turned or tilted.
    """
    image = upright_picture(path)
    expect_whole_sphere(path, image)
    return image


def upright_picture(path: PathLike) -> Image:
    """The picture of a file, of whatever it is, turned as its EXIF says.

    Raises:
        omma.Error: there is no such picture, or a pixel is not finite.
    """
    try:
        image = Image(os.fspath(path))
    except Error as error:
        name = os.fsdecode(path)
        raise error if str(error).startswith(name) else Error(f"{name}: {error}") from None
    orientation = orientation_of(path)
    if orientation == 1:
        return image
    return Image(np.ascontiguousarray(_turned(image.pixels, orientation)), image.name)


def orientation_of(path: PathLike) -> int:
    """The orientation, 1 to 8, that the EXIF of a JPEG, PNG or WebP file says; 1 where it says
    none, or cannot be read, which is told where its pixels are."""
    try:
        with open(path, "rb") as file:
            said = [
                _orientation_in(block.removeprefix(_BEGIN)) for block in picture_blocks(file, _EXIF)
            ]
    except OSError:
        return 1
    return next((one for one in said if one in TURNS), 1)


def _turned(pixels: NDArray[Any], orientation: int) -> NDArray[Any]:
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    down = -1 if orientation in (3, 4, 7, 8) else 1
    right = -1 if orientation in (2, 3, 6, 7) else 1
    return pixels[::down, ::right]


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
