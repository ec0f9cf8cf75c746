"""What one wrong line of a table does to the measures of an eye, and eyes of a few ommatidia."""

import numpy as np
import pytest

import omma
from omma.eye.hexagonal import NO_COORDINATE
from omma.eye.measures import measure_eye
from omma.eye.report import eye_summary

CENTRE_M = np.array([0.9e-3, 0, 0])
RADIUS_M = 0.5e-3


def patch(step_deg, half_deg):
    """A hexagonal lattice of directions within an angle of +x, rows of equal steps from there."""
    i, j = np.meshgrid(np.arange(-20, 21), np.arange(-20, 21))
    points = step_deg * np.column_stack([(i + j / 2).ravel(), (j * np.sqrt(3) / 2).ravel()])
    angle_deg = np.hypot(*points.T)
    points, angle = points[angle_deg <= half_deg], np.radians(angle_deg[angle_deg <= half_deg])
    around = np.arctan2(points[:, 1], points[:, 0])
    return np.column_stack(
        [np.cos(angle), np.sin(angle) * np.sin(around), np.sin(angle) * np.cos(around)]
    )


def on_sphere(directions, axes=None, radius_m=RADIUS_M):
    axes = directions if axes is None else axes
    return omma.Eye(CENTRE_M + radius_m * directions, axes, 0.03)


def across(direction):
    way = np.cross(direction, [0, 0, 1])
    return way / np.linalg.norm(way)


@pytest.fixture(scope="module")
def directions():
    return patch(2, 35)


@pytest.fixture(scope="module")
def whole(directions):
    return measure_eye(on_sphere(directions))


@pytest.mark.parametrize("turned_deg", [90, 180])
def test_a_wrong_axis_is_one_outlier_and_adds_one_cell(directions, whole, turned_deg):
    axes = directions.copy()
    turn = np.radians(turned_deg)
    axes[500] = np.cos(turn) * axes[500] + np.sin(turn) * across(axes[500])
    eye = on_sphere(directions, axes)
    found = measure_eye(eye)
    assert [one["ommatidium"] for one in eye_summary(eye, found)["outliers"]] == [500]
    assert found.neighbours[500] == 0
    # The hole where it belongs is bridged; what it sees itself is as wide as its acceptance.
    assert found.field.seen_sr == pytest.approx(whole.field.seen_sr, abs=2e-3)
    beside = np.linalg.norm(directions - directions[500], axis=1) < np.radians(2.5)
    assert found.interommatidial_rad[~beside] == pytest.approx(whole.interommatidial_rad[~beside])


@pytest.mark.parametrize("which", [[500, 501], [500, 300], [500, 600, 700, 300]])
def test_some_wrong_axes_spoil_no_others(directions, whole, which):
    axes = directions.copy()
    axes[which] *= -1
    found = measure_eye(on_sphere(directions, axes))
    assert np.flatnonzero(found.outlier != "").tolist() == sorted(which)
    # An angle of 2° is 3° at most where it spans a hole.
    others = np.delete(found.interommatidial_rad, which)
    assert np.degrees(others).max() < 3
    assert found.cell_rad.max() < 4.1 * np.median(whole.interommatidial_rad)


@pytest.mark.parametrize("step_deg", [2, 10])
@pytest.mark.parametrize(
    ("rings", "count", "inner"), [(1, 7, 1), (1.75, 13, 1), (2, 19, 7), (3, 37, 19)]
)
def test_eyes_of_few_rings(step_deg, rings, count, inner):
    directions = patch(step_deg, rings * step_deg * 1.0001)
    found = measure_eye(on_sphere(directions, radius_m=1e-4))
    assert len(found) == count
    assert np.sum(~found.border) == np.sum(~found.surface_border) == inner
    assert (found.neighbours[~found.border] == 6).all()
    # On the sphere rings are shorter than in the plane: at 30° by 1 - sin(30°)/(30°), 4.5 %.
    assert np.degrees(found.interommatidial_rad) == pytest.approx(step_deg, rel=0.05)
    # The normal at the border is that of triangles on one side, up to 0.6 of a step away.
    assert np.degrees(found.skew_normal_rad).max() < 0.6 * step_deg


@pytest.mark.parametrize("step_deg", [2, 10])
def test_a_rhombus_and_a_triangle(step_deg):
    lattice = patch(step_deg, 1.0001 * step_deg)
    middle = np.argmax(lattice[:, 0])
    ring = np.delete(lattice, middle, axis=0)
    turn = np.argsort(np.arctan2(ring[:, 1], ring[:, 2]))
    four = np.vstack([lattice[middle], ring[turn[:3]]])
    found = measure_eye(on_sphere(four, radius_m=1e-4))
    assert sorted(found.neighbours.tolist()) == [2, 2, 3, 3]
    assert found.border.all()
    assert np.degrees(found.interommatidial_rad) == pytest.approx(step_deg, rel=0.005)
    three = measure_eye(on_sphere(four[:3], radius_m=1e-4))
    assert three.neighbours.tolist() == [2, 2, 2]
    # By chords of equal triangles that are 10° wide: 1 % less.
    assert np.degrees(three.horizontal_rad) == pytest.approx(step_deg, rel=0.01)
    assert np.isnan(three.skew_eye_rad).all()


def test_three_in_a_row():
    angle = np.radians([0.0, 2.0, 4.0])
    row = np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    found = measure_eye(on_sphere(row))
    assert found.neighbours.tolist() == [1, 2, 1]
    assert np.degrees(found.interommatidial_rad) == pytest.approx(2, rel=1e-4)


@pytest.mark.parametrize(("apart_m", "apart_deg"), [(0.1e-6, 0.1), (0.17e-6, 0.1), (1e-6, 0.3)])
def test_a_double_is_named_and_changes_nothing(directions, whole, apart_m, apart_deg):
    eye = on_sphere(directions)
    way = across(directions[500])
    twice = omma.Eye(
        np.vstack([eye.position_m, eye.position_m[500] + apart_m * way]),
        np.vstack([directions, directions[500] + np.radians(apart_deg) * way]),
        0.03,
    )
    found = measure_eye(twice)
    assert np.flatnonzero(found.outlier != "").tolist() == [len(eye)]
    assert found.outlier[-1] == "double of 500"
    assert (found.duplicate_of == -1).all()
    same = [*range(len(eye)), 500]
    for name in ("interommatidial_rad", "facet_spacing_m", "neighbours", "border"):
        assert getattr(found, name) == pytest.approx(getattr(whole, name)[same])
    rows = omma.eye.hexagonal_coordinates(eye)
    again = omma.eye.hexagonal_coordinates(twice)
    assert again.p.tolist() == [*rows.p, NO_COORDINATE]
    assert again.neighbours[:-1].tolist() == rows.neighbours.tolist()
    facets = omma.eye.facet_diameters_m(eye)
    assert omma.eye.facet_diameters_m(twice) == pytest.approx(facets[same])
    filled = omma.eye.set_acceptance(eye, ratio=1).acceptance_angle_rad
    assert omma.eye.set_acceptance(twice, ratio=1).acceptance_angle_rad == pytest.approx(
        filled[same]
    )


@pytest.mark.parametrize("copies", [1, 2, 6])
def test_copies_count_once_for_an_acceptance_by_ratio(directions, copies):
    eye = on_sphere(directions)
    same = [*range(len(eye)), *[500] * copies]
    filled = omma.eye.set_acceptance(eye, ratio=1).acceptance_angle_rad
    twice = omma.eye.set_acceptance(eye.take(same), ratio=1).acceptance_angle_rad
    assert twice == pytest.approx(filled[same])
    assert measure_eye(eye.take(same)).duplicate_of[len(eye) :].tolist() == [500] * copies


def test_a_stretched_lattice_has_no_doubles(directions):
    stretched = directions * [1, 0.15, 1]
    axes = stretched / np.linalg.norm(stretched, axis=1, keepdims=True)
    found = measure_eye(omma.Eye(CENTRE_M + RADIUS_M * stretched, axes, 0.03))
    assert not any("double" in odd for odd in found.outlier)
