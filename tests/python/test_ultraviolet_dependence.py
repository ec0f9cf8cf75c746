"""By how much responses depend on ultraviolet that nobody has given: on open ground under an even
sky, where all is known in closed form."""

import numpy as np
import pytest

import omma
from omma.receptors import ReceptorType
from omma.rendering import ultraviolet_dependence

BLUE = 0.25
RADIANCE = 1e17


@pytest.fixture(scope="module")
def scene():
    """Ground without a spectrum on the left, with one on the right, wide enough to fill a narrow
    ommatidium each."""
    known = omma.light.Spectrum([300, 700], [0.4, 0.4])
    parts = [
        omma.scene.plane((4, 4), (0.5, 0.5, BLUE), center_m=(-2, 0, 0), name="unknown"),
        omma.scene.plane((4, 4), (0.5, 0.5, BLUE), center_m=(2, 0, 0), name="known"),
    ]
    merged = omma.scene.merge_scenes(parts)
    matt = [one.replace(specular=0) for one in merged.materials]  # gloss would be there in the dark
    materials = [
        one if one.name == "unknown" else one.replace(reflectance=known, base_color=(1, 1, 1, 1))
        for one in matt
    ]
    return merged.replace(materials=materials)


@pytest.fixture(scope="module")
def eye():
    """One ommatidium looks down at each half, one up at the sky."""
    return omma.Eye(
        [[-2, 1, 0], [2, 1, 0], [0, 1, 0]],
        [[0, -1, 0], [0, -1, 0], [0, 1, 0]],
        np.radians(2),
        up=[[0, 0, -1]] * 3,
    )


@pytest.mark.parametrize("lighting", ["path", "baked"])
def test_open_ground(scene, eye, lighting):
    bands = omma.light.Bands.from_edges([300, 390, 500, 600, 700])
    world = omma.World(
        scene,
        light=omma.light.uniform_sky(RADIANCE, bands=bands),
        ultraviolet=0.02,
        lighting=lighting,
        bake=omma.scene.Bake(cache=False) if lighting == "baked" else None,
    )
    assert world.materials_without_ultraviolet == ("unknown",)
    found = ultraviolet_dependence(omma.Renderer(world, eye, omma.Fixed(256)), np.eye(4))
    assert found.materials == ("unknown",)
    assert found.dark.shape == found.as_blue.shape == (1, 3, 4)
    level = found.as_blue[0] / found.as_blue[0, 2]  # of the sky
    assert found.dark[0, 0, 0] == 0
    # Open ground returns its reflectance: 256 rays each bring the sky along one path.
    assert level[0, 0] == pytest.approx(BLUE, rel=1e-3)
    assert level[1] == pytest.approx(0.4, rel=1e-3)
    assert np.array_equal(found.dark[0, 1:], found.as_blue[0, 1:]), "what is known is the same"
    assert found.share[0, 0, 0] == 1
    assert (found.share[0, 1:] == 0).all()
    assert found.share[0, 0, 2:].max() < 1e-6, "light above 500 nm does not depend on it"
    assert found.share_error.shape == found.share.shape
    assert found.share_error[0, 0, 0] < 1e-3


def test_of_receptors(scene, eye):
    types = [
        ReceptorType("uv", peak_wavelength_nm=344),
        ReceptorType("green", peak_wavelength_nm=544),
    ]
    seeing = eye.replace(receptor_types=types, receptors=[0, 1])
    world = omma.World(
        scene, light=omma.light.uniform_sky(RADIANCE), ultraviolet="as_blue", lighting="path"
    )
    renderer = omma.Renderer(world, seeing, omma.Fixed(64))
    told = []
    found = ultraviolet_dependence(renderer, np.eye(4), receptors=True, progress=told.append)
    assert found.share.shape == found.dark.shape
    assert found.share[0, 0] > 0.9
    assert found.share[0, 1] < 0.1
    assert told == sorted(told)
    assert told[-1] == 1
    assert "1 materials: up to" in repr(found)


def test_chance_is_told_from_dependence(eye):
    """Gloss is sampled by all bands: what is above 400 nm differs, by no more than chance."""
    glossy = omma.scene.plane((4, 4), (0.1, 0.1, 0.1), name="glossy")
    world = omma.World(
        glossy.replace(materials=[glossy.materials[0].replace(roughness=0.6, specular=1.0)]),
        light=omma.light.clear_sky(40),
        ultraviolet="dark",
        lighting="path",
    )
    found = ultraviolet_dependence(omma.Renderer(world, eye, omma.Fixed(64)), np.eye(4))
    visible, below = found.share[0, :2, 4:], found.share[0, :2, :4]
    assert visible.max() > 0
    assert (visible < 5 * found.share_error[0, :2, 4:]).all()
    assert (below > 5 * found.share_error[0, :2, :4]).all()


def test_worlds_of_which_it_cannot_be_told(scene, eye):
    plain = omma.Renderer(scene, eye)
    assert plain.world.materials_without_ultraviolet == ()
    with pytest.raises(omma.Error, match="renderer: expected one of a lit world"):
        ultraviolet_dependence(plain, np.eye(4))
