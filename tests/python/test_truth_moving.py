"""Ground truth where things move from pose to pose, and renders one pose after the other: beside
worlds that are moved by hand, and optic flow beside differences of places."""

import dataclasses
import json
import warnings

import numpy as np
import pytest
from animated_scenes import Builder, cube, swinging_box
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import omma
from omma import scene as solids
from omma.photoreceptors import ImpulseResponse
from omma.rendering import GroundTruth

POSES = omma.poses_from_angles(
    [(0.1 * k, 1, 0.05 * k) for k in range(6)], [(20 * k, -5, 3 * k) for k in range(6)]
)
TIMES = np.array([0, 0.01, 0.02, 0.04, 0.05, 0.07])
VELOCITY = (np.array([0.5, 0.0, -0.2]), np.array([0.0, 0.4, 0.1]))
# Those that every world has, told how things move.
NOT_HERE = ("names", "rays", "source_distance_m", "camera_distance_m", "camera_angle_deg", "eye")
ARRAYS = [one.name for one in dataclasses.fields(GroundTruth) if one.name not in NOT_HERE]


@pytest.fixture(scope="module", params=["embree", "portable"])
def world(request):
    things = [
        solids.plane((60, 60), (0.4, 0.3, 0.1)),
        solids.sphere(0.9, (1, 0, 0), center_m=(0.5, 1, -2), name="ball"),
        solids.box((0.3, 4, 0.3), (0, 1, 0), center_m=(-1, 2, -3), name="post"),
    ]
    try:
        return omma.World(solids.merge_scenes(things), backend=request.param)
    except omma.Error as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def path(world):
    """The ball goes round, the post turns and comes nearer: (6, 2, 4, 4)."""
    places = np.stack(
        [world.instances[world.index(name)].world_from_node for name in ("ball", "post")]
    )
    moves = omma.poses_from_angles(
        [(0.05 * k, 0.02 * k, 0.1 * k) for k in range(6)], [(10 * k, 0, 4 * k) for k in range(6)]
    )
    return moves[:, None] @ places


def test_a_head_without_a_velocity_goes_as_its_poses_do(world, path):
    renderer = omma.Renderer(world, omma.eye.generate_eye(40), omma.Fixed(4))
    moves = {"instances": ["ball", "post"], "transforms": path, "times_s": TIMES}
    found = renderer.ground_truth(POSES, **moves)
    told = renderer.ground_truth(
        POSES, head_velocity=omma.velocities_from_poses(POSES, TIMES), **moves
    )
    assert np.array_equal(found.flow_rad_s, told.flow_rad_s)
    still = renderer.ground_truth(np.tile(POSES[:1], (6, 1, 1)), **moves)
    assert not still.flow_rotation_rad_s.any()
    assert not still.flow_translation_rad_s.any()
    assert still.flow_objects_rad_s.any()
    # No path: of a single time, of times that do not grow.
    one = {"instances": ["ball", "post"], "transforms": path[:1], "times_s": TIMES[:1]}
    back = moves | {"times_s": TIMES[::-1]}
    for poses, given in ((POSES[:1], one), (POSES, back)):
        assert renderer.ground_truth(poses, **given).flow_rad_s is None


def test_it_is_that_of_a_world_moved_so(world, path):
    eye = omma.eye.generate_eye(80)
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    asked = {"shares": ["ball", "post"], "head_velocity": VELOCITY, "standard_error": True}
    told = {
        name: omma.velocities_from_poses(path[:, k], TIMES)
        for k, name in enumerate(("ball", "post"))
    }
    unseen = [None, ["post"], None, ["ball"], None, None]
    found = renderer.ground_truth(
        POSES,
        instances=["ball", "post"],
        transforms=path,
        times_s=TIMES,
        unseen=unseen,
        first_pose=3,
        **asked,
    )
    alone = omma.World(world.scene, backend=world.backend.split()[0])
    by_hand = omma.Renderer(alone, eye, omma.Fixed(8))
    for p in range(6):
        alone.set_transforms(["ball", "post"], path[p])
        one = by_hand.ground_truth(
            POSES[p],
            velocities={name: (linear[p], angular[p]) for name, (linear, angular) in told.items()},
            first_pose=3 + p,
            unseen=[unseen[p]],
            **asked,
        )
        for name in ARRAYS:
            first, second = getattr(found, name)[p], getattr(one, name)[0]
            assert np.array_equal(first, second, equal_nan=True), (p, name)
    assert (found.shares[1, :, 1] == 0).all(), "who does not see it has no share of it"
    assert found.shares[0, :, 1].max() > 0.1
    assert np.abs(found.flow_objects_rad_s).max() > 0.5


def test_velocities_that_are_told_stand(world, path):
    renderer = omma.Renderer(world, omma.eye.generate_eye(40), omma.Fixed(4))
    moves = {"instances": ["ball", "post"], "transforms": path}
    still = {name: ((0, 0, 0), (0, 0, 0)) for name in ("ball", "post")}
    truth = renderer.ground_truth(POSES, velocities=still, times_s=TIMES, **moves)
    assert not truth.flow_objects_rad_s.any()
    untimed = renderer.ground_truth(POSES, head_velocity=VELOCITY, **moves)
    assert not untimed.flow_objects_rad_s.any(), "without times nothing has a velocity"
    with pytest.raises(omma.Error, match="velocities: expected that of instance 1, as the path"):
        renderer.ground_truth(POSES, head_velocity=VELOCITY, times_s=TIMES[::-1], **moves)


def test_flow_of_what_an_animation_moves(tmp_path):
    """A box that slides and turns: the flow is how the point that is met goes on."""
    made = Builder()
    mesh = made.mesh(*cube(1.0)[::2])
    node = made.node(mesh=mesh, name="box")
    keys = np.linspace(0, 1, 11)
    turns = Rotation.from_rotvec(np.outer(0.8 * keys, (0, 1, 0))).as_quat()
    slides = np.stack([0.5 * keys, 0 * keys, -4 - keys], 1)
    made.animation(
        [(node, "rotation", keys, turns, "LINEAR"), (node, "translation", keys, slides, "LINEAR")],
        "go",
    )
    world = omma.World(omma.load_scene(made.write(tmp_path / "box.gltf")), backend="portable")
    eye = omma.eye.generate_eye(2).replace(
        axis=np.float32([[0, 0, -1]] * 2),
        up=np.float32([[0, 1, 0]] * 2),
        position_m=np.zeros((2, 3)),
        acceptance_angle_rad=np.zeros(2, np.float32),
    )
    renderer = omma.Renderer(world, eye, omma.Fixed(1))
    times = [0.31, 0.77]
    pose = np.stack([np.eye(4)] * 2)
    truth = renderer.ground_truth(pose, head_velocity=((0, 0, 0), (0, 0, 0)), times_s=times)
    for p, time in enumerate(times):
        r = truth.distance_m[p, 0]
        point = np.array([0, 0, -r])
        center = np.array([0.5 * time, 0, -4 - time])
        v = np.array([0.5, 0, -1]) + np.cross((0, 0.8, 0), point - center)
        # Keys are float32, and a moment is 1e-4 s: velocities to some 1e-3.
        assert_allclose(truth.flow_objects_rad_s[p, 0], v[:2] / r, atol=2e-3)
    assert_allclose(world.instances[0].world_from_node, np.eye(4), atol=0, err_msg="nothing moved")


@pytest.mark.parametrize("standard_error", [False, True])
def test_one_pose_after_the_other(world, path, standard_error):
    eye = omma.eye.generate_eye(60)
    moves = {
        "instances": ["ball", "post"],
        "transforms": path,
        "unseen": [None, ["post"], None, None, ["ball"], None],
    }
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    at_once = renderer.render(POSES, standard_error=standard_error, **moves)
    for chunk in (1, 4, None):
        single = renderer.render_iter(POSES, standard_error=standard_error, chunk=chunk, **moves)
        if standard_error:
            for part, found in zip(zip(*single), at_once):
                assert np.array_equal(np.stack(part), found)
        else:
            assert np.array_equal(np.stack(list(single)), at_once)


def test_one_lasting_frame_after_the_other(world, path):
    response = ImpulseResponse.exponential(0.02)
    renderer = omma.Renderer(
        world, omma.eye.generate_eye(60), omma.Fixed(16), impulse_response=response
    )
    moves = {"instances": ["ball", "post"], "transforms": path, "times_s": TIMES}
    at_once = renderer.render(POSES, **moves)
    single = renderer.render_iter(POSES, chunk=2, **moves)
    assert np.array_equal(np.stack(list(single)), at_once)


def test_moves_need_poses_that_are_known(world, path):
    renderer = omma.Renderer(world, omma.eye.generate_eye(20), omma.Fixed(4))
    moves = {"instances": ["ball", "post"], "transforms": path}
    with pytest.raises(TypeError, match="poses: expected an array, as things move"):
        list(renderer.render_iter((pose for pose in POSES), **moves))
    with pytest.raises(omma.Error, match=r"transforms: expected shape \(5, 2, 4, 4\)"):
        list(renderer.render_iter(POSES[:5], **moves))


def test_times_where_nothing_moves_name_what_takes_them(world):
    renderer = omma.Renderer(world, omma.eye.generate_eye(20), omma.Fixed(4))
    with pytest.raises(omma.Error, match=r"times_s: .* found neither.* dataset takes time_s"):
        renderer.render(POSES, times_s=TIMES)
    for poses, times in ((POSES, TIMES[::-1]), (POSES[:1], TIMES[:1])):  # no path
        with pytest.raises(omma.Error, match=r"times_s: expected two or more that grow"):
            renderer.ground_truth(poses, times_s=times)
    with pytest.raises(TypeError, match="'time_s'; did you mean 'times_s'"):
        renderer.ground_truth(POSES, time_s=TIMES)


def test_times_tell_how_a_head_flies_through_a_still_world(world):
    renderer = omma.Renderer(world, omma.eye.generate_eye(60, radius_m=1e-3), omma.Fixed(4))
    velocity = omma.velocities_from_poses(POSES, TIMES)
    told = renderer.ground_truth(POSES, head_velocity=velocity)
    found = renderer.ground_truth(POSES, times_s=TIMES)
    assert_allclose(found.flow_rad_s, told.flow_rad_s, rtol=0, atol=0)
    assert (found.responses == told.responses).all()
    assert np.abs(found.flow_rad_s).max() > 0.1
    unseen = renderer.ground_truth(POSES, times_s=TIMES, unseen=["ball"] * len(POSES))
    assert (unseen.distance_m != found.distance_m).any()
    assert_allclose(unseen.flow_rotation_rad_s, found.flow_rotation_rad_s, atol=1e-6)


def test_a_data_set_takes_the_times_of_a_truth_in_a_still_world(world):
    renderer = omma.Renderer(world, omma.eye.generate_eye(20), omma.Fixed(4))
    truth = renderer.ground_truth(POSES, times_s=TIMES)
    for asked in ({}, {"times_s": TIMES}, {"time_s": TIMES}):
        data = renderer.dataset(POSES, truth=truth, **asked)
        assert_allclose(data.time, TIMES)
        assert_allclose(data.flow, truth.flow_rad_s)


def growing_ball(folder, scales, times):
    """A ball 1 m wide, 3 m ahead, whose scale goes through ``scales`` at ``times``."""
    made = Builder()
    mesh = made.mesh(*cube(0.5)[::2])
    node = made.node(mesh=mesh, name="grower", translation=[0, 0, -3])
    made.animation([(node, "scale", times, scales, "LINEAR")], "grow")
    return omma.load_scene(made.write(folder / "grow.gltf"))


def test_what_grows_is_told_of(world, path):
    """Its flow is 0, as velocities are how things go and turn; that is not silent."""
    renderer = omma.Renderer(world, omma.eye.generate_eye(40), omma.Fixed(4))
    still = np.tile(POSES[:1], (6, 1, 1))
    grown = np.tile(path[:1], (6, 1, 1, 1))
    grown[:, 0, :3, :3] *= np.linspace(1, 1.5, 6)[:, None, None]
    moves = {"instances": ["ball", "post"], "times_s": TIMES}
    with pytest.warns(UserWarning, match="optic flow: 'ball' changes size or shape"):
        truth = renderer.ground_truth(still, transforms=grown, **moves)
    assert not truth.flow_objects_rad_s.any()
    grown[:, 1, 0, 0] *= np.linspace(1, 2, 6)
    with pytest.warns(UserWarning, match="optic flow: 'ball', 'post' change size"):
        renderer.ground_truth(still, transforms=grown, **moves)
    told = {name: VELOCITY for name in ("ball", "post")}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        renderer.ground_truth(still, transforms=grown, velocities=told, **moves)
        # What goes and turns does not, nor what mirrors or is of another shape all along.
        bent = path @ np.diag([-2, 1, 0.5, 1])
        for given in (path, bent, bent.astype(np.float32), path.round(6)):
            renderer.ground_truth(POSES, transforms=given, **moves)


@pytest.mark.parametrize(("rate", "grows"), [(1.0, True), (0.02, True), (0.0, False)])
def test_an_animation_that_grows_is_told_of(tmp_path, rate, grows):
    keys = np.linspace(0, 1, 11)
    scales = np.outer(0.7 + rate * keys, np.ones(3))
    world = omma.World(growing_ball(tmp_path, scales, keys), backend="portable")
    renderer = omma.Renderer(world, omma.eye.generate_eye(40), omma.Fixed(4))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        renderer.ground_truth(np.eye(4), head_velocity=VELOCITY, times_s=[0.37])
    assert [f"{one.message}"[:29] for one in told] == ["optic flow: 'grower' changes "] * grows


def test_datasets_say_where_things_were(world, path, tmp_path):
    xarray = pytest.importorskip("xarray", reason="needs xarray: pip install 'omma[data]'")
    renderer = omma.Renderer(world, omma.eye.generate_eye(20), omma.Fixed(4))
    moves = {"instances": ["ball", "post"], "transforms": path}
    truth = renderer.ground_truth(POSES, **moves)
    timed = renderer.dataset(POSES, time_s=TIMES, **moves)
    for data, first in (
        (renderer.dataset(POSES, **moves), "pose"),
        (renderer.dataset(POSES, truth=truth, **moves), "pose"),
        (timed, "time"),
    ):
        assert data.world_from_thing.dims == (first, "thing", "row", "column")
        assert data.thing.values.tolist() == ["ball", "post"]
        assert data.instance_index.values.tolist() == [1, 2]
        assert np.array_equal(data.world_from_thing, path)
        assert np.array_equal(data.sel(thing="post").world_from_thing, path[:, 1])
    timed.to_netcdf(tmp_path / "moved.nc")
    with xarray.open_dataset(tmp_path / "moved.nc") as kept:
        assert np.array_equal(kept.world_from_thing, path)
    assert "thing" not in renderer.dataset(POSES).dims


def walker(folder):
    """A cube that its only bone carries 1 m to the right in a second, a second cube that a morph
    target moves in the second after, and an eye that sees both."""
    made = Builder()
    positions, _, triangles = cube(0.5)
    count = len(positions)
    bones, all_of_one = np.zeros((count, 4)), np.eye(4)[[0] * count]
    body = made.mesh(
        positions,
        triangles,
        JOINTS_0=made.accessor(bones, "u1"),
        WEIGHTS_0=made.accessor(all_of_one),
    )
    hip = made.node(name="hip", translation=[0, 0, -3])
    made.node(name="body", mesh=body, skin=made.skin([hip]))
    face = made.mesh(positions, triangles, targets=[{"POSITION": positions}])
    smile = made.node(name="face", mesh=face, translation=[0, 2, -3])
    made.animation([(hip, "translation", [0, 1], [[0, 0, -3], [1, 0, -3]], "LINEAR")], "walk")
    made.animation([(smile, "weights", [0, 1, 2], [0, 0, 1], "LINEAR")], "grin")
    scenes = [solids.sphere(0.1, name="ball"), omma.load_scene(made.write(folder / "walker.gltf"))]
    return omma.World(solids.merge_scenes(scenes), backend="portable")


def told_of(call):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        truth = call()
    return truth, [str(one.message) for one in told]


def test_what_bones_and_morph_targets_move_is_told_of(tmp_path):
    """Nothing of it is in the flow, which there is all the same, with the head's."""
    renderer = omma.Renderer(walker(tmp_path), omma.eye.generate_eye(40), omma.Fixed(4))
    heads = omma.poses_from_angles([(0, 0, 0), (0.1, 0, 0)], [(0, 0, 0), (5, 0, 0)])

    def truth(times_s, **options):
        return told_of(lambda: renderer.ground_truth(heads, times_s=times_s, **options))

    found, told = truth([0.2, 0.4])
    head = omma.velocities_from_poses(heads, [0.2, 0.4])
    expected = renderer.ground_truth(heads, head_velocity=head)
    assert np.array_equal(found.flow_rotation_rad_s, expected.flow_rotation_rad_s)
    assert not found.flow_objects_rad_s.any()
    (one,) = told
    assert "'body'" in one
    assert "'face'" not in one, "which is still then"
    for times, options, names in (
        ([0.5, 1.5], {}, ["body", "face"]),
        ([1.2, 1.4], {}, ["face"]),
        ([1.2, 1.4], {"animation": "walk"}, []),
        ([2.5, 3.0], {}, []),
        ([0.2, 0.4], {"velocities": {"body": ((1, 0, 0), (0, 0, 0))}}, []),
    ):
        found, told = truth(times, **options)
        here = [name for name in ("body", "face") if any(repr(name) in one for one in told)]
        assert (here, len(told)) == (names, bool(names))
        assert found.flow_rad_s is not None


def test_jumps_have_no_flow(tmp_path):
    """A box that a STEP key puts 10 cm to the right in the middle of its slide upwards."""
    made = Builder()
    rail = made.node(name="rail")
    node = made.node(rail, mesh=made.mesh(*cube(1.0)[::2]), name="box")
    keys = [0, 0.5]
    jumps = [[0, 0, -4], [0.1, 0, -4]]
    made.animation(
        [
            (node, "translation", keys, jumps, "STEP"),
            (rail, "translation", [0, 1], [[0, 0, 0], [0, 0.2, 0]], "LINEAR"),
        ]
    )
    turned = made.node(mesh=made.mesh(*cube(1.0)[::2]), name="turned", translation=[9, 0, 0])
    made.document["animations"][0]["channels"].append(
        {"sampler": 2, "target": {"node": turned, "path": "rotation"}}
    )
    made.document["animations"][0]["samplers"].append(
        {
            "input": made.accessor(keys),
            "output": made.accessor(np.array([[0, 0, 0, 1], [0, 1, 0, 0]])),
            "interpolation": "STEP",
        }
    )
    world = omma.World(omma.load_scene(made.write(tmp_path / "jump.gltf")), backend="portable")
    eye = omma.Eye([(0, 0, 0)], [(0, 0, -1)], 0.0)
    renderer = omma.Renderer(world, eye, omma.Fixed(1))
    times = np.array([0.3, 0.49995, 0.5, 0.50005, 0.7])
    truth = renderer.ground_truth(np.tile(np.eye(4), (5, 1, 1)), times_s=times)
    assert_allclose(truth.flow_objects_rad_s[:, 0], [[0, 0.2 / 3]] * 5, atol=1e-4)
    aside = omma.poses_from_angles([(9, 0, 4)] * 5, [(0, 0, 0)] * 5)
    assert not renderer.ground_truth(aside, times_s=times).flow_objects_rad_s.any()


def test_datasets_say_which_animation_moved_the_scene(tmp_path):
    pytest.importorskip("xarray", reason="needs xarray: pip install 'omma[data]'")
    scene = swinging_box(tmp_path / "box.gltf")
    world = omma.World(scene, backend="portable")
    renderer = omma.Renderer(world, omma.eye.generate_eye(20), omma.Fixed(4))
    plain = renderer.dataset(POSES).attrs
    assert not {"at_time_s", "at_animation", "animation", "unseen", "unseen_by_light"} & set(plain)
    timed = renderer.dataset(POSES, times_s=TIMES, animation=0)
    assert timed.attrs["animation"] == "swing"
    world.at(0.5)
    moved = renderer.dataset(POSES)
    assert moved.attrs["at_time_s"] == 0.5
    assert "at_animation" not in moved.attrs
    world.at(0.75, "swing")
    truth = renderer.ground_truth(POSES)
    world.at(0.25)
    other = renderer.dataset(POSES, truth=truth)
    again = omma.Renderer(omma.World(scene, backend="portable"), renderer.eye, omma.Fixed(4))
    again.world.at(other.attrs["at_time_s"], other.attrs["at_animation"])
    assert np.array_equal(other.response, again.render(POSES))
    told = renderer.ground_truth(POSES, times_s=TIMES, animation="swing")
    assert renderer.dataset(POSES, truth=told, animation=0).attrs["animation"] == "swing"
    with pytest.raises(omma.Error, match="animation: expected that of truth"):
        renderer.dataset(POSES, truth=truth, animation="swing")


def test_datasets_say_what_was_unseen(world, tmp_path):
    xarray = pytest.importorskip("xarray", reason="needs xarray: pip install 'omma[data]'")
    renderer = omma.Renderer(world, omma.eye.generate_eye(20), omma.Fixed(4))
    unseen = [None, "ball", ["ball", "post"], [], "ball", 2]
    moves = {"unseen": unseen, "unseen_by_light": True}
    truth = renderer.ground_truth(POSES, **moves)
    for given in ({}, {"truth": truth}):
        renderer.dataset(POSES, **given, **moves).to_netcdf(tmp_path / "unseen.nc")
        with xarray.open_dataset(tmp_path / "unseen.nc") as kept:
            groups = json.loads(kept.attrs["unseen"])
            by_pose = [groups[one] if one >= 0 else None for one in kept.unseen_group.values]
            assert by_pose == [None, [1], [1, 2], None, [1], [2]]
            by_light = bool(kept.attrs["unseen_by_light"])
            again = renderer.render(POSES, unseen=by_pose, unseen_by_light=by_light)
            assert np.array_equal(kept.response, again)
    alone = renderer.dataset(POSES, truth=truth, unseen_by_light=True)
    assert alone.attrs["unseen"] == json.dumps(groups)
    with pytest.raises(omma.Error, match="unseen: expected that of truth"):
        renderer.dataset(POSES, truth=truth, unseen=[None] * 6)
    with pytest.raises(omma.Error, match="unseen_by_light: expected True, as of truth"):
        renderer.dataset(POSES, truth=truth, unseen_by_light=False)
    assert "unseen_group" not in renderer.dataset(POSES)


def test_names_that_nothing_has_name_their_argument(world):
    renderer = omma.Renderer(world, omma.eye.generate_eye(5), omma.Fixed(1))
    for name, value in (("shares", ["bal"]), ("velocities", {"bal": VELOCITY})):
        with pytest.raises(omma.Error, match=rf"^{name}.*: expected the name .*'bal'.*'ball'"):
            renderer.ground_truth(np.eye(4), **{name: value})
