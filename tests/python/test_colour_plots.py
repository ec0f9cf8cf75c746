"""Figures of colours: loci where the spaces say, corners, the spectrum, names and clear errors."""

import math
import re

import numpy as np
import pytest
from conftest import svg_texts

import omma
from omma import colour_vision as cv
from omma.colour_vision import plots
from omma.colour_vision.plot_parts import mark

pytest.importorskip("matplotlib")


@pytest.fixture
def drawn(monkeypatch):
    """Figures as they are written."""
    figures = []
    save = plots.save_figure

    def keep(figure, names, dpi):
        figures.append(figure)
        save(figure, names, dpi)

    monkeypatch.setattr(plots, "save_figure", keep)
    return figures


def marked(panel, name):
    """Loci of one name."""
    return np.concatenate([line.get_xydata() for line in panel.lines if line.get_label() == name])


def words(panel):
    return {text.get_text(): np.array(text.xy) for text in panel.texts if hasattr(text, "xy")}


def test_hexagon(tmp_path, drawn):
    excited = [[0, 1, 0], [0.5, 0.5, 0.5], [0, 0, 1]]
    cv.plot_hexagon(tmp_path / "a.svg", excited, labels=["petal", "leaf", "petal"])
    (panel,) = drawn[0].axes
    # A pure excitation of one class is a corner, by Chittka 1992: sin 60° to the side, 1/2 down.
    right = [math.sqrt(3) / 2, -0.5]
    assert marked(panel, "petal") == pytest.approx(np.array([[0, 1], right]))
    assert marked(panel, "leaf") == pytest.approx(np.zeros((1, 2)))
    corners = words(panel)
    assert corners["green"] == pytest.approx(right)
    assert corners["UV"] == pytest.approx([-math.sqrt(3) / 2, -0.5])
    assert corners["UV-green"] == pytest.approx([0, -1])
    said = svg_texts(tmp_path / "a.svg")
    assert {"Colour hexagon", "petal", "leaf", "blue", "UV-blue"} <= set(said)


def test_sectors_lie_between_their_borders(tmp_path, drawn):
    cv.plot_hexagon(tmp_path / "a.png", [0.5, 0.5, 0.5])
    (panel,) = drawn[0].axes
    for border in (line.get_xydata()[1] for line in panel.lines if line.get_linestyle() == "--"):
        turn = np.radians([-1, 1])
        beside = np.stack([
            border[0] * np.cos(turn) + border[1] * np.sin(turn),
            border[1] * np.cos(turn) - border[0] * np.sin(turn),
        ], axis=-1)  # fmt: skip
        one, other = cv.hexagon_sector(beside)
        assert one != other


def test_triangle_with_a_spectrum_in_any_order(tmp_path, drawn):
    nm = np.array([500.0, 350.0, 430.0])
    alone = np.eye(3)[[2, 0, 1]]
    cv.plot_triangle(
        tmp_path / "a.png", [1, 1, 1], classes=["S", "M", "L"], spectrum=(nm, alone)
    )  # fmt: skip
    (panel,) = drawn[0].axes
    corners = words(panel)
    locus = next(line for line in panel.lines if len(line.get_xydata()) == 3)
    wanted = [corners[name] for name in "SML"]  # from short to long wavelengths
    assert locus.get_xydata() == pytest.approx(np.array(wanted))
    assert np.hypot(*(wanted[0] - wanted[1])) == pytest.approx(math.sqrt(2))
    assert {"350", "500"} <= set(corners)


def test_tetrahedron_is_seen_from_two_sides(tmp_path, drawn):
    catches = [[0.2, 0.5, 1.0, 1.2]]
    cv.plot_tetrahedron(tmp_path / "a.png", catches, labels=["petal"])
    side, above = drawn[0].axes
    x, y, z = cv.tetrahedron(catches).position[0]
    assert marked(side, "petal")[0] == pytest.approx([x, z])
    assert marked(above, "petal")[0] == pytest.approx([x, y])
    assert words(side)["UV"] == pytest.approx([0, 0.75])
    assert words(above)["UV"] == pytest.approx([0, 0])


def test_fly_categories_lie_in_their_quadrants(tmp_path, drawn):
    catches = [[3, 1, 1, 2], [1, 3, 1, 2]]
    cv.plot_fly_categories(tmp_path / "a.png", catches, labels=["one", "other"])
    (panel,) = drawn[0].axes
    at = {text.get_text(): np.sign(text.get_position()) for text in panel.texts}
    for name, category in zip(("one", "other"), cv.fly_category(catches), strict=True):
        assert np.sign(marked(panel, name)[0]).tolist() == at[category].tolist()


def test_distances_beside_the_threshold(tmp_path, drawn):
    apart = np.array([[8.6, 5.2], [0.7, 0.4]])
    cv.plot_distances(
        tmp_path / "a.pdf", apart, ["petal", "sepal"], series=["noon", "dusk"], threshold=2
    )
    (panel,) = drawn[0].axes
    assert marked(panel, "noon")[:, 0].tolist() == [8.6, 0.7]
    assert marked(panel, "dusk")[:, 0].tolist() == [5.2, 0.4]
    line = next(line for line in panel.lines if line.get_linestyle() == "--")
    assert line.get_xdata() == [2, 2]
    assert panel.get_xlabel() == "distance (just-noticeable differences)"
    assert panel.yaxis_inverted()  # the first is above


def test_a_colour_without_a_distance_leaves_a_gap(tmp_path, drawn):
    apart = [[8.6, np.nan], [np.nan, np.nan], [0.7, 0.4]]
    cv.plot_distances(tmp_path / "a.pdf", apart, ["a", "b", "c"], series=["noon", "dusk"])
    drawn[0].canvas.draw()
    (panel,) = drawn[0].axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["a", "b", "c"]
    assert np.isfinite(marked(panel, "noon")[:, 0]).tolist() == [True, False, True]
    ends = [segment[1][0] for segment in panel.collections[0].get_segments()]
    assert ends == [8.6, 0, 0.7]
    assert panel.get_xlim()[1] == pytest.approx(1.06 * 8.6)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda to: cv.plot_distances(to, [np.nan], ["a"]), "or NaN where there is none"),
        (lambda to: cv.plot_distances(to, [1, np.inf], ["a", "b"]), "finite numbers from 0 on"),
        (lambda to: cv.plot_hexagon(to, [0, 1, 2]), "excitations from 0 to 1"),
        (
            lambda to: cv.plot_hexagon(to, [0, 1, 0], spectrum=([400, 500], [[0, 1, 2]] * 2)),
            "spectrum: expected excitations from 0 to 1, found 2; of catches",
        ),
        (
            lambda to: cv.plot_triangle(to, [1, 1, 1], spectrum=([400, 500], [[0, 1, -2]] * 2)),
            "spectrum: expected finite numbers from 0 on",
        ),
        (lambda to: cv.plot_hexagon(to, np.empty((0, 3))), "at least one colour"),
        (lambda to: cv.plot_triangle(to, [1, 1, 1], labels=["a", "b"]), "labels: expected 1 names"),
        (lambda to: cv.plot_triangle(to, [1, 1, 1], classes="abc"), "classes: expected a sequence"),
        (lambda to: cv.plot_tetrahedron(to, [1, 1, 1]), "expected shape (..., 4)"),
        (
            lambda to: cv.plot_triangle(to, [1, 1, 1], spectrum=([400, 500], np.eye(3))),
            "a row for each of 2 wavelengths",
        ),
        (lambda to: cv.plot_triangle(to, [1, 1, 1], spectrum=([400], [[1, 1, 1]])), "at least two"),
        (
            lambda to: cv.plot_triangle(to, [1, 1, 1], spectrum=([0.4, 0.5], np.eye(3)[:2])),
            "spectrum: expected wavelengths of 100 to 5000 nm, found 0.4 to 0.5",
        ),
        (lambda to: cv.plot_distances(to, [1, -1], ["a", "b"]), "from 0 on"),
        (lambda to: cv.plot_distances(to, [[1, 2]], ["a"]), "series: expected 2 names"),
        (lambda to: cv.plot_distances(to, [1], ["a"], threshold=0), "threshold"),
        (
            lambda to: cv.plot_hexagon(to, np.zeros((37, 3)), labels=[str(k) for k in range(37)]),
            "at most 36",
        ),
    ],
)
def test_what_cannot_be_drawn_is_said(tmp_path, call, said):
    with pytest.raises(omma.Error, match=re.escape(said)):
        call(tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("plot", "colour"),
    [
        (cv.plot_hexagon, [0.2, 0.6, 0.7]),
        (cv.plot_triangle, [0.2, 0.6, 0.7]),
        (cv.plot_tetrahedron, [0.2, 0.6, 0.7, 1.0]),
        (cv.plot_fly_categories, [0.2, 0.6, 0.7, 1.0]),
    ],
)
def test_long_names_stay_in_the_figure(tmp_path, drawn, plot, colour):
    names = ["red petal with ultraviolet", "grey leaf of another plant, seen in the shade"]
    plot(tmp_path / "a.png", [colour, colour[::-1]], labels=names)
    (figure,) = drawn
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == names
    box = legend.get_window_extent()
    assert box.x1 <= figure.bbox.x1
    assert all(box.x0 >= panel.get_tightbbox().x1 for panel in figure.axes)


def test_a_legend_of_many_names_stays_in_the_figure(tmp_path, drawn):
    names = [f"species {k}" for k in range(36)]
    for colours in (np.random.default_rng(1).random((36, 3)), np.eye(36, 3) + 0.1):
        cv.plot_triangle(tmp_path / "a.png", colours, labels=names)
    for figure in drawn:
        (legend,) = figure.legends
        assert [text.get_text() for text in legend.get_texts()] == names
        box, page = legend.get_window_extent(), figure.bbox
        assert 0 <= box.y0 < box.y1 <= page.y1
        assert box.x1 <= page.x1


def test_names_stand_as_they_are(tmp_path, drawn):
    """Names that begin with an underscore had no entry, and between two $ was mathematics."""
    names = ["_leaf", "petal $a$ and $b_1$"]
    cv.plot_hexagon(tmp_path / "a.svg", [[0.2, 0.6, 0.7], [0.4, 0.5, 0.5]], labels=names)
    cv.plot_triangle(tmp_path / "b.svg", np.eye(3), classes=["$S$ $1$", "M", "L"], title="$t$ $1$")
    cv.plot_distances(tmp_path / "c.svg", [[1, 2]], ["$a$ or $b$"], series=names)
    assert set(names) <= set(svg_texts(tmp_path / "a.svg"))
    assert {"$S$ $1$", "$t$ $1$"} <= set(svg_texts(tmp_path / "b.svg"))
    assert {*names, "$a$ or $b$"} <= set(svg_texts(tmp_path / "c.svg"))


def test_each_dot_of_a_spectrum_has_its_number(tmp_path, drawn):
    nm = np.arange(300.0, 701, 10)
    peaks = np.array([350, 440, 540])
    alone = np.exp(-(((nm[:, None] - peaks) / 40) ** 2)) + 1e-6
    cv.plot_triangle(tmp_path / "a.png", [1, 1, 1], spectrum=(nm, alone))
    (panel,) = drawn[0].axes
    dots = [line.get_xydata()[0] for line in panel.lines if line.get_markersize() == 2]
    numbers = [np.array(text.xy) for text in panel.texts if text.get_text().isdecimal()]
    assert len(dots) == len(numbers) > 3
    np.testing.assert_allclose(dots, numbers)
    # Each stands nearest to its own dot.
    drawn[0].canvas.draw()
    places = panel.transData.transform(dots)
    for k, text in enumerate(one for one in panel.texts if one.get_text().isdecimal()):
        box = text.get_window_extent()
        middle = np.array([(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2])
        assert np.argmin(np.linalg.norm(places - middle, axis=1)) == k


def test_as_many_marks_as_names():
    marks = [tuple(mark(k)[key] for key in ("color", "marker")) for k in range(36)]
    assert len(set(marks)) == 36
