"""Maps of eyes: where directions are, what a place shows, and that figures say what they show."""

import re
import xml.etree.ElementTree as ElementTree
from contextlib import nullcontext

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.eye.field import sphere_directions
from omma.eye.measures import measure_eye
from omma.picture.eye_maps import (
    PROJECTIONS,
    colour_limits,
    draw_graticule,
    make_map,
    map_directions,
    plot_eye_maps,
    project_directions,
)

pytest.importorskip("matplotlib")


@pytest.fixture(autouse=True)
def coarse_maps(monkeypatch):
    """Maps of few pixels: quicker, and as good for what is tested here."""
    monkeypatch.setattr("omma.picture.eye_maps._PIXELS", 200)


AHEAD, RIGHT, LEFT, UP = [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0]


@pytest.mark.parametrize(
    ("projection", "direction", "x", "y"),
    [
        ("mercator", AHEAD, 0, 0),
        ("mercator", RIGHT, np.pi / 2, 0),
        # ln tan(45° + 30°), where a degree is twice as long as at the equator.
        ("mercator", [0, np.sqrt(0.75), -0.5], 0, np.log(2 + np.sqrt(3))),
        ("mollweide", RIGHT, np.sqrt(2), 0),
        ("mollweide", LEFT, -np.sqrt(2), 0),
        ("mollweide", UP, 0, np.sqrt(2)),
        ("lambert", AHEAD, 0, 0),
        ("lambert", RIGHT, np.sqrt(2), 0),
        ("lambert", UP, 0, np.sqrt(2)),
    ],
)
def test_which_direction_is_where(projection, direction, x, y):
    # Newton's steps come to the pole of Mollweide's map only slowly.
    at = project_directions(np.array(direction, float), projection)
    assert at == pytest.approx([x, y], abs=1e-6)


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_there_and_back(projection):
    directions = sphere_directions(5000)
    if projection == "mercator":
        directions = directions[np.abs(directions[:, 1]) < np.sin(np.radians(79.9))]
    x, y = project_directions(directions, projection).T
    back = map_directions(projection, x, y)
    # Close to the poles of Mollweide's map and to Lambert's rim many directions are close.
    assert np.abs(back - directions).max() < 1e-5


@pytest.mark.parametrize("projection", ["mollweide", "lambert"])
def test_equal_areas(projection):
    # Of many places spread evenly over the map as many are in a cap as it has of the sphere.
    x, y = np.meshgrid(np.linspace(-3, 3, 1201), np.linspace(-2.1, 2.1, 841))
    directions = map_directions(projection, x, y)
    inside = np.isfinite(directions[..., 0])
    area = inside.sum() * (6 / 1200) * (4.2 / 840)
    assert area == pytest.approx(4 * np.pi, rel=0.002)
    for middle in (RIGHT, UP, [0.6, -0.48, 0.64]):
        fraction = np.mean(directions[inside] @ np.array(middle, float) > np.cos(0.7))
        assert fraction == pytest.approx((1 - np.cos(0.7)) / 2, rel=0.005)


def test_mercator_is_conformal():
    # A small circle stays one: steps to the right and up are as long, and at right angles.
    for azimuth, elevation in [(0, 0), (2, 0.5), (-1, -1.1)]:
        step = 1e-5
        around = np.array(
            [
                [azimuth, elevation],
                [azimuth + step / np.cos(elevation), elevation],
                [azimuth, elevation + step],
            ]
        )
        level = np.cos(around[:, 1])
        directions = np.column_stack(
            [level * np.sin(around[:, 0]), np.sin(around[:, 1]), -level * np.cos(around[:, 0])]
        )
        at = project_directions(directions, "mercator")
        right, up = at[1] - at[0], at[2] - at[0]
        assert np.linalg.norm(right) == pytest.approx(np.linalg.norm(up), rel=1e-3)
        assert abs(right @ up) < 1e-3 * (right @ right)


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_a_place_shows_the_nearest_axis_within_the_field(projection):
    directions = sphere_directions(900)
    eye = omma.Eye(1e-3 * directions[:450], directions[:450], 0.1)  # the upper half
    found = measure_eye(eye)
    the_map = make_map(found, projection, width=200)
    height, width = the_map.ommatidium.shape
    left, right, bottom, top = the_map.extent
    x = left + (np.arange(width) + 0.5) / width * (right - left)
    y = top - (np.arange(height) + 0.5) / height * (top - bottom)
    places = map_directions(projection, *np.meshgrid(x, y))
    inside = np.isfinite(places[..., 0])
    assert (the_map.ommatidium[~inside] == -2).all()
    shown = the_map.ommatidium >= 0
    assert (the_map.seen[0] == shown).all()
    nearest = (places[shown] @ eye.axis.T).argmax(axis=1)
    assert np.mean(nearest == the_map.ommatidium[shown]) > 0.999  # ties
    # What is seen is up: to half a cell below the lowest axes, some of which are a cell higher.
    half = np.degrees(np.median(found.interommatidial_rad)) / 2
    elevation = np.degrees(np.arcsin(places[..., 1]))
    assert elevation[shown].min() > -1.3 * half
    assert elevation[inside & ~shown].max() < 2 * half


def texts(path):
    """The words in an SVG are outlines; what they say is in comments."""
    return re.findall(r"<!-- (.*?) -->", path.read_text())


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_figure_says_what_it_shows(tmp_path, projection):
    eye = omma.eye.merge_eyes([omma.eye.generate_eye(300), omma.eye.generate_eye(200)])
    plot_eye_maps([tmp_path / "a.svg", tmp_path / "a.png", tmp_path / "a.pdf"], eye,
                  projection=projection)  # fmt: skip
    said = texts(tmp_path / "a.svg")
    for words in ("interommatidial angle Δφ (°)", "acceptance angle Δρ (°)", "Δρ/Δφ",
                  "500 ommatidia"):  # fmt: skip
        assert words in said
    assert not any("eye parameter" in words for words in said)  # not known
    assert ElementTree.parse(tmp_path / "a.svg").getroot().tag.endswith("svg")
    assert (tmp_path / "a.pdf").read_bytes()[:5] == b"%PDF-"


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_graticule_is_labelled(projection):
    from matplotlib.figure import Figure

    panel = Figure().add_subplot()
    draw_graticule(panel, projection, labels=True)
    said = {text.get_text(): text.xy for text in panel.texts}
    assert {"ahead 0°", "−60°", "30°"} <= set(said)
    assert said["ahead 0°"][0] == pytest.approx(0, abs=1e-9)
    assert said["30°"][1] > said["−30°"][1]
    # Meridians and circles each 30°, and the map's edge.
    assert len(panel.lines) >= 11 + 5 + 2


def test_figure_of_chosen_properties(tmp_path):
    eye = omma.eye.generate_eye(200).replace(
        facet_diameter_m=np.linspace(10e-6, 30e-6, 200),
        columns={"age": np.arange(200.0), "zone": ["dorsal", "ventral"] * 100},
    )
    plot_eye_maps(tmp_path / "a.svg", eye, ["eye-parameter", "age", "zone"], title="My eye")
    said = texts(tmp_path / "a.svg")
    for words in ("eye parameter D·Δφ (µm rad)", "age", "dorsal", "ventral", "My eye"):
        assert words in said


def test_what_is_the_same_throughout_needs_no_colours(tmp_path):
    plot_eye_maps(tmp_path / "a.svg", make_eye(50), ["acceptance"])
    assert "acceptance angle Δρ (°): 5 throughout" in texts(tmp_path / "a.svg")


def test_the_same_eye_gives_the_same_bytes(tmp_path):
    eye = omma.eye.generate_eye(100)
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        plot_eye_maps([tmp_path / folder / f"m.{e}" for e in ("svg", "png", "pdf")], eye)
    for ending in ("svg", "png", "pdf"):
        one, other = (tmp_path / folder / f"m.{ending}" for folder in ("a", "b"))
        assert one.read_bytes() == other.read_bytes()


def test_colours_end_before_what_is_far_out():
    values = np.append(np.linspace(1, 2, 999), 50.0)
    assert colour_limits(values)[2] == "max"
    assert colour_limits(values)[1] < 2.1
    assert colour_limits(values[:-1]) == (1, 2, "neither")
    assert colour_limits(np.append(values[:-1], np.nan)) == (1, 2, "neither")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"properties": ["colour"]}, ["property", "interommatidial", "colour"]),
        ({"properties": ["facet"]}, ["facet", "not known"]),
        ({"projection": "gnomonic"}, ["projection", "mercator", "gnomonic"]),
        ({"paths": "a.gif"}, ["a.gif", ".pdf"]),
    ],
)
def test_wrong_arguments_are_named(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(omma.Error) as caught:
        plot_eye_maps(**({"paths": "a.svg", "eye": make_eye(30)} | arguments))
    for word in words:
        assert word in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_commands(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("a.eye", omma.eye.generate_eye(150))
    code, out, err = run_omma("eye", "info", "a.eye", "--map", "m.pdf")
    assert (code, err) == (0, "")
    assert "wrote m.pdf" in out
    code, out, err = run_omma(
        "eye", "plot", "a.eye", "--what", "map", "--projection", "lambert", "--property",
        "horizontal", "--property", "neighbours", "-o", "l.svg", "--title", "T",
    )  # fmt: skip
    assert (code, out, err) == (0, "wrote l.svg\n", "")
    said = texts(tmp_path / "l.svg")
    for words in ("horizontal Δφ (°)", "neighbours", "T"):
        assert words in said


def test_crowded_values_have_a_logarithmic_scale():
    from omma.picture.eye_maps import is_crowded

    assert is_crowded(np.array([20.0] * 90 + [78.0] * 10), 20, 78)
    assert not is_crowded(np.linspace(20, 78, 100), 20, 78)
    assert not is_crowded(np.array([18.0] * 90 + [25.0] * 10), 18, 25)  # not twice as much
    assert not is_crowded(np.array([0.0] * 90 + [25.0] * 10), 0, 25)  # 0 has no logarithm


def test_angles_are_between_neighbours_on_the_surface():
    from omma.base.directions import direction

    # A square patch of a sphere whose axes are stretched four times as much sideways as up, so
    # that the nearest axes are not the neighbours' on the surface.
    across, up = np.meshgrid(np.arange(-10.0, 11), np.arange(-10.0, 11))
    across = across + 0.5 * (up % 2)
    position = direction(2 * across.ravel(), np.sqrt(3) * up.ravel())
    axis = direction(4 * across.ravel(), 0.8 * up.ravel())
    eye = omma.Eye(position * 1e-3, axis, 0.01)
    measures = omma.eye.measure_eye(eye)
    middle = np.argmin(np.hypot(across, up).ravel())
    # Two 4° along the row, four 2° along and 0.8° up.
    expected = np.radians((2 * 4 + 4 * np.hypot(2, 0.8)) / 6)
    # Meridians close in by less than 1 % this near to the equator.
    assert measures.surface_angle_rad[middle] == pytest.approx(expected, rel=0.01)
    assert measures.interommatidial_rad[middle] < 0.9 * expected
    flat = omma.Eye(np.zeros((len(axis), 3)), axis, 0.01)
    at_a_point = omma.eye.measure_eye(flat)
    assert (at_a_point.surface_angle_rad == at_a_point.interommatidial_rad).all()


@pytest.mark.parametrize(
    ("axes", "ids", "lone"),
    [
        ([[0, 0, -1]], [0], (0,)),
        ([[0, 0, -1]] * 2, [0, 0], (0, 1)),
        ([[-1, 0, -1], [1, 0, -1]], [0, 1], (0, 1)),
        ([[-1, 0, -1], [1, 0, -1]], [0, 0], ()),
    ],
)
def test_eyes_without_neighbours_are_drawn(tmp_path, axes, ids, lone):
    """No angle can be measured: ommatidia are points with their numbers."""
    eye = omma.Eye([[0, 0, 0]] * len(axes), axes, 0.0, 0.0, ids)
    measures = measure_eye(eye)
    assert make_map(measures, "mollweide", 300).lone == lone
    omma.picture.plot_eye_maps(tmp_path / "map.png", eye, measures=measures)
    with pytest.raises(omma.Error, match="is not known of any") if lone else nullcontext():
        omma.picture.plot_eye_maps(tmp_path / "map.png", eye, ["interommatidial"])


def test_a_poster_of_one_ommatidium_is_drawn(tmp_path):
    omma.picture.plot_poster(tmp_path / "poster.png", omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1))
