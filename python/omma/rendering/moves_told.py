"""What data sets say of how the scene was moved and of what was not seen, so that it can be
rendered again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Scene
from omma.base.poses import Matrices
from omma.scene.world import World
from omma.scene.world_moves import Animations, animations_of


@dataclass(frozen=True, eq=False)
class Past:
    """Where the head, and what was moved, had been before the first pose."""

    poses: Matrices  # (N, 4, 4)
    times_s: NDArray[np.float64]  # (N,)
    transforms: NDArray[np.float64]  # (N, K, 4, 4), of what was moved; (0, K, 4, 4): not told


@dataclass(frozen=True, eq=False)
class MovesTold:
    """What a call was asked for besides instances, transforms and times."""

    attributes: dict[str, Any]
    """Of the data set; of what was not asked for there is none."""
    unseen_group: NDArray[np.int32] | None
    """(P,), which group of things in the attribute ``unseen`` each pose's eye does not see, -1 for
    none; None where all is seen."""
    past: Past | None = None
    """None where the call said nothing of what was before."""

    @classmethod
    def of(
        cls,
        world: World,
        unseen: tuple[Sequence[Sequence[int]], NDArray[np.int32]],
        by_light: bool,
    ) -> MovesTold:
        """Of a call in a world as it is now; ``unseen``: groups of things, and that of each
        pose."""
        told: dict[str, Any] = {}
        if world._last_at:
            ((time_s, at),) = world._last_at
            told["at_time_s"] = time_s
            if at is not None:
                told["at_animation"] = _name_of(world.scene, at)
        groups, of_pose = unseen
        if groups:
            told["unseen"] = json.dumps(groups)
            if by_light:
                told["unseen_by_light"] = 1
        return cls(told, of_pose.copy() if groups else None)

    def with_animation(self, scene: Scene, animation: Animations | None) -> MovesTold:
        """The same with the animation that times were of; None: of all."""
        if animation is None:
            return self
        about = {"animation": _name_of(scene, animation)}
        return replace(self, attributes=self.attributes | about)

    def differs(self, other: MovesTold, name: str) -> bool:
        """Whether another call was asked for something else by the argument of that name."""
        if self.attributes.get(name) != other.attributes.get(name):
            return True
        return name == "unseen" and not np.array_equal(self._groups, other._groups)

    @property
    def _groups(self) -> NDArray[np.int32]:
        return np.empty(0, np.int32) if self.unseen_group is None else self.unseen_group


def _name_of(scene: Scene, animation: Animations) -> str | int:
    """An animation's name, of one without a name of its own its index in ``scene.animations``."""
    index = int(animations_of(scene, animation)[0])
    names = [one.name for one in scene.animations]
    name = names[index] if index < len(names) else ""
    return name if name and names.count(name) == 1 else index
