"""Scenes that have animations, rendered from files to files: by the times of a path, or at rest."""

from __future__ import annotations

import numpy as np

from omma._core import Error, Scene
from omma.base.arrays import Floats
from omma.scene.world import World


def animation_words(scene: Scene) -> list[str]:
    """Each animation of a scene in words: its name and when its last key is."""
    return [f"{one.name or '(no name)'}, {one.duration_s:.4g} s" for one in scene.animations]


def told_at_rest(scene: Scene, why: str) -> list[str]:
    """That a scene with animations is rendered at rest, in a line; none of one without."""
    if not scene.animations:
        return []
    names = "; ".join(animation_words(scene))
    return [f"{scene.path}: is rendered at rest, without its animations ({names}): {why}"]


def times_that_move(world: World, times_s: Floats | None, warnings: list[str]) -> Floats | None:
    """The times of poses, s, at which animations move the world; None: it stays at rest, which
    warnings say where the scene has animations."""
    scene = world.scene
    if not scene.animations:
        return None
    if times_s is None:
        warnings += told_at_rest(scene, "a path with times, t_s, moves what they move")
        return None
    try:
        world._engine.animated_at(0.0, np.empty(0, np.int32))
    except Error as problem:  # several move the same, and one would have to be named
        warnings += told_at_rest(scene, f"{problem}; Renderer.render takes animation=")
        return None
    return times_s
