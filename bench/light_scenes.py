"""Scenes and lights of light.py: the light meadow, the lit meadow, and either one flattened, with
diffuse surfaces and a grey light, which all renderers agree about.
"""

from __future__ import annotations

import argparse
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import omma
from omma.base.srgb import linear_of_srgb
from omma.light import Bands, Light
from omma.scene import Image, Material, Mesh

LIT_MEADOW = Path(__file__).resolve().parents[1] / "examples" / "meadow_lit.glb"


@dataclass(frozen=True)
class Setup:
    """A scene, who sees it, and from where, (4, 4)."""

    name: str
    scene: omma.Scene
    eye: omma.Eye
    pose: NDArray[np.float64]


def light_meadow(data: Path) -> Setup:
    """CompoundRay's meadow, a surface of hills with one texture, and a honeybee above it."""
    scene = omma.load_scene(data / "scenes" / "natural-standin-sky.gltf")
    pose = np.eye(4)
    pose[1, 3] = 0.15
    return Setup(
        "natural-standin-sky", scene, omma.load_eye(data / "bees" / "AM_60185-real.eye"), pose
    )


def lit_meadow() -> Setup:
    """The bundled meadow with materials that have spectra, and a honeybee in its grass."""
    scene = omma.load_scene(LIT_MEADOW)
    eye = omma.species.honeybee_worker().eye
    return Setup("lit meadow", scene, eye, scene.camera("bee").world_from_camera)


def given_setups(description: str | None) -> tuple[list[Setup], bool]:
    """The meadows that a command line of DATA and --quick asks for, and whether it is quick."""
    parser = argparse.ArgumentParser(description=(description or "").split("\n\n")[0])
    parser.add_argument("data", type=Path, nargs="?")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    # The scenes' files say of themselves that without a light they are not lit, which is meant.
    warnings.simplefilter("ignore", UserWarning)
    return ([light_meadow(given.data)] if given.data else []) + [lit_meadow()], given.quick


def diffuse_setup(setup: Setup) -> Setup:
    """The same triangles in one mesh for each material; surfaces diffuse, opaque, two-sided.

    Without vertex colours, normals and spectra: what is left means the same in every renderer.
    """
    scene = setup.scene
    parts: dict[int, list[tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float32]]]] = {}
    meshes = scene.meshes
    for instance in scene.instances:
        mesh = meshes[instance.mesh]
        matrix = np.asarray(instance.world_from_mesh)
        position = mesh.positions_m @ matrix[:3, :3].T + matrix[:3, 3]
        where = mesh.texture_coordinates
        if where is None:
            where = np.zeros((len(position), 2), np.float32)
        own = -1 if mesh.material is None else mesh.material
        parts.setdefault(own, []).append((position, mesh.triangles, where))
    materials, flat = [], []
    for own, pieces in parts.items():
        start = np.cumsum([0] + [len(position) for position, _, _ in pieces])
        flat.append(
            Mesh(
                np.concatenate([position for position, _, _ in pieces]),
                np.concatenate([one + first for (_, one, _), first in zip(pieces, start)]),
                texture_coordinates=np.concatenate([where for _, _, where in pieces]),
                material=len(materials),
            )
        )
        materials.append(
            _diffuse(scene.materials[own]) if own >= 0 else Material(double_sided=True)
        )
    flattened = omma.Scene(
        meshes=flat, materials=materials, textures=scene.textures, images=scene.images
    )
    return replace(setup, scene=flattened)


def grey_setup(setup: Setup) -> Setup:
    """The same with grey surfaces, which are the same in red, green, blue and in bands of spectra.

    Base colours and texels are the mean of their red, green and blue.
    """
    scene = setup.scene
    images = []
    for image in scene.images:
        texels = linear_pixels(image.pixels[..., :3])
        images.append(Image(np.repeat(texels.mean(axis=-1, keepdims=True), 3, axis=-1)))
    materials = [
        one.replace(base_color=(*[float(np.mean(one.base_color[:3]))] * 3, 1.0))
        for one in scene.materials
    ]
    grey = omma.Scene(
        meshes=scene.meshes, instances=scene.instances, materials=materials,
        textures=scene.textures, images=images,
    )  # fmt: skip
    return replace(setup, scene=grey)


def linear_pixels(pixels: NDArray[Any]) -> NDArray[np.float32]:
    """Linear light of pixels as an `omma.scene.Image` has them: 8 bits are sRGB."""
    if pixels.dtype != np.uint8:
        return pixels.astype(np.float32)
    return linear_of_srgb(pixels.astype(np.float32) / 255)


def _diffuse(material: Material) -> Material:
    return Material(
        material.name,
        base_color=material.base_color,
        base_color_texture=material.base_color_texture,
        double_sided=True,
        specular=0.0,
    )


def grey_light(light: Light, bands: Bands) -> Light:
    """A light of the same shape, unpolarised and the same in all bands, as other bands have it."""
    assert light.sky is not None
    strength = 1.0 / light.sky[..., :1, :].mean()
    sky = light.sky[..., :1, :].mean(axis=-1, keepdims=True) * strength
    sky = np.repeat(sky, len(bands), axis=-1).astype(np.float32)
    discs = tuple(
        replace(
            one, radiance=np.full(len(bands), one.radiance.mean() * strength), limb_darkening=None
        )
        for one in light.discs
    )
    return Light(bands, light.unit, sky, None, discs)
