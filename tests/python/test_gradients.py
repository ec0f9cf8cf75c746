"""Derivatives of responses by the eye and by where the head looks: closed forms of an edge and of a
grating, finite differences, error bars, products with vectors, what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

import omma
from omma.scene import Mesh

AHEAD = np.eye(4)
SIGMA_PER_WIDTH = 1 / np.sqrt(8 * np.log(2))


def edge():
    """A white wall, all that is right of straight ahead."""
    corners = [(0, -50, -1), (50, -50, -1), (50, 50, -1), (0, 50, -1)]
    wall = Mesh(corners, [(0, 1, 2), (0, 2, 3)])
    return omma.World(omma.Scene(meshes=[wall], instances=[omma.scene.Instance(0)]))


def looking_right_by(angles_rad, width_rad):
    axis = np.stack([np.sin(angles_rad), 0 * angles_rad, -np.cos(angles_rad)], axis=1)
    return omma.Eye(np.zeros_like(axis), axis, width_rad)


def test_an_edge_blurred_by_a_gaussian():
    """r = Φ(δ/σ): by the axis φ(δ/σ)/σ, by the width −δ φ(δ/σ)/σ² dσ/dw."""
    width = np.radians(2.0)
    sigma = width * SIGMA_PER_WIDTH
    offset = np.linspace(-2.5, 2.5, 41) * sigma
    eye = looking_right_by(offset, width)
    found = omma.Renderer(edge(), eye, omma.Fixed(1 << 14)).jacobian(AHEAD)
    density = norm.pdf(offset / sigma) / sigma
    expected = {
        "responses": norm.cdf(offset / sigma),
        # Of an axis (x, y, z) with x = sin, z = −cos: along the way to the right.
        "axis": density,
        "acceptance_angle_rad": -offset / sigma * density * SIGMA_PER_WIDTH,
        # A turn about the world's vertical moves axes to the left.
        "rotation_rad": -density,
    }
    right = np.stack([np.cos(offset), 0 * offset, np.sin(offset)], axis=1)
    got = {
        "responses": found.responses[0, :, 0],
        "axis": np.einsum("ni,ni->n", found.values["axis"][0, :, 0], right),
        "acceptance_angle_rad": found.values["acceptance_angle_rad"][0, :, 0],
        "rotation_rad": found.values["rotation_rad"][0, :, 0, 1],
    }
    assert got["responses"] == pytest.approx(expected["responses"], abs=2e-3)
    errors = {name: value[0, :, 0] for name, value in found.errors.items()}
    errors["axis"] = np.linalg.norm(errors["axis"], axis=1)
    errors["rotation_rad"] = errors["rotation_rad"][:, 1]
    for name, error in errors.items():
        # A sphere is no plane: terms of the order of the width squared, 1e-3. Of eight estimates
        # eight standard errors are passed once in 10,000 (Student's t).
        off = np.abs(got[name] - expected[name])
        most = np.abs(expected[name]).max()
        assert (off < 8 * error + 1e-3 * most).all(), name
        assert np.sqrt(np.mean(off**2)) < 0.01 * most, name
        assert np.median(error) < 0.01 * np.abs(expected[name]).max(), name
    # Nothing else turns it.
    other = found.values["axis"][0, :, 0] - got["axis"][:, None] * right
    assert np.abs(other).max() < 0.01 * density.max()


def test_errors_are_those_that_there_are():
    """z of what 64 rays say against the closed form, over 400 ommatidia."""
    width = np.radians(2.0)
    sigma = width * SIGMA_PER_WIDTH
    offset = np.random.default_rng(1).uniform(-1.5, 1.5, 400) * sigma
    eye = looking_right_by(offset, width)
    found = omma.Renderer(edge(), eye, omma.Fixed(64)).jacobian(AHEAD)
    density = norm.pdf(offset / sigma) / sigma
    for name, index, expected in (
        ("acceptance_angle_rad", (), -offset / sigma * density * SIGMA_PER_WIDTH),
        ("rotation_rad", (1,), -density),
    ):
        value, error = (
            each[name][(0, slice(None), 0, *index)] for each in (found.values, found.errors)
        )
        z = (value - expected) / error
        assert abs(z.mean()) < 0.2, name  # 4 of 1/√400, unbiased
        # Student's t of eight estimates has a standard deviation of 1.18.
        assert 1.0 < np.sqrt(np.mean(z**2)) < 1.4, name


def test_a_grating_by_its_modulation_transfer():
    """A grating all around, r = 1/2 + M(w) cos(k φ) / 2 with M = exp(−π² w² f² / (4 ln 2))."""
    cycles = 18
    columns = 3600
    azimuth = (np.arange(columns) + 0.5) / columns * 2 * np.pi
    stripes = 0.5 + 0.5 * np.cos(cycles * azimuth)
    image = np.repeat(np.repeat(stripes[None, :, None], 1800, 0), 3, 2).astype(np.float32)
    world = omma.World(omma.Scene(), background=omma.Background.image(image))
    width = np.radians(6.0)
    heading = np.radians(np.linspace(0, 20, 41))
    eye = looking_right_by(heading, width)
    found = omma.Renderer(world, eye, omma.Fixed(1 << 13), footprints=False).jacobian(AHEAD)
    frequency = cycles / (2 * np.pi)
    transfer = np.exp(-(np.pi**2) * width**2 * frequency**2 / (4 * np.log(2)))
    phase = found.responses[0, :, 0] - 0.5
    # By the width: M'/M of the modulation itself, whatever its phase is here.
    expected = phase * (-2 * np.pi**2 * width * frequency**2 / (4 * np.log(2)))
    by_width = found.values["acceptance_angle_rad"][0, :, 0]
    assert np.abs(phase).max() == pytest.approx(transfer / 2, rel=0.01)
    assert by_width == pytest.approx(expected, abs=0.02 * np.abs(expected).max())
    # By the heading: sine for cosine.
    by_heading = np.hypot(phase * cycles, found.values["rotation_rad"][0, :, 0, 1])
    assert by_heading == pytest.approx(np.full(41, cycles * transfer / 2), rel=0.02)


def test_against_differences_in_a_meadow():
    """Finite differences with many rays, of widths and of turns, within their error bars."""
    world = omma.World(omma.load_scene(omma.examples.meadow()))
    eye = omma.eye.generate_eye(80)
    pose = world.scene.camera("bee").world_from_camera
    renderer = omma.Renderer(world, eye, omma.Fixed(1024))
    found = renderer.jacobian(pose)
    step = 0.02
    width = eye.acceptance_angle_rad

    def seen(factor):
        wider = eye.replace(acceptance_angle_rad=width * factor)
        return renderer.with_eye(wider).render(pose, standard_error=True)

    more, less = seen(1 + step), seen(1 - step)
    per = (2 * step * width)[:, None]
    difference = (more[0] - less[0])[0] / per
    error = np.sqrt(more[1] ** 2 + less[1] ** 2)[0] / per
    z = (found.values["acceptance_angle_rad"][0] - difference) / np.hypot(
        error, found.errors["acceptance_angle_rad"][0]
    )
    assert np.abs(np.median(z)) < 0.4
    assert np.sqrt(np.mean(z**2)) < 1.5

    turn = 0.004
    turned = [
        omma.poses_from_angles((0, 0, 0), (np.degrees(sign * turn), 0, 0))[0] for sign in (1, -1)
    ]
    left, right = (
        renderer.render(
            np.block([[t[:3, :3] @ pose[:3, :3], pose[:3, 3:]], [np.zeros((1, 3)), 1]]),
            standard_error=True,
        )
        for t in turned
    )
    sign = np.sign(turned[0][0, 2])  # which way the yaw of angles turns about +Y
    difference = sign * (left[0] - right[0])[0] / (2 * turn)
    error = np.sqrt(left[1] ** 2 + right[1] ** 2)[0] / (2 * turn)
    z = (found.values["rotation_rad"][0, :, :, 1] - difference) / np.hypot(
        error, found.errors["rotation_rad"][0, :, :, 1]
    )
    assert np.abs(np.median(z)) < 0.4
    assert np.sqrt(np.mean(z**2)) < 1.5


def test_products_with_vectors_are_those_of_the_jacobian():
    eye = omma.eye.generate_eye(30)
    renderer = omma.Renderer(omma.scene.box(), eye, omma.Fixed(32))
    poses = omma.poses_from_angles(np.zeros((3, 3)), [(0, 0, 0), (10, 0, 0), (20, 5, 0)])
    rng = np.random.default_rng(1)
    tangents = {
        "acceptance_angle_rad": rng.normal(size=30),
        "axis": rng.normal(size=(30, 3)),
        "rotation_rad": rng.normal(size=(3, 3)),
    }
    cotangent = rng.normal(size=(3, 30, 3))
    responses, change = renderer.jvp(poses, tangents)
    same, gradient = renderer.vjp(poses, cotangent)
    assert np.array_equal(responses, same)
    through = sum(np.sum(gradient[name] * tangents[name]) for name in tangents)
    assert np.sum(change * cotangent) == pytest.approx(through, rel=1e-9)
    # Poses one by one have the same rays.
    for p in range(3):
        alone = renderer.jacobian(poses[p], by="axis", first_pose=p)
        assert np.array_equal(alone.responses[0], responses[p])


def test_a_turn_of_a_turned_head():
    """By the chain rule of rotation vectors, against differences of the matrices themselves."""
    from scipy.spatial.transform import Rotation

    from omma.rendering.differentiable import turn_per_vector

    vectors = np.random.default_rng(1).normal(size=(5, 3))
    vectors[0] = 0
    found = turn_per_vector(vectors)
    for k in range(3):
        step = 1e-6 * np.eye(3)[k]
        more, less = (Rotation.from_rotvec(vectors + sign * step) for sign in (1, -1))
        expected = (more * less.inv()).as_rotvec() / 2e-6
        assert found[:, :, k] == pytest.approx(expected, abs=1e-8)


def test_pieces_make_the_whole(monkeypatch):
    """Some ommatidia and some poses at a time, as where rays would fill the memory."""
    eye = omma.eye.generate_eye(30)
    renderer = omma.Renderer(omma.load_scene(omma.examples.meadow()), eye, omma.Fixed(32))
    poses = np.tile(renderer.scene.camera("bee").world_from_camera, (3, 1, 1))
    whole = renderer.jacobian(poses)
    monkeypatch.setattr("omma.rendering.gradients._MOST_BYTES", 1 << 15)
    pieces = renderer.jacobian(poses)
    assert np.array_equal(pieces.responses, whole.responses)
    for name, value in whole.values.items():
        assert pieces.values[name] == pytest.approx(value, rel=1e-9, abs=1e-9)
        assert pieces.errors[name] == pytest.approx(whole.errors[name], rel=1e-9, abs=1e-9)


def test_responses_are_those_of_a_render():
    eye = omma.eye.generate_eye(30)
    renderer = omma.Renderer(omma.load_scene(omma.examples.meadow()), eye, omma.Fixed(1024))
    pose = renderer.scene.camera("bee").world_from_camera
    found = renderer.jacobian(pose, by="axis").responses
    # Eight times 128 rays, as these are.
    rendered, error = renderer.with_eye(eye, omma.Fixed(128)).render(pose, standard_error=True)
    assert np.sqrt(np.mean(((found - rendered) / (error * np.sqrt(2))) ** 2)) < 1.4


def test_rays_look_where_they_say(tmp_path):
    """Of one pixel wide backgrounds: the direction of each ray, by its radiance."""
    rows, columns = 512, 1024
    elevation = np.pi / 2 - (np.arange(rows) + 0.5) / rows * np.pi
    image = np.repeat(np.sin(elevation)[:, None, None] + 1, columns, 1).repeat(3, 2)
    background = omma.Background.image(image.astype(np.float32))
    eye = omma.eye.generate_eye(50)
    for samples in (1, 5, 16, 100):
        renderer = omma.Renderer(
            omma.Scene(), eye, omma.Fixed(samples), background=background, footprints=False
        )
        poses = omma.poses_from_angles(np.zeros((2, 3)), [(30, 20, 10), (80, -30, 0)])
        rays = renderer.render_rays(poses, first_pose=3)
        directions = np.empty((2, 50, samples, 3), np.float32)
        renderer._engine.ray_directions(poses, 3, directions)
        assert np.linalg.norm(directions, axis=-1) == pytest.approx(1, abs=1e-5)
        # Between pixels a sine is off by an eighth of a pixel squared, and more at the poles.
        assert directions[..., 1] == pytest.approx(rays[..., 0] - 1, abs=1e-3)


def test_eyes_of_animals():
    """Their round Gaussians are told as acceptances."""
    eye = omma.species.drosophila().eye.take(np.arange(40))
    renderer = omma.Renderer(omma.scene.box(), eye, omma.Fixed(64))
    found = renderer.jacobian(AHEAD)
    plain = eye.replace(acceptance_angle_rad=eye.acceptance_angle_rad)
    same = renderer.with_eye(plain).jacobian(AHEAD)
    for name, value in found.values.items():
        assert value == pytest.approx(same.values[name], rel=1e-4, abs=1e-4)


def test_what_does_not_fit_is_told_before_rays_are_traced():
    renderer = omma.Renderer(omma.scene.box(), omma.eye.generate_eye(10))
    shares: list[float] = []

    def vjp(weights):
        return renderer.vjp(AHEAD, weights, by="axis", progress=shares.append)

    def jvp(tangents):
        return renderer.jvp(AHEAD, tangents, progress=shares.append)

    for call, message in (
        (lambda: vjp(np.zeros((2, 10, 3))), r"cotangent: expected shape \(1, 10, 3\), found"),
        (lambda: vjp(np.full((1, 10, 3), np.nan)), "cotangent: expected finite numbers"),
        (lambda: jvp({"axis": np.zeros((3, 3))}), r"axis: expected shape \(10, 3\) or \(3,\)"),
        (lambda: jvp({"rotation": (0, 1, 0)}), "tangents: expected one of .* did you mean"),
    ):
        with pytest.raises(omma.Error, match=message):
            call()
    assert not shares
    vjp(np.zeros((1, 10, 3)))
    assert shares


def test_what_has_no_derivatives_is_refused():
    eye = omma.eye.generate_eye(10)
    long = omma.Acceptance.gaussian(0.1, 0.05)
    lens = omma.Acceptance.airy(20e-6, 500)
    scene = omma.scene.box()
    for renderer, message in (
        (omma.Renderer(scene, eye, omma.ToError(0.1)), "Fixed"),
        (omma.Renderer(scene, eye, omma.Shared(4)), "Fixed"),
        (omma.Renderer(scene, eye, angular_sensitivity="pillbox"), "pillbox"),
        (omma.Renderer(scene, eye.replace(acceptance_angle_rad=0.0)), "10 ommatidia are none"),
        (omma.Renderer(scene, eye.replace(acceptance=long)), "10 ommatidia are none"),
        (omma.Renderer(scene, eye.replace(acceptance=[None, lens, *[None] * 8])), "the first 1"),
    ):
        with pytest.raises(omma.Error, match=message):
            renderer.jacobian(AHEAD)
    renderer = omma.Renderer(scene, eye)
    with pytest.raises(omma.Error, match="position"):
        renderer.jacobian(AHEAD, by="position_m")
    for first_pose in (-1, 1 << 60):
        with pytest.raises(omma.Error, match=f"0 to {(1 << 60) - 1}, found {first_pose}"):
            renderer.jacobian(AHEAD, first_pose=first_pose)
    assert renderer.jacobian(AHEAD, first_pose=(1 << 60) - 1, by="axis").responses.shape == (
        1,
        10,
        3,
    )
    with pytest.raises(TypeError, match=r"Renderer.jvp: .*'first'; did you mean 'first_pose'"):
        renderer.jvp(AHEAD, {"axis": np.zeros((10, 3))}, first=1)
    with pytest.raises(TypeError, match=r"by: expected some of acceptance_angle_rad, .* None"):
        renderer.jacobian(AHEAD, by=None)
    found = renderer.jacobian(AHEAD, by="axis")
    with pytest.raises(omma.Error, match="expected one of axis"):
        found.jvp({"rotation_rad": (0, 0, 1)})
    for tangent, message in (
        (np.zeros((3, 3)), r"axis: expected shape \(10, 3\) or \(3,\), found \(3, 3\)"),
        (np.full((10, 3), np.nan), "axis: expected finite numbers"),
    ):
        with pytest.raises(omma.Error, match=message):
            found.jvp({"axis": tangent})
    assert renderer.jacobian(np.zeros((0, 4, 4))).values["axis"].shape == (0, 10, 3, 3)
    with pytest.raises(omma.Error, match="finite"):
        found.vjp(np.full((1, 10, 3), np.nan))
    with pytest.raises(omma.Error, match="cotangent"):
        found.vjp(np.zeros((2, 10, 3)))
