"""Pictures, colours and backgrounds that change while a world's shapes stay."""

import pickle

import numpy as np
import pytest
from conftest import make_eye

import omma

RANDOM = np.random.default_rng(4)
FIRST, SECOND = (RANDOM.integers(0, 256, (16, 32, 3), dtype=np.uint8) for _ in range(2))


@pytest.fixture(params=["embree", "portable"])
def backend(request):
    return request.param


def screen(picture):
    """A drum with a picture, and a lamp beside it."""
    drum = omma.scene.drum(1.0, 1.5, picture)
    lamp = omma.scene.sphere(0.2, (0.1, 0.2, 0.3), center_m=(0, 0, -0.6), name="lamp")
    return omma.scene.merge_scenes([drum, lamp])


def seen(world, poses=None):
    eye = make_eye(300, acceptance_deg=6)
    renderer = omma.Renderer(world, eye, omma.Fixed(16))
    return renderer.render(np.eye(4) if poses is None else poses)


@pytest.mark.parametrize("linear", [False, True])
def test_a_world_with_another_picture_is_one_built_with_it(backend, linear):
    second = (SECOND / 255).astype(np.float32) if linear else SECOND
    world = omma.World(screen(FIRST), backend=backend)
    before = seen(world)
    world.set_image(0, second)
    expected = seen(omma.World(screen(second), backend=backend))
    assert np.array_equal(seen(world), expected)
    assert not np.array_equal(before, expected)
    world.set_image(0, FIRST)
    assert np.array_equal(seen(world), before)


def test_a_world_with_another_colour_is_one_built_with_it(backend):
    world = omma.World(screen(FIRST), backend=backend)
    lamp = len(world.scene.materials) - 1
    red = omma.scene.merge_scenes(
        [
            omma.scene.drum(1.0, 1.5, FIRST),
            omma.scene.sphere(0.2, (0.9, 0.0, 2.5), center_m=(0, 0, -0.6), name="lamp"),
        ]
    )
    before = seen(world)
    world.set_color(lamp, (0.9, 0.0, 2.5))
    assert np.array_equal(seen(world), seen(omma.World(red, backend=backend)))
    world.set_color(lamp, world.scene.materials[lamp].base_color[:3])
    assert np.array_equal(seen(world), before)


def test_light_of_its_own_is_added():
    material = omma.scene.Material("lamp", base_color=(0.2, 0.2, 0.2, 1), double_sided=True)
    mesh = omma.scene.Mesh([(-1, -1, -1), (1, -1, -1), (0, 1, -1)], [(0, 1, 2)], material=0)
    world = omma.World(omma.Scene(meshes=[mesh], materials=[material]))
    ahead = omma.Renderer(world, omma.Eye([(0, 0, 0)], [(0, 0, -1)], 0), omma.Fixed(1))
    for light in (0, 0.25, 3):
        world.set_color("lamp", emissive=(light, 0, 0))
        assert np.allclose(ahead.render(np.eye(4)), (0.2 + light, 0.2, 0.2), rtol=1e-6)
    world.set_color("lamp", (0.5, 0.5, 0.5))
    assert np.allclose(ahead.render(np.eye(4)), (3.5, 0.5, 0.5), rtol=1e-6)


def test_all_who_see_the_world_see_it(tmp_path):
    world = omma.World(screen(FIRST))
    eye = make_eye(50, acceptance_deg=6)
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    before_sky = renderer.with_world(
        world.with_background(omma.Background.constant((0.2, 0.4, 0.9)))
    )
    world.set_image(0, SECOND)
    world.set_color(len(world.scene.materials) - 1, (0.5, 0.1, 0.1))
    fresh = omma.Renderer(world, eye, omma.Fixed(8)).render(np.eye(4))
    assert np.array_equal(renderer.render(np.eye(4)), fresh)
    assert not np.array_equal(before_sky.render(np.eye(4)), fresh)
    again = pickle.loads(pickle.dumps(renderer))
    assert np.array_equal(again.render(np.eye(4)), fresh)
    assert again.world is not world


def test_another_world_for_the_same_eye():
    world = omma.World(screen(FIRST))
    eye = make_eye(200, acceptance_deg=5)
    renderer = omma.Renderer(world, eye, omma.Fixed(16), seed=5)
    for level in (0.1, 0.7):
        sky = omma.Background.constant((level, level, level))
        other = world.with_background(sky)
        expected = omma.Renderer(other, eye, omma.Fixed(16), seed=5).render(np.eye(4))
        there = renderer.with_world(other)
        assert there.world is other
        assert there.settings == renderer.settings
        assert np.array_equal(there.render(np.eye(4)), expected)
    with pytest.raises(TypeError, match="world"):
        renderer.with_world(world.scene)


def test_what_cannot_be_changed_says_why():
    world = omma.World(screen(FIRST))
    with pytest.raises(omma.Error, match="picture: expected 32 x 16 pixels, as image 0 has, found"):
        world.set_image(0, SECOND[:8])
    with pytest.raises(omma.Error, match="image"):
        world.set_image(1, SECOND)
    with pytest.raises(omma.Error, match="image: expected one called 'wall', found nothing"):
        world.set_image("wall", SECOND)
    with pytest.raises(omma.Error, match="base_color: expected three finite numbers from 0 on"):
        world.set_color(0, (-1, 0, 0))
    with pytest.raises(omma.Error, match="emissive"):
        world.set_color(0, emissive=(np.inf, 0, 0))
    with pytest.raises(omma.Error, match="material"):
        world.set_color(9, (0, 0, 0))
    with pytest.raises(omma.Error, match="material: expected one called 'glass', found nothing"):
        world.set_color("glass", (0, 0, 0))
    before = seen(world)
    with pytest.raises(omma.Error, match="finite"):
        world.set_image(0, np.full((16, 32, 3), np.nan, np.float32))
    assert np.array_equal(seen(world), before)


def test_lit_worlds_keep_their_colours():
    light = omma.light.uniform_sky()
    lit = omma.World(screen(FIRST), light=light, lighting="path", ultraviolet="dark")
    for change in (
        lambda world: world.set_image(0, SECOND),
        lambda world: world.set_color(0, (0, 0, 0)),
    ):
        with pytest.raises(omma.Error, match="expected a world that was never lit"):
            change(lit)
        world = omma.World(screen(FIRST))
        change(world)
        with pytest.raises(omma.Error, match="light: expected a world whose images and colours"):
            world.with_light(light, ultraviolet="dark")


def test_cut_outs_keep_their_image():
    picture = np.dstack([FIRST, np.where(FIRST[:, :, 0] > 127, 255, 0).astype(np.uint8)])
    image = omma.scene.Image(picture)
    texture = omma.scene.Texture(0)
    material = omma.scene.Material("leaf", base_color_texture=0, alpha_mode="mask")
    mesh = omma.scene.Mesh(
        [(-1, -1, -1), (1, -1, -1), (0, 1, -1)],
        [(0, 1, 2)],
        texture_coordinates=[(0, 0), (1, 0), (0.5, 1)],
        material=0,
    )
    scene = omma.Scene(meshes=[mesh], materials=[material], textures=[texture], images=[image])
    with pytest.raises(omma.Error, match="image: expected one whose alpha is not used"):
        omma.World(scene).set_image(0, picture)
