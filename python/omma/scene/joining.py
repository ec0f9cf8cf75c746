"""Scenes put elsewhere, and several in one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma import _core
from omma._core import (
    Background,
    Error,
    Instance,
    Material,
    Mesh,
    Rig,
    Scene,
    TextureUse,
)
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats

# What the engine's sentences about places have in them (src/model/scene_place.cpp).
_OF_PLACES = ("from the origin of their own coordinates", "are not seen reliably")
# What turns by rounding differ in scale.
_ROUNDING = 1e-9


@checked
def place_scene(scene: Scene, world_from_scene: ArrayLike) -> Scene:
    """The same scene at another pose: instances, cameras, lamps, hit boxes and splats together.

    Its animations move things about that pose.

    A pose with a scale makes a larger scene, or a smaller one. Cameras grow with it, and so the
    half extents of orthographic ones and eyes that are rendered at their poses. So do the ranges of
    lamps and, of materials, thickness and attenuation distance, and what is absorbed per metre gets
    less: by the cube root of what the volume grows by, where the scale differs along the axes. A
    pose that flattens the scene to no volume leaves these as they are. Intensities (cd, lx) stay,
    and the light in a world, with its air, is no part of the scene.

    Args:
        world_from_scene: (4, 4), m, applied after where each of them is already.

    Raises:
        omma.Error: it is no finite transform.
    """
    matrix = array_of(world_from_scene, "world_from_scene", (4, 4))
    if not np.isfinite(matrix).all() or (matrix[3] != (0, 0, 0, 1)).any():
        raise Error("world_from_scene: expected finite numbers, the last row 0, 0, 0, 1")
    scale = scale_of(matrix)
    if scale != 1:
        scene = scene.replace(
            lights=[one.replace(range_m=one.range_m * scale) for one in scene.lights],
            materials=[_scaled(one, scale) for one in scene.materials],
        )
    return scene.replace(
        rig=scene.rig and _core.placed_rig(scene.rig, matrix),
        instances=[
            one.replace(world_from_mesh=matrix @ one.world_from_mesh) for one in scene.instances
        ],
        cameras=[
            one.replace(world_from_camera=matrix @ one.world_from_camera) for one in scene.cameras
        ],
        hit_boxes=[
            one.replace(world_from_mesh=matrix @ one.world_from_mesh) for one in scene.hit_boxes
        ],
        lights=[
            one.replace(world_from_light=matrix @ one.world_from_light) for one in scene.lights
        ],
        splats=[
            one.replace(world_from_splats=matrix @ one.world_from_splats) for one in scene.splats
        ],
    )


def scale_of(matrix: Floats) -> float:
    """By what lengths grow in a (4, 4) transform, on average over its axes; 1 of one that keeps
    volumes, but for rounding, or leaves none."""
    volume = abs(float(np.linalg.det(matrix[:3, :3])))
    scale = float(np.cbrt(volume))
    return 1.0 if volume == 0 or abs(scale - 1) < _ROUNDING else scale


def _scaled(material: Material, scale: float) -> Material:
    """The material of a thing that is so much larger."""
    distance, absorbed = material.attenuation_distance_m, material.absorption_per_m
    if material.thickness_m == 0 and distance is None and absorbed is None:
        return material
    return material.replace(
        thickness_m=material.thickness_m * scale,
        attenuation_distance_m=None if distance is None else distance * scale,
        absorption_per_m=absorbed and absorbed.replace(value=absorbed.value / scale),
    )


def warnings_of_file(scene: Scene) -> list[str]:
    """What there was to warn of a scene's file, without what `_core.with_path` tells anew: what
    places do to it."""
    return [one for one in scene.warnings if not any(words in one for words in _OF_PLACES)]


@checked
def merge_scenes(scenes: Sequence[Scene], *, background: Background | None = None) -> Scene:
    """All that is in several scenes, in one, each thing where it is and under its name.

    Things of the same name may come together (`World.index` then asks for their index); cameras may
    not, as they are chosen by name. Animations come together in the order of the scenes.

    Args:
        scenes: at least one.
        background: None takes that of the first.

    Example:
        >>> ball = omma.scene.sphere(center_m=(0, 2, 0), name="ball")
        >>> both = omma.scene.merge_scenes([omma.scene.box(name="crate"), ball])
        >>> [instance.name for instance in both.instances]
        ['crate', 'ball']

    Raises:
        omma.Error: no scene; cameras of one name in two of them; scenes of different colour rules.
    """
    scenes = list(scenes)
    if not scenes:
        raise Error("scenes: expected at least one, found none")
    _check_together(scenes)
    parts: dict[str, list[Any]] = {
        name: []
        for name in (
            "meshes", "instances", "materials", "textures", "images", "cameras", "hit_boxes",
            "lights", "splats",
        )
    }  # fmt: skip
    nodes = 0
    rig: Rig | None = None
    for scene in scenes:
        # Indices of this scene go on after those of the scenes before.
        before = {name: len(found) for name, found in parts.items()}
        if scene.rig is not None:
            offsets = before["meshes"], before["cameras"], nodes
            rig = _core.joined_rig(Rig() if rig is None else rig, scene.rig, *offsets)
        parts["meshes"] += [_mesh(one, before["materials"]) for one in scene.meshes]
        parts["materials"] += [_material(one, before["textures"]) for one in scene.materials]
        parts["textures"] += [
            one.replace(image=one.image + before["images"]) for one in scene.textures
        ]
        parts["images"] += scene.images
        parts["cameras"] += scene.cameras
        parts["hit_boxes"] += scene.hit_boxes
        parts["lights"] += scene.lights
        parts["splats"] += scene.splats
        instances = scene.instances
        parts["instances"] += [_instance(one, before["meshes"], nodes) for one in instances]
        nodes += 1 + max((one.node for one in instances if one.node is not None), default=-1)
    return Scene(
        **parts,
        background=scenes[0].background if background is None else background,
        color_rule=scenes[0].color_rule,
        rig=rig,
    )


def _check_together(scenes: list[Scene]) -> None:
    first_with: dict[str, int] = {}
    for number, scene in enumerate(scenes):
        if scene.color_rule != scenes[0].color_rule:
            raise Error(
                f"scenes[{number}]: expected the colour rule {scenes[0].color_rule}, as scenes[0] "
                f"has, found {scene.color_rule}"
            )
        for camera in scene.cameras:
            if camera.name and first_with.setdefault(camera.name, number) != number:
                raise Error(
                    f"scenes[{number}]: its camera '{camera.name}' is also in "
                    f"scenes[{first_with[camera.name]}]; leave one out, or give it another name: "
                    "scene.replace(cameras=[...]), camera.replace(name=...)"
                )


def _mesh(mesh: Mesh, materials: int) -> Mesh:
    if mesh.material is None or materials == 0:
        return mesh
    return mesh.replace(material=mesh.material + materials)


def _instance(instance: Instance, meshes: int, nodes: int) -> Instance:
    node = None if instance.node is None else instance.node + nodes
    return instance.replace(mesh=instance.mesh + meshes, node=node)


def _material(material: Material, textures: int) -> Material:
    extra = material.extra_reflectance
    return material.replace(
        base_color_texture=_use(material.base_color_texture, textures),
        emissive_texture=_use(material.emissive_texture, textures),
        metallic_roughness_texture=_use(material.metallic_roughness_texture, textures),
        normal_texture=_use(material.normal_texture, textures),
        specular_texture=_use(material.specular_texture, textures),
        specular_color_texture=_use(material.specular_color_texture, textures),
        transmission_texture=_use(material.transmission_texture, textures),
        diffuse_transmission_factor_texture=_use(
            material.diffuse_transmission_factor_texture, textures
        ),
        diffuse_transmission_texture=_use(material.diffuse_transmission_texture, textures),
        clearcoat_texture=_use(material.clearcoat_texture, textures),
        clearcoat_roughness_texture=_use(material.clearcoat_roughness_texture, textures),
        clearcoat_normal_texture=_use(material.clearcoat_normal_texture, textures),
        extra_reflectance=extra and extra.replace(texture=_use(extra.texture, textures)),
    )


def _use(use: TextureUse | None, textures: int) -> TextureUse | None:
    return None if use is None else use.replace(texture=use.texture + textures)
