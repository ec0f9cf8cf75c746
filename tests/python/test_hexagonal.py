"""Hexagonal coordinates: known lattices come back exactly, anatomy is the same in both eyes."""

from functools import cache

import numpy as np
import pytest

import omma
from omma.eye import hexagonal_coordinates
from omma.eye.hexagonal import NO_COORDINATE

STEPS = np.array([[1, 1], [0, 1], [-1, 0], [-1, -1], [0, -1], [1, 0]])
COLUMN = {name: k for k, name in enumerate(omma.eye.hexagonal.DIRECTIONS)}


def eye_of(azimuth_deg, elevation_deg):
    """An eye on a sphere whose axes are its normals."""
    axis = omma.eye.direction(np.ravel(azimuth_deg), np.ravel(elevation_deg))
    return omma.Eye(1e-3 * axis, axis, np.radians(2))


def upright(centre_deg=60.0):
    """An eye of vertical rows 2° apart, and the p and q of each ommatidium."""
    p, q = (c.ravel() for c in np.mgrid[-9:10, -9:10])
    inside = np.abs(p + q) <= 9
    p, q = p[inside], q[inside]
    # In a right eye the front is to the left: azimuth falls. v = p + q, h = q - p.
    return eye_of(centre_deg - np.sqrt(3) * (q - p), 1.0 * (p + q)), p, q


@cache
def coordinates(name, by="surface"):
    return hexagonal_coordinates(omma.species.make(name).eye, by)


def assert_consistent(found):
    own, column = np.nonzero(found.neighbours >= 0)
    other = found.neighbours[own, column]
    assert np.array_equal(found.neighbours[other, (column + 3) % 6], own)
    # From one neighbour to the next but one and back: round a triangle.
    for d in range(6):
        first = found.neighbours[:, d]
        second = np.where(first >= 0, found.neighbours[first, (d + 2) % 6], -1)
        third = np.where(second >= 0, found.neighbours[second, (d + 4) % 6], -1)
        closed = third >= 0
        assert np.array_equal(third[closed], np.flatnonzero(closed))
    known = found.known
    places = np.stack([found.p, found.q, found.side], axis=1)[known]
    assert len(np.unique(places, axis=0)) == len(places)
    assert np.array_equal(found.q == NO_COORDINATE, ~known)


def test_a_lattice_gets_its_own_coordinates():
    eye, p, q = upright()
    found = hexagonal_coordinates(eye)
    assert_consistent(found)
    # Up to where zero is: the middle of the eye.
    known = found.known
    assert known.mean() > 0.98  # corners that only flat triangles hold have none
    assert np.array_equal(found.p[known], p[known])
    assert np.array_equal(found.q[known], q[known])
    place = {pair: i for i, pair in enumerate(zip(p.tolist(), q.tolist()))}
    for i in np.flatnonzero(np.abs(p) + np.abs(q) < 6):
        wanted = [place[p[i] + a, q[i] + b] for a, b in STEPS.tolist()]
        assert found.neighbours[i].tolist() == wanted
    assert not found.fault.any()
    assert (found.side == 1).all()
    # On average over the eye; circles of latitude bend by under a degree.
    wanted = np.radians([0, 60, 120, 180, 240, 300])
    off = (found.angle_rad[0] - wanted + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(np.degrees(off), 0, atol=2)


@pytest.mark.parametrize("by", ["surface", "direction"])
def test_directions_are_what_they_are_called(by):
    eye, _, _ = upright()
    found = hexagonal_coordinates(eye, by)
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)

    def steps(name):
        has = found.neighbours[:, COLUMN[name]] >= 0
        other = found.neighbours[has, COLUMN[name]]
        return azimuth[other] - azimuth[has], elevation[other] - elevation[has]

    sideways, up = steps("v")
    np.testing.assert_allclose(sideways, 0, atol=1e-4)
    np.testing.assert_allclose(up, 2, atol=1e-4)
    to_front, up = steps("q")
    np.testing.assert_allclose(to_front, -np.sqrt(3), atol=1e-4)
    np.testing.assert_allclose(up, 1, atol=1e-4)
    to_back, up = steps("p")
    np.testing.assert_allclose(to_back, np.sqrt(3), atol=1e-4)
    np.testing.assert_allclose(up, 1, atol=1e-4)


def test_left_is_the_mirror_image_of_right():
    right, p, _ = upright()
    head = omma.eye.pair_of_eyes(right)
    found = hexagonal_coordinates(head)
    left, mine = np.flatnonzero(head.eye_id == 0), np.flatnonzero(head.eye_id == 1)
    assert (found.side[left] == -1).all()
    for values in (found.p, found.q, found.fault):
        assert np.array_equal(values[left], values[mine])
    others = np.where(found.neighbours[mine] >= 0, found.neighbours[mine] - len(left), -1)
    assert np.array_equal(found.neighbours[left], others)
    assert np.array_equal(np.sort(np.unique(found.p[mine][found.known[mine]])), np.unique(p))


def test_horizontal_rows():
    row, column = np.mgrid[-8:9, -8:9]
    eye = eye_of(60 + 2 * (column + 0.5 * (row % 2)), np.sqrt(3) * row)
    found = hexagonal_coordinates(eye)
    assert_consistent(found)
    front = found.towards(np.pi / 2)
    has = front >= 0
    assert has.mean() > 0.85
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)
    np.testing.assert_allclose(azimuth[front[has]] - azimuth[has], -2, atol=1e-4)
    np.testing.assert_allclose(elevation[front[has]], elevation[has], atol=1e-4)
    assert np.array_equal(front, found.neighbours[:, COLUMN["q"]])


def test_a_hole_is_passed_around():
    eye, p, q = upright()
    kept = np.flatnonzero((p != 2) | (q != 1))
    found = hexagonal_coordinates(eye.take(kept))
    assert_consistent(found)
    known = found.known
    # The triangulation bridges the hole; those around it are faults, the others count on.
    assert 1 <= found.fault.sum() <= 6
    assert known.mean() > 0.96
    assert np.array_equal(found.p[known], p[kept][known])
    assert np.array_equal(found.q[known], q[kept][known])


# What was found when it was written, less a hundredth: eyes have faults where rows end.
@pytest.mark.parametrize(
    ("name", "by", "known", "whole"),
    [("honeybee_worker", "surface", 0.94, 0.82), ("drosophila", "direction", 0.91, 0.59)],
)
def test_species(name, by, known, whole):
    found = coordinates(name, by)
    assert_consistent(found)
    assert found.known.mean() > known
    assert (found.neighbours >= 0).all(axis=1).mean() > whole
    # A neighbour is a step away, but across the seams behind faults.
    own, column = np.nonzero(found.neighbours >= 0)
    other = found.neighbours[own, column]
    both = found.known[own] & found.known[other]
    step = np.stack([found.p[other] - found.p[own], found.q[other] - found.q[own]], axis=1)
    assert np.mean((step == STEPS[column]).all(axis=1)[both]) > 0.96


def test_a_designed_eye():
    seen = omma.eye.window(azimuth_deg=(-10, 100), elevation_deg=(-50, 50))
    axes = omma.eye.lay_directions(np.radians(3), field_of_view=seen).directions
    found = hexagonal_coordinates(omma.eye.eye_on_surface(axes, omma.eye.surfaces.sphere(1e-3)))
    assert_consistent(found)
    # Found 0.91 and 0.042: rows begin and end where circles of longitude draw together.
    assert found.known.mean() > 0.88
    assert found.fault.mean() < 0.06


def test_other_lattices_have_none():
    azimuth, elevation = np.meshgrid(np.arange(-30, 31, 2.0), np.arange(-30, 31, 2.0))
    random = np.random.default_rng(0)
    scattered = random.normal(size=(1000, 3))
    scattered /= np.linalg.norm(scattered, axis=1, keepdims=True)
    one_row = eye_of(np.arange(0, 60, 2.0), np.zeros(30))
    for eye in (
        eye_of(azimuth, elevation),
        omma.Eye(1e-3 * scattered, scattered, 0.1),
        one_row,
        one_row.take([0]),
    ):
        found = hexagonal_coordinates(eye)
        assert not found.known.any()
        assert (found.neighbours == -1).all()
        assert np.isnan(found.angle_rad).all()
        assert (found.towards(0.0) == -1).all()


def test_positions_in_one_place_have_directions():
    eye, p, _ = upright()
    eye = eye.replace(position_m=np.zeros((len(eye), 3)))
    assert not hexagonal_coordinates(eye).known.any()
    found = hexagonal_coordinates(eye, "direction")
    assert np.array_equal(found.p[found.known], p[found.known])


def test_wrong_arguments():
    eye, _, _ = upright()
    with pytest.raises(omma.Error, match="by: expected one of surface, direction"):
        hexagonal_coordinates(eye, "sideways")
    with pytest.raises(TypeError, match=r"eye: expected omma\.Eye"):
        hexagonal_coordinates("bee")
