"""Eyes rescaled, split, given other acceptance angles, read from old files."""

from functools import partial

import numpy as np
import pytest
from conftest import DATA, make_eye

import omma

EYES = DATA / "compound-ray" / "scenes" / "eyes"


@pytest.fixture
def offset_eye():
    """60 ommatidia on a sphere of 1 mm, with focal offsets."""
    eye = make_eye(60)
    return omma.Eye(eye.position_m, eye.axis, 0.1, np.linspace(1e-4, 2e-4, 60), 3)


def real(name):
    if not DATA.is_dir():
        pytest.skip("needs the scenes and eyes of CompoundRay in ../shared/data")
    return omma.load_eye(DATA / "compound-ray" / name)


def test_rescale_by_a_factor(offset_eye):
    large = omma.eye.rescale_eye(offset_eye, 2.5)
    assert large.position_m == pytest.approx(2.5 * offset_eye.position_m, rel=1e-6)
    assert large.focal_offset_m == pytest.approx(2.5 * offset_eye.focal_offset_m, rel=1e-6)
    assert (large.axis == offset_eye.axis).all()
    assert (large.acceptance_angle_rad == offset_eye.acceptance_angle_rad).all()
    assert (large.eye_id == 3).all()


def test_rescale_to_a_mean_radius(offset_eye):
    changed = omma.eye.rescale_eye(offset_eye, mean_radius_m=0.2e-3)
    radius = np.linalg.norm(changed.position_m, axis=1)
    assert radius.mean() == pytest.approx(0.2e-3, rel=1e-6)
    assert changed.focal_offset_m == pytest.approx(0.2 * offset_eye.focal_offset_m, rel=1e-5)


def test_rescaled_as_compoundray_did():
    """Its eyes of mean radius 0.1 and 0.2 are one another, rescaled."""
    small = real("scenes/eyes/test1000-horizontallyAcute-2.6degrees-avgRadius-0.1.eye")
    large = real("scenes/eyes/test1000-horizontallyAcute-2.6degrees-avgRadius-0.2.eye")
    again = omma.eye.rescale_eye(large, mean_radius_m=0.1e-3)
    assert again.position_m == pytest.approx(small.position_m, abs=1e-10)  # float, at 1e-4 m


@pytest.fixture
def rich_eye():
    """40 ommatidia with everything an eye can have, all different."""
    eye = make_eye(40)
    rest = np.random.default_rng(1)
    types = [
        omma.receptors.ReceptorType("green", peak_wavelength_nm=544),
        omma.receptors.ReceptorType("uv", peak_wavelength_nm=344, microvillus_angle_rad=0.3),
    ]
    return omma.Eye(
        eye.position_m,
        eye.axis,
        None,
        rest.uniform(1e-5, 2e-5, 40),
        np.arange(40) % 2 + 3,
        up=rest.standard_normal((40, 3)),
        facet_diameter_m=rest.uniform(1e-5, 3e-5, 40),
        aperture_diameter_m=rest.uniform(1e-5, 3e-5, 40),
        acceptance=[omma.Acceptance.gaussian(0.05, 0.03, 0.01 * i) for i in range(40)],
        receptor_types=types,
        receptors=[[0], [1, 0]] * 20,
        columns={"number": np.arange(40.0), "name": [f"o{i}" for i in range(40)]},
    )


def kept(before, after, order=None, *, but=()):
    """Whether ommatidia have what they had: those of ``before`` in this order."""
    before = before if order is None else before.take(order)
    for name in ("axis", "up", "position_m", "focal_offset_m", "facet_diameter_m", "eye_id",
                 "aperture_diameter_m", "first_receptor", "receptor_type"):  # fmt: skip
        if name not in but:
            assert (getattr(before, name) == getattr(after, name)).all(), name
    if "acceptance" not in but:
        for i in range(len(before)):
            assert before.acceptance(i) == after.acceptance(i)
    assert after.receptor_types == before.receptor_types
    assert (after.columns["number"] == before.columns["number"]).all()
    assert after.columns["name"] == before.columns["name"]
    return True


def test_every_tool_keeps_what_it_does_not_change(rich_eye):
    large = omma.eye.rescale_eye(rich_eye, 2)
    lengths = ("position_m", "focal_offset_m", "facet_diameter_m", "aperture_diameter_m")
    assert kept(rich_eye, large, but=lengths)
    for name in lengths:
        assert getattr(large, name) == pytest.approx(2 * getattr(rich_eye, name), rel=1e-6)
    x = rich_eye.position_m[:, 0]
    order = np.concatenate([np.flatnonzero(x < 0), np.flatnonzero(x >= 0)])
    assert kept(rich_eye, omma.eye.split_eye(rich_eye), order, but=["eye_id"])
    changed = omma.eye.set_acceptance(rich_eye, angle_rad=0.1)
    assert kept(rich_eye, changed, but=["acceptance"])
    assert changed.acceptance(3) == omma.Acceptance.gaussian(np.float32(0.1))
    assert kept(rich_eye, omma.eye.place_on_head(rich_eye, (1e-3, 0, 0)), but=["position_m"])
    joined = omma.eye.join_eyes([rich_eye])
    order = np.concatenate([np.arange(0, 40, 2), np.arange(1, 40, 2)])
    assert kept(rich_eye, joined, order, but=["eye_id"])
    assert joined.eye_id.tolist() == [0] * 20 + [1] * 20


def test_mirroring_turns_what_is_not_round(rich_eye):
    image = omma.eye.mirror_eye(rich_eye)
    flip = np.array([-1, 1, 1])
    assert image.position_m == pytest.approx(rich_eye.position_m * flip)
    assert image.axis == pytest.approx(rich_eye.axis * flip, abs=1e-6)
    assert image.up == pytest.approx(rich_eye.up * flip, abs=1e-6)
    assert (image.eye_id == rich_eye.eye_id).all()
    # A direction and its mirror image are seen alike: azimuths turn over.
    for i in (0, 7, 33):
        assert image.acceptance(i).eval(0.02, -0.7) == pytest.approx(
            rich_eye.acceptance(i).eval(0.02, 0.7)
        )
    assert image.acceptance(7) != rich_eye.acceptance(7)
    twice = omma.eye.mirror_eye(image)
    assert twice.position_m == pytest.approx(rich_eye.position_m)
    assert all(twice.acceptance(i).eval(0.02, 1.0) == pytest.approx(
        rich_eye.acceptance(i).eval(0.02, 1.0)) for i in range(40))  # fmt: skip


def test_a_pair_is_left_then_right():
    right = make_eye(30)
    right = right.replace(position_m=right.position_m + np.float32([2e-3, 0, 0]))
    head = omma.eye.pair_of_eyes(right)
    assert head.eye_id.tolist() == [0] * 30 + [1] * 30
    assert (head.select(1).position_m == right.position_m).all()
    assert head.select(0).position_m[:, 0] == pytest.approx(-right.position_m[:, 0])
    assert head.select(0).position_m[:, 0].max() < 0


@pytest.mark.parametrize("where", ["on a head", "in its own frame", "at a point"])
def test_a_left_eye_is_the_left_one_of_its_pair(where):
    window = omma.eye.window((-160, -15), (-80, 80))
    left = omma.eye.generate_eye(60, radius_m=1e-3)
    left = left.take(np.flatnonzero(window(left.axis.astype(float))))
    position = left.position_m - left.position_m.mean(axis=0)
    place = {"on a head": position - [1e-3, 0, 0], "at a point": 0 * position}
    left = left.replace(position_m=place.get(where, position))
    head = omma.eye.pair_of_eyes(left)
    assert head.eye_id.tolist() == [0] * len(left) + [1] * len(left)
    assert head.select(0) == left.replace(eye_id=0)
    assert head.select(1).replace(eye_id=0) == omma.eye.mirror_eye(left)
    # The same head by its right eye.
    right = omma.eye.mirror_eye(left)
    again = omma.eye.pair_of_eyes(right)
    assert again.select(1).replace(eye_id=0) == right
    assert (again.position_m == head.position_m).all()
    with pytest.warns(DeprecationWarning, match="right: is called eye now"):
        assert omma.eye.pair_of_eyes(right=right) == again


def test_an_eye_that_looks_across_the_head_is_told():
    ahead = omma.Eye([[1e-3, 0, 0]], [[-0.6, 0, -0.8]], 0.1)
    with pytest.warns(UserWarning, match="sits on the right and looks to the left"):
        head = omma.eye.pair_of_eyes(ahead)
    assert (head.select(1).position_m == ahead.position_m).all()


def test_a_head_of_both_sides_makes_no_pair():
    head = omma.eye.pair_of_eyes(omma.eye.place_on_head(make_eye(30), (2e-3, 0, 0)))
    with pytest.raises(omma.Error, match="eye_id 0 on the left and 1 on the right"):
        omma.eye.pair_of_eyes(head)
    assert len(omma.eye.pair_of_eyes(head.select(0))) == 60
    # Two parts of one side are one eye there.
    parts = head.select(1).replace(eye_id=np.arange(30) % 2)
    assert omma.eye.pair_of_eyes(parts).eye_id.tolist() == [0] * 30 + [1] * 30


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda eye: omma.eye.set_acceptance(eye, angle_rad=2.6), "acceptance_angle_rad"),
        (lambda eye: omma.eye.set_acceptance(eye, factor=57.3), "acceptance_angle_rad"),
        (lambda eye: omma.eye.place_on_head(eye, (1, 2, 3)), "position_m: 3.742 m"),
        (lambda eye: omma.eye.split_eye(eye, 3.0), "shift_m: 3 m .* 3 mm"),
        (lambda eye: omma.eye.rescale_eye(eye, 1000), "position_m"),
    ],
)
def test_changes_tell_of_numbers_that_no_animal_has(change, told):
    eye = make_eye(30).replace(acceptance_angle_rad=0.05)
    with pytest.warns(UserWarning, match=told) as caught:
        changed = change(eye)
    assert len(caught) == 1
    # What the eye had before is not told again.
    omma.eye.place_on_head(changed, yaw_deg=0)


def test_placed_as_a_pose_says():
    ahead = omma.Eye([[0, 0, -1e-3]], [[0, 0, -1]], 0.1, up=[[0, 1, 0]])
    right = omma.eye.place_on_head(ahead, (0, 2e-3, 0), yaw_deg=90)
    assert right.axis[0] == pytest.approx([1, 0, 0], abs=1e-6)
    assert right.position_m[0] == pytest.approx([1e-3, 2e-3, 0], abs=1e-9)
    assert omma.eye.place_on_head(ahead, pitch_deg=90).axis[0] == pytest.approx([0, 1, 0], abs=1e-6)
    rolled = omma.eye.place_on_head(ahead, roll_deg=90)
    assert rolled.up[0] == pytest.approx([1, 0, 0], abs=1e-6)
    with pytest.raises(omma.Error, match="nan"):
        omma.eye.place_on_head(ahead, (0, np.nan, 0))
    with pytest.raises(omma.Error, match="at least one"):
        omma.eye.join_eyes([])


def test_joined_heads_keep_their_eyes_apart():
    head = omma.eye.pair_of_eyes(make_eye(20))
    assert omma.eye.join_eyes([head, make_eye(5)]).eye_id.tolist() == [0] * 20 + [1] * 20 + [2] * 5


def test_split_by_side(offset_eye):
    both = omma.eye.split_eye(offset_eye, shift_m=2e-3)
    left, right = both.select(0), both.select(1)
    x = offset_eye.position_m[:, 0]
    assert len(left) == np.sum(x < 0)
    assert len(right) == np.sum(x >= 0)
    assert left.position_m[:, 0] == pytest.approx(x[x < 0] - 2e-3, abs=1e-9)
    assert right.position_m[:, 0] == pytest.approx(x[x >= 0] + 2e-3, abs=1e-9)
    assert (left.position_m[:, 1:] == offset_eye.position_m[x < 0, 1:]).all()
    assert (right.axis == offset_eye.axis[x >= 0]).all()
    assert (left.focal_offset_m == offset_eye.focal_offset_m[x < 0]).all()
    assert (both.eye_id[: len(left)] == 0).all()


def test_split_with_overlap_and_a_middle():
    x = np.array([-2, -0.5, 0, 0.5, 2]) * 1e-3
    eye = omma.Eye(np.stack([x, 0 * x, 0 * x], axis=1), [[0, 0, -1]] * 5, 0.1)
    plain = omma.eye.split_eye(eye)
    assert plain.select(0).position_m[:, 0] * 1e3 == pytest.approx([-2, -0.5])
    assert plain.select(1).position_m[:, 0] * 1e3 == pytest.approx([0, 0.5, 2])  # none is lost
    wide = omma.eye.split_eye(eye, overlap_m=1e-3)
    assert wide.select(0).position_m[:, 0] * 1e3 == pytest.approx([-2, -0.5, 0, 0.5])
    assert wide.select(1).position_m[:, 0] * 1e3 == pytest.approx([-0.5, 0, 0.5, 2])


def test_a_bee_has_two_like_halves():
    both = omma.eye.split_eye(real("bees/AM_60185-real.eye"))
    assert (len(both.select(0)), len(both.select(1))) == (3187, 3187)


def test_acceptance_constant_scaled_and_from_the_spacing():
    eye = make_eye(60, acceptance_deg=5)
    assert omma.eye.set_acceptance(eye, angle_rad=0.2).acceptance_angle_rad == pytest.approx(0.2)
    scaled = omma.eye.set_acceptance(eye, factor=1.5)
    assert scaled.acceptance_angle_rad == pytest.approx(1.5 * eye.acceptance_angle_rad, rel=1e-6)
    ratio = omma.eye.set_acceptance(eye, ratio=0.8)
    expected = 0.8 * eye.interommatidial_angle_rad()
    assert ratio.acceptance_angle_rad == pytest.approx(expected, rel=1e-6)
    assert (ratio.position_m == eye.position_m).all()


def angles_between(eye):
    axis = eye.axis.astype(float)
    angle = np.arccos(np.clip(axis @ axis.T, -1, 1))
    np.fill_diagonal(angle, np.inf)
    return angle


def test_non_overlapping_cones_touch_at_most():
    eye = make_eye(700)  # more than one block of the search
    cone = omma.eye.set_acceptance(eye, non_overlapping=True).acceptance_angle_rad.astype(float)
    angle = angles_between(eye)
    # The arc cosine of a float axis is good to some 1e-5 at the least angle here, 0.002.
    assert cone == pytest.approx(angle.min(axis=1), abs=1e-4)
    gap = angle - (cone[:, None] + cone) / 2
    assert gap.min() == pytest.approx(0, abs=1e-4)  # none overlap; the nearest pairs touch


def test_compoundray_maximal_is_its_rule():
    """Its eye of variable acceptance was made with it."""
    eye = real("scenes/eyes/1000-horizontallyAcute-variableDegree.eye")
    ours = omma.eye.set_acceptance(eye, compoundray_maximal=True)
    # Six digits of axes of some 0.05 rad apart.
    assert ours.acceptance_angle_rad == pytest.approx(eye.acceptance_angle_rad, rel=1e-4)
    narrow = omma.eye.set_acceptance(eye, non_overlapping=True).acceptance_angle_rad
    assert (ours.acceptance_angle_rad >= narrow * (1 - 1e-6)).all()
    assert ours.acceptance_angle_rad.max() > 1.5 * narrow.max()


def test_neighbours_are_those_of_the_same_eye():
    eye = make_eye(50)
    head = omma.eye.merge_eyes([eye, eye])
    for rule in ("non_overlapping", "compoundray_maximal"):
        alone = omma.eye.set_acceptance(eye, **{rule: True}).acceptance_angle_rad
        both = omma.eye.set_acceptance(head, **{rule: True}).acceptance_angle_rad
        assert both == pytest.approx(np.tile(alone, 2))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda eye: omma.eye.rescale_eye(eye), ["factor", "mean_radius_m"]),
        (lambda eye: omma.eye.rescale_eye(eye, 2, mean_radius_m=1), ["factor", "mean_radius_m"]),
        (lambda eye: omma.eye.rescale_eye(eye, -1), ["factor", "-1"]),
        (lambda eye: omma.eye.rescale_eye(eye, mean_radius_m=0), ["mean_radius_m", "0"]),
        (lambda eye: omma.eye.split_eye(eye, overlap_m=-1), ["overlap_m", "-1"]),
        (lambda eye: omma.eye.split_eye(eye, shift_m=np.nan), ["shift_m", "nan"]),
        (lambda eye: omma.eye.set_acceptance(eye), ["exactly one"]),
        (lambda eye: omma.eye.set_acceptance(eye, ratio=1, factor=1), ["exactly one"]),
        (lambda eye: omma.eye.set_acceptance(eye, angle_rad=7), ["acceptance", "7"]),
        (lambda eye: omma.eye.set_acceptance(eye, ratio=0), ["ratio", "0"]),
        (lambda eye: omma.eye.set_acceptance(eye, factor=-2), ["factor", "-2"]),
    ],
)
def test_wrong_arguments_are_named(call, words):
    with pytest.raises(omma.Error) as caught:
        call(make_eye(20))
    for word in words:
        assert word in str(caught.value)


def test_eyes_that_cannot_be_changed_so():
    point = omma.Eye([[0, 0, 0]] * 2, [[0, 0, -1]] * 2, 0.1)
    with pytest.raises(omma.Error, match="origin"):
        omma.eye.rescale_eye(point, mean_radius_m=1)
    with pytest.raises(omma.Error, match="no ommatidium sits on the left"):
        omma.eye.split_eye(point)
    for rule in ({"ratio": 1.0}, {"non_overlapping": True}, {"compoundray_maximal": True}):
        with pytest.raises(omma.Error, match="ommatidium 0"):
            omma.eye.set_acceptance(point, **rule)


# position (mm), axis (z ahead), acceptance (rad), offset (mm), and what nobody remembers
OLD = ["1 2 3 0 0 1 0.05 0.01 7", "-1 2 3 0 1 0 0.06 0.02 8"]


def old_file(folder, columns, lines=OLD):
    path = folder / "old.eye"
    path.write_text("# an old eye\n" + "\n".join(" ".join(x.split()[:columns]) for x in lines))
    return path


@pytest.mark.parametrize("columns", [7, 8, 9])
def test_old_files_of_any_age(tmp_path, columns):
    converted = omma.eye.convert_eye(old_file(tmp_path, columns))
    eye = converted.eye
    assert converted.columns == columns
    assert eye.position_m * 1e3 == pytest.approx(np.array([[1, 2, -3], [-1, 2, -3]]))
    assert eye.axis == pytest.approx(np.array([[0, 0, -1], [0, 1, 0]]))
    assert eye.acceptance_angle_rad == pytest.approx([0.05, 0.06])
    offset = [0, 0] if columns == 7 else [1e-5, 2e-5]
    assert eye.focal_offset_m == pytest.approx(offset)


def test_a_converted_file_is_read_as_the_same_eye(tmp_path):
    eye = make_eye(30)
    omma.save_eye(tmp_path / "today.eye", eye)
    lines = (tmp_path / "today.eye").read_text().splitlines()
    nine = old_file(tmp_path, 9, [line + " 3" for line in lines])
    assert (omma.eye.convert_eye(nine).eye.position_m == eye.position_m).all()
    assert (omma.eye.convert_eye(nine).eye.axis == eye.axis).all()
    with pytest.raises(omma.Error, match="column 9"):
        omma.load_eye(nine)


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (7, ["focal offset 0", "7 columns"]),
        (8, ["Nothing to convert"]),
        (9, ["Lost: column 9 (7 to 8, 2 different)", "8 are acceptance angle and focal offset"]),
    ],
)
def test_what_is_assumed_and_lost_is_said(tmp_path, columns, words):
    notes = " ".join(omma.eye.convert_eye(old_file(tmp_path, columns)).notes)
    for word in words:
        assert word in notes


def test_degrees_and_their_suspicion(tmp_path):
    path = old_file(tmp_path, 7, ["0 0 1 0 0 1 2.0", "0 1 0 0 1 0 1.0"])
    with pytest.warns(UserWarning, match=r"old\.eye: acceptance_angle_rad .* no animal's"):
        plain = omma.eye.convert_eye(path)
    assert plain.eye.acceptance_angle_rad == pytest.approx([2, 1])
    assert any("114.6°" in note and "degrees" in note for note in plain.notes)
    degrees = omma.eye.convert_eye(path, degrees=True)
    assert degrees.eye.acceptance_angle_rad == pytest.approx(np.radians([2, 1]))
    assert any("are degrees" in note for note in degrees.notes)
    with pytest.raises(omma.Error, match="are they degrees"):
        omma.eye.convert_eye(old_file(tmp_path, 7, ["0 0 1 0 0 1 10"]))


def test_units_of_old_files(tmp_path):
    eye = omma.eye.convert_eye(old_file(tmp_path, 8), "um").eye
    assert eye.position_m[0] * 1e6 == pytest.approx([1, 2, -3])
    assert eye.focal_offset_m[0] * 1e6 == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["found none"]),
        ("1 2 3 4 5 6", ["line 1", "7, 8 or 9", "found 6"]),
        ("1 2 3 4 5 6 0.1\n\n1 2 3 4 5 6 0.1 0", ["line 3", "7 columns as in line 1", "found 8"]),
        ("1 2 3 4 5 six 0.1", ["line 1", "six"]),
        ("1 2 3 4 5 inf 0.1", ["line 1", "inf"]),
        ("1 2 3 0 0 0 0.1", ["axis", "zero"]),
        ("1 2 3 0 0 1 0.1 -1", ["focal offset"]),
    ],
)
def test_wrong_old_files_are_errors(tmp_path, text, words):
    path = tmp_path / "bad.eye"
    path.write_text(text)
    with pytest.raises(omma.Error) as caught:
        omma.eye.convert_eye(path)
    for word in ["bad.eye", *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (None, "there is no such file"),
        (b"\xff\xfd\x00", "line 1: expected UTF-8 text"),
        (b"\xff\xfe\x00", "line 1: expected UTF-16 text"),
    ],
)
def test_old_files_that_are_no_files(tmp_path, data, says):
    path = tmp_path / "bad.eye"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(omma.Error, match=says):
        omma.eye.convert_eye(path)


@pytest.fixture
def omma_eye(tmp_path, monkeypatch, run_omma):
    """Runs ``omma eye ARGUMENTS`` in a directory with bug.eye: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    omma.save_eye("bug.eye", make_eye(60))
    return partial(run_omma, "eye")


def test_scale_command(omma_eye):
    code, out, err = omma_eye("scale", "bug.eye", "--mean-radius-mm", 0.1, "-o", "small.eye")
    assert (code, err) == (0, "")
    assert "60 ommatidia, mean radius 0.1 mm" in out
    assert omma_eye("scale", "small.eye", "--factor", 10, "-o", "again.eye")[0] == 0
    again, eye = omma.load_eye("again.eye"), omma.load_eye("bug.eye")
    assert again.position_m == pytest.approx(eye.position_m, rel=1e-5)


def test_split_command(omma_eye):
    code, out, _ = omma_eye(
        "split", "bug.eye", "--shift-mm", 2, "-o", "both.eye", "--left", "l.eye", "--right", "r.eye"
    )
    assert (code, out.count("wrote")) == (0, 3)
    left, right = omma.load_eye("l.eye"), omma.load_eye("r.eye")
    assert left.position_m[:, 0].max() < -2e-3
    assert right.position_m[:, 0].min() > 2e-3
    both = omma.load_eye("both.eye")
    assert (both.axis == np.concatenate([left.axis, right.axis])).all()


@pytest.mark.parametrize(
    ("arguments", "changed"),
    [
        (["--degrees", 3], {"angle_rad": np.radians(3)}),
        (["--factor", 2], {"factor": 2}),
        (["--ratio", 1.2], {"ratio": 1.2}),
        (["--non-overlapping"], {"non_overlapping": True}),
        (["--compoundray-maximal"], {"compoundray_maximal": True}),
    ],
)
def test_acceptance_command(omma_eye, arguments, changed):
    code, _, err = omma_eye("acceptance", "bug.eye", *arguments, "-o", "new.eye")
    assert (code, err) == (0, "")
    expected = omma.eye.set_acceptance(omma.load_eye("bug.eye"), **changed).acceptance_angle_rad
    assert omma.load_eye("new.eye").acceptance_angle_rad == pytest.approx(expected, rel=1e-6)


def test_convert_command_says_what_is_lost(omma_eye, tmp_path):
    old_file(tmp_path, 9)
    code, out, err = omma_eye("convert", "old.eye", "-o", "new.eye")
    assert code == 0
    assert "2 ommatidia" in out
    assert "omma: warning: old.eye: Lost: column 9" in err
    assert len(omma.load_eye("new.eye")) == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["scale", "bug.eye", "-o", "x.eye"], ["--factor", "--mean-radius-mm"]),
        (["scale", "none.eye", "--factor", 2, "-o", "x.eye"], ["none.eye"]),
        (["scale", "bug.eye", "--factor", 2, "-o", "no/x.eye"], ["no/x.eye"]),
        (["split", "bug.eye"], ["--left"]),
        (["split", "bug.eye", "--left", "x.eye", "--right", "no/x.eye"], ["no/x.eye"]),
        (["acceptance", "bug.eye", "-o", "x.eye"], ["exactly one", "--ratio"]),
        (["acceptance", "bug.eye", "--ratio", 1, "--factor", 1, "-o", "x.eye"], ["exactly one"]),
        (["convert", "none.eye", "-o", "x.eye"], ["none.eye", "there is no such file"]),
        (["scale", "bug.eye", "--factor", 2, "--unit", "ell", "-o", "x.eye"], ["unit", "ell"]),
    ],
)
def test_command_errors_are_one_line(omma_eye, tmp_path, arguments, words):
    code, out, err = omma_eye(*arguments)
    assert (code, out, err.count("\n")) == (1, "", 1)
    for word in words:
        assert word in err
    assert [path.name for path in tmp_path.iterdir()] == ["bug.eye"]
