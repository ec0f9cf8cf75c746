"""Pose samplers: where poses lie, that they keep clear of things, what is said where not."""

import numpy as np
import pytest
from dataset_jobs import write_job

import omma
from omma.datasets.far_map import FarMap
from omma.datasets.free_space import FreeSpace
from omma.datasets.job_file import load_job
from omma.datasets.samplers import PoseSet, sample_poses
from omma.datasets.walks import walk_poses

CUBE = omma.scene.box((2, 2, 2), center_m=(0, 1, 0), name="cube")
FLOOR = omma.scene.plane((20, 20), name="floor")
ROOF = omma.scene.box((20, 0.1, 20), center_m=(0, 6, 0), name="roof")


@pytest.fixture(scope="module")
def space():
    """A cube of 2 m on a floor, below a roof."""
    return FreeSpace(omma.World(omma.scene.merge_scenes([FLOOR, CUBE, ROOF])))


def outside(place, margin):
    """Whether places are at least so far from the cube, to each of its faces."""
    beside = np.abs(place - [0, 1, 0]) - 1
    distance = np.linalg.norm(np.maximum(beside, 0), axis=1)
    return distance >= margin


def test_uniform_poses_keep_clear_of_a_cube(space):
    poses = PoseSet("a", "uniform", 400, (), low_m=(-2, 0, -2), high_m=(2, 3, 2), clearance_m=0.3)
    place = sample_poses(poses, 1, "s", range(400), space)[:, :3, 3]
    # Rays 18° apart find a plane at 0.3 m where it is nearer than 0.3 cos 13°.
    assert outside(place, 0.3 * np.cos(np.radians(13))).all()
    assert (place[:, 1] >= 0.3 * np.cos(np.radians(13))).all()
    assert np.ptp(place, axis=0).min() > 2.5


def test_nobody_is_inside_of_a_cube(space):
    """Also where the faces, seen from within, are farther than asked for."""
    inside = np.array([[0, 1.0, 0], [0.5, 0.6, 0.5], [3, 1, 0], [0, 3, 0], [0, -1, 0]])
    assert space.is_free(inside, 0.05).tolist() == [False, False, True, True, False]


def test_poses_above_a_surface_through_what_is_above_it(space):
    poses = PoseSet(
        "a", "surface", 300, (), low_m=(-3, -3), high_m=(3, 3), height_m=(0.5, 0.7),
        on=("floor", "cube"), pitch_deg=(-10, 10),
    )  # fmt: skip
    made = sample_poses(poses, 1, "s", range(300), space)
    on_cube = (np.abs(made[:, [0, 2], 3]) < 1).all(axis=1)
    height = made[:, 1, 3] - np.where(on_cube, 2, 0)
    assert 0 < on_cube.sum() < 300
    assert (height > 0.5 - 1e-4).all()
    assert (height < 0.7 + 1e-4).all()
    assert np.degrees(np.abs(np.arcsin(made[:, 1, 2]))).max() == pytest.approx(10, abs=1)
    roof = PoseSet("a", "surface", 5, (), low_m=(-3, -3), high_m=(3, 3), height_m=(1, 1))
    above = sample_poses(roof, 1, "s", range(5), space)[:, 1, 3]
    np.testing.assert_allclose(above, 7.05, atol=1e-4)


def test_a_pose_does_not_depend_on_those_beside_it(space):
    poses = PoseSet("a", "uniform", 50, (), low_m=(-2, 0, -2), high_m=(2, 3, 2), clearance_m=0.2)
    every = sample_poses(poses, 1, "s", range(50), space)
    np.testing.assert_array_equal(sample_poses(poses, 1, "s", range(17, 23), space), every[17:23])
    other = sample_poses(poses, 2, "s", range(50), space)
    assert (other[:, :3, 3] != every[:, :3, 3]).all(axis=1).all()


def test_walks_go_straight_between_saccades_and_keep_clear(space):
    poses = PoseSet(
        "w", "walk", 600, (), low_m=(-3, 0.5, -3), high_m=(3, 3, 3), clearance_m=0.1, steps=200,
        step_s=0.02, speed_m_s=(1.0, 1.0), saccades_per_s=1.0, saccade_deg=(40, 90), saccade_s=0.06,
    )  # fmt: skip
    walks = walk_poses(poses, 3, "s", range(3), space).reshape(3, 200, 4, 4)
    place = walks[..., :3, 3]
    step = np.linalg.norm(np.diff(place, axis=1), axis=2)
    np.testing.assert_allclose(step, 0.02, atol=1e-9)  # 1 m/s
    assert outside(place.reshape(-1, 3), 0.1 * np.cos(np.radians(13))).all()
    turn = np.abs(np.degrees(np.arctan2(-walks[..., 0, 2], walks[..., 2, 2])))
    turned = np.abs((np.diff(turn, axis=1) + 180) % 360 - 180)
    still = np.mean(turned < 1e-9)
    assert 0.4 < still < 0.98  # mostly no turn: saccades of 3 steps, about one a second, and walls
    np.testing.assert_allclose(walks[..., 1, 1], 1, atol=1e-12)  # level
    one = walk_poses(poses, 3, "s", range(2, 3), space)
    np.testing.assert_array_equal(one, walks[2])


def test_no_free_place(tmp_path):
    job = write_job(
        tmp_path,
        poses='[[poses]]\nname = "low"\nsampler = "uniform"\nlow_m = [-1, 0, -1]\n'
        "high_m = [1, 0.1, 1]\nclearance_m = 0.5\ncount = 3\n",
    )
    with pytest.raises(
        omma.Error, match=r"poses 'low': found no free position in scene 'ground' for"
    ):
        omma.datasets.run(job)
    walk = PoseSet(
        "w", "walk", 10, (), low_m=(0, 1, 0), high_m=(0.01, 1, 0.01), steps=10, step_s=1.0,
        speed_m_s=(1.0, 1.0), saccades_per_s=1.0, saccade_s=0.1,
    )  # fmt: skip
    space = FreeSpace(omma.World(omma.Scene()))
    with pytest.raises(omma.Error, match=r"walk 0, step 1.* 64 ways tried"):
        walk_poses(walk, 1, "s", range(1), space)


def test_paths_are_those_of_the_file(tmp_path):
    (tmp_path / "way.csv").write_text(
        "x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n0,1,-1,20,0,0\n"
    )
    job = write_job(tmp_path, poses='[[poses]]\nsampler = "path"\nfile = "way.csv"\n')
    assert load_job(job).poses[0].count == 2
    omma.datasets.run(job)
    views = omma.datasets.open_views(tmp_path / "job.zarr", ["world_from_head"])
    np.testing.assert_array_equal(
        views[:]["world_from_head"], omma.load_poses(tmp_path / "way.csv")
    )


def test_what_the_map_of_the_open_says_is_what_rays_say():
    """In a box about a slanted cube: where the map is sure there is room, and answers are those of
    rays alone, also outside of the box that the map is of."""
    tilt = omma.poses_from_angles((0.3, 1.2, -0.2), (30, 40, 20))[0]
    scene = omma.scene.merge_scenes([FLOOR, omma.scene.place_scene(CUBE, tilt)])
    rng = np.random.default_rng(3)
    low, high = np.array([-3, -0.5, -3]), np.array([3, 4, 3])
    places = rng.uniform(low, high, (3000, 3))
    clear = FarMap(scene, low, high, 0.2).is_far(places)
    assert 0.3 < clear.mean() < 0.9
    mapped, rays = FreeSpace(omma.World(scene)), FreeSpace(omma.World(scene))
    rays._is_mapped = False
    free = rays.is_free(places, 0.2)
    assert free[clear & (places[:, 1] > 0)].all()
    np.testing.assert_array_equal(mapped.is_free(places, 0.2), free)
    assert mapped._maps  # it was asked
    np.testing.assert_array_equal(
        mapped.is_free(3 * places[:500], 0.2), rays.is_free(3 * places[:500], 0.2)
    )
    # Places within a hand's breadth of the cube's faces are none that a map is sure of.
    local = np.linalg.inv(tilt) @ np.append(places, np.ones((3000, 1)), axis=1).T
    beside = np.abs(local[:3].T - [0, 1, 0]) - 1
    near = np.linalg.norm(np.maximum(beside, 0), axis=1) < 0.2
    inner = beside.max(axis=1) < -0.2  # far inside of it: nothing is near there
    assert not clear[near & ~inner].any()
