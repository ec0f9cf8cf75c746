"""Pixels of pictures that are no radiance, or that are in another unit than is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.srgb import linear_of_srgb
from omma.base.warn import warn_caller

# Floats of 8-bit pictures are whole numbers up to 255; fewer levels without that very number, or
# none above so much, may as well be radiances that somebody made up.
_WHITE, _LEAST_WHITE, _LEAST_LEVELS = 255, 16, 8
# Bands of red, green and blue with how far light is let through.
_RGBA = 4
# So many of a picture's numbers are looked at.
_LOOKED_AT = 1 << 14


def check_radiance(pixels: NDArray[Any], name: str, hint: str = "") -> None:
    """omma.Error where floats (..., height, width, bands) are negative or infinite, with the pixel;
    NaN is not known, which is for the caller to judge.

    Args:
        hint: what else can be done with such numbers, put behind the message.
    """
    wrong = _first_wrong(pixels)
    if wrong is not None:
        raise Error(f"{name}: expected radiances of at least 0, found {wrong}{hint}")


def check_finite(pixels: NDArray[Any], name: str) -> None:
    """omma.Error where numbers (..., height, width, bands) are not finite, with the pixel."""
    found = _first_of(~np.isfinite(pixels), pixels)
    if found is not None:
        raise Error(f"{name}: expected finite radiances, found {found}")


def check_picture(pixels: NDArray[Any], name: str) -> None:
    """omma.Error where a picture (height, width, 3 or 4) in floats is negative, with the pixel; the
    caller of the package is told of one in 8 bits."""
    if pixels.dtype.kind == "f":
        check_radiance(pixels[..., :3], name)
        warn_of_bytes(pixels[..., :3], name)


def warn_of_background(pixels: NDArray[Any] | None) -> None:
    """Tell the caller of the package of a background's pixels that are negative, or in 8 bits."""
    if pixels is None or pixels.dtype.kind != "f":
        return
    wrong = _first_wrong(pixels)
    if wrong is not None:
        warn_caller(
            f"background: expected radiances of at least 0, found {wrong}: responses may be "
            "negative; only a difference of pictures is so",
            UserWarning,
        )
    warn_of_bytes(pixels[..., :3], "background")


def warn_of_bytes(pixels: NDArray[Any], name: str) -> None:
    """Tell the caller of the package of floats that look like those of a picture in 8 bits: white
    is then 255, and sRGB counts as linear."""
    if pixels.dtype.kind != "f":
        return
    flat = pixels.reshape(-1)
    some = flat[:: max(flat.size // _LOOKED_AT, 1)]
    some = some[np.isfinite(some)]
    if some.size == 0:
        return
    most = float(some.max())
    if not (some.min() >= 0 and _LEAST_WHITE <= most <= _WHITE and (some == np.rint(some)).all()):
        return
    if most < _WHITE and len(np.unique(some)) < _LEAST_LEVELS:
        return
    meant = float(linear_of_srgb(np.array(most / _WHITE)))
    warn_caller(
        f"{name}: floats are linear radiance, found whole numbers up to {most:g}, as of a picture "
        f"in 8 bits, in which {most:g} would be {meant:.4g}: give it as uint8, which is sRGB",
        UserWarning,
    )


def warn_of_alpha(pixels: NDArray[Any], name: str) -> None:
    """Tell the caller of the package of pixels in 8 bits that look like RGBA, where each band is
    light."""
    if pixels.dtype == np.uint8 and pixels.shape[-1] == _RGBA:
        warn_caller(
            f"{name}: found four bands in 8 bits, as of RGBA, and each of them counts as light, "
            f"alpha too: give {name}[..., :3] for red, green and blue, or floats, which are "
            "linear, for four bands",
            UserWarning,
        )


def _first_wrong(pixels: NDArray[Any]) -> str | None:
    """The first pixel that is negative or infinite, in words."""
    with np.errstate(invalid="ignore"):
        wrong = (pixels < 0) | np.isinf(pixels)
    return _first_of(wrong, pixels)


def _first_of(wrong: NDArray[np.bool_], pixels: NDArray[Any]) -> str | None:
    """The first of the pixels that are wrong, in words: its value, row and column."""
    if not wrong.any():
        return None
    at = np.unravel_index(int(wrong.argmax()), pixels.shape)
    numbers = ", ".join(str(int(one)) for one in at[:-1])
    return f"{float(pixels[at]):g} in band {int(at[-1])} of pixel ({numbers}), of {wrong.sum()}"
