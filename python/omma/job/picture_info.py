"""What a picture is, that stands behind all things or lights them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from omma.base.files import PathLike
from omma.base.orientation import TURNS, load_upright, orientation_of
from omma.job.results_info import Lines

PICTURE_FILES = (".png", ".jpg", ".jpeg", ".webp", ".hdr", ".exr")


def is_picture_file(path: PathLike) -> bool:
    """Whether a file is a picture, by its ending."""
    return Path(os.fsdecode(path)).suffix.lower() in PICTURE_FILES


def describe_picture(path: PathLike) -> Lines:
    """Size, values, and whether it can be all that is around.

    Raises:
        omma.Error: the file cannot be read.
    """
    pixels = load_upright(path).pixels
    orientation = orientation_of(path)
    height, width = pixels.shape[:2]
    lines = [("picture", os.fsdecode(path)), ("size", f"{width:,} x {height:,} pixels")]
    colors = pixels[..., :3]
    if pixels.dtype == np.uint8:
        lines.append(("values", f"sRGB, {colors.min()} to {colors.max()} of 255"))
    else:
        lines.append(("values", f"linear, {colors.min():.4g} to {colors.max():.4g}"))
    if orientation != 1:
        lines.append(("orientation", f"of EXIF, {orientation}: is shown {TURNS[orientation]}"))
    if width == 2 * height:
        lines.append(("panorama", "of the whole sphere, as it is twice as wide as high"))
    else:
        lines.append(("panorama", "none of the whole sphere, which is twice as wide as high"))
    return lines
