"""What is wrong in files of Gaussian splats is said, or counted and left out."""

import gzip
import struct
import tracemalloc

import numpy as np
import pytest
import splat_bytes
from hypothesis import given, settings
from hypothesis import strategies as st
from splat_files import ARRAYS, check, check_spz, expected, ply_of, saved

import omma
from omma.job.info import describe_file
from omma.scene import load_splats
from omma.scene.point_files import is_point_file
from omma.scene.splat_files import is_splat_file, read_splats


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
        (without("f_dc_0"), "found none called f_dc_0"),
        (without("rot_0"), "found none called rot_0"),
        (without("scale_0"), "found none called scale_0"),
        (without("f_dc_0", "rot_0"), "expected Gaussian splats, vertices with f_dc_0"),
    ],
)
def test_ply_that_lacks_something(tmp_path, columns, message):
    name = saved(tmp_path, "a.ply", splat_bytes.ply({"vertex": columns}))
    with pytest.raises(omma.Error, match=rf"a\.ply: .*{message}"):
        load_splats(name)
    if "none called" in message:  # and by what loads any scene, to which others are points
        with pytest.raises(omma.Error, match=rf"a\.ply: .*{message}"):
            omma.load_scene(name)


def test_broken_ply(tmp_path):
    columns = splat_bytes.floats(splat_bytes.raw_splats(6, 4))
    whole = splat_bytes.ply({"vertex": columns})
    text = splat_bytes.ply({"vertex": columns}, "ascii")
    for data, message in (
        (whole[:-1], "expected 6 points, found the end of the file after 5"),
        (text[: text.rindex(b"\n", 0, -1) + 1], "expected 6 points"),
        (text[:-30], "line 37: expected 26 numbers"),
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
    with pytest.raises(omma.Error, match=r"found bytes that are no plain text$"):
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
    for name in ("a.splat", "a.ksplat", "a.SOG"):
        path = saved(tmp_path, name, b"PK\3\4")
        for read in (load_splats, omma.load_scene, describe_file):
            with pytest.raises(omma.Error, match=r"as \.ply or \.spz, found .*SuperSplat"):
                read(path)
    with pytest.raises(omma.Error, match=r"\.ply or \.spz"):
        load_splats(saved(tmp_path, "a.bin", b""))
    for data, found in (
        (b"", "an empty file"),
        (b"ply\n", "a file that begins with 'ply'"),
        (b"\xff\0ab", "bytes that are no plain text"),
    ):
        with pytest.raises(omma.Error, match=rf"c\.spz: expected .*, found .*{found}$"):
            load_splats(saved(tmp_path, "c.spz", data))
    assert not is_splat_file(tmp_path / "a.splat")
    points = splat_bytes.ply({"vertex": {axis: ("float", np.arange(3)) for axis in "xyz"}})
    path = saved(tmp_path, "points.ply", points)
    assert not is_splat_file(path)
    assert is_point_file(str(path))


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


def test_far_splats_of_spz_are_left_out(tmp_path):
    columns = splat_bytes.raw_splats(30, 4)
    columns["y"][[3, 9]] = 2e6
    path = saved(tmp_path, "a.spz", splat_bytes.spz(columns, bits=2))
    splats, told = read_splats(path)
    assert told == ["2 splats are left out: position beyond 1e6"]
    kept = {one: np.delete(values, [3, 9]) for one, values in columns.items()}
    check_spz(splats, expected(kept), 1 / 8, 2.1e-3)
