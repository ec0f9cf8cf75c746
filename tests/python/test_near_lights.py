"""Surfaces that shine near others: what arrives is that of closed forms, however large triangles
are beside the distance between them.
"""

import numpy as np
import pytest

import omma
from omma.light import Bands, Spectrum

BANDS = Bands.equal(2, 400, 700)
BACKENDS = ["embree", "portable"]
ALBEDO, RADIANCE = 0.5, 3.0


def flat(value):
    return Spectrum([300.0, 800.0], [value, value])


MATT = omma.scene.Material("matt", specular=0, reflectance=flat(ALBEDO), double_sided=True)
SHINING = omma.scene.Material(
    "shining", specular=0, base_color=(0, 0, 0, 1), emissive=(1, 1, 1), emission=flat(RADIANCE),
    double_sided=True,
)  # fmt: skip


def square(size, center_m, facing, material):
    return omma.scene.plane((size, size), center_m=center_m, facing=facing).replace(
        materials=[material]
    )


def form_factor(half, height):
    """Of a level square of sides 2 half over its middle, seen from a level patch below."""
    a = half / height
    b = a / np.sqrt(1 + a**2)
    return 4 / np.pi * b * np.arctan(b)


def seen(scene, backend, samples, from_m):
    """What a narrow ommatidium sees of the ground at the origin, and its standard error."""
    world = omma.World(scene, light=omma.light.lamps(bands=BANDS, unit="watts"), backend=backend)
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], np.radians(0.02))
    renderer = omma.Renderer(world, eye, omma.Fixed(samples))
    response, error = renderer.render(omma.look_at(from_m, (0, 0, 0)), standard_error=True)
    return float(response[0, 0, 0]), float(error[0, 0, 0])


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("size", [2, 20, 200, 2000])
@pytest.mark.parametrize("height", [0.1, 1.0])
def test_ground_of_large_triangles_is_lit(size, height, backend):
    # Floats of coordinates of 1,000 m are 6e-5 m apart, of which leave_surface takes 32.
    scene = omma.scene.merge_scenes(
        [square(size, (0, 0, 0), (0, 1, 0), MATT), square(0.1, (0, height, 0), (0, -1, 0), SHINING)]
    )
    response, error = seen(scene, backend, 64, (0.5, 0.5, 0))
    expected = ALBEDO * RADIANCE * form_factor(0.05, height)
    # Within the noise, and half a hundredth for where 2,000 m of ground is met, to centimetres.
    assert 0 < error < 0.01 * expected
    assert response == pytest.approx(expected, abs=5 * error + 0.005 * expected)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("height", [0.01, 0.1, 0.19, 0.5])
def test_wide_lights_just_above_a_floor(height, backend):
    scene = omma.scene.merge_scenes(
        [square(20, (0, 0, 0), (0, 1, 0), MATT), square(1, (0, height, 0), (0, -1, 0), SHINING)]
    )
    response, error = seen(scene, backend, 256, (0.6, 0.006, 0))
    assert 0 < error < 0.005 * response
    assert response == pytest.approx(ALBEDO * RADIANCE * form_factor(0.5, height), abs=5 * error)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_small_patch_below_a_light_of_large_triangles(backend):
    scene = omma.scene.merge_scenes(
        [
            square(0.2, (0, 0, 0), (0, 1, 0), MATT),
            square(200, (0, 0.1, 0), (0, -1, 0), SHINING),
        ]
    )
    response, error = seen(scene, backend, 256, (0.09, 0.05, 0))
    assert 0 < error < 0.005 * response
    assert response == pytest.approx(ALBEDO * RADIANCE, abs=5 * error)


def ring(count, radius_m=0.002, distance_m=2.0, off_deg=3.0):
    """Small lights around the axis of an ommatidium that looks along -Z."""
    turn = 2 * np.pi * np.arange(count) / count
    off = np.radians(off_deg)
    towards = np.stack(
        [np.sin(off) * np.cos(turn), np.sin(off) * np.sin(turn), np.full(count, -np.cos(off))], 1
    )
    return omma.scene.merge_scenes(
        [
            omma.scene.disc(radius_m, center_m=place, facing=-place, segments=4).replace(
                materials=[SHINING]
            )
            for place in distance_m * towards
        ]
    )


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("count", [2, 9, 10])
def test_each_of_ten_small_lights_is_seen(count, backend):
    world = omma.World(
        ring(count), light=omma.light.lamps(bands=BANDS, unit="watts"), backend=backend
    )
    width = np.radians(5.0)
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], width)
    renderer = omma.Renderer(world, eye, omma.Fixed(16), noise="new_every_frame")
    responses, errors = renderer.render(np.repeat(np.eye(4)[None], 20, 0), standard_error=True)
    sensitivity = np.exp(-4 * np.log(2) * (3.0 / 5.0) ** 2)
    # A disc of four corners is a square of that half diagonal.
    solid_sr = 2 * 0.002**2 / 2.0**2
    expected = count * RADIANCE * solid_sr * sensitivity / omma.receptors.solid_angle_sr(width)
    assert responses[:, 0, 0].mean() == pytest.approx(float(expected), rel=0.002)
    assert np.all(errors[:, 0, 0] < 0.01 * expected)


def test_a_light_alone_in_the_dark_needs_no_more_rays_than_the_dark():
    world = omma.World(ring(1), light=omma.light.lamps(bands=BANDS, unit="watts"))
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], np.radians(5.0))
    sampling = omma.ToError(relative_error=0.05, most=1 << 15)
    _, report = omma.Renderer(world, eye, sampling).render(np.eye(4)[None], report=True)
    assert report.rays[0, 0] == 32 + 4096
