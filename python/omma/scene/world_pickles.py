"""A world as what it is made of, from which it is made again."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from omma.base.arrays import Floats
from omma.base.values import check_format
from omma.scene.lighting import Lighting

# Raised where what is pickled changes.
_FORMAT = 7


def parts_of(world: Any) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """What ``World.__reduce__`` returns."""
    base, lighting = world._base, world._lighting
    if base is not None:
        # What moves in one moves in both: so also where both are unpickled together.
        if lighting is not None and world._background is None:
            return _lit_again, (base, lighting, world._places_when_baked)
        return type(world).with_background, (base, world._background)
    moved = sorted(world._moved)
    instances = world.instances if moved else []
    engine = world._engine
    state = {
        "format": _FORMAT,
        "arguments": {
            **world._asked,
            "scene": world.scene,
            "background": world._background,
            "band_from_rgb": world.band_from_rgb,
            **({} if lighting is None else vars(lighting)),
        },
        "moved": moved,
        "world_from_node": [instances[index].world_from_node for index in moved],
        "shapes": [
            (mesh, engine.positions(mesh), engine.normals(mesh)) for mesh in engine.reshaped
        ],
        "colors": world._colors.parts(),
        "last_at": world._last_at,
    }
    return _made_again, (type(world), state)


def _lit_again(base: Any, lighting: Lighting, places_when_baked: dict[int, Floats]) -> Any:
    """The same world in a light, which was baked while things were elsewhere perhaps."""
    if lighting.bake is None or not base._moved:
        return base.with_light(**vars(lighting))
    now, instances = base._moved.keys(), base.instances
    then = [places_when_baked.get(k, before) for k, before in base._moved.items()]
    base.set_transforms(list(now), np.stack(then))
    lit = base.with_light(**vars(lighting))
    base.set_transforms(list(now), np.stack([instances[k].world_from_node for k in now]))
    return lit


def _made_again(kind: Callable[..., Any], state: dict[str, Any]) -> Any:
    check_format(state["format"], _FORMAT, "World")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they were given when the world was made
        world = kind(**state["arguments"])
    if state["moved"]:
        world.set_transforms(state["moved"], np.stack(state["world_from_node"]))
    for mesh, positions, normals in state["shapes"]:
        world.set_vertices(mesh, positions, normals if len(normals) else None)
    world._last_at[:] = state["last_at"]
    images, colors = state["colors"]
    for image, picture in images.items():
        world.set_image(image, picture)
    for material, (base_color, emissive) in colors.items():
        world.set_color(material, base_color, emissive=emissive)
    return world
