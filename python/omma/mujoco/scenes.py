"""Scenes and worlds of models: geoms and skins where they are, as they look, with cameras, lamps
and the sky.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from omma._core import Background, Error, Instance, Mesh, Scene
from omma.base.arguments import checked, one_of, positive
from omma.base.warn import warn_caller
from omma.mujoco.cube_maps import panorama
from omma.mujoco.lamps import lamps_of
from omma.mujoco.materials import SKYBOX, Look, light_of, texture_pixels
from omma.mujoco.models import (
    KINDS,
    MESH,
    SHAPES_IN_MODEL,
    checked_data,
    checked_model,
    data_at_start,
    names_of,
    shape_names,
    skin_names,
    transforms,
)
from omma.mujoco.moving import note_made, note_shown
from omma.mujoco.poses import cameras
from omma.mujoco.shapes import Shape, drawn_size, shape_of
from omma.mujoco.skins import skin_coordinates, skin_triangles, skin_vertices
from omma.scene.world import World

Colors = Literal["srgb", "linear"]


@checked
def scene_from_model(
    model: Any,
    data: Any = None,
    *,
    groups: Sequence[int] = (0, 1, 2),
    hidden: Sequence[str] = (),
    colors: Colors = "srgb",
    lux: float = 10_000.0,
) -> Scene:
    """The scene of a MuJoCo model: its geoms and skins, each an instance of its own name.

    The world's frame is the model's: +Z is up, lengths are the model's. Unnamed geoms are called
    "geom 12", by their index, skins "skin NAME". Cameras and lights are where they are now, in the
    scene for good. docs/mujoco.md says what becomes of colours, textures and lights.

    Args:
        model: `mujoco.MjModel`.
        data: `mujoco.MjData` of it, where things are. None: in the model's reference configuration.
        groups: of geoms and skins that are seen; MuJoCo's own default is the first three.
        hidden: names of geoms that are not seen, as those of an animal's own head.
        colors: what the model's colours and textures are: "srgb", as on a screen, or "linear",
            light itself, so that a response of 0.5 is a colour of 0.5.
        lux: what a light of diffuse colour 1 stands for, where the world is lit.

    Raises:
        omma.Error: not a model, data of another one, geoms or textures of kinds or sizes that are
            not known, or a name that no geom has.

    Warns:
        UserWarning: the model has flexes, which are left out.
    """
    checked_model(model)
    data = data_at_start(model) if data is None else checked_data(data, model)
    linear = one_of(colors, ("srgb", "linear"), "colors") == "linear"
    light = positive(lux, "lux")
    if isinstance(groups, str) or not hasattr(groups, "__iter__"):
        raise Error(f"groups: expected numbers such as (0, 1, 2), found {groups!r:.40}")
    if model.nflex:
        warn_caller(f"model: its flexes, {model.nflex}, are left out", UserWarning)
    look = Look(model, linear)
    meshes: list[Mesh] = []
    instances: list[Instance] = []
    world_from_geom = transforms(data.geom_xpos, data.geom_xmat)
    meshes_of: dict[tuple[Any, ...], range] = {}  # geoms that look the same share their meshes
    names, shapes = names_of(model, "geom", model.ngeom), shape_names(model)
    seen = _seen_geoms(model, look, names, groups, hidden)
    note_shown(model, [(names[geom], shapes[geom]) for geom in seen])
    for geom in seen:
        own = model.geom_rgba[geom].tobytes(), model.geom_size[geom].tobytes()
        key = shapes[geom], int(model.geom_matid[geom]), *own
        if key not in meshes_of:
            own_meshes = look.meshes(
                shapes[geom],
                shape_of(model, geom),
                int(model.geom_matid[geom]),
                model.geom_rgba[geom],
                int(model.geom_type[geom]),
                drawn_size(model, geom),
            )
            meshes_of[key] = range(len(meshes), len(meshes) + len(own_meshes))
            meshes += own_meshes
        instances += [
            Instance(mesh, world_from_geom[geom], name=names[geom], node=geom)
            for mesh in meshes_of[key]
        ]
    for skin, name in enumerate(skin_names(model)):
        if int(model.skin_group[skin]) in groups and model.skin_rgba[skin][3] > 0:
            meshes.append(_skin(model, data, look, skin, name))
            instances.append(Instance(len(meshes) - 1, name=name, node=model.ngeom + skin))
    return Scene(
        meshes=meshes,
        instances=instances,
        materials=look.materials,
        textures=look.textures,
        images=look.images,
        cameras=cameras(model, data),
        lights=lamps_of(model, data, np.asarray if linear else light_of, light),
        background=_sky(model, linear),
    )


def world_from_model(
    model: Any,
    data: Any = None,
    *,
    groups: Sequence[int] = (0, 1, 2),
    hidden: Sequence[str] = (),
    colors: Colors = "srgb",
    lux: float = 10_000.0,
    **options: Any,
) -> World:
    """A world of a MuJoCo model, which `update` keeps as the simulation goes on.

    Args:
        model, data, groups, hidden, colors, lux: as of `scene_from_model`.
        options: as of `omma.World`: ``light``, ``background``, ``threads``, ``backend``, ...

    Raises:
        omma.Error: as `scene_from_model` and `omma.World` do.
    """
    scene = scene_from_model(model, data, groups=groups, hidden=hidden, colors=colors, lux=lux)
    world = World(scene, **options)
    note_made(world)
    return world


def _seen_geoms(
    model: Any, look: Look, names: list[str], groups: Sequence[int], hidden: Sequence[str]
) -> list[int]:
    """Geoms of these groups that are neither hidden nor wholly transparent."""
    if isinstance(hidden, str):
        raise Error(f"hidden: expected a list of names, found the text {hidden!r}")
    left_out = {one_of(name, names, "hidden") for name in hidden}
    found = []
    for geom, name in enumerate(names):
        kind = int(model.geom_type[geom])
        if not 0 <= kind < len(KINDS):
            known = ", ".join(KINDS)
            raise Error(f"model: geom {name!r}: expected a kind of {known}, found type {kind}")
        if kind in SHAPES_IN_MODEL and not 0 <= int(model.geom_dataid[geom]) < getattr(
            model, SHAPES_IN_MODEL[kind][1]
        ):
            raise Error(f"model: geom {name!r}: expected a {KINDS[kind]} of the model, found none")
        if int(model.geom_group[geom]) not in groups or name in left_out:
            continue
        if look.rgba(int(model.geom_matid[geom]), model.geom_rgba[geom])[3] > 0:
            found.append(geom)
    return found


def _skin(model: Any, data: Any, look: Look, skin: int, name: str) -> Mesh:
    positions, normals = skin_vertices(data, skin)
    coordinates = skin_coordinates(model, skin)
    textured = coordinates is not None
    triangles = skin_triangles(model, skin)
    shape = Shape(positions, triangles, normals, positions, coordinates, textured)
    material = int(model.skin_matid[skin])
    size = np.ones(3)
    rgba = model.skin_rgba[skin]
    return look.meshes(name, shape, material, rgba, MESH, size, textured=textured)[0]


def _sky(model: Any, linear: bool) -> Background:
    """The model's first skybox; black without."""
    for texture in range(model.ntex):
        if int(model.tex_type[texture]) == SKYBOX:
            return Background.image(panorama(texture_pixels(model, texture, linear)))
    return Background.constant((0.0, 0.0, 0.0))
