"""Blender's world as the background of a scene: a colour, or an equirectangular picture."""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from .gltf_file import GltfFile, add_bytes, default_scene
from .package import OmmaError


@dataclass
class Backdrop:
    """What a world shines with from afar."""

    color: tuple[float, float, float]  # linear, where there is no picture a radiance, else a factor
    image: bpy.types.Image | None = None
    turn_rad: float = 0.0  # of the picture about the vertical, as its Mapping node says


def backdrop_of(world: bpy.types.World | None) -> Backdrop:
    """What Omma can take over of a world.

    Raises:
        OmmaError: its nodes are more than a colour or an environment picture; it names the node.
    """
    if world is None:
        return Backdrop((0, 0, 0))
    if world.node_tree is None or (bpy.app.version < (5, 0) and not world.use_nodes):
        return Backdrop(tuple(world.color))
    # Where several are there, the renderer takes that for all or for Cycles too.
    output = world.node_tree.get_output_node("CYCLES")
    surface = _before(output.inputs["Surface"]) if output else None
    if surface is None:
        return Backdrop((0, 0, 0))
    if surface.type != "BACKGROUND":
        raise _unknown(world, surface)
    if strength := _before(surface.inputs["Strength"]):
        raise _unknown(world, strength)
    factor = surface.inputs["Strength"].default_value
    source = _before(surface.inputs["Color"])
    if source is None:
        color = surface.inputs["Color"].default_value[:3]
        return Backdrop(tuple(factor * part for part in color))
    if source.type != "TEX_ENVIRONMENT" or source.projection != "EQUIRECTANGULAR":
        raise _unknown(world, source)
    if source.image is None:
        raise OmmaError(f"World {world.name}: its environment texture has no picture")
    return Backdrop((factor,) * 3, source.image, _turn(world, _before(source.inputs["Vector"])))


def _before(socket: bpy.types.NodeSocket) -> bpy.types.Node | None:
    """The node that feeds a socket, past reroutes."""
    while socket.is_linked:
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def _unknown(world: bpy.types.World, node: bpy.types.Node) -> OmmaError:
    return OmmaError(
        f"World {world.name}: the node {node.name} is not exported. Omma takes a Background of one "
        "colour or of one equirectangular Environment Texture; bake the world into such a picture"
    )


def _turn(world: bpy.types.World, mapping: bpy.types.Node | None) -> float:
    """How far a Mapping node turns directions about the vertical."""
    if mapping is None or mapping.type == "TEX_COORD":
        return 0.0
    if mapping.type != "MAPPING" or mapping.vector_type not in ("POINT", "TEXTURE"):
        raise _unknown(world, mapping)
    inputs = mapping.inputs
    rotation = inputs["Rotation"].default_value
    scale, location = inputs["Scale"].default_value, inputs["Location"].default_value
    plain = (
        not any(socket.is_linked for socket in list(inputs)[1:])
        and max(abs(rotation[0]), abs(rotation[1]), *map(abs, location)) < 1e-6
        and max(abs(part - 1) for part in scale) < 1e-6
    )
    source = _before(inputs["Vector"])
    if not plain or (source is not None and source.type != "TEX_COORD"):
        raise _unknown(world, mapping)
    return rotation[2] if mapping.vector_type == "POINT" else -rotation[2]


def write_backdrop(gltf: GltfFile, backdrop: Backdrop) -> None:
    """Puts a background where Omma reads it: into the extras of the scene."""
    extras = default_scene(gltf)["extras"]
    if backdrop.image is None:
        extras["background-color"] = list(backdrop.color)
        return
    codes = _pixels(backdrop.image)
    codes = turned(codes, backdrop.turn_rad)
    is_coded = not backdrop.image.is_float and backdrop.image.colorspace_settings.name == "sRGB"
    made = {"name": backdrop.image.name, "mimeType": "image/png"}
    linear = codes.copy()
    if is_coded:
        linear[..., :3] = linear_from_srgb(codes[..., :3])
    linear[..., :3] *= backdrop.color
    if not is_coded or backdrop.color != (1, 1, 1):
        values = add_bytes(gltf, np.ascontiguousarray(linear, np.float32).tobytes())
        made["extras"] = {"omma-linear-rgba": values}
        codes = linear.copy()
        codes[..., :3] = srgb_from_linear(np.clip(linear[..., :3], 0, 1))
    made["bufferView"] = add_bytes(gltf, _png(codes))
    images = gltf.document.setdefault("images", [])
    images.append(made)
    extras["background-image"] = len(images) - 1


def _pixels(image: bpy.types.Image) -> np.ndarray:
    """float32 (height, width, 4), row 0 at the top; sRGB codes from 0 to 1 where it has 8 bits."""
    width, height = image.size
    if width == 0 or height == 0 or image.channels == 0:
        raise OmmaError(f"World: the picture {image.name} cannot be read ({image.filepath})")
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)[::-1]
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels[..., :3] if image.channels >= 3 else pixels[..., :1]
    return rgba


def turned(pixels: np.ndarray, turn_rad: float) -> np.ndarray:
    """An equirectangular picture of Blender's with +y, Omma's ahead, in the middle.

    Blender has +x there and what lies at +y a quarter to the left of it; Mapping turns directions
    before they are looked up.
    """
    width = pixels.shape[1]
    shift = width * (0.25 + turn_rad / (2 * math.pi))
    whole = math.floor(shift + 1e-4)
    part = shift - whole
    moved = np.roll(pixels, whole, axis=1)
    if part < 1e-3:
        return moved
    return ((1 - part) * moved + part * np.roll(moved, 1, axis=1)).astype(np.float32)


def linear_from_srgb(code: np.ndarray) -> np.ndarray:
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(value: np.ndarray) -> np.ndarray:
    return np.where(value <= 0.0031308, value * 12.92, 1.055 * value ** (1 / 2.4) - 0.055)


def _png(codes: np.ndarray) -> bytes:
    height, width = codes.shape[:2]
    image = bpy.data.images.new("omma-background", width, height, alpha=False)
    try:
        image.pixels.foreach_set(np.ascontiguousarray(codes[::-1], np.float32).ravel())
        with tempfile.TemporaryDirectory(prefix="omma-background-") as folder:
            path = Path(folder, "background.png")
            image.filepath_raw, image.file_format = str(path), "PNG"
            image.save()
            return path.read_bytes()
    finally:
        bpy.data.images.remove(image)
