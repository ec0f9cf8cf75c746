"""Where nothing is near for sure: cells of space that no triangle's box comes close to.

Most positions that are tried lie in the open, where rays would only say so. Asked first, a map of
the open spares these rays; what it is not sure of is left to rays, so that answers do not depend on
it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from omma._core import Scene
from omma.base.arrays import Floats

_CELLS = 64  # along each axis
# Margin for rounding in single precision, as a fraction of the size of the scene.
_ROUNDING = 1e-5


class FarMap:
    """Cells of a box in which every position is farther from all triangles than a clearance."""

    def __init__(self, scene: Scene, low_m: Floats, high_m: Floats, clearance_m: float) -> None:
        """A map of the box from ``low_m`` (3,) to ``high_m`` (3,), of a scene without a rig."""
        self.clearance_m = clearance_m
        self._low = low_m
        self._cell = np.maximum((high_m - low_m) / _CELLS, 1e-9 * (1 + np.abs(low_m)))
        bounds = scene.bounds
        size = 0.0 if bounds is None else float(np.abs(bounds).max())
        margin = clearance_m + _ROUNDING * (size + float(np.abs([low_m, high_m]).max()))
        # Each box adds 1 to all cells that it overlaps: differences at its corners, then cumulative
        # sums along the axes.
        steps = np.zeros(3 * (_CELLS + 1,))
        for least, most in triangle_boxes(scene):
            first = np.floor((least - margin - self._low) / self._cell)
            after = np.floor((most + margin - self._low) / self._cell) + 1
            met = ((after > 0) & (first < _CELLS)).all(axis=1)
            ends = np.clip(np.stack([first[met], after[met]]), 0, _CELLS).astype(np.int64)
            for x in (0, 1):
                for y in (0, 1):
                    for z in (0, 1):
                        corner = ends[x, :, 0], ends[y, :, 1], ends[z, :, 2]
                        np.add.at(steps, corner, (-1.0) ** (x + y + z))
        self._is_far = steps.cumsum(0).cumsum(1).cumsum(2)[:_CELLS, :_CELLS, :_CELLS] < 0.5

    def is_far(self, positions: Floats) -> NDArray[np.bool_]:
        """(P,), whether positions (P, 3) are for sure farther from everything than the
        clearance."""
        cell = np.floor((positions - self._low) / self._cell).astype(np.int64)
        found = np.asarray(((cell >= 0) & (cell < _CELLS)).all(axis=1))
        found[found] = self._is_far[tuple(cell[found].T)]
        return found


def triangle_boxes(scene: Scene) -> Iterator[tuple[Floats, Floats]]:
    """Of each instance, the least and the largest coordinates of its triangles, (T, 3), m, in the
    world."""
    meshes = [(mesh.positions_m, mesh.triangles) for mesh in scene.meshes]
    for instance in scene.instances:
        positions, triangles = meshes[instance.mesh]
        placed = instance.world_from_mesh
        corners = (positions @ placed[:3, :3].T + placed[:3, 3])[triangles]
        yield corners.min(axis=1), corners.max(axis=1)
