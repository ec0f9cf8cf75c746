"""Whether a world shows a stimulus: what its things look like is in the world, and two stimuli of a
kind call them by the same names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol
from weakref import WeakKeyDictionary

import numpy as np

from omma._core import Background, Error, Instance, Scene
from omma.scene.world import World

# Of the largest number: stimuli of other versions, and files, may round.
_ROUNDING = 1e-5


class Shown(Protocol):
    """What is asked of a stimulus."""

    name: str
    background: float

    @property
    def names(self) -> list[str]: ...
    def _scene(self) -> Scene: ...


# Of worlds what they are known to show, by its name.
_known: WeakKeyDictionary[World, dict[str, Shown]] = WeakKeyDictionary()


def is_shown(stimulus: Shown, world: World) -> None:
    """Say that a world has been made of a stimulus."""
    _known.setdefault(world, {})[stimulus.name] = stimulus


def check_shown(stimulus: Shown, world: World) -> None:
    """omma.Error where a world's scene has things of the stimulus' names that are another's.

    What was changed in the world itself, by `World.set_image` and others, does not count.
    """
    if _known.get(world, {}).get(stimulus.name) == stimulus:
        return
    scene, own = world.scene, stimulus._scene()
    found, expected = _things(scene, stimulus.names), _things(own, stimulus.names)
    for name, ours in expected.items():
        for here, there in zip(_looks(own, ours), _looks(scene, found[name]), strict=False):
            for part, value in here.items():
                if not _alike(value, there[part]):
                    raise _another(stimulus, f"{part} of {name}")
        if len(ours) != len(found[name]):
            raise _another(stimulus, f"number of meshes of {name}")
    # Frames and stars are numbered: a world with one more is of more of them.
    following = f"{stimulus.name} {len(stimulus.names)}"
    others = [one.name for one in scene.instances if one.name not in expected]
    if stimulus.names != [stimulus.name] and following in others:
        raise _another(stimulus, f"number of things, as there is {following}")
    alone = not others and world.light is None and world.background == scene.background
    if alone and not _alike_background(scene.background, stimulus.background):
        raise _another(stimulus, "background")
    is_shown(stimulus, world)


def _another(stimulus: Shown, what: str) -> Error:
    return Error(
        f"world: expected one that shows {type(stimulus).__name__} {stimulus.name!r}, found "
        f"another {what}: its things may be those of another stimulus. Take a renderer of this "
        "one's world(), as pictures and shapes are part of the world; things that were changed on "
        "purpose are moved by render(poses, instances=stimulus.names, "
        "transforms=stimulus.transforms(times_s))"
    )


def _things(scene: Scene, names: list[str]) -> dict[str, list[Instance]]:
    """The instances of each of these names."""
    things: dict[str, list[Instance]] = {name: [] for name in names}
    for one in scene.instances:
        if one.name in things:
            things[one.name].append(one)
    return things


def _looks(scene: Scene, things: list[Instance]) -> Iterator[dict[str, Any]]:
    """Of each instance what is seen of it, by what it is called."""
    meshes, materials = scene.meshes, scene.materials
    textures, images = scene.textures, scene.images
    for thing in things:
        mesh = meshes[thing.mesh]
        material = None if mesh.material is None else materials[mesh.material]
        use = None if material is None else material.base_color_texture
        image = None if use is None else textures[use.texture].image
        yield {
            "shape": mesh.positions_m,
            "triangles": mesh.triangles,
            "color": (1.0, 1.0, 1.0, 1.0) if material is None else material.base_color,
            "picture": None if image is None else images[image].pixels,
            "place of the picture": mesh.texture_coordinates,
        }


def _alike(one: Any, other: Any) -> bool:
    if one is None or other is None:
        return one is None and other is None
    first, second = np.asarray(one), np.asarray(other)
    if first.shape != second.shape or first.dtype.kind != second.dtype.kind:
        return False
    most = np.abs(first).max(initial=0)
    return bool(np.all(np.abs(first - second.astype(first.dtype)) <= _ROUNDING * most))


def _alike_background(found: Background, radiance: float) -> bool:
    return found.type == "constant" and _alike([radiance] * 3, list(found.color))
