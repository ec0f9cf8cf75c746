"""A world kept as a simulation goes on."""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import checked
from omma.base.warn import warn_caller
from omma.mujoco.models import checked_data, names_of, shape_names, skin_names, transforms
from omma.mujoco.skins import skin_vertices
from omma.scene.world import World


@dataclass
class _Things:
    """Which of a world's things are which of a model's.

    Attributes:
        model: whose.
        geoms: (K,) of the model.
        instances: (K,) of the world, the same things.
        moves: (K,), whether it can move, or has been somewhere else.
        world_from_geom: (K, 4, 4), where what does not move is.
        skins: of each skin its index in the model and that of its mesh in the scene.
        sizes: (K, 3), of the geoms as they are in the world.
    """

    model: Any
    geoms: NDArray[np.int64]
    instances: NDArray[np.int64]
    moves: NDArray[np.bool_]
    world_from_geom: NDArray[np.float64]
    skins: list[tuple[int, int]]
    sizes: NDArray[np.float64]


_known: weakref.WeakKeyDictionary[World, _Things] = weakref.WeakKeyDictionary()


@checked
def update(world: World, data: Any) -> None:
    """Put the geoms and skins of a model to where they are now.

    Things of the world are found by their names, so it may hold other things beside the model's,
    and need not hold all of these. What the model welds to its world stays in what was built
    once, unless it is found elsewhere. The first call moves everything that can move, which
    builds the world anew (docs/motion-and-time.md).

    Args:
        world: of `world_from_model`, or any world of a scene of the same model.
        data: `mujoco.MjData` with positions computed, as `mujoco.mj_step` leaves them.

    Raises:
        omma.Error: data of a model that the world was not made of, or without finite positions; or
            what `World.set_transforms` raises.

    Warns:
        UserWarning: sizes of geoms that have changed in the model: shapes stay as they were.
    """
    checked_data(data)
    things = _known.get(world)
    if things is None or things.model is not data.model:
        things = _found(world, data.model)
        _known[world] = things
    _tell_sizes(things, data.model)
    now = transforms(data.geom_xpos[things.geoms], data.geom_xmat[things.geoms])
    things.moves |= np.abs(now - things.world_from_geom).max(axis=(1, 2)) > 0
    if things.moves.any():
        world.set_transforms(things.instances[things.moves], now[things.moves])
    for skin, mesh in things.skins:
        positions, normals = skin_vertices(data, skin)
        world.set_vertices(mesh, positions, normals)


def _tell_sizes(things: _Things, model: Any) -> None:
    """Warns of sizes that are not those of the last look; each change once."""
    sizes = np.asarray(model.geom_size)[things.geoms]
    changed = np.flatnonzero((sizes != things.sizes).any(axis=1))
    if not len(changed):
        return
    things.sizes = sizes
    name = names_of(model, "geom", model.ngeom)[things.geoms[changed[0]]]
    warn_caller(
        f"update: the size of geom {name!r} has changed in the model, which the world does not "
        "follow; omma.mujoco.world_from_model makes another with it",
        UserWarning,
    )


def _found(world: World, model: Any) -> _Things:
    """The model's things in the world.

    Raises:
        omma.Error: none is there, or one has another shape.
    """
    instances = world.instances
    index_of: dict[str, list[int]] = {}
    for index, instance in enumerate(instances):
        index_of.setdefault(instance.name, []).append(index)
    scene = world.scene
    mesh_names = [mesh.name for mesh in scene.meshes]
    mesh_of = {instance.name: mesh_names[instance.mesh] for instance in scene.instances}
    geoms, found = [], []
    for geom, (name, shape) in enumerate(zip(names_of(model, "geom", model.ngeom),
                                             shape_names(model))):  # fmt: skip
        there = index_of.get(name, [])
        if len(there) > 1:
            raise Error(f"world: expected one thing named {name!r}, found {len(there)}")
        if there and mesh_of[name] != shape:
            raise Error(
                "data: expected those of the model that the world was made of, found another's: "
                f"geom {name!r} is a {shape}, in the world it is a {mesh_of[name]}"
            )
        if there:
            geoms.append(geom)
            found.append(there[0])
    skins = [
        (skin, mesh_names.index(name))
        for skin, name in enumerate(skin_names(model)) if name in mesh_names
    ]  # fmt: skip
    if not geoms and not skins and (model.ngeom or model.nskin):
        raise Error(
            "data: expected those of the model that the world was made of, found another's: none "
            "of its geoms and skins is in the world"
        )
    _check_skins(world, model, skins)
    kept = np.array(geoms, np.int64)
    return _Things(
        model,
        kept,
        np.array(found, np.int64),
        _can_move(model)[kept],
        np.array([instances[index].world_from_node for index in found]).reshape(-1, 4, 4),
        skins,
        np.asarray(model.geom_size)[kept],
    )


def _check_skins(world: World, model: Any, skins: list[tuple[int, int]]) -> None:
    for skin, mesh in skins:
        ours, theirs = len(world.scene.meshes[mesh].positions_m), int(model.skin_vertnum[skin])
        if ours != theirs:
            raise Error(
                "data: expected those of the model that the world was made of, found another's: "
                f"{skin_names(model)[skin]!r} has {theirs} vertices, in the world {ours}"
            )


def _can_move(model: Any) -> NDArray[np.bool_]:
    """Which geoms are not welded to the world; what follows a mocap body counts as not welded."""
    body = np.asarray(model.geom_bodyid)
    welded = np.asarray(model.body_weldid)[body] == 0
    mocap = np.asarray(model.body_mocapid)[np.asarray(model.body_rootid)[body]] >= 0
    return np.asarray(~welded | mocap)
