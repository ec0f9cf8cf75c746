"""Files of Gaussian splats: what they hold is read and written, and what is wrong is said."""

import gzip
import struct
import tracemalloc

import numpy as np
import pytest
import slow_splats
import splat_bytes
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import omma
from omma.job.info import describe_file, is_scene_file
from omma.scene import SplatCloud, cull_splats, load_splats, save_splats, splat_harmonics
from omma.scene.point_files import is_point_file
from omma.scene.splat_files import is_splat_file, read_splats

TERMS = (1, 4, 9, 16)
RDF_TO_RUB = np.diag([1.0, -1.0, -1.0, 1.0])
ARRAYS = ("positions_m", "scales_m", "rotations", "opacities", "harmonics")


def expected(columns):
    """What 3DGS makes of its columns (scene/gaussian_model.py)."""
    terms = 1 + sum(name.startswith("f_rest") for name in columns) // 3
    count = len(columns["x"])
    double = {name: values.astype(float) for name, values in columns.items()}
    rest = [double[f"f_rest_{k}"] for k in range(3 * terms - 3)]
    harmonics = np.empty((count, terms, 3))
    for channel in range(3):
        harmonics[:, 0, channel] = double[f"f_dc_{channel}"]
        for k in range(terms - 1):
            harmonics[:, 1 + k, channel] = rest[channel * (terms - 1) + k]
    quaternions = np.stack([double[f"rot_{k}"] for k in (1, 2, 3, 0)], axis=1)
    return {
        "positions_m": np.stack([double[axis] for axis in "xyz"], axis=1),
        "scales_m": np.exp(np.stack([double[f"scale_{k}"] for k in range(3)], axis=1)),
        "rotations": quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True),
        "opacities": 1 / (1 + np.exp(-double["opacity"])),
        "harmonics": harmonics,
    }


def check(found, wanted, in_logs=False, **tolerances):
    for name in ARRAYS:
        values = getattr(found, name)
        assert values.dtype == np.float32
        want = wanted[name]
        if name == "scales_m" and in_logs:
            values, want = np.log(values), np.log(want)
        if name == "rotations":  # q and -q turn alike
            want = want * np.sign((values * want).sum(axis=1, keepdims=True))
        # Single precision, where a test does not say more.
        np.testing.assert_allclose(
            values, want, rtol=1e-5, atol=tolerances.get(name, 1e-6), err_msg=name
        )


def saved(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data)
    return path


def ply_of(tmp_path, columns, name="place.ply", **more):
    data = splat_bytes.ply({"vertex": splat_bytes.floats(columns)}, **more)
    return saved(tmp_path, name, data)


@pytest.mark.parametrize("terms", TERMS)
@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_of_every_kind(tmp_path, kind, terms, monkeypatch):
    monkeypatch.setattr("omma.scene.splat_ply.PIECE", 64)
    columns = splat_bytes.raw_splats(200, terms)
    path = ply_of(tmp_path, columns, kind=kind)
    shares = []
    splats = load_splats(path, progress=shares.append)
    check(splats, expected(columns))
    assert (splats.color_space, splats.direction, splats.name) == ("srgb", "center", "place")
    assert splats.world_from_splats == pytest.approx(RDF_TO_RUB)
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert is_splat_file(path)
    assert not is_point_file(str(path))


def test_columns_in_any_order_and_of_double_precision(tmp_path):
    columns = splat_bytes.raw_splats(50, 4)
    mixed = {
        name: ("double" if k % 3 else "float", values)
        for k, (name, values) in enumerate(reversed(columns.items()))
    }
    mixed["segment"] = ("uchar", np.arange(50) % 7)
    faces = {"a": ("int", np.arange(3))}
    data = splat_bytes.ply({"before": faces, "vertex": mixed, "after": faces})
    check(load_splats(saved(tmp_path, "a.ply", data)), expected(columns))


def test_units_and_axes(tmp_path):
    path = ply_of(tmp_path, splat_bytes.raw_splats(5, 1))
    down, up, z = (load_splats(path, up=one).world_from_splats for one in ("-y", "y", "z"))
    assert down @ [0, -1, 0, 0] == pytest.approx([0, 1, 0, 0])
    assert up == pytest.approx(np.eye(4))
    assert z @ [0, 0, 1, 0] == pytest.approx([0, 1, 0, 0])
    assert load_splats(path, unit="mm", up="y").world_from_splats[0, 0] == pytest.approx(1e-3)
    for wrong in ({"up": "x"}, {"unit": 0.0}):
        with pytest.raises(omma.Error, match=next(iter(wrong))):
            load_splats(path, **wrong)


@pytest.mark.parametrize("has_colours", [True, False])
@pytest.mark.parametrize("terms", TERMS)
def test_packed_ply(tmp_path, terms, has_colours, monkeypatch):
    monkeypatch.setattr("omma.scene.splat_packed_ply.PIECE", 512)
    columns = splat_bytes.raw_splats(700, terms)
    elements = splat_bytes.packed_ply(columns, has_colours)
    path = saved(tmp_path, "a.compressed.ply", splat_bytes.ply(elements))
    shares = []
    splats = load_splats(path, progress=shares.append)
    assert shares[-1] == 1
    wanted = expected(columns)
    # Half a step of 10 bits over what the columns span, of log scales as a factor, of 8 bits.
    check(
        splats,
        wanted,
        in_logs=True,
        positions_m=8 / 1023 / 2,
        scales_m=8 / 1023 / 2,
        rotations=2e-3,
        opacities=1 / 255,
        harmonics=8 / 256 / 2 * 1.001,
    )
    assert is_splat_file(path)
    assert not is_point_file(str(path))


def test_mip_splatting_is_smoothed_as_its_own_program_does(tmp_path):
    columns = splat_bytes.raw_splats(60, 4)
    columns["filter_3D"] = np.random.default_rng(3).uniform(0, 0.1, 60).astype(np.float32)
    splats = load_splats(ply_of(tmp_path, columns))
    plain = expected(columns)
    wide = np.sqrt(plain["scales_m"] ** 2 + columns["filter_3D"].astype(float)[:, None] ** 2)
    dimmed = plain["opacities"] * np.prod(plain["scales_m"], axis=1) / np.prod(wide, axis=1)
    check(splats, {**plain, "scales_m": wide, "opacities": dimmed})


@pytest.mark.parametrize("terms", TERMS)
@pytest.mark.parametrize("version", [2, 3, 4])
def test_spz_as_its_specification_says(tmp_path, version, terms, monkeypatch):
    if version == 4:
        pytest.importorskip("zstandard")
    monkeypatch.setattr("omma.scene.splat_spz.PIECE", 64)
    columns = splat_bytes.raw_splats(200, terms)
    path = saved(tmp_path, "place.spz", splat_bytes.spz(columns, version))
    shares = []
    splats = load_splats(path, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1
    wanted = expected(columns)
    check_spz(splats, wanted, 2**-13, {2: 0.12}.get(version, 2.1e-3))
    assert splats.world_from_splats == pytest.approx(np.eye(4))
    assert is_splat_file(path)
    assert np.linalg.norm(splats.rotations, axis=1) == pytest.approx(1, abs=1e-6)


def check_spz(splats, wanted, step, turn):
    """Half a step of each byte; of rotations what a largest component makes of it."""
    check(
        splats,
        wanted,
        in_logs=True,
        positions_m=step * 1.001,
        scales_m=1 / 32 * 1.001,
        rotations=turn,
        opacities=0.5 / 255 * 1.001,
        harmonics=0.5 / 255 / 0.15 * 1.001,
    )


def test_spz_of_one_splat_byte_by_byte(tmp_path):
    # Written out by hand: (1, -2, 0.5) m with 8 bits of fraction, half a turn about y.
    body = bytes.fromhex("000100 00feff 800000") + bytes([51, 255, 0, 128, 160, 144, 176])
    body += struct.pack("<I", 1 << 30)  # y is the largest, the others are 0
    data = struct.pack("<IIIBBBB", 0x5053474E, 3, 1, 0, 8, 0, 0) + body
    splats = load_splats(saved(tmp_path, "a.spz", gzip.compress(data)))
    assert splats.positions_m.tolist() == [[1, -2, 0.5]]
    assert splats.opacities == pytest.approx([0.2])
    assert splats.harmonics[0, 0] == pytest.approx([0.5 / 0.15, -0.5 / 0.15, 0.5 / 255 / 0.15])
    assert splats.scales_m[0] == pytest.approx(np.exp([0, -1, 1]))
    assert splats.rotations.tolist() == [[0, 1, 0, 0]]


def some_splats(count=300, terms=16, seed=2):
    rng = np.random.default_rng(seed)
    quaternions = rng.normal(size=(count, 4))
    return SplatCloud(
        rng.normal(size=(count, 3)).astype(np.float32),
        np.exp(rng.normal(size=(count, 3)) - 2).astype(np.float32),
        (quaternions / np.linalg.norm(quaternions, axis=1)[:, None]).astype(np.float32),
        rng.uniform(0.01, 0.99, count).astype(np.float32),
        rng.uniform(-0.9, 0.9, (count, terms, 3)).astype(np.float32),
        world_from_splats=RDF_TO_RUB,
    )


def arrays_of(splats):
    return {name: getattr(splats, name).astype(float) for name in ARRAYS}


@pytest.mark.parametrize("terms", TERMS)
def test_written_ply_is_read_back(tmp_path, terms, monkeypatch):
    monkeypatch.setattr("omma.scene.splat_files.PIECE", 128)
    splats = some_splats(terms=terms)
    save_splats(tmp_path / "a.ply", splats)
    found = load_splats(tmp_path / "a.ply")
    check(found, arrays_of(splats), scales_m=0, positions_m=0, harmonics=0)
    assert np.array_equal(found.positions_m, splats.positions_m)
    assert np.array_equal(found.harmonics, splats.harmonics)
    save_splats(tmp_path / "b.ply", found)
    again = load_splats(tmp_path / "b.ply")
    assert np.array_equal(again.positions_m, found.positions_m)
    check(again, arrays_of(found))


@pytest.mark.parametrize("terms", TERMS)
def test_written_spz_is_read_back(tmp_path, terms, monkeypatch):
    monkeypatch.setattr("omma.scene.splat_files.PIECE", 128)
    splats = some_splats(terms=terms).replace(world_from_splats=np.eye(4))
    save_splats(tmp_path / "a.spz", splats)
    found = load_splats(tmp_path / "a.spz")
    check_spz(found, arrays_of(splats), np.abs(splats.positions_m).max() * 2**-22, 2.1e-3)
    save_splats(tmp_path / "b.spz", found)
    for name in ("positions_m", "scales_m", "opacities", "harmonics"):
        assert np.array_equal(getattr(load_splats(tmp_path / "b.spz"), name), getattr(found, name))


def test_opaque_and_invisible_splats_are_written(tmp_path):
    splats = some_splats(2).replace(opacities=np.array([0, 1], np.float32))
    for name in ("a.ply", "a.spz"):
        save_splats(tmp_path / name, splats)
        assert load_splats(tmp_path / name).opacities == pytest.approx([0, 1], abs=1e-15)


@pytest.mark.parametrize("name", ["a.ply", "a.spz"])
def test_splats_look_the_same_in_the_world_from_every_file(tmp_path, name):
    splats = some_splats(60)
    matrix = np.eye(4)
    matrix[:3, :3] = 0.5 * Rotation.from_rotvec([0.3, -1, 0.4]).as_matrix()
    matrix[:3, 3] = [1, -2, 0.5]
    splats = splats.replace(world_from_splats=matrix)
    save_splats(tmp_path / name, splats)
    rng = np.random.default_rng(8)
    origins = matrix[:3, 3] + rng.normal(size=(40, 3)) * 3
    directions = matrix[:3, 3] + rng.normal(size=(40, 3)) * 0.4 - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    far = np.full(40, np.inf)
    wanted = slow_splats.trace(splats, origins, directions, far)
    found = slow_splats.trace(load_splats(tmp_path / name), origins, directions, far)
    assert (wanted[1] < 0.5).sum() > 10
    # Of .spz what the rounding of scales by 3 % makes of them, on the way through several.
    limit = 1e-4 if name == "a.ply" else 0.1
    for one, other in zip(found[:2], wanted[:2]):
        assert np.abs(one - other).max() < limit
        assert np.abs(one - other).mean() < limit / 5


def test_half_turns_change_signs_of_harmonics_as_niantics_table_says():
    x, y, z = RDF_TO_RUB.diagonal()[:3]
    # nianticlabs/spz, src/cc/splat-types.h, coordinateConverter.
    flips = [1, y, z, x, x * y, y * z, 1, x * z, 1, y, x * y * z, y, z, x, z, x]
    matrix = splat_harmonics.turned_harmonics(RDF_TO_RUB[:3, :3], 16)
    assert np.array_equal(matrix, np.diag(flips))


def test_what_files_cannot_say_is_not_written(tmp_path):
    splats = some_splats(4)
    mirrored = np.diag([-1.0, 1, 1, 1])
    stretched = np.diag([1.0, 2, 1, 1])
    for more, found in (
        ({"color_space": "linear"}, "linear"),
        ({"direction": "ray"}, "ray"),
        ({"white": (2, 2, 2)}, "white"),
        ({"world_from_splats": np.diag([1e8, 1e8, 1e8, 1])}, "within 1e6 m"),
        ({"world_from_splats": mirrored}, "one scale"),
        ({"world_from_splats": stretched}, "one scale"),
    ):
        with pytest.raises(omma.Error, match=found):
            save_splats(tmp_path / "a.ply", splats.replace(**more))
    with pytest.raises(omma.Error, match=r"\.ply or \.spz"):
        save_splats(tmp_path / "a.glb", splats)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("x", np.nan, "position not finite"),
        ("z", np.inf, "position not finite"),
        ("y", 1.1e6, "position beyond 1e6"),
        ("scale_1", np.nan, "scale not a number"),
        ("scale_1", -np.inf, "scale below 1e-12"),
        ("scale_0", np.log(0.9e-12), "scale below 1e-12"),
        ("scale_2", np.log(1.1e6), "scale above 1e6"),
        ("scale_2", np.inf, "scale above 1e6"),
        ("opacity", np.nan, "opacity not a number"),
        ("f_dc_1", np.nan, "harmonics not finite"),
        ("f_rest_7", -np.inf, "harmonics not finite"),
        ("f_rest_3", -1.1e4, "harmonics beyond 1e4"),
        ("rot_2", np.nan, "rotation not finite"),
        ("rot_0", np.inf, "rotation not finite"),
        (("rot_0", "rot_1", "rot_2", "rot_3"), 0, "rotation of length 0"),
    ],
)
def test_splats_that_are_no_gaussians_are_left_out_and_counted(tmp_path, name, value, reason):
    columns = splat_bytes.raw_splats(30, 4)
    for one in (name,) if isinstance(name, str) else name:
        columns[one][[3, 11, 29]] = value
    for kind in ("binary_big_endian", "ascii"):
        path = ply_of(tmp_path, columns, kind=kind)
        splats, told = read_splats(path)
        assert told == [f"3 splats are left out: {reason}"]
        with pytest.warns(UserWarning, match=rf"place\.ply: 3 splats are left out: {reason}"):
            assert load_splats(path) == splats
        kept = {one: np.delete(values, [3, 11, 29]) for one, values in columns.items()}
        check(splats, expected(kept))


def test_each_splat_is_counted_once_and_none_left_is_an_error(tmp_path):
    columns = splat_bytes.raw_splats(4, 1)
    columns["x"][:] = np.nan
    columns["opacity"][:] = np.nan
    with pytest.raises(omma.Error, match=r"none that can be used \(position not finite: 4\)"):
        load_splats(ply_of(tmp_path, columns))


def test_infinite_logits_are_zero_and_one(tmp_path):
    columns = splat_bytes.raw_splats(3, 1)
    columns["opacity"][:] = [np.inf, -np.inf, 800]
    assert load_splats(ply_of(tmp_path, columns)).opacities.tolist() == [1, 0, 1]


def without(*names):
    columns = splat_bytes.floats(splat_bytes.raw_splats(6, 4))
    return {name: value for name, value in columns.items() if name not in names}


def with_rest(count):
    columns = splat_bytes.floats(splat_bytes.raw_splats(6, 1))
    return {**columns, **{f"f_rest_{k}": columns["x"] for k in range(count)}}


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (without("opacity"), "found none called opacity"),
        (without("scale_2", "rot_3"), "found none called scale_2, rot_3"),
        (without("f_dc_2"), "found none called f_dc_2"),
        (without("f_rest_8"), "0, 9, 24, 45 properties f_rest_0 and so on, found 8"),
        (with_rest(72), "found 72"),
        ({**without("f_rest_8"), "f_rest_9": without()["x"]}, "found no f_rest_8"),
        ({**without(), "f_dc_0": ("uchar", np.arange(6))}, "found f_dc_0 of the type uint8"),
        ({**without(), "opacity": ("int", np.arange(6))}, "found opacity of the type int32"),
        (without("f_dc_0"), "expected Gaussian splats, vertices with f_dc_0"),
    ],
)
def test_ply_that_lacks_something(tmp_path, columns, message):
    with pytest.raises(omma.Error, match=rf"a\.ply: .*{message}"):
        load_splats(saved(tmp_path, "a.ply", splat_bytes.ply({"vertex": columns})))


def test_broken_ply(tmp_path):
    columns = splat_bytes.floats(splat_bytes.raw_splats(6, 4))
    whole = splat_bytes.ply({"vertex": columns})
    text = splat_bytes.ply({"vertex": columns}, "ascii")
    for data, message in (
        (whole[:-1], "expected 6 points, found the end of the file after 5"),
        (text[: text.rindex(b"\n", 0, -1) + 1], "expected 6 points"),
        (text[:-30], "other text or another number"),
        (whole.replace(b"property float x", b"property list uchar float x"), "without lists"),
        (whole.replace(b"property float nx", b"property float x"), "found x twice"),
        (whole.replace(b"vertex 6", b"vertex 0"), "found none"),
        (whole.replace(b"vertex 6", b"vertex 4000000000"), "expected 4000000000 rows"),
        (whole.replace(b"end_header", b"end_heads"), "a header that ends"),
        (whole.replace(b"binary_little_endian", b"binary"), "expected the format"),
        (whole[:40], "a header that ends"),
        (b"", "expected 'ply'"),
    ):
        with pytest.raises(omma.Error, match=rf"a\.ply.*{message}"):
            load_splats(saved(tmp_path, "a.ply", data))


def test_broken_packed_ply(tmp_path):
    columns = splat_bytes.raw_splats(300, 4)
    whole = splat_bytes.ply(splat_bytes.packed_ply(columns))
    for change, message in (
        ((b"element chunk 2", b"element chunk 1"), "found the end|rows of chunk"),
        ((b"min_x", b"mix_x"), "chunk with min_x of the type float, found none"),
        ((b"max_b", b"max_c"), "chunk with max_b"),
        ((b"property uint packed_scale", b"property float packed_scale"), "found another type"),
        ((b"f_rest_8", b"f_rest_x"), "sh with f_rest_8"),
        ((b"element sh 300", b"element sh 299"), "expected 300 rows of sh"),
        ((b"element chunk", b"element chunks"), "expected packed splats, chunk and vertex"),
        ((b"binary_little_endian", b"ascii"), "found text"),
    ):
        assert change[0] in whole
        with pytest.raises(omma.Error, match=rf"a\.ply: .*({message})"):
            load_splats(saved(tmp_path, "a.ply", whole.replace(*change)))
    with pytest.raises(omma.Error, match="expected 300 points"):
        load_splats(saved(tmp_path, "a.ply", whole[:-1]))


def record(kind, data):
    return struct.pack("<II", kind, len(data)) + data


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"says": 1}, "found version 1"),
        ({"says": 5}, "found version 5"),
        ({"magic": 7}, "letters NGSP|gzip or NGSP"),
        ({"degree": 4}, "found degree 4"),
        ({"says_bits": 25}, "found 25"),
        ({"count": 201}, "expected .* bytes more of its splats|as its table says"),
        ({"count": 199}, "found more bytes|as its table says"),
        ({"count": 0}, "expected Gaussian splats, found none|found more|as its table says"),
        ({"flags": 2, "tail": record(0xADBE0003, b"\6\0\0\0")}, "number 0xADBE0003"),
        ({"flags": 2, "tail": record(0xADBE0002, b"")[:-1]}, "with their lengths"),
        ({"flags": 2, "tail": record(0xADBE0002, b"12")[:-1]}, "found its end"),
        ({"count": (1 << 32) - 1}, "which hold fewer"),
    ],
)
@pytest.mark.parametrize("version", [3, 4])
def test_spz_that_is_not_what_it_says(tmp_path, version, more, message):
    if version == 4:
        pytest.importorskip("zstandard")
    data = splat_bytes.spz(splat_bytes.raw_splats(200, 4), version, **more)
    with pytest.raises(omma.Error, match=rf"a\.spz: .*({message})"):
        load_splats(saved(tmp_path, "a.spz", data))


@pytest.mark.parametrize("version", [2, 3, 4])
def test_spz_cut_off_anywhere(tmp_path, version):
    if version == 4:
        pytest.importorskip("zstandard")
    columns = splat_bytes.raw_splats(40, 4)
    limits = record(0xADBE0002, b"of a camera.")
    whole = splat_bytes.spz(columns, version, flags=2, tail=limits)
    assert len(load_splats(saved(tmp_path, "a.spz", whole)).positions_m) == 40
    for length in (0, 1, 3, 9, 17, 33, 60, 200, len(whole) - 9, len(whole) - 1):
        with pytest.raises(omma.Error, match=r"a\.spz: "):
            load_splats(saved(tmp_path, "a.spz", whole[:length]))


def test_versions_in_the_wrong_wrapping(tmp_path):
    columns = splat_bytes.raw_splats(10, 1)
    three = gzip.decompress(splat_bytes.spz(columns, 3))
    with pytest.raises(omma.Error, match="version 3 as gzip"):
        load_splats(saved(tmp_path, "a.spz", three))
    with pytest.raises(omma.Error, match="version 4 without gzip"):
        load_splats(saved(tmp_path, "a.spz", splat_bytes.spz(columns, 3, says=4)))
    with pytest.raises(omma.Error, match="found b'PK"):
        load_splats(saved(tmp_path, "a.spz", b"PK\3\4" * 20))


def bombs():
    """Files that promise, or unpack to, far more than they hold."""
    head = "<IIIBBBB"
    zeros = bytes(1 << 26)
    promise = gzip.compress(struct.pack(head, 0x5053474E, 3, (1 << 32) - 1, 3, 12, 0, 0))
    # Zeros behind ten splats.
    ten = struct.pack(head, 0x5053474E, 3, 10, 0, 12, 0, 0) + bytes(200)
    longer = gzip.compress(ten + zeros, 1)
    # What deflate can hold of so many, but does not: some 10 million splats promised.
    padded = struct.pack(head, 0x5053474E, 3, 10_000_000, 3, 12, 0, 0)
    short = gzip.compress(padded) + np.random.default_rng(1).bytes(1 << 20)
    ply = splat_bytes.ply({"vertex": splat_bytes.floats(splat_bytes.raw_splats(1, 1))})
    return {
        "promise.spz": promise,
        "longer.spz": longer,
        "short.spz": short,
        "rows.ply": ply.replace(b"vertex 1", b"vertex 4000000000"),
        "before.ply": ply.replace(b"element vertex 1", b"element vertex 4294967296"),
    }


@pytest.mark.timeout(60)
def test_bombs_are_refused_at_once_and_without_memory(tmp_path):
    for name, data in bombs().items():
        path = saved(tmp_path, name, data)
        tracemalloc.start()
        with pytest.raises(omma.Error, match=name):
            load_splats(path)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        # NumPy's arrays are counted whole where they are made, though pages nobody wrote to take
        # none: those of the file that could hold what it promises.
        assert peak < (3e9 if name == "short.spz" else 3e7), name


def test_a_wide_window_of_zstandard_is_refused(tmp_path):
    zstandard = pytest.importorskip("zstandard")
    data = bytearray(splat_bytes.spz(splat_bytes.raw_splats(200, 1), 4))
    at = 32 + 5 * 16
    assert data[at : at + 4] == b"\x28\xb5\x2f\xfd"
    # A frame that says its window is 2 GB: no single segment, the greatest exponent.
    data[at + 4], data[at + 5] = 0x00, (31 - 10) << 3
    with pytest.raises(omma.Error, match=r"a\.spz: "):
        load_splats(saved(tmp_path, "a.spz", bytes(data)))
    assert zstandard.WINDOWLOG_MAX >= 27


def test_version_4_says_which_package_it_needs(tmp_path, monkeypatch):
    path = saved(tmp_path, "a.spz", bytes.fromhex("4e475350 04000000 0100000000000005"))
    path.write_bytes(path.read_bytes() + struct.pack("<I12x", 32) + bytes(400))
    monkeypatch.setitem(__import__("sys").modules, "zstandard", None)
    with pytest.raises(omma.Error, match=r"omma\[splats\]|table says"):
        load_splats(path)


def test_files_that_are_none(tmp_path):
    with pytest.raises(omma.Error, match="expected a file, found none"):
        load_splats(tmp_path / "a.ply")
    (tmp_path / "b.spz").mkdir()
    with pytest.raises(omma.Error, match="found a directory"):
        load_splats(tmp_path / "b.spz")
    with pytest.raises(omma.Error, match=r"\.ply or \.spz"):
        load_splats(saved(tmp_path, "a.splat", b""))
    assert not is_splat_file(tmp_path / "a.splat")
    points = splat_bytes.ply({"vertex": {axis: ("float", np.arange(3)) for axis in "xyz"}})
    path = saved(tmp_path, "points.ply", points)
    assert not is_splat_file(path)
    assert is_point_file(str(path))


@pytest.mark.parametrize("name", ["a.ply", "a.spz"])
def test_what_progress_raises_comes_back(tmp_path, name):
    save_splats(tmp_path / name, some_splats())

    def stop(share):
        raise ZeroDivisionError(share)

    with pytest.raises(ZeroDivisionError):
        load_splats(tmp_path / name, progress=stop)


SMALL = splat_bytes.raw_splats(7, 4)
WHOLE = {
    "a.ply": splat_bytes.ply({"vertex": splat_bytes.floats(SMALL)}),
    "text.ply": splat_bytes.ply({"vertex": splat_bytes.floats(SMALL)}, "ascii"),
    "packed.ply": splat_bytes.ply(splat_bytes.packed_ply(SMALL)),
    "two.spz": splat_bytes.spz(SMALL, 2),
    "three.spz": splat_bytes.spz(SMALL, 3),
}


@pytest.mark.parametrize("name", [*WHOLE, "unpacked.spz", "four.spz"])
def test_changed_bytes_give_splats_or_an_error(tmp_path_factory, name):
    if name == "four.spz":
        pytest.importorskip("zstandard")
        whole = splat_bytes.spz(SMALL, 4)
    else:
        whole = WHOLE.get(name) or gzip.decompress(WHOLE["three.spz"])
    path = tmp_path_factory.mktemp("changed") / name

    @settings(max_examples=150, deadline=None, database=None)
    @given(
        changes=st.lists(
            st.tuples(st.integers(0, len(whole) - 1), st.integers(0, 255)), max_size=6
        ),
        length=st.one_of(st.just(len(whole)), st.integers(0, len(whole))),
    )
    def run(changes, length):
        data = bytearray(whole)
        for at, value in changes:
            data[at] = value
        changed = bytes(data[:length])
        path.write_bytes(gzip.compress(changed, 1) if name == "unpacked.spz" else changed)
        try:
            splats, _ = read_splats(path)
        except omma.Error:
            return
        assert len(splats.positions_m) > 0
        for one in ARRAYS:
            assert np.isfinite(getattr(splats, one)).all()
        assert (splats.scales_m > 0).all()
        assert np.linalg.norm(splats.rotations, axis=1) == pytest.approx(1, abs=1e-5)
        assert ((splats.opacities >= 0) & (splats.opacities <= 1)).all()

    run()


def test_floaters_are_culled():
    splats = some_splats(400)
    matrix = splats.world_from_splats
    world = splats.positions_m @ matrix[:3, :3].T
    scan = world[:200:2]
    culled, counts = cull_splats(splats, least_opacity=0.3, scan=scan, distance_m=0.2)
    faint = splats.opacities < 0.3
    distance = np.linalg.norm(world[:, None] - scan[None], axis=2).min(axis=1)
    far = ~faint & (distance > 0.2)
    assert counts == {"opacity": faint.sum(), "distance": far.sum()}
    assert far.sum() > 20
    assert np.array_equal(culled.positions_m, splats.positions_m[~faint & ~far])
    assert np.array_equal(culled.harmonics, splats.harmonics[~faint & ~far])
    # A survey's points, far from zero.
    shift = np.array([4e5, 100, -5.8e6])
    cloud = omma.scene.PointCloud(scan.astype(np.float32), shift)
    placed = matrix.copy()
    placed[:3, 3] = shift
    moved = splats.replace(world_from_splats=placed)
    same, _ = cull_splats(moved, least_opacity=0.3, scan=cloud, distance_m=0.2)
    assert np.array_equal(same.positions_m, culled.positions_m)
    assert cull_splats(splats) == (splats, {})


def test_culling_refuses_nonsense():
    splats = some_splats(10)
    for more, message in (
        ({"scan": np.zeros((1, 3))}, "scan and distance_m together"),
        ({"distance_m": 1.0}, "scan and distance_m together"),
        ({"scan": np.zeros((0, 3)), "distance_m": 1.0}, "scan: expected points"),
        ({"scan": np.full((1, 3), np.nan), "distance_m": 1.0}, "finite"),
        ({"scan": np.zeros((1, 3)), "distance_m": -1.0}, "distance_m"),
        ({"least_opacity": 2.0}, "least_opacity"),
        ({"beyond_m": -1.0}, "beyond_m"),
        ({"center_m": (0, np.nan, 0)}, "center_m"),
        ({"above_m": np.nan}, "above_m"),
        ({"least_opacity": 1.0}, r"found none of 10 \(opacity: 10\)"),
    ):
        with pytest.raises(omma.Error, match=message):
            cull_splats(splats, **more)


def test_sky_is_culled():
    splats = some_splats(400)
    world = splats.positions_m @ RDF_TO_RUB[:3, :3].T
    center = np.array([0.5, 1.0, -0.2])
    culled, counts = cull_splats(splats, beyond_m=1.5, center_m=center, above_m=0.8)
    beyond = np.linalg.norm(world - center, axis=1) > 1.5
    above = ~beyond & (world[:, 1] > 0.8)
    assert counts == {"beyond": beyond.sum(), "above": above.sum()}
    assert min(counts.values()) > 20
    assert culled == splats.replace(
        **{name: getattr(splats, name)[~beyond & ~above] for name in ARRAYS}
    )


@pytest.mark.parametrize("name", ["a.ply", "a.spz"])
def test_scenes_of_splats(tmp_path, name):
    save_splats(tmp_path / name, some_splats())
    shares = []
    scene = omma.load_scene(tmp_path / name, progress=shares.append)
    assert shares[-1] == 1
    assert scene.splats == [load_splats(tmp_path / name)]
    assert scene.path == str(tmp_path / name)
    assert scene.warnings == []
    z_up = omma.load_scene(tmp_path / name, unit="mm", up="z").splats
    assert z_up == [load_splats(tmp_path / name, unit="mm", up="z")]
    for more in ({"scene_index": 0}, {"color_rule": "compoundray"}, {"up": "-z"}):
        with pytest.raises(omma.Error, match=next(iter(more))):
            omma.load_scene(tmp_path / name, **more)
    with pytest.raises(omma.Error, match=r"load_scene reads|\.ply"):
        omma.scene.load_points(tmp_path / name)


def test_info_says_what_splats_there_are(tmp_path):
    columns = splat_bytes.raw_splats(30, 4)
    columns["x"][7] = np.nan
    path = ply_of(tmp_path, columns)
    assert is_scene_file(tmp_path / "none.spz")
    lines = describe_file(path)
    assert next(value for what, value in lines if what == "splats").startswith(
        "29 Gaussian splats of place, harmonics of degree 1, composited as srgb"
    )
    assert ("warning", "1 splats are left out: position not finite") in lines
    with pytest.warns(UserWarning, match="1 splats are left out"):
        omma.load_scene(path)


def test_far_splats_of_spz_are_left_out(tmp_path):
    columns = splat_bytes.raw_splats(30, 4)
    columns["y"][[3, 9]] = 2e6
    path = saved(tmp_path, "a.spz", splat_bytes.spz(columns, bits=2))
    splats, told = read_splats(path)
    assert told == ["2 splats are left out: position beyond 1e6"]
    kept = {one: np.delete(values, [3, 9]) for one, values in columns.items()}
    check_spz(splats, expected(kept), 1 / 8, 2.1e-3)
