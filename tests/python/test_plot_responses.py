"""Figures of responses: what is shown of them, and that they are written."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.picture import response_axes, response_colours, unseen

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


@pytest.mark.parametrize("size", [(200, None), (200, 200), (130, 40), (61, 127)])
@pytest.mark.parametrize("projection", ["mollweide", "lambert", "hemisphere"])
def test_what_lies_outside_a_map_is_what_shows_no_ommatidium(projection, size):
    # An eye that sees everything: all that is empty is outside the map.
    eye = make_eye(400)
    eye = eye.replace(acceptance_angle_rad=np.full(400, 3.1))
    ids = omma.picture.projection_ids(eye, projection, *size)
    inside = unseen.inside_outline(projection, *ids.shape)
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


def rows_of_legend(figure):
    return [label.get_text() for label in figure.axes[-1].get_yticklabels()]


def rgba(figure, panel):
    """The colours of a picture in a panel, (H, W, 4), and what lies below it."""
    ground, image = (each.get_array() for each in figure.axes[panel].images)
    return np.asarray(image), np.asarray(ground)


@pytest.mark.parametrize("full_scale", [1.0, 3e17, 2e-5])
def test_scales_of_photons_have_their_power_of_ten_in_the_label(drawn, full_scale):
    responses = np.full((50, 3), full_scale)
    scale = drawn(make_eye(50), responses, full_scale=full_scale).axes[-1]
    shown = [float(label.get_text()) for label in scale.get_xticklabels()]
    power = {1.0: "", 3e17: ", $10^{17}$", 2e-5: ", $10^{-5}$"}[full_scale]
    not_said = " unit not given (light=)" if power else ""
    assert scale.get_xlabel() == f"response (display gamma 2.2){power}{not_said}"
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
        ({"responses": np.zeros((4, 2))}, r"responses: expected shape \(3, bands\)"),
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
        ({"responses": [[0, 1, np.nan]] * 3}, "responses: expected finite numbers"),
    ],
)
def test_what_makes_no_sense_is_refused(tmp_path, arguments, words):
    given = {"responses": np.zeros((3, 3)), **arguments}
    with pytest.raises(omma.Error, match=words):
        omma.picture.plot_responses(tmp_path / "a.png", bee(), **given)
    assert not list(tmp_path.iterdir())


def test_light_names_the_unit_and_the_bands(drawn):
    bands = omma.light.Bands.equal(4, 300, 700)
    responses = np.random.default_rng(0).random((50, 4)) * 4e17
    per = {
        "photons": "$10^{17}$ photons m⁻² s⁻¹ sr⁻¹ nm⁻¹",
        "watts": "$10^{17}$ W m⁻² sr⁻¹ nm⁻¹",
    }
    for unit, words in per.items():
        light = omma.light.overcast_sky(40, bands=bands, unit=unit)
        scale = drawn(make_eye(50), responses, channels=[1], light=light).axes[-1]
        assert scale.get_xlabel() == f"response: band 1, 450 nm, {words}"
        figure = drawn(make_eye(50), responses, channels=[3, 0], light=light, errors=responses)
        labels = [panel.get_xlabel().replace("\n", " ") for panel in figure.axes[-2:]]
        assert labels == [f"response (display gamma 2.2), {words}", f"standard error, {words}"]
        names = [label.get_text() for label in figure.axes[-2].get_yticklabels()]
        assert names == ["band 3, 650 nm, shown yellow", "band 0, 350 nm, shown blue"]
    with pytest.raises(omma.Error, match="light: expected as many bands as responses, 3, found 4"):
        drawn(make_eye(50), responses[:, :3], channels=[0], light=light)


def test_labelled_arrays_know_their_unit(drawn):
    xarray = pytest.importorskip("xarray")
    lit = "photons m-2 s-1 sr-1 nm-1"
    units = {lit: "band 0, photons m⁻² s⁻¹ sr⁻¹ nm⁻¹", "1": "red"}
    for unit, words in units.items():
        array = xarray.DataArray(np.full((50, 3), 0.5), attrs={"units": unit})
        label = drawn(make_eye(50), array, channels=[0]).axes[-1].get_xlabel()
        assert label == f"response: {words}"


@pytest.mark.parametrize(
    ("bands", "called"),
    [
        (3, "green"),
        (2, "band 1"),
        (["red", "green", "blue"], "green"),
        (["350 nm", "450.5 nm", "550 nm"], "band 1, 450.5 nm"),
        (["band_0", "band_1", "band_2"], "band 1"),
    ],
)
def test_bands_have_the_names_that_are_known(drawn, bands, called):
    """Three bands of which nobody says more are RGB, as where all three are drawn."""
    responses = np.full((50, bands if isinstance(bands, int) else len(bands)), 0.5)
    if not isinstance(bands, int):
        xarray = pytest.importorskip("xarray")
        responses = xarray.DataArray(
            responses, dims=("ommatidium", "band"), coords={"band": bands}, attrs={"units": "1"}
        )
    label = drawn(make_eye(50), responses, channels=[1]).axes[-1].get_xlabel()
    assert label == f"response: {called}"


def two_eyes(left=90, right=130):
    """A left eye and a right one, both of which see ahead."""
    eyes = []
    for side, count in ((-1, left), (1, right)):
        axis = make_eye(3000).axis
        axis = axis[axis[:, 0] * side > -0.3][:count]
        eyes.append(omma.Eye((axis + [9 * side, 0, 0]) * 1e-3, axis, np.radians(15)))
    return omma.eye.merge_eyes(eyes)


def test_a_title_says_how_many_ommatidia_are_shown(drawn):
    head = two_eyes()
    for eye in (head, head.replace(eye_id=np.zeros(len(head), np.int32))):
        panels = drawn(eye, np.full((len(eye), 3), 0.5)).axes[:2]
        titles = [panel.get_title(loc="left") for panel in panels]
        assert titles == ["left eye, 90 of 220 ommatidia", "right eye, 130 of 220 ommatidia"]
    panels = drawn(head, np.full((2, len(head), 3), 0.5)).axes[:4]
    assert panels[3].get_title(loc="left") == "right eye, 130 of 220 ommatidia, pose 1"
    panels = drawn(head, np.full((len(head), 3), 0.5), titles=["mine"]).axes[:2]
    assert [panel.get_title(loc="left") for panel in panels] == [
        "mine: left eye",
        "mine: right eye",
    ]
    assert drawn(make_eye(50), np.ones((50, 3))).axes[0].get_title(loc="left") == "50 ommatidia"


def test_grey_has_one_row_in_its_legend(drawn):
    eye = make_eye(50)
    shade = np.repeat(np.random.default_rng(0).random((50, 1)), 3, axis=1).astype(np.float32)
    grey = drawn(eye, shade)
    assert rows_of_legend(grey) == ["red = green = blue"]
    image, _ = rgba(grey, 0)
    ids = omma.picture.projection_ids(eye, None, 1080, 540)
    assert image.shape[:2] == ids.shape
    expected = (shade ** (1 / 2.2))[ids[ids >= 0]]
    np.testing.assert_allclose(image[..., :3][ids >= 0], expected, rtol=0, atol=1e-6)
    # One facet of another colour, and there are three.
    shade[7, 2] += 0.01
    coloured = drawn(eye, shade)
    assert rows_of_legend(coloured) == ["red", "green", "blue"]


def crossed(kinds):
    """Three ommatidia; the first has crossed ultraviolet receptors, all have what else is named."""
    types = [
        omma.receptors.ReceptorType(
            name, peak_wavelength_nm=nm, polarisation_sensitivity=sensitivity,
            microvillus_angle_rad=np.radians(angle),
        )
        for name, nm, sensitivity, angle in kinds
    ]  # fmt: skip
    axis = [[0, 0, -1], [0.1, 0, -0.995], [-1, 0, 0]]
    others = list(range(3, len(kinds)))
    return omma.Eye(
        np.zeros((3, 3)), axis, 0.1, receptor_types=types,
        receptors=[[0, 1, *others], [2, *others], [2, *others]],
    )  # fmt: skip


RIM = [("along", 350, 6, 0), ("across", 350, 6, -90), ("uv", 350, 1, 0)]


def test_who_has_more_receptors_than_a_picture_has_colours_is_told_how_to_choose(drawn):
    kinds = [
        omma.receptors.ReceptorType(f"R{k}", peak_wavelength_nm=350 + 50 * k) for k in range(4)
    ]
    eye = omma.receptors.assign_receptors(
        make_eye(50), omma.receptors.OmmatidiumType("all", tuple(kinds))
    )
    with pytest.raises(omma.Error, match=r"channels=\['R0'\], found none.* R0, R1, R2, R3$"):
        drawn(eye, np.ones(200), receptors=True)
    assert drawn(eye, np.ones(200), receptors=True, channels=["R3", "R0"])


def test_crossed_receptors_are_two_channels():
    eye = crossed([*RIM, ("green", 520, 2, 0)])
    responses = np.array([3.0, 1, 9, 5, 9, 6, 9])
    shown = response_colours.receptors_shown(eye, responses, None, "responses")
    assert shown.names == (
        "green (520 nm)",
        "along, uv (350 nm, microvilli 0° from each ommatidium's up)",
        "across, uv (350 nm, microvilli 90° from each ommatidium's up)",
    )
    # What has no crossed ones shows its own ultraviolet in both, not the rim's.
    assert shown.values.tolist() == [[[9, 3, 1], [9, 5, 5], [9, 6, 6]]]
    # Where there are no channels left for it, the legend says what is a mean.
    eye = crossed([*RIM, ("green", 520, 1, 0), ("blue", 440, 1, 0)])
    shown = response_colours.receptors_shown(eye, np.arange(10.0), None, "responses")
    assert shown.names[2] == "along to uv (350 nm, mean of microvilli at 0°, 90°)"
    assert shown.values[0, 0].tolist() == [2, 3, 0.5]
    by_name = response_colours.receptors_shown(eye, np.arange(10.0), ["across"], "responses")
    assert by_name.names == ("across (350 nm)",)


def test_directions_that_nobody_sees_are_hatched_in_figures(drawn):
    eye = make_eye(400).take(np.flatnonzero(make_eye(400).axis[:, 1] > 0).tolist())
    figure = drawn(eye, np.full((len(eye), 3), 0.5), projection="mollweide")
    image, ground = rgba(figure, 0)
    hidden = (image[..., 3] == 0) & unseen.inside_outline("mollweide", *image.shape[:2])
    levels = np.unique(ground[..., 0][hidden])
    assert len(levels) == 2
    assert 0.1 < (ground[..., 0][hidden] == levels[0]).mean() < 0.4
    assert (ground[..., 3] == unseen.inside_outline("mollweide", *image.shape[:2])).all()


@pytest.mark.parametrize("errors", [False, True])
def test_long_names_of_receptors_stay_in_the_figure(drawn, errors):
    types = [
        omma.receptors.ReceptorType(
            f"{name} of the ventral two thirds of the eye", peak_wavelength_nm=nm
        )
        for name, nm in (("ultraviolet", 350), ("blue", 440), ("green", 530))
    ]
    eye = make_eye(20)
    eye = eye.replace(receptor_types=types, receptors=[[0, 1, 2]] * 20)
    values = np.ones(60)
    figure = drawn(eye, values, receptors=True, errors=values if errors else None)
    labels = figure.axes[-2 if errors else -1].get_yticklabels()
    boxes = [label.get_window_extent() for label in labels]
    assert len(boxes) == 3
    assert all(box.x0 >= 0 for box in boxes)
    for above, below in zip(boxes[:-1], boxes[1:], strict=True):
        assert above.y0 >= below.y1 - 1  # pixels: they do not touch


def test_what_of_stokes_vectors_is_drawn_is_said(drawn):
    eye, random = make_eye(50), np.random.default_rng(1)
    responses = random.random((2, 50, 3, 4)) * [[1], [0.1], [0.1]]
    for each in (responses, responses[0]):
        with pytest.raises(
            omma.Error, match=r"of Stokes vectors responses\[\.\.\., 0, :\] is the intensity, and"
        ):
            drawn(eye, each, channels=[0])
    assert drawn(eye, responses[..., 0, :], channels=[2])
    # As the message has it.
    band, numpy = 1, np
    i, q, u = numpy.moveaxis(responses[..., band], -1, 0)
    degree = numpy.hypot(q, u) / i
    assert degree.shape == (2, 50)
    scale = drawn(eye, degree, quantity="degree of polarisation", full_scale=1).axes[-1]
    assert scale.get_xlabel().startswith("degree of polarisation")
    with pytest.raises(omma.Error, match=r"found \(2, 50, 4, 4\)$"):
        drawn(eye, random.random((2, 50, 4, 4)))


def test_other_numbers_than_responses_are_called_what_they_are(drawn):
    values = np.linspace(0, 3, 150).reshape(50, 3)
    eye = make_eye(50)
    scale = drawn(eye, values, channels=[0], quantity="mean of 1/distance (1/m)").axes[-1]
    assert scale.get_xlabel() == "mean of 1/distance (1/m)"
    scale = drawn(eye, values, quantity="flow (°/s)", full_scale=2).axes[-1]
    assert scale.get_xlabel() == "flow (°/s), more cut off (display gamma 2.2)"


def ant():
    types = [
        omma.receptors.ReceptorType("ultraviolet", peak_wavelength_nm=350),
        omma.receptors.ReceptorType("green", peak_wavelength_nm=510),
        omma.receptors.ReceptorType("blue", peak_wavelength_nm=436),
    ]
    return bee().replace(receptor_types=types)


def test_a_legend_has_the_names_of_each_eye(drawn):
    """Receptors of the second eye that have other peaks are not called as those of the first."""
    one, other = bee(), ant()
    responses = [np.ones(len(one.receptor_type)), np.ones(len(other.receptor_type))]
    figure = drawn([one, other], responses, receptors=True)
    assert [row.replace("\n", " ") for row in rows_of_legend(figure)] == [
        "eye 1 of 2: green (544 nm); eye 2 of 2: green (510 nm), shown red",
        "blue (436 nm), shown green",
        "eye 1 of 2: uv (344 nm); eye 2 of 2: ultraviolet (350 nm), shown blue",
    ]
    figure = drawn([one, other], responses, receptors=True, channels=["green"])
    said = "response: eye 1 of 2: green (544 nm); eye 2 of 2: green (510 nm)"
    assert figure.axes[-1].get_xlabel() == said
    assert (
        drawn([one, one], responses, receptors=True, channels=["blue"]).axes[-1].get_xlabel()
        == "response: blue (436 nm)"
    )


def test_eyes_of_animals_are_named(drawn):
    eyes = [omma.species.honeybee_worker().eye, omma.species.cataglyphis().eye]
    responses = [np.ones(len(eye.receptor_type)) for eye in eyes]
    figure = drawn(eyes, responses, receptors=True)
    titles = [panel.get_title(loc="left") for panel in figure.axes[:-1]]
    assert [title.split(": ")[0] for title in titles] == ["Honeybee worker"] * 2 + [
        "Cataglyphis"
    ] * 2
    assert all(": " in row for row in rows_of_legend(figure))
    half = eyes[1].take(np.flatnonzero(eyes[1].eye_id == 0).tolist())
    title = drawn(half, np.ones((len(half), 3))).axes[0].get_title(loc="left")
    assert title == f"Cataglyphis: {len(half):,} ommatidia"


def test_labels_of_two_scales_do_not_touch(tmp_path, monkeypatch):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from omma.picture import response_plots

    labels = []

    def measured(figure, *_, **__):
        FigureCanvasAgg(figure).draw()
        labels.extend(panel.xaxis.label.get_window_extent() for panel in figure.axes[-2:])
        labels.append(figure.bbox)

    # As it is written, in the style that figures have then.
    monkeypatch.setattr(response_plots, "save_figure", measured)
    light = omma.light.overcast_sky(40, bands=omma.light.Bands.equal(4, 300, 700))
    responses = np.random.default_rng(0).random((500, 4)) * 4e17
    responses[0] *= 1e3
    omma.picture.plot_responses(
        tmp_path / "a.png", make_eye(500), responses, errors=responses, channels=[1], light=light
    )
    left, right, whole = labels
    assert left.x1 < right.x0
    assert right.x1 <= whole.x1
    assert min(left.y0, right.y0) >= 0


def test_the_scale_of_errors_ends_where_99_of_100_do(drawn):
    responses = np.ones((500, 3))
    errors = np.full((500, 3), 0.1)
    errors[0] = 0.8
    figure = drawn(make_eye(500), responses, errors=errors)
    assert figure.axes[1].images[1].get_clim() == pytest.approx((0, 0.1))
    assert figure.axes[-1].get_xlabel() == "standard error, larger cut off"
    errors[0] = 0.15
    figure = drawn(make_eye(500), responses, errors=errors)
    assert figure.axes[1].images[1].get_clim() == pytest.approx((0, 0.15))
    assert figure.axes[-1].get_xlabel() == "standard error"


def test_angles_have_the_same_colour_at_both_ends(drawn):
    eye = make_eye(4)
    figure = drawn(eye, [-90.0, 90.0, 100.0, np.nan], cyclic=180, quantity="angle (°)")
    image = figure.axes[0].images[1]
    assert image.get_clim() == (-90, 90)
    ends = [image.cmap(image.norm(end)) for end in (-90.0, 90.0)]
    assert ends[0] == pytest.approx(ends[1], abs=0.02)
    shown = np.unique(np.ma.asarray(image.get_array()).compressed())
    assert shown == pytest.approx([-90, -80])
    scale = figure.axes[-1]
    assert scale.get_xticks() == pytest.approx([-90, -45, 0, 45, 90])
    assert scale.get_xlabel() == "angle (°)"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"responses": np.arange(9.0).reshape(3, 3)}, "cyclic: expected one channel"),
        ({"full_scale": 90}, "cyclic: expected no full_scale"),
        ({"cyclic": 0}, "cyclic"),
        ({"receptors": True, "responses": np.ones(8), "channels": ["uv"]}, "of receptors"),
    ],
)
def test_periods_that_make_no_sense_are_refused(drawn, arguments, words):
    with pytest.raises(omma.Error, match=words):
        drawn(bee(), **{"responses": np.ones(3), "cyclic": 180, **arguments})


@pytest.mark.parametrize("projection", [None, *omma.picture.PROJECTIONS])
def test_titles_stay_in_the_figure(tmp_path, projection):
    image = pytest.importorskip("PIL.Image")
    eye, path = make_eye(200), tmp_path / "a.png"
    if projection == "raw_ommatidial_samples":
        with pytest.raises(omma.Error, match="projection: expected one that shows responses"):
            omma.picture.plot_responses(path, eye, np.ones(200), projection=projection)
        return
    omma.picture.plot_responses(path, eye, np.ones(200), projection=projection)
    inked = (np.asarray(image.open(path).convert("L")) < 250).any(axis=1)
    # The layout means to leave a 24th of an inch, 8 pixels; what is cut has none.
    assert np.flatnonzero(inked)[0] >= 4
