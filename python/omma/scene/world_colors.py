"""Methods of `omma.World` that change its pictures and colours while its shapes stay."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Image, Scene
from omma.base.arguments import array_of, checked, whole
from omma.base.methods import method_of
from omma.base.pixels import check_picture
from omma.scene.world_changes import Changes

Colour = tuple[NDArray[np.float64], NDArray[np.float64]]


class Colors:
    """What a world was given instead of its scene's pictures and colours."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._images: dict[int, Image] = {}
        self._colors: dict[int, Colour] = {}

    def set_image(self, engine: _core.World, image: int | str, picture: Any) -> None:
        """As of `World.set_image`."""
        index = index_of(image, "image", [one.name for one in self._scene.images])
        given = picture if isinstance(picture, Image) else Image(picture)
        check_picture(given.pixels, "picture")
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
        index = index_of(material, "material", [one.name for one in materials])
        own = materials[index]
        before = self._colors.get(index, (np.array(own.base_color[:3]), np.array(own.emissive)))
        colour = (
            before[0] if base_color is None else array_of(base_color, "base_color", (3,)),
            before[1] if emissive is None else array_of(emissive, "emissive", (3,)),
        )
        engine.set_color(index, *(tuple(map(float, one)) for one in colour))
        self._colors[index] = colour

    @contextmanager
    def kept(self, engine: _core.World) -> Iterator[None]:
        """Colours that are set inside are undone at the end."""
        before = self._colors.copy()
        try:
            yield
        finally:
            for index, own in enumerate(self._scene.materials):
                if index in self._colors:
                    colour = before.get(index, (np.array(own.base_color[:3]), own.emissive))
                    engine.set_color(index, *(tuple(map(float, one)) for one in colour))
            self._colors.clear()
            self._colors.update(before)

    def parts(self) -> tuple[dict[int, Image], dict[int, Colour]]:
        """To give to another world of the same scene, as when one is unpickled."""
        return self._images, self._colors


class Coloured(Protocol):
    """What changes of colour need of `omma.World`."""

    _engine: _core.World
    _colors: Colors
    _changes: Changes


_world_method = method_of("omma.scene.world", "World")


@checked
@_world_method
def set_image(self: Coloured, image: int | str, picture: Image | ArrayLike) -> None:
    """Show another picture where an image of the scene is seen, as on a screen.

    For all renderers of this world, whose scene keeps its own. Only in worlds that were never
    lit: light goes by the colours that it was made for.

    Args:
        image: which, an index in ``scene.images`` or the name of one.
        picture: of the same size: an image, or (height, width, 3 or 4), where uint8 is sRGB and
            float linear.

    Raises:
        omma.Error: no such image, another size, negative numbers, an image whose alpha cuts out or
            blends, a world that was lit, or something is being rendered.

    Warns:
        UserWarning: floats that are whole numbers up to 255, as of a picture in 8 bits.
    """
    self._colors.set_image(self._engine, image, picture)
    self._changes.note()


@checked
@_world_method
def set_color(
    self: Coloured,
    material: int | str,
    base_color: ArrayLike | None = None,
    *,
    emissive: ArrayLike | None = None,
) -> None:
    """Give a material another colour or light of its own, as of a lamp that flickers.

    For all renderers of this world, whose scene keeps its own. Only in worlds that were never
    lit.

    Args:
        material: which, an index in ``scene.materials`` or the name of one.
        base_color: linear RGB, by which the material's texture is multiplied. None: as it is.
        emissive: linear RGB that it adds; nothing where the material is unlit
            (KHR_materials_unlit). None: as it is.

    Raises:
        omma.Error: no such material, a number below 0 or not finite, a world that was lit, or
            something is being rendered.
    """
    self._colors.set_color(self._engine, material, base_color, emissive)
    self._changes.note()


def index_of(given: int | str, what: str, names: Sequence[str]) -> int:
    """The index that is given, or that of the one thing that is so called."""
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
