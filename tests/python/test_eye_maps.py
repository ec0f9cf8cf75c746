"""Maps of eyes: where directions are, what a place shows, and that figures say what they show."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from conftest import make_eye, svg_texts

import omma
from omma.eye.field import sphere_directions
from omma.eye.measures import measure_eye
from omma.eye.properties import eye_property
from omma.picture.eye_maps import colour_limits, draw_graticule, make_map, plot_eye_maps
from omma.picture.map_projections import PROJECTIONS, map_directions, project_directions

pytest.importorskip("matplotlib")
pytestmark = pytest.mark.usefixtures("coarse_maps")

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


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_figure_says_what_it_shows(tmp_path, projection):
    eye = omma.eye.merge_eyes([omma.eye.generate_eye(300), omma.eye.generate_eye(200)])
    plot_eye_maps([tmp_path / "a.svg", tmp_path / "a.png", tmp_path / "a.pdf"], eye,
                  projection=projection)  # fmt: skip
    said = svg_texts(tmp_path / "a.svg")
    for words in ("interommatidial angle Δφ (°)", "angle of touching facets, smaller (°)",
                  "angle of touching facets, larger (°)", "acceptance angle Δρ (°)", "Δρ/Δφ",
                  "500 ommatidia",
                  "hatched: no ommatidium looks there; grey: not known, at a rim for want of "
                  "neighbours"):  # fmt: skip
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
    said = svg_texts(tmp_path / "a.svg")
    for words in ("eye parameter D·Δφ (µm rad)", "age", "dorsal", "ventral", "My eye"):
        assert words in said


def test_maps_are_made_in_pieces_that_are_told(monkeypatch):
    eye = omma.eye.merge_eyes([omma.eye.generate_eye(60), omma.eye.generate_eye(80)])
    measures = omma.eye.measure_eye(eye)
    whole = make_map(measures, "mollweide", 100)
    monkeypatch.setattr("omma.picture.eye_maps._PIECE", 500)
    shares = []
    parts = make_map(measures, "mollweide", 100, lambda _, share: shares.append(share))
    assert np.array_equal(parts.ommatidium, whole.ommatidium)
    assert np.array_equal(parts.seen, whole.seen)
    assert len(shares) == 2 * 8
    assert shares == sorted(set(shares))


def test_what_is_the_same_throughout_needs_no_colours(tmp_path):
    plot_eye_maps(tmp_path / "a.svg", make_eye(50), ["acceptance"])
    assert "acceptance angle Δρ (°): 5 throughout" in svg_texts(tmp_path / "a.svg")


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
    said = svg_texts(tmp_path / "l.svg")
    for words in ("horizontal Δφ (°)", "neighbours", "T"):
        assert words in said


def test_crowded_values_have_a_logarithmic_scale():
    from omma.picture.eye_maps import is_crowded

    assert is_crowded(np.array([20.0] * 90 + [78.0] * 10), 20, 78)
    assert not is_crowded(np.linspace(20, 78, 100), 20, 78)
    assert not is_crowded(np.array([18.0] * 90 + [25.0] * 10), 18, 25)  # not twice as much
    assert not is_crowded(np.array([0.0] * 90 + [25.0] * 10), 0, 25)  # 0 has no logarithm


def stretched_patch(turn_deg=0.0):
    """A patch of a sphere, a lattice with neighbours 2° apart on the surface, with axes stretched
    twice along its rows and 0.8/√3 times across them, all turned about straight ahead."""
    from omma.base.directions import direction

    across, up = np.meshgrid(np.arange(-10.0, 11), np.arange(-10.0, 11))
    across = across + 0.5 * (up % 2)
    position = direction(2 * across.ravel(), np.sqrt(3) * up.ravel())
    axis = direction(4 * across.ravel(), 0.8 * up.ravel())
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    middle = int(np.argmin(np.hypot(across, up).ravel()))
    return omma.Eye(position @ turn.T * 1e-3, axis @ turn.T, 0.01), middle


@pytest.mark.parametrize("turn_deg", [0, 30, 77, 90])
def test_the_ellipse_of_the_neighbours_is_found_whichever_way_it_lies(turn_deg):
    eye, middle = stretched_patch(turn_deg)
    measures = omma.eye.measure_eye(eye)
    # Meridians close in by less than 1 % this near to the equator.
    assert np.degrees(measures.smaller_rad[middle]) == pytest.approx(2 * 0.8 / np.sqrt(3), rel=0.01)
    assert np.degrees(measures.larger_rad[middle]) == pytest.approx(4, rel=0.01)


def test_a_dragonflys_dorsal_band_is_its_finest_part():
    eye = omma.species.dragonfly().eye
    measures = omma.eye.measure_eye(eye)
    elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)[1]
    smaller = eye_property(eye, measures, "smaller").values
    above, below = (smaller[(elevation > a) & (elevation < b)] for a, b in ((30, 70), (-60, -20)))
    # Land (1997): 0.24° across the band; the eye's facts say it.
    assert np.nanpercentile(above, 5) == pytest.approx(0.24, abs=0.02)
    assert np.nanpercentile(below, 5) > 0.65
    # The axes of its rows interleave: directions lie as in a lattice of √(0.24 · 1.15) = 0.53°.
    spacing = eye_property(eye, measures, "interommatidial").values
    above, below = (spacing[(elevation > a) & (elevation < b)] for a, b in ((30, 70), (-60, -20)))
    assert np.nanpercentile(above, 5) == pytest.approx(0.53, rel=0.05)
    assert np.nanpercentile(below, 5) > 0.7


def cap(rows=12):
    """A hexagon of a lattice 3° wide around straight ahead; which of its ommatidia are the rim."""
    q, r = np.meshgrid(np.arange(-rows, rows + 1), np.arange(-rows, rows + 1))
    ring = np.maximum(np.maximum(np.abs(q), np.abs(r)), np.abs(q + r)).ravel()
    x, y = 3 * (q + r / 2).ravel(), 3 * np.sqrt(0.75) * r.ravel()
    # Equal areas, so that the lattice is even to a few percent.
    angle = 2 * np.arcsin(np.radians(np.hypot(x, y)) / 2)
    turn = np.arctan2(y, x)
    axis = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), -np.cos(angle)], 1)
    kept = ring <= rows
    return omma.Eye(1e-3 * axis[kept], axis[kept], np.radians(3)), (ring == rows)[kept]


def test_the_rim_has_no_value_of_what_depends_on_neighbours():
    eye, rim = cap()
    measures = omma.eye.measure_eye(eye)
    assert (measures.surface_border == rim).all()
    for name in ("interommatidial", "surface-angle", "smaller", "larger", "horizontal", "vertical",
                 "ratio", "spacing", "sampling"):  # fmt: skip
        values = eye_property(eye, measures, name).values
        assert np.isnan(values[rim]).all()
        assert np.isfinite(values[~rim]).all()
    assert np.isfinite(eye_property(eye, measures, "acceptance").values).all()
    # What is all rim keeps what it has.
    few = eye.take([0, 1, 2])
    assert np.isfinite(eye_property(few, measure_eye(few), "interommatidial").values).all()


def test_maps_draw_the_rim_grey_and_hatch_what_nobody_sees():
    from matplotlib.figure import Figure

    from omma.picture.eye_maps import draw_map

    eye, rim = cap()
    measures = measure_eye(eye)
    the_map = make_map(measures, "lambert", 400)
    panel = Figure().add_subplot()
    draw_map(None, panel, the_map, eye_property(eye, measures, "smaller"))
    ground, values = (image.get_array() for image in panel.images)
    at_rim = (the_map.ommatidium >= 0) & rim[np.maximum(the_map.ommatidium, 0)]
    coloured = ~np.ma.getmaskarray(values)
    assert at_rim.sum() > 500
    assert not coloured[at_rim].any()
    assert coloured[(the_map.ommatidium >= 0) & ~at_rim].all()
    assert len(np.unique(ground[at_rim][:, 0])) == 1
    empty = np.unique(ground[the_map.ommatidium == -1][:, 0])
    assert len(empty) == 2  # hatched
    assert ground[at_rim][0, 0] not in empty
    assert (ground[..., 3] == (the_map.ommatidium != -2)).all()


def test_where_two_eyes_look_one_of_them_is_shown():
    axis = make_eye(2000).axis
    left = axis[axis[:, 0] < 0.4]
    sides = [left, left * np.float32([-1, 1, 1])]
    head = omma.eye.merge_eyes([omma.Eye(1e-3 * each, each, 0.1) for each in sides])
    the_map = make_map(measure_eye(head), "mollweide", 400)
    shown = the_map.ommatidium >= 0
    side = np.broadcast_to(np.arange(400) >= 200, shown.shape)
    both = the_map.seen.all(axis=0)
    assert both.mean() > 0.2
    assert ((the_map.ommatidium >= len(left)) == side)[both & shown].all()


def test_neighbours_in_direction_and_on_the_surface_have_a_name_each():
    # The nearest axes are not the neighbours' on the surface.
    eye, middle = stretched_patch()
    measures = omma.eye.measure_eye(eye)
    # Two 4° along the row, four 2° along and 0.8° up.
    expected = np.radians((2 * 4 + 4 * np.hypot(2, 0.8)) / 6)
    # Meridians close in by less than 1 % this near to the equator.
    assert measures.surface_angle_rad[middle] == pytest.approx(expected, rel=0.01)
    assert measures.interommatidial_rad[middle] < 0.9 * expected
    for name, label, values in (
        ("interommatidial", "interommatidial angle Δφ (°)", measures.interommatidial_rad),
        ("surface-angle", "angle of touching facets, mean (°)", measures.surface_angle_rad),
    ):
        drawn = eye_property(eye, measures, name)
        assert drawn.label == label
        assert np.radians(drawn.values[middle]) == pytest.approx(values[middle])
    flat = omma.Eye(np.zeros((len(eye), 3)), eye.axis, 0.01)
    at_a_point = omma.eye.measure_eye(flat)
    assert (at_a_point.surface_angle_rad == at_a_point.interommatidial_rad).all()


@pytest.mark.parametrize("axis", [[[0, 0, -1]], [[0, 0, -1]] * 3, [[0, 0, -1], [1, 0, 0]]])
def test_eyes_whose_angles_cannot_be_measured_are_drawn(tmp_path, axis):
    eye = omma.Eye(np.zeros((len(axis), 3)), axis, 0.1)
    plot_eye_maps(tmp_path / "a.svg", eye)
    said = svg_texts(tmp_path / "a.svg")
    assert "angle of touching facets, smaller (°): not known" in said
    assert "acceptance angle Δρ (°): 5.73 throughout" in said
    omma.picture.plot_poster(tmp_path / "p.svg", eye)
    said = svg_texts(tmp_path / "p.svg")
    assert "acceptance angle Δρ (°): 5.73 throughout" in said
    assert not any("touching facets" in words for words in said)
