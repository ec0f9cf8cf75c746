"""Pictures that mesh files name: the engine reads them, Pillow those of other formats. Their
colours and their opacity are often two files, in the engine they are one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image

Pixels = NDArray[Any]

# As many as the engine reads of any image.
MOST_PIXELS = 1 << 28


def read_picture(path: str) -> Pixels:
    """The picture of a file: (height, width, 4), uint8 (sRGB) or float32 (linear)."""
    try:
        return np.asarray(Image(path).pixels)
    except Error as error:
        read = _by_pillow(path)
        if read is None:
            raise error
        return read


def _by_pillow(path: str) -> Pixels | None:
    """None where Pillow is not installed or knows no such format either."""
    try:
        from PIL import Image as Pillow
    except ImportError:
        return None
    try:
        with Pillow.open(path, formats=("BMP", "TGA", "TIFF", "GIF", "WEBP", "DDS")) as picture:
            if picture.width * picture.height > MOST_PIXELS:
                return None
            return np.asarray(picture.convert("RGBA"))
    except Exception:  # whatever its many readers raise
        return None


def opaque(pixels: Pixels) -> Pixels:
    """The same colours, nothing of it transparent."""
    if (pixels[..., 3] == 255).all():
        return pixels
    made: Pixels = pixels.copy()
    made[..., 3] = 255
    return made


def alpha_of(pixels: Pixels) -> NDArray[np.uint8]:
    """The opacity that a picture stands for: its alpha where it has any, else how bright it is."""
    if pixels.dtype != np.uint8:
        pixels = np.rint(np.clip(pixels, 0, 1) * 255).astype(np.uint8)
    if (pixels[..., 3] < 255).any():
        return np.asarray(pixels[..., 3])
    red, green, blue = (pixels[..., i].astype(np.uint32) for i in range(3))
    # Rec. 601, the brightness of code values; exact for grey.
    return np.asarray((299 * red + 587 * green + 114 * blue + 500) // 1000, np.uint8)


def with_alpha(colors: Pixels | None, alpha: NDArray[np.uint8]) -> Pixels:
    """RGBA of two pictures, as large as the larger one; white where there are no colours."""
    if colors is None:
        colors = np.full((1, 1, 4), 255, np.uint8)
    if colors.dtype != np.uint8:
        raise Error("map_d beside a picture of floating point numbers is not read")
    height, width = (max(colors.shape[i], alpha.shape[i]) for i in (0, 1))
    if height * width > MOST_PIXELS:
        raise Error(f"expected pictures of at most {MOST_PIXELS} pixels together")
    made: Pixels = _as_large(colors, height, width).copy()
    made[..., 3] = _as_large(alpha, height, width)
    return made


def _as_large(pixels: Pixels, height: int, width: int) -> Pixels:
    if pixels.shape[:2] == (height, width):
        return pixels
    rows = np.arange(height) * pixels.shape[0] // height
    columns = np.arange(width) * pixels.shape[1] // width
    return np.asarray(pixels[rows[:, None], columns])
