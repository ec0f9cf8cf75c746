"""Points as text: columns with names and without, grids, decimal commas."""

import numpy as np
import pytest
from point_clouds import CLASSES, COLOURS, COUNT, PLACES, srgb_to_linear, turned

import omma
from omma.scene import load_points


@pytest.mark.parametrize(
    ("name", "head", "columns"),
    [
        ("a.xyz", "", "xyz"),
        ("a.txt", "", "xyzi"),
        ("a.asc", "", "xyzi"),
        ("a.xyz", "# made by hand\n", "xyzrgb"),
        ("a.pts", f"{COUNT}\n", "xyzirgb"),
        ("a.csv", "B,G,R,Z,Y,X\n", "bgrzyx"),
        ("a.txt", "//X Y Z Classification\n", "xyzc"),
    ],
)
def test_text_with_and_without_names(tmp_path, name, head, columns):
    values = dict(zip("xyzrgb", [*PLACES.T, *COLOURS.T]), i=np.arange(COUNT), c=CLASSES)
    table = np.stack([values[one].astype(float) for one in columns], axis=1)
    split = "," if name.endswith("csv") else " "
    rows = [split.join(f"{x:.7g}" for x in row) for row in table]
    (tmp_path / name).write_text(head + "\n".join(rows) + "\n")
    cloud = load_points(tmp_path / name)
    assert cloud.positions_m == pytest.approx(turned(PLACES), abs=1e-6)
    has = {"colors": "r", "intensity": "i", "labels": "c"}
    for field, column in has.items():
        assert (getattr(cloud, field) is not None) == (column in columns), field
    if "r" in columns:
        assert cloud.colors == pytest.approx(srgb_to_linear(COLOURS / 255), abs=1e-6)
    if "c" in columns:
        assert (cloud.labels == CLASSES).all()


def test_a_grid_of_heights_is_told(tmp_path):
    (tmp_path / "a.asc").write_text("NCOLS 2\nnrows 1\nxllcorner 0\nyllcorner 0\n1 2\n")
    with pytest.raises(omma.Error, match=r"a\.asc: .*found a grid of heights \(ESRI ASCII\)"):
        omma.load_scene(tmp_path / "a.asc")


def rows(*columns, count=40):
    """Lines of text: places on a slope, and these numbers in each."""
    places = [(0.05 * k, 0.1 * (k % 7), 0.02 * k) for k in range(count)]
    return [" ".join(f"{x:.4f}" for x in (*one, *columns)) for one in places]


@pytest.mark.parametrize(
    ("name", "columns", "color", "intensity"),
    [
        ("a.xyz", (128, 64, 200), (128, 64, 200), False),
        ("a.xyz", (128, 64, 200, 3000), (128, 64, 200), True),
        ("a.xyz", (128, 64, 200, 0.5), (128, 64, 200), True),
        ("a.xyz", (-1200, 128, 64, 200), (128, 64, 200), True),
        ("a.pts", (20, 128, 64, 200), (128, 64, 200), True),
        ("a.pts", (3000, 128, 64, 200), (128, 64, 200), True),
    ],
)
def test_columns_without_names_by_what_they_hold(tmp_path, name, columns, color, intensity):
    (tmp_path / name).write_text("\n".join(rows(*columns)))
    found = load_points(tmp_path / name)
    assert found.colors[0] == pytest.approx(srgb_to_linear(np.array(color) / 255), abs=1e-4)
    assert (found.intensity is not None) == intensity


def test_columns_that_may_be_either_are_told(tmp_path):
    (tmp_path / "a.xyz").write_text("\n".join(rows(20, 128, 64, 200)))
    with pytest.warns(UserWarning, match="read as x y z intensity red green blue; name them"):
        load_points(tmp_path / "a.xyz")


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.6, 0, 0.8), (-0.6, 0, 0.8)])
def test_normals_are_no_colours(tmp_path, normal):
    (tmp_path / "a.xyz").write_text("\n".join(rows(*normal)))
    found = load_points(tmp_path / "a.xyz")
    assert found.colors is None
    # +Z was up in the file, as text has it.
    assert found.normals[0] == pytest.approx((normal[0], normal[2], -normal[1]), abs=1e-6)


@pytest.mark.parametrize("between", [";", "\t"])
@pytest.mark.parametrize("head", ["", "x y z red green blue\n"])
def test_decimal_commas(tmp_path, between, head):
    text = head + "\n".join(rows(128, 64, 200))
    plain, commas = tmp_path / "plain.xyz", tmp_path / "commas.xyz"
    plain.write_text(text)
    commas.write_text(text.replace(".", ",").replace(" ", between))
    expected, found = load_points(plain), load_points(commas)
    assert np.array_equal(found.positions_m, expected.positions_m)
    assert np.array_equal(found.colors, expected.colors)
