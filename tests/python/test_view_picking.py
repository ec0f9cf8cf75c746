"""Ommatidia that are picked in the window: their rays, their cones, and which a click means."""

import numpy as np
from conftest import make_eye
from view_checks import LEVEL

import omma
from omma.view.picked import cone_of, ommatidium_looking_at, ommatidium_towards, rays_of
from omma.view.state import Look


def test_rays_are_those_that_are_rendered(looker):
    look = Look(LEVEL, samples=16)
    below = int(np.argmin(looker.eye.axis[:, 1]))
    rays = rays_of(looker, look, below, 16)
    seen = looker.see(look)
    assert np.allclose(rays.radiance.mean(axis=0), seen.responses[below], atol=1e-6)
    assert np.allclose(np.linalg.norm(rays.direction, axis=1), 1)
    # They meet the ground, which is at y = 0 and 20 m wide.
    ends = rays.start_m + rays.distance_m[:, None] * rays.direction
    met = np.isfinite(rays.distance_m)
    assert met.any()
    assert np.abs(ends[met, 1]).max() < 1e-4
    # Each alone, looked along by an eye of its own, brings what it brought.
    single = omma.Eye(rays.start_m, rays.direction, 1e-6)
    alone = omma.Renderer(looker.world, single, omma.Fixed(1), footprints=False).render(np.eye(4))
    plain = omma.Renderer(looker.world, looker.eye, omma.Fixed(16), footprints=False)
    exact = plain.render_rays(LEVEL.world_from_head)[0, below]
    # Directions are read from a picture of 1024 x 512, to some 1e-3 rad at worst; the ground is
    # 1.2 m away and goes from one colour to another in 20 m.
    assert np.abs(alone[0] - exact).max() < 1e-4
    assert np.abs(exact - exact.mean(axis=0)).max() > 5e-3


def test_what_is_clicked_on_is_what_is_picked(looker):
    look = Look(LEVEL, samples=1)
    pose = LEVEL.world_from_head
    for wanted in (3, 17):
        axis = pose[:3, :3] @ looker.eye.axis[wanted].astype(float)
        # On the head as it is drawn, 0.1 m in radius, from 1 m outside.
        start = pose[:3, 3] + axis
        found = ommatidium_looking_at(looker, look, start, -axis, 0.1)
        assert found == wanted
    # On the ground, from high above it: whoever looks at that place.
    place = np.array([1.0, 0.0, 2.0])
    start = np.array([1.5, 5.0, 1.0])
    found = ommatidium_looking_at(looker, look, start, place - start, 1e-3)
    assert found == ommatidium_towards(looker.eye, (place - pose[:3, 3]) @ pose[:3, :3])
    assert ommatidium_looking_at(looker, look, start, np.array([0, 1.0, 0]), 1e-3) is None


def test_a_cone_is_where_sensitivity_is_half():
    eye = make_eye(3).replace(acceptance=omma.Acceptance.gaussian(0.2, 0.1, 0.3))
    directions = cone_of(eye, 1, 16)
    axis, up = eye.axis[1].astype(float), eye.up[1].astype(float)
    theta = np.arccos(directions @ axis)
    azimuth = np.arctan2(directions @ np.cross(axis, up), directions @ up)
    assert np.allclose(eye.acceptance(1).eval(theta, azimuth), 0.5, atol=1e-4)
    assert np.ptp(theta) > 0.04
