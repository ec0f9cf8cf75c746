"""Materials and textures of a model as a scene's: colours, pictures, how textures are laid."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image, Material, Mesh, Texture
from omma.base.srgb import linear_of_srgb
from omma.mujoco.cube_maps import cut_by_faces
from omma.mujoco.models import PLANE, mujoco_module, names_of
from omma.mujoco.shapes import Shape

# mjtTexture, mjtTextureRole, mjtColorSpace
PICTURE, CUBE, SKYBOX = 0, 1, 2
_ROLE_RGB, _ROLE_RGBA = 1, 8
_SRGB = 2
# The colour of a geom whose material says what colour it has.
_NOT_SAID = (0.5, 0.5, 0.5, 1.0)
# Below, MuJoCo draws what lies behind.
_OPAQUE = 0.995
# mj_version() (three digits, later seven) from which pictures go over surfaces.
_OVER_SURFACES = 3_012_000


def light_of(value: Any) -> NDArray[np.floating[Any]]:
    """Linear light of the model's sRGB values, in double precision."""
    return linear_of_srgb(np.asarray(value, float))


class Look:
    """Materials, textures and images of a scene, each made once, when something first needs it.

    Args:
        linear: whether the model's numbers are light itself, instead of sRGB.
    """

    def __init__(self, model: Any, linear: bool) -> None:
        self._model = model
        self._linear = linear
        self._goes_over_surfaces = mujoco_module().mj_version() >= _OVER_SURFACES
        self._names = names_of(model, "material", model.nmat)
        self._material_of: dict[tuple[Any, ...], int] = {}
        self._texture_of: dict[tuple[int, int], int] = {}
        self.materials: list[Material] = []
        self.textures: list[Texture] = []
        self.images: list[Image] = []

    def rgba(self, material: int, own_rgba: NDArray[Any]) -> tuple[float, ...]:
        """The model's numbers for something of that material (-1: none) and colour of its own."""
        own = tuple(float(value) for value in own_rgba)
        said = material < 0 or not np.allclose(own, _NOT_SAID, rtol=0, atol=1e-7)
        return own if said else tuple(float(value) for value in self._model.mat_rgba[material])

    def meshes(
        self,
        name: str,
        shape: Shape,
        material: int,
        own_rgba: NDArray[Any],
        kind: int,
        size: NDArray[np.float64],
        *,
        textured: bool = True,
    ) -> list[Mesh]:
        """The meshes of a thing: one, or one for each face of a cube texture that it shows."""
        rgba = self.rgba(material, own_rgba)
        texture = self._texture_of_material(material) if textured else -1
        both_sides = kind == PLANE
        flat = texture >= 0 and int(self._model.tex_type[texture]) == PICTURE
        # A mesh's own coordinates are positions in a picture; of a cube MuJoCo shows nothing there.
        if texture < 0 or (shape.own and not flat):
            which = self._material(material, rgba, None, both_sides)
            return [_mesh(name, shape, None, which)]
        if flat:
            coordinates = self._laid_out(shape, material, kind, size)
            image = self._texture(texture, 0)
            which = self._material(material, rgba, image, both_sides)
            return [_mesh(name, shape, coordinates, which)]
        uniform = bool(self._model.mat_texuniform[material])
        scale = np.where((size > 0) & uniform, size, 1.0)
        normals = [] if shape.normals is None else [shape.normals]
        found = []
        for face, coordinates, values in cut_by_faces(
            shape.triangles, shape.local * scale, shape.positions, *normals
        ):
            corners = np.arange(len(coordinates)).reshape(-1, 3)
            normal = values[1] if normals else None
            shown = Shape(values[0], corners, normal, values[0])
            which = self._material(material, rgba, self._texture(texture, face), both_sides)
            found.append(_mesh(name, shown, coordinates, which))
        return found

    def _laid_out(
        self, shape: Shape, material: int, kind: int, size: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Texture coordinates of a picture on something: as often as the material says, on all of
        it or, where it is uniform, on a length of 1 (2 along z).

        MuJoCo before 3.12 lays pictures along z, as if from a projector, on all that has no
        coordinates of its own, and does not repeat these. From then on they go once over each
        surface of a solid, and all are repeated; but a plane without an end, and what has no
        coordinates, has them along z still.
        """
        repeat = np.asarray(self._model.mat_texrepeat[material], float)
        ends = size[:2] > 0
        length = np.where(ends, size[:2], 1.0)
        uniform = bool(self._model.mat_texuniform[material])
        times = repeat * (length if uniform else 1.0)
        if shape.own and shape.once is not None:
            return shape.once * times if self._goes_over_surfaces else shape.once
        half = np.ones(2) if shape.once is not None and kind != PLANE else length
        along_z = 0.5 * times / half * (1, -1) * shape.local[:, :2] - 0.5
        if shape.once is None or not self._goes_over_surfaces:
            return np.asarray(along_z)
        if ends.all() or kind != PLANE:
            return shape.once * times
        return np.where(ends, shape.once * times - 0.5, along_z)

    def _texture_of_material(self, material: int) -> int:
        if material < 0:
            return -1
        roles = np.atleast_1d(self._model.mat_texid[material])
        if len(roles) == 1:
            return int(roles[0])
        return int(roles[_ROLE_RGB] if roles[_ROLE_RGB] >= 0 else roles[_ROLE_RGBA])

    def _texture(self, texture: int, face: int) -> int:
        key = texture, face
        if key not in self._texture_of:
            kind = int(self._model.tex_type[texture])
            pixels = texture_pixels(self._model, texture, self._linear)
            self.images.append(Image(pixels[face], names_of_texture(self._model, texture)))
            # A cube's faces end at its edges.
            wrap = "repeat" if kind == PICTURE else "clamp_to_edge"
            self.textures.append(Texture(len(self.images) - 1, wrap, wrap))
            self._texture_of[key] = len(self.textures) - 1
        return self._texture_of[key]

    def _material(
        self, material: int, rgba: tuple[float, ...], texture: int | None, both_sides: bool
    ) -> int:
        key = material, rgba, texture, both_sides
        if key not in self._material_of:
            model = self._model
            color = np.asarray(rgba[:3]) if self._linear else light_of(rgba[:3])
            more: dict[str, Any] = {}
            if material >= 0:
                more["emissive"] = color * float(model.mat_emission[material])
                if more["emissive"].any():
                    more["emissive_texture"] = texture
                more["roughness"] = roughness_of(
                    float(model.mat_roughness[material]), float(model.mat_shininess[material])
                )
                more["metallic"] = max(float(model.mat_metallic[material]), 0.0)
                more["specular"] = float(model.mat_specular[material])
            self.materials.append(
                Material(
                    self._names[material] if material >= 0 else "",
                    base_color=(*color, rgba[3]),
                    base_color_texture=texture,
                    alpha_mode="opaque" if rgba[3] >= _OPAQUE else "blend",
                    double_sided=both_sides,
                    **more,
                )
            )
            self._material_of[key] = len(self.materials) - 1
        return self._material_of[key]


def roughness_of(roughness: float, shininess: float) -> float:
    """A material's own roughness where it has one; else that of facets whose highlight is as wide
    as that of Phong's exponent, which MuJoCo takes as 128 times the shininess: alpha squared is
    2 / (exponent + 2), and alpha the square of the roughness."""
    if roughness >= 0:
        return min(roughness, 1.0)
    return float((2 / (128 * max(shininess, 0.0) + 2)) ** 0.25)


def names_of_texture(model: Any, texture: int) -> str:
    return names_of(model, "texture", model.ntex)[texture]


def texture_pixels(model: Any, texture: int, linear: bool) -> NDArray[Any]:
    """A texture's pictures: (1, H, W, 3 or 4), of a cube (6, N, N, 3 or 4); uint8 sRGB, or float32
    where they are light.

    Flat ones that say they are sRGB MuJoCo decodes before it shows them; its cubes never are.

    Raises:
        omma.Error: it is of no kind that is known, or of a size that no cube has.
    """
    kind = int(model.tex_type[texture])
    height, width = int(model.tex_height[texture]), int(model.tex_width[texture])
    channels = int(model.tex_nchannel[texture])
    where = f"model: texture {names_of_texture(model, texture)!r}"
    if kind not in (PICTURE, CUBE, SKYBOX):
        raise Error(f"{where}: expected a 2d, cube or skybox texture, found type {kind}")
    if height < 1 or width < 1 or not 1 <= channels <= 4:
        raise Error(f"{where}: expected a picture, found {width} x {height} x {channels}")
    if kind != PICTURE and height not in (width, 6 * width):
        raise Error(
            f"{where}: expected one or six squares below each other, found {width} x {height}"
        )
    first = int(model.tex_adr[texture])
    data = np.asarray(model.tex_data[first : first + height * width * channels], np.uint8)
    pixels = data.reshape(-1, height if kind == PICTURE else width, width, channels)
    if kind != PICTURE and len(pixels) == 1:
        pixels = np.repeat(pixels, 6, axis=0)
    if channels < 3:  # grey, and perhaps alpha
        pixels = np.concatenate([np.repeat(pixels[..., :1], 3, -1), pixels[..., 1:]], -1)
    decoded = kind == PICTURE and int(model.tex_colorspace[texture]) == _SRGB
    if not linear and not decoded:
        return np.ascontiguousarray(pixels)
    light = pixels / 255
    for _ in range(decoded + (not linear)):
        light[..., :3] = light_of(light[..., :3])
    return np.asarray(light, np.float32)


def _mesh(name: str, shape: Shape, coordinates: NDArray[np.float64] | None, material: int) -> Mesh:
    return Mesh(
        shape.positions,
        shape.triangles,
        name=name,
        normals=shape.normals,
        texture_coordinates=coordinates,
        material=material,
    )
