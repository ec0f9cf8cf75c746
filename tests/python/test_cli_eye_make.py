"""omma eye make, mirror, place, scale, join: the eyes of the API, and errors of one line."""

from functools import partial

import numpy as np
import pytest

import omma

D = np.radians


@pytest.fixture
def omma_eye(tmp_path, monkeypatch, run_omma):
    """Runs ``omma eye ARGUMENTS`` in a directory of its own: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    return partial(run_omma, "eye")


def same(one, other):
    for name in ("position_m", "axis", "acceptance_angle_rad", "facet_diameter_m", "eye_id"):
        assert (getattr(one, name) == getattr(other, name)).all(), name
    return True


def test_make_is_the_api_put_together(omma_eye):
    code, out, err = omma_eye(
        "make", 90, "--acute-zone", "60,10,40,6", "--streak", "0,30,2", "--fov", "-20,150,-70,70",
        "--semi-axes-mm", 0.4, 1.2, 0.5, "--centre-mm", 1.4, 0, 0, "--skew", 20, "--pair",
        "--acceptance-ratio", 1.5, "--seed", 3, "-o", "made.csv",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "180 ommatidia" in out
    zone = omma.eye.AcuteZone(D(60), D(10), D(40), 6)
    band = omma.eye.AcuteZone(0, 0, D(30), 2, band=True)
    across = omma.eye.acute_angle(D(1), zone.density)
    lattice = omma.eye.lay_directions(
        across,
        omma.eye.acute_angle(across, band.density, one_way=True),
        field_of_view=omma.eye.window((-20, 150), (-70, 70)),
        count=90,
        seed=3,
    )
    surface = omma.eye.surfaces.ellipsoid((0.4e-3, 1.2e-3, 0.5e-3), (1.4e-3, 0, 0))
    middle = lattice.directions.sum(axis=0)
    squeeze = omma.eye.skew.squeeze_for_skew(lattice.directions, surface, middle, D(20))
    eye = omma.eye.eye_on_surface(
        lattice.directions,
        surface,
        normal=omma.eye.skew.squeezed(middle, squeeze),
        acceptance_ratio=1.5,
    )
    assert np.median(omma.eye.skew.skew_rad(eye, surface=surface)) == pytest.approx(D(20), rel=1e-4)
    assert same(omma.load_eye("made.csv"), omma.eye.pair_of_eyes(eye))


def test_make_from_a_table(omma_eye, tmp_path):
    lines = ["# two angles", "azimuth_deg,elevation_deg,dphi_h_deg,dphi_v_deg"]
    lines += [f"{a},{e},{12 - e / 30},9" for e in (-90, 90) for a in (-90, 90)]
    (tmp_path / "field.csv").write_text("\n".join(lines))
    assert omma_eye("make", "--field", "field.csv", "-o", "made.csv")[0] == 0
    made = omma.load_eye("made.csv")
    lattice = omma.eye.lay_directions(*omma.eye.angles.load_angle_table("field.csv"))
    assert made.axis == pytest.approx(lattice.directions, abs=1e-6)


def test_make_by_facets(omma_eye):
    assert omma_eye("make", "--facet-um", 200, "--radius-mm", 0.8, "-o", "a.csv")[0] == 0
    eye = omma.load_eye("a.csv")
    assert np.median(eye.facet_diameter_m) == pytest.approx(200e-6, rel=0.02)
    assert same(eye, omma.eye.lay_on_surface(omma.eye.surfaces.sphere(0.8e-3), 200 * 1e-6))
    assert omma_eye("make", 150, "--even-facets", "--semi-axes-mm", 1, 2, 1, "-o", "b.csv")[0] == 0
    assert len(omma.load_eye("b.csv")) == 150


def test_pairs_do_not_interpenetrate_or_say_so(omma_eye):
    from scipy.spatial import cKDTree

    code, _, err = omma_eye("make", 60, "--radius-mm", 0.5, "--pair", "-o", "apart.csv")
    assert (code, err) == (0, "")
    head = omma.load_eye("apart.csv")
    left, right = (head.position_m[head.eye_id == k] for k in (0, 1))
    assert left[:, 0].max() < 0 < right[:, 0].min()
    # A gap of a tenth of an eye's width, twice a twentieth.
    assert cKDTree(left).query(right)[0].min() >= 0.099 * np.ptp(right[:, 0])

    code, _, err = omma_eye(
        *("make", 60, "--radius-mm", 0.5, "--centre-mm", 0.2, 0, 0, "--pair", "-o", "in.csv")
    )
    assert code == 0
    assert "--pair: the eyes interpenetrate" in err
    code, _, err = omma_eye(
        *("make", 60, "--radius-mm", 0.5, "--centre-mm", 0.6, 0, 0, "--pair", "-o", "out.csv")
    )
    assert (code, err) == (0, "")
    omma_eye("make", 60, "--radius-mm", 0.5, "-o", "one.csv")
    assert "interpenetrate" in omma_eye("mirror", "one.csv", "--pair", "-o", "two.csv")[2]


def test_pairs_of_left_eyes(omma_eye):
    left = ["--radius-mm", 0.5, "--fov=-160,-15,-80,80"]
    assert omma_eye("make", 60, *left, "--centre-mm", -1, 0, 0, "-o", "left.csv")[0] == 0
    code, _, err = omma_eye("mirror", "left.csv", "--pair", "-o", "pair.csv")
    assert (code, err) == (0, "")
    given, head = omma.load_eye("left.csv"), omma.load_eye("pair.csv")
    assert (head.select(0).position_m == given.position_m).all()
    assert head.select(0).position_m[:, 0].max() < 0 < head.select(1).position_m[:, 0].min()
    # Made without a place: moved to its own side.
    code, _, err = omma_eye("make", 60, *left, "--pair", "-o", "made.csv")
    assert (code, err) == (0, "")
    made = omma.load_eye("made.csv").select(0)
    assert made.position_m[:, 0].max() < 0 > made.axis[:, 0].mean()
    omma_eye("make", 60, *left, "--centre-mm", 0.1, 0, 0, "-o", "near.csv")
    err = omma_eye("mirror", "near.csv", "--pair", "-o", "pair.csv")[2]
    assert "of the left one sit right of the midline" in err


@pytest.mark.parametrize(
    ("options", "kernel"), [(["--airy"], "airy"), (["--rhabdom-um", 2, "--f-number", 2], "lens")]
)
def test_make_with_optics(omma_eye, options, kernel):
    code, _, err = omma_eye("make", 60, "--radius-mm", 0.05, *options, "-o", "a.csv")
    assert (code, err) == (0, "")
    made = omma.load_eye("a.csv")
    assert all(one.kernel.startswith(kernel) for one in made.acceptances)
    assert (made.acceptance_of >= 0).all()


def test_mirror_place_scale_join(omma_eye):
    assert omma_eye("make", 40, "--centre-mm", 2, 0, 0, "-o", "right.csv")[0] == 0
    right = omma.load_eye("right.csv")
    assert omma_eye("mirror", "right.csv", "-o", "left.csv")[0] == 0
    left = omma.load_eye("left.csv")
    assert same(left, omma.eye.mirror_eye(right))
    assert omma_eye("mirror", "right.csv", "--pair", "-o", "pair.csv")[0] == 0
    assert omma_eye("join", "left.csv", "right.csv", "-o", "joined.csv")[0] == 0
    assert same(omma.load_eye("pair.csv"), omma.eye.pair_of_eyes(right))
    assert same(omma.load_eye("joined.csv"), omma.load_eye("pair.csv"))
    place = ["--position-mm", 1, 2, 3, "--yaw", 30, "--pitch", 20, "--roll", 10]
    assert omma_eye("place", "right.csv", *place, "-o", "placed.csv")[0] == 0
    expected = omma.eye.place_on_head(
        right, (1e-3, 2e-3, 3e-3), yaw_deg=30, pitch_deg=20, roll_deg=10
    )
    assert same(omma.load_eye("placed.csv"), expected)
    assert omma_eye("scale", "right.csv", "--factor", 2, "-o", "large.csv")[0] == 0
    assert same(omma.load_eye("large.csv"), omma.eye.rescale_eye(right, 2))


def test_what_an_eye_file_loses_is_said(omma_eye):
    with pytest.warns(UserWarning, match="a.eye: lost: facet diameters") as told:
        code, out, _ = omma_eye("make", 40, "-o", "a.eye")
    assert (code, out.count("wrote"), len(told)) == (0, 1, 1)


def test_an_eye_of_half_a_metre_is_said(omma_eye):
    with pytest.warns(UserWarning, match=r"semi-axis of 0\.5 m is no animal's eye"):
        code, _, _ = omma_eye("make", 40, "--radius-mm", 500, "-o", "a.csv")
    assert code == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["make"], ["N", "--dphi"]),
        (["make", "1"], ["N: expected", "axis_x,axis_y,axis_z,acceptance_angle_deg", "0,0,-1,5"]),
        (["make", "50", "--acute-zone", "0,0,10"], ["--acute-zone", "4 numbers", "0,0,10"]),
        (["make", "50", "--acute-band", "0,0,2"], ["--acute-band", "width"]),
        (["make", "50", "--streak", "a,b,c"], ["--streak", "3 numbers"]),
        (["make", "50", "--fov", "0,10,20"], ["--fov", "4 numbers"]),
        (["make", "50", "--fov", "10,0,0,20"], ["--fov", "ascending"]),
        (["make", "50", "--radius-mm", "1", "--mesh", "a.stl"], ["--radius-mm", "--mesh"]),
        (["make", "50", "--mesh", "none.stl"], ["none.stl"]),
        (["make", "50", "--mesh", "none.stl", "--centre-mm", "1", "1", "1"], ["--centre-mm"]),
        (["make", "50", "--radius-mm", "0"], ["--radius-mm: expected"]),
        (["make", "50", "--facet-um", "20"], ["N", "--facet-um"]),
        (["make", "--even-facets"], ["N", "--even-facets"]),
        (["make", "--facet-um", "20", "--skew", "10"], ["--skew", "--facet-um"]),
        (["make", "--dphi", "0"], ["--dphi: expected", "0"]),
        (["make", "9", "--dphi-vertical", "2"], ["--dphi-vertical"]),
        (["make", "--dphi", "9", "--field", "f.csv"], ["--field", "--dphi"]),
        (["make", "9", "--airy", "--acceptance-ratio", "1"], ["--airy"]),
        (["make", "9", "--rhabdom-um", "1"], ["--f-number"]),
        (["make", "40", "--skew", "170"], ["--skew: expected", "170"]),
        (["make", "50", "-o", "no/where.eye"], ["no/where.eye", "directory"]),
        (["join", "none.csv"], ["none.csv"]),
        (["mirror", "none.csv"], ["none.csv"]),
        (["place", "none.csv"], ["none.csv"]),
        (["scale", "none.csv"], ["--factor", "--mean-radius-mm"]),
    ],
)
def test_command_errors_are_one_line(omma_eye, tmp_path, arguments, words):
    code, out, err = omma_eye(*arguments, *([] if "-o" in arguments else ["-o", "made.csv"]))
    assert (code, out, err.count("\n")) == (1, "", 1)
    for word in words:
        assert word in err
    assert list(tmp_path.iterdir()) == []
