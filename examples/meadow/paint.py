"""What each thing in the meadow is made of: unlit materials, or lit ones with spectra."""

from dataclasses import dataclass

from . import textures
from .glb import add_texture, add_unlit_material
from .lit import MEAN_FIELD, add_lit_material, add_plant_materials, picture_mean

REPEAT, CLAMP = 10497, 33071
GRASS_KINDS = ("grass blade", "dry grass")  # natural materials
LIGHTS = {"sun": (1.0, 1.0, 1.0), "dry": (1.0, 0.90, 0.64), "shade": (0.5, 0.5, 0.5)}


@dataclass
class Paint:
    """What each thing is made of: an unlit material, or lit ones by the parts of its mesh.

    grass is by light (a key of LIGHTS), cards and single blades; bark by the kind of tree.
    """

    lit: bool
    land: object
    path: object
    verges: object
    stones: object
    plants: object
    cards: dict
    blades: dict
    leaf: object
    bark: dict


def unlit_paint(glb, rng):
    ground_texture = add_texture(glb, "ground", textures.ground_jpeg(rng), "image/jpeg", REPEAT)
    grass_texture = add_texture(glb, "grass", textures.grass_png(rng), "image/png", CLAMP)
    leaf_texture = add_texture(glb, "leaves", textures.leaves_png(rng), "image/png", CLAMP)
    bark_texture = add_texture(glb, "bark", textures.bark_jpeg(rng), "image/jpeg", REPEAT)
    ground = add_unlit_material(glb, "ground", ground_texture)
    grass = add_unlit_material(glb, "grass", grass_texture, cutout=True)
    leaf = add_unlit_material(glb, "leaves", leaf_texture, cutout=True)
    bark = add_unlit_material(glb, "bark", bark_texture)
    plain = add_unlit_material(glb, "petals and stems")
    return Paint(
        lit=False,
        land=ground,
        path=ground,
        verges=ground,
        stones=ground,
        plants=plain,
        cards=dict.fromkeys(LIGHTS, grass),
        blades=dict.fromkeys(LIGHTS, plain),
        leaf=leaf,
        bark={"oak": bark, "birch": bark},
    )


def lit_paint(glb, rng):
    pictures = {
        "ground": (textures.ground_jpeg(rng), "image/jpeg", REPEAT),
        "grass": (textures.grass_png(rng, lit=True), "image/png", CLAMP),
        "leaves": (textures.leaves_png(rng, lit=True), "image/png", CLAMP),
        "bark": (textures.bark_jpeg(rng), "image/jpeg", REPEAT),
    }
    texture = {name: add_texture(glb, name, *picture) for name, picture in pictures.items()}

    def add(name, natural, picture, columns=(0, 1), cutout=False, brightness=1.0):
        mean = picture_mean(pictures[picture][0], columns) * brightness
        return add_lit_material(glb, name, natural, texture[picture], mean, cutout)

    plain = add_plant_materials(glb)
    green, dry = (add(f"{kind} on cards", kind, "grass", cutout=True) for kind in GRASS_KINDS)
    dry_blade = add_lit_material(glb, "dry grass", "dry grass")
    return Paint(
        lit=True,
        land={"": add("green sward", "green sward", "ground", brightness=MEAN_FIELD)},
        path={"": add("light soil", "light soil", "ground")},
        verges={"": add("verge", "green sward", "ground")},
        stones={"": add("rock", "rock", "ground")},
        plants=plain,
        cards={"sun": {"": green}, "dry": {"": dry}},
        blades={"sun": plain, "dry": {"grass blade": dry_blade}},
        leaf={"": add("green leaf on cards", "green leaf", "leaves", cutout=True)},
        bark={
            "oak": {"": add("bark", "bark", "bark", (0, 0.5))},
            "birch": {"": add("birch bark", "birch bark", "bark", (0.5, 1))},
        },
    )
