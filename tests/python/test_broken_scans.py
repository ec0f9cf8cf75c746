"""Files of points that are broken are refused, with where and what was found."""

import struct

import numpy as np
import pytest
from point_clouds import (
    COUNT,
    PLACES,
    colour_columns,
    ply_columns,
    turned,
    write_las,
    write_ply,
)

import omma
from omma.job.points_info import describe_points
from omma.scene import PointCloud, load_points


def rows(count=100):
    return [f"{0.1 * k:.2f} {k % 7} {0.5 * (k % 3)} 100 150 200" for k in range(count)]


@pytest.mark.parametrize("name", ["a.xyz", "a.pts", "a.csv"])
def test_lines_of_text_that_differ_in_length(tmp_path, name):
    lines = rows()
    lines[40], lines[90] = lines[40][:-4], lines[90] + " 200"
    head = {"a.xyz": [], "a.pts": ["100"], "a.csv": ["x,y,z,red,green,blue"]}[name]
    text = "\n".join(head + lines)
    (tmp_path / name).write_text(text.replace(" ", ",") if name == "a.csv" else text)
    with pytest.raises(omma.Error, match=rf"line {41 + len(head)}: expected 6 numbers, found '4"):
        load_points(tmp_path / name)


def test_a_blank_field_is_told_as_it_stands(tmp_path):
    lines = ["x,y,z,red,green,blue", *(line.replace(" ", ",") for line in rows(5))]
    lines[3], lines[5] = "0,4,,200,50,50", lines[5] + ",9"
    (tmp_path / "a.csv").write_text("\r\n".join(lines))
    with pytest.raises(omma.Error, match=r"a\.csv, line 4: .* found '0,4,,200,50,50'"):
        load_points(tmp_path / "a.csv")


def test_lines_are_counted_over_pieces_and_blank_ones(tmp_path, monkeypatch):
    monkeypatch.setattr("omma.base.number_lines._TEXT_BYTES", 100)
    lines = ["# made by hand", "", *rows()]
    lines.insert(30, "")
    (tmp_path / "a.xyz").write_text("\n".join(lines))
    assert len(load_points(tmp_path / "a.xyz")) == 100
    lines[77] = "a b c"
    (tmp_path / "a.xyz").write_text("\n".join(lines))
    with pytest.raises(omma.Error, match=r"line 78: expected 6 numbers, found 'a b c'"):
        load_points(tmp_path / "a.xyz")


def test_rows_of_text_ply_that_differ_in_length(tmp_path):
    path = write_ply(tmp_path / "a.ply", ply_columns(), "ascii")
    lines = path.read_text().splitlines()
    lines[20], lines[30] = lines[20].rpartition(" ")[0], lines[30] + " 1"
    path.write_text("\n".join(lines))
    with pytest.raises(omma.Error, match=r"a\.ply, line 21: expected 3 numbers"):
        load_points(path)


MESH = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
3 0 1 2
3 0 2 3
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "1 0 0\n1 1 0\n",
            "1 0\n1 1 0 0\n",
            "line 11: expected 3 numbers of vertex 1, found '1 0'",
        ),
        ("3 0 1 2\n3 0 2 3", "3 0 1\n2 3 0 2 3", "line 14: expected 4 numbers of face 0"),
        ("1 1 0\n", "1 one 0\n", "line 12: expected numbers, found '1 one 0'"),
        ("3 0 2 3\n", "3 0 2 3\n3 0 2 3\n", "found 4 numbers more"),
    ],
)
def test_rows_of_a_text_mesh_that_differ_in_length(tmp_path, old, new, words):
    (tmp_path / "a.ply").write_text(MESH.replace(old, new))
    with pytest.raises(omma.Error, match=words):
        omma.load_scene(tmp_path / "a.ply")


def test_rows_of_a_text_mesh_may_be_broken_into_lines(tmp_path):
    (tmp_path / "a.ply").write_text(MESH.replace("1 1 0\n", "1\n1 0\n"))
    assert omma.load_scene(tmp_path / "a.ply").triangle_count == 2


@pytest.mark.parametrize("said", [20, 59, 100])
def test_a_count_at_the_head_is_kept_to(tmp_path, said):
    (tmp_path / "a.pts").write_text("\n".join([str(said), *rows(59)]))
    if said == 59:
        assert len(load_points(tmp_path / "a.pts")) == 59
        return
    with pytest.raises(omma.Error, match=rf"expected {said} points, .* found 59"):
        load_points(tmp_path / "a.pts")


@pytest.mark.parametrize("piece", [100, 1 << 20])
def test_blocks_of_a_pts_file_are_read(tmp_path, monkeypatch, piece):
    monkeypatch.setattr("omma.base.number_lines._TEXT_BYTES", piece)
    lines = rows(50)
    (tmp_path / "a.pts").write_text("\n".join(["20", *lines[:20], "30", *lines[20:]]))
    (tmp_path / "b.pts").write_text("\n".join(["50", *lines]))
    one, other = (load_points(tmp_path / name) for name in ("a.pts", "b.pts"))
    assert np.array_equal(one.positions_m, other.positions_m)
    (tmp_path / "a.pts").write_text("\n".join(["20", *lines[:20], "30", *lines[20:-1]]))
    with pytest.raises(omma.Error, match=r"expected 50 points, .* found 49"):
        load_points(tmp_path / "a.pts")


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
def test_more_than_a_ply_header_says(tmp_path, kind):
    path = write_ply(tmp_path / "a.ply", ply_columns(), kind)
    whole = path.read_bytes()
    path.write_bytes(whole + b"\n\n")
    assert len(load_points(path)) == COUNT
    path.write_bytes(whole + b"1 2 3 4 5 6 ")
    words = "expected 3 numbers" if kind == "ascii" else "found 12 bytes more"
    with pytest.raises(omma.Error, match=words):
        load_points(path)
    if kind == "ascii":
        path.write_bytes(whole + b"1 2 3\n")
        with pytest.raises(omma.Error, match=r"expected 500 points, .* found 501"):
            load_points(path)


def test_more_than_the_header_of_splats_says(tmp_path):
    rng = np.random.default_rng(1)
    cloud = omma.scene.SplatCloud(
        rng.random((9, 3)), np.full((9, 3), 0.1), np.tile((0, 0, 0, 1), (9, 1)),
        np.full(9, 0.5), np.zeros((9, 1, 3)),
    )  # fmt: skip
    path = tmp_path / "a.ply"
    omma.scene.save_splats(path, cloud)
    path.write_bytes(path.read_bytes() + b"8 bytes.")
    with pytest.raises(omma.Error, match="found 8 bytes more"):
        omma.load_scene(path)


def test_a_las_file_that_is_cut_within_a_record(tmp_path):
    path = write_las(tmp_path / "a.las")
    path.write_bytes(path.read_bytes()[:-45])  # of records of 20 bytes
    with pytest.raises(
        omma.Error, match="expected 500 points, found the end of the file after 497"
    ):
        load_points(path)


def test_points_that_a_las_header_does_not_count(tmp_path):
    path = write_las(tmp_path / "a.las")
    made = bytearray(path.read_bytes())
    made[107:111] = (100).to_bytes(4, "little")
    path.write_bytes(made)
    with pytest.warns(UserWarning, match="400 points are left out: behind those that its header"):
        assert len(load_points(path)) == 100


@pytest.mark.parametrize("version", ["1.3", "1.4"])
def test_what_may_follow_the_points_of_a_las_file(tmp_path, version, recwarn):
    laspy = pytest.importorskip("laspy")
    las = laspy.LasData(laspy.LasHeader(point_format=1, version=version))
    las.x, las.y, las.z = PLACES.T.astype(float)
    if version == "1.4":
        las.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.VLR("me", 7, "", bytes(28 * 5 - 60))])
    las.write(tmp_path / "a.las")
    if version == "1.3":  # waveforms behind the points, as bytes 227 to 234 say
        made = bytearray((tmp_path / "a.las").read_bytes())
        made[227:235] = len(made).to_bytes(8, "little")
        (tmp_path / "a.las").write_bytes(made + bytes(280))
    assert len(load_points(tmp_path / "a.las")) == COUNT
    assert not recwarn.list


def test_e57_files_that_are_cut_off_or_damaged(tmp_path):
    pye57 = pytest.importorskip("pye57")
    path = tmp_path / "a.e57"
    data = {f"cartesian{axis}": PLACES[:, k].astype(float) for k, axis in enumerate("XYZ")}
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw(data)
    whole = path.read_bytes()
    size = len(whole)
    path.write_bytes(whole[:-1000])
    words = rf"expected {size:,} bytes as its header says, found {size - 1000:,}$"
    with pytest.raises(omma.Error, match=words):
        load_points(path)
    damaged = bytearray(whole)
    damaged[-500] ^= 1
    path.write_bytes(damaged)
    with pytest.raises(omma.Error, match=r"a\.e57: cannot be read as points: ") as told:
        load_points(path)
    assert "****" not in str(told.value)  # where libE57 goes on, for those who write it
    write_las(tmp_path / "b.las").rename(tmp_path / "b.e57")
    with pytest.raises(omma.Error, match="begins with ASTM-E57, found bytes that are no plain"):
        load_points(tmp_path / "b.e57")


@pytest.mark.parametrize(
    ("pair", "seen", "words", "said"),
    [
        ((-1500, 1500), (0, 1), "-1500 as black, 1500 and above as white", "from -1500 to 1500"),
        ((-1800, -100), (0, 1), "-1800 as black, -100 and above as white", "from -1800 to -100"),
        ((50, 100), (0.5, 1), "seen, 100 and above as white", "up to 100"),
        ((-7, -7), None, "all its intensities are -7: its points are grey, 0.5", "from -7 to -7"),
        ((0, 0), None, "all its intensities are 0: its points are grey, 0.5", "up to 0"),
    ],
)
def test_intensities_below_zero(tmp_path, pair, seen, words, said):
    some = [(0.1 * (k % 20), 0.1 * (k // 20), 0, pair[k % 2]) for k in range(400)]
    path = tmp_path / "a.pts"
    path.write_text("\n".join(["400", *(" ".join(map(str, one)) for one in some)]))
    with pytest.warns(UserWarning, match=words):
        scene = omma.load_scene(path)
    assert ("intensity", said) in describe_points(str(path))
    colors = scene.meshes[0].colors
    if seen is None:
        assert colors is None
        return
    assert np.unique(colors[:, :3]) == pytest.approx(seen)


def test_pieces_of_which_nothing_is_left(tmp_path, monkeypatch):
    """The first, the last, and others between those that are good."""
    monkeypatch.setattr("omma.scene.point_files.PIECE", 100)
    held = np.arange(COUNT) < 150
    held[300:400] = True
    path = write_las(tmp_path / "a.las", withheld=held)
    with pytest.warns(UserWarning, match="250 points are left out: withheld"):
        cloud = load_points(path)
    assert cloud.positions_m == pytest.approx(turned(PLACES[~held]), abs=6e-5)
    assert dict(describe_points(str(path)))["number"] == "250"
    for columns in (
        ply_columns(),
        ply_columns(**colour_columns(), intensity=("float", PLACES[:, 0])),
    ):
        path = write_ply(tmp_path / "a.ply", columns)
        for every in (251, 499, 1000):  # nothing of most pieces
            cloud = load_points(path, every=every)
            assert cloud.positions_m + cloud.offset_m == pytest.approx(PLACES[::every], abs=1e-6)


@pytest.mark.parametrize("ending", [".las", ".laz"])
def test_las_files_of_which_nothing_is_left(tmp_path, monkeypatch, ending):
    monkeypatch.setattr("omma.scene.point_files.PIECE", 100)
    for words, given in (
        ("500 withheld", {"withheld": np.ones(COUNT, bool)}),
        ("500 class noise", {"classes": np.full(COUNT, 7)}),
    ):
        path = write_las(tmp_path / f"a{ending}", colours=np.ones((COUNT, 3)), **given)
        for read in (load_points, omma.load_scene, lambda one: describe_points(str(one))):
            with pytest.raises(omma.Error, match=f"found none of 500 that can be used: {words}"):
                read(path)


@pytest.mark.parametrize("ending", [".las", ".laz"])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(
    ("at", "number", "words"),
    [
        (131, 0.0, "scale of {} of 1e-18 to 1e.18, found 0"),
        (131, 1e-300, "scale of {} of .*, found 1e-300"),
        (131, np.nan, "scale of {} of .*, found nan"),
        (131, np.inf, "scale of {} of .*, found inf"),
        (155, np.nan, "offset of {} up to 1e.18, found nan"),
        (155, -1e300, "offset of {} up to 1e.18, found -1e.300"),
    ],
)
def test_scales_and_offsets_that_leave_nothing_of_places(tmp_path, ending, axis, at, number, words):
    path = write_las(tmp_path / f"a{ending}")
    made = bytearray(path.read_bytes())
    struct.pack_into("<d", made, at + 8 * axis, number)
    path.write_bytes(made)
    for read in (load_points, omma.load_scene, lambda one: describe_points(str(one))):
        with pytest.raises(omma.Error, match=r"a\.la.: expected an? " + words.format("xyz"[axis])):
            read(path)


def test_places_beyond_any_world_that_lie_together(tmp_path):
    far = PLACES.astype(float) * 1e290 + 1e300
    columns = {axis: ("double", far[:, k]) for k, axis in enumerate("xyz")}
    path = write_ply(tmp_path / "a.ply", columns)
    for read in (load_points, omma.load_scene):
        with pytest.raises(omma.Error, match=r"a\.ply: expected points within 1e.18 m"):
            read(path)
    with pytest.raises(omma.Error, match=r"offset_m: expected points within 1e.18 m"):
        PointCloud(PLACES, (0, 1e300, 0))
    with pytest.raises(omma.Error, match=r"expected points within 1e.18 m"):
        PointCloud(far)
