"""What a picture is, that stands behind all things or lights them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from omma.base.files import PathLike
from omma.base.gpano import gpano_of
from omma.base.orientation import TURNS, orientation_of, upright_picture
from omma.base.srgb import srgb_of_linear
from omma.job.results_info import Lines

# The largest of 16 bits, which PNG alone has: other floats are linear in the file too.
_MOST_CODE = 65535

PICTURE_FILES = (".png", ".jpg", ".jpeg", ".webp", ".hdr", ".exr")


def is_picture_file(path: PathLike) -> bool:
    """Whether a file is a picture, by its ending."""
    return Path(os.fsdecode(path)).suffix.lower() in PICTURE_FILES


def describe_picture(path: PathLike) -> Lines:
    """Size, values, and whether it can be all that is around.

    Raises:
        omma.Error: the file cannot be read.
    """
    pixels = upright_picture(path).pixels
    orientation = orientation_of(path)
    height, width = pixels.shape[:2]
    lines = [("picture", os.fsdecode(path)), ("size", f"{width:,} x {height:,} pixels")]
    colors = pixels[..., :3]
    if pixels.dtype == np.uint8:
        lines.append(("values", f"sRGB, {colors.min()} to {colors.max()} of 255"))
    elif _is_png(path):
        codes = np.rint(srgb_of_linear(np.array([colors.min(), colors.max()], float)) * _MOST_CODE)
        low, high = (f"{one:,.0f}" for one in codes)
        lines.append(("values", f"sRGB of 16 bits, {low} to {high} of {_MOST_CODE:,}"))
    else:
        lines.append(("values", f"linear, {colors.min():.4g} to {colors.max():.4g}"))
    if orientation != 1:
        lines.append(("orientation", f"of EXIF, {orientation}: is shown {TURNS[orientation]}"))
    return lines + _panorama(path, width, height)


def _panorama(path: PathLike, width: int, height: int) -> Lines:
    """Whether it is the whole sphere, by what the file says, else by its shape, and how the camera
    was held."""
    said = gpano_of(path)
    if said is not None and not said.is_equirectangular:
        return [("panorama", f"none: {said.projection!r:.40}, as its GPano (XMP) says")]
    part = None if said is None else said.part(width, height)
    if part is not None:
        return [("panorama", f"a part of the sphere, as its GPano (XMP) says: {part}")]
    if width != 2 * height:
        return [("panorama", "none of the whole sphere, which is twice as wide as high")]
    lines = [("panorama", "of the whole sphere, as it is twice as wide as high")]
    if said is not None and said.pose is not None:
        lines.append(("camera", f"{said.pose}, as its GPano (XMP) says: is not applied"))
    return lines


def _is_png(path: PathLike) -> bool:
    with open(path, "rb") as file:
        return file.read(4) == b"\x89PNG"
