"""Ground truth as labelled data sets, which take that of their own poses and eye alone."""

import dataclasses
import pickle

import numpy as np
import pytest

import omma
from omma import scene as solids


@pytest.fixture(scope="module")
def things():
    """Ground and a ball."""
    return solids.merge_scenes(
        [
            solids.plane((60, 60), (0.4, 0.3, 0.1)),
            solids.sphere(0.9, (1, 0, 0), center_m=(0.5, 1, -2), name="ball"),
        ]
    )


def test_dataset_names_units_and_places(things):
    xarray = pytest.importorskip("xarray")
    eye = omma.eye.generate_eye(60)
    renderer = omma.Renderer(things, eye, omma.Fixed(8))
    poses = omma.poses_from_angles([(0, 1, 0), (0, 1, -0.1)], [(0, 0, 0)])
    times_s = [0, 0.01]
    truth = renderer.ground_truth(
        poses, shares=["ball"], head_velocity=omma.velocities_from_poses(poses, times_s)
    )
    data = renderer.dataset(poses, time_s=times_s, truth=truth)
    assert isinstance(data, xarray.Dataset)
    assert np.array_equal(data.response, truth.responses)
    assert data.distance.dims == ("time", "ommatidium")
    assert data.distance.attrs["units"] == "m"
    assert np.array_equal(data.distance, truth.distance_m)
    assert np.array_equal(data.share.sel(instance="ball"), truth.shares[..., 0])
    assert np.array_equal(data.flow.sel(direction="right"), truth.flow_rad_s[..., 0])
    assert data.flow_translation.attrs["units"] == "rad s-1"
    assert data.seen_position.dims == ("time", "ommatidium", "axis")
    plain = renderer.dataset(poses, truth=renderer.ground_truth(poses))
    assert "flow" not in plain
    assert "share" not in plain
    with pytest.raises(omma.Error, match="truth: expected that of 1 poses"):
        renderer.dataset(poses[:1], truth=truth)
    with pytest.raises(omma.Error, match=r"ground_truth\(\.\.\., standard_error=True\)"):
        renderer.dataset(poses, truth=truth, standard_error=True)
    auto = renderer.with_eye(eye, omma.ToError(0.1, most=64))
    found = auto.dataset(poses, truth=auto.ground_truth(poses))
    assert {"rays", "standard_error"} <= set(found)


def test_a_dataset_takes_the_truth_of_its_own_poses_and_eye_alone(things):
    pytest.importorskip("xarray")
    eye = omma.eye.generate_eye(20)
    renderer = omma.Renderer(things, eye, omma.Fixed(2))
    poses = omma.poses_from_angles([(0, 1, 0), (0, 1, -0.1)], [(0, 0, 0)])
    truth = renderer.ground_truth(poses)
    others = omma.poses_from_angles([(0, 1, 0), (0, 1, -0.2)], [(0, 0, 0)])
    with pytest.raises(omma.Error, match=r"these poses, .* pose 1 is at \(0, 1, -0\.2\) m .*-0\.1"):
        renderer.dataset(others, truth=truth)
    turned = omma.poses_from_angles([(0, 1, 0), (0, 1, -0.1)], [(90, 0, 0), (0, 0, 0)])
    with pytest.raises(omma.Error, match=r"pose 0 is .* looking along \(1, "):
        renderer.dataset(turned, truth=truth)
    wider = renderer.with_eye(eye.replace(acceptance_angle_rad=np.full(20, 0.1, np.float32)))
    with pytest.raises(omma.Error, match="this renderer's eye, found that of another eye"):
        wider.dataset(poses, truth=truth)
    bare, red = omma.scene.box(), omma.Background.constant([1, 0, 0])
    for world, what in ((omma.World(bare), "scene"), (omma.World(things, background=red), "back")):
        with pytest.raises(omma.Error, match=f"this renderer's world, .* another {what}"):
            omma.Renderer(world, eye, omma.Fixed(2)).dataset(poses, truth=truth)
    omma.Renderer(things, eye, omma.Fixed(2)).dataset(poses, truth=truth)  # the same scene, anew
    kept = pickle.loads(pickle.dumps(truth))
    assert kept == truth
    omma.Renderer(bare, eye, omma.Fixed(2)).dataset(poses, truth=kept)
    # Poses that were kept in single precision are the same, and so is what was made by hand.
    renderer.dataset(poses.astype(np.float32), truth=truth)
    by_hand = dataclasses.replace(truth, world_from_head=None, eye=None)
    renderer.dataset(others, truth=by_hand)


@pytest.fixture(scope="module")
def moved(things):
    """A renderer, poses, and how the ball moves meanwhile."""
    renderer = omma.Renderer(things, omma.eye.generate_eye(20), omma.Fixed(2))
    path = omma.poses_from_angles([(0.2 * k, 0, 0) for k in range(3)], [(0, 0, 0)])
    transforms = path[:, None]
    moves = {"instances": ["ball"], "transforms": transforms, "times_s": np.array([0, 0.1, 0.2])}
    return renderer, np.stack([np.eye(4)] * 3), moves


def test_a_dataset_of_truth_says_what_truth_was_rendered_with(moved):
    pytest.importorskip("xarray")
    renderer, poses, moves = moved
    truth = renderer.ground_truth(poses, **moves)
    for given in ({}, moves):
        data = renderer.dataset(poses, truth=truth, **given)
        assert data.time.values.tolist() == [0, 0.1, 0.2]
        assert data.thing.values.tolist() == ["ball"]
        assert np.array_equal(data.world_from_thing, moves["transforms"])
    eye, transforms = renderer.eye, moves["transforms"]
    for options, what in (
        ({"seed": 9}, "seed 9, found 0"),
        ({"angular_sensitivity": "pillbox"}, "angular_sensitivity pillbox, found own"),
        ({"sampling": omma.Fixed(4)}, "samples 4, found 2"),
    ):
        with pytest.raises(omma.Error, match=f"truth: .* settings, {what}"):
            renderer.with_eye(eye, **options).dataset(poses, truth=truth)
    with pytest.raises(omma.Error, match=r"transforms: .* of 'ball' at pose 0"):
        renderer.dataset(poses, truth=truth, instances=["ball"], transforms=transforms[::-1])
    with pytest.raises(omma.Error, match=r"instances: expected .*'ball'.*, which truth has moved"):
        renderer.dataset(poses, truth=truth, instances=[0], transforms=transforms)
    with pytest.raises(omma.Error, match=r"time_s: .* pose 1 at 1 s here, 0.1 s there"):
        renderer.dataset(poses, truth=truth, time_s=[0, 1, 2])
    with pytest.raises(omma.Error, match=r"instances: expected .*, which truth has moved"):
        renderer.dataset(
            poses, truth=renderer.ground_truth(poses), instances=["ball"], transforms=transforms
        )


def test_fresh_noise_is_rendered_again_from_the_attributes(moved):
    pytest.importorskip("xarray")
    frozen, poses, _ = moved
    renderer = frozen.with_eye(frozen.eye, noise="new_every_frame")
    renderer.render(np.stack([np.eye(4)] * 7))
    truth = renderer.ground_truth(poses)
    with pytest.raises(omma.Error, match="first_pose: expected 7, as of truth, or None, found 0"):
        renderer.dataset(poses, truth=truth, first_pose=0)
    again = frozen.with_eye(frozen.eye, noise="new_every_frame")
    for data, first in (
        (renderer.dataset(poses, truth=truth), 7),
        (renderer.dataset(poses), 10),
        (renderer.dataset(poses, first_pose=4), 4),
        (renderer.dataset(poses), 13),
    ):
        assert data.attrs["first_pose"] == first
        assert np.array_equal(again.render(poses, first_pose=first), data.response)
    assert "first_pose" not in frozen.dataset(poses).attrs


def test_times_of_a_dataset_are_finite(moved):
    pytest.importorskip("xarray")
    renderer, poses, _ = moved
    with pytest.raises(omma.Error, match="time_s: expected finite numbers"):
        renderer.dataset(poses, time_s=[0, np.nan, 1])
    # As of sequences one after the other.
    assert renderer.dataset(poses, time_s=[0, 1, 0]).time.values.tolist() == [0, 1, 0]


def test_files_of_fresh_noise_say_that_they_begin_with_frame_0(tmp_path):
    xarray = pytest.importorskip("xarray")
    eye, file = omma.eye.generate_eye(20), tmp_path / "out.nc"
    omma.save_eye(tmp_path / "e.csv", eye)
    scene = omma.examples.meadow()
    omma.render_file(
        scene, [file], omma.Fixed(1), eyes=[tmp_path / "e.csv"], noise="new_every_frame"
    )
    with xarray.open_dataset(file) as kept:
        assert kept.attrs["first_pose"] == 0
