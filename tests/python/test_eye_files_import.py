"""Eyes from measurements: what the Ommatidia Detecting Algorithm writes, lenses and cones."""

import numpy as np
import pytest

import omma
from omma.eye.scan_tables import ScanTable


def grid(rows=14, spacing=20.0):
    """Hexagonal lattice on an ellipsoid of half a millimetre, micrometres: (N, 3) and normals."""
    i, j = np.meshgrid(np.arange(-rows, rows + 1), np.arange(-rows, rows + 1))
    x, y = spacing * (i + 0.5 * j), spacing * np.sqrt(0.75) * j
    keep = np.hypot(x, y) < rows * spacing * 0.8
    x, y = x[keep], y[keep]
    a, b, c = 500.0, 600.0, 400.0
    z = -c * np.sqrt(1 - (x / a) ** 2 - (y / b) ** 2)
    points = np.stack([x, y, z], axis=1)
    normal = points / np.square([a, b, c])
    return points, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def skewed(points, normal, angle_deg):
    """Axes leaning by that angle, more to one side the further over the eye."""
    lean = np.tan(np.radians(angle_deg)) * (1 + points[:, :1] / 1000)
    axis = normal + lean * np.array([0.8, 0.6, 0.0])
    return axis / np.linalg.norm(axis, axis=1, keepdims=True)


@pytest.mark.parametrize("skew_deg", [0, 20, 40])
def test_lenses_find_their_cones(skew_deg):
    lens, normal = grid()
    axis = skewed(lens, normal, skew_deg)
    rng = np.random.default_rng(1)
    order = rng.permutation(len(lens))
    length = 60 + 10 * rng.random((len(lens), 1))
    cone = (lens - axis * length)[order]
    found = omma.eye.scans.import_lens_cone(lens, cone, acceptance_angle_rad=0.03)
    assert (found.lens == np.arange(len(lens))).all()
    assert (order[found.cone] == found.lens).all()
    # Positions and axes are float32.
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-6, abs=1e-12)
    assert found.eye.axis == pytest.approx(axis, abs=1e-6)
    assert found.distance_m == pytest.approx(length[:, 0] * 1e-6, rel=1e-9)
    assert not found.doubtful.any()
    # The lattice has a spacing of 20 um seen from ahead; on the ellipsoid it is a little wider.
    assert 20e-6 < np.median(found.eye.facet_diameter_m) < 23e-6
    assert found.eye.acceptance_angle_rad == pytest.approx(0.03)
    nearest = np.linalg.norm(lens[:, None] - cone[None], axis=2).argmin(axis=1)
    if skew_deg == 40:  # what makes it hard: the nearest tip is another's
        assert np.mean(order[nearest] == np.arange(len(lens))) < 0.5


def test_unequal_counts_are_refused_or_reported():
    lens, normal = grid()
    cone = (lens - normal * 60)[5:]
    with pytest.raises(omma.Error, match=f"{len(lens)} and {len(cone)}"):
        omma.eye.scans.import_lens_cone(lens, cone)
    found = omma.eye.scans.import_lens_cone(lens, cone, allow_unmatched=True)
    assert found.unmatched_lenses.tolist() == [0, 1, 2, 3, 4]
    assert found.unmatched_cones.tolist() == []
    assert (found.cone == found.lens - 5).all()
    assert any("5 lenses and 0 cones" in note for note in found.notes)


def test_a_stray_tip_is_doubtful():
    lens, normal = grid()
    cone = lens - normal * 60
    cone[70] += [14.0, 3.0, 0.0]
    found = omma.eye.scans.import_lens_cone(lens, cone)
    assert found.doubtful[70]
    assert found.doubtful.sum() <= 3
    assert any(note.startswith("Doubtful") for note in found.notes)


def test_the_frame_of_a_scan(tmp_path):
    lens, normal = grid()
    # Ahead is +y and up +z of this scan: its x is then the animal's right.
    turned = np.stack([lens[:, 0], -lens[:, 2], lens[:, 1]], axis=1)
    axis = np.stack([normal[:, 0], -normal[:, 2], normal[:, 1]], axis=1)
    files = []
    for name, points in (("lens", turned), ("cone", turned - 60 * axis)):
        files.append(tmp_path / f"{name}.csv")
        np.savetxt(files[-1], points / 1e3, delimiter=",", header="x,y,z", comments="")
    found = omma.eye.scans.import_lens_cone(*files, "mm", ahead=(0, 1, 0), up=(0, 0, 1))
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-12)
    assert found.eye.axis == pytest.approx(normal, abs=1e-5)


def pair_of_caps(between_um, count=850):
    """Both eyes of a head: lenses, axes, tips and sides (0 left, 1 right), micrometres.

    Each an ellipsoid, looked off along its normals, a little askew, from 20 degrees on the other
    side to 150 degrees on its own: ahead the two look the same way, as those of flies do.
    """
    cosine = 1 - (1 - np.cos(np.radians(85))) * (np.arange(count) + 0.5) / count
    turn, sine = np.pi * (3 - np.sqrt(5)) * np.arange(count), np.sqrt(1 - cosine**2)
    middle, up = np.array([np.sin(np.radians(65)), 0, -np.cos(np.radians(65))]), np.array([0, 1, 0])
    frame = np.stack([np.cross(middle, up), up, middle])
    normal = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=1) @ frame
    radii = np.array([130.0, 210.0, 190.0])
    lens = normal * radii**2 / np.linalg.norm(normal * radii, axis=1, keepdims=True)
    axis = normal + [0.05, 0, -0.15] * (1 + 0.3 * normal[:, 1:2])
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    lens[:, 0] += between_um / 2 - lens[:, 0].min()
    tip = lens - axis * (25 + 5 * normal[:, 1:2])
    mirror = [-1, 1, 1]
    both = (np.concatenate([part * mirror, part]) for part in (lens, axis, tip))
    return *both, np.repeat([0, 1], count)


def test_both_eyes_of_a_scan_are_told_apart():
    lens, axis, tip, side = pair_of_caps(300)
    rng = np.random.default_rng(1)
    order, other = rng.permutation(len(lens)), rng.permutation(len(lens))
    found = omma.eye.scans.import_lens_cone(lens[order], tip[other])
    assert (found.eye.eye_id == side[order]).all()
    assert (other[found.cone] == order[found.lens]).all()
    assert not found.doubtful.any()
    # Each eye for itself, from its own axes. They are float32, so are the angles.
    alone = omma.Eye(lens[order] * 1e-6, axis[order], 0.1, eye_id=side[order])
    known = alone.interommatidial_angle_rad()
    assert found.eye.acceptance_angle_rad == pytest.approx(known, rel=1e-5)
    # What makes it matter: taken for one eye, neighbours of the other lie between the axes.
    as_one = alone.replace(eye_id=0).interommatidial_angle_rad()
    assert (as_one / known < 0.95).sum() > 100
    assert found.eye.facet_diameter_m == pytest.approx(omma.eye.facet_diameters_m(alone), rel=1e-5)
    assert any("850 ommatidia of the left one (eye_id 0)" in note for note in found.notes)


def test_a_scans_origin_off_the_midline_is_noted():
    lens, _, tip, _ = pair_of_caps(300)
    off = np.array([3000.0, 0, 0])
    whole = omma.eye.scans.import_lens_cone(lens, tip)
    assert not any("origin" in note for note in whole.notes)
    found = omma.eye.scans.import_lens_cone(lens + off, tip + off)
    (note,) = [note for note in found.notes if "origin" in note]
    assert "is at (3, " in note
    assert "place_on_head(eye, (-0.003, " in note
    back = omma.eye.place_on_head(found.eye, (-0.003, 0, 0))
    skew = [np.median(omma.eye.measure_eye(e).skew_head_rad) for e in (whole.eye, back, found.eye)]
    assert skew[1] == pytest.approx(skew[0], rel=1e-3)
    assert skew[2] > 2 * skew[0]


def test_another_unit_than_the_scans_is_warned_of(tmp_path):
    lens, normal = grid(8)
    with pytest.warns(UserWarning, match="lenses and cones: position_m .*no animal's .*eye radius"):
        omma.eye.scans.import_lens_cone(lens, lens - 40 * normal, "m")
    path = tmp_path / "ommatidial_data.csv"
    oda_file(path, lens, normal)
    with pytest.warns(UserWarning, match="ommatidial_data.csv: position_m .*no animal's"):
        omma.eye.scans.import_oda(path, "m")


def test_left_and_right_follow_from_ahead_and_up():
    lens, _, tip, side = pair_of_caps(300, 200)
    # In this scan +x is up, -y ahead and +z the animal's right.
    turned_lens, turned_tip = lens[:, [1, 2, 0]], tip[:, [1, 2, 0]]
    found = omma.eye.scans.import_lens_cone(turned_lens, turned_tip, ahead=(0, -1, 0), up=(1, 0, 0))
    assert (found.eye.eye_id == side).all()
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-9)
    # With the front and upper side left at -z and +y the eyes would lie behind one another.
    with pytest.raises(omma.Error, match=r"apart along .*say where its front and upper side"):
        omma.eye.scans.import_lens_cone(turned_lens, turned_tip)


def test_each_eye_of_a_scan_needs_its_tips():
    lens, _, tip, side = pair_of_caps(300, 200)
    with pytest.raises(omma.Error, match=r"of the left eye: .* found 200 and 197"):
        omma.eye.scans.import_lens_cone(lens, tip[3:])
    with pytest.raises(omma.Error, match="of the left eye"):  # as many in all
        omma.eye.scans.import_lens_cone(lens[:-3], tip[3:])
    found = omma.eye.scans.import_lens_cone(lens, tip[3:], allow_unmatched=True)
    assert found.unmatched_lenses.tolist() == [0, 1, 2]
    assert (found.cone == found.lens - 3).all()
    assert (found.eye.eye_id == side[3:]).all()


def test_eyes_that_touch_are_refused_or_said_to_be_doubtful():
    # One spacing between the lenses; between the tips, 25 um deeper, more than four.
    lens, _, tip, _ = pair_of_caps(15)
    with pytest.raises(omma.Error, match=r"found lenses in 1 .*import each eye from points of its"):
        omma.eye.scans.import_lens_cone(lens, tip)
    lens, _, tip, _ = pair_of_caps(7)
    found = omma.eye.scans.import_lens_cone(lens, tip)
    assert any("too many for marks of one eye" in note for note in found.notes)


def test_strays_make_no_eye():
    lens, normal = grid()
    stray = np.array([[900.0, 0, 0], [905, 0, 0], [0, 900, 0]])
    found = omma.eye.scans.import_lens_cone(
        np.concatenate([lens, stray]), np.concatenate([lens - 60 * normal, stray * 0.95])
    )
    assert (found.eye.eye_id == 0).all()
    assert len(found.eye) == len(lens) + 3


def imaris_file(path, points, unit="\u00b5m", title=True, encoding="utf-8", end=",", labels=False):
    """As Imaris exports positions of spots: with or without a title, labels, and a comma at the
    end (reiserlab/eyemap_T4: lens.csv and cone.csv in data/microCT/20240701_position; tests of
    cm_microtissue_struct for the title)."""
    lines = ["", " Position", " ==================== "] if title else []
    label_name, label = (",Default.Labels", ",") if labels else ("", "")
    names = "Position X,Position Y,Position Z,Unit,Category,Collection,Time"
    lines.append(f"{names}{label_name},ID{end}")
    for i, (x, y, z) in enumerate(points):
        lines.append(f"{x:.6g},{y:.6g},{z:.6g},{unit},Spot,Position,1{label},{i}{end}")
    path.write_bytes("\r\n".join([*lines, ""]).encode(encoding))
    return path


@pytest.mark.parametrize(
    ("unit", "options"),
    [
        ("\u00b5m", {}),
        ("\u00b5m", {"title": False, "end": "", "labels": True}),
        ("\u03bcm", {"title": False, "end": ""}),
        ("um", {"end": ""}),
        ("\u00b5m", {"encoding": "latin-1"}),
        ("mm", {"title": False}),
        ("nm", {}),
    ],
)
def test_positions_as_imaris_exports_them(tmp_path, unit, options):
    lens, normal = grid(8)
    scale = {"mm": 1e-3, "nm": 1e3}.get(unit, 1)
    files = [
        imaris_file(tmp_path / f"{name}.csv", points * scale, unit, **options)
        for name, points in (("lens", lens), ("cone", lens - 60 * normal))
    ]
    found = omma.eye.scans.import_lens_cone(*files)
    # Imaris writes six digits.
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-10)
    assert found.eye.axis == pytest.approx(normal, abs=1e-4)
    # A unit that is given goes before what the file says.
    with pytest.warns(UserWarning, match="no animal's"):
        given = omma.eye.scans.import_lens_cone(*files, "m")
    assert given.eye.position_m == pytest.approx(lens * scale, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize(
    ("header", "rows", "words"),
    [
        ("Position X,Position Y,Unit", "1,2,um", ["line 1", "Position X"]),
        ("Position X,Position Y,Position Z,Unit", "1,2,3,Pixel", ["line 2", "Unit", "'Pixel'"]),
        ("Position X,Position Y,Position Z,Unit", "1,2,3,um\n1,2,3,mm", ["one unit", "um, mm"]),
        ("Position X,Position Y,Position Z,Unit", "1,2", ["line 2", "'1,2'"]),
        ("x_um,x_px,y,z", "1,2,3,4", ["line 1", "x_um, x_px"]),
        ("x_um,y_mm,z_um", "1,2,3", ["line 1", "one unit"]),
        ("x,y,z", "1,2,three", ["line 2", "three numbers"]),
        ("Position\n====\nx,y,z", "1,2,three", ["line 4"]),
        ("1,2,3", "1,2,3,4", ["line 2", "three numbers"]),
        ("\0\0,1,2", "1,2,3", ["expected text"]),
    ],
)
def test_bad_files_of_points(tmp_path, header, rows, words):
    (tmp_path / "lens.csv").write_text(f"{header}\n{rows}\n")
    with pytest.raises(omma.Error) as caught:
        omma.eye.scans.import_lens_cone(tmp_path / "lens.csv", grid()[0])
    for word in ["lens.csv", *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_units_behind_names_and_separators(tmp_path, separator):
    lens, normal = grid(8)
    files = []
    for name, points in (("lens", lens), ("cone", lens - 60 * normal)):
        lines = [["n", "z_mm", "x_mm", "y_mm"]]
        lines += [[str(i), *(f"{v / 1e3:.9g}" for v in p[[2, 0, 1]])] for i, p in enumerate(points)]
        files.append(tmp_path / f"{name}.txt")
        files[-1].write_text("\n".join(separator.join(line) for line in lines))
    found = omma.eye.scans.import_lens_cone(*files)
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-10)


def oda_file(path, points, axis, **changes):
    """ommatidial_data.csv with the columns that ODA writes, in its order."""
    count = len(points)
    texts = [str(list(map(float, a))) for a in -axis]
    columns = {
        "label": np.arange(1, count + 1),
        "x": points[:, 0],
        "y": points[:, 1],
        "z": points[:, 2],
        "theta": np.zeros(count),
        "phi": np.zeros(count),
        "radius": np.full(count, 500.0),
        "size": np.full(count, 321),
        "lens_area": np.full(count, np.pi * 100.0),
        "anatomical_axis": texts,
        "approx_axis": texts,
        "skewness": np.full(count, 3.5),
        "spherical_IOA": np.full(count, 2.2),
        "neighbors": ["[1 2 3]"] * count,
        "cross_section_area": np.full(count, 250.0),
        "cross_section_height": np.full(count, 80.0),
        "lens_diameter": np.full(count, 20.0),
        "lens_diameter_adj": np.full(count, 19.0),
    } | changes
    lines = [",".join(columns)]
    for row in zip(*columns.values(), strict=True):
        lines.append(",".join(f'"{v}"' if "[" in str(v) else str(v) for v in row))
    path.write_text("\n".join(lines) + "\n")
    return path


def test_oda(tmp_path):
    points, normal = grid(8)
    axis = skewed(points, normal, 20)
    found = omma.eye.scans.import_oda(oda_file(tmp_path / "ommatidial_data.csv", points, axis))
    eye = found.eye
    assert eye.position_m == pytest.approx(points * 1e-6, rel=1e-6, abs=1e-12)
    assert eye.axis == pytest.approx(axis, abs=1e-6)  # out of the eye, ODA's point into it
    assert eye.facet_diameter_m == pytest.approx(20e-6)
    assert eye.acceptance_angle_rad == pytest.approx(eye.interommatidial_angle_rad(), rel=1e-6)
    assert (eye.columns["skewness"] == 3.5).all()
    assert eye.columns["neighbors"][0] == "[1 2 3]"
    assert "label" in eye.columns
    assert "x" not in eye.columns
    assert any("acceptance" in note for note in found.notes)


def test_oda_without_some_axes(tmp_path):
    points, normal = grid(8)
    texts = [str(list(map(float, -n))) for n in normal]
    anatomical = ["[nan, nan, nan]", str(list(map(float, normal[1]))), *texts[2:]]
    file = oda_file(tmp_path / "o.csv", points, normal, anatomical_axis=anatomical)
    found = omma.eye.scans.import_oda(file)
    assert found.eye.axis == pytest.approx(normal, abs=1e-6)
    assert any(note.startswith("Assumed: 1 ommatidia without") for note in found.notes)
    assert any(note.startswith("Turned round: 1 ") for note in found.notes)


def test_oda_rows_of_noise_are_no_ommatidia(tmp_path):
    """As in ODA's own example (tests/d_mauritiana_ct_stack/ommatidial_data.csv): the first row has
    label 0, no neighbours, no anatomical axis and no diameter, far from the others."""
    points, normal = grid(8)
    noise = np.array([[0.0, 0.0, -100.0], [300.0, 0.0, -100.0]])
    axes = np.concatenate([[[0, 0, -1], [0, 0, -1]], normal])
    count = len(axes)
    nan = ["[nan, nan, nan]"] * 2
    texts = [str(list(map(float, -a))) for a in axes]
    file = oda_file(
        tmp_path / "o.csv",
        np.concatenate([noise, points]),
        axes,
        label=np.arange(-1, count - 1),
        anatomical_axis=nan + texts[2:],
        lens_diameter=["", "", *["20.0"] * (count - 2)],
        neighbors=["[]"] * 2 + ["[1 2 3]"] * (count - 2),
    )
    found = omma.eye.scans.import_oda(file)
    assert len(found.eye) == len(points)
    assert found.eye.facet_diameter_m == pytest.approx(20e-6)
    assert found.eye.columns["label"].min() == 1
    assert found.eye.acceptance_angle_rad == pytest.approx(
        omma.eye.scans.import_oda(
            oda_file(tmp_path / "clean.csv", points, normal)
        ).eye.acceptance_angle_rad
    )
    assert any(note.startswith("Left out: 2 rows") for note in found.notes)
    assert not any("without an anatomical_axis" in note for note in found.notes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"label": [0] * 400}, ["noise"]),
        ({"x": ["a"]}, ["line 2", "column x", "'a'"]),
        ({"x": [np.nan]}, ["position"]),
        ({"anatomical_axis": ["[1, 2]"]}, ["line 2", "anatomical_axis", "three numbers"]),
        (
            {"anatomical_axis": ["[nan, 0, 0]"], "approx_axis": ["[nan, 0, 0]"]},
            ["line 2", "no axis"],
        ),
    ],
)
def test_bad_oda(tmp_path, changes, words):
    points, normal = grid(8)
    texts = [str(list(map(float, n))) for n in normal]
    rest = {"x": list(points[:, 0]), "anatomical_axis": texts, "approx_axis": texts, "label": []}
    full = {name: [*first, *rest[name][1:]][: len(points)] for name, first in changes.items()}
    with pytest.raises(omma.Error) as caught:
        omma.eye.scans.import_oda(oda_file(tmp_path / "o.csv", points, normal, **full))
    for word in ["o.csv", *words]:
        assert word in str(caught.value)


def test_columns_are_looked_up_not_searched(tmp_path):
    """Searched one after another, 100,000 columns took minutes."""

    class Columns(list):
        def index(self, *_):
            raise AssertionError("walks through all columns")

    points, normal = grid(4)
    table = ScanTable(str(oda_file(tmp_path / "o.csv", points, normal)))
    table.columns = Columns(table.columns)
    assert table.numbers("x") == pytest.approx(points[:, 0])
    assert table.texts("neighbors")[0] == "[1 2 3]"
    assert table.vectors("approx_axis") == pytest.approx(-normal)


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "x,y,z\n1,2,3\n"])
def test_no_oda(tmp_path, text):
    (tmp_path / "o.csv").write_text(text)
    with pytest.raises(omma.Error, match=r"o\.csv"):
        omma.eye.scans.import_oda(tmp_path / "o.csv")


@pytest.mark.parametrize(
    "points", [np.zeros((5, 3)), np.zeros((20, 2)), "abc", np.full((20, 3), np.nan)]
)
def test_bad_points(points):
    lens, _ = grid(8)
    with pytest.raises(omma.Error):
        omma.eye.scans.import_lens_cone(lens, points, allow_unmatched=True)
