"""Where in a picture a direction is shown that no ommatidium sees, and how people are told.

In pictures for people it is hatched: a plain grey could be a colour of the scene. What programs
read is never hatched: ids (-1), linear pictures (NaN), and `omma.picture.paint` (mid grey).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Flags

Ids = NDArray[np.int32]

# Pixels of these that show no ommatidium are no directions: there is nothing to see or to miss.
_WITHOUT_DIRECTIONS = (
    "facets",
    "single_dimension",
    "single_dimension_fast",
    "raw_ommatidial_samples",
)
_GROUND, _LINE = 128, 84  # grey levels; what is painted plainly is the ground alone
_PAPER_GROUND, _PAPER_LINE = 0.93, 0.72  # the same on the white paper of figures
#: Grey of figures where an ommatidium looks but has no number that could be drawn.
NOT_KNOWN = 0.62
#: Of angles, the same at both ends. White is among them, that grey is not.
CYCLIC_COLOURS = "twilight"
_LINES = 36  # over the height of a picture, so that hatching looks alike at any size
_LEAST_PERIOD = 6  # pixels


# Projections whose picture is an ellipse, and how many times it is as wide as high.
_ELLIPSES = {"mollweide": 2, "lambert": 1}


def aspect_of(projection: str | None) -> int:
    """How many times as wide as high a picture of a projection is, unless something else is asked
    for."""
    return _ELLIPSES.get(projection or "", 2)


def inside_outline(projection: str | None, height: int, width: int) -> Flags:
    """Which pixels lie inside a projection's own outline: (H, W)."""
    if projection in _ELLIPSES:
        return _ellipse(height, width, 0, width, _ELLIPSES[projection])
    if projection == "hemisphere":
        left = _ellipse(height, width, 0, width / 2, 1)
        return np.asarray(left | _ellipse(height, width, width / 2, width, 1))
    return np.broadcast_to(np.asarray(projection != "facets"), (height, width))


def _ellipse(height: int, width: int, left: float, right: float, aspect: float) -> Flags:
    """The largest ellipse so many times as wide as high between two columns of a picture."""
    half = min((right - left) / 2, aspect * height / 2)
    row, column = np.ogrid[:height, :width]
    x = (column + 0.5 - (left + right) / 2) / half
    y = (row + 0.5 - height / 2) / (half / aspect)
    return np.asarray(x**2 + y**2 < 1)


def unseen(ids: Ids, projection: str | None) -> Flags:
    """Which pixels of an id map (H, W) are directions that no ommatidium sees."""
    if projection in _WITHOUT_DIRECTIONS:
        return np.zeros(ids.shape, bool)
    return np.asarray((ids < 0) & inside_outline(projection, *ids.shape))


def hatch(pixels: NDArray[np.uint8], where: Flags) -> NDArray[np.uint8]:
    """Diagonal lines on grey in the pixels (H, W, 3) that ``where`` says, in place."""
    row, column = np.nonzero(where)
    levels = np.where(_on_line(row, column, len(pixels)), _LINE, _GROUND)
    pixels[row, column] = levels.astype(np.uint8)[:, None]
    return pixels


def hatching(where: Flags) -> Callable[[NDArray[np.uint8]], NDArray[np.uint8]]:
    """`hatch` of any number of pictures, where the pixels (H, W) are the same ones."""
    of_bytes = np.repeat(where[..., None], 3, axis=2)
    lines = hatch(np.zeros(of_bytes.shape, np.uint8), where)

    def hatched(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        np.copyto(pixels, lines, where=of_bytes)
        return pixels

    return hatched


def hatched_ground(hidden: Flags, inside: Flags) -> NDArray[np.float64]:
    """What lies below a picture in a figure, RGBA (H, W, 4): hatched where it is ``hidden``, light
    grey ``inside`` of its outline, else nothing."""
    row, column = np.indices(hidden.shape)
    lines = hidden & _on_line(row, column, len(hidden))
    ground = np.empty((*hidden.shape, 4))
    ground[..., :3] = np.where(lines, _PAPER_LINE, _PAPER_GROUND)[..., None]
    ground[..., 3] = inside
    return ground


def _on_line(row: Any, column: Any, height: int) -> Flags:
    period = max(_LEAST_PERIOD, height // _LINES)
    return np.asarray((row + column) % period < max(1, period // 4))
