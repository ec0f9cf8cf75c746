"""Files of Gaussian splats: what they hold is read and written."""

import gzip
import struct

import numpy as np
import pytest
import slow_splats
import splat_bytes
from scipy.spatial.transform import Rotation
from splat_files import (
    RDF_TO_RUB,
    TERMS,
    arrays_of,
    check,
    check_spz,
    expected,
    ply_of,
    saved,
    some_splats,
)

import omma
from omma.job.info import describe_file, is_scene_file
from omma.scene import load_splats, save_splats, splat_harmonics
from omma.scene.point_files import is_point_file
from omma.scene.splat_files import is_splat_file


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


@pytest.mark.parametrize("name", ["a.ply", "a.spz"])
def test_what_progress_raises_comes_back(tmp_path, name):
    save_splats(tmp_path / name, some_splats())

    def stop(share):
        raise ZeroDivisionError(share)

    with pytest.raises(ZeroDivisionError):
        load_splats(tmp_path / name, progress=stop)


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
