"""Renderers that share a scene, the radiance of single rays, CompoundRay's colours."""

import numpy as np
import pytest
from conftest import make_eye

import omma


def test_with_eye_equals_a_renderer_of_its_own(scene, eye, flight):
    first = omma.Renderer(
        scene, eye, omma.Fixed(5), seed=3, angular_sensitivity="pillbox", points="random"
    )
    other = make_eye(count=25, seed=9)
    for changes in (
        {},
        {"sampling": omma.Fixed(7)},
        {"seed": 4, "angular_sensitivity": "gaussian"},
    ):
        settings = {
            "sampling": omma.Fixed(5),
            "seed": 3,
            "angular_sensitivity": "pillbox",
            "points": "random",
        }
        settings |= changes
        second = first.with_eye(other, **changes)
        own = omma.Renderer(scene, other, **settings)
        assert (second.render(flight) == own.render(flight)).all()
        assert second.scene is scene
    expected = first.render(flight)
    assert len(first.eye) == len(eye)
    second = first.with_eye(eye)
    del first
    assert (second.render(flight) == expected).all()


def test_with_eye_keeps_the_background(scene, eye):
    white = omma.Background.constant((1, 1, 1))
    renderer = omma.Renderer(omma.Scene(), eye, background=white).with_eye(make_eye(count=3))
    assert np.abs(renderer.render(np.eye(4)) - 1).max() < 1e-6


def test_with_eye_checks_its_arguments(renderer, eye):
    with pytest.raises(omma.Error, match="samples"):
        renderer.with_eye(eye, omma.Fixed(0))
    with pytest.raises(TypeError, match="eye"):
        renderer.with_eye("bee")


@pytest.mark.parametrize("sampling", ["low_discrepancy", "random"])
def test_rays_average_to_the_responses(scene, eye, flight, sampling):
    renderer = omma.Renderer(scene, eye, omma.Fixed(12), points=sampling)
    rays = renderer.render_rays(flight[:3], first_pose=5)
    assert rays.shape == (3, len(eye), 12, 3)
    # Means of 12 numbers around 1 in another order.
    responses = renderer.render(flight[:3], first_pose=5)
    np.testing.assert_allclose(rays.mean(axis=2), responses, atol=1e-5)
    assert rays.std(axis=2).max() > 0


def test_color_rules(files):
    path = files / "scene.gltf"
    assert omma.load_scene(path, color_rule="compoundray").triangle_count > 0
    with pytest.raises(omma.Error, match="color_rule: expected one of gltf, compoundray"):
        omma.load_scene(path, color_rule="srgb")
