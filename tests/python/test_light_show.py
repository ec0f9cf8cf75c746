"""Figures of light, and the command that draws them."""

import dataclasses
import pickle
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest

import omma
from omma.picture.light_titles import light_title
from omma.picture.neutral_points import neutral_points

pytest.importorskip("matplotlib")

# Of the command's lights.
EDGES_NM = [300, *np.arange(305, 700, 10), 700]


def test_a_figure_of_each_kind(tmp_path):
    few = omma.light.Bands.equal(4)
    lights = [
        omma.light.clear_sky(30, sun_azimuth_deg=135, bands=few),
        omma.light.overcast_sky(30, bands=few, unit="watts"),
        omma.light.uniform_sky(0, bands=few),
        omma.light.panorama_bands(np.ones((4, 8, 4)), bands=few).scaled(2),
    ]
    for k, light in enumerate(lights):
        omma.picture.plot_sky(tmp_path / f"{k}.png", light, [550], size_mm=60)
        assert (tmp_path / f"{k}.png").stat().st_size > 5000
    omma.picture.plot_sky([tmp_path / "a.svg", tmp_path / "a.pdf"], lights[0], [350, 550])
    assert b"<svg" in (tmp_path / "a.svg").read_bytes()


def test_a_title_says_when_and_where():
    pytest.importorskip("ephem")
    moment = datetime(2026, 6, 21, 12, tzinfo=timezone(timedelta(hours=2)))
    few = omma.light.Bands.equal(2)
    light = omma.light.natural_sky_at(moment, 52.5, 13.4, bands=few)
    expected = "natural sky at 2026-06-21 12:00+02:00, latitude 52.5°, longitude 13.4°"
    assert light_title(light) == expected
    assert pickle.loads(pickle.dumps(light)) == light
    assert light_title(omma.light.clear_sky(30, bands=few)) == "clear sky, sun elevation 30°"
    high = omma.light.clear_sky(30, ozone_du=300, height_m=2000, haze_kind="urban", bands=few)
    said = "clear sky, sun elevation 30°, ozone 300 DU, height 2000 m, urban haze"
    assert light_title(high) == said


def test_titles_round_where_the_sun_is():
    few = omma.light.Bands.equal(2)
    light = omma.light.clear_sky(15.22618, sun_azimuth_deg=288.8071, bands=few)
    assert light_title(light) == "clear sky, sun elevation 15.23°, sun azimuth 288.81°"


def texts(figure):
    return [one.get_text() for panel in figure.axes for one in panel.texts]


def test_a_figure_says_whose_light_it_is_and_how_its_maps_lie(figures):
    few = omma.light.Bands.equal(4)
    sun = omma.light.clear_sky(30, bands=few)
    moon = omma.light.moonlit_sky(30, bands=few)
    for light, name in ((sun, "sun"), (moon, "moon"), (sun.turned(20), "sun"),
                        (sun.plus(moon), "sun or moon")):  # fmt: skip
        omma.picture.plot_sky("a.png", light, [550])
        legend = figures[-1].axes[-1].get_legend() or next(
            one.get_legend() for one in figures[-1].axes if one.get_legend()
        )
        assert [one.get_text() for one in legend.get_texts()] == ["sky", name, "both"]
        assert sum("seen from above" in one for one in texts(figures[-1])) == 1


def test_labels_are_within_the_figure(figures):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    bands = omma.light.Bands.from_edges(EDGES_NM)
    omma.picture.plot_sky("a.png", omma.light.clear_sky(30, bands=bands))
    figure = figures[-1]
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer, width = canvas.get_renderer(), figure.bbox.width
    ends = [
        panel.yaxis.label.get_window_extent(renderer)
        for one in figure.axes
        for panel in (one, *one.child_axes)
        if panel.yaxis.label.get_text()
    ]
    assert all(box.x0 >= 0 and box.x1 <= width for box in ends)


def test_the_command_says_when_and_where(figures, omma_command):
    pytest.importorskip("ephem")
    asked = ("--time", "2026-06-21T19:30:00+02:00", "--place", "52.5,13.4", "--wavelength", 550)
    for kind, said in (
        ("clear", "2026-06-21 19:30+02:00, latitude 52.5°, longitude 13.4°: clear sky, sun elev"),
        ("natural", "natural sky at 2026-06-21 19:30+02:00, latitude 52.5°, longitude 13.4°"),
    ):
        assert omma_command("light", "show", *asked, "--kind", kind, "-o", "a.png")[0] == 0
        title = figures[-1].get_suptitle().replace("\n", " ")
        assert title.startswith(said)


def test_what_cannot_be_drawn(tmp_path):
    light = omma.light.uniform_sky()
    with pytest.raises(omma.Error, match=r"expected a name ending in \.pdf"):
        omma.picture.plot_sky(tmp_path / "a.txt", light)
    with pytest.raises(omma.Error, match="wavelengths_nm: expected 1 to 6"):
        omma.picture.plot_sky(tmp_path / "a.png", light, [])
    with pytest.raises(TypeError, match=r"light: expected omma\.light\.Light"):
        omma.picture.plot_sky(tmp_path / "a.png", 3)


@pytest.fixture
def figures(monkeypatch):
    """Those that are drawn, in place of files."""
    from omma.picture import sky_plots

    drawn = []
    monkeypatch.setattr(sky_plots, "save", lambda one, *_: drawn.append(one))
    return drawn


def rows(figure):
    return [one.get_ylabel() for one in figure.axes if one.get_ylabel().endswith(" nm")]


def test_wavelengths_are_drawn_in_the_bands_that_they_lie_in(figures):
    wide = omma.light.Bands.from_edges([300, 500, 510])
    visible = omma.light.Bands.equal(12, 400, 700)
    tuned = omma.light.Bands.from_sensitivities(
        [340, 350, 360, 540, 550, 560], [[0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0]]
    )
    for bands, asked, shown in (
        (wide, [480, 510, 300], ["400 nm", "505 nm", "400 nm"]),
        (visible, None, ["438 nm", "538 nm"]),
        (omma.light.Bands.equal(1, 600, 700), None, ["650 nm"]),
        (omma.light.Bands.equal(1), None, ["500 nm"]),
        (tuned, [341, 559], ["350 nm", "550 nm"]),
    ):
        omma.picture.plot_sky("a.png", omma.light.uniform_sky(bands=bands), asked)
        assert rows(figures[-1]) == shown


@pytest.mark.parametrize(
    ("asked", "found"),
    [(0, "0"), (299, "299"), (900, "900"), (0.44, "0.44; 0.44 µm would be 440 nm")],
)
def test_wavelengths_beyond_the_light_are_refused(asked, found, tmp_path, run_omma):
    told = f"expected 300 to 700 nm, where the bands of this light are, found {found}"
    with pytest.raises(omma.Error, match=f"wavelengths_nm: {told}"):
        omma.picture.plot_sky(tmp_path / "a.png", omma.light.uniform_sky(), [550, asked])
    code, _, err = run_omma(
        "light", "show", "--sun", 30, "--wavelength", asked, "-o", tmp_path / "a.png"
    )
    assert code == 1
    assert f"--wavelength: {told}" in err


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        (["--sun", 30], ["350 nm", "440 nm", "550 nm"]),
        (["--light", "overcast_sky sun_elevation_deg=30"], ["350 nm", "440 nm", "550 nm"]),
        (["--sun", 30, "--wavelength", 310, "--wavelength", 646], ["310 nm", "650 nm"]),
        (["--light", "uniform_sky bands=visible"], ["438 nm", "538 nm"]),
    ],
)
def test_the_command_draws_bands_about_what_is_asked(figures, run_omma, tmp_path, given, shown):
    code, _, err = run_omma("light", "show", *given, "-o", tmp_path / "a.png")
    assert (code, err) == (0, "")
    assert rows(figures[0]) == shown


@pytest.mark.parametrize("kind", ["clear", "moonlit"])
def test_the_command(tmp_path, run_omma, kind):
    name = str(tmp_path / "sky.png")
    given = ("--sun", "20", "--azimuth", "90", "--wavelength", "440", "--kind", kind)
    code, out, err = run_omma("light", "show", *given, "-o", name)
    assert (code, err) == (0, "")
    assert out == f"wrote {name}\n"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["--sun", -12], "--sun: expected -8 to 90, found -12; --kind natural goes on"),
        (["--sun", -12, "--kind", "overcast"], "found -12; in Python, omma.light.clouded before"),
        (["--sun", -12, "--kind", "moonlit"], "--sun: expected -8 to 90, found -12"),
        (["--light", "clear_sky sun_elevation_deg=-12"], "found -12; natural_sky goes on"),
        (
            ["--light", "cloudy_sky sun_elevation_deg=-12"],
            "found -12; in Python, omma.light.clouded before omma.light.natural_sky goes on",
        ),
    ],
)
def test_below_the_horizon(tmp_path, run_omma, given, told):
    """Where a clear sky ends it says which one goes on, as it is said there."""
    code, _, err = run_omma("light", "show", *given, "-o", tmp_path / "sky.png")
    assert code == 1
    assert told in err
    assert ("--kind natural" in err) == ("--kind natural" in told)


@pytest.mark.parametrize("moment", ["2026-06-21T12:00:00+02:00", "2026-06-21T23:59:00+02:00"])
def test_a_time_and_place(tmp_path, run_omma, moment):
    pytest.importorskip("ephem")
    name = str(tmp_path / "sky.png")
    kind = "natural" if "T23" in moment else "clear"  # a sun 14 degrees below the horizon
    given = ("--time", moment, "--place", "52.5,13.4", "--wavelength", "440", "--kind", kind)
    code, _, err = run_omma("light", "show", *given, "-o", name)
    assert (code, err) == (0, "")


def test_a_time_when_the_sun_is_too_low(tmp_path, run_omma):
    pytest.importorskip("ephem")
    given = ("--time", "2026-06-21T23:30:00+02:00", "--place", "52.5,13.4")
    code, _, err = run_omma("light", "show", *given, "-o", str(tmp_path / "sky.png"))
    assert code == 1
    assert "--time: expected one when the sun stands at -8 degrees or higher, found -11" in err
    assert "--kind natural goes on into the night" in err
    moment = datetime(2026, 6, 21, 21, 30, tzinfo=timezone.utc)
    with pytest.raises(omma.Error, match=r"^date_time: .*found -11.* natural_sky_at goes on"):
        omma.light.clear_sky_at(moment, 52.5, 13.4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((), "show: expected either --sun or --time and --place"),
        (("--sun", "3", "--time", "2026-06-21"), "show: expected either"),
        (("--time", "noon", "--place", "1,2"), "--time: expected one such as 2026-06-21T12:00"),
        (("--time", "2026-06-21T12:00", "--place", "1,2"), "found '2026-06-21T12:00'"),
        (("--time", "2026-06-21T12:00Z", "--place", "1"), "--place: expected latitude,longitude"),
        (
            ("--time", "2026-06-21T12:00Z", "--place", "1,2", "--kind", "overcast"),
            "--kind: expected clear",
        ),
        (
            ("--sun", "30", "--kind", "cloudy"),
            "--kind: expected one of clear, natural, moonlit, overcast, found 'cloudy'; --light "
            "draws all others, such as --light 'cloudy_sky sun_elevation_deg=30'",
        ),
        (("--light", "cloudy"), "--light: expected one of clear_sky, clear_sky_at, cloudy_sky"),
        (("--light", ""), "--light: expected one of clear_sky"),
        (("--light", "clear_sky sun_elevation_deg=100"), "sun_elevation_deg: expected -8 to 90"),
        (("--light", "night_sky", "--ozone", "300"), "--ozone: goes without --light"),
        (("--light", "night_sky", "--unit", "watts"), "--unit: goes without --light"),
    ],
)
def test_wrong_options(tmp_path, run_omma, given, message):
    code, _, err = run_omma("light", "show", *given, "-o", str(tmp_path / "sky.png"))
    assert code == 1
    assert message in err


@pytest.mark.parametrize(
    "words",
    [
        "cloudy_sky sun_elevation_deg=30 cloud_fraction=0.3 kind=cirrus",
        "cie_sky sky_type=5 sun_elevation_deg=30 unit=watts bands=visible ultraviolet=dark",
        "clear_sky sun_elevation_deg=30 haze_kind=smoke visibility_m=2000",
        "night_sky",
        "lamps",
    ],
)
def test_any_light_that_is_rendered_under(tmp_path, run_omma, monkeypatch, words):
    from omma.cli import light as command
    from omma.scene.light_words import parse_light

    drawn = []
    monkeypatch.setattr(command, "plot_sky", lambda names, light, nm, **_: drawn.append(light))
    code, _, err = run_omma("light", "show", "--light", words, "-o", str(tmp_path / "sky.png"))
    assert (code, err) == (0, "")
    assert drawn == [parse_light(words, omma.light.Bands.from_edges(EDGES_NM))["light"]]
    if "bands=" in words:
        assert drawn == [parse_light(words)["light"]]


def test_lamps_alone_are_dark(tmp_path, run_omma):
    name = tmp_path / "sky.png"
    code, _, err = run_omma("light", "show", "--light", "lamps", "-o", str(name))
    assert (code, err) == (0, "")
    assert name.stat().st_size > 5000


def test_neutral_points_are_where_polarisation_changes_its_sign():
    # Across the meridian (Q < 0) but for 10 to 50 degrees on the sun's side, and under 10 opposite.
    sky = np.zeros((2, 91, 8, 3, 1))
    sky[:, :, :, 0], sky[:, :, :, 1] = 1, -0.05
    sky[0, 10:50, 0, 1] = 0.05
    sky[0, :10, 4, 1] = 0.05
    disc = omma.light.Disc((0, 0.5, -np.sqrt(0.75)), 0.004, [1.0])
    light = omma.light.Light(omma.light.Bands.equal(1), sky=sky, discs=(disc,))
    found = neutral_points(light, 0)
    assert [name for name, _ in found] == ["Brewster", "Babinet", "Arago"]
    elevation = [np.degrees(np.arcsin(towards[1])) for _, towards in found]
    # Between rows of 1 degree.
    np.testing.assert_allclose(elevation, [9.5, 49.5, 9.5], atol=0.01)
    assert neutral_points(omma.light.uniform_sky(), 0) == []


def test_nothing_is_polarised_at_neutral_points_of_a_moon_in_twilight():
    pytest.importorskip("ephem")
    # A crescent 34 degrees beside the sun, which has set: neither's meridian is an axis of the sky.
    moment = datetime(2026, 1, 22, 17, 30, tzinfo=timezone.utc)
    few = omma.light.Bands.from_edges([345, 355, 435, 445, 545, 555])
    light = omma.light.natural_sky_at(moment, -25, 29, bands=few)
    for band in (0, 2, 4):
        found = neutral_points(light, band)
        # The crescent's light is weak, so that they are where they are without it.
        assert [name for name, _ in found] == ["Babinet of the sun", "Arago of the sun"]
        for (_, towards), azimuth in zip(found, (244.3, 64.3), strict=True):
            i, q, u = light.radiance(towards)[:, band]
            assert np.hypot(q, u) < 0.005 * i  # the degree at the old crosses was 0.35
            beside = omma.base.directions.azimuth_elevation_deg_of(towards)[0] - azimuth
            assert abs((beside + 180) % 360 - 180) < 1


def test_neutral_points_of_two_lights_as_strong_are_neithers():
    few = omma.light.Bands.equal(1, 435, 445)
    sun = omma.light.natural_sky(-9, bands=few)
    moon = omma.light.moonlit_sky(20, moon_azimuth_deg=90, bands=few)
    level = sum(sun.irradiance())[0] / moon.irradiance()[0][0]
    both = sun + float(level) * moon
    found = neutral_points(both, 0)
    assert found
    assert {name for name, _ in found} == {""}
    for _, towards in found:
        i, q, u = both.radiance(towards)[:, 0]
        assert np.hypot(q, u) < 0.01 * i


def test_a_moon_by_day_and_a_high_sun_do_not_disturb_neutral_points():
    pytest.importorskip("ephem")
    few = omma.light.Bands.equal(1, 435, 445)
    # The sun is 11.5 degrees up, the moon above it.
    moment = datetime(2026, 1, 22, 16, tzinfo=timezone.utc)
    day = omma.light.natural_sky_at(moment, -25, 29, bands=few)
    assert [name for name, _ in neutral_points(day, 0)] == ["Babinet", "Arago"]
    # Near the zenith, where directions of the map meet, nothing is added.
    high = omma.light.clear_sky(75, sun_azimuth_deg=200, bands=few)
    assert [name for name, _ in neutral_points(high, 0)] == ["Brewster", "Babinet"]
    moonlit = omma.light.moonlit_sky(40, bands=few)
    assert [name for name, _ in neutral_points(moonlit, 0)] == ["Brewster", "Babinet"]


def test_neutral_points_have_names_where_these_belong():
    few = omma.light.Bands.equal(2, 420, 480)
    names = lambda light: [name for name, _ in neutral_points(light, 0)]  # noqa: E731
    low, high = (omma.light.clear_sky(sun, bands=few) for sun in (10, 75))
    assert names(low) == ["Babinet", "Arago"]
    # Babinet's lies beyond the zenith; Arago's is below the horizon.
    assert names(high)[-1] == "Babinet"
    assert "Arago" not in names(high)
    # The sun that has set.
    for set_sky in (omma.light.clear_sky(-3, bands=few), omma.light.natural_sky(-7, bands=few)):
        assert names(set_sky) == names(set_sky.turned(40)) == ["Babinet", "Arago"]
    assert names(omma.light.natural_sky(-40, bands=few)) == []
    # The edge of Snell's window is none of the sky's own.
    for water in (omma.light.under_water(low, 3, "3C"), omma.light.under_water(high, 1).turned(9)):
        assert set(names(water)) <= {""}
    sky = np.zeros((2, 91, 8, 3, 1))
    sky[:, :, :, 0], sky[:, :, :, 1] = 1, -0.05
    sky[0, 80:, 4, 1] = 0.05
    disc = omma.light.Disc((0, 0.5, -np.sqrt(0.75)), 0.004, [1.0])
    made = omma.light.Light(omma.light.Bands.equal(1), sky=sky, discs=(disc,))
    assert names(made)[-1:] == [""]  # 79 degrees up opposite, 109 from the antisun


def test_a_title_says_what_was_done():
    few = omma.light.Bands.equal(2, 400, 700)
    clear = omma.light.clear_sky(40, sun_azimuth_deg=45, bands=few)
    said = "clear sky, sun elevation 40°, sun azimuth 45°"
    water, air = omma.light.under_water, omma.light.with_air
    dusk = omma.light.natural_sky(-5, bands=few)
    even = omma.light.uniform_sky(2.0, bands=few)
    titles = {
        f"{said}, 3 m under water 3C": water(clear, 3, "3C"),
        f"{said}, 2.5 m under water IB": water(clear, 2.5),
        f"{said}, 1 m under water as measured": water(
            clear, 1, absorption_per_m=0.1, scattering_per_m=0.2
        ),
        "natural sky, sun elevation -5°, half cirrus": omma.light.clouded(dusk, 0.5, "cirrus"),
        "clear sky, sun elevation 30°, sun azimuth 0°, 30% cumulus": omma.light.cloudy_sky(
            30, 0.3, bands=few
        ),
        f"{said}, air of visibility 5000 m": air(clear, 5000),
        f"{said}, air of visibility 500 m, 50 m high": air(clear, 500, layer_height_m=50),
        f"{said}, its own air": air(clear),
        f"{said}, turned by 30°": clear.turned(30),
        f"{said}, turned by -40°": clear.turned(-400),
        f"0.5 × {said} + uniform sky, radiance 2": 0.5 * clear + even,
        f"2 × ({said} + uniform sky, radiance 2), all deck": omma.light.clouded(
            2 * (clear + even), 1, "deck"
        ),
    }
    assert [light_title(light) for light in titles.values()] == list(titles)
    around = omma.light.clear_sky(40, sun_azimuth_deg=405, bands=few)
    assert light_title(around) == said


def clouded(cover_at):
    """A clear sky with the sun at 10°, and over it a grey, unpolarised cover: cover_at(elevation,
    azimuth), degrees, is its share."""
    bands = omma.light.Bands.equal(2, 340, 360)
    clear = omma.light.clear_sky(10, sun_azimuth_deg=0, bands=bands)
    grey = omma.light.overcast_sky(10, bands=bands).sky
    rows, columns = clear.sky.shape[1:3]
    elevation, azimuth = np.linspace(0, 90, rows)[:, None], np.arange(columns) * 360 / columns
    share = np.broadcast_to(cover_at(elevation, azimuth), (rows, columns))[:, :, None, None]
    sky = clear.sky.copy()
    sky[0] = (1 - share) * clear.sky[0]
    sky[0, :, :, :1] += share * grey[0][:, :1, :1]
    return clear, dataclasses.replace(clear, sky=sky, recipe=None)


def test_neutral_points_are_not_drawn_in_clouds():
    # Babinet's point is at 37° on the sun's side, Arago's at 21° opposite.
    ahead = lambda azimuth: (azimuth < 45) | (azimuth > 315)  # noqa: E731
    clear, over_babinet = clouded(lambda e, a: np.where(ahead(a) & (e > 25) & (e < 50), 0.85, 0.0))
    names = lambda light: [name for name, _ in neutral_points(light, 0)]  # noqa: E731
    assert names(clear) == ["Babinet", "Arago"]
    assert names(over_babinet) == ["Arago"]
    assert names(clouded(lambda e, a: 0.9)[1]) == []
    assert names(clouded(lambda e, a: 0.0)[1]) == ["Babinet", "Arago"]
    # Through a thin veil they are seen, and between clouds.
    assert names(clouded(lambda e, a: 0.2)[1]) == ["Babinet", "Arago"]
    gap = clouded(lambda e, a: np.where(np.abs(e - 37) < 8, 0.0, 0.9))[1]
    assert names(gap) == ["Babinet"]


def test_a_sun_behind_clouds_has_no_dot(tmp_path, monkeypatch):
    from omma.picture import sky_plots

    figures = []
    monkeypatch.setattr(sky_plots, "save", lambda one, *_: figures.append(one))
    light = omma.light.clear_sky(30)
    hidden = tuple(dataclasses.replace(d, radiance=0 * d.radiance) for d in light.discs)
    for each in (light, dataclasses.replace(light, discs=hidden, recipe=None)):
        omma.picture.plot_sky(tmp_path / "a.png", each, [440])
    dots = [sum(line.get_marker() == "o" for line in f.axes[0].lines) for f in figures]
    assert dots == [1, 0]


def test_a_sun_behind_a_cloud_has_no_dot(figures):
    """Of the sun's light 4e-5 come through; the sky's curve lies on that of both."""
    behind = omma.light.cloudy_sky(35, 0.4, "cumulus")
    shaded = omma.light.cloudy_sky(35, 0.4, "cumulus", shadow_height_m=900)
    for light in (behind, shaded, omma.light.clear_sky(35), omma.light.moonlit_sky(35)):
        omma.picture.plot_sky("a.png", light, [440])
    dots = [sum(line.get_marker() == "o" for line in one.axes[0].lines) for one in figures]
    assert dots == [0, 0, 1, 1]
    panel = next(one for one in figures[0].axes if one.get_xlabel() == "wavelength (nm)")
    sky, _, both = panel.lines
    assert sky.get_zorder() > both.get_zorder()
    assert sky.get_linewidth() < both.get_linewidth()


@pytest.mark.parametrize("azimuth", [0, 45, 97, 160, 260, 300])
def test_names_of_neutral_points_hide_nothing(figures, azimuth):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    bands = omma.light.Bands.from_edges(EDGES_NM)
    light = omma.light.clear_sky(35, sun_azimuth_deg=azimuth, bands=bands)
    omma.picture.plot_sky("a.png", light)
    figure = figures[-1]
    FigureCanvasAgg(figure).draw()
    names = 0
    for panel in figure.axes:
        called = [one for one in panel.texts if one.get_text() in ("Babinet", "Brewster", "Arago")]
        boxes = [one.get_window_extent() for one in called]
        marks = [line for line in panel.lines if line.get_marker() in ("+", "o")]
        for k, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[:k])
            for line in marks:
                x, y = panel.transData.transform(line.get_xydata()[0])
                assert not box.contains(x, y)
        names += len(called)
    assert names >= 12


def test_titles_break_between_what_they_say(figures):
    light = omma.light.clear_sky(
        35.27, sun_azimuth_deg=96.97, aerosol=0.1, ozone_du=300, albedo=0.1, height_m=0,
        haze_kind="rural", bands=omma.light.Bands.equal(2),
    )  # fmt: skip
    omma.picture.plot_sky("a.png", light, [440])
    lines = figures[-1].get_suptitle().split("\n")
    assert lines[0].endswith("albedo 0.1,")
    assert lines[1] == "height 0 m, rural haze"
    omma.picture.plot_sky("a.png", light, [440], title="letters " * 20)
    assert max(map(len, figures[-1].get_suptitle().split("\n"))) <= 100


def test_the_spectrums_axis_has_its_power_of_ten_beside_the_unit(tmp_path, monkeypatch):
    from omma.picture import sky_plots

    figures = []
    monkeypatch.setattr(sky_plots, "save", lambda one, *_: figures.append(one))
    light = omma.light.clear_sky(30)
    omma.picture.plot_sky(tmp_path / "a.png", light, [440])
    figures[0].canvas.draw()
    panel = next(a for a in figures[0].axes if a.get_xlabel() == "wavelength (nm)")
    assert panel.get_ylabel() == "on level ground\n($10^{18}$ photons m⁻² s⁻¹ nm⁻¹)"
    assert panel.yaxis.get_offset_text().get_text() == ""
    shown = [float(label.get_text()) for label in panel.get_yticklabels()]
    assert shown == pytest.approx(panel.get_yticks() / 1e18)


def test_what_has_no_angle_is_said(tmp_path, monkeypatch):
    from omma.picture import sky_plots
    from omma.picture.unseen import NOT_KNOWN

    figures = []
    monkeypatch.setattr(sky_plots, "save", lambda one, *_: figures.append(one))
    sky = np.zeros((2, 91, 8, 3, 1))
    sky[:, :, :, 0], sky[:, :, :, 1] = 1, 0.5
    half = sky.copy()
    half[:, :, :4, 1] = 0.005
    for each in (sky, half):
        light = omma.light.Light(omma.light.Bands.equal(1), sky=each)
        omma.picture.plot_sky(tmp_path / "a.png", light, [500])
    said = [[text.get_text() for text in figure.axes[2].texts] for figure in figures]
    assert "grey: less than 1% polarised" not in said[0]
    assert "grey: less than 1% polarised" in said[1]
    # The grey is there, where there is no angle, and no colour of an angle.
    angle, ground = figures[1].axes[2].images
    is_grey = ground.get_array()[..., 3] == 1
    assert is_grey.any()
    assert not (is_grey & ~np.ma.getmaskarray(angle.get_array())).any()
    grey = ground.get_array()[is_grey][0, :3]
    assert np.all(grey == NOT_KNOWN)
    assert np.abs(angle.cmap(np.linspace(0, 1, 512))[:, :3] - grey).max(axis=1).min() > 0.1
