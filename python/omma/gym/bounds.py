"""Between which numbers the responses of a world must lie, from what its surfaces and its sky can
be: the bounds of an observation."""

from __future__ import annotations

import numpy as np

from omma._core import Background, Material, Scene
from omma.base.arguments import checked
from omma.scene.world import World

# A mean of single precision numbers may lie above the largest of them by its rounding.
_ROUNDING = 1e-5


@checked
def response_bounds(world: World) -> tuple[float, float]:
    """The least and the largest response that an eye in this world can have.

    In a world without light no response is above the brightest of its surfaces and of its
    background: colour times the largest of texture and vertex colours, plus emission. Bands that
    take something away from another (negative weights) may go below 0. In a lit world nothing is
    known but that light is not negative, and the largest is infinite.

    Example:
        >>> grey = omma.World(omma.scene.box(paint=(0.5, 0.5, 0.5)))
        >>> omma.gym.response_bounds(grey)[0]
        0.0

    Returns:
        (least, largest), in the responses' unit.
    """
    scene = world.scene
    if world.light is not None or scene.color_rule != "gltf":
        return 0.0, np.inf
    brightest = max(_of_surfaces(_as_it_is(world)), _of_background(world.background))
    brightest *= 1 + _ROUNDING
    weights = world.band_from_rgb
    if weights is None:
        return 0.0, float(brightest)
    below, above = np.minimum(weights, 0).sum(axis=1), np.maximum(weights, 0).sum(axis=1)
    return float(brightest * below.min()), float(brightest * above.max())


def _as_it_is(world: World) -> Scene:
    """The scene with the pictures and colours that the world was given since."""
    scene = world.scene
    images, colors = world._colors.parts()
    if not images and not colors:
        return scene
    materials, pictures = scene.materials, scene.images
    for k, (base_color, emissive) in colors.items():
        own = materials[k]
        given = (0, 0, 0) if own.unlit else emissive
        materials[k] = own.replace(base_color=(*base_color, own.base_color[3]), emissive=given)
    for k, picture in images.items():
        pictures[k] = picture
    return scene.replace(materials=materials, images=pictures)


def _of_surfaces(scene: Scene) -> float:
    materials = scene.materials
    found = [_of_material(scene, material) for material in materials]
    largest = 0.0
    for mesh in scene.meshes:
        painted = 1.0 if mesh.colors is None else float(mesh.colors[:, :3].max(initial=0.0))
        base, emitted = (1.0, 0.0) if mesh.material is None else found[mesh.material]
        largest = max(largest, base * painted + emitted)
    return largest


def _of_material(scene: Scene, material: Material) -> tuple[float, float]:
    base, emitted = max(material.base_color[:3]), max(material.emissive)
    if material.base_color_texture is not None:
        base *= _of_texture(scene, material.base_color_texture.texture)
    if material.emissive_texture is not None:
        emitted *= _of_texture(scene, material.emissive_texture.texture)
    return base, emitted


def _of_texture(scene: Scene, texture: int) -> float:
    return _of_pixels(scene.images[scene.textures[texture].image].pixels)


def _of_background(background: Background) -> float:
    if background.type == "constant":
        return max(background.color)
    return 1.0 if background.pixels is None else _of_pixels(background.pixels)


def _of_pixels(pixels: np.ndarray) -> float:
    return 1.0 if pixels.dtype == np.uint8 else float(pixels[..., :3].max(initial=0.0))
