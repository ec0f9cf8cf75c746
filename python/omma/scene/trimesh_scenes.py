"""Scenes from trimesh, and with it from STL files."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image, Instance, Material, Mesh, Scene
from omma.base.arguments import checked
from omma.base.mesh_parts import linear, offset_of, world_from_file
from omma.base.optional import needs


@checked
def from_trimesh(mesh: Any, *, unit: str | float = "m", up: str = "y") -> Scene:
    """A scene from a `trimesh.Trimesh` or a `trimesh.Scene`, whose meshes stay shared and whose
    nodes keep their names.

    Colours of vertices and faces are taken as sRGB, as scanners and PLY files have them; factors of
    materials as linear. The picture of an OBJ material stands for its diffuse colour, that
    of a PBR material multiplies its factor. Surfaces are seen from both sides unless their material
    says that they are not. Cameras, lights and normals are left out.

    Args:
        mesh: what trimesh has.
        unit: of its lengths: "m", "mm", "um" or a number of metres.
        up: "y", "z" or "-y", the axis that points up in it, which is turned to Omma's +Y up.

    Raises:
        omma.Error: it is neither, or has numbers that no scene has; trimesh is not installed.
    """
    trimesh = needs("trimesh", "meshes", "meshes of other formats need trimesh")
    world_from_mesh = world_from_file(unit, up)
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
            placed[:3, 3] += placed[:3, :3] @ parts.offsets[index_of[name]]
            placed[3] = 0, 0, 0, 1
            instances.append(Instance(index_of[name], placed, name=str(node)))
    return Scene(
        meshes=parts.meshes, instances=instances, materials=parts.materials, images=parts.images
    )


def read_stl(path: str) -> Any:
    """What trimesh has of an STL file."""
    trimesh = needs("trimesh", "meshes", "meshes of other formats need trimesh")
    try:
        return trimesh.load(path, file_type="stl", force="scene", process=False)
    except Exception as error:  # its readers raise what they like
        raise Error(f"{path}: trimesh cannot read it: {error}") from error


class _Parts:
    """Meshes, materials and images as they come."""

    def __init__(self) -> None:
        self.meshes: list[Mesh] = []
        self.materials: list[Material] = []
        self.images: list[Image] = []
        self.offsets: list[NDArray[np.float64]] = []  # of each mesh, taken off its coordinates
        self._material_of: dict[int, int] = {}  # by identity of what trimesh has

    def add(self, name: str, geometry: Any) -> int:
        positions = np.asarray(geometry.vertices, float)
        triangles = np.asarray(geometry.faces)
        coordinates = colors = None
        visual = geometry.visual
        if visual.kind == "texture":
            if visual.uv is not None and len(visual.uv) == len(positions):
                coordinates = np.asarray(visual.uv, float) * (1, -1) + (0, 1)
        elif visual.kind == "vertex":
            colors = linear(np.asarray(visual.vertex_colors, float) / 255)
        elif visual.kind == "face":
            # A colour for each face: none of its vertices is another's.
            corners = triangles.ravel()
            positions = positions[corners]
            colors = np.repeat(linear(np.asarray(visual.face_colors, float) / 255), 3, axis=0)
            triangles = np.arange(len(corners)).reshape(-1, 3)
        self.offsets.append(offset_of([positions]))
        self.meshes.append(
            Mesh(
                positions - self.offsets[-1],
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
