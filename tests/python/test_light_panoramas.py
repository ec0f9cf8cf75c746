"""Lights of pictures: between pixels, across the horizon, at the seam and the poles, and turned."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import omma
from omma.base.directions import direction
from omma.light import Bands, sky_map

ONE = Bands.equal(1)
RNG = np.random.default_rng(5)


def light_of(picture):
    return omma.light.panorama_bands(np.asarray(picture)[:, :, None], bands=ONE)


def seen_of(light, azimuth_deg, elevation_deg):
    return light.radiance(direction(azimuth_deg, elevation_deg))[..., 0, 0]


def between_pixels(picture, azimuth_deg, elevation_deg):
    """On straight lines from middle to middle of pixels, the last row being all there is beyond."""
    height, width = picture.shape
    row = np.clip((0.5 - np.asarray(elevation_deg) / 180) * height - 0.5, 0, height - 1)
    column = (np.asarray(azimuth_deg) / 360 + 0.5) * width - 0.5
    top, left = np.floor(row).astype(int), np.floor(column).astype(int)
    down, along = row - top, column - left
    below = np.minimum(top + 1, height - 1)
    upper, lower = (
        (1 - along) * picture[at, left % width] + along * picture[at, (left + 1) % width]
        for at in (top, below)
    )
    return (1 - down) * upper + down * lower


@pytest.mark.parametrize("shape", [(18, 36), (9, 18), (10, 21), (7, 15), (4, 8)])
def test_a_light_is_its_picture_between_the_middles_of_pixels(shape):
    picture = RNG.random(shape)
    azimuth = RNG.uniform(-180, 180, 5000)
    last = 90 - 90 / shape[0]
    elevation = RNG.uniform(-last, last, 5000)
    found = seen_of(light_of(picture), azimuth, elevation)
    np.testing.assert_allclose(found, between_pixels(picture, azimuth, elevation), atol=1e-6)


def test_a_light_is_seen_as_a_background_of_the_same_picture_is():
    picture = RNG.random((36, 72, 1)).astype(np.float32)
    picture[10, 30] = 20.0
    axes = direction(RNG.uniform(-180, 180, 1000), RNG.uniform(-87, 87, 1000))
    axes = np.concatenate([axes, direction(np.linspace(170, 190, 41), 10)])
    axes = np.concatenate([axes, direction(30, np.linspace(-8, 8, 41))])
    eye = omma.Eye(np.zeros((len(axes), 3)), axes, np.full(len(axes), np.radians(0.02)))
    lit = omma.World(omma.Scene(), light=omma.light.panorama_bands(picture, bands=ONE))
    background = omma.Background.image(np.repeat(picture, 3, axis=2))
    drawn = omma.World(omma.Scene(background=background))
    of_light = omma.Renderer(lit, eye, omma.Fixed(8)).render(np.eye(4))[0, :, 0]
    of_background = omma.Renderer(drawn, eye, omma.Fixed(8)).render(np.eye(4))[0, :, 0]
    # Rounding of directions and angles, where radiance goes from 1 to 20 in 5 degrees.
    np.testing.assert_allclose(of_light, of_background, rtol=1e-5, atol=2e-5)


def test_gratings_of_two_pixels_are_not_blurred_away():
    stripes = np.arange(90) % 2.0
    elevation = 89 - 2.0 * np.arange(90)
    rows = light_of(np.repeat(stripes[:, None], 180, axis=1))
    np.testing.assert_allclose(seen_of(rows, np.full(90, 33.0), elevation), stripes, atol=1e-6)
    columns = light_of(np.tile(stripes, (90, 2)))
    azimuth = 2.0 * np.arange(90) - 179
    np.testing.assert_allclose(seen_of(columns, azimuth, np.full(90, 33.0)), stripes, atol=1e-6)


@pytest.mark.parametrize("rows", [18, 9])
def test_a_ramp_goes_on_across_the_horizon(rows):
    middles = 90 - (np.arange(rows) + 0.5) * 180 / rows
    picture = np.repeat(1 + np.sin(np.radians(middles))[:, None], 2 * rows, axis=1)
    at = np.linspace(-12, 12, 25)
    found = seen_of(light_of(picture), np.full(25, 40.0), at)
    expected = np.interp(at, middles[::-1], picture[::-1, 0])
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_a_sun_of_one_pixel_is_as_bright_as_the_picture_says():
    picture = np.zeros((90, 180))
    picture[20, 130] = 1e4
    light = light_of(picture)
    assert seen_of(light, 81, 49) == pytest.approx(1e4, rel=1e-6)
    beside = seen_of(light, [79, 83, 81, 81], [49, 49, 47, 51])
    np.testing.assert_allclose(beside, 0, atol=1e-3)


def test_all_columns_meet_at_the_poles():
    picture = RNG.random((6, 12))
    light = light_of(picture)
    for sign, row in ((1, 0), (-1, -1)):
        found = seen_of(light, np.arange(0, 360, 20.0), np.full(18, sign * 90.0))
        np.testing.assert_allclose(found, picture[row].mean(), rtol=1e-6)


def test_nodes_of_large_pictures_are_a_pixel_apart(monkeypatch):
    monkeypatch.setattr(sky_map, "_FINE_PIXELS", 100)
    assert light_of(np.ones((5, 20))).sky.shape[1:3] == (6, 40)
    picture = RNG.random((6, 20))
    coarse = light_of(picture)
    assert coarse.sky.shape[1:3] == (4, 20)
    # Between pixels: the mean of the four about it.
    at_node = seen_of(coarse, 0, 30)
    assert at_node == pytest.approx(picture[1:3, 9:11].mean(), rel=1e-6)


def test_facets_get_what_pixels_send():
    picture = RNG.random((90, 180)) ** 4
    light = light_of(picture)
    fine = 8
    e, a = np.meshgrid(
        np.pi / 2 - (np.arange(90 * fine) + 0.5) / (90 * fine) * np.pi,
        (np.arange(180 * fine) + 0.5) / (180 * fine) * 2 * np.pi - np.pi,
        indexing="ij",
    )
    sent = np.kron(picture, np.ones((fine, fine))) * np.cos(e) * (np.pi / (90 * fine)) ** 2
    for normal in ((0, 1, 0), (0, -1, 0), (1, 0, 0), (0.48, 0.6, -0.64)):
        x, y, z = normal
        facing = np.cos(e) * (np.sin(a) * x - np.cos(a) * z) + np.sin(e) * y
        expected = (sent * np.maximum(facing, 0)).sum()
        # Each pixel's light is spread to the middles of those beside it.
        np.testing.assert_allclose(light.irradiance(normal)[0], expected, rtol=3e-4)


def test_halves_of_a_pixel_turn_without_loss():
    picture = RNG.random((18, 36))
    turned = light_of(picture).turned(25)
    at, elevation = RNG.uniform(-180, 180, 500), RNG.uniform(-85, 85, 500)
    expected = between_pixels(picture, at, elevation)
    np.testing.assert_allclose(seen_of(turned, at + 25, elevation), expected, atol=1e-6)


def test_turning_several_times_softens_once():
    light = light_of(RNG.random((18, 36)))
    step_by_step = light
    for _ in range(10):
        step_by_step = step_by_step.turned(1.3)
    assert step_by_step == light.turned(13.0)
    assert light.turned(500.2).turned(-500.2) == light
    with_recipe = omma.light.clear_sky(30, bands=ONE)
    for one in (light, with_recipe):
        turned = one.turned(1.3)
        for same in (turned, pickle.loads(pickle.dumps(turned)), copy.deepcopy(turned)):
            assert same == turned
            assert same.turned(11.7) == one.turned(13.0)


def test_what_was_changed_since_it_was_turned_is_turned_as_it_is():
    light = omma.light.clear_sky(30, bands=ONE).turned(10)
    dark = dataclasses.replace(light, discs=()).turned(20)
    assert len(dark.discs) == 0
    twice = light.scaled(2).turned(20)
    np.testing.assert_allclose(twice.discs[0].radiance, 2 * light.discs[0].radiance)
    np.testing.assert_allclose(twice.discs[0].direction, direction(30, 30), atol=1e-12)


@pytest.mark.parametrize("shape", [(8, 40_000), (40_000, 8)])
def test_strips_are_skies_of_as_many_columns_and_rows_as_there_may_be(shape):
    light = omma.light.panorama(np.ones((*shape, 3), np.float32), bands=Bands.equal(3, 400, 700))
    eye = omma.Eye([[0, 0, 0]], [[0, 1, -1]], 0.01)
    seen = omma.Renderer(omma.World(omma.Scene(), light=light), eye, omma.Fixed(4)).render(
        np.eye(4)
    )
    np.testing.assert_allclose(seen[0, 0], light.radiance((0, 1, -1))[0], rtol=1e-5)
