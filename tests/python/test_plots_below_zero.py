"""Figures of numbers below 0, of infinite ones and of none, and of ground truth."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.picture.unseen import NOT_KNOWN

pytest.importorskip("matplotlib")


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """What `plot_responses` draws, as Matplotlib's figure, drawn but not written."""
    from omma.picture import response_plots

    figures = []
    monkeypatch.setattr(response_plots, "save_figure", lambda one, *_, **__: figures.append(one))

    def draw(*arguments, **options):
        omma.picture.plot_responses(tmp_path / "a.png", *arguments, **options)
        figures[-1].canvas.draw()
        return figures[-1]

    return draw


def image_of(figure, panel=0):
    return figure.axes[panel].images[1]


def test_numbers_below_0_have_a_scale_about_0(drawn):
    eye = make_eye(300)
    x = eye.axis[:, :1]
    figure = drawn(eye, x, quantity="x")
    image = image_of(figure)
    end = float(np.abs(x).max())
    assert image.get_clim() == pytest.approx((-end, end))
    assert figure.axes[-1].get_xlim() == pytest.approx((-end, end))
    # White at 0, blue below it and red above, each the darker the farther.
    for value, brightest in ((-end, 2), (end, 0)):
        shade = image.cmap(image.norm(value))[:3]
        assert np.argmax(shade) == brightest
        assert max(shade) < 0.5
    assert min(image.cmap(image.norm(0.0))[:3]) > 0.95
    image = image_of(drawn(eye, x, quantity="x", full_scale=0.5))
    assert image.get_clim() == (-0.5, 0.5)
    assert drawn(eye, x, quantity="x", full_scale=0.5).axes[-1].get_xlabel() == "x, more cut off"


def test_a_scale_about_0_ends_where_99_of_100_do(drawn):
    values = np.where(np.arange(500) % 2, -1.0, 1.0)
    values[3] = -500
    figure = drawn(make_eye(500), values, quantity="x")
    assert image_of(figure).get_clim() == (-1, 1)
    assert figure.axes[-1].get_xlabel() == "x, more cut off"


def test_rounding_below_0_is_0(drawn):
    values = np.linspace(0, 1, 50)
    values[0] = -1e-6
    assert image_of(drawn(make_eye(50), values)).get_clim() == (0, 1)


def test_greys_below_0_have_a_bar(drawn):
    eye = make_eye(50)
    values = np.repeat(np.linspace(-2, 1, 50)[:, None], 3, axis=1)
    figure = drawn(eye, values)
    assert image_of(figure).get_clim() == (-2, 2)
    assert figure.axes[-1].get_xlabel() == "response: red = green = blue"


def test_colours_below_0_are_refused_or_said(drawn):
    eye = make_eye(50)
    with pytest.raises(omma.Error, match=r"found -0\.9.*one channel at a time.*channels=\[0\]"):
        drawn(eye, eye.axis)
    with pytest.raises(omma.Error, match=r"expected numbers from 0 on.*channels=\[0\]"):
        drawn(eye, eye.axis, channels=[0, 1])
    # A green that no screen has is a colour: of luminance 0.63.
    values = np.tile([-0.3, 0.9, 0.6], (50, 1))
    label = drawn(eye, values).axes[-1].get_xlabel()
    assert label == "response, below 0 cut off (display gamma 2.2)"
    with pytest.raises(omma.Error, match="errors: expected numbers from 0 on"):
        drawn(eye, np.ones((50, 1)), errors=-np.ones((50, 1)))


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ([np.inf], "grey: infinite"),
        ([np.nan], "grey: not a number"),
        ([np.nan, -np.inf], "grey: infinite or not a number"),
    ],
)
def test_what_has_no_number_is_grey(drawn, values, said):
    eye = make_eye(50)
    distance = np.linspace(1, 5, 50)
    distance[: len(values)] = values
    figure = drawn(eye, distance, quantity="m")
    assert figure.get_supxlabel() == said
    ground, image = (np.ma.asarray(each.get_array()) for each in figure.axes[0].images)
    ids = omma.picture.projection_ids(eye, None, 1080, 540)
    without = (ids >= 0) & (ids < len(values))
    assert without.any()
    assert np.all(image.mask[without])
    assert not image.mask[(ids >= 0) & ~without].any()
    assert np.all(ground[without] == (NOT_KNOWN, NOT_KNOWN, NOT_KNOWN, 1))
    assert image_of(figure).get_clim() == (0, 5)
    assert drawn(eye, np.ones(50)).get_supxlabel() == ""
    colours = np.ones((50, 3))
    colours[0, 1] = values[0]
    with pytest.raises(omma.Error, match="expected finite numbers to show as colours"):
        drawn(eye, colours)


def test_nothing_but_sky_is_drawn(drawn):
    assert drawn(make_eye(50), np.full((50, 1), np.inf)).get_supxlabel() == "grey: infinite"


def test_one_channel_needs_no_axis_of_its_own(drawn):
    eye = make_eye(50)
    for shape, panels in (((50,), 1), ((2, 50), 2), ((1, 50), 1)):
        figure = drawn(eye, np.ones(shape), errors=np.zeros(shape))
        assert len(figure.axes) == 2 * panels + 2  # the errors', and two bars
        assert figure.axes[-2].get_xlabel() == "response"
    with pytest.raises(omma.Error, match=r"of one channel \(50,\) or \(poses, 50\)"):
        drawn(eye, np.ones(49))


@pytest.fixture(scope="module")
def truth():
    """Of 50 ommatidia above a plane, half of which see the sky, that fly ahead."""
    pytest.importorskip("xarray")
    renderer = omma.Renderer(omma.scene.plane((100, 100)), make_eye(50), omma.Fixed(4))
    pose = omma.look_at((0, 1, 0), (0, 1, -1))
    found = renderer.ground_truth(pose, head_velocity=((0, 0, -1), (0, 0, 0)))
    return renderer.eye, found, renderer.dataset(pose, truth=found)


@pytest.mark.parametrize(
    ("name", "channels", "label"),
    [
        ("met", None, "share in which anything is"),
        ("distance", None, "mean distance, m"),
        ("inverse_distance", None, "mean of the inverse distance, 0 where nothing is, m⁻¹"),
        ("seen_normal", [1], "mean normal of what is seen, in the world: y"),
        ("flow", [0], "optic flow in the ommatidium's right and up, in all: right, rad s⁻¹"),
    ],
)
def test_ground_truth_knows_what_it_is(drawn, truth, name, channels, label):
    eye, _, data = truth
    figure = drawn(eye, data[name], channels=channels)
    assert figure.axes[-1].get_xlabel() == label
    sky = {"distance": "grey: infinite", "seen_normal": "grey: not a number"}
    assert figure.get_supxlabel() == sky.get(name, "")
    own = drawn(eye, data[name], channels=channels, quantity="mine").axes[-1].get_xlabel()
    assert own == "mine"


def test_as_many_poses_as_ommatidia(drawn, truth):
    """Labels tell poses from channels where numbers do not."""
    import xarray

    eye = make_eye(4)
    values = xarray.DataArray(np.arange(16.0).reshape(4, 4), dims=("pose", "ommatidium"))
    assert len(drawn(eye, values).axes) == 5


def test_flow_has_a_way_out(drawn, truth):
    eye, found, data = truth
    for flow in (found.flow_rad_s, data["flow"]):
        with pytest.raises(omma.Error, match=r"channels=\[0\] .*numpy\.linalg\.norm\(responses"):
            drawn(eye, flow, quantity="rad/s")
    drawn(eye, np.linalg.norm(found.flow_rad_s, axis=-1), quantity="optic flow (rad/s)")


def test_pictures_refuse_what_no_colour_shows():
    eye = make_eye(50)
    makers = (
        omma.picture.project, omma.picture.framed, omma.picture.equirectangular,
        omma.picture.side_by_side,
    )  # fmt: skip
    for make in makers:
        with pytest.raises(omma.Error, match=r"from 0 on, found -0\.9.* plot_responses"):
            make(eye, eye.axis)
        make(eye, np.tile([-0.3, 0.9, 0.6], (50, 1)))  # a colour under water
    linear = omma.picture.project(eye, eye.axis, linear=True)
    assert np.nanmin(linear) < -0.9
    with pytest.raises(omma.Error, match=r"picture: expected .* from 0 on, found -0\.9"):
        omma.picture.display(linear)
    omma.picture.display(np.full((2, 3, 3), [-0.3, 0.9, np.nan]))
