"""Poses in all their forms, and CSV files of them."""

import re
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omma

angle = st.floats(-180, 180)


@settings(max_examples=50, deadline=None)
@given(st.tuples(angle, angle, angle))
def test_angles_make_rigid_poses(angles):
    pose = omma.poses_from_angles((1, 2, 3), angles)[0]
    rotation = pose[:3, :3]
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)
    assert pose[:3, 3].tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("angles", "view", "up"),
    [
        ((0, 0, 0), (0, 0, -1), (0, 1, 0)),
        ((90, 0, 0), (1, 0, 0), (0, 1, 0)),  # to the right
        ((0, 90, 0), (0, 1, 0), (0, 0, 1)),  # up
        ((0, 0, 90), (0, 0, -1), (1, 0, 0)),  # the right side down, so up goes right
        ((90, 90, 0), (0, 1, 0), (-1, 0, 0)),
    ],
)
def test_what_angles_mean(angles, view, up):
    rotation = omma.poses_from_angles((0, 0, 0), angles)[0, :3, :3]
    assert rotation @ [0, 0, -1] == pytest.approx(view, abs=1e-12)
    assert rotation @ [0, 1, 0] == pytest.approx(up, abs=1e-12)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.01),
    st.lists(st.floats(-1, 1), min_size=3, max_size=3),
)
def test_quaternions_turn_as_hamilton_says(quaternion, vector):
    x, y, z, w = unit = np.array(quaternion) / np.linalg.norm(quaternion)
    rotation = omma.poses_from_quaternions((0, 0, 0), unit)[0, :3, :3]
    axis, v = np.array([x, y, z]), np.array(vector)
    # v' = v + 2 w (q x v) + 2 q x (q x v)
    turned = v + 2 * w * np.cross(axis, v) + 2 * np.cross(axis, np.cross(axis, v))
    assert rotation @ v == pytest.approx(turned, abs=1e-12)


def test_look_at():
    pose = omma.look_at((1, 2, 3), (1, 2, -7))
    assert pose == pytest.approx(omma.poses_from_angles((1, 2, 3), (0, 0, 0))[0])
    with pytest.raises(omma.Error, match="target"):
        omma.look_at((1, 2, 3), (1, 2, 3))
    for side in (1, -1):
        view = f"up=(0, 0, {side}), or poses_from_angles(position_m, (0, {90 * side}, 0))[0]"
        with pytest.raises(omma.Error, match=re.escape(view)):
            omma.look_at((0, 2, 0), (0, 2 + side, 0))
        steep = omma.poses_from_angles((0, 2, 0), (0, 90 * side, 0))[0]
        assert omma.look_at((0, 2, 0), (0, 2 + side, 0), up=(0, 0, side)) == pytest.approx(steep)
    with pytest.raises(omma.Error, match=r"up: expected.*\[1, 0, 0\] along it.*up=\(0, 1, 0\)"):
        omma.look_at((0, 0, 0), (5, 0, 0), (1, 0, 0))
    with pytest.raises(omma.Error, match="up must not be zero"):
        omma.look_at((0, 0, 0), (0, 1, 0), (0, 0, 0))
    with pytest.raises(omma.Error, match=r"target_m: expected numbers of shape \(3,\)"):
        omma.look_at((0, 0, 0), (0, 1))


def test_csv(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text(
        "# a flight\nx, y, z, qx, qy, qz, qw\n\n1,2,3,0,0,0,1 # first\r\n4,5,6,0,0.71,0,0.71\n"
    )
    poses = omma.load_poses(path)
    assert poses.shape == (2, 4, 4)
    assert poses[0, :3, 3].tolist() == [1, 2, 3]
    assert poses[1, :3, :3] @ [0, 0, -1] == pytest.approx([-1, 0, 0])
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n1,2,3,10,20,30")
    assert omma.load_poses(path) == pytest.approx(omma.poses_from_angles((1, 2, 3), (10, 20, 30)))


def test_quaternions_of_another_length_are_told_of(tmp_path):
    """With the line, or the row; of three digits they are rounded."""
    path = tmp_path / "poses.csv"
    rows = [(0, 0, 0, 2), (0.707, 0, 0, 0.707), (0.2, 0, 0, 1)]
    lines = [",".join(map(str, (0, 0, 0, *row))) for row in rows]
    path.write_text("\n".join(["x,y,z,qx,qy,qz,qw", lines[1], "", lines[0], lines[2]]))
    words = r"poses\.csv, line 4: expected a quaternion of length 1, found .* 2, and in 1 more"
    with pytest.warns(UserWarning, match=words) as told:
        poses = omma.load_poses(path)
    assert len(told) == 1
    with pytest.warns(UserWarning, match="quaternions, row 2: .* found one of length 1.02") as told:
        again = omma.poses_from_quaternions((0, 0, 0), np.array(rows)[[1, 1, 2]])
    assert len(told) == 1
    np.testing.assert_array_equal(again[[0, 2]], poses[[0, 2]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.poses_from_quaternions((0, 0, 0), rows[1])


HEADER = "x,y,z,yaw_deg,pitch_deg,roll_deg\n"


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "holds no pose"),
        (HEADER, "holds no pose"),
        ("1,2,3,0,0,0\n", ", line 1: expected a header line"),
        ("x,y,z\n", ", line 1: expected a header line"),
        (
            "t_ms,x,y,z,yaw,pitch,roll\n",
            "columns are in seconds, metres and degrees: t_s for t_ms, yaw_deg for yaw, ",
        ),
        (
            "timestamp,x,y,z,heading_deg,pitch_deg,roll_deg\n",
            "degrees: t_s for timestamp, yaw_deg for heading_deg",
        ),
        ("t_s,time,x,y,z,qx,qy,qz,qw,theta\n", "found 't_s,time,x,y,z,qx,qy,qz,qw,theta'$"),
        (HEADER + "1,2,3,0,0,0\n1,2,3\n", ", line 3: expected 6 numbers.*found 3"),
        (
            HEADER + "1,2,3,0,0,zero\n",
            ", line 2, column roll_deg: expected a finite number.*'zero'",
        ),
        (HEADER + "1,nan,3,0,0,0\n", ", line 2, column y: expected a finite number"),
        (HEADER + "1,,3,0,0,0\n", ", line 2, column y"),
        ("x,y,z,qx,qy,qz,qw\n1,2,3,0,0,0,0\n", ", line 2: the quaternion has length 0"),
    ],
)
def test_wrong_csv(tmp_path, text, word):
    path = tmp_path / "poses.csv"
    path.write_text(text)
    with pytest.raises(omma.Error, match="poses.csv.*" + word):
        omma.load_poses(path)


def test_csv_that_cannot_be_read(tmp_path):
    with pytest.raises(omma.Error, match=r"missing\.csv: there is no such file"):
        omma.load_poses(tmp_path / "missing.csv")
    with pytest.raises(omma.Error, match="is a directory, expected a file"):
        omma.load_poses(tmp_path)
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    with pytest.raises(omma.Error, match="line 2: expected UTF-8 text"):
        omma.load_poses(tmp_path / "binary.csv")


@pytest.mark.parametrize(
    ("poses", "found"),
    [
        (np.eye(4).astype(str), "texts"),
        (np.eye(4).astype("S"), "texts"),
        (np.eye(4) + 0j, "complex numbers"),
        (np.eye(4, dtype=bool), "True or False"),
        (np.eye(4).astype(object), "objects"),
        (np.eye(4).astype("m8[s]"), "durations"),
        (["bee", "bee"], "texts, of which a renderer takes one, a camera's name"),
        ([[1, 2], [3]], "rows of different lengths"),
    ],
)
def test_what_is_no_array_of_numbers_is_no_pose(poses, found):
    renderer = omma.Renderer(omma.Scene(), omma.eye.generate_eye(10), omma.Fixed(1))
    with pytest.raises(omma.Error, match=f"poses: expected .* world_from_head, found {found}"):
        renderer.render(poses)


def test_a_camera_for_a_pose_is_told_of_its_pose_and_its_name():
    scene = omma.load_scene(omma.examples.meadow())
    renderer = omma.Renderer(omma.Scene(), omma.eye.generate_eye(10), omma.Fixed(1))
    camera = scene.cameras[0]
    with pytest.raises(omma.Error, match=rf"\.world_from_camera is one, .* name, '{camera.name}'"):
        renderer.render(camera)
