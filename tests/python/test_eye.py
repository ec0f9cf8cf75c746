"""Eyes: arrays in and out, files, heads of several eyes."""

import numpy as np
import pytest
from conftest import make_eye
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import omma


def test_arrays_are_readonly_views():
    eye = make_eye(7)
    assert len(eye) == 7
    assert eye.position_m.shape == eye.axis.shape == (7, 3)
    assert eye.acceptance_angle_rad.shape == eye.focal_offset_m.shape == eye.eye_id.shape == (7,)
    assert eye.axis.dtype == np.float32
    assert eye.eye_id.dtype == np.int32
    assert np.shares_memory(eye.axis, eye.axis)  # the same memory each time: no copy
    with pytest.raises(ValueError, match="read-only"):
        eye.axis[0] = 0
    axis = eye.axis
    before = axis.copy()
    del eye  # the view keeps the memory alive
    assert (axis == before).all()


def test_axes_are_normalised_and_arrays_accepted():
    eye = omma.Eye([[0, 0, 0], [1, 0, 0]], [[0, 0, -2], [3, 0, 0]], [0.1, 0.2], 1e-5, [0, 4])
    assert eye.axis.tolist() == [[0, 0, -1], [1, 0, 0]]
    assert eye.eye_id.tolist() == [0, 4]
    assert eye.focal_offset_m == pytest.approx([1e-5, 1e-5])
    assert len(eye.select(4)) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([[0, 0, 0]], [[0, 0]], 1), ["axis", "(N, 3)", "(1, 2)"]),
        (([[0, 0, 0]] * 2, [[0, 0, 1]], 1), ["position_m", "(1, 3)", "(2, 3)"]),
        (([[0, 0, 0]], [[0, 0, 1]], [1, 2]), ["acceptance_angle_rad", "(1,)", "(2,)"]),
        (([[0, 0, 0]], [[0, 0, 0]], 1), ["axis", "zero"]),
        (([[0, 0, 0]], [[0, 0, 1]], -1), ["acceptance"]),
        (([[0, 0, 0]], [[0, 0, 1]], 6.3), ["acceptance"]),
        (([[0, 0, float("nan")]], [[0, 0, 1]], 1), ["position"]),
        (([[0, 0, 0]], [["a", 0, 1]], 1), ["axis"]),
        (([[0, 0, 0]], [[0, 0, 1]], 1, 0, [0.5]), ["eye_id", "int32"]),
    ],
)
def test_wrong_arrays_are_errors_that_name_them(arguments, words):
    with pytest.raises(omma.Error) as caught:
        omma.Eye(*arguments)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1), ("um", 1e3), ("m", 1e-3), (1e-2, 0.1)])
def test_units(tmp_path, unit, factor):
    eye = make_eye(5)
    omma.save_eye(tmp_path / "a.eye", eye, unit=unit)
    numbers = np.loadtxt(tmp_path / "a.eye")
    # 6 digits: what float32 positions of a millimetre are worth.
    assert numbers[:, 0] == pytest.approx(eye.position_m[:, 0] * 1e3 * factor, rel=1e-6)
    back = omma.load_eye(tmp_path / "a.eye", unit=unit)
    assert back.position_m == pytest.approx(eye.position_m, rel=1e-6)
    assert back.path == str(tmp_path / "a.eye")


@pytest.mark.parametrize("unit", ["inch", -1, 0, float("nan")])
def test_wrong_unit(files, unit):
    with pytest.raises(omma.Error, match="unit: expected mm, um, m"):
        omma.load_eye(files / "bug.eye", unit=unit)


def test_no_unit(files):
    with pytest.raises(TypeError, match="unit: expected a text or a number, found NoneType"):
        omma.load_eye(files / "bug.eye", unit=None)


direction = arrays(np.float32, 3, elements=st.floats(-1, 1, width=32)).filter(
    lambda v: np.linalg.norm(v) > 0.1
)


@settings(max_examples=30, deadline=None)
@given(st.lists(direction, min_size=1, max_size=8), st.floats(0.001, 6.2))
def test_file_round_trip(tmp_path_factory, axes, acceptance):
    eye = omma.Eye(np.array(axes) * 1e-3, axes, acceptance, 2e-5)
    path = tmp_path_factory.mktemp("eye") / "x.eye"
    omma.save_eye(path, eye)
    back = omma.load_eye(path)
    # Written in decimal, read and normalised again: a few float32 rounding steps.
    assert back.axis == pytest.approx(eye.axis, abs=3e-7)
    assert back.acceptance_angle_rad == pytest.approx(eye.acceptance_angle_rad, rel=1e-6)


def test_merge_moves_eyes_into_the_head():
    one = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1)
    turn = omma.poses_from_angles((1, 2, 3), (90, 0, 0))[0]  # looks along +X
    head = omma.eye.merge_eyes([one, (one, turn)])
    assert head.eye_id.tolist() == [0, 1]
    assert head.position_m.tolist() == [[0, 0, 0], [1, 2, 3]]
    assert head.axis[1] == pytest.approx([1, 0, 0], abs=1e-6)
    assert head.select(1).axis[0] == pytest.approx([1, 0, 0], abs=1e-6)


@pytest.mark.parametrize("eyes", [[], [1], 5, "text", [(1, 2)]])
def test_merge_of_something_else(eyes):
    with pytest.raises(omma.Error, match="eyes: expected"):
        omma.eye.merge_eyes(eyes)


def test_merge_with_a_wrong_transform(eye):
    with pytest.raises(omma.Error, match=r"head_from_eye: expected numbers of shape \(4, 4\)"):
        omma.eye.merge_eyes([(eye, np.eye(3))])
    with pytest.raises(omma.Error):
        omma.eye.merge_eyes([(eye, np.full((4, 4), np.nan))])


def test_select_of_no_such_eye(eye):
    with pytest.raises(omma.Error, match="7"):
        eye.select(7)


def test_interommatidial_angle():
    # Two axes 10 degrees apart: each has the other as its only neighbour.
    angle = np.radians(10)
    eye = omma.Eye(np.zeros((2, 3)), [[0, 0, -1], [np.sin(angle), 0, -np.cos(angle)]], 0.1)
    assert eye.interommatidial_angle_rad() == pytest.approx([angle, angle], rel=1e-5)


def test_repr(eye):
    assert "60 ommatidia" in repr(eye)
    assert "in memory" in repr(make_eye(3))


def test_eyes_without_positions_are_told_that_zeros_will_do():
    with pytest.raises(omma.Error, match=r"shape \(1, 3\), in metres, found None; zeros"):
        omma.Eye(None, [[0, 0, -1]], 0.1)
