"""Derivatives of responses in lit worlds: of the sun's disc by its closed form, whole and partly
behind an edge; of its image in water; of all that a lit meadow shows, by differences of renders."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from test_aimed_rays import SUN_DEG, pond, reflectance, sun_ahead, towards_image
from test_eye_discs import (
    RADIANCE,
    RADIUS_RAD,
    Floats,
    empty,
    off_axis,
    points_on_sun,
    screen,
    sun,
)

import omma

SCORE = 8 * np.log(2)
TURN_RAD = 0.3  # of what is off an axis, as off_axis has it


@lru_cache
def normalisation(width: float) -> tuple[float, float]:
    """The integral of a Gaussian over the sphere, and the derivative of its logarithm."""
    polar = (np.arange(200_000) + 0.5) / 200_000 * min(np.pi, 5 * width)
    gaussian = np.exp(-SCORE / 2 * (polar / width) ** 2) * np.sin(polar)
    slope = np.sum(SCORE * polar**2 / width**3 * gaussian) / gaussian.sum()
    return float(2 * np.pi * gaussian.sum() * (polar[1] - polar[0])), float(slope)


def open_sun(axis: Floats, width_deg: float, seen: Floats | None = None) -> tuple[float, ...]:
    """The response to the sun, its derivative by the width, and by the axis towards the sun."""
    direction, _ = points_on_sun(250)
    width = np.radians(width_deg)
    along = direction @ axis
    across = direction - along[..., None] * axis
    sine = np.linalg.norm(across, axis=-1)
    angle = np.arctan2(sine, along)
    light = np.exp(-SCORE / 2 * (angle / width) ** 2)
    if seen is not None:
        light = light * seen
    of_sphere, slope = normalisation(width)
    solid_sr = np.pi * 4 * np.sin(RADIUS_RAD / 2) ** 2
    scale = RADIANCE * solid_sr / of_sphere
    towards = np.array([-np.cos(TURN_RAD), -np.sin(TURN_RAD), 0.0])
    towards -= (towards @ axis) * axis
    towards /= np.linalg.norm(towards)
    by_axis = SCORE * angle / width**2 * (across @ towards) / np.maximum(sine, 1e-12)
    by_width = SCORE * angle**2 / width**3 - slope
    return tuple(float(scale * np.mean(light * by)) for by in (1.0, by_width, by_axis))


def found_by(world: omma.World, axes: Floats, width_deg: float, samples: int = 16):
    eye = omma.Eye(np.zeros_like(axes), axes, np.radians(width_deg))
    return omma.Renderer(world, eye, omma.Fixed(samples)).jacobian(np.eye(4))


def towards_sun(axes: Floats) -> Floats:
    towards = np.array([-np.cos(TURN_RAD), -np.sin(TURN_RAD), 0.0])
    towards = towards - (axes @ towards)[:, None] * axes
    return towards / np.linalg.norm(towards, axis=1)[:, None]


@pytest.mark.parametrize("backend", ["embree", "portable"])
@pytest.mark.parametrize("width_deg", [0.5, 1.0, 2.6, 8.0])
def test_the_sun_by_its_closed_form(backend: str, width_deg: float) -> None:
    """From the sun to far beside it, where fewer and fewer points are taken of it."""
    off = np.linspace(0.05, 3.4, 60)
    axes = np.stack([off_axis(x * width_deg, TURN_RAD) for x in off])
    world = omma.World(empty(), light=sun(), lighting="path", backend=backend)
    found = found_by(world, axes, width_deg)
    exact = np.array([open_sun(axis, width_deg) for axis in axes])
    peak = np.abs(exact).max(axis=0)
    by_axis = np.einsum("ni,ni->n", found.values["axis"][0, :, 0], towards_sun(axes))
    got = (found.responses[0, :, 0], found.values["acceptance_angle_rad"][0, :, 0], by_axis)
    for value, known, most in zip(got, exact.T, peak, strict=True):
        # Directions and axes are single precision, 6e-8 rad.
        far = off > 2
        assert np.abs(value - known).max() < 1e-5 * most
        assert np.abs(value - known)[far].max() < 1e-4 * np.abs(known[far]).max()
    about = np.cross(axes, towards_sun(axes))
    turn = np.einsum("ni,ni->n", found.values["rotation_rad"][0, :, 0], about)
    assert turn == pytest.approx(by_axis, abs=1e-5 * peak[2])


def test_a_sun_partly_behind_an_edge() -> None:
    """Less of it is open where the sensitivity is higher, or more: by the points, not the whole."""
    edge, turn_rad = 0.3, 0.4
    axes = np.stack([off_axis(x, TURN_RAD) for x in np.linspace(0.05, 4, 30)])
    world = omma.World(screen(edge, turn_rad), light=sun(), lighting="path")
    found = found_by(world, axes, 2.6, 64)
    x, y, z = np.moveaxis(points_on_sun(250)[0], -1, 0)
    across = (x * np.cos(turn_rad) + y * np.sin(turn_rad)) / -z
    exact = np.array([open_sun(axis, 2.6, across > edge * np.tan(RADIUS_RAD)) for axis in axes])
    by_axis = np.einsum("ni,ni->n", found.values["axis"][0, :, 0], towards_sun(axes))
    by_width = found.values["acceptance_angle_rad"][0, :, 0]
    for name, value, known in (
        ("acceptance_angle_rad", by_width, exact[:, 1]),
        ("axis", by_axis, exact[:, 2]),
    ):
        error = found.errors[name][0, :, 0]
        error = np.linalg.norm(error, axis=-1) if error.ndim == 2 else error
        most = np.abs(known).max()
        assert np.median(error) < 0.002 * most, name
        # The reference's own points miss the edge by up to 5e-4.
        off = (value - known) / np.hypot(error, 5e-4 * most)
        assert np.sqrt(np.mean(off**2)) < 1.6, name


def test_the_sun_in_water() -> None:
    """Of its image the closed form is the sun's own times what water reflects."""
    off = np.array([0.5, 1.0, 1.5])
    axes = np.repeat(np.stack([towards_image(x * 2.6) for x in off]), 40, axis=0)
    found = found_by(pond(sun_ahead()), axes, 2.6)
    share = reflectance(SUN_DEG, 1.333)
    exact = np.array([open_sun(off_axis(x * 2.6, TURN_RAD), 2.6) for x in off])
    by_width = found.values["acceptance_angle_rad"][0, :, 0].reshape(3, 40)
    error = found.errors["acceptance_angle_rad"][0, :, 0].reshape(3, 40)
    off_by = np.median(by_width, axis=1) - share * exact[:, 1]
    # The image is spread a little by the least roughness (test_aimed_rays.py), and tails of it are
    # met by chance, which medians leave out.
    assert np.abs(off_by).max() < 0.03 * share * np.abs(exact[:, 1]).max()
    assert (np.median(error, axis=1) < 0.1 * share * np.abs(exact[:, 1]).max()).all()


def test_single_rays_have_what_is_seen_beside_them() -> None:
    """Their mean is the response: of the sun, which no ray brings, alone and in water."""
    for world, towards in ((omma.World(empty(), light=sun(), lighting="path"), off_axis),
                           (pond(sun_ahead()), towards_image)):  # fmt: skip
        axes = np.stack([towards(x) for x in (0.0, 1.0, 2.0)])
        eye = omma.Eye(np.zeros_like(axes), axes, np.radians(2.6))
        renderer = omma.Renderer(world, eye, omma.Fixed(16))
        rays = renderer.render_rays(np.eye(4))
        assert (rays > 0).all()
        response = renderer.render(np.eye(4))
        # Sums of 16 floats in another order.
        assert rays.mean(axis=2, dtype=float) == pytest.approx(response, rel=1e-5)


def test_against_differences_in_a_lit_meadow() -> None:
    """A sun within the field, and all that it lights: widths and a turn of the head."""
    world = omma.World(
        omma.load_scene(omma.examples.lit_meadow()),
        light=omma.light.clear_sky(30, bands=omma.light.Bands.equal(4, 300, 700)),
    )
    eye = omma.eye.generate_eye(60)
    pose = world.scene.camera("bee").world_from_camera
    renderer = omma.Renderer(world, eye, omma.Fixed(512), footprints=False)
    found = renderer.jacobian(pose)
    assert found.responses.max() > 100 * np.median(found.responses)
    by_turn = renderer.jacobian(pose, by="rotation_rad").values["rotation_rad"]
    assert np.array_equal(by_turn, found.values["rotation_rad"])
    width = eye.acceptance_angle_rad
    step = 0.04

    def seen(factor: float) -> tuple[Floats, Floats]:
        wider = renderer.with_eye(eye.replace(acceptance_angle_rad=width * factor))
        response, error = wider.render(pose, standard_error=True)
        return response[0].astype(float), error[0].astype(float)

    more, less = seen(1 + step), seen(1 - step)
    per = (2 * step * width)[:, None]
    difference = (more[0] - less[0]) / per
    error = np.hypot(more[1], less[1]) / per
    off = found.values["acceptance_angle_rad"][0] - difference
    z = off / np.hypot(error, found.errors["acceptance_angle_rad"][0])
    assert np.abs(np.median(z)) < 0.4
    assert np.sqrt(np.mean(z**2)) < 1.6
