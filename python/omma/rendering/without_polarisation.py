"""Polarised light that is followed as if it were not, before receptors that could tell: told once a
session."""

from __future__ import annotations

import numpy as np

from omma.base.warn import warn_caller
from omma.light.lights import Light
from omma.scene.world import World

# What has been told.
_told: list[str] = []
_BY_RENDERING = (
    "the world is not: they answer as to unpolarised light. omma.World(..., polarized=True) "
    "follows polarisation; among the words of a light it is polarized=True (docs/receptors.md)"
)
_BY_DETECTION = (
    "omma.detect follows no polarisation: they answer as to unpolarised light (docs/colours.md)"
)


def tell_without_polarisation(world: World, sensitivity: float) -> None:
    """Warns where receptors, of which that is the largest polarisation sensitivity, tell directions
    of polarisation, the light has some, and the world does not follow it."""
    if not world.polarized:
        _tell(world.light, sensitivity, _BY_RENDERING)


def tell_detection_without_polarisation(light: Light, sensitivity: float) -> None:
    """The same of `omma.detect`, which never follows it."""
    _tell(light, sensitivity, _BY_DETECTION)


def _tell(light: Light | None, sensitivity: float, but: str) -> None:
    if sensitivity <= 1 or but in _told or light is None or not _is_polarised(light):
        return
    warn_caller(
        f"receptors have a polarisation sensitivity (PS) of up to {sensitivity:g}, and the light "
        f"is polarised, but {but}",
        UserWarning,
    )
    # Where warnings are errors it is not told before somebody lets it pass.
    _told.append(but)


def _is_polarised(light: Light) -> bool:
    sky = light.sky
    return sky is not None and sky.shape[3] > 1 and bool(np.any(sky[:, :, :, 1:]))
