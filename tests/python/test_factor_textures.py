"""Textures of a surface's specular reflection, transmission and clear coat: a square of which one
half of the texture is 0 and the other 1 looks as two materials do."""

import numpy as np
import pytest
from lit_checks import BAND, eyes_at, matter, shining, square

import omma
from omma.light import Bands, uniform_sky
from omma.scene import Image, Material, Texture, TextureUse

UPPER_SKY = uniform_sky(1.0, below=0.25, bands=BAND, unit="watts")
# Where texture coordinates are (0.25, 0.5) and (0.75, 0.5), seen aslant from above.
PLACES = np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
AXIS = np.array([0.0, -1.0, -1.0])
RED, GREEN, BLUE, ALPHA = range(4)


def halves(channel, first, second):
    """A picture of two texels that differ in one channel; the others are 0.5."""
    values = np.full((1, 2, 4), 0.5, np.float32)
    values[0, :, channel] = first, second
    return Image(values)


def seen(material, image=None, light=UPPER_SKY, **settings):
    """Radiance of the left and of the right half of a square of that material."""
    scene = omma.Scene(
        meshes=[square(2, (0, 0, 0), (0, 1, 0))],
        materials=[material],
        images=[] if image is None else [image],
        textures=[] if image is None else [Texture(0, filter="nearest")],
    )
    world = omma.World(scene, light=light, ultraviolet="dark", **settings)
    eye = eyes_at(PLACES - AXIS, AXIS)
    return omma.Renderer(world, eye, omma.Fixed(64)).render(np.eye(4))[0]


CASES = {
    "specular": ("specular_texture", ALPHA, {"specular": 0.8, "roughness": 0.3}),
    "transmission": ("transmission_texture", RED, {"transmission": 0.7}),
    "clearcoat": ("clearcoat_texture", RED, {"clearcoat": 0.9, "clearcoat_roughness": 0.2}),
    "clearcoat_roughness": (
        "clearcoat_roughness_texture",
        GREEN,
        {"clearcoat": 1.0, "clearcoat_roughness": 0.6},
    ),
}


@pytest.mark.parametrize("backend", ["embree", "portable"])
@pytest.mark.parametrize("factor", CASES)
def test_a_half_of_0_and_a_half_of_1_are_two_materials(factor, backend):
    texture, channel, values = CASES[factor]
    material = matter(0.2, **values)
    settings = {"lighting": "path", "backend": backend}
    found = seen(
        material.replace(**{texture: TextureUse(0)}), halves(channel, 0.0, 1.0), **settings
    )
    without = seen(material.replace(**{factor: 0.0}), **settings)
    whole = seen(material, **settings)
    np.testing.assert_array_equal(found[0], without[0])
    np.testing.assert_array_equal(found[1], whole[1])
    assert not np.array_equal(without[0], whole[0]), "the factor is seen"


@pytest.mark.parametrize("factor", CASES)
def test_half_a_factor(factor):
    texture, channel, values = CASES[factor]
    material = matter(0.2, **values)
    found = seen(
        material.replace(**{texture: TextureUse(0)}), halves(channel, 0.5, 3.0), lighting="path"
    )
    half = seen(material.replace(**{factor: values[factor] / 2}), lighting="path")
    np.testing.assert_allclose(found[0], half[0], rtol=1e-6)
    # What a picture holds above 1 counts as 1: no surface gives back more than it gets.
    np.testing.assert_array_equal(found[1], seen(material, lighting="path")[1])


# As a spectrum reflectance stands for itself; as a colour it is of what does not go through.
@pytest.mark.parametrize("known", [{}, {"reflectance": None, "base_color": (0.5, 0.5, 0.5, 1)}])
def test_diffuse_transmission(known):
    sheet = matter(0.2, diffuse_transmission_color=(0.8, 0.8, 0.8)).replace(**known)
    textured = sheet.replace(
        diffuse_transmission=0.6, diffuse_transmission_factor_texture=TextureUse(0)
    )
    found = seen(textured, halves(ALPHA, 0.25, 1.0), lighting="path")
    parts = [
        seen(sheet.replace(diffuse_transmission=part), lighting="path") for part in (0, 0.15, 0.6)
    ]
    # The factors are multiplied in another order: single precision.
    np.testing.assert_allclose(found[0], parts[1][0], rtol=1e-6)
    np.testing.assert_allclose(found[1], parts[2][1], rtol=1e-6)
    assert abs(parts[1][0, 0] / parts[0][0, 0] - 1) > 0.01, "the factor is seen"


COAT = {"specular": 0.0, "clearcoat": 1.0, "clearcoat_roughness": 0.0}
TURNED = {"clearcoat_normal_texture": TextureUse(0)}


# What mirrors straight above a mirror of water or glass: itself dark, or what shines aside.
@pytest.mark.parametrize(
    ("material", "sees"),
    [
        (matter(0.0, **COAT), "above"),
        (matter(0.0, **COAT, normal_texture=TextureUse(0)), "above"),
        (matter(0.0, **COAT, **TURNED), "aside"),
        (matter(0.0, **COAT, **TURNED, clearcoat_normal_scale=0.0), "above"),
        (matter(0.0, roughness=0.0, specular=1.0, normal_texture=TextureUse(0)), "aside"),
        (matter(0.0, roughness=0.0, specular=1.0, **TURNED, clearcoat=0.0), "above"),
    ],
)
def test_a_coat_mirrors_by_normals_of_its_own(material, sees):
    """A lamp where the mesh's own normal mirrors a ray, or where one turned by 30 degrees does."""
    angle = np.radians(30)
    codes = [0.5 + 0.5 * np.sin(angle), 0.5, 0.5 + 0.5 * np.cos(angle), 1.0]
    picture = Image(np.full((1, 1, 4), codes, np.float32))
    # A ray along (0, -1, -1) is mirrored to (0, 1, -1) or, about the turned normal, off the plane.
    normals = {"above": np.array([0.0, 1, 0]), "aside": np.array([np.sin(angle), np.cos(angle), 0])}
    axis = np.array([0.0, -1.0, -1.0]) / np.sqrt(2)
    for place, normal in normals.items():
        towards = axis - 2 * (axis @ normal) * normal
        lamp = square(0.5, 4 * towards, -towards, material=1)
        ground = square(2, (0, 0, 0), (0, 1, 0))
        scene = omma.Scene(
            meshes=[ground, lamp],
            materials=[material, shining(1.0)],
            images=[picture],
            textures=[Texture(0)],
        )
        dim = uniform_sky(1e-9, bands=BAND, unit="watts")
        world = omma.World(scene, light=dim, lighting="path")
        found = omma.Renderer(world, eyes_at(-axis, axis), omma.Fixed(256)).render(np.eye(4))[0, 0]
        cosine = -axis @ normal
        sine = np.sqrt(1 - cosine**2) / 1.5
        inside = np.sqrt(1 - sine**2)
        across = ((cosine - 1.5 * inside) / (cosine + 1.5 * inside)) ** 2
        along = ((inside - 1.5 * cosine) / (inside + 1.5 * cosine)) ** 2
        fresnel = (across + along) / 2
        if place == sees:
            # One lobe in many is taken, and the lamp found by two ways: noise of 256 rays.
            assert found == pytest.approx(fresnel, rel=0.05)
        else:
            assert found < 1e-3 * fresnel


def test_in_baked_light():
    material = matter(0.2, specular=1.0, roughness=0.1)
    settings = {"lighting": "baked", "bake": omma.scene.Bake(cache=False)}
    found = seen(
        material.replace(specular_texture=TextureUse(0)), halves(ALPHA, 0.0, 1.0), **settings
    )
    matt, glossy = (seen(material.replace(specular=s), **settings) for s in (0.0, 1.0))
    assert found[0] == pytest.approx(matt[0], rel=1e-3)
    assert found[1] == pytest.approx(glossy[1], rel=1e-3)
    assert glossy[0] > 1.02 * matt[0]


def test_the_colour_of_reflections():
    """By band, lifted as base colours are: in the picture red and black, times the factor."""
    bands = Bands.equal(4, 300, 700)
    sky = uniform_sky(1.0, bands=bands, unit="watts")
    black = Material(base_color=(0, 0, 0, 1), specular_color=(1, 0.5, 0), double_sided=True)
    values = np.zeros((1, 2, 4), np.float32)
    values[0, 0] = 1, 0, 0, 1
    image = Image(values)
    found = seen(
        black.replace(specular_color_texture=TextureUse(0)), image, light=sky, lighting="path"
    )
    red = seen(black.replace(specular_color=(1, 0, 0)), light=sky, lighting="path")
    none = seen(black.replace(specular_color=(0, 0, 0)), light=sky, lighting="path")
    np.testing.assert_allclose(found[0], red[0], rtol=1e-5)
    np.testing.assert_allclose(found[1], none[1], rtol=1e-5)
    assert (red[0] - none[0])[3] > 5 * (red[0] - none[0])[2]
