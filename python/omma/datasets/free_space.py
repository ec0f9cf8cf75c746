"""Free space in a scene: what rays tell of the surfaces about a position.

Single-sided surfaces are met from their front only, so that positions are asked from both sides.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats
from omma.base.spirals import GOLDEN_ANGLE_RAD, fibonacci_lattice
from omma.datasets.far_map import FarMap
from omma.motion.ground_rays import LAYERS, first_below, ray_bundle, shoot, upright
from omma.rendering.renderer import Renderer
from omma.scene.world import World

# Directions in which rays are sent from a position, and towards it.
_DIRECTIONS = 128
_PIECE = 4096  # positions in one render
# Most triangles for which a map of far cells is made; and how many positions, at 256 rays each,
# cost as much as a map, per triangle.
_MOST_MAPPED = 1 << 22
_POSITIONS_PER_TRIANGLE = 0.02


class FreeSpace:
    """Asks a world, which should have no light: what is seen is of no use here."""

    def __init__(self, world: World, threads: int = 0) -> None:
        bounds = world.scene.bounds
        self.world, self._threads = world, threads
        box = np.zeros((2, 3)) if bounds is None else np.asarray(bounds)
        self._top = float(box[1, 1]) + 1.0
        # Offset against self-intersection: rays are single precision.
        self._step = max(1e-5, 1e-5 * float(np.abs(box).max()))
        self._down = ray_bundle(world, [[0, -1, 0]], threads=threads)
        self._up = ray_bundle(world, [[0, 1, 0]], threads=threads)
        self._ahead = ray_bundle(world, [[0, 0, -1]], threads=threads)
        self._balls: dict[float, Renderer] = {}
        self._maps: dict[float, FarMap] = {}
        # Skinned meshes are not where the file has their triangles: no map then.
        triangles = world.scene.triangle_count if world.scene.rig is None else _MOST_MAPPED + 1
        self._mapped_after = triangles * _POSITIONS_PER_TRIANGLE
        self._is_mapped = triangles <= _MOST_MAPPED
        self._asked = 0

    def is_free(self, positions: Floats, clearance_m: float) -> NDArray[np.bool_]:
        """(P,), whether nothing is nearer than ``clearance_m`` to a position (P, 3), and the
        position is not inside of something."""
        free = self._is_far(positions, clearance_m)
        free[~free] = self._near(positions[~free], clearance_m) >= clearance_m
        free[free] = self._depth_inside(positions[free]) <= 0
        return free

    def ground_below(self, spots: Floats, on: Sequence[str] = ()) -> Floats:
        """(P,), m: the height at x and z (P, 2) of the highest surface of the instances called so,
        through whatever is above it; without names, of anything. NaN where there is none."""
        start = np.column_stack([spots[:, 0], np.full(len(spots), self._top), spots[:, 1]])
        return first_below(self._down, start, self._step, on)[0]

    def is_clear_ahead(self, poses: NDArray[np.float64], distance_m: float) -> NDArray[np.bool_]:
        """(P,), whether heads at poses (P, 4, 4) meet nothing within a distance straight ahead."""
        return np.asarray(self._ahead.ground_truth(poses).nearest_m[:, 0] >= distance_m)

    def _is_far(self, positions: Floats, clearance_m: float) -> NDArray[np.bool_]:
        """(P,), whether the map of far cells says that no surface is nearer."""
        self._asked += len(positions)
        found = self._maps.get(clearance_m)
        if (
            found is None
            and self._is_mapped
            and self._asked > self._mapped_after
            and len(positions)
        ):
            found = FarMap(
                self.world.scene, positions.min(axis=0), positions.max(axis=0), clearance_m
            )
            self._maps[clearance_m] = found
        return np.zeros(len(positions), np.bool_) if found is None else found.is_far(positions)

    def _near(self, positions: Floats, radius_m: float) -> Floats:
        """(P,), m: distance of the nearest surface about a position, as far as ``radius_m``."""
        if radius_m not in self._balls:
            out = _directions(_DIRECTIONS)
            # Rays from the position, and rays towards it from a sphere about it.
            self._balls[radius_m] = ray_bundle(
                self.world,
                np.concatenate([out, -out]),
                np.concatenate([0 * out, radius_m * out]),
                self._threads,
            )
        found = []
        for first in range(0, len(positions), _PIECE):
            poses = upright(positions[first : first + _PIECE])
            seen = self._balls[radius_m].ground_truth(poses).nearest_m
            away, towards = seen[:, :_DIRECTIONS], seen[:, _DIRECTIONS:]
            # Hits of inward rays beyond the position do not count.
            nearest = np.minimum(away, np.where(towards < radius_m, 0, np.inf)).min(axis=1)
            found.append(nearest)
        return np.concatenate(found) if found else np.empty(0)

    def _depth_inside(self, positions: Floats) -> NDArray[np.int64]:
        """(P,), the number of closed surfaces around positions (P, 3): along the line upwards,
        upward faces less downward ones, where there are any of the former. Two-sided faces count as
        both, so as none."""
        top = positions.copy()
        top[:, 1] = np.maximum(self._top, positions[:, 1] + 1)
        depth = self._crossed(self._down, top, -1, top[:, 1] - positions[:, 1])
        # Without upward faces above, downward ones make no difference.
        below = np.flatnonzero(depth > 0)
        depth[below] -= self._crossed(self._up, positions[below], 1, (top - positions)[below, 1])
        return depth

    def _crossed(
        self, rays: Renderer, start: Floats, sign: int, length: Floats
    ) -> NDArray[np.int64]:
        """How many surfaces vertical rays meet on so much of their way."""
        number = np.zeros(len(start), np.int64)
        position, left = start.copy(), np.arange(len(start))
        for _ in range(LAYERS):
            if len(left) == 0:
                break
            distance = shoot(rays, upright(position[left])).distance_m[:, 0]
            gone = np.abs(position[left, 1] - start[left, 1]) + distance
            met = gone < length[left]
            number[left[met]] += 1
            left = left[met]
            position[left, 1] += sign * (distance[met] + self._step)
        return number


def _directions(number: int) -> Floats:
    """(N, 3), spread evenly over the sphere."""
    return fibonacci_lattice(GOLDEN_ANGLE_RAD * np.arange(number))[:, [0, 2, 1]]
