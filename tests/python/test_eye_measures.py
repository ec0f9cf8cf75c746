"""Numbers about eyes against closed forms: lattices of known angles, fields of known solid angle,
planted skew, outliers and duplicates; what ``omma eye info`` prints and writes."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, make_eye

import omma
from omma.eye.field import sphere_directions
from omma.eye.measures import diffraction_limit_m_rad, measure_eye
from omma.eye.neighbours import eye_centre, sides
from omma.eye.report import SPREADS, eye_summary, eye_table

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
BEES = DATA / "compound-ray" / "bees"


def on_sphere(directions, radius_m=1e-3, **more):
    return omma.Eye(radius_m * directions, directions, 0.02, **more)


def hexagonal(spacing_deg, stretch=(1.0, 1.0), radius=12, turned_deg=0.0):
    """A round patch of a hexagonal lattice ahead, stretched to the right and upwards: directions,
    and the lattice points in units of the spacing before that."""
    i, j = np.meshgrid(np.arange(-radius, radius + 1), np.arange(-radius, radius + 1))
    points = np.column_stack([(i + j / 2).ravel(), (j * np.sqrt(3) / 2).ravel()])
    points = points[np.hypot(*points.T) < 0.8 * radius]
    turn = np.radians(turned_deg)
    points = points @ np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    right, up = (np.radians(spacing_deg) * points * stretch).T
    # Circles of latitude are spaced as the elevation, azimuths by its cosine.
    azimuth = right / np.cos(up)
    return np.column_stack(
        [np.cos(up) * np.sin(azimuth), np.sin(up), -np.cos(up) * np.cos(azimuth)]
    ), points


def cap(half_deg, count=20_000, towards=(0, 0, -1)):
    """Directions spread evenly over a cap."""
    directions = sphere_directions(count)
    return directions[directions @ np.asarray(towards, float) > np.cos(np.radians(half_deg))]


def cap_sr(half_deg):
    return 2 * np.pi * (1 - np.cos(np.radians(half_deg)))


@pytest.mark.parametrize("turned_deg", [0, 30, 13])
def test_hexagonal_lattice(turned_deg):
    directions, points = hexagonal(0.5, turned_deg=turned_deg)
    found = measure_eye(on_sphere(directions))
    inner = ~found.border
    assert (found.neighbours[inner] == 6).all()
    # The patch reaches 4.8° from its middle, so that angles are off by up to 0.3 %.
    for angle in (found.interommatidial_rad, found.horizontal_rad, found.vertical_rad):
        assert np.degrees(angle) == pytest.approx(0.5, rel=0.005)
    # The border is the outermost points, and no edge bridges a notch of it.
    assert np.hypot(*points[found.border].T).min() > 8
    i, j = found.lattice.pairs.T
    assert np.linalg.norm(points[i] - points[j], axis=1) == pytest.approx(1)


def test_sampling_frequencies():
    found = measure_eye(on_sphere(hexagonal(0.5)[0]))
    per_degree = np.radians(found.sampling_per_rad)
    assert per_degree == pytest.approx(1.0, rel=0.005)
    assert found.hexagonal_sampling_per_rad == pytest.approx(
        found.sampling_per_rad * 2 / np.sqrt(3)
    )


@pytest.mark.parametrize(
    ("turned_deg", "stretch"),
    # Rows lie along x, turned by 30° along y; along rows neighbours change from √3 on,
    # and a little sooner where the sphere shears the lattice.
    [(0, (1.4, 1.0)), (0, (1.0, 3.0)), (0, (0.7, 1.1)), (30, (2.5, 1.0)), (30, (0.75, 1.0))],
)
def test_stretched_lattice_has_its_own_angles_along_both_ways(turned_deg, stretch):
    found = measure_eye(on_sphere(hexagonal(0.4, stretch, turned_deg=turned_deg)[0]))
    inner = ~found.border
    # Up to 11.5° from the middle the sphere's curvature is 2 %.
    assert np.degrees(found.horizontal_rad[inner]) == pytest.approx(0.4 * stretch[0], rel=0.02)
    assert np.degrees(found.vertical_rad[inner]) == pytest.approx(0.4 * stretch[1], rel=0.02)
    assert (found.neighbours[inner] == 6).all()


def test_giger_lattice_of_the_honeybee():
    eye = omma.load_eye(EXAMPLES / "honeybee_worker_left.eye")
    found = measure_eye(eye)
    # The project's honeybee: median 2.25° with six neighbours, asked for within 3 %.
    assert np.degrees(np.median(found.interommatidial_rad)) == pytest.approx(2.25, rel=0.03)
    assert np.mean(found.neighbours[~found.border] == 6) > 0.9


def test_whole_sphere_has_no_border_and_no_blind_zone():
    found = measure_eye(on_sphere(sphere_directions(800)))
    assert not found.border.any()
    assert found.neighbours.mean() == pytest.approx(6 - 12 / 800)  # Euler: 3N - 6 pairs
    assert found.field.seen_sr == pytest.approx(4 * np.pi)
    assert found.field.blind_zones == ()
    # A hexagonal lattice of so many: 2/√3 over the solid angle of each; Fibonacci's is near one.
    each = np.sqrt(4 * np.pi / 800 * 2 / np.sqrt(3))
    assert np.median(found.interommatidial_rad) == pytest.approx(each, rel=0.05)


@pytest.mark.parametrize(
    ("half_deg", "count"), [(90, 2000), (90, 20_000), (60, 4000), (20, 20_000)]
)
def test_field_of_a_cap(half_deg, count):
    directions = cap(half_deg, count, towards=(0.36, 0.48, 0.8))
    field = measure_eye(on_sphere(directions)).field
    # The border follows the lattice: off by a share of half a cell all along it.
    assert field.seen_sr == pytest.approx(cap_sr(half_deg), rel=0.015)
    assert field.blind_sr == pytest.approx(4 * np.pi - field.seen_sr)
    assert field.binocular_sr == 0
    assert list(field.eyes_sr.values()) == [field.seen_sr]


@pytest.mark.parametrize("apart_deg", [40, 90, 150])
def test_binocular_overlap_of_two_hemispheres(apart_deg):
    turn = np.radians(apart_deg / 2)
    halves = [cap(90, 8000, towards=(sign * np.sin(turn), 0, -np.cos(turn))) for sign in (-1, 1)]
    eye = omma.eye.merge_eyes([on_sphere(directions) for directions in halves])
    field = measure_eye(eye).field
    # Two half spheres share a lune as wide as the angle that is left of half a turn. Each border
    # is known to a share of half a cell (1.3° here) of 2 x 180° of it: 0.06 sr.
    assert field.binocular_sr == pytest.approx(2 * (np.pi - np.radians(apart_deg)), abs=0.06)
    assert field.seen_sr == pytest.approx(2 * np.pi + 2 * np.radians(apart_deg), abs=0.06)
    assert sum(field.eyes_sr.values()) == pytest.approx(field.seen_sr + field.binocular_sr)


def test_blind_cones():
    directions = sphere_directions(20_000)
    seen = np.ones(len(directions), bool)
    cones = [((0, 0, 1), 30.0), ((0.6, -0.8, 0), 12.0)]
    for middle, half in cones:
        seen &= directions @ np.array(middle) < np.cos(np.radians(half))
    zones = measure_eye(on_sphere(directions[seen])).field.blind_zones
    assert len(zones) == 2
    for zone, (_, half) in zip(zones, cones, strict=True):
        # Ommatidia are 1.6° apart, and cells reach half of that into the zone; directions are
        # tried 0.57° apart. The widest cone ends at the cell that reaches in furthest.
        assert zone.radius_deg == pytest.approx(half - 0.8, abs=0.8)
        assert zone.solid_angle_sr == pytest.approx(cap_sr(half), rel=0.06)
    assert abs(zones[0].azimuth_deg) == pytest.approx(180, abs=1.5)
    assert zones[0].elevation_deg == pytest.approx(0, abs=1.5)
    assert zones[1].azimuth_deg == pytest.approx(90, abs=2)  # 1.2° of arc at that elevation
    assert zones[1].elevation_deg == pytest.approx(-53.13, abs=1.2)


def test_ratio_and_eye_parameter():
    eye = on_sphere(sphere_directions(500))
    known = eye.replace(facet_diameter_m=np.where(np.arange(500) < 400, 20e-6, 0.0))
    found = measure_eye(known)
    assert found.ratio == pytest.approx(0.02 / found.interommatidial_rad)
    assert found.eye_parameter_m_rad[:400] == pytest.approx(20e-6 * found.interommatidial_rad[:400])
    assert np.isnan(found.eye_parameter_m_rad[400:]).all()
    assert np.isnan(measure_eye(eye).eye_parameter_m_rad).all()
    assert diffraction_limit_m_rad(500) == pytest.approx(0.29e-6)


def test_sensitivity_is_that_of_the_most_sensitive_receptor():
    long = {"peak_wavelength_nm": 544, "absorption_per_m": 6700, "length_m": 320e-6}
    types = [
        omma.receptors.ReceptorType("green", **long),
        omma.receptors.ReceptorType("?", peak_wavelength_nm=344),
    ]
    eye = on_sphere(sphere_directions(3)).replace(
        facet_diameter_m=20e-6,
        acceptance_angle_rad=np.radians(1.75),
        receptor_types=types,
        receptors=[[0, 1], [1], [1]],
    )
    found = measure_eye(eye).sensitivity_m2_sr * 1e12
    # Apis mellifera, J Exp Biol 212:2448, table 1: 0.1, as printed.
    assert found[0] == pytest.approx(0.11, rel=0.03)
    assert np.isnan(found[1:]).all()


def skewed(angle_deg, count=3000):
    """Axes turned by an angle out of the direction of their position."""
    directions = sphere_directions(count)
    aside = np.cross(directions, [0.3, 0.9, 0.3])
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    turn = np.radians(angle_deg)
    axes = np.cos(turn) * directions + np.sin(turn) * aside
    return directions, axes


@pytest.mark.parametrize("angle_deg", [0, 5, 35])
def test_skew(angle_deg):
    directions, axes = skewed(angle_deg)
    found = measure_eye(omma.Eye(1e-3 * directions, axes, 0.02))
    for angle in (found.skew_head_rad, found.skew_eye_rad):
        assert np.degrees(angle) == pytest.approx(angle_deg, abs=1e-3)  # float32
    # Normals are those of the triangles around, 3.7° wide, which are least even at the poles.
    off = np.abs(np.degrees(found.skew_normal_rad) - angle_deg)
    assert np.percentile(off, 90) < 0.6
    assert off.max() < 1.9


def test_skew_from_the_head_is_not_that_from_the_eye():
    directions = cap(80, 3000, towards=(1, 0, 0))
    eye = omma.Eye(0.5e-3 * directions + [1e-3, 0, 0], directions, 0.02)
    found = measure_eye(eye)
    assert np.degrees(found.skew_eye_rad).max() < 0.01
    expected = np.arccos(
        np.sum(eye.position_m * directions, axis=1) / np.linalg.norm(eye.position_m, axis=1)
    )
    assert found.skew_head_rad == pytest.approx(expected, abs=1e-3)
    assert np.degrees(found.skew_normal_rad[~found.border]).max() < 1


def test_eyes_at_a_point_have_no_skew():
    found = measure_eye(omma.Eye(np.zeros((50, 3)), sphere_directions(50), 0.1))
    for angle in (found.skew_head_rad, found.skew_eye_rad, found.skew_normal_rad):
        assert np.isnan(angle).all()
    assert np.isnan(found.facet_spacing_m).all()
    assert (found.outlier == "").all()


def test_planted_outliers():
    directions = cap(80, 6000)
    middle = np.argsort(directions[:, 2])[:3]  # well inside
    axes, positions = directions.copy(), 1e-3 * directions
    spacing = np.sqrt(4 * np.pi / 6000)
    turned, moved, _ = middle
    axes[turned] += 4 * spacing * np.cross(axes[turned], [0, 1, 0])
    positions[moved] *= 1 + 4 * spacing
    clean = measure_eye(omma.Eye(1e-3 * directions, directions, 0.02))
    assert (clean.outlier == "").all()
    found = measure_eye(omma.Eye(positions, axes, 0.02))
    assert "axis" in found.outlier[turned]
    assert "position" in found.outlier[moved]
    odd = set(np.flatnonzero(found.outlier != "").tolist())
    # What the turned one comes to lie between may be told too, but nobody else.
    near = np.flatnonzero(directions @ directions[turned] > np.cos(7 * spacing))
    assert odd <= {moved, *near.tolist()}


def test_a_wrong_axis_is_told_from_a_wrong_position():
    rng = np.random.default_rng(3)
    directions = cap(80, 2000)
    spacing = np.sqrt(4 * np.pi / 2000)
    inner = np.flatnonzero(directions[:, 2] < -np.cos(np.radians(50)))
    for one in rng.choice(inner, 6, replace=False):
        aside = np.cross(directions[one], rng.standard_normal(3))
        wrong = directions.copy()
        wrong[one] += rng.uniform(2, 6) * spacing * aside / np.linalg.norm(aside)
        wrong[one] /= np.linalg.norm(wrong[one])
        turned = measure_eye(omma.Eye(1e-3 * directions, wrong, 0.02)).outlier
        moved = measure_eye(omma.Eye(1e-3 * wrong, directions, 0.02)).outlier
        assert set(turned[one].split("+")) - {"spacing"} == {"axis"}
        assert moved[one] == "position"
        # Those around it, between which it seems to lie, are none.
        assert np.flatnonzero(turned != "").tolist() == [one]
        assert np.flatnonzero(moved != "").tolist() == [one]


def test_a_stretched_surface_has_no_outliers_but_what_is_turned_on_it():
    # On this ellipsoid the facets that touch are not those that look nearest.
    lattice = omma.eye.lay_directions(
        np.radians(4), field_of_view=omma.eye.window((-15, 160), (-80, 80)), seed=0
    )
    surface = omma.eye.surfaces.ellipsoid((0.4e-3, 1.2e-3, 0.5e-3))
    eye = omma.eye.eye_on_surface(lattice.directions, surface)
    whole = measure_eye(eye)
    inner = np.flatnonzero(~whole.border & ~whole.surface_border)
    assert np.median(whole.surface_angle_rad[inner] / whole.interommatidial_rad[inner]) > 1.2
    assert not any("axis" in odd for odd in whole.outlier)

    # How many are told by their axis and how many by something else hangs on the lattice, which
    # another processor's rounding lays otherwise: 21 to 54 of 60 in six lattices.
    told, by_axis = [], 0
    for draw in range(3):
        turned = np.random.default_rng(draw).choice(inner, 20, replace=False)
        axes = whole.axis.copy()
        aside = np.cross(axes[turned], [0.3, 0.8, 0.5])
        aside /= np.linalg.norm(aside, axis=1, keepdims=True)
        angle = 4 * whole.interommatidial_rad[turned, None]
        axes[turned] = np.cos(angle) * axes[turned] + np.sin(angle) * aside
        found = measure_eye(eye.replace(axis=axes)).outlier
        told.append(found[turned] != "")
        of_axis = np.flatnonzero(["axis" in odd for odd in found])
        assert set(of_axis) <= set(turned)
        by_axis += len(of_axis)
    assert np.mean(told) > 0.9
    assert by_axis > 12


def test_a_gap_in_spacing_is_an_outlier():
    directions = cap(80, 6000)
    angle = np.arccos(np.clip(directions @ [0, 0, -1], -1, 1))
    spacing = np.sqrt(4 * np.pi / 6000)
    lonely = angle > 4 * spacing
    lonely[angle.argmin()] = True  # one alone in a hole
    found = measure_eye(on_sphere(directions[lonely]))
    which = int(np.flatnonzero(np.flatnonzero(lonely) == angle.argmin())[0])
    assert "spacing" in found.outlier[which]
    assert np.sum(found.outlier != "") < 20  # and some around the hole


@pytest.mark.parametrize("make", [lambda: omma.eye.generate_eye(700), lambda: make_eye(300)])
def test_whole_eyes_have_no_duplicates(make):
    assert (measure_eye(make()).duplicate_of == -1).all()


def test_duplicates():
    eye = omma.eye.generate_eye(300)
    twice = eye.take([*range(300), 17, 250, 17])
    found = measure_eye(twice)
    assert found.duplicate_of[300:].tolist() == [17, 250, 17]
    assert (found.duplicate_of[:300] == -1).all()
    # They have the neighbours of the first, and take nobody's place.
    alone = measure_eye(eye)
    assert found.interommatidial_rad[:300] == pytest.approx(alone.interommatidial_rad)
    assert found.interommatidial_rad[300] == found.interommatidial_rad[17]
    assert found.neighbours[301] == alone.neighbours[250]


def test_the_same_axis_elsewhere_is_no_duplicate():
    directions = sphere_directions(100)
    eye = omma.Eye(
        np.concatenate([1e-3 * directions, 1.1e-3 * directions]),
        np.concatenate([directions, directions]),
        0.1,
    )
    found = measure_eye(eye)
    assert (found.duplicate_of == -1).all()
    assert found.interommatidial_rad[:100] == pytest.approx(found.interommatidial_rad[100:])


def test_two_sides_in_one_file_are_two_eyes():
    both = [cap(70, 1000, towards=(sign, 0, 0)) for sign in (-1, 1)]
    positions = np.concatenate(
        [0.3e-3 * side + [sign * 1e-3, 0, 0] for side, sign in zip(both, (-1, 1), strict=True)]
    )
    eye = omma.Eye(positions, np.concatenate(both), 0.1)
    found = measure_eye(eye)
    assert (found.eye_id == (positions[:, 0] > 0)).all()
    assert len(found.field.eyes_sr) == 2
    whole = omma.eye.generate_eye(500)
    assert (measure_eye(whole).eye_id == 0).all()
    assert sides(np.zeros((3, 3)), np.array([0, 1, 1], np.int32)).tolist() == [0, 1, 1]


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_eyes_with_few_ommatidia(count):
    axes = np.array([[0, 0, -1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], float)[:count]
    found = measure_eye(omma.Eye(1e-3 * axes, axes, 0.1))
    assert len(found) == count
    if count == 1:
        assert np.isnan(found.interommatidial_rad).all()
    else:
        assert np.isfinite(found.interommatidial_rad).all()
    assert eye_summary(omma.Eye(1e-3 * axes, axes, 0.1), found)["ommatidia"] == count


def test_a_single_ommatidium_sees_its_acceptance():
    eye = omma.Eye([[0, 0, 0]], [[0, 1, 0]], np.radians(60))
    assert measure_eye(eye).field.seen_sr == pytest.approx(cap_sr(30), rel=0.01)


def test_ommatidia_in_a_row():
    angle = np.radians(np.arange(-20, 21, 2.0))
    axes = np.column_stack([np.sin(angle), 0 * angle, -np.cos(angle)])
    found = measure_eye(omma.Eye(1e-3 * axes, axes, 0.1))
    assert np.degrees(found.interommatidial_rad[1:-1]) == pytest.approx(2, rel=1e-4)
    assert found.neighbours.tolist() == [1, *[2] * 19, 1]


def test_the_centre_of_an_eye():
    positions = 0.4e-3 * cap(50, 3000, towards=(0, 0.6, -0.8)) + [1e-3, 2e-3, 3e-3]
    assert eye_centre(positions) == pytest.approx([1e-3, 2e-3, 3e-3], abs=1e-9)


def test_table_and_summary_name_the_same_things():
    eye = omma.eye.generate_eye(200)
    found = measure_eye(eye)
    table = eye_table(eye, found)
    assert {name for name, _, _ in SPREADS} <= set(table)
    assert all(len(values) == 200 for values in table.values())
    summary = json.loads(json.dumps(eye_summary(eye, found), allow_nan=False))
    assert summary["spread"]["interommatidial_deg"]["median"] == pytest.approx(
        np.degrees(np.median(found.interommatidial_rad))
    )
    assert summary["spread"]["facet_diameter_um"] == {
        "min": None, "p5": None, "median": None, "p95": None, "max": None, "known": 0
    }  # fmt: skip


def test_command(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    eye = omma.eye.generate_eye(300)
    omma.save_eye("a.eye", eye)
    omma.save_eye("twice.eye", eye.take([*range(300), 7]))
    code, out, err = run_omma("eye", "info", "twice.eye", "-o", "t.csv", "--json", "s.json")
    assert (code, err) == (0, "")
    for words in ("301", "interommatidial Δφ", "touching facets, mean",
                  "binocular    none", "blind        nowhere",
                  "duplicates   1: 300 (as 7)", "outliers     none", "cycles/°",
                  "wrote t.csv", "wrote s.json"):  # fmt: skip
        assert words in out
    assert max(map(len, out.splitlines())) <= 100
    assert json.loads(Path("s.json").read_text())["duplicates"] == [
        {"ommatidium": 300, "same_as": 7}
    ]
    with open("t.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 301
    measured = measure_eye(omma.load_eye("twice.eye"))
    for column in ("interommatidial", "surface_angle"):
        written = [float(row[f"{column}_deg"]) for row in rows]
        expected = np.degrees(getattr(measured, f"{column}_rad"))
        assert written == pytest.approx(expected, rel=1e-6)
    assert rows[3]["facet_diameter_um"] == ""  # not known
    code, out, _ = run_omma("eye", "info", "a.eye", "a.eye")
    assert code == 0
    assert "600 (300 + 300)" in out
    assert "100.0% of the field" in out


def test_axes_into_the_eye_are_told(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    eye = on_sphere(cap(35, 2000, (0, 0, 1)))  # blind straight ahead, at an elevation of 0
    count = len(eye)
    summary = eye_summary(eye, measure_eye(eye))
    assert summary["inward"] == []
    omma.save_eye("out.csv", eye)
    out = run_omma("eye", "info", "out.csv")[1]
    assert "into the eye" not in out
    assert "-0°" not in out
    for number, inward, words in (
        (count, np.arange(count), f"{count} of {count} axes point into the eye\n"),
        (1, np.array([7]), f"1 of {count} axes point into the eye: 7\n"),
    ):
        axis = eye.axis.copy()
        axis[inward] *= -1
        omma.save_eye("in.csv", eye.replace(axis=axis))
        code, out, _ = run_omma("eye", "info", "in.csv", "--json", "in.json")
        assert code == 0
        assert f"looks wrong  {words}" in out
        assert len(json.loads(Path("in.json").read_text())["inward"]) == number


def test_command_says_what_is_wrong(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("a.eye", omma.eye.generate_eye(50))
    code, _, err = run_omma("eye", "info", "a.eye", "--map", "a.jpg")
    assert code == 1
    assert "a.jpg" in err
    code, _, err = run_omma("eye", "info", "nowhere.eye")
    assert code == 1
    assert "nowhere.eye" in err


@pytest.mark.parametrize(
    ("name", "skew_deg"), [("AM_60185", 34), ("BT_77967", 40), ("BT_77973", 37)]
)
def test_real_bees(name, skew_deg):
    path = BEES / f"{name}-real.eye"
    if not path.exists():
        pytest.skip(f"{path} is not there")
    eye = omma.load_eye(path)
    found = measure_eye(eye)
    assert len(found.field.eyes_sr) == 2
    # Positions seen from the head's centre and axes: 32 to 45°, computed from the files before.
    assert np.degrees(np.median(found.skew_head_rad)) == pytest.approx(skew_deg, abs=1)
    # From the surface itself they are hardly skewed.
    assert np.degrees(np.median(found.skew_normal_rad)) < 3
    left, right = found.field.eyes_sr.values()
    assert left == pytest.approx(right, rel=0.01)  # they are mirror images
    assert 0 < found.field.binocular_sr < 0.5 * left
    assert found.field.blind_zones[0].solid_angle_sr > 4
    assert (found.duplicate_of == -1).all()
    assert np.mean(found.outlier != "") < 0.02


def test_a_few_missing_ommatidia_are_bridged_and_many_are_a_blind_zone():
    directions = sphere_directions(6000)
    from_ahead = np.arccos(np.clip(-directions[:, 2], -1, 1))
    spacing = np.sqrt(4 * np.pi / 6000 * 2 / np.sqrt(3))
    for missing, zones in ((0.5, 0), (1.1, 0), (5, 1)):
        field = measure_eye(on_sphere(directions[from_ahead > missing * spacing])).field
        assert len(field.blind_zones) == zones
