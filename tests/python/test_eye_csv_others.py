"""CSV files of eyes as others write them: separators, decimal commas, gaps, names of columns."""

import math
import warnings

import numpy as np
import pytest

import omma
from omma.eye.files import slips_in

HEADER = (
    "facet,position_x_um,position_y_um,position_z_um,azimuth_deg,elevation_deg,"
    "acceptance_angle_deg,facet_diameter_um"
)
ACCEPTANCE = 6  # its column


def rows(count=12):
    """Numbers with decimals; the acceptance grows by 0.25 degrees along a row 2 degrees apart."""
    return [
        [k, -900.5 + k, 1.25 * k, 400.0, -90 + 2.0 * k, 0.5, 4 + 0.25 * k, 24.5]
        for k in range(count)
    ]


def csv_of(header=HEADER, cells=None, before=""):
    cells = rows() if cells is None else cells
    lines = [",".join(str(one) for one in row) for row in cells]
    return before + "\n".join([header, *lines]) + "\n"


def quiet(path, **words):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return omma.load_eye(path, **words)


@pytest.fixture
def whole(tmp_path):
    (tmp_path / "whole.csv").write_text(csv_of())
    return quiet(tmp_path / "whole.csv")


@pytest.mark.parametrize("between", [";", "\t"])
@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_semicolons_tabs_and_decimal_commas(tmp_path, whole, between, decimal, end):
    text = csv_of(before="# measured by hand, 2026\n\n").replace(",", between)
    text = text.replace("# measured by hand" + between, "# measured by hand,")
    path = tmp_path / "eye.csv"
    path.write_bytes(text.replace(".", decimal).replace("\n", end).encode("utf-8-sig"))
    eye = quiet(path)
    assert eye == whole
    assert eye.path == str(path)
    assert eye.columns["facet"].tolist() == list(range(12))


def test_errors_name_the_line_of_the_file_itself(tmp_path):
    text = csv_of(before="# a comment\n").replace(",", ";").replace(".", ",")
    lines = text.splitlines()
    lines[5] = lines[5].replace("24,5", "wide")
    lines.insert(3, "")
    path = tmp_path / "eye.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(omma.Error, match=r'eye\.csv, line 7, column "facet_diameter_um".*"wide"'):
        omma.load_eye(path)


def test_names_with_semicolons_are_names(tmp_path):
    """A header with commas has commas between its cells."""
    path = tmp_path / "eye.csv"
    path.write_text('azimuth_deg,elevation_deg,acceptance_angle_deg,"size; mm"\n0,0,2,7\n')
    assert list(quiet(path).columns) == ["size; mm"]


@pytest.mark.parametrize(
    ("renamed", "look", "call"),
    [
        ({"position_": ""}, "x_um, y_um, z_um not read: they look like positions", "position_x_um"),
        ({"position_": "Pos "}, "Pos x_um, .* look like positions", "position_x_um"),
        ({"position_x_um": "X (µm)", "position_y_um": "Y (µm)", "position_z_um": "Z (µm)"},
         r"X \(µm\), Y \(µm\), Z \(µm\) not read", "position_x_um"),
        ({"position_x_um": "x_mm", "position_y_um": "y_mm", "position_z_um": "z_mm"},
         "x_mm, y_mm, z_mm not read", "position_x_um"),
        ({"facet_diameter": "diameter"}, "diameter_um not read: it looks like facet", "facet_diam"),
        ({"facet_diameter": "lens_diameter"}, "lens_diameter_um not read", "facet_diameter_um"),
        ({"facet,": "side,"}, "side not read: it looks like numbers of eyes", "eye_id"),
    ],
)  # fmt: skip
def test_columns_that_look_like_what_is_read_are_told(tmp_path, renamed, look, call):
    header = HEADER
    for one, other in renamed.items():
        header = header.replace(one, other)
    path = tmp_path / "eye.csv"
    path.write_text(csv_of(header))
    with pytest.warns(UserWarning, match=f"eye.csv: columns? {look}.*call (it|them) {call}"):
        omma.load_eye(path)
    # What the warning says to do where it is meant so: quiet, and the name is the same.
    names = [one for one in header.split(",") if one not in HEADER.split(",")]
    for name in names:
        header = header.replace(name, f"column:{name}")
    path.write_text(csv_of(header))
    assert set(names) <= set(quiet(path).columns)


def test_columns_of_files_that_have_what_is_read_are_not_told(tmp_path):
    """Beside positions, an x_um is whatever it is; so are one z alone, and a rhabdom's diameter."""
    path = tmp_path / "eye.csv"
    more = [[*row, 1, 2, 3] for row in rows()]
    path.write_text(csv_of(HEADER + ",x_um,y_um,diameter_um", more))
    quiet(path)
    bare = [[row[4], row[5], row[6], 1.5, 2] for row in rows()]
    head = "azimuth_deg,elevation_deg,acceptance_angle_deg,z,rhabdom_diameter_um"
    path.write_text(csv_of(head, bare))
    quiet(path)


@pytest.mark.parametrize(
    ("renamed", "told"),
    [
        ({"acceptance_angle": "acceptance"}, "acceptance_deg may be its acceptance angles: accept"),
        ({"acceptance_angle": "delta_rho"}, "delta_rho_deg may be its acceptance angles: accept"),
        ({"azimuth": "az", "elevation": "el"}, "az_deg may be its azimuths: azimuth_deg .*el_deg"),
        ({"azimuth_deg": "nx", "elevation_deg": "ny", "facet,": "nz,"},
         "nz, nx, ny may be its axes: axis_x, axis_y, axis_z"),
    ],
)  # fmt: skip
def test_errors_name_columns_that_look_like_what_lacks(tmp_path, renamed, told):
    header = HEADER
    for one, other in renamed.items():
        header = header.replace(one, other)
    path = tmp_path / "eye.csv"
    path.write_text(csv_of(header))
    with pytest.raises(omma.Error, match=f"found none; {told}"):
        omma.load_eye(path)


def test_errors_name_no_columns_in_place_of_what_is_read(tmp_path):
    """A wrong number is all that lacks; normals beside angles are extra columns."""
    cells = [[*row, 0, 1, 0] for row in rows()]
    cells[3][ACCEPTANCE] = "wide"
    path = tmp_path / "eye.csv"
    path.write_text(csv_of(HEADER + ",nx,ny,nz", cells))
    with pytest.raises(omma.Error, match="line 5") as told:
        omma.load_eye(path)
    assert "may be its" not in str(told.value)


@pytest.mark.parametrize("gap", ["", "NA", "nan", "null"])
@pytest.mark.parametrize("between", [",", ";"])
def test_gaps_are_filled_by_the_nearest_where_that_is_said(tmp_path, whole, gap, between):
    cells = rows()
    for k in (5, 11):
        cells[k][ACCEPTANCE] = gap
    path = tmp_path / "eye.csv"
    path.write_text(csv_of(cells=cells).replace(",", between))
    refused = "line 7.*2 of 12 ommatidia lack one.*--missing-acceptance neighbours"
    with pytest.raises(omma.Error, match=refused):
        omma.load_eye(path)
    with pytest.warns(UserWarning, match="2 of 12 ommatidia without .* up to 14 degrees off"):
        eye = omma.load_eye(path, missing_acceptance="neighbours")
    # Number 5 is a gap, so that the sixth of number 11 is 4, 14 degrees off.
    deg = np.degrees(eye.acceptance_angle_rad.astype(float))
    around = {5: (2, 3, 4, 6, 7, 8), 11: (10, 9, 8, 7, 6, 4)}
    for k, others in around.items():
        assert deg[k] == pytest.approx(4 + 0.25 * np.mean(others), abs=1e-5)
    kept = [k for k in range(12) if k not in around]
    assert (eye.acceptance_angle_rad[kept] == whole.acceptance_angle_rad[kept]).all()
    assert (eye.position_m == whole.position_m).all()


def test_gaps_beside_kernels_and_eyes_without_any(tmp_path):
    head = "azimuth_deg,elevation_deg,acceptance_angle_deg,eye_id,kernel,kernel_wavelength_nm"
    path = tmp_path / "eye.csv"
    lines = ["0,0,2,0,,", "2,0,,0,,", "4,0,9,0,pillbox,", "6,0,4,0,,", "0,0,50,1,,"]
    path.write_text("\n".join([head, *lines]))
    with pytest.warns(UserWarning, match="1 of 5 ommatidia"):
        eye = omma.load_eye(path, missing_acceptance="neighbours")
    # Neither the pillbox's nor the other eye's.
    assert math.degrees(eye.acceptance_angle_rad[1]) == pytest.approx(3, abs=1e-5)
    assert eye.acceptance(2).kernel == "pillbox"
    assert math.degrees(eye.acceptance(2).width_rad()) == pytest.approx(9, abs=1e-5)
    path.write_text("\n".join([head, *lines[:4], "0,0,,1,,"]))
    with pytest.raises(omma.Error, match=r"expected acceptance angles of some .* of eye 1"):
        omma.load_eye(path, missing_acceptance="neighbours")


@pytest.fixture
def without(tmp_path):
    """Positions and axes, as of a scan: without a column of acceptance angles, and with an empty
    one."""
    column = [row[:ACCEPTANCE] + row[ACCEPTANCE + 1 :] for row in rows()]
    empty = [[*row[:ACCEPTANCE], "", *row[ACCEPTANCE + 1 :]] for row in rows()]
    paths = tmp_path / "none.csv", tmp_path / "empty.csv"
    header = HEADER.replace("acceptance_angle_deg,", "")
    paths[0].write_text("# of a scan\n" + csv_of(header, column).replace(",", ";"))
    paths[1].write_text(csv_of(cells=empty))
    return paths


def test_a_table_without_any_acceptance_angles_has_a_way_in(without, whole):
    advice = r'none of 12 ommatidia has one: load_eye\(missing_acceptance="interommatidial"\)'
    for path in without:
        for missing in ("refuse", "neighbours"):
            with pytest.raises(omma.Error, match=f"{advice}.*omma eye acceptance --deg") as told:
                omma.load_eye(path, missing_acceptance=missing)
            assert 'missing_acceptance="neighbours"' not in str(told.value)
        with pytest.warns(UserWarning, match="12 of 12 .* interommatidial angle, .*not measured"):
            eye = omma.load_eye(path, missing_acceptance="interommatidial")
        assert eye.acceptance_angle_rad == pytest.approx(whole.interommatidial_angle_rad())
        assert (eye.position_m == whole.position_m).all()
        assert eye.path == str(path)


def test_interommatidial_angles_fill_gaps_beside_kernels(tmp_path):
    path = tmp_path / "eye.csv"
    head = "azimuth_deg,elevation_deg,kernel,kernel_wavelength_nm,facet_diameter_um"
    path.write_text("\n".join([head, "0,0,,,25", "2,0,airy,500,25", "4,0,,,25"]))
    with pytest.warns(UserWarning, match="2 of 3 ommatidia without"):
        eye = omma.load_eye(path, missing_acceptance="interommatidial")
    assert np.degrees(eye.acceptance_angle_rad[[0, 2]]) == pytest.approx([3, 3], abs=1e-5)
    assert eye.acceptance(1).kernel == "airy"
    path.write_text("azimuth_deg,elevation_deg\n0,0\n")
    with pytest.raises(omma.Error, match="ommatidium 0: it has no neighbour"):
        omma.load_eye(path, missing_acceptance="interommatidial")


def test_acceptance_takes_tables_without_any(without, tmp_path, run_omma):
    out = tmp_path / "out.csv"
    for path in without:
        for rule, expected_deg in ((["--degrees", "2.5"], 2.5), (["--ratio", "1"], None)):
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                assert run_omma("eye", "acceptance", path, *rule, "-o", out)[0] == 0
                eye = omma.load_eye(out)
            apart = np.degrees(eye.interommatidial_angle_rad())
            expected = expected_deg or apart
            assert np.degrees(eye.acceptance_angle_rad) == pytest.approx(expected, rel=1e-5)
        code, _, err = run_omma("eye", "acceptance", path, "--factor", "2", "-o", out)
        assert code == 1
        assert "omma eye acceptance --degrees or --ratio" in err


def test_gaps_are_of_csv_alone(tmp_path, whole):
    omma.save_eye(tmp_path / "eye.glb", whole)
    with pytest.raises(omma.Error, match=r"only \.csv files can have gaps"):
        omma.load_eye(tmp_path / "eye.glb", missing_acceptance="neighbours")
    with pytest.raises(omma.Error, match=r"missing_acceptance: expected .*neighbours"):
        omma.load_eye(tmp_path / "whole.csv", missing_acceptance="mean")


def test_an_acceptance_of_0_beside_others_is_told(tmp_path):
    cells = rows()
    cells[3][ACCEPTANCE] = 0
    path = tmp_path / "eye.csv"
    path.write_text(csv_of(cells=cells))
    told = "acceptance angle of 1 of 12 ommatidia is 0, that of number 3 first"
    with pytest.warns(UserWarning, match=told):
        omma.load_eye(path)
    for row in cells:  # rays are meant
        row[ACCEPTANCE] = 0
    path.write_text(csv_of(cells=cells))
    quiet(path)


def test_catches_without_an_acceptance_are_told():
    bee = omma.species.bumblebee(assume="honeybee_worker")
    few = bee.eye.take([0, 1, 2])
    narrow = few.replace(acceptance_angle_rad=[0.0, 0.02, 0.02])
    light = omma.light.uniform_sky(1e17)
    seen = np.ones(len(narrow.receptor_type))
    with pytest.warns(UserWarning, match="of ommatidium 0 first, catch no photons"):
        caught = omma.receptors.photon_catch(narrow, seen, light, integration_time_s=0.02)
    per_facet = np.add.reduceat(caught, narrow.first_receptor[:-1])
    assert per_facet[0] == 0
    assert (per_facet[1:] > 0).all()


@pytest.mark.parametrize(("width", "is_told"), [(0.03, True), (1.7, False), (0.3, False)])
def test_radians_in_a_column_of_degrees_are_told(tmp_path, width, is_told):
    path = tmp_path / "eye.csv"
    rows = [f"{azimuth},0,{width}" for azimuth in range(-40, 41, 2)]
    head = "azimuth_deg,elevation_deg,acceptance_angle_deg"
    path.write_text("\n".join([head, *rows]))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        omma.load_eye(path)
    assert [("0.03 rad would be 1.7°" in str(one.message)) for one in told] == [True] * is_told


@pytest.mark.parametrize("stated_deg", [1.18, 2.6])
def test_an_acceptance_angle_beside_another_angular_sensitivity_is_told(tmp_path, stated_deg):
    path = tmp_path / "eye.csv"
    path.write_text(
        "azimuth_deg,elevation_deg,acceptance_angle_deg,kernel,kernel_wavelength_nm,"
        f"facet_diameter_um\n0,0,{stated_deg},airy,500,25\n5,0,2,,,25\n"
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        eye = omma.load_eye(path)
    # 1.029 lambda / D
    assert np.degrees(eye.acceptance(0).width_rad()) == pytest.approx(1.179, abs=1e-3)
    found = [str(one.message) for one in told]
    assert found == [] if stated_deg == 1.18 else "is 2.6°" in found[0] and "1.18° wide" in found[0]


def test_axes_in_radians_under_names_of_degrees_are_told(tmp_path):
    eye = omma.eye.generate_eye(300)
    azimuth_rad = np.arctan2(eye.axis[:, 0], -eye.axis[:, 2])
    elevation_rad = np.arcsin(eye.axis[:, 1])
    head = "azimuth_deg,elevation_deg,acceptance_angle_deg"
    path = tmp_path / "eye.csv"
    # In radians the angles alone, and the acceptance angles too.
    for scale, width, is_told in ((1, 5, True), (1, 0.05, True), (180 / np.pi, 5, False)):
        rows = [
            f"{azimuth:.5f},{elevation:.5f},{width}"
            for azimuth, elevation in zip(scale * azimuth_rad, scale * elevation_rad, strict=True)
        ]
        path.write_text("\n".join([head, *rows]))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            omma.load_eye(path)
        assert ["may be radians" in str(one.message) for one in told] == [True] * is_told


@pytest.mark.parametrize("between", [",", ";"])
@pytest.mark.parametrize("top", ["", "sep=X\n"])
def test_what_excel_leaves_is_passed_over(tmp_path, whole, between, top):
    """Rows of which all cells are empty, at the end and between, and its line sep=;."""
    lines = csv_of().replace(",", between).splitlines()
    empty = between * 7
    text = top.replace("X", between) + "\n".join([*lines[:4], empty, *lines[4:], empty, empty, ""])
    path = tmp_path / "eye.csv"
    path.write_text(text)
    assert quiet(path) == whole


@pytest.mark.parametrize("mark", [b"\xff\xfe", b"\xfe\xff"])
@pytest.mark.parametrize("between", [",", "\t"])
def test_utf_16_is_read_by_its_byte_order_mark(tmp_path, whole, mark, between):
    """As Excel saves "Unicode text", with tabs."""
    order = "utf-16-le" if mark == b"\xff\xfe" else "utf-16-be"
    path = tmp_path / "poses.csv"
    path.write_bytes(
        mark + "x,y,z,yaw_deg,pitch_deg,roll_deg\n1,2,3,0,0,0\n".replace(",", between).encode(order)
    )
    assert omma.load_poses(path)[0, :3, 3].tolist() == [1, 2, 3]
    eye = tmp_path / "eye.csv"
    eye.write_bytes(mark + csv_of().replace(",", between).encode(order))
    assert quiet(eye) == whole
    cut = csv_of().splitlines()[:3]
    eye.write_bytes(mark + "\n".join(cut).encode(order) + b"\x00")
    with pytest.raises(omma.Error, match=r"eye\.csv, line 3: expected UTF-16 text, found other"):
        omma.load_eye(eye)


def test_gaps_are_told_of_where_filling_them_helps(tmp_path):
    """Not where the line of the first gap lacks a position too."""
    cells = rows()
    cells[5][ACCEPTANCE], cells[5][1] = "", ""
    path = tmp_path / "eye.csv"
    path.write_text(csv_of(cells=cells))
    with pytest.raises(omma.Error, match="line 7") as caught:
        omma.load_eye(path)
    assert "missing_acceptance" not in str(caught.value)


def test_an_angular_sensitivity_that_no_ommatidium_has_is_not_told_of(tmp_path):
    wide, narrow = omma.Acceptance.gaussian(0.2), omma.Acceptance.gaussian(0.05)
    eye = omma.eye.generate_eye(10).replace(acceptance=[wide] * 5 + [narrow] * 5).take([7])
    assert eye.acceptances[0] == wide
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert slips_in(eye) == []
        omma.save_eye(tmp_path / "eye.glb", eye)
        omma.load_eye(tmp_path / "eye.glb")
