"""Projections from Python: pictures and ids, maps kept and never stale, forward formulas."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.picture import kept_ids

SIX = np.array([[0, 0, -1], [1, 0, 0], [0, 0, 1], [-1, 0, 0], [0, 1, 0], [0, -1, 0]], np.float32)
NAMES = [name for name in omma.picture.PROJECTIONS if name != "raw_ommatidial_samples"]


def six(eye_id=0):
    return omma.Eye(SIX * 1e-3, SIX, 0.1, 0.0, eye_id)


@pytest.fixture(autouse=True)
def forget():
    kept_ids._kept.clear()


@pytest.mark.parametrize("name", NAMES)
def test_a_picture_is_its_ids_painted(name):
    eye = six()
    responses = np.random.default_rng(0).random((6, 3)).astype(np.float32) * 2
    ids = omma.picture.projection_ids(eye, name, 64, 32)
    assert ids.shape == (32, 64)
    assert ids.dtype == np.int32
    assert set(ids.ravel().tolist()) <= set(range(-1, 6))
    assert set(range(6)) <= set(ids.ravel().tolist())
    picture = omma.picture.project(eye, responses, name, 64, 32)
    assert picture.dtype == np.uint8
    seen = ids >= 0
    assert (picture[seen] == omma.picture.paint(ids, responses)[seen]).all()
    assert (picture == omma.picture.project(eye, responses[np.newaxis], name, 64, 32)).all()
    assert (
        omma.picture.project(eye, responses, name, 64, 32, gamma=1)[ids == 0][0]
        == np.clip(np.rint(responses[0].astype(float) * 255), 0, 255)
    ).all()
    linear = omma.picture.project(eye, responses, name, 64, 32, linear=True)
    assert linear.dtype == np.float32
    assert np.nanmax(linear) > 1  # not clipped
    assert (linear[ids >= 0] == responses[ids[ids >= 0]]).all()
    assert np.isnan(linear[ids < 0]).all()


@pytest.mark.parametrize("name", omma.picture.PROJECTIONS)
def test_ids_as_a_picture(name):
    eye = make_eye(300)
    ids = omma.picture.projection_ids(eye, name, 320, 64)
    picture = omma.picture.project(eye, None, name + "_ids", 320, 64)
    assert picture.shape == (64, 320, 4)
    assert picture.dtype == np.uint8
    assert (picture.view(">i4")[..., 0] == ids).all()
    assert (omma.picture.encode_ids([[258, -1]]) == [[[0, 0, 1, 2], [255] * 4]]).all()


def test_raw_samples_are_the_rays(renderer, flight):
    rays = renderer.render_rays(flight[0])
    ommatidia, samples = rays.shape[1:3]
    assert samples == 8
    linear = omma.picture.project(renderer.eye, rays, "raw_ommatidial_samples", linear=True)
    assert linear.shape == (samples, ommatidia, 3)
    assert (linear == rays[0].transpose(1, 0, 2)).all()
    assert linear.std(axis=0).max() > 0
    padded = omma.picture.project(renderer.eye, rays[0], "raw_ommatidial_samples", 100, 20)
    assert padded.shape == (20, 100, 3)
    plain = omma.picture.project(renderer.eye, rays, "raw_ommatidial_samples")
    assert (padded[:samples, :ommatidia] == plain).all()
    assert (padded[samples:] == 128).all()
    assert (padded[:, ommatidia:] == 128).all()


@pytest.mark.parametrize(
    ("name", "size", "shape"),
    [
        ("spherical_orientationwise", (None, None), (512, 1024)),
        ("facets", (300, None), (150, 300)),
        ("hemisphere_ids", (None, 100), (100, 200)),
        ("lambert", (None, None), (1024, 1024)),
        ("lambert", (30, None), (30, 30)),
        ("lambert", (None, 30), (30, 30)),
        ("mollweide", (30, 70), (70, 30)),
        ("single_dimension", (1, None), (1, 1)),
        ("single_dimension_fast", (None, None), (1, 6)),
        ("raw_ommatidial_samples", (None, 5), (5, 6)),
    ],
)
def test_sizes_left_out(name, size, shape):
    assert omma.picture.projection_ids(six(), name, *size).shape == shape


def test_maps_are_kept():
    eye = make_eye(200)
    first = omma.picture.projection_ids(eye, "mollweide", 64, 32)
    assert omma.picture.projection_ids(eye, "mollweide", 64, 32) is first
    assert omma.picture.projection_ids(eye, "mollweide_ids", 64) is first
    # The same eye made anew is the same eye.
    assert omma.picture.projection_ids(make_eye(200), "mollweide", 64, 32) is first
    assert omma.picture.projection_ids(eye, "mollweide", 64, 33) is not first
    assert omma.picture.projection_ids(eye, "lambert", 64, 32) is not first
    with pytest.raises(ValueError, match="read-only"):
        first[0, 0] = 1


def test_no_map_is_that_of_another_eye():
    eye = make_eye(200)
    arrays = {
        "position_m": eye.position_m,
        "axis": eye.axis,
        "acceptance_angle_rad": eye.acceptance_angle_rad,
        "eye_id": eye.eye_id,
    }
    first = omma.picture.projection_ids(eye, "hemisphere", 64, 32)
    for name in arrays:
        changed = {key: value.copy() for key, value in arrays.items()}
        changed[name] = changed[name][::-1].copy() if name != "eye_id" else arrays["eye_id"] + 1
        if name == "acceptance_angle_rad":
            changed[name][3] = 0.7
        assert omma.picture.projection_ids(omma.Eye(**changed), "hemisphere", 64, 32) is not first
    # An eye in the memory of one that is gone, many times.
    for seed in range(30):
        short = make_eye(40, seed=seed)
        ids = omma.picture.projection_ids(short, "spherical_orientationwise", 16, 8)
        assert (ids == omma._core.projection_ids(short, "spherical_orientationwise", 16, 8)).all()
        del short


def test_what_is_kept_is_bounded(monkeypatch):
    monkeypatch.setattr(kept_ids, "_MOST_KEPT_BYTES", 3 * 64 * 32 * 4)
    eye = six()
    maps = [omma.picture.projection_ids(eye, name, 64, 32) for name in NAMES]
    assert len(kept_ids._kept) == 3
    assert omma.picture.projection_ids(eye, NAMES[-1], 64, 32) is maps[-1]
    omma.picture.projection_ids(eye, "facets", 640, 320)  # larger than the bound: kept alone
    assert len(kept_ids._kept) == 1


def mollweide(direction):
    """Forward formulas, x and y from -1 to 1: 2 t + sin 2 t = pi sin(elevation) by Newton."""
    azimuth = np.arctan2(direction[:, 0], -direction[:, 2])
    goal = np.pi * direction[:, 1]
    t = np.arcsin(direction[:, 1])
    for _ in range(50):
        t -= (2 * t + np.sin(2 * t) - goal) / (2 + 2 * np.cos(2 * t))
    return azimuth / np.pi * np.cos(t), np.sin(t)


def lambert(direction, ahead=(0, 0, -1), right=(1, 0, 0)):
    """Forward formulas: the distance from the middle is sin(angle / 2), 1 for the whole sphere."""
    along = direction @ ahead
    x, y = direction @ right, direction[:, 1]
    scale = np.sqrt((1 - along) / 2) / np.hypot(x, y)
    return x * scale, y * scale


def left_disc(direction):
    x, y = lambert(direction, (-1, 0, 0), (0, 0, -1))
    return (x * np.sqrt(2) - 1) / 2, y * np.sqrt(2)


def right_disc(direction):
    x, y = lambert(direction, (1, 0, 0), (0, 0, 1))
    return (x * np.sqrt(2) + 1) / 2, y * np.sqrt(2)


@pytest.mark.parametrize(
    ("name", "forward", "side"),
    [
        ("mollweide", mollweide, None),
        ("lambert", lambert, None),
        ("hemisphere", left_disc, -1),
        ("hemisphere", right_disc, 1),
    ],
)
def test_forward_formulas_lead_to_the_right_pixel(name, forward, side):
    # Dense and wide enough to see everywhere; random directions and where they should be drawn.
    eye = make_eye(500, acceptance_deg=60)
    rng = np.random.default_rng(5)
    direction = rng.normal(size=(4000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    # Not the very rim of ellipse and disc, where the pixel's centre may lie outside.
    direction = direction[(np.abs(direction[:, 1]) < 0.99) & (direction[:, 2] < 0.99)]
    if side is not None:
        direction = direction[direction[:, 0] * side > 0.02]
    width, height = (1600, 1600) if name == "lambert" else (3200, 1600)
    ids = omma.picture.projection_ids(eye, name, width, height)
    x, y = forward(direction)
    column = ((x + 1) / 2 * width).astype(int)
    row = ((1 - y) / 2 * height).astype(int)
    shown = ids[row, column]
    cosine = direction @ eye.axis.T.astype(np.float64)
    # A pixel is 0.1 degrees wide in the middle, up to 2 near the rim; axes are 10 degrees apart:
    # a few directions lie in the pixel of a neighbour, which then is nearly as near.
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    shown_angle = angle[np.arange(len(direction)), shown]
    assert (shown >= 0).all()
    assert (shown == angle.argmin(axis=1)).mean() > 0.95
    assert (shown_angle - angle.min(axis=1)).max() < 1.5


def test_the_old_names_are_the_same_pictures():
    eye = make_eye(100)
    responses = np.random.default_rng(0).random((100, 3))
    for by, name in (("axis", "spherical_orientationwise"), ("position", "spherical_positionwise")):
        assert (
            omma.picture.equirectangular(eye, responses, 64, 32, by=by)
            == omma.picture.project(eye, responses, name, 64, 32)
        ).all()


def test_two_eyes_in_one_file_are_two_eyes():
    axis = make_eye(200).axis
    right = axis[axis[:, 0] > 0.2]
    left = right * [-1, 1, 1]
    position = np.concatenate([left - [1, 0, 0], right + [1, 0, 0]]) * 1e-3
    both = omma.Eye(position, np.concatenate([left, right]), 0.1)
    numbers = np.repeat([7, 3], len(right))
    numbered = omma.Eye(position, both.axis, 0.1, 0.0, numbers)
    for name in ("facets", "hemisphere"):
        ids = omma.picture.projection_ids(both, name, 400, 200)
        assert (ids == omma.picture.projection_ids(numbered, name, 400, 200)).all()
        assert (ids[:, :200] < len(left)).all()
        assert (ids[:, 200:][ids[:, 200:] >= 0] >= len(left)).all()


POINT = omma.Eye(np.zeros((6, 3)), SIX, 0.1)


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (
            lambda: omma.picture.projection_ids(six(), "peters"),
            "projection: expected one of single_dim",
        ),
        (lambda: omma.picture.project(six(), np.zeros((6, 3)), ""), "found ''"),
        (
            lambda: omma.picture.project(six(), np.zeros((5, 3))),
            r"responses: expected shape \(6, 3\)",
        ),
        (
            lambda: omma.picture.project(six(), None, "facets_ids", linear=True),
            "linear: facets_ids shows",
        ),
        (lambda: omma.picture.projection_ids(six(), "facets", 0), "width"),
        (lambda: omma.picture.projection_ids(six(), "facets", 8, 0), "height"),
        (lambda: omma.picture.projection_ids(six(), "facets", 1 << 20, 1 << 20), "2\\^30"),
        (
            lambda: omma.picture.projection_ids(six(), "single_dimension_fast", 5),
            "width must be at least",
        ),
        (
            lambda: omma.picture.projection_ids(POINT, "facets"),
            "positions of eye 0 lie in one point",
        ),
        (lambda: omma.picture.projection_ids(POINT, "cylindrical"), "the same height"),
        (lambda: omma.picture.projection_ids(POINT, "spherical_positionwise"), "in one point"),
        (
            lambda: omma.picture.project(six(), np.zeros((6, 3)), "raw_ommatidial_samples"),
            r"takes the rays of one pose, shape \(6, samples, 3\), found \(6, 3\)",
        ),
        (
            lambda: omma.picture.project(
                six(), np.zeros((6, 9, 3)), "raw_ommatidial_samples", 6, 8
            ),
            "height: expected at least the 9 samples, found 8",
        ),
        (lambda: omma.picture.encode_ids([1, 2]), "ids"),
    ],
)
def test_wrong_arguments(call, word):
    with pytest.raises(omma.Error, match=word):
        call()
