"""Files of points: what they hold is read, thinned in pieces, and what is wrong is said."""

import pickle
import warnings

import numpy as np
import pytest

import omma
from omma.scene import PointCloud, load_points
from omma.scene import point_files as files_of_points

RNG = np.random.default_rng(4)
COUNT = 500
# As a scanner has them: z up.
PLACES = RNG.uniform(-1, 1, (COUNT, 3)).astype(np.float32)
COLOURS = RNG.integers(0, 256, (COUNT, 3))
CLASSES = RNG.integers(1, 4, COUNT)


def srgb_to_linear(value):
    """IEC 61966-2-1."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def write_ply(path, columns, kind="binary_little_endian", count=None, cut=0):
    """Columns by name: (type of PLY, values)."""
    types = {"float": "f4", "double": "f8", "uchar": "u1", "ushort": "u2", "int": "i4"}
    rows = len(next(iter(columns.values()))[1])
    lines = [f"property {type_} {name}" for name, (type_, _) in columns.items()]
    header = ["ply", f"format {kind} 1.0", f"element vertex {count or rows}", *lines, "end_header"]
    head = ("\n".join(header) + "\n").encode()
    if kind == "ascii":
        text = [" ".join(str(values[i]) for _, values in columns.values()) for i in range(rows)]
        body = ("\n".join(text) + "\n").encode()
    else:
        order = "<" if "little" in kind else ">"
        table = np.empty(
            rows, [(name, order + types[type_]) for name, (type_, _) in columns.items()]
        )
        for name, (_, values) in columns.items():
            table[name] = values
        body = table.tobytes()
    path.write_bytes(head + body[: len(body) - cut])
    return path


def ply_columns(places=PLACES, **more):
    return {**{axis: ("float", places[:, k]) for k, axis in enumerate("xyz")}, **more}


def colour_columns(type_="uchar", values=COLOURS):
    return {name: (type_, values[:, k]) for k, name in enumerate(("red", "green", "blue"))}


def write_las(path, places=PLACES, colours=None, classes=CLASSES, **dimensions):
    laspy = pytest.importorskip("laspy")
    if path.suffix == ".laz":
        pytest.importorskip("lazrs")
    header = laspy.LasHeader(point_format=3 if colours is not None else 0, version="1.2")
    header.scales, header.offsets = [1e-4] * 3, np.round(np.mean(places, axis=0))
    las = laspy.LasData(header)
    las.x, las.y, las.z = np.asarray(places, float).T
    las.classification = classes
    las.intensity = np.arange(len(places)) % 60_000
    if colours is not None:
        las.red, las.green, las.blue = np.asarray(colours).T
    for name, values in dimensions.items():
        las[name] = values
    las.write(path)
    return path


def turned(places):
    """z up as y up."""
    return np.stack([places[:, 0], places[:, 2], -places[:, 1]], axis=1)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_of_every_kind(tmp_path, kind, monkeypatch):
    """Also where the pieces are small."""
    more = {"nx": ("float", PLACES[:, 1]), "ny": ("float", PLACES[:, 2])}
    more.update(nz=("float", PLACES[:, 0]), scalar_Classification=("int", CLASSES))
    path = write_ply(tmp_path / "a.ply", ply_columns(**colour_columns(), **more), kind)
    monkeypatch.setattr(files_of_points, "PIECE", 77)
    monkeypatch.setattr(files_of_points, "_TEXT_BYTES", 1000)
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


def test_e57_has_scanners_and_poses(tmp_path):
    pye57 = pytest.importorskip("pye57")
    data = {f"cartesian{axis}": PLACES[:, k].astype(float) for k, axis in enumerate("XYZ")}
    for k, name in enumerate(("Red", "Green", "Blue")):
        data[f"color{name}"] = COLOURS[:, k].astype(np.uint8)
    data["cartesianInvalidState"] = (np.arange(COUNT) % 10 == 0).astype(np.int8)
    path = tmp_path / "a.e57"
    quarter = np.array([np.cos(np.pi / 4), 0, 0, np.sin(np.pi / 4)])  # about +Z
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw(data, rotation=quarter, translation=np.array([10.0, 20.0, 30.0]))
    with pytest.warns(UserWarning, match="50 points are left out: invalid"):
        cloud = load_points(path)
    kept = np.arange(COUNT) % 10 != 0
    expected = np.stack([-PLACES[:, 1], PLACES[:, 0], PLACES[:, 2]], axis=1) + (10, 20, 30)
    found = cloud.positions_m + cloud.offset_m
    assert found == pytest.approx(turned(expected[kept]), abs=1e-5)
    assert cloud.colors == pytest.approx(srgb_to_linear(COLOURS[kept] / 255), abs=1e-6)
    assert cloud.scanners_m + cloud.offset_m == pytest.approx(np.array([[10, 30, -20]]))


SURFACE_NORMALS = "http://www.libe57.org/E57_EXT_surface_normals.txt"


def write_e57(path, scans, prefix="nor", steps=0):
    """Scans of doubles by name, each with its rotation (w, x, y, z) and translation; what has a
    prefix is of an extension, and with ``steps`` a whole number of so many to 1."""
    pye57 = pytest.importorskip("pye57")
    e57 = pye57.libe57
    with pye57.E57(str(path), mode="w") as file:
        image = file.image_file

        def structure(values):
            made = e57.StructureNode(image)
            for name, value in values.items():
                made.set(name, value)
            return made

        def numbers(names, values):
            return structure(
                {name: e57.FloatNode(image, float(value)) for name, value in zip(names, values)}
            )

        def like(name):
            if steps and ":" in name:
                return e57.ScaledIntegerNode(image, 0, -steps, steps, 1 / steps, 0.0)
            return e57.FloatNode(image, 0.0, e57.E57_DOUBLE)

        image.extensionsAdd(prefix, SURFACE_NORMALS)
        for columns, rotation, translation in scans:
            pose = structure(
                {"rotation": numbers("wxyz", rotation), "translation": numbers("xyz", translation)}
            )
            rows = structure({name: like(name) for name in columns})
            points = e57.CompressedVectorNode(image, rows, e57.VectorNode(image, True))
            file.data3d.append(structure({"pose": pose, "points": points}))
            kept = {name: np.array(values, float) for name, values in columns.items()}
            buffers = e57.VectorSourceDestBuffer()
            for name, values in kept.items():
                buffers.append(e57.SourceDestBuffer(image, name, values, len(values), True, True))
            writer = points.writer(buffers)
            writer.write(len(values))
            writer.close()
    return path


def e57_columns(places, normals, before="nor:normal"):
    found = {f"cartesian{axis}": places[:, k] for k, axis in enumerate("XYZ")}
    names = "XYZ" if before.endswith("normal") else "xyz"
    return {**found, **{f"{before}{axis}": normals[:, k] for k, axis in enumerate(names)}}


QUARTER = (np.sqrt(0.5), 0, 0, np.sqrt(0.5))  # a turn about +Z
NORMALS = RNG.normal(size=(COUNT, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("prefix", "before", "steps"),
    [("nor", "nor:normal", 0), ("nor", "nor:normal", 32767), ("n", "n:normal", 0),
     ("nor", "nor:n", 0)],
)  # fmt: skip
def test_e57_has_normals(tmp_path, prefix, before, steps):
    turns = [(QUARTER, (10.0, 20.0, 30.0)), ((1, 0, 0, 0), (0, 0, 0))]
    scans = [(e57_columns(PLACES, NORMALS, before), *one) for one in turns]
    cloud = load_points(write_e57(tmp_path / "a.e57", scans, prefix, steps))
    about_z = np.stack([-NORMALS[:, 1], NORMALS[:, 0], NORMALS[:, 2]], axis=1)
    # Half a step of the whole numbers, or single precision; a turn mixes two of them.
    off = 0.75 / steps if steps else 1e-6
    assert cloud.normals == pytest.approx(turned(np.concatenate([about_z, NORMALS])), abs=off)


def test_e57_whose_scans_have_not_all_normals(tmp_path):
    plain = {f"cartesian{axis}": PLACES[:, k] for k, axis in enumerate("XYZ")}
    pose = ((1, 0, 0, 0), (0, 0, 0))
    two = [(e57_columns(PLACES, NORMALS), *pose), (plain, *pose)]
    assert load_points(write_e57(tmp_path / "a.e57", two)).normals is None
    half = {
        name: values for name, values in e57_columns(PLACES, NORMALS).items() if "Y" not in name
    }
    half["cartesianY"] = PLACES[:, 1]
    assert load_points(write_e57(tmp_path / "b.e57", [(half, *pose)])).normals is None


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
        with pytest.raises(omma.Error, match=r"a\.ply: expected (500|3) "):
            load_points(path)
    for ending in (".las", ".laz"):
        whole = write_las(tmp_path / f"a{ending}").read_bytes()
        (tmp_path / f"b{ending}").write_bytes(whole[:-cut])
        with pytest.raises(omma.Error, match=rf"b\{ending}: "):
            load_points(tmp_path / f"b{ending}")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.xyz", "", "expected columns x, y and z"),
        ("a.xyz", "1 2\n3 4\n", "expected columns x, y and z"),
        ("a.xyz", "1 2 3\n4 five 6\n", "expected 3 numbers in each of the lines from point 0"),
        ("a.xyz", "1 2 3\n4 5\n", "expected 3 numbers"),
        ("a.xyz", "nan nan nan\n", "expected points, found none of 1 that can be used"),
        ("a.las", "LASF", "expected a file that begins with LASF and a header"),
        ("a.e57", "none", "cannot be read as points"),
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
