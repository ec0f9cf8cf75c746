"""Drawings of eyes: files that are pictures, the right things on them, clear errors."""

import re
import struct
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from conftest import make_eye, svg_texts

import omma
from omma.picture.drawing import _Drawing, _length, _round_length, view_from

pytest.importorskip("matplotlib")

# Ahead, right, left, up, down, back, on a sphere of 1 mm.
SIX = np.array([[0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], dtype=float)


@pytest.fixture
def six():
    return omma.Eye(1e-3 * SIX, SIX, 0.1)


def seen(eye, yaw, pitch, back=False, style="facets"):
    view = view_from(np.radians(yaw), np.radians(pitch))
    return _Drawing(eye, view, style, back, None)


@pytest.mark.parametrize(
    ("yaw", "pitch", "right", "up", "towards"),
    [
        (0, 0, [-1, 0, 0], [0, 1, 0], [0, 0, -1]),  # from ahead its right is on our left
        (90, 0, [0, 0, -1], [0, 1, 0], [1, 0, 0]),  # from its right it looks to our right
        (180, 0, [1, 0, 0], [0, 1, 0], [0, 0, 1]),
        (0, 90, [-1, 0, 0], [0, 0, 1], [0, 1, 0]),
        (180, 90, [1, 0, 0], [0, 0, -1], [0, 1, 0]),
    ],
)
def test_which_direction_is_where(yaw, pitch, right, up, towards):
    assert view_from(np.radians(yaw), np.radians(pitch)) == pytest.approx(
        np.array([right, up, towards]), abs=1e-12
    )


def test_views_are_rotations():
    for yaw, pitch in np.random.default_rng(0).uniform(-3, 3, (20, 2)):
        view = view_from(yaw, pitch)
        assert view @ view.T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(view) == pytest.approx(1)


def test_only_what_faces_us_and_the_near_over_the_far(six):
    assert seen(six, 30, 20).shown.tolist() == [3, 1, 0]  # by how near: up, right, ahead
    assert seen(six, 210, 20).shown.tolist() == [3, 2, 5]
    assert len(seen(six, 30, 20, back=True).shown) == 6


def test_positions_in_millimetres(six):
    drawing = seen(six, 180, 0, back=True)
    assert drawing.start == pytest.approx(SIX[:, :2], abs=1e-6)


def test_facets_fill_the_surface():
    eye = omma.eye.generate_eye(400)
    drawing = seen(eye, 0, 0)
    # Hexagons of this distance across their flats cover the sphere of 1 mm.
    covered = 400 * np.sqrt(3) / 2 * np.mean(drawing.diameter**2)
    assert covered == pytest.approx(4 * np.pi, rel=0.05)  # neighbours' chords, lattice defects


def test_an_eye_at_a_point_is_drawn_along_its_axes():
    eye = omma.Eye(np.zeros((6, 3)), SIX, 0.1)
    drawing = seen(eye, 180, 0, back=True)
    assert drawing.lifted
    assert drawing.start == pytest.approx(SIX[:, :2] * drawing.length, abs=1e-6)
    assert (drawing.diameter > 0).all()
    assert not seen(eye, 180, 0, style="axes").lifted


def test_one_ommatidium_is_its_facet(tmp_path):
    one = omma.Eye(1e-3 * SIX[:1], SIX[:1], 0.1, facet_diameter_m=18e-6)
    drawing = seen(one, 0, 0)
    assert drawing.diameter == pytest.approx([0.018])
    assert drawing.notes() == []
    omma.picture.draw_eye(tmp_path / "a.svg", one)
    said = svg_texts(tmp_path / "a.svg")
    assert "1 ommatidium, seen from yaw 0°, pitch 0°" in said
    assert "5 µm" in said  # the bar
    omma.picture.draw_eye(tmp_path / "a.svg", one.replace(facet_diameter_m=0.0))
    said = svg_texts(tmp_path / "a.svg")
    assert "not to scale: its facet's diameter is not known" in said
    assert not any(words.endswith(("mm", "µm")) for words in said)


def test_the_title_says_which_ommatidia_are_counted(tmp_path):
    at_point = omma.Eye(np.zeros((8, 3)), np.tile(SIX[:1], (8, 1)), 0.1)
    head = omma.eye.merge_eyes([omma.eye.generate_eye(100), at_point])
    omma.picture.draw_eye(tmp_path / "a.svg", head, colour="none")
    said = svg_texts(tmp_path / "a.svg")
    facing = len(seen(head, 0, 0).shown)
    assert 8 < facing < 108
    title = f"108 ommatidia, seen from yaw 0°, pitch 0°: {facing} face the viewer"
    assert title in said
    assert "8 at one point with others: no facets to be seen" in said


@pytest.mark.parametrize(
    ("most", "length"), [(1, 1), (0.99, 0.5), (0.049, 0.02), (7, 5), (2e-3, 2e-3), (300, 200)]
)
def test_scale_bars_are_round(most, length):
    assert _round_length(most) == pytest.approx(length)


@pytest.mark.parametrize(
    ("mm", "text"), [(2, "2 mm"), (0.5, "0.5 mm"), (0.05, "50 µm"), (5e-4, "0.5 µm")]
)
def test_lengths_as_text(mm, text):
    assert _length(mm) == text


def png_size(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", data[16:24])


@pytest.mark.parametrize("style", ["facets", "axes"])
@pytest.mark.parametrize("colour", ["interommatidial", "acceptance", "eye", "none"])
def test_svg_and_png(tmp_path, style, colour):
    eye = make_eye(80)
    omma.picture.draw_eye(
        [tmp_path / "a.svg", tmp_path / "a.png"], eye, style=style, colour=colour, yaw_deg=40
    )
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    assert root.tag.endswith("svg")
    width = float(re.fullmatch(r"([\d.]+)pt", root.attrib["width"]).group(1))
    assert width == pytest.approx(150 / 25.4 * 72, rel=1e-3)  # 150 mm in points
    assert png_size(tmp_path / "a.png")[0] == pytest.approx(150 / 25.4 * 200, abs=1)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.svg"]


def paths_of(file, collection):
    """How many marks a collection of the SVG has."""
    tree = ElementTree.parse(file)
    groups = [g for g in tree.iter() if g.attrib.get("id", "").startswith(collection)]
    assert len(groups) == 1
    return sum(1 for mark in groups[0].iter() if mark.tag.endswith(("}use", "}path")))


def test_one_mark_for_each_ommatidium_shown(tmp_path):
    eye = make_eye(90)
    facing = int(np.sum(eye.axis[:, 2] < 0))
    omma.picture.draw_eye(tmp_path / "a.svg", eye, style="axes", colour="none")
    assert paths_of(tmp_path / "a.svg", "LineCollection") == facing
    omma.picture.draw_eye(tmp_path / "b.svg", eye, style="axes", colour="none", back=True)
    assert paths_of(tmp_path / "b.svg", "LineCollection") == 90


def test_the_same_eye_gives_the_same_bytes(tmp_path):
    eye = make_eye(50)
    for name in ("a", "b"):
        omma.picture.draw_eye([tmp_path / f"{name}.svg", tmp_path / f"{name}.png"], eye)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize("axes", [SIX[:1], SIX[:2], SIX[5:]])
def test_eyes_with_little_to_show(tmp_path, axes):
    eye = omma.Eye(1e-3 * axes, axes, 0.1)
    for style in ("facets", "axes"):
        omma.picture.draw_eye(tmp_path / f"{style}.png", eye, style=style)
        png_size(tmp_path / f"{style}.png")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"paths": "a.jpg"}, ["a.jpg", ".svg"]),
        ({"paths": ["a.svg", "b"]}, ["b", ".png"]),
        ({"paths": "no/a.svg"}, ["no/a.svg", "directory"]),
        ({"style": "dots"}, ["style", "facets", "dots"]),
        ({"colour": "red"}, ["colour", "interommatidial", "red"]),
        ({"yaw_deg": np.inf}, ["yaw_deg", "inf"]),
        ({"size_mm": 0}, ["size_mm", "0"]),
        ({"axis_length_mm": -1}, ["axis_length_mm", "-1"]),
    ],
)
def test_wrong_arguments_are_named(tmp_path, monkeypatch, six, arguments, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(omma.Error) as caught:
        omma.picture.draw_eye(**({"paths": "a.svg", "eye": six} | arguments))
    for word in words:
        assert word in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_without_matplotlib_it_says_what_to_install(tmp_path, monkeypatch, six):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(omma.Error, match=re.escape("pip install 'omma[plots]'")):
        omma.picture.draw_eye(tmp_path / "a.svg", six)
    assert list(tmp_path.iterdir()) == []


def test_command(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("l.eye", make_eye(40))
    omma.save_eye("r.eye", make_eye(40, seed=2))
    arguments = "l.eye r.eye --yaw 60 --pitch 10 --colour eye -o head.svg -o head.png"
    code, out, err = run_omma("eye", "draw", *arguments.split())
    assert (code, err) == (0, "")
    assert out == "wrote head.svg\nwrote head.png\n"
    direct = [omma.load_eye("l.eye"), omma.load_eye("r.eye")]
    omma.picture.draw_eye(
        "direct.svg", omma.eye.merge_eyes(direct), yaw_deg=60, pitch_deg=10, colour="eye"
    )
    assert (tmp_path / "direct.svg").read_bytes() == (tmp_path / "head.svg").read_bytes()
