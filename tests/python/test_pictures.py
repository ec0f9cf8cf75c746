"""Pictures: which ommatidium a pixel shows, and how it is painted."""

import numpy as np
import pytest
from conftest import make_eye
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import omma
from omma import _core
from omma.picture.unseen import hatch, hatching


def pixel_directions(width, height):
    """(height, width, 3), from the definition: azimuth to the right, elevation up, ahead is -Z."""
    azimuth = ((np.arange(width) + 0.5) / width * 2 - 1) * np.pi
    elevation = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
    a, e = np.meshgrid(azimuth, elevation)
    return np.stack([np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)], axis=-1)


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 200), st.integers(0, 100))
def test_each_pixel_takes_the_nearest_axis(count, seed):
    eye = make_eye(count, seed)
    ids = omma.picture.equirectangular_ids(eye, 48, 24)
    cosine = pixel_directions(48, 24) @ eye.axis.T.astype(np.float64)
    chosen = np.take_along_axis(cosine, ids[..., None], axis=-1)[..., 0]
    # Equal up to the float32 rounding of pixel directions.
    assert (chosen >= cosine.max(axis=-1) - 1e-6).all()


def test_by_position():
    # Axes say one thing, positions the opposite.
    axis = make_eye(50).axis
    eye = omma.Eye(-axis * 1e-3, axis, 0.1)
    centred = -axis + axis.mean(axis=0)
    centred /= np.linalg.norm(centred, axis=1, keepdims=True)
    ids = omma.picture.equirectangular_ids(eye, 48, 24, by="position")
    cosine = pixel_directions(48, 24) @ centred.T.astype(np.float64)
    chosen = np.take_along_axis(cosine, ids[..., None], axis=-1)[..., 0]
    # The centroid is rounded to float32 of a millimetre: 1e-7 of the distance, some times over.
    assert (chosen >= cosine.max(axis=-1) - 3e-6).all()


def test_north_up_east_right():
    eye = omma.Eye(np.zeros((4, 3)), [[-1, 0.3, 0], [1, 0.3, 0], [-1, -0.3, 0], [1, -0.3, 0]], 0.1)
    colours = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], np.float32)
    picture = omma.picture.equirectangular(eye, colours, 8, 4)
    assert picture.shape == (4, 8, 3)
    assert picture.dtype == np.uint8
    corners = [picture[0, 2], picture[0, 5], picture[3, 2], picture[3, 5]]
    assert [corner.tolist() for corner in corners] == (colours * 255).tolist()


def test_gamma_and_clamp():
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1)
    responses = [[0.25, 7.0, -1.0]]
    assert omma.picture.equirectangular(eye, responses, 2, 1, gamma=2)[0, 0].tolist() == [
        128,
        255,
        0,
    ]
    assert omma.picture.equirectangular(eye, responses, 2, 1, gamma=1)[0, 0].tolist() == [
        64,
        255,
        0,
    ]


def is_hatched(picture, where):
    """Whether these pixels have two greys, neither for long in a row or a column."""
    levels = picture[where]
    grey = (levels == levels[:, :1]).all()
    two = np.unique(levels[:, 0])
    dark = np.where(where, picture[..., 0] == two[0], False)
    return grey and len(two) == 2 and 0.1 < dark[where].mean() < 0.4


def test_limit_of_angle():
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1)
    ids = omma.picture.equirectangular_ids(eye, 360, 180, max_angle_deg=30)
    seen = ids >= 0
    # A cap of 30 degrees: 2 pi (1 - cos 30) of 4 pi; pixels are 1 degree wide.
    weight = np.cos(np.radians(89.5 - np.arange(180)))
    fraction = (seen.mean(axis=1) * weight).sum() / weight.sum()
    assert fraction == pytest.approx((1 - np.cos(np.radians(30))) / 2, rel=0.02)
    picture = omma.picture.equirectangular(eye, [[1, 1, 1]], 360, 180, max_angle_deg=30)
    assert (picture[seen] == 255).all()
    assert is_hatched(picture, ~seen)


def test_field_ends_a_facet_beyond_the_last_axis():
    eye = omma.Eye(np.zeros((2, 3)), [[0, 0, -1], [np.sin(0.2), 0, -np.cos(0.2)]], 0.05)
    ids = omma.picture.field_ids(eye, 720, 360)
    row = ids[180]  # just below the horizon
    azimuth = ((np.arange(720) + 0.5) / 720 * 2 - 1) * np.pi
    # Half a pixel of 0.5 degrees, twice.
    assert azimuth[row >= 0].min() == pytest.approx(-0.2, abs=0.01)
    assert azimuth[row >= 0].max() == pytest.approx(0.4, abs=0.01)
    assert set(ids.ravel().tolist()) == {-1, 0, 1}


def test_side_by_side_has_the_left_eye_left():
    right = omma.Eye([[0, 0, 0]], [[1, 0, 0]], np.radians(60))
    left = omma.Eye([[0, 0, 0]], [[-1, 0, 0]], np.radians(60))
    head = omma.eye.merge_eyes([right, left])
    picture = omma.picture.side_by_side(head, [[1, 0, 0], [0, 0, 1]], 40, 20)
    assert picture.shape == (20, 80, 3)
    assert picture[10, 10].tolist() == [0, 0, 255]  # left panel, looking left
    assert picture[10, 70].tolist() == [255, 0, 0]  # right panel, looking right
    hidden = omma.picture.id_maps.side_by_side_ids(head, 40, 20) < 0
    assert hidden[10, 30]  # the left eye does not see the right
    assert hidden[10, 50]
    assert is_hatched(picture, hidden)


def test_responses_of_a_render_can_be_painted(renderer, flight, tmp_path):
    responses = renderer.render(flight[0])
    picture = omma.picture.equirectangular(renderer.eye, responses, 64, 32)
    assert (picture == omma.picture.equirectangular(renderer.eye, responses[0], 64, 32)).all()
    ids = omma.picture.equirectangular_ids(renderer.eye, 64, 32)
    assert (ids >= 0).all()
    assert (picture == omma.picture.paint(ids, responses[0])).all()
    omma.save_png(tmp_path / "a.png", picture)
    back = omma.Background.image(tmp_path / "a.png")
    assert "64 x 32" in repr(back)


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (
            lambda e: omma.picture.equirectangular(e, np.zeros((3, 3))),
            r"responses: expected shape \(60, 3\)",
        ),
        (lambda e: omma.picture.equirectangular(e, np.zeros((2, 60, 3))), r"found \(2, 60, 3\)"),
        (lambda e: omma.picture.equirectangular(e, np.zeros((60, 3)), gamma=0), "gamma"),
        (lambda e: omma.picture.equirectangular(e, np.zeros((60, 3)), 0), "width"),
        (lambda e: omma.picture.equirectangular(e, np.zeros((60, 3)), 1 << 40), "width"),
        (lambda e: omma.picture.equirectangular_ids(e, 8, -1), "height"),
        (
            lambda e: omma.picture.equirectangular_ids(e, by="colour"),
            "by: expected 'axis' or 'position'",
        ),
        (lambda e: omma.picture.equirectangular_ids(e, max_angle_deg=-1), "max_angle_deg"),
        (lambda e: omma.picture.paint([[60]], np.zeros((60, 3))), "ids: expected numbers under 60"),
        (lambda e: omma.picture.paint([[0]], np.zeros((60, 4))), r"responses: .*\(N, 3\)"),
        (
            lambda e: omma.save_png("no/such/x.png", np.zeros((2, 2, 3))),
            r"pixels: expected uint8.*float64.*omma\.picture\.display",
        ),
        (lambda e: omma.save_png("no/such/x.png", np.zeros((2, 2), np.uint8)), "pixels"),
        (lambda e: omma.save_png("no/such/x.png", np.zeros((2, 2, 3), np.uint8)), "no/such/x.png"),
    ],
)
def test_wrong_arguments(eye, call, word):
    with pytest.raises(omma.Error, match=word):
        call(eye)


def two_fans(middle_deg):
    """A left and a right eye with axes each 10° over 100°, their middles so far to each side."""
    from omma.base.directions import direction

    azimuth, elevation = (each.ravel() for each in np.mgrid[-50:51:10, -50:51:10])
    eyes = [
        omma.Eye(np.zeros((len(azimuth), 3)), direction(azimuth + side, elevation), 0.1)
        for side in (-middle_deg, middle_deg)
    ]
    return omma.eye.merge_eyes(eyes)


def test_default_picture_is_empty_where_nothing_is_seen_and_has_overlapping_eyes_apart():
    near, far = two_fans(30), two_fans(90)
    assert omma.picture.projection_ids(far, None, 72).shape == (36, 72)
    assert (
        omma.picture.projection_ids(far, None, 72, 36) == omma.picture.field_ids(far, 72, 36)
    ).all()
    picture = omma.picture.project(near, np.ones((len(near), 3)), None, 72)
    assert picture.shape == (36, 144, 3)
    assert (picture == omma.picture.side_by_side(near, np.ones((len(near), 3)), 72, 36)).all()
    # 5° a pixel. Straight ahead is 30° from the middle of both; straight behind nothing is.
    for panel in (picture[:, :72], picture[:, 72:]):
        assert (panel[18, 36] == 255).all()
    hidden = omma.picture.projection_ids(near, None, 72) < 0
    assert hidden[18, [0, 72]].all()
    assert hidden[0].all()
    assert is_hatched(picture, hidden)


def test_gaps_smaller_than_a_cell_are_closed_also_over_the_seam():
    from omma.picture.fields import without_gaps

    seen = np.ones((10, 20), bool)
    seen[2, 5:7] = False  # 2
    seen[5, 0] = seen[5:7, 19] = False  # 3 in one, over the seam
    seen[8, 3:9] = False  # 6
    each = np.full((10, 1), 0.5)
    closed = without_gaps(seen, each, 0.9)
    assert (closed == seen).all()
    closed = without_gaps(seen, each, 1.4)
    assert closed[2].all()
    assert not closed[5, 0]
    assert not closed[6, 19]
    closed = without_gaps(seen, each, 1.6)
    assert closed[:8].all()
    assert (closed[8] == seen[8]).all()


@pytest.mark.parametrize("projection", ["mollweide", "lambert", "hemisphere", "cylindrical"])
def test_what_nobody_sees_is_hatched_for_people_and_plain_for_programs(projection):
    from omma.picture.unseen import inside_outline

    upper = make_eye(3000, acceptance_deg=8)
    upper = upper.take(np.flatnonzero(upper.axis[:, 1] > 0.3).tolist())
    white = np.ones((len(upper), 3), np.float32)
    ids = omma.picture.projection_ids(upper, projection, 200)
    picture = omma.picture.project(upper, white, projection, 200)
    inside = inside_outline(projection, *ids.shape)
    if projection != "cylindrical":  # whose picture is as high as the eye
        assert is_hatched(picture, (ids < 0) & inside)
    assert (picture[ids >= 0] == 255).all()
    assert (picture[~inside] == 128).all()  # outside of the map there are no directions
    linear = omma.picture.project(upper, white, projection, 200, linear=True)
    assert (np.isnan(linear).all(axis=2) == (ids < 0)).all()
    assert (omma.picture.paint(ids, white)[ids < 0] == 128).all()


def test_facets_have_nothing_to_miss_around_them():
    eye = omma.eye.generate_eye(100)
    ids = omma.picture.projection_ids(eye, "facets", 200)
    picture = omma.picture.project(eye, np.ones((100, 3)), "facets", 200)
    assert (picture[ids < 0] == 128).all()


def letters(monkeypatch):
    """What is written on pictures from now on, and where: (x, y, text)."""
    from PIL import ImageDraw

    said = []
    write = ImageDraw.ImageDraw.text

    def watched(self, xy, text, *arguments, **options):
        said.append((*xy, text))
        return write(self, xy, text, *arguments, **options)

    monkeypatch.setattr(ImageDraw.ImageDraw, "text", watched)
    return said


def test_a_picture_for_people_has_borders_names_and_degrees(monkeypatch):
    said = letters(monkeypatch)
    near, far = two_fans(30), two_fans(90)
    responses = np.random.default_rng(1).random((len(near), 3))
    plain = omma.picture.project(near, responses, None, 400)
    picture = omma.picture.framed(near, responses, 400)
    words = [text for *_, text in said]
    assert words[0] == "L  left eye"
    assert "R  right eye" in words
    assert [words.count(each) for each in ("left -90°", "ahead 0°", "right 90°")] == [2, 2, 2]
    assert {"90°", "60°", "0°", "-90°", "azimuth", "elevation"} <= set(words)
    # Both panels are in it as they are, apart from each other, in a border.
    corner = {}
    for side, panel in (("L", plain[:, :400]), ("R", plain[:, 400:])):
        y, x = find(picture, panel)
        corner[side] = x
        border = picture[y - 1 : y + 201, x - 1 : x + 401].copy()
        border[1:-1, 1:-1] = 34
        assert (border == 34).all()
        # Straight ahead is named in the middle, the right to the right of it.
        ahead = [at for at, _, text in said if text == "ahead 0°"]
        assert min(abs(at - (x + 200)) for at in ahead) <= 1
    assert corner["R"] - corner["L"] > 410
    assert (picture[y : y + 200, corner["L"] + 405] == 255).all()  # paper
    # Where no direction is seen by two, one panel has both; or two, where they are asked for.
    said.clear()
    one = omma.picture.framed(far, responses, 400)
    assert not any("eye" in text for *_, text in said)
    find(one, omma.picture.project(far, responses, None, 400))
    find(omma.picture.framed(far, responses, 400, apart=True),
         omma.picture.side_by_side(far, responses, 400, 200)[:, :400])  # fmt: skip


def find(picture, panel):
    """Row and column at which a panel stands in a picture."""
    height, width = panel.shape[:2]
    for y in range(picture.shape[0] - height + 1):
        for x in range(picture.shape[1] - width + 1):
            if (picture[y : y + height, x] == panel[:, 0]).all() and (
                picture[y : y + height, x : x + width] == panel
            ).all():
                return y, x
    raise AssertionError("the panel is not in the picture")


@pytest.mark.parametrize("width", [1, 12, 60, 200, 1500])
def test_labels_never_touch(monkeypatch, width):
    from omma.picture import frame

    said = letters(monkeypatch)
    omma.picture.framed(two_fans(30), np.ones((242, 3)), width)
    font = frame._font(max(min(max(width // 2, 1) // 20, 48), 9))
    below = {}
    for x, y, text in said:
        if text.endswith("°"):
            below.setdefault(y, []).append((x, font.getlength(text) / 2))
    rows = [sorted(row) for row in below.values() if len(row) > 3]
    assert rows or width < 12
    for row in rows if width >= 60 else []:
        for (x, half), (after, other) in zip(row[:-1], row[1:], strict=True):
            assert x + half < after - other


def test_an_ommatidium_that_no_pixel_shows_is_a_dot_with_its_number(monkeypatch):
    said = letters(monkeypatch)
    eye = omma.Eye(np.zeros((1, 3)), [[0, 0, -1]], 0.0)
    assert (omma.picture.projection_ids(eye, width=200) < 0).all()
    picture = omma.picture.framed(eye, [[1, 0, 0]], 200)
    assert "0" in [text for *_, text in said]
    _row, column = (each.mean() for each in np.nonzero((picture == (255, 0, 0)).all(axis=2)))
    ahead = [x for x, _, text in said if text == "ahead 0°"]
    assert column == pytest.approx(ahead[0], abs=1.5)


@pytest.mark.parametrize("channels", [3, 4])
def test_pngs_of_patches_hold_the_pixels(tmp_path, channels):
    pixels = np.zeros((37, 53, channels), np.uint8)
    pixels[:20, :31] = np.arange(1, 1 + channels)
    pixels[20:, 9:] = 250
    pixels[36, 52] = 7
    path = tmp_path / "patches.png"
    path.write_bytes(_core.encode_png(path, pixels, quick=True))
    assert np.array_equal(np.asarray(Image.open(path)), pixels)


def test_hatching_of_many_is_that_of_one():
    where = np.random.default_rng(1).random((30, 50)) < 0.4
    hatched = hatching(where)
    for seed in (2, 3):
        pixels = np.random.default_rng(seed).integers(0, 255, (30, 50, 3), np.uint8)
        expected = hatch(pixels.copy(), where)
        assert np.array_equal(hatched(pixels), expected)
