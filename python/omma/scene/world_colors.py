"""Pictures and colours of a world that change while its shapes stay: checked, for the engine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Image, Scene
from omma.base.arguments import array_of, whole

Colour = tuple[NDArray[np.float64], NDArray[np.float64]]


class Colors:
    """What a world was given instead of its scene's pictures and colours."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._images: dict[int, Image] = {}
        self._colors: dict[int, Colour] = {}

    def set_image(self, engine: _core.World, image: int | str, picture: Any) -> None:
        """As of `World.set_image`."""
        index = _index(image, "image", [one.name for one in self._scene.images])
        given = picture if isinstance(picture, Image) else Image(picture)
        engine.set_image(index, given)
        self._images[index] = given

    def set_color(
        self,
        engine: _core.World,
        material: int | str,
        base_color: ArrayLike | None,
        emissive: ArrayLike | None,
    ) -> None:
        """As of `World.set_color`."""
        materials = self._scene.materials
        index = _index(material, "material", [one.name for one in materials])
        own = materials[index]
        before = self._colors.get(index, (np.array(own.base_color[:3]), np.array(own.emissive)))
        colour = (
            before[0] if base_color is None else array_of(base_color, "base_color", (3,)),
            before[1] if emissive is None else array_of(emissive, "emissive", (3,)),
        )
        engine.set_color(index, *(tuple(map(float, one)) for one in colour))
        self._colors[index] = colour

    def parts(self) -> tuple[dict[int, Image], dict[int, Colour]]:
        """To give to another world of the same scene, as when one is unpickled."""
        return self._images, self._colors


def _index(given: int | str, what: str, names: Sequence[str]) -> int:
    if not names:
        raise Error(f"{what}: expected a scene that has some, found one with none")
    if not isinstance(given, str):
        return whole(given, what, 0, max(len(names) - 1, 0))
    found = [k for k, name in enumerate(names) if name == given]
    if len(found) != 1:
        there = "nothing" if not found else f"{len(found)} ({', '.join(map(str, found))})"
        known = ", ".join(repr(name) for name in dict.fromkeys(names) if name)
        raise Error(f"{what}: expected one called {given!r}, found {there}; there are {known:.200}")
    return found[0]
