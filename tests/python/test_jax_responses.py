"""Responses as functions of JAX's arrays, whose derivatives are those of `Renderer.jacobian`."""

from __future__ import annotations

import numpy as np
import pytest

import omma

jax = pytest.importorskip("jax", reason="needs JAX: pip install 'omma[jax]'")

jnp = jax.numpy
responses = omma.rendering.jax_responses
POSES = omma.poses_from_angles(np.zeros((2, 3)), [(0, 0, 0), (25, 10, 0)])


def renderer_of(samples=64):
    eye = omma.eye.generate_eye(30)
    return omma.Renderer(omma.load_scene(omma.examples.meadow()), eye, omma.Fixed(samples))


@pytest.fixture(scope="module")
def renderer():
    return renderer_of()


def test_derivatives_are_those_of_the_jacobian_to_the_bit(renderer):
    truth = renderer.jacobian(POSES)
    width = jnp.asarray(renderer.eye.acceptance_angle_rad)
    turn = jnp.zeros((2, 3))

    def seen(width, turn):
        return responses(renderer, POSES, acceptance_angle_rad=width, rotation_rad=turn)

    assert np.array_equal(seen(width, turn), truth.responses)
    for of in (jax.jacrev, jax.jacfwd):
        by_width, by_turn = of(seen, (0, 1))(width, turn)
        # Of each response by the width of its own ommatidium and the turn of its own pose.
        for found, name, own in (
            (by_width, "acceptance_angle_rad", "pncn->pnc"),
            (by_turn, "rotation_rad", "pncpi->pnci"),
        ):
            expected = truth.values[name].astype(np.float32)
            assert np.array_equal(np.einsum(own, found), expected), name
            # All else is 0.
            assert np.count_nonzero(found) == np.count_nonzero(expected), name


def test_gradients_are_those_of_vjp(renderer):
    """Of a random number of the responses, plain and compiled, to what single precision leaves."""
    rng = np.random.default_rng(1)
    weights = rng.normal(size=(2, 30, 3)).astype(np.float32)
    given = {
        "acceptance_angle_rad": jnp.asarray(renderer.eye.acceptance_angle_rad),
        "axis": jnp.asarray(renderer.eye.axis),
        "rotation_rad": jnp.zeros((2, 3)),
    }

    def number(given, weights):
        return (responses(renderer, POSES, **given) * weights).sum()

    _, expected = renderer.vjp(POSES, weights)
    _, change = renderer.jvp(POSES, {"rotation_rad": (0, 1, 0)})
    for made in (jax.grad(number), jax.jit(jax.grad(number)), jax.grad(jax.jit(number))):
        found = made(given, weights)
        for name, gradient in expected.items():
            assert found[name].dtype == np.float32
            # Sums of 180 numbers in single precision, each 6e-8 off.
            assert found[name] == pytest.approx(gradient, abs=1e-5 * np.abs(gradient).max()), name
    tangent = jnp.zeros((2, 3)).at[:, 1].set(1.0)
    _, along = jax.jvp(
        lambda turn: responses(renderer, POSES, rotation_rad=turn),
        (given["rotation_rad"],),
        (tangent,),
    )
    assert along == pytest.approx(change, abs=1e-6 * np.abs(change).max())


def test_axes_and_turns_of_any_length_by_differences():
    """Far from unit axes and from no turn, against differences of renders, within error bars."""
    renderer = renderer_of(1024)
    pose = renderer.scene.camera("bee").world_from_camera
    axis = jnp.asarray(2.5 * renderer.eye.axis)
    turn = jnp.asarray([[0.4, -0.3, 0.2]])
    change = np.random.default_rng(1).normal(size=(30, 3))
    for name, value, way in (("axis", axis, change), ("rotation_rad", turn, change[:1])):
        given = {"axis": axis, "rotation_rad": turn}
        step = 0.01

        def seen(value, given=given, name=name):
            return responses(renderer, pose, **{**given, name: value})

        _, slope = jax.jvp(seen, (value,), (jnp.asarray(way, jnp.float32),))
        more, less = (_rendered(renderer, pose, given, name, sign * step * way) for sign in (1, -1))
        difference = (more[0] - less[0]) / (2 * step)
        error = np.hypot(more[1], less[1]) / (2 * step)
        own = _slope_error(renderer, pose, given, name, way)
        z = (slope - difference)[0] / np.hypot(error, own)[0]
        # As of the tests of the Jacobian: Student's t of eight estimates, 90 numbers.
        assert abs(np.median(z)) < 0.4, name
        assert np.sqrt(np.mean(z**2)) < 1.5, name


def _eye_and_pose(renderer, pose, given):
    from scipy.spatial.transform import Rotation

    turned = np.array(pose)
    matrix = Rotation.from_rotvec(given["rotation_rad"][0]).as_matrix()
    turned[:3, :3] = matrix @ turned[:3, :3]
    return renderer.with_eye(renderer.eye.replace(axis=given["axis"])), turned


def _rendered(renderer, pose, given, name, change):
    given = {key: np.array(value, float) for key, value in given.items()}
    given[name] = given[name] + change
    seen_by, turned = _eye_and_pose(renderer, pose, given)
    return seen_by.render(turned, standard_error=True)


def _slope_error(renderer, pose, given, name, change):
    """Of a derivative along a change, from those by each axis: at most their sum."""
    given = {key: np.array(value, float) for key, value in given.items()}
    seen_by, turned = _eye_and_pose(renderer, pose, given)
    errors = seen_by.jacobian(turned, by=name).errors[name]
    length = np.linalg.norm(given["axis"], axis=1)[:, None] if name == "axis" else 1.0
    return np.sqrt(np.einsum("pnci,ni->pnc", errors**2, (change / length) ** 2 * np.ones((30, 3))))


def test_poses_and_numbers_that_a_compiled_function_is_given(renderer, monkeypatch):
    """They come in the precision of JAX, those outside in double precision."""
    compiled = jax.jit(lambda poses, number: responses(renderer, poses, first_pose=number))
    for number in (0, 5):
        expected = renderer.jacobian(POSES.astype(np.float32), by=(), first_pose=number).responses
        assert np.array_equal(compiled(jnp.asarray(POSES), number), expected)
    third = omma.poses_from_angles([(1 / 3, 1.2, 0)], [(0, 0, 0)])
    given = []

    def rendered(renderer, poses, **options):
        given.append(poses)
        return jacobian(renderer, poses, **options)

    jacobian = omma.Renderer.jacobian
    monkeypatch.setattr(omma.Renderer, "jacobian", rendered)
    jax.jit(lambda: responses(renderer, third))().block_until_ready()
    compiled(jnp.asarray(third), 0).block_until_ready()
    assert np.array_equal(given[0], third)
    assert np.array_equal(given[1], third.astype(np.float32))
    assert not np.array_equal(given[0], given[1])


def test_mapped_poses_are_rendered_one_by_one(renderer):
    compiled = jax.jit(lambda pose: responses(renderer, pose)[0])
    many = jax.vmap(compiled)(jnp.asarray(POSES))
    one_by_one = [compiled(jnp.asarray(pose)) for pose in POSES]
    assert np.array_equal(many, one_by_one)


def test_a_loop_of_descent_finds_back_how_an_eye_was_turned():
    """Compiled as one loop, new rays each step: Gauss-Newton on the difference of two frames."""
    renderer = renderer_of(2048)
    true = jnp.asarray([[0.0, 0.03, 0.0]])
    seen = responses(renderer, POSES[:1], rotation_rad=true, first_pose=7)

    def step(turn, number):
        def now(turn):
            return responses(renderer, POSES[:1], rotation_rad=turn, first_pose=number)

        slope = jax.jacrev(now)(turn).reshape(-1, 3)
        change = jnp.linalg.lstsq(slope, (seen - now(turn)).reshape(-1))[0]
        return turn + 0.5 * change, None

    turn, _ = jax.jit(lambda start: jax.lax.scan(step, start, jnp.arange(100, 112)))(
        jnp.zeros((1, 3))
    )
    assert np.abs(turn - true).max() < 0.01


def test_what_has_no_derivatives_is_refused(renderer):
    width = jnp.asarray(renderer.eye.acceptance_angle_rad)
    rough = renderer.with_eye(renderer.eye, omma.ToError(0.1))
    for call, message in (
        (lambda: responses(renderer, POSES, position_m=width), "position_m: responses have no"),
        (lambda: responses(renderer, POSES, samples=16), "numbers of rays"),
        (lambda: responses(renderer, POSES, axis=jnp.zeros((3, 3))), r"axis: .* \(30, 3\), found"),
        (lambda: responses(renderer, POSES, axis="x"), "axis: expected an array"),
        (lambda: responses(renderer, POSES, first_pose=-1), "first_pose"),
        (lambda: responses(rough, POSES), "sampling: expected omma.Fixed"),
        (
            lambda: jax.grad(lambda poses: responses(renderer, poses).sum())(jnp.asarray(POSES)),
            "poses: expected poses without gradients",
        ),
        (
            lambda: jax.grad(lambda k: responses(renderer, POSES, first_pose=k).sum())(1.0),
            "first_pose: expected a whole number",
        ),
        (
            lambda: jax.jit(lambda poses: responses(renderer, poses))(jnp.zeros((2, 3))),
            r"poses: expected shape \(4, 4\) or",
        ),
        (
            lambda: jax.hessian(lambda w: responses(renderer, POSES, acceptance_angle_rad=w).sum())(
                width
            ),
            "second ones",
        ),
    ):
        with pytest.raises(omma.Error, match=message):
            call()
    # What values alone tell comes through JAX.
    with pytest.raises(Exception, match="acceptance angle must be"):
        jax.jit(lambda w: responses(renderer, POSES, acceptance_angle_rad=w))(-width)
