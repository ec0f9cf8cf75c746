"""What a scene's animations bend and move, as its rig says."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Scene

# As numbers of the rig's parts: what a channel moves, and how it goes between its keys.
_WEIGHTS = 3
_STEP, _CUBIC_SPLINE = 1, 2


class RigParts:
    """What of a scene can move, read once: nodes, bones, cameras, and when each of them moves."""

    def __init__(self, scene: Scene) -> None:
        rig = scene.rig
        # The fields of Rig in their order (omma/rig.h).
        parts: tuple[Any, ...] = ((), (), (), ()) if rig is None else rig.__getstate__()[1]
        nodes, skins, deformations, animations = parts
        self._parents = [node[1] for node in nodes]
        self._camera_nodes = {node[3]: n for n, node in enumerate(nodes) if node[3] >= 0}
        joints = [skin[1].tolist() for skin in skins]
        # Of each mesh that changes its shape: the node whose weights it has, and its bones.
        self._bent = [
            (mesh, node if targets else -1, joints[skin] if skin >= 0 else [])
            for mesh, _, _, node, targets, skin, *_ in deformations
        ]
        self._channels: list[list[tuple[Any, ...]]] = [list(one[2]) for one in animations]
        self._things = _things_of_meshes(scene) if self._bent else {}

    def moves_camera(self, camera: int, animations: Sequence[int]) -> bool:
        """Whether one of these animations, all where there are none, moves a camera of the scene.

        Args:
            camera: an index in ``scene.cameras``.
        """
        node = self._camera_nodes.get(camera, -1)
        moved = {one[0] for one in self._chosen(animations) if one[1] != _WEIGHTS}
        return node in self._with_children(moved)

    def ends_s(self, animations: Sequence[int]) -> tuple[float, float]:
        """When the first and the last key of these animations are, of all where there are none."""
        keys = [keys for _, _, _, keys, _ in self._chosen(animations) if len(keys)]
        if not keys:
            return -np.inf, np.inf
        return min(float(one[0]) for one in keys), max(float(one[-1]) for one in keys)

    def bent(
        self, times_s: NDArray[np.float64], moment_s: float, animations: Sequence[int]
    ) -> list[int]:
        """What changes its shape within a moment of one of these times, s: indices in
        `World.instances`. What jumps there, from key to key, does not count."""
        moving = [
            (node, part)
            for node, part, way, keys, values in self._chosen(animations)
            if _moves_at(way, keys, values, times_s, moment_s)
        ]
        blended = {node for node, part in moving if part == _WEIGHTS}
        moved = self._with_children({node for node, part in moving if part != _WEIGHTS})
        return sorted(
            self._things[mesh]
            for mesh, node, joints in self._bent
            if mesh in self._things and (node in blended or not moved.isdisjoint(joints))
        )

    def _chosen(self, animations: Sequence[int]) -> Iterable[tuple[Any, ...]]:
        """Channels: node, part, way between keys, keys, values."""
        return (
            channel
            for one, channels in enumerate(self._channels)
            for channel in channels
            if len(animations) == 0 or one in animations
        )

    def _with_children(self, moved: set[int]) -> set[int]:
        found = set(moved)
        for node, parent in enumerate(self._parents):  # parents come before children
            if parent in found:
                found.add(node)
        return found


def _things_of_meshes(scene: Scene) -> dict[int, int]:
    """The index in `World.instances` of what has a mesh: instances of one node are one thing."""
    thing_of_node: dict[tuple[int, int], int] = {}
    things = {}
    for number, instance in enumerate(scene.instances):
        node = (-1, number) if instance.node is None else (instance.node, -1)
        things[instance.mesh] = thing_of_node.setdefault(node, len(thing_of_node))
    return things


def _moves_at(
    way: int,
    keys: NDArray[np.float64],
    values: NDArray[np.float64],
    times_s: NDArray[np.float64],
    moment_s: float,
) -> bool:
    """Whether a channel is between two keys that differ, within a moment of one of these times."""
    if way == _STEP or len(keys) < 2:
        return False
    by_key = values.reshape(len(keys), -1)
    if way == _CUBIC_SPLINE:
        arrives, value, leaves = np.split(by_key, 3, axis=1)
        differ = (value[1:] != value[:-1]) | (leaves[:-1] != 0) | (arrives[1:] != 0)
    else:
        differ = by_key[1:] != by_key[:-1]
    before = np.append(0, np.cumsum(differ.any(axis=1)))
    first = np.searchsorted(keys[1:], times_s - moment_s, "right")
    end = np.searchsorted(keys[:-1], times_s + moment_s, "left")
    return bool((before[np.maximum(first, end)] > before[first]).any())
