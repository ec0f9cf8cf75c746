"""Files of points: what they hold is read, thinned in pieces, and what is wrong is said."""

import pickle
import warnings

import numpy as np
import pytest
from point_clouds import (
    CLASSES,
    COLOURS,
    COUNT,
    PLACES,
    RNG,
    colour_columns,
    ply_columns,
    srgb_to_linear,
    turned,
    write_las,
    write_ply,
)

import omma
from omma.scene import PointCloud, load_points
from omma.scene import point_files as files_of_points


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_of_every_kind(tmp_path, kind, monkeypatch):
    """Also where the pieces are small."""
    more = {"nx": ("float", PLACES[:, 1]), "ny": ("float", PLACES[:, 2])}
    more.update(nz=("float", PLACES[:, 0]), scalar_Classification=("int", CLASSES))
    path = write_ply(tmp_path / "a.ply", ply_columns(**colour_columns(), **more), kind)
    monkeypatch.setattr(files_of_points, "PIECE", 77)
    monkeypatch.setattr("omma.base.number_lines._TEXT_BYTES", 1000)
    cloud = load_points(path)
    assert cloud.positions_m == pytest.approx(PLACES, abs=1e-6)
    assert cloud.colors == pytest.approx(srgb_to_linear(COLOURS / 255), abs=1e-6)
    assert cloud.normals == pytest.approx(np.roll(PLACES, -1, axis=1), abs=1e-6)
    assert (cloud.labels == CLASSES).all()
    assert cloud.intensity is None
    assert load_points(path, unit="mm", up="z").positions_m == pytest.approx(
        turned(PLACES) * 1e-3, abs=1e-9
    )
    assert load_points(path, up="z").normals == pytest.approx(
        turned(np.roll(PLACES, -1, axis=1)), abs=1e-6
    )


@pytest.mark.parametrize("ending", [".las", ".laz"])
@pytest.mark.parametrize("bits", [8, 16])
def test_las_with_colours_of_8_or_16_bits(tmp_path, ending, bits):
    """Many programs write 8 bits into LAS files, whose colours have 16."""
    full = 2**bits - 1
    colours = RNG.integers(0, full + 1, (COUNT, 3))
    path = write_las(tmp_path / f"a{ending}", colours=colours)
    cloud = load_points(path)
    assert cloud.positions_m == pytest.approx(turned(PLACES), abs=6e-5)  # half its steps of 0.1 mm
    assert cloud.colors == pytest.approx(srgb_to_linear(colours / full), abs=1e-6)
    assert (cloud.labels == CLASSES).all()
    assert (cloud.intensity == np.arange(COUNT)).all()


def test_bits_are_told_by_all_colours_not_by_the_first(tmp_path, monkeypatch):
    monkeypatch.setattr(files_of_points, "PIECE", 50)
    colours = np.full((COUNT, 3), 200)
    colours[-1] = 65535
    cloud = load_points(write_las(tmp_path / "a.las", colours=colours))
    assert cloud.colors[0] == pytest.approx(srgb_to_linear(np.full(3, 200 / 65535)), rel=1e-4)
    assert cloud.colors[-1] == pytest.approx(np.ones(3))
    assert len(cloud) == COUNT


def test_a_grid_keeps_the_mean_of_each_cell(tmp_path, monkeypatch):
    """Against sums by hand, whatever the pieces."""
    columns = ply_columns(**colour_columns(), label=("uchar", CLASSES))
    path = write_ply(tmp_path / "a.ply", columns)
    whole = load_points(path, voxel_m=0.5)
    monkeypatch.setattr(files_of_points, "PIECE", 64)
    pieces = load_points(path, voxel_m=0.5)
    assert pieces.positions_m == pytest.approx(whole.positions_m, abs=1e-6)
    cell = np.floor(PLACES.astype(float) / 0.5).astype(int)
    linear = srgb_to_linear(COLOURS / 255)
    cells = np.unique(cell, axis=0)
    assert len(cells) == len(whole) == 64
    for k, one in enumerate(cells):
        here = (cell == one).all(axis=1)
        assert whole.positions_m[k] == pytest.approx(PLACES[here].mean(axis=0), abs=1e-6)
        assert whole.colors[k] == pytest.approx(linear[here].mean(axis=0), abs=1e-6)
        numbers, counts = np.unique(CLASSES[here], return_counts=True)
        assert whole.labels[k] == numbers[counts.argmax()]


def test_every_and_bounds(tmp_path, monkeypatch):
    path = write_ply(tmp_path / "a.ply", ply_columns())
    monkeypatch.setattr(files_of_points, "PIECE", 64)
    assert (load_points(path, every=7).positions_m == PLACES[::7]).all()
    box = [(-0.5, -1, -0.25), (0.5, 0, 2)]
    inside = ((PLACES >= box[0]) & (PLACES <= box[1])).all(axis=1)
    assert (load_points(path, bounds=box).positions_m == PLACES[inside]).all()


def test_surveys_keep_their_millimetres(tmp_path):
    far = PLACES.astype(float).round(4) + (431234, 5412345, 250)
    cloud = load_points(write_las(tmp_path / "a.las", far))
    assert cloud.positions_m + cloud.offset_m == pytest.approx(turned(far), abs=2e-5)
    small = far * 1e-6  # of which whole metres would not do as an offset
    columns = {axis: ("double", small[:, k]) for k, axis in enumerate("xyz")}
    cloud = load_points(write_ply(tmp_path / "a.ply", columns))
    assert cloud.positions_m + cloud.offset_m == pytest.approx(small, abs=1e-12)
    assert PointCloud(far).positions_m + PointCloud(far).offset_m == pytest.approx(far, abs=2e-6)


def test_what_is_left_out_is_counted(tmp_path):
    bad = PLACES.copy()
    bad[3, 0], bad[7, 2] = np.nan, np.inf
    with pytest.warns(UserWarning, match="2 points are left out: not finite"):
        assert len(load_points(write_ply(tmp_path / "a.ply", ply_columns(bad)))) == COUNT - 2
    held = np.arange(COUNT) < 5
    classes = np.where(np.arange(COUNT) >= COUNT - 3, 7, 2)
    with pytest.warns(UserWarning, match="left out") as told:
        cloud = load_points(write_las(tmp_path / "a.las", classes=classes, withheld=held))
    assert len(cloud) == COUNT - 8
    said = " ".join(str(one.message) for one in told)
    assert "3 points are left out: class noise" in said
    assert "5 points are left out: withheld" in said


def test_black_colours_are_none(tmp_path):
    """Formats of LAS with colours that nobody measured would be a black world."""
    path = write_las(tmp_path / "a.las", colours=np.zeros((COUNT, 3)))
    with pytest.warns(UserWarning, match="all its colours are black"):
        assert load_points(path).colors is None


def test_feet_are_told(tmp_path):
    laspy = pytest.importorskip("laspy")
    path = write_las(tmp_path / "a.las")
    las = laspy.read(path)
    wkt = 'PROJCS["x",GEOGCS["y"],UNIT["US survey foot",0.3048006096]]'
    las.header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(wkt))
    las.write(path)
    with pytest.warns(UserWarning, match=r"in US survey feet, .*unit=0\.3048006096"):
        load_points(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        feet = load_points(path, unit=0.3048006096)
    assert feet.positions_m == pytest.approx(turned(PLACES) * 0.3048, abs=3e-5)


@pytest.mark.parametrize("cut", [1, 100, 5000])
def test_files_that_are_cut_off(tmp_path, cut):
    for kind in ("binary_big_endian", "ascii"):
        path = write_ply(tmp_path / "a.ply", ply_columns(), kind, cut=cut)
        if kind == "ascii" and cut == 1:
            assert len(load_points(path)) == COUNT  # the last line's end
            continue
        with pytest.raises(omma.Error, match=r"a\.ply(, line \d+)?: expected (500|3) "):
            load_points(path)
    for ending in (".las", ".laz"):
        whole = write_las(tmp_path / f"a{ending}").read_bytes()
        (tmp_path / f"b{ending}").write_bytes(whole[:-cut])
        with pytest.raises(omma.Error, match=rf"b\{ending}: "):
            load_points(tmp_path / f"b{ending}")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.xyz", "", "expected lines of numbers, found an empty file"),
        ("a.xyz", "PK\3\4", "expected lines of numbers, found bytes that are no plain text"),
        ("a.xyz", "# none\n", "found no line of several columns"),
        ("a.xyz", "1 2\n3 4\n", "expected columns .* found line 1 of 2 columns, '1 2'"),
        ("a.xyz", "1 2 3\n4 five 6\n", "line 2: expected 3 numbers, found '4 five 6'"),
        ("a.xyz", "1 2 3\n4 5\n", "line 2: expected 3 numbers, found '4 5'"),
        ("a.las", "", "expected a file that begins with LASF, found an empty file"),
        ("a.xyz", "nan nan nan\n", "expected points, found none of 1 that can be used"),
        ("a.las", "LASF", "expected a header of 227 bytes, found 4"),
        ("a.e57", "none", "begins with ASTM-E57, found a file that begins with 'none'"),
        ("a.e57", "", "begins with ASTM-E57, found an empty file"),
        ("a.ply", "", "expected 'ply' in the first line, found an empty file"),
        ("a.ply", "ply\nformat ascii 1.0\nelement face 0\nend_header\n", "expected vertices"),
        ("a.dat", "", "expected a name ending in"),
    ],
)
def test_what_is_no_file_of_points(tmp_path, name, text, words):
    for ending, package in ((".las", "laspy"), (".e57", "pye57")):
        if name.endswith(ending):
            pytest.importorskip(package)
    (tmp_path / name).write_text(text)
    with pytest.raises(omma.Error, match=words) as told:
        load_points(tmp_path / name)
    assert name in str(told.value)


def test_a_las_file_that_claims_too_many_records_is_not_waited_for(tmp_path):
    made = bytearray(write_las(tmp_path / "a.las").read_bytes())
    made[100:104] = b"\xff\xff\xff\xff"
    (tmp_path / "a.las").write_bytes(made)
    with pytest.raises(omma.Error, match="expected as many records as its header says"):
        load_points(tmp_path / "a.las")


def test_a_laz_file_that_claims_too_many_chunks_takes_no_memory(tmp_path):
    made = bytearray(write_las(tmp_path / "a.laz").read_bytes())
    begin = int.from_bytes(made[96:100], "little")
    table = int.from_bytes(made[begin : begin + 8], "little")
    made[table + 4 : table + 8] = b"\xff\xff\xff\xff"
    (tmp_path / "a.laz").write_bytes(made)
    with pytest.raises(omma.Error, match="expected a table of its chunks"):
        load_points(tmp_path / "a.laz")


def test_more_than_fits_is_refused_before_it_is_read(tmp_path, monkeypatch):
    path = write_ply(tmp_path / "a.ply", ply_columns())
    monkeypatch.setattr("omma.scene.points.free_bytes", lambda: 3 * 5.5 * 100)
    with pytest.raises(omma.Error, match=r"100 would fit; thin them by voxel_m, or .* by every=5"):
        load_points(path)
    assert len(load_points(path, every=5)) == 100


def test_wrong_arguments(tmp_path):
    path = write_ply(tmp_path / "a.ply", ply_columns())
    for wrong, words in (
        ({"voxel_m": 0}, "voxel_m: expected a number above 0"),
        ({"voxel_m": 1e-8}, "voxel_m: expected cells"),
        ({"every": 0}, "every: expected 1 to"),
        ({"up": "x"}, "up: expected one of y, z"),
        ({"unit": "feet"}, "unit: expected mm"),
        ({"bounds": [(0, 0, 0), (0, 1, 1)]}, "bounds: expected a lower and an upper corner"),
        ({"bounds": [(5, 5, 5), (6, 6, 6)]}, "found none of 500 that can be used"),
    ):
        with pytest.raises(omma.Error, match=words):
            load_points(path, **wrong)
    with pytest.raises(omma.Error, match="colors: expected shape"):
        PointCloud(PLACES, colors=COLOURS[:7])
    with pytest.raises(omma.Error, match="positions_m: expected finite numbers, found 1 row"):
        PointCloud([[0, 0, np.nan], [1, 1, 1]])


def test_clouds_are_values():
    cloud = PointCloud(PLACES, colors=COLOURS / 255, labels=CLASSES)
    assert pickle.loads(pickle.dumps(cloud)) == cloud
    assert PointCloud(PLACES) != cloud
    with pytest.raises(ValueError, match="read-only"):
        cloud.positions_m[0] = 1
    assert cloud.bounds == pytest.approx(np.array([PLACES.min(axis=0), PLACES.max(axis=0)]))
    mine = PLACES.copy()
    kept = PointCloud(mine)
    mine[0] = 0  # the caller's own array stays the caller's
    assert kept == PointCloud(PLACES)


@pytest.mark.parametrize(
    "names", [("f_dc_0", "opacity", "scale_0", "rot_0"), ("packed_position", "packed_rotation")]
)
def test_gaussian_splats_are_no_points(tmp_path, names):
    more = {name: ("float", np.zeros(len(PLACES))) for name in names}
    path = write_ply(tmp_path / "place.ply", ply_columns(**more))
    assert not files_of_points.is_point_file(str(path))
    with pytest.raises(omma.Error, match=r"place\.ply: .* found Gaussian splats, which omma\.load"):
        omma.scene.load_points(path)
