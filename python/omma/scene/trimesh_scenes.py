"""Scenes from trimesh, and with it from STL files."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image, Instance, Material, Mesh, Scene
from omma.base.arguments import checked
from omma.base.arrays import Floats
from omma.base.mesh_parts import colors_and_mode, linear, offset_of, world_from_file
from omma.base.optional import needs
from omma.base.warn import warn_caller


@checked
def from_trimesh(mesh: Any, *, unit: str | float = "m", up: str = "y") -> Scene:
    """A scene from a `trimesh.Trimesh` or a `trimesh.Scene`, whose meshes stay shared and whose
    nodes keep their names.

    Colours of vertices and faces are taken as sRGB, as scanners and PLY files have them; factors of
    materials as linear. The picture of an OBJ material stands for its diffuse colour, that
    of a PBR material multiplies its factor. Light comes through where the alpha of a colour is
    below 1, of PBR materials as their alpha mode says. Surfaces are seen from both sides unless
    their material says that they are not.

    Of a PBR material emission, metal, roughness, pictures of these and of normals are taken too;
    one that says nothing of metal is none. What trimesh itself does not keep of a glTF file is not
    there: the strength of emission, transmission and other extensions. Of OBJ materials shine is
    left out, of scenes cameras, lights and normals.

    Args:
        mesh: what trimesh has.
        unit: of its lengths: "m", "mm", "um" or a number of metres.
        up: "y", "z" or "-y", the axis that points up in it, which is turned to Omma's +Y up.

    Raises:
        omma.Error: it is neither, or has numbers that no scene has; trimesh is not installed.

    Warns:
        UserWarning: materials of another kind, which are white; colours whose alpha is 0 all over,
            which are taken as opaque.
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
    for sentence in parts.warnings:
        warn_caller(sentence, UserWarning)
    return Scene(
        meshes=parts.meshes, instances=instances, materials=parts.materials, images=parts.images
    )


def read_stl(path: str) -> Any:
    """What trimesh has of an STL file."""
    trimesh = needs("trimesh", "meshes", "meshes of other formats need trimesh")
    _expect_whole(path)
    try:
        return trimesh.load(path, file_type="stl", force="scene", process=False)
    except Exception as error:  # its readers raise what they like
        raise Error(f"{path}: trimesh cannot read it: {error}") from error


def _expect_whole(path: str) -> None:
    """omma.Error where an STL file is cut off, of which trimesh has nothing or a part."""
    with open(path, "rb") as file:
        content = file.read()
    count, there = int.from_bytes(content[80:84], "little"), max(len(content) - 84, 0) // 50
    # Text, whatever its head is called: a count of triangles has zeros.
    if content.lstrip()[:5].lower() == b"solid" and b"\0" not in content[:84]:
        text = content.lower()
        if text.rfind(b"endfacet") > text.rfind(b"endsolid"):
            raise Error(f"{path}: expected endsolid at the end, found none: it is cut off")
    elif there < count:
        raise Error(f"{path}: expected {count:,} triangles, as its head says, found {there:,}")


class _Parts:
    """Meshes, materials and images as they come."""

    def __init__(self) -> None:
        self.meshes: list[Mesh] = []
        self.materials: list[Material] = []
        self.images: list[Image] = []
        self.offsets: list[NDArray[np.float64]] = []  # of each mesh, taken off its coordinates
        self.warnings: list[str] = []
        # By identity of what trimesh has.
        self._material_of: dict[tuple[int, str], int] = {}
        self._image_of: dict[int, int] = {}

    def add(self, name: str, geometry: Any) -> int:
        positions = np.asarray(geometry.vertices, float)
        triangles = np.asarray(geometry.faces)
        coordinates = colors = None
        visual = geometry.visual
        if visual.kind == "texture":
            if visual.uv is not None and len(visual.uv) == len(positions):
                coordinates = np.asarray(visual.uv, float) * (1, -1) + (0, 1)
            # Of files that have both.
            beside = visual.vertex_attributes.get("color")
            if beside is not None and len(beside) == len(positions):
                colors = _linear(beside)
        elif visual.kind == "vertex":
            colors = _linear(visual.vertex_colors)
        elif visual.kind == "face":
            # A colour for each face: none of its vertices is another's.
            corners = triangles.ravel()
            positions = positions[corners]
            colors = np.repeat(_linear(visual.face_colors), 3, axis=0)
            triangles = np.arange(len(corners)).reshape(-1, 3)
        told: list[str] = []
        colors, mode = colors_and_mode(colors, told)
        self.warnings += [f"mesh '{name}': {one}" for one in told]
        self.offsets.append(offset_of([positions]))
        self.meshes.append(
            Mesh(
                positions - self.offsets[-1],
                triangles,
                name=str(name),
                texture_coordinates=coordinates,
                colors=colors,
                material=self._material(getattr(visual, "material", None), mode),
            )
        )
        return len(self.meshes) - 1

    def _material(self, material: Any, mode: str) -> int:
        """The number of a material; ``mode`` is what alpha does where it does not say that."""
        key = id(material), mode
        if key not in self._material_of:
            if hasattr(material, "baseColorFactor"):
                made = self._physical(material)
            else:
                made = self._simple(material, mode)
            self.materials.append(made)
            self._material_of[key] = len(self.materials) - 1
        return self._material_of[key]

    def _simple(self, material: Any, mode: str) -> Material:
        """Of an OBJ file, or a white one where there are only colours."""
        if material is not None and not hasattr(material, "diffuse"):
            self.warnings.append(f"a {type(material).__name__} of trimesh is not read; it is white")
        texture = self._picture(getattr(material, "image", None))
        color = _factor(getattr(material, "diffuse", None) if texture is None else None)
        return Material(
            _name(material),
            base_color=color,
            base_color_texture=texture,
            alpha_mode="blend" if color[3] < 1 else mode,
            double_sided=True,
        )

    def _physical(self, material: Any) -> Material:
        """Of glTF, where what is not said is as it has it; but without a word about metal it is
        none."""
        shine = self._picture(material.metallicRoughnessTexture)
        metallic = 0.0 if shine is None else 1.0
        return Material(
            _name(material),
            base_color=_factor(material.baseColorFactor),
            base_color_texture=self._picture(material.baseColorTexture),
            emissive=_or(material.emissiveFactor, (0.0, 0.0, 0.0)),
            emissive_texture=self._picture(material.emissiveTexture),
            metallic=_or(material.metallicFactor, metallic),
            roughness=_or(material.roughnessFactor, 1.0),
            metallic_roughness_texture=shine,
            normal_texture=self._picture(material.normalTexture),
            alpha_mode=_or(material.alphaMode, "opaque").lower(),
            alpha_cutoff=_or(material.alphaCutoff, 0.5),
            double_sided=_or(material.doubleSided, True),
        )

    def _picture(self, picture: Any) -> int | None:
        """The number of the texture of an image of Pillow."""
        if picture is None:
            return None
        if id(picture) not in self._image_of:
            self.images.append(Image(np.asarray(picture.convert("RGBA"))))
            self._image_of[id(picture)] = len(self.images) - 1
        return self._image_of[id(picture)]


def _linear(colors: Any) -> Floats:
    """Linear RGBA of sRGB colours as trimesh has them: bytes, or from 0 to 1."""
    found = np.asarray(colors)
    shown = found.astype(float) / (np.iinfo(found.dtype).max if found.dtype.kind in "iu" else 1)
    return linear(shown if shown.shape[1] == 4 else np.insert(shown, 3, 1.0, axis=1))


def _factor(color: Any) -> Floats:
    """Linear RGBA, white where there is none."""
    if color is None:
        return np.ones(4)
    found = np.asarray(color).ravel()
    return found / 255 if found.dtype.kind in "iu" else found.astype(float)


def _name(material: Any) -> str:
    return str(getattr(material, "name", None) or "")


def _or(value: Any, otherwise: Any) -> Any:
    return otherwise if value is None else value
