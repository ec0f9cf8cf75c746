"""Polarised light that is followed as if it were not, before receptors that could tell: told once a
session."""

from __future__ import annotations

import numpy as np

from omma.base.warn import warn_caller
from omma.light.lights import Light
from omma.scene.world import World

_told: list[str] = []


def tell_without_polarisation(world: World, sensitivity: float) -> None:
    """Warns where receptors, of which that is the largest polarisation sensitivity, tell directions
    of polarisation, the light has some, and the world does not follow it."""
    light = world.light
    if sensitivity <= 1 or _told or light is None or world.polarized or not _is_polarised(light):
        return
    sentence = (
        f"receptors have a polarisation sensitivity (PS) of up to {sensitivity:g}, and the light "
        "is polarised, but the world is not: they answer as to unpolarised light. "
        "omma.World(..., polarized=True) follows polarisation; among the words of a light it is "
        "polarized=True (docs/receptors.md)"
    )
    warn_caller(sentence, UserWarning)
    # Where warnings are errors it is not told before somebody lets it pass.
    _told.append(sentence)


def _is_polarised(light: Light) -> bool:
    sky = light.sky
    return sky is not None and sky.shape[3] > 1 and bool(np.any(sky[:, :, :, 1:]))
