"""Ground truth beside responses, as Python asks for it: against formulas that NumPy computes, on
both backends, in unlit, lit and baked worlds."""

import dataclasses
import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation, Slerp

import omma
from omma import scene as solids
from omma.rendering import GroundTruth

FORWARD = np.array([0.0, 0.0, -1.0])
# The head moves and turns in all directions.
HEAD = (np.array([0.4, -0.2, 1.3]), np.array([1.0, 2.5, -0.7]))
BALL = (np.array([0.0, 0.6, 0.2]), np.array([3.0, 0.0, -5.0]))


@pytest.fixture(scope="module")
def things():
    """Ground, a ball and two posts of one name."""
    return solids.merge_scenes(
        [
            solids.plane((60, 60), (0.4, 0.3, 0.1)),
            solids.sphere(0.9, (1, 0, 0), center_m=(0.5, 1, -2), name="ball"),
            solids.box((0.3, 4, 0.3), (0, 1, 0), center_m=(-1, 2, -3), name="post"),
            solids.box((0.3, 4, 0.3), (0, 0, 1), center_m=(2, 2, 1), name="post"),
        ]
    )


@pytest.fixture(scope="module", params=["embree", "portable"])
def world(things, request):
    try:
        return omma.World(things, backend=request.param)
    except omma.Error as error:
        pytest.skip(str(error))


def narrow_eye(count=400):
    """Rays along the axes alone, so that each number is that of one direction."""
    eye = omma.eye.generate_eye(count)
    return eye.replace(acceptance_angle_rad=np.zeros(count, np.float32))


def eye_ahead(**acceptance):
    """Two ommatidia in the head's origin that look straight ahead."""
    ahead = np.tile(FORWARD, (2, 1)).astype(np.float32)
    up = np.tile(np.float32([0, 1, 0]), (2, 1))
    return narrow_eye(2).replace(axis=ahead, up=up, position_m=np.zeros((2, 3)), **acceptance)


def frame_of(eye, pose):
    """Axes, right and up of ommatidia in the world, (N, 3) each, and where rays start."""
    axis = eye.axis.astype(float)
    up = eye.up.astype(float)
    start = eye.position_m - axis * eye.focal_offset_m[:, None]
    turn = pose[:3, :3]
    return (
        axis @ turn.T,
        np.cross(axis, up) @ turn.T,
        up @ turn.T,
        start @ turn.T + pose[:3, 3],
    )


def moved(pose, velocity, dt_s):
    """A frame that has moved on."""
    linear, angular = velocity
    after = pose.copy()
    after[:3, :3] = Rotation.from_rotvec(angular * dt_s).as_matrix() @ pose[:3, :3]
    after[:3, 3] += linear * dt_s
    return after


POSE = omma.poses_from_angles((0.1, 1.1, 0.3), (25, -10, 15))[0]


def test_flow_is_the_formula_and_how_points_are_seen_to_move(world):
    eye = narrow_eye()
    renderer = omma.Renderer(world, eye, omma.Fixed(1))
    truth = renderer.ground_truth(
        POSE, shares=["ball"], head_velocity=HEAD, velocities={"ball": BALL}
    )
    d, right, up, start = frame_of(eye, POSE)
    on_ball = truth.shares[0, :, 0] == 1
    assert 5 < on_ball.sum() < 200
    r = truth.distance_m[0, :, None].astype(float)
    with np.errstate(invalid="ignore"):
        point = np.where(np.isfinite(r), start + d * r, 0)

    def along(flow):
        return np.stack([(flow * right).sum(1), (flow * up).sum(1)], 1)

    t = HEAD[0] + np.cross(HEAD[1], start - POSE[:3, 3])
    rotation = along(-np.cross(HEAD[1], d))
    translation = along(-(t - (t * d).sum(1, keepdims=True) * d) / r)
    center = world.instances[world.index("ball")].world_from_node[:3, 3]
    v = np.where(on_ball[:, None], BALL[0] + np.cross(BALL[1], point - center), 0)
    objects = along((v - (v * d).sum(1, keepdims=True) * d) / r)
    for found, expected in (
        (truth.flow_rotation_rad_s, rotation),
        (truth.flow_translation_rad_s, translation),
        (truth.flow_objects_rad_s, objects),
    ):
        size = np.linalg.norm(expected, axis=1, keepdims=True).max()
        assert_allclose(found[0], expected, atol=1e-5 * size)
    assert (truth.flow_objects_rad_s[0, ~on_ball] == 0).all()

    # What is seen at these points, a moment before and after, in the head's frame.
    def seen_at(dt_s):
        pose = moved(POSE, HEAD, dt_s)
        ball = moved(np.eye(4), (BALL[0], BALL[1]), dt_s)
        there = np.where(
            on_ball[:, None], (point - center) @ ball[:3, :3].T + center + ball[:3, 3], point
        )
        towards = there - frame_of(eye, pose)[3]
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        return towards @ pose[:3, :3] @ POSE[:3, :3].T

    met = truth.met[0] == 1
    difference = along((seen_at(1e-4) - seen_at(-1e-4)) / 2e-4)
    size = np.linalg.norm(difference, axis=1, keepdims=True)
    assert met.sum() > 150
    assert (np.abs(truth.flow_rad_s[0] - difference) < 1e-3 * size + 1e-6)[met].all()


def test_distances_places_and_normals(world):
    eye = narrow_eye()
    truth = omma.Renderer(world, eye, omma.Fixed(1)).ground_truth(POSE, shares=["plane", "ball"])
    d, _, _, start = frame_of(eye, POSE)
    ground, ball = truth.shares[0, :, 0] == 1, truth.shares[0, :, 1] == 1
    assert ground.sum() > 100
    assert ball.sum() > 5
    expected = -start[ground, 1] / d[ground, 1]
    assert_allclose(truth.distance_m[0, ground], expected, rtol=1e-5)
    assert_allclose(truth.nearest_m[0, ground], expected, rtol=1e-5)
    assert_allclose(truth.inverse_distance_per_m[0, ground], 1 / expected, rtol=1e-5)
    assert_allclose(
        truth.position_m[0, ground], start[ground] + d[ground] * expected[:, None], atol=1e-3
    )
    assert_allclose(truth.normal[0, ground], np.tile([0.0, 1, 0], (ground.sum(), 1)), atol=1e-6)
    # Of the ball: within the chords of its faces, 0.9 (1 - cos(pi / 128)) = 2.7e-4 m.
    out = truth.position_m[0, ball] - (0.5, 1, -2)
    assert_allclose(np.linalg.norm(out, axis=1), 0.9, atol=6e-4)
    assert ((truth.normal[0, ball] * out).sum(1) > 0.898).all()
    nothing = truth.met[0] == 0
    assert np.isinf(truth.distance_m[0, nothing]).all()
    assert np.isnan(truth.position_m[0, nothing]).all()
    assert (truth.inverse_distance_per_m[0, nothing] == 0).all()


def test_shares_are_by_name_or_index_and_sum_to_what_is_met(world):
    eye = omma.eye.generate_eye(300)
    renderer = omma.Renderer(world, eye, omma.Fixed(48))
    truth = renderer.ground_truth(POSE, shares=["plane", "ball", "post"])
    assert truth.names == ("plane", "ball", "post")
    assert truth.shares.shape == (1, 300, 3)
    assert_allclose(truth.shares.sum(-1), truth.met, atol=1e-6)
    # Ball and posts have colours of their own: shares are what radiance says.
    assert_allclose(truth.shares[0, :, 1] + 0.4 * truth.shares[0, :, 0], truth.responses[0, :, 0],
                    atol=1e-5)  # fmt: skip
    posts = [k for k, one in enumerate(world.instances) if one.name == "post"]
    each = renderer.ground_truth(POSE, shares=posts)
    assert_allclose(each.shares.sum(-1), truth.shares[..., 2], atol=1e-6)
    assert (each.shares > 0).any(axis=(0, 1)).all()


def test_two_discs_that_fill_as_much_have_the_same_share():
    # Equal solid angles at different distances, weighted by the Gaussian alike; by quadrature.
    width = np.radians(10)
    at = omma.eye.direction([-4, 4], [0, 0])
    scene = solids.merge_scenes(
        [
            solids.disc(
                r * np.tan(np.radians(3)), center_m=r * axis, facing=-axis, segments=512, name=name
            )
            for r, axis, name in ((1, at[0], "near"), (7, at[1], "far"))
        ]
    )
    eye = eye_ahead(acceptance=omma.Acceptance.gaussian(width))
    truth = omma.Renderer(scene, eye, omma.Fixed(1 << 14)).ground_truth(
        np.eye(4), shares=["near", "far"]
    )
    theta, phi = np.meshgrid(
        (np.arange(2000) + 0.5) * np.radians(40) / 2000, (np.arange(720) + 0.5) * np.pi / 360
    )
    weight = np.sin(theta) * np.exp(-4 * np.log(2) * (theta / width) ** 2)
    d = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), -np.cos(theta)], axis=-1
    )
    inside = d @ at[0] > np.cos(np.radians(3))
    expected = (weight * inside).sum() / weight.sum()
    # 16,384 even rays: edges are off by some 1e-3 of the disc.
    assert_allclose(truth.shares[0, 0], [expected, expected], atol=1e-3)


def test_responses_and_errors_are_those_of_render(world):
    eye = omma.eye.generate_eye(200)
    poses = np.stack([POSE, np.eye(4) @ POSE])
    for sampling in (omma.Fixed(4), omma.Fixed(20), omma.ToError(0.05, most=128)):
        one, two = (omma.Renderer(world, eye, sampling, threads=n) for n in (1, 2))
        truth = one.ground_truth(poses, shares=["ball"], head_velocity=HEAD, standard_error=True)
        responses, errors = one.render(poses, standard_error=True)
        assert np.array_equal(truth.responses, responses)
        assert np.array_equal(truth.standard_error, errors)
        assert truth == two.ground_truth(
            poses, shares=["ball"], head_velocity=HEAD, standard_error=True
        )
        plain = one.ground_truth(poses)
        assert np.array_equal(plain.responses, one.render(poses))
        assert plain.flow_rad_s is None
        assert plain.shares is None
        assert (plain.rays is not None) == isinstance(sampling, omma.ToError)


def test_batches_are_single_poses(world):
    eye = omma.eye.generate_eye(100)
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    poses = omma.poses_from_angles([(0, 1, z) for z in range(3)], [(0, 0, 0)])
    heads = (np.arange(9.0).reshape(3, 3), np.ones((3, 3)))
    ball = (np.arange(9.0).reshape(3, 3) - 4, np.zeros(3))
    all_at_once = renderer.ground_truth(poses, head_velocity=heads, velocities={"ball": ball})
    for p in range(3):
        single = renderer.ground_truth(
            poses[p],
            head_velocity=(heads[0][p], heads[1][p]),
            velocities={world.index("ball"): (ball[0][p], ball[1])},
        )
        for name, values in vars(single).items():
            if isinstance(values, np.ndarray):
                assert np.array_equal(getattr(all_at_once, name)[p], values[0], equal_nan=True)


def test_lit_and_baked_worlds_have_the_same_truth(things):
    eye = omma.eye.generate_eye(150)
    sky = omma.light.uniform_sky(1.0, below=0.2, bands=omma.light.Bands.from_edges([400, 500, 600]))
    unlit = omma.World(things)
    lit = unlit.with_light(sky, depth=2)
    baked = unlit.with_light(
        sky, lighting="baked", bake=solids.Bake(cell_m=2, paths=16, cache=False)
    )
    kept = None
    for world in (unlit, lit, baked):
        truth = omma.Renderer(world, eye, omma.Fixed(16)).ground_truth(
            POSE, shares=["ball", "post"], head_velocity=HEAD, velocities={"ball": BALL}
        )
        numbers = {
            one.name: getattr(truth, one.name)
            for one in dataclasses.fields(truth)
            if one.name not in ("responses", "standard_error")
        }
        if kept is None:
            kept = numbers
        for name, values in kept.items():
            assert np.array_equal(values, numbers[name]) or np.array_equal(
                values, numbers[name], equal_nan=True
            ), name


def test_things_that_were_moved_are_where_they_are(things):
    world = omma.World(things)
    renderer = omma.Renderer(world, eye_ahead(), omma.Fixed(1))
    ball = world.index("ball")
    place = np.eye(4)
    place[:3, 3] = (0.2, 1, -6)
    world.set_transforms("ball", place)
    truth = renderer.ground_truth(
        omma.poses_from_angles((0, 1, 0), (0, 0, 0)),
        shares=[ball],
        velocities={ball: ((0, 0, 0), (0, 1, 0))},
    )
    # Met 0.2 m to the left of its middle; there it moves by (0, 1, 0) x (-0.2, 0, ahead).
    ahead = np.sqrt(0.9**2 - 0.2**2)
    assert truth.shares[0, 0, 0] == 1
    assert_allclose(truth.distance_m[0, 0], 6 - ahead, atol=3e-4)
    assert_allclose(truth.flow_objects_rad_s[0, 0], [ahead / (6 - ahead), 0], atol=2e-4)


def test_velocities_of_a_path():
    # Straight and evenly turning: exactly that, whatever the steps.
    times = np.array([0, 0.3, 0.4, 1.0])
    linear, angular = np.array([1.0, -2, 3]), np.array([0.4, 2, -1])
    start = omma.poses_from_angles((1, 2, 3), (30, 20, 10))[0]
    poses = np.stack([moved(start, (linear, angular), t) for t in times])
    found = omma.velocities_from_poses(poses, times)
    assert_allclose(found[0], np.tile(linear, (4, 1)), atol=1e-12)
    assert_allclose(found[1], np.tile(angular, (4, 1)), atol=1e-12)
    # A head that scales moves alike.
    scaled = poses @ np.diag([2, 2, 2, 1.0])
    assert_allclose(omma.velocities_from_poses(scaled, times)[1], found[1], atol=1e-12)
    # Between poses it is SciPy's slerp.
    turns = Rotation.random(3, random_state=2)
    slerp = Slerp([0, 1, 3], turns)
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, :3] = turns.as_matrix()
    after = (slerp(0.5 + 1e-5) * slerp(0.5).inv()).as_rotvec() / 1e-5
    assert_allclose(omma.velocities_from_poses(poses, [0, 1, 3])[1][0], after, rtol=1e-4)


def test_half_a_turn_may_go_either_way():
    still = omma.poses_from_angles((0, 0, 0), [(0, 0, 0), (90, 0, 0), (270, 0, 0), (91, 0, 0)])
    with pytest.warns(UserWarning, match="half a turn from pose 1 to pose 2, which"):
        omma.velocities_from_poses(still, [0, 1, 2, 3])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.velocities_from_poses(still[[0, 1, 3]], [0, 1, 2])
        omma.velocities_from_poses(still[2:], [0, 1])


@pytest.mark.parametrize(
    ("poses", "times", "message"),
    [
        (np.eye(4), [0.0], "poses: expected two or more, found 1"),
        (np.tile(np.eye(4), (2, 1, 1)), [1, 1], "times_s: expected finite times that grow"),
        (np.tile(np.eye(4), (2, 1, 1)), [0, 1, 2], "times_s: expected shape"),
        (np.stack([np.eye(4), np.diag([-1.0, 1, 1, 1])]), [0, 1], "poses: expected a path"),
        (np.stack([np.eye(4), np.diag([0.0, 1, 1, 1])]), [0, 1], "poses: pose 1 flattens"),
    ],
)
def test_paths_that_have_no_velocities(poses, times, message):
    with pytest.raises(omma.Error, match=message):
        omma.velocities_from_poses(poses, times)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"shares": ["bal"]}, omma.Error, "ball"),
        ({"shares": "ball"}, TypeError, "shares: expected a list"),
        ({"shares": [99]}, omma.Error, r"shares\[0\]: expected 0 to 3"),
        ({"shares": ["ball", 1]}, omma.Error, r"shares\[1\]: 1 is there twice"),
        ({"shares": ["post", "post"]}, omma.Error, "is there twice"),
        ({"head_velocity": [0, 0, 1]}, TypeError, "head_velocity: expected a tuple"),
        ({"head_velocity": ((0, 0), (0, 0, 0))}, omma.Error, "head_velocity, linear_m_s"),
        ({"head_velocity": ((0, 0, 0), np.zeros((2, 3)))}, omma.Error, "angular_rad_s: expected"),
        ({"head_velocity": ((np.nan, 0, 0), (0, 0, 0))}, omma.Error, "expected finite"),
        ({"head_velocity": ((1e10, 0, 0), (0, 0, 0))}, omma.Error, r"head\[0\]: expected"),
        ({"velocities": {"post": BALL}}, omma.Error, "post"),
        ({"velocities": {"ball": BALL, 1: BALL}}, omma.Error, "there twice"),
        ({"velocities": {7: BALL}}, omma.Error, "velocities: expected 0 to 3"),
        ({"velocities": [BALL]}, TypeError, "velocities: expected a mapping"),
    ],
)
def test_what_cannot_be_is_refused(things, arguments, error, message):
    renderer = omma.Renderer(things, narrow_eye(10), omma.Fixed(1))
    with pytest.raises(error, match=message):
        renderer.ground_truth(POSE, **arguments)


def test_rays_that_are_shared_have_no_truth(things):
    eye = omma.eye.generate_eye(200)
    renderer = omma.Renderer(things, eye, omma.Shared(4))
    with pytest.raises(omma.Error, match="ground_truth: expected rays of each ommatidium's own"):
        renderer.ground_truth(POSE)


def test_it_is_a_value(things):
    truth = omma.Renderer(things, narrow_eye(10), omma.Fixed(1)).ground_truth(POSE)
    assert isinstance(truth, GroundTruth)
    assert "float32 (1, 10)" in repr(truth)
