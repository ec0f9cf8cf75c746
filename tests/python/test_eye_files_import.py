"""Eyes from measurements: what the Ommatidia Detecting Algorithm writes, lenses and cones."""

import numpy as np
import pytest

import omma


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
    found = omma.import_lens_cone(lens, cone, acceptance_angle_rad=0.03)
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
        omma.import_lens_cone(lens, cone)
    found = omma.import_lens_cone(lens, cone, allow_unmatched=True)
    assert found.unmatched_lenses.tolist() == [0, 1, 2, 3, 4]
    assert found.unmatched_cones.tolist() == []
    assert (found.cone == found.lens - 5).all()
    assert any("5 lenses and 0 cones" in note for note in found.notes)


def test_a_stray_tip_is_doubtful():
    lens, normal = grid()
    cone = lens - normal * 60
    cone[70] += [14.0, 3.0, 0.0]
    found = omma.import_lens_cone(lens, cone)
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
    found = omma.import_lens_cone(*files, "mm", ahead=(0, 1, 0), up=(0, 0, 1))
    assert found.eye.position_m == pytest.approx(lens * 1e-6, rel=1e-5, abs=1e-12)
    assert found.eye.axis == pytest.approx(normal, abs=1e-5)


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
    found = omma.import_oda(oda_file(tmp_path / "ommatidial_data.csv", points, axis))
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
    found = omma.import_oda(file)
    assert found.eye.axis == pytest.approx(normal, abs=1e-6)
    assert any(note.startswith("Assumed: 1 ommatidia without") for note in found.notes)
    assert any(note.startswith("Turned round: 1 ") for note in found.notes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
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
    rest = {"x": list(points[:, 0]), "anatomical_axis": texts, "approx_axis": texts}
    full = {name: [*first, *rest[name][1:]] for name, first in changes.items()}
    with pytest.raises(omma.Error) as caught:
        omma.import_oda(oda_file(tmp_path / "o.csv", points, normal, **full))
    for word in ["o.csv", *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "x,y,z\n1,2,3\n"])
def test_no_oda(tmp_path, text):
    (tmp_path / "o.csv").write_text(text)
    with pytest.raises(omma.Error, match=r"o\.csv"):
        omma.import_oda(tmp_path / "o.csv")


@pytest.mark.parametrize(
    "points", [np.zeros((5, 3)), np.zeros((20, 2)), "abc", np.full((20, 3), np.nan)]
)
def test_bad_points(points):
    lens, _ = grid(8)
    with pytest.raises(omma.Error):
        omma.import_lens_cone(lens, points, allow_unmatched=True)
