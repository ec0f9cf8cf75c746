"""Scenes from trimesh, and with it from OBJ, PLY and STL files."""

from __future__ import annotations

import os
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image, Instance, Material, Mesh, Scene
from omma.base.arguments import checked, one_of
from omma.base.files import metres_per_unit

# What turns +Z up into +Y up.
_Y_FROM_Z = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


@checked
def from_trimesh(mesh: Any, *, unit: str | float = "m", up: str = "y") -> Scene:
    """A scene from a `trimesh.Trimesh` or a `trimesh.Scene`, whose meshes stay shared and whose
    nodes keep their names.

    Colours of vertices and faces are taken as sRGB, as scanners and PLY files have them; factors of
    materials as linear. The picture of an OBJ material stands in place of its diffuse colour, that
    of a PBR material multiplies its factor. Surfaces are seen from both sides unless their material
    says that they are not. Cameras, lights and normals are left out.

    Args:
        mesh: what trimesh has.
        unit: of its lengths: "m", "mm", "um" or a number of metres.
        up: "y" or "z", the axis that points up in it; z up is turned to Omma's +Y up.

    Raises:
        omma.Error: it is neither, or has numbers that no scene has; trimesh is not installed.
    """
    trimesh = _trimesh()
    world_from_mesh = np.diag([metres_per_unit(unit)] * 3 + [1.0])
    if one_of(up, ("y", "z"), "up") == "z":
        world_from_mesh = _Y_FROM_Z @ world_from_mesh
    if isinstance(mesh, trimesh.Trimesh):
        mesh = trimesh.Scene(mesh)
    if not isinstance(mesh, trimesh.Scene):
        raise Error(
            f"mesh: expected a trimesh.Trimesh or trimesh.Scene, found {type(mesh).__name__}"
        )
    parts = _Parts()
    index_of = {
        name: parts.add(name, geometry)
        for name, geometry in mesh.geometry.items()
        if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces)
    }
    instances = []
    for node in mesh.graph.nodes_geometry:
        transform, name = mesh.graph[node]
        if name in index_of:
            placed = world_from_mesh @ np.asarray(transform, float)
            placed[3] = 0, 0, 0, 1
            instances.append(Instance(index_of[name], placed, name=str(node)))
    return Scene(
        meshes=parts.meshes, instances=instances, materials=parts.materials, images=parts.images
    )


def load_mesh_file(path: str, unit: str | float, up: str) -> Scene:
    """The scene of a file that trimesh reads."""
    trimesh = _trimesh()
    if not os.path.isfile(path):
        raise Error(f"{path}: expected a file, found {_what_else(path)}")
    try:
        found = trimesh.load(path, force="scene", process=False)
    except Exception as error:  # each of its readers raises what it likes
        raise Error(f"{path}: trimesh cannot read it: {error}") from error
    try:
        scene = from_trimesh(found, unit=unit, up=up)
    except Error as error:
        raise Error(f"{path}: {error}") from None
    if not scene.meshes:
        raise Error(f"{path}: expected triangles, found none")
    return scene


def _what_else(path: str) -> str:
    return "a directory" if os.path.isdir(path) else "none"


def _trimesh() -> ModuleType:
    try:
        import trimesh
    except ImportError:
        raise Error(
            "meshes of other formats need trimesh, which is not installed: "
            "pip install 'omma[meshes]'"
        ) from None
    module: ModuleType = trimesh
    return module


class _Parts:
    """Meshes, materials and images as they come."""

    def __init__(self) -> None:
        self.meshes: list[Mesh] = []
        self.materials: list[Material] = []
        self.images: list[Image] = []
        self._material_of: dict[int, int] = {}  # by identity of what trimesh has

    def add(self, name: str, geometry: Any) -> int:
        positions, triangles = np.asarray(geometry.vertices), np.asarray(geometry.faces)
        coordinates = colors = None
        visual = geometry.visual
        if visual.kind == "texture":
            if visual.uv is not None and len(visual.uv) == len(positions):
                coordinates = np.asarray(visual.uv, float) * (1, -1) + (0, 1)
        elif visual.kind == "vertex":
            colors = _linear(visual.vertex_colors)
        elif visual.kind == "face":
            # A colour for each face: none of its vertices is another's.
            corners = triangles.ravel()
            positions = positions[corners]
            colors = np.repeat(_linear(visual.face_colors), 3, axis=0)
            triangles = np.arange(len(corners)).reshape(-1, 3)
        self.meshes.append(
            Mesh(
                positions,
                triangles,
                name=str(name),
                texture_coordinates=coordinates,
                colors=colors,
                material=self._material(getattr(visual, "material", None)),
            )
        )
        return len(self.meshes) - 1

    def _material(self, material: Any) -> int:
        if id(material) in self._material_of:
            return self._material_of[id(material)]
        # None, where there are only colours, gives a white one.
        factor = getattr(material, "baseColorFactor", None)
        picture = getattr(material, "baseColorTexture", None)
        if hasattr(material, "diffuse"):
            picture = material.image
            factor = material.diffuse if picture is None else None
        texture = None
        if picture is not None:
            self.images.append(Image(np.asarray(picture.convert("RGBA"))))
            texture = len(self.images) - 1
        color = np.ones(4) if factor is None else np.asarray(factor, float).ravel()
        if factor is not None and np.asarray(factor).dtype.kind in "iu":
            color = color / 255
        alpha = getattr(material, "alphaMode", None)
        cutoff = getattr(material, "alphaCutoff", None)
        both = getattr(material, "doubleSided", None)
        self.materials.append(
            Material(
                str(getattr(material, "name", None) or ""),
                base_color=color,
                base_color_texture=texture,
                alpha_mode="opaque" if alpha is None else alpha.lower(),
                alpha_cutoff=0.5 if cutoff is None else cutoff,
                double_sided=True if both is None else bool(both),
            )
        )
        self._material_of[id(material)] = len(self.materials) - 1
        return len(self.materials) - 1


def _linear(colors: Any) -> NDArray[np.float64]:
    """Linear RGBA of 8-bit sRGB."""
    encoded = np.asarray(colors, float) / 255
    rgb = encoded[:, :3]
    low, high = rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4
    return np.concatenate([np.where(rgb <= 0.04045, low, high), encoded[:, 3:]], axis=1)
