"""Lengths of a scene that are no positions: they grow with its place, and with a file's unit."""

import numpy as np
import pytest
from lit_checks import BAND

import omma
from omma.light import Spectrum, uniform_sky
from omma.scene import Camera, Material, PunctualLight, load_scene, place_scene, save_scene

ABSORPTION = Spectrum([400, 700], [0.3, 0.6])  # per metre
DULL = Material("dull", base_color=(0.5, 0.5, 0.5, 1), specular=0.0)


def at(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def lamp_room(k):
    """A floor below a lamp that ends between the two places that `lamp_light` looks at."""
    floor = omma.scene.plane((20 * k, 20 * k))
    lamp = PunctualLight("bulb", intensity=50, range_m=3 * k, world_from_light=at(0, 2 * k, 0))
    return floor.replace(materials=[DULL], lights=[lamp])


def lamp_light(scene):
    eye = omma.Eye([[0, 0, 0]], [[0, -1, 0]], 0.0)
    world = omma.World(scene, light=omma.light.lamps(bands=BAND))
    return omma.Renderer(world, eye, omma.Fixed(16)).render(np.array([at(0.5, 1, 0), at(3, 1, 0)]))


def seen_square(k):
    """A square that fills a quarter of an orthographic camera's picture."""
    camera = Camera("map", type="orthographic", xmag_m=2 * k, ymag_m=k, znear_m=k, zfar_m=9 * k)
    square = omma.scene.box((2 * k, k, k), center_m=(0, 0, -3 * k))
    return square.replace(cameras=[camera])


def picture(scene):
    return omma.render_camera(scene, "map", width=64, samples=1)


def glass_block(k, **absorbs):
    glass = Material("glass", transmission=1, roughness=0, thickness_m=k, **absorbs)
    return omma.scene.box((2 * k, 2 * k, 2 * k), center_m=(0, 0, -3 * k)).replace(materials=[glass])


def coloured_block(k):
    return glass_block(k, attenuation_color=(0.5, 0.4, 0.3), attenuation_distance_m=2 * k)


def spectral_block(k):
    return glass_block(k, absorption_per_m=Spectrum(ABSORPTION.wavelength_nm, ABSORPTION.value / k))


def through(scene):
    eye = omma.Eye([[0.1, 0.2, 0]], [[0, 0, -1]], 0.0)
    world = omma.World(scene, light=uniform_sky(1.0, bands=BAND))
    return omma.Renderer(world, eye, omma.Fixed(64)).render(np.eye(4))


EACH = pytest.mark.parametrize(
    ("make", "look"),
    [
        (lamp_room, lamp_light),
        (seen_square, picture),
        (coloured_block, through),
        (spectral_block, through),
    ],
)


@EACH
def test_a_file_in_millimetres_is_seen_as_one_in_metres(tmp_path, make, look):
    save_scene(tmp_path / "m.glb", make(1))
    save_scene(tmp_path / "mm.glb", make(1000))
    metres = load_scene(tmp_path / "m.glb")
    told = load_scene(tmp_path / "mm.glb", unit="mm")
    expected = look(metres)
    assert expected.max() > 0
    assert look(told) == pytest.approx(expected, rel=1e-5)
    for one, other in zip(told.cameras, metres.cameras, strict=True):
        lengths = [(c.xmag_m, c.ymag_m, c.znear_m, c.zfar_m) for c in (one, other)]
        assert lengths[0] == pytest.approx(lengths[1])
        assert np.allclose(one.world_from_camera, other.world_from_camera, atol=1e-9)


@EACH
def test_lengths_grow_with_the_place(make, look):
    """A scene placed twice as large is seen as one that was made twice as large."""
    placed, made = place_scene(make(1), np.diag([2.0, 2, 2, 1])), make(2)
    assert look(placed) == pytest.approx(look(made), rel=1e-5)
    for one, other in zip(placed.lights, made.lights, strict=True):
        assert one.range_m == pytest.approx(other.range_m)
    for one, other in zip(placed.materials, made.materials, strict=True):
        assert one.thickness_m == pytest.approx(other.thickness_m)
        assert one.attenuation_distance_m == pytest.approx(other.attenuation_distance_m)


def test_turns_and_flat_places_change_no_lengths():
    scene = glass_block(1, attenuation_distance_m=0.3).replace(lights=lamp_room(1).lights)
    turned = place_scene(scene, omma.poses_from_angles((1, 2, 3), (20, 30, 40))[0])
    flat = place_scene(scene, np.diag([1.0, 0, 1, 1]))
    for one in (turned, flat):
        assert one.materials == scene.materials
        assert [lamp.range_m for lamp in one.lights] == [3]
    # Mirrored and stretched: the cube root of the volume.
    stretched = place_scene(scene, np.diag([-1.0, 4, 2, 1]))
    assert stretched.lights[0].range_m == pytest.approx(6)
    assert stretched.materials[0].attenuation_distance_m == pytest.approx(0.6)
