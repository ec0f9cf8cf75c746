"""Gaussian splats far from the origin, in UTM or in coordinates of the whole earth: what they have
in common is taken off on loading, and they are seen as near the origin."""

import subprocess
import sys
import textwrap

import numpy as np
import pytest
import splat_bytes
from splat_files import RDF_TO_RUB, ply_of, saved, some_splats
from test_gltf_spz import document_of, primitive, write_glb

import omma
from omma.scene import SplatCloud, load_splats, save_splats
from omma.scene.files import read_scene
from omma.scene.splat_files import read_splats

UTM = np.array([4e5, 100.0, -5.8e6])
EARTH = np.array([4.0e6, 1.1e6, 4.8e6])


def positions_of(splats):
    """Where splats are in the world, in double precision."""
    matrix = splats.world_from_splats
    return splats.positions_m.astype(float) @ matrix[:3, :3].T + matrix[:3, 3]


def moved_columns(columns, shift, type_="double"):
    """Columns of a PLY file, positions of that type."""
    wide = splat_bytes.floats(columns)
    for k, axis in enumerate("xyz"):
        wide[axis] = (type_, columns[axis].astype(float) + shift[k])
    return wide


def xyz_of(columns):
    return np.stack([columns[axis].astype(float) for axis in "xyz"], axis=1)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("shift", [UTM, EARTH])
def test_surveys_keep_their_micrometres(tmp_path, kind, shift):
    columns = splat_bytes.raw_splats(50, 1)
    data = splat_bytes.ply({"vertex": moved_columns(columns, shift)}, kind)
    splats, told = read_splats(saved(tmp_path, "a.ply", data), up="y")
    # Single precision has steps of 2.4e-7 at 2 to 4 m from the middle, double of 1e-9 out there.
    assert np.abs(positions_of(splats) - (xyz_of(columns) + shift)).max() < 2e-7
    assert told == []
    turned = load_splats(tmp_path / "a.ply", unit=0.5)  # +Y down, half a metre
    wanted = (xyz_of(columns) + shift) @ RDF_TO_RUB[:3, :3] / 2
    assert np.abs(positions_of(turned) - wanted).max() < 1e-7


def test_floaters_do_not_draw_the_offset_away(tmp_path):
    columns = splat_bytes.raw_splats(500, 1)
    wide = moved_columns(columns, EARTH)
    wide["x"][1][[7, 400]] = [0.0, -3e7]
    splats, told = read_splats(saved(tmp_path, "a.ply", splat_bytes.ply({"vertex": wide})), up="y")
    assert told == ["2 splats are left out: position beyond 1e6"]
    wanted = np.delete(xyz_of(columns) + EARTH, [7, 400], axis=0)
    assert np.abs(positions_of(splats) - wanted).max() < 1e-6


def test_what_the_file_has_rounded_is_told_with_a_number(tmp_path):
    columns = splat_bytes.raw_splats(300, 1)
    path = saved(
        tmp_path, "a.ply", splat_bytes.ply({"vertex": moved_columns(columns, EARTH, "float")})
    )
    with pytest.warns(UserWarning, match="24 bits a number, as the file has, may have moved them"):
        splats = load_splats(path, up="y")
    off = np.abs(positions_of(splats) - (xyz_of(columns) + EARTH)).max()
    assert off <= 0.25  # half a step of single precision at 4.8e6
    (told,) = read_scene(path).warnings
    assert "by up to 0.29, in a cloud of" in told  # 4.8e6 / 2^24
    # Near the origin there is nothing to tell.
    assert read_splats(ply_of(tmp_path, columns))[1] == []


def test_spz_far_away_is_kept(tmp_path):
    columns = splat_bytes.raw_splats(60, 1)
    shift = np.array([1.9e6, 0, -1.9e6])
    far = {**columns, **{axis: columns[axis] + shift[k] for k, axis in enumerate("xyz")}}
    path = saved(tmp_path, "a.spz", splat_bytes.spz(far, bits=2))
    splats, told = read_splats(path)
    assert len(splats.positions_m) == 60
    # Half a step of 2 bits of fraction, the moved numbers rounded by single precision before.
    assert np.abs(positions_of(splats) - (xyz_of(columns) + shift)).max() <= 0.125 + 0.0625
    assert len(told) == 1
    assert "24 bits" in told[0]


@pytest.mark.parametrize("shift", [UTM, EARTH])
def test_packed_ply_far_away_is_kept(tmp_path, shift):
    columns = splat_bytes.raw_splats(700, 1)
    far = {**columns, **{a: columns[a].astype(float) + shift[k] for k, a in enumerate("xyz")}}
    path = saved(tmp_path, "a.ply", splat_bytes.ply(splat_bytes.packed_ply(far)))
    splats, _ = read_splats(path, up="y")
    off = np.abs(positions_of(splats) - (xyz_of(columns) + shift)).max(axis=0)
    # Bounds of chunks are of single precision; between them half a step of 10 bits over 8 m.
    step = np.spacing(np.abs(shift).astype(np.float32)).astype(float) / 2
    assert (off <= step + 8 / 1023 / 2).all()


@pytest.mark.parametrize("backend", ["embree", "portable"])
def test_they_are_seen_as_near_the_origin(tmp_path, backend):
    columns = splat_bytes.raw_splats(400, 4)
    eye = omma.eye.generate_eye(40)
    seen = []
    for shift in (np.zeros(3), UTM, EARTH):
        data = splat_bytes.ply({"vertex": moved_columns(columns, shift)})
        scene = omma.load_scene(saved(tmp_path, "a.ply", data), up="y")
        pose = omma.look_at((0, 0, 1.5), (0, 0, 0))
        pose[:3, 3] += shift
        world = omma.World(scene, backend=backend)
        seen.append(omma.Renderer(world, eye, omma.Fixed(256)).render(pose)[0])
    # Places in the traced frame are rounded otherwise: one ray of 256 may pass the edge of a splat,
    # where it counts 1/255, on its other side.
    for other in seen[1:]:
        assert np.abs(other - seen[0]).max() < 2e-5
    assert np.ptp(seen[0]) > 0.1


def test_far_splats_are_written_in_double_precision(tmp_path, monkeypatch):
    monkeypatch.setattr("omma.scene.splat_files.PIECE", 128)
    near = some_splats()
    placed = RDF_TO_RUB.copy()
    placed[:3, 3] = EARTH
    far = near.replace(world_from_splats=placed)
    save_splats(tmp_path / "far.ply", far)
    assert b"property double y" in (tmp_path / "far.ply").read_bytes()
    found = load_splats(tmp_path / "far.ply")
    assert np.abs(positions_of(found) - positions_of(far)).max() < 4e-7  # 4 m from the middle
    assert np.array_equal(found.harmonics, far.harmonics)
    save_splats(tmp_path / "near.ply", near)
    assert b"property double" not in (tmp_path / "near.ply").read_bytes()
    # What was read of single precision is written in it again.
    columns = splat_bytes.raw_splats(30, 1)
    data = splat_bytes.ply({"vertex": moved_columns(columns, UTM / 10, "float")})
    again, _ = read_splats(saved(tmp_path, "old.ply", data))
    save_splats(tmp_path / "old_again.ply", again)
    assert b"property double" not in (tmp_path / "old_again.ply").read_bytes()
    assert np.array_equal(
        positions_of(read_splats(tmp_path / "old_again.ply")[0]), positions_of(again)
    )


def test_spz_refuses_what_its_steps_would_ruin(tmp_path):
    placed = np.eye(4)
    placed[:3, 3] = EARTH
    message = r"a\.spz: expected splats about the origin.*found them 4\.8e\+06 m away.*0\.57 m"
    with pytest.raises(omma.Error, match=message):
        save_splats(tmp_path / "a.spz", some_splats(20, 1).replace(world_from_splats=placed))
    assert not (tmp_path / "a.spz").exists()


def test_placed_scenes_are_kept_by_glb(tmp_path):
    matrix = np.eye(4)
    matrix[:3, 3] = EARTH + 0.01
    scene = omma.scene.place_scene(omma.Scene(splats=[some_splats(20, 1)]), matrix)
    omma.scene.save_scene(tmp_path / "a.glb", scene)
    (found,) = omma.load_scene(tmp_path / "a.glb").splats
    assert np.array_equal(found.world_from_splats, scene.splats[0].world_from_splats)
    assert np.abs(positions_of(found) - positions_of(scene.splats[0])).max() == 0


@pytest.mark.parametrize("name", ["a.ply", "a.spz"])
def test_wrong_splats_are_counted_from_the_start_of_the_cloud(tmp_path, name, monkeypatch):
    monkeypatch.setattr("omma.scene.splat_files.PIECE", 128)
    scales = np.full((300, 3), 0.01, np.float32)
    scales[267, 1] = 2e5
    splats = some_splats(300, 1).replace(
        scales_m=scales, world_from_splats=np.diag([10.0, 10, 10, 1])
    )
    with pytest.raises(omma.Error, match=rf"{name}: .*splat 267: expected scales"):
        save_splats(tmp_path / name, splats)


@pytest.mark.parametrize("name", ["many.ply", "many.spz", "many.glb"])
def test_a_scene_takes_two_clouds_of_memory_while_it_is_read(tmp_path, name):
    count, terms = 300_000, 16
    many = SplatCloud(
        np.random.default_rng(1).normal(size=(count, 3)),
        np.full((count, 3), 0.01),
        np.tile((0, 0, 0, 1.0), (count, 1)),
        np.full(count, 0.5),
        np.zeros((count, terms, 3), np.float32),
    )
    save_splats(tmp_path / name.replace("glb", "spz"), many)
    if name == "many.glb":
        packed = document_of([(tmp_path / "many.spz").read_bytes()], [[primitive(0)]])
        write_glb(tmp_path / name, *packed)
    code = """
        import resource, sys
        import omma
        peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        before = peak()
        scene = omma.load_scene(sys.argv[1])
        print(peak() - before)
    """
    words = [sys.executable, "-c", textwrap.dedent(code), str(tmp_path / name)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    # What readers look for before they begin (splat_columns.py), and 10 MB or so of a piece.
    assert int(done.stdout) < 2 * 4 * count * (11 + 3 * terms) + (24 << 20)
