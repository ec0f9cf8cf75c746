"""Which of many points is nearest, for those who ask again and again for nearly the same ones."""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats, Ints


class Nearest:
    """The nearest of ``points`` (S, 3). A step of a relaxation asks three times for the same
    places, but for a few: what was found for a row the last time is not sought again."""

    def __init__(self, points: Floats) -> None:
        from scipy.spatial import cKDTree

        self.points = points
        self._tree = cKDTree(points)
        self._asked = np.empty((0, 3))
        self._found = np.empty(0, dtype=np.int64)

    def __call__(self, places: Floats) -> Ints:
        """Indices (K,) of the points nearest to places (K, 3)."""
        found = np.empty(len(places), dtype=np.int64)
        rows = np.arange(len(places))
        if len(places) == len(self._asked):
            found = self._found.copy()
            rows = np.flatnonzero((places != self._asked).any(axis=1))
        if len(rows):
            found[rows] = self._tree.query(places[rows])[1]
        self._asked, self._found = places.copy(), found
        return found
