"""Which ommatidium each pixel of the page's picture shows: as large as browsers show it, without
margins, so that what the animal sees has the room."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arrays import Flags
from omma.view.painting import PROJECTIONS, eye_ids, unseen_in

Ids = NDArray[np.int32]
T = TypeVar("T", bound=np.generic)

# Before any browser has said how large its picture is; and what is painted at most.
FIRST_WIDTH, MOST_PIXELS = 800, 1600 * 1600
_LEAST_WIDTH = 40
_PROBE_WIDTH = 800
# A projection is drawn at most so wide, of which margins are then cut off.
_WIDEST = 4096
# What stays of an empty strip between two eyes, and around all, of the picture's width.
_GAP = 0.015


class PictureIds:
    """The id maps of an eye's pictures; the last is kept."""

    def __init__(self, eye: Eye) -> None:
        self._eye = eye
        self._last: tuple[tuple[str, int, int], Ids, Flags] | None = None

    def fitted(self, projection: str, width: int, height: int) -> Ids:
        """The picture that just fits into so many pixels; of a size of 0 the first one's."""
        return self._kept(projection, width, height)[0]

    def unseen(self, projection: str, width: int, height: int) -> Flags:
        """Where that picture shows directions that no ommatidium sees."""
        return self._kept(projection, width, height)[1]

    def _kept(self, projection: str, width: int, height: int) -> tuple[Ids, Flags]:
        key = (projection, width, height)
        if self._last is None or self._last[0] != key:
            self._last = (key, *self._make(projection, width, height))
        return self._last[1], self._last[2]

    def _make(self, projection: str, width: int, height: int) -> tuple[Ids, Flags]:
        if width < 1 or height < 1:
            width = height = FIRST_WIDTH
        # Where each eye is drawn apart the strip between them says nothing; in maps of directions
        # it does.
        apart = PROJECTIONS[projection] == "facets"
        probe = without_margins(eye_ids(self._eye, projection, _PROBE_WIDTH), apart)
        high, wide = probe.shape
        scale = min(width / wide, height / high, np.sqrt(MOST_PIXELS / (high * wide)))
        drawn = int(np.clip(round(scale * _PROBE_WIDTH), _LEAST_WIDTH, _WIDEST))
        whole = eye_ids(self._eye, projection, drawn)
        kept = _within_margins(whole, apart)
        return _cut(whole, kept), _cut(unseen_in(whole, projection), kept)


def without_margins(ids: Ids, between: bool = False) -> Ids:
    """An id map without the rows and columns at its edges that show nothing, but for a narrow rim;
    ``between``: nor those in the middle."""
    return _cut(ids, _within_margins(ids, between))


def _cut(pixels: NDArray[T], kept: tuple[NDArray[np.int64], NDArray[np.int64]]) -> NDArray[T]:
    return np.ascontiguousarray(pixels[np.ix_(*kept)])


def _within_margins(ids: Ids, between: bool) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The rows and the columns that `without_margins` keeps."""
    seen = ids >= 0
    gap = max(2, round(_GAP * ids.shape[1]))
    rows, columns = _near(np.any(seen, 1), gap), _near(np.any(seen, 0), gap)
    if not len(rows):
        return np.arange(ids.shape[0]), np.arange(ids.shape[1])
    if not between:
        rows = np.arange(rows[0], rows[-1] + 1)
        columns = np.arange(columns[0], columns[-1] + 1)
    return rows, columns


def _near(seen: NDArray[np.bool_], gap: int) -> NDArray[np.int64]:
    """Which rows are kept: those that show something, and the ``gap`` / 2 nearest to them."""
    at = np.flatnonzero(seen)
    if not len(at):
        return at
    near = np.zeros(len(seen), bool)
    half = max(1, gap // 2)
    for offset in range(-half, half + 1):
        near[np.clip(at + offset, 0, len(seen) - 1)] = True
    return np.flatnonzero(near)
