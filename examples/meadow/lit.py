"""What the lit meadow has in place of baked light: materials with spectra, and a pond.

Spectra are those of omma.scene.natural_materials, in the materials' extras; what glTF itself says
of a material is such that other programs show it in its colours. Pictures only say how brightness
varies: on the mean of one the material has its spectrum.
"""

import io
import math
from dataclasses import replace

import numpy as np
from PIL import Image

from . import land, shapes
from .glb import Mesh, append

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB
MEAN_FIELD = 0.6  # brightness where the land has its spectrum
POND_LEVEL_M, POND = -0.2, (35.2, -16.0)  # a hollow of the land, beyond the grass
EXTENSIONS = ["KHR_materials_ior", "KHR_materials_specular", "KHR_materials_diffuse_transmission"]


def picture_mean(data, columns=(0, 1)):
    """Mean linear RGB (3,) of a PNG or JPEG where it is opaque, between two shares of its width."""
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGBA")) / 255
    width = pixels.shape[1]
    pixels = pixels[:, int(columns[0] * width) : int(columns[1] * width)]
    return shapes.linear_of(pixels[pixels[..., 3] >= 0.5][:, :3]).mean(axis=0)


def spectrum(wavelength_nm, values):
    # Every 10 nm: the curves are smooth.
    return {
        "wavelength_nm": [float(v) for v in wavelength_nm[::2]],
        "value": [round(float(v), 4) for v in values[::2]],
    }


def add_lit_material(glb, name, natural, texture=None, mean=1.0, cutout=False, opaque=False):
    """A natural material. texture: an index, whose mean colour, times that of the vertices, is
    `mean` (linear RGB). opaque: of solid parts, which nothing passes."""
    from omma.scene import natural_materials  # of the lit meadow alone

    made = natural_materials()[natural]
    thin = made.transmittance is not None and not opaque
    share = made.diffuse_transmission if thin else 0.0
    # base_color is over 1 - share.
    colour = made.base_color * (1 - made.diffuse_transmission) / (1 - share)
    factor = np.round(np.clip(colour / mean, 0, 1), 4)
    surface = {
        "baseColorFactor": [*factor.tolist(), 1.0],
        "metallicFactor": 0,
        "roughnessFactor": made.roughness,
    }
    if texture is not None:
        surface["baseColorTexture"] = {"index": texture}
    extensions = {"KHR_materials_ior": {"ior": made.ior}}
    if made.specular != 1:
        extensions["KHR_materials_specular"] = {"specularFactor": made.specular}
    extras = {
        "reflectance": spectrum(made.wavelength_nm, made.reflectance),
        "spectral_luminance": round(float(LUMINANCE @ (factor * mean)), 5),
    }
    if thin:
        extensions["KHR_materials_diffuse_transmission"] = {
            "diffuseTransmissionFactor": round(share, 4),
            "diffuseTransmissionColorFactor": np.round(made.diffuse_transmission_color, 4).tolist(),
        }
        extras["transmittance"] = spectrum(made.wavelength_nm, made.transmittance)
    material = {"name": name, "pbrMetallicRoughness": surface, "doubleSided": True}
    material |= {"extensions": extensions, "extras": {"omma": extras}}
    if cutout:
        material |= {"alphaMode": "MASK", "alphaCutoff": 0.5}
    return append(glb, "materials", material)


def add_plant_materials(glb):
    """{part: material} of all that is geometry, not cards."""
    petals = ("white", "yellow", "blue", "pink", "dark")
    kinds = [f"{colour} petal" for colour in petals]
    kinds += ["yellow petal with ultraviolet", "red petal with ultraviolet"]
    kinds += ["green leaf", "grass blade"]
    materials = {kind: add_lit_material(glb, kind, kind) for kind in kinds}
    return materials | {"stem": add_lit_material(glb, "stem", "green leaf", opaque=True)}


def with_brightness(terrain):
    """The land with its fields: brighter and darker swards, from 0 to 1, MEAN_FIELD on average."""
    x, _, z = terrain.position.T
    bright = 1 - 0.4 * np.clip(land.waves(x, z, 13, 5), 0, 1)
    # Beyond the meadow: hay fields and pastures, where ground_colour has them.
    field = np.clip(0.5 + 2.5 * land.waves(x, z, 70, 6), 0, 1)
    bright *= 1 + (1 / MEAN_FIELD - 1) * field * land.smoothstep(26, 60, np.hypot(x, z))
    return replace(terrain, brightness=MEAN_FIELD * bright * (1 - 0.35 * land.wooded(x, z)))


def pond(directions=40):
    """The water in its hollow: a level fan of triangles whose rim lies under the shore."""
    rim = []
    for k in range(directions):
        angle = 2 * math.pi * k / directions
        r = np.arange(0.5, 14, 0.1)
        x, z = POND[0] + r * math.cos(angle), POND[1] - r * math.sin(angle)
        # So far into the shore that a coarser mesh of the land still covers the rim.
        ashore = np.argmax(land.height_m(x, z) > POND_LEVEL_M + 0.08)
        if ashore == 0:
            raise ValueError("the pond has no shore")
        rim.append([x[ashore], POND_LEVEL_M, z[ashore]])
    position = np.array([[POND[0], POND_LEVEL_M, POND[1]], *rim])
    k = np.arange(directions)
    index = np.stack([0 * k, k + 1, (k + 1) % directions + 1], axis=1)
    return Mesh(position, np.zeros_like(position), index)
