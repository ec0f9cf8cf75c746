"""A world kept as a simulation goes on."""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import checked
from omma.base.poses import Matrices
from omma.base.warn import warn_caller
from omma.mujoco.models import checked_data, names_of, shape_names, skin_names, transforms
from omma.mujoco.skins import skin_vertices
from omma.scene.world import World

# Of where a thing is, in sizes of at least 1: as far as single precision rounds it.
_ROUNDED = 2.0**-20


@dataclass
class _Things:
    """Which of a world's things are which of a model's.

    Attributes:
        model: whose.
        geoms: (K,) of the model.
        names: (K), what they are called.
        can_move: (K,), whether the model does not weld them to its world.
        instances: (K,) of the world, the same things.
        moves: (K,), whether it can move, or has been somewhere else.
        world_from_geom: (K, 4, 4), where they are in the world.
        skins: of each skin its index in the model and that of its mesh in the scene.
        sizes: (K, 3), of the geoms at the last look; NaN: not looked at.
        shapes: of the geoms in words, as they are in the world.
    """

    model: Any
    geoms: NDArray[np.int64]
    names: list[str]
    can_move: NDArray[np.bool_]
    instances: NDArray[np.int64]
    moves: NDArray[np.bool_]
    world_from_geom: NDArray[np.float64]
    skins: list[tuple[int, int]]
    sizes: NDArray[np.float64]
    shapes: list[str]


_known: weakref.WeakKeyDictionary[World, _Things] = weakref.WeakKeyDictionary()
# Names of the things of worlds that hold those of one model and no others.
_made: weakref.WeakKeyDictionary[World, frozenset[str]] = weakref.WeakKeyDictionary()
# Of models (name, shape in words) of the geoms that scenes were made of: sizes may change after.
_shown: weakref.WeakKeyDictionary[Any, set[tuple[str, str]]] = weakref.WeakKeyDictionary()


def note_shown(model: Any, geoms: Iterable[tuple[str, str]]) -> None:
    """Keep the names and shapes of geoms that a scene was made of."""
    _shown.setdefault(model, set()).update(geoms)


def note_made(world: World) -> None:
    """Keep that a world holds the things of one model alone."""
    _made[world] = frozenset(instance.name for instance in world.instances)


@checked
def update(world: World, data: Any) -> None:
    """Put the geoms and skins of a model to where they are now.

    Things of the world are found by their names, so it may hold other things beside the model's,
    and need not hold all of these. What the model welds to its world stays in what was built
    once, unless it is found elsewhere. The first call moves everything that can move, which
    builds the world anew (docs/motion-and-time.md).

    Args:
        world: of `world_from_model`, or any world of a scene of the same model.
        data: `mujoco.MjData` with positions computed, as `mujoco.mj_forward` does; `mj_step` leaves
            those from before its step.

    Raises:
        omma.Error: data of a model that the world was not made of, or without finite positions; or
            what `World.set_transforms` raises.

    Warns:
        UserWarning: sizes of geoms that have changed in the model: shapes stay as they were.
    """
    things = _things_of(world, data)
    now = transforms(data.geom_xpos[things.geoms], data.geom_xmat[things.geoms])
    things.moves |= np.abs(now - things.world_from_geom).max(axis=(1, 2)) > 0
    if things.moves.any():
        world.set_transforms(things.instances[things.moves], now[things.moves])
        things.world_from_geom[things.moves] = now[things.moves]
    for skin, mesh in things.skins:
        positions, normals = skin_vertices(data, skin)
        world.set_vertices(mesh, positions, normals)


@checked
def moving_things(world: World, data: Any) -> tuple[list[str], Matrices]:
    """Names (K) of a world's things that a model can move, and where they are, (K, 4, 4), m.

    What `update` would set, for renders and loops that take ``instances`` or ``things`` and
    ``transforms``: the world itself stays as it is. The names are the same for all data of a model.

    Args:
        world: as of `update`.
        data: as of `update`.

    Example:
        >>> import mujoco
        >>> model = mujoco.MjModel.from_xml_string(
        ...     '<mujoco><worldbody><body><freejoint/><geom name="ball" size="0.1"/></body>'
        ...     "</worldbody></mujoco>"
        ... )
        >>> data = mujoco.MjData(model)
        >>> mujoco.mj_forward(model, data)
        >>> names, transforms = omma.mujoco.moving_things(
        ...     omma.mujoco.world_from_model(model), data
        ... )
        >>> names, transforms.shape
        (['ball'], (1, 4, 4))

    Raises:
        omma.Error: as `update`; skins, which bend, as no transform can say; a geom that the model
            welds to its world and that is elsewhere than in ``world``.

    Warns:
        UserWarning: as `update`.
    """
    things = _things_of(world, data)
    if things.skins:
        skin = skin_names(things.model)[things.skins[0][0]]
        raise Error(
            f"world: expected one without skins, which bend, found {skin!r}; omma.mujoco.update "
            "bends them, in a world that one environment has for itself"
        )
    now = transforms(data.geom_xpos[things.geoms], data.geom_xmat[things.geoms])
    apart = np.abs(now - things.world_from_geom)
    is_off = (apart > _ROUNDED * np.maximum(1, np.abs(now))).any(axis=(1, 2)) & ~things.can_move
    if is_off.any():
        name = things.names[np.argmax(is_off)]
        raise Error(
            f"data: expected what the model welds to its world where it is in the world, found "
            f"geom {name!r} elsewhere"
        )
    return list(compress(things.names, things.can_move)), now[things.can_move]


def _things_of(world: World, data: Any) -> _Things:
    """Which of a world's things are those of data; tells what is wrong with them."""
    checked_data(data)
    things = _known.get(world)
    if things is None or things.model is not data.model:
        things = _found(world, data.model)
        _known[world] = things
    _tell_sizes(things, data.model)
    return things


def _tell_sizes(things: _Things, model: Any) -> None:
    """Warns of sizes that are neither those of the last look nor the world's; each change once."""
    sizes = np.asarray(model.geom_size)[things.geoms]
    changed = np.flatnonzero((sizes != things.sizes).any(axis=1))
    if not len(changed):
        return
    things.sizes = sizes
    shapes = shape_names(model)
    other = [k for k in changed if shapes[things.geoms[k]] != things.shapes[k]]
    if not other:
        return
    name = things.names[other[0]]
    warn_caller(
        f"data: the size of geom {name!r} has changed in the model, which the world does not "
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
    names, shapes = names_of(model, "geom", model.ngeom), shape_names(model)
    shown = _shown.get(model, set())
    for geom, (name, shape) in enumerate(zip(names, shapes, strict=True)):
        there = index_of.get(name, [])
        if len(there) > 1:
            raise Error(f"world: expected one thing named {name!r}, found {len(there)}")
        if there and mesh_of[name] != shape and (name, mesh_of[name]) not in shown:
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
    without = sorted(_made_names(world) - {*names, *skin_names(model)})
    if without:
        raise Error(
            "data: expected those of the model that the world was made of, found another's: none "
            f"of its geoms is called {without[0]!r}, as a thing of the world is"
        )
    called = [names[geom] for geom in geoms]
    there_now = [mesh_of[name] for name in called]
    kept = np.array(geoms, np.int64)
    sizes = np.array(model.geom_size)[kept]
    sizes[[shapes[geom] != one for geom, one in zip(geoms, there_now, strict=True)]] = np.nan
    can_move = _can_move(model)[kept]
    return _Things(
        model,
        kept,
        called,
        can_move,
        np.array(found, np.int64),
        can_move.copy(),
        np.array([instances[index].world_from_node for index in found]).reshape(-1, 4, 4),
        skins,
        sizes,
        there_now,
    )


def _made_names(world: World) -> frozenset[str]:
    """Names that a model has that a world was made of; none where it may hold other things."""
    while world._base is not None:  # the same in another light
        world = world._base
    return _made.get(world, frozenset())


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
