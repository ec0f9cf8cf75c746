"""Lenses and cones marked in a scan, as people and programs write them."""

import pytest
from test_eye_files_import import grid, pair_of_caps

import omma


def written(tmp_path, header, columns, between=",", decimal="."):
    """Files of lenses and cones, with a column for each of ``columns`` (of x y z)."""
    lens, normal = grid(8)
    files = []
    for name, points in (("lens", lens), ("cone", lens - 60 * normal)):
        lines = [between.join(header)] if header else []
        for k, point in enumerate(points):
            cells = [str(k) if c is None else f"{point[c]:.9g}" for c in columns]
            lines.append(between.join(cells).replace(".", decimal))
        files.append(tmp_path / f"{name}.csv")
        files[-1].write_text("\n".join(lines))
    return lens, normal, files


def test_lenses_and_cones_swapped_are_refused():
    lens, normal = grid()
    with pytest.raises(omma.Error, match=r"point into it.*are lenses and cones swapped"):
        omma.eye.scans.import_lens_cone(lens - 60 * normal, lens)
    lens, _, tip, _ = pair_of_caps(300)
    with pytest.raises(omma.Error, match="850 of the left eye that point into it"):
        omma.eye.scans.import_lens_cone(tip, lens)


def test_axes_that_may_point_into_the_head_are_noted_and_kept():
    """A hollow eye: its axes spread, but point to where the sphere of its lenses has its middle."""
    lens, normal = grid()
    hollow = lens + 60 * (lens * [1, 1, 0] / 500 - [0, 0, -1])
    found = omma.eye.scans.import_lens_cone(hollow, lens)
    assert any(note.startswith("Looks wrong: ") for note in found.notes)
    right = omma.eye.scans.import_lens_cone(lens, lens - 60 * normal)
    assert not any(note.startswith("Looks wrong") for note in right.notes)


@pytest.mark.parametrize("index", [True, False])
def test_naparis_axes_are_z_y_x(tmp_path, index):
    header, columns = ["axis-0", "axis-1", "axis-2"], [2, 1, 0]
    if index:
        header, columns = ["index", *header], [None, *columns]
    lens, normal, files = written(tmp_path, header, columns)
    found = omma.eye.scans.import_lens_cone(*files)
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-10)
    assert found.eye.axis == pytest.approx(normal, abs=1e-5)


@pytest.mark.parametrize(
    "names",
    ["a,b,c", "axis-0,axis-1", "row;column;plane", "one two three", "axis-0,axis-1,axis-2,axis-3"],
)
def test_unknown_names_of_columns_are_refused(tmp_path, names):
    between = next((one for one in ",; " if one in names), ",")
    header = names.split(between)
    *_, files = written(tmp_path, header, [0, 1, 2, None][: len(header)], between)
    with pytest.raises(omma.Error, match=r"lens\.csv, line 1: expected columns x, y, z.*found"):
        omma.eye.scans.import_lens_cone(*files)


@pytest.mark.parametrize("header", [["x", "y", "z"], None])
@pytest.mark.parametrize("between", [";", "\t", " "])
def test_decimal_commas_where_commas_separate_nothing(tmp_path, header, between):
    lens, _, files = written(tmp_path, header, [0, 1, 2], between, ",")
    found = omma.eye.scans.import_lens_cone(*files)
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-10)


def test_a_title_above_numbers_is_none(tmp_path):
    lens, _, files = written(tmp_path, ["# lenses, as marked"], [0, 1, 2])
    found = omma.eye.scans.import_lens_cone(*files)
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-10)
