"""Figures of responses: what is shown of them, and that they are written."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.picture import response_axes, response_colours

pytest.importorskip("matplotlib")


def bee():
    types = [
        omma.receptors.ReceptorType("uv", peak_wavelength_nm=344),
        omma.receptors.ReceptorType("green", peak_wavelength_nm=544),
        omma.receptors.ReceptorType("blue", peak_wavelength_nm=436),
    ]
    axis = [[0, 0, -1], [0.1, 0, -0.995], [-1, 0, 0]]
    # The second has no blue one, the third no uv.
    return omma.Eye(
        np.zeros((3, 3)), axis, 0.1, receptor_types=types, receptors=[[0, 1, 1, 2], [0, 1], [1, 2]]
    )


def test_receptors_are_shown_by_wavelength_and_taken_from_the_nearest_that_has_them():
    eye = bee()
    responses = np.array([1.0, 2, 4, 5, 6, 7, 8, 9])
    shown = response_colours.receptors_shown(eye, responses, None, "responses")
    assert shown.names == ("green (544 nm)", "blue (436 nm)", "uv (344 nm)")
    assert shown.values.tolist() == [[[3, 5, 1], [7, 5, 6], [8, 9, 1]]]
    shown = response_colours.receptors_shown(eye, responses, ["uv"], "responses")
    assert shown.values.shape == (1, 3, 1)
    assert shown.values[0, :, 0].tolist() == [1, 6, 1]


def test_two_channels_are_yellow_and_blue():
    colours = response_colours.as_colours(np.array([[2.0, 0], [0, 1], [4, 4]]), 2.0, 1.0)
    assert colours.tolist() == [[1, 1, 0], [0, 0, 0.5], [1, 1, 1]]


@pytest.mark.parametrize("projection", ["mollweide", "lambert", "hemisphere"])
def test_what_lies_outside_a_map_is_what_shows_no_ommatidium(projection):
    # An eye that sees everything: all that is empty is outside the map.
    eye = make_eye(400)
    eye = eye.replace(acceptance_angle_rad=np.full(400, 3.1))
    ids = omma.picture.projection_ids(eye, projection, 200)
    inside = response_axes.inside_picture(projection, *ids.shape)
    # A pixel in the very rim may fall either way by rounding.
    assert (inside == (ids >= 0)).mean() > 0.999


def test_hemispheres_have_directions_where_the_picture_has_them():
    for azimuth, elevation, middle in ((-90, 0, -1.0), (-90, 45, -1.0), (150, 10, 1.0)):
        axis = [response_axes.direction(azimuth, elevation)]
        eye = omma.Eye(np.zeros((1, 3)), axis, np.radians(4))
        ids = omma.picture.projection_ids(eye, "hemisphere", 400, 200)
        row, column = (each.mean() for each in np.nonzero(ids >= 0))
        x, y = response_axes._on_disc(np.array(float(azimuth)), np.array(float(elevation)), middle)
        # Pixels are 0.01 wide; the cap's middle moves a little with the projection.
        assert (column + 0.5) / 100 - 2 == pytest.approx(float(x), abs=0.02)
        assert 1 - (row + 0.5) / 100 == pytest.approx(float(y), abs=0.02)


@pytest.mark.parametrize(
    "projection",
    [None, *(p for p in omma.picture.PROJECTIONS if p != "raw_ommatidial_samples")],
)
def test_every_projection_is_drawn(tmp_path, projection):
    eye = make_eye(200)
    responses = np.random.default_rng(0).random((2, 200, 3))
    omma.picture.plot_responses(
        [tmp_path / "a.png", tmp_path / "a.svg"], eye, responses, errors=responses / 10,
        projection=projection,
    )  # fmt: skip
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert (tmp_path / "a.svg").stat().st_size > 1000


def test_several_eyes_have_one_scale(tmp_path, monkeypatch):
    from omma.picture import response_plots

    limits = []
    draw = response_plots._draw

    def watched(*arguments):
        marks = draw(*arguments)
        limits.append(marks.get_clim())
        return marks

    monkeypatch.setattr(response_plots, "_draw", watched)
    eyes = [make_eye(50), make_eye(80)]
    responses = [np.full((50, 3), 0.25), np.full((80, 3), 4.0)]
    omma.picture.plot_responses(tmp_path / "a.png", eyes, responses, channels=[1])
    assert limits == [(0, 4), (0, 4)]


@pytest.mark.parametrize("full_scale", [1.0, 3e17, 2e-5])
def test_scales_of_photons_have_their_power_of_ten_in_the_label(tmp_path, monkeypatch, full_scale):
    from omma.picture import response_plots

    figures = []
    monkeypatch.setattr(response_plots, "save_figure", lambda one, *_, **__: figures.append(one))
    responses = np.full((50, 3), full_scale)
    omma.picture.plot_responses(tmp_path / "a.png", make_eye(50), responses, full_scale=full_scale)
    figures[0].canvas.draw()
    scale = figures[0].axes[-1]
    shown = [float(label.get_text()) for label in scale.get_xticklabels()]
    power = {1.0: "", 3e17: ", $10^{17}$", 2e-5: ", $10^{-5}$"}[full_scale]
    assert scale.get_xlabel() == f"response (display gamma 2.2){power}"
    unit = {1.0: 1.0, 3e17: 1e17, 2e-5: 1e-5}[full_scale]
    assert shown == pytest.approx(scale.get_xticks() / unit)
    assert scale.xaxis.get_offset_text().get_text() == ""


@pytest.mark.parametrize(
    ("brightest", "end", "words"), [(500.0, 1.0, ", brighter cut off"), (5.0, 5.0, "")]
)
def test_one_that_sees_the_sun_leaves_the_others_visible(
    tmp_path, monkeypatch, brightest, end, words
):
    from omma.picture import response_plots

    figures = []
    monkeypatch.setattr(response_plots, "save_figure", lambda one, *_, **__: figures.append(one))
    responses = np.full((500, 3), 1.0)
    responses[0] = brightest
    omma.picture.plot_responses(tmp_path / "a.png", make_eye(500), responses, channels=[0, 1])
    scale = figures[0].axes[-1]
    assert scale.get_xlim()[1] == pytest.approx(end)
    assert scale.get_xlabel() == f"response{words} (display gamma 2.2)"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"responses": np.zeros((4, 3))}, r"responses: expected shape \(3, bands\)"),
        ({"responses": np.zeros((3, 5))}, "channels: expected one to three of the 5 bands"),
        ({"channels": [3]}, "channels: expected bands from 0 to 2, found 3"),
        ({"channels": []}, "channels: expected one to three, found 0"),
        ({"errors": np.zeros((2, 3, 3))}, "errors: expected the shape of responses"),
        ({"titles": ["a", "b"]}, "titles: expected 1"),
        ({"projection": "mollweide_ids"}, "projection: expected one that shows responses"),
        ({"projection": "moon"}, "projection"),
        ({"responses": np.zeros((25, 3, 3))}, "at most 24 pictures, found 25"),
        ({"full_scale": 0}, "full_scale"),
        ({"receptors": True, "responses": np.zeros(7)}, r"responses: expected shape \(8,\)"),
        (
            {"receptors": True, "responses": np.zeros(8), "channels": ["red"]},
            r"channels: expected receptors of this eye \(uv, green, blue\), found 'red'",
        ),
        ({"responses": np.full((3, 3), np.nan)}, "responses: expected finite numbers"),
    ],
)
def test_what_makes_no_sense_is_refused(tmp_path, arguments, words):
    given = {"responses": np.zeros((3, 3)), **arguments}
    with pytest.raises(omma.Error, match=words):
        omma.picture.plot_responses(tmp_path / "a.png", bee(), **given)
    assert not list(tmp_path.iterdir())
