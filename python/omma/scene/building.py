"""Worlds that are made while somebody watches: each stage of the work by its name."""

from __future__ import annotations

from typing import Any

from omma import _core
from omma._core import Scene
from omma.base.progress import Progress, Stage
from omma.scene.baking import BakeCost
from omma.scene.world import World

# What tools that report stages call those before rendering.
READING, BUILDING = "Reading the scene", "Building the acceleration structure"
BAKING = "Baking light"
COMPILING = "Compiling kernels for the card, once"

# Bakes that take longer say beforehand how long.
_LONG_S = 10.0


def stage_of(tell: Stage, stage: str) -> Progress:
    """Tells of a stage, and of the card's kernels while they are compiled in it."""

    def told(done: float) -> None:
        if _core.compiling_kernels():
            tell(COMPILING, None)
        else:
            tell(stage, done)

    return told


def build_world(scene: Scene, tell: Stage, **arguments: Any) -> World:
    """A world of the arguments of `World`; building and baking are told as stages of their own."""
    if arguments.get("lighting") != "baked":
        return World(scene, progress=stage_of(tell, BUILDING), **arguments)
    of_light = ("light", "depth", "polarized", "ultraviolet")
    lit = {name: arguments[name] for name in of_light if name in arguments}
    baked = {name: arguments.pop(name) for name in ("lighting", "sun", "bake") if name in arguments}
    world = World(scene, progress=stage_of(tell, BUILDING), **arguments)
    tell(BAKING, None)
    return world.with_light(**lit, **baked, progress=Baking(tell))


class Baking:
    """Tells of baking, with what it costs where the cache does not have it.

    Args:
        tell: who is told.
        stage: what it is called.
    """

    def __init__(self, tell: Stage, stage: str = BAKING) -> None:
        self._tell, self._called, self._stage = tell, stage, stage

    def begins(self, cost: BakeCost) -> None:
        """Called before it is baked."""
        self._stage = f"{self._called} ({cost.cells:,} cells, {cost.bytes / 1e6:,.0f} MB)"
        if cost.seconds > _LONG_S:
            self._stage = f"{self._called} ({cost})"
        self._tell(self._stage, None)

    def __call__(self, done: float) -> None:
        stage_of(self._tell, self._stage)(done)
