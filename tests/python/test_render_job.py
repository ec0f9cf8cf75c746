"""What `omma render` and `omma info` are asked for: meshes in their unit, a camera's own eye along
a path, writing beside rendering."""

import time

import numpy as np
import pytest
from conftest import write_gltf

import omma
from omma.job.begun import _looking
from omma.job.pieces import render_pieces
from omma.picture.files import on_threads
from omma.rendering.response_files import Piece


@pytest.fixture
def command(tmp_path, monkeypatch, run_omma):
    """`omma` with arguments, in the folder of the test: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    return run_omma


@pytest.fixture
def scan(tmp_path):
    """A wedge of 1 x 2 x 3 mm, +Z up."""
    trimesh = pytest.importorskip("trimesh")
    wedge = trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]],
        [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        process=False,
    )
    for ending in ("stl", "obj", "ply"):
        wedge.export(tmp_path / f"scan.{ending}")
    omma.save_eye(tmp_path / "e.csv", omma.eye.generate_eye(12))
    return tmp_path


@pytest.mark.parametrize("name", ["scan.stl", "scan.obj", "scan.ply"])
def test_a_scan_is_a_scene_in_its_unit(scan, name, command):
    code, told, err = command("info", name)
    assert code == 0, err
    assert "bounds           (0, 0, 0) to (1, 2, 3) m" in told
    _, told, _ = command("info", name, "--unit", "mm", "--up", "z")
    assert "bounds           (0, 0, -0.002) to (0.001, 0.003, 0) m" in told
    code, _, err = command("info", "e.csv", "--up", "z")
    assert code == 1
    assert "up: expected none" in err


def test_a_scan_is_rendered_in_its_unit_and_again(scan, command):
    words = ("render", "scan.stl", "--eye", "e.csv", "--position", 0.0003, 0.0005, 0.01)
    code, _, err = command(*words, "-o", "m.npy")
    assert code == 0, err
    of_mm = ("--scene-unit", "mm", "--scene-up", "z", "-o", "mm.npy")
    assert command(*words, *of_mm)[0] == 0
    in_metres, in_mm = np.load(scan / "m.npy"), np.load(scan / "mm.npy")
    scene = omma.load_scene(scan / "scan.stl", unit="mm", up="z")
    renderer = omma.Renderer(scene, omma.load_eye(scan / "e.csv"))
    pose = omma.poses_from_angles((0.0003, 0.0005, 0.01), (0, 0, 0))
    assert in_mm.tobytes() == renderer.render(pose).tobytes()
    assert (in_metres != in_mm).any()
    assert command("render-again", "mm.npy", "-o", "like.npy")[0] == 0
    assert np.load(scan / "like.npy").tobytes() == in_mm.tobytes()
    wrong = command("render", "scan.stl", "--scene-up", "x", *words[2:], "-o", "x.npy")
    assert "expected one of y, z" in wrong[2]


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_a_cameras_own_eye_flies_along_a_path(tmp_path, command, scale):
    grown = omma.eye.generate_eye(30, radius_m=0.05)
    omma.save_eye(tmp_path / "bug.eye", grown, unit="m")
    extras = {"compound-eye": "true", "compound-structure": "bug.eye"}
    place = {"translation": [0, 1, 0], "scale": [scale] * 3}
    write_gltf(
        tmp_path / "scene.gltf",
        cameras=[("plain", None, place), ("bug", extras, place)],
        scene_extras={"background-color": [0.1, 0.2, 0.3]},
    )
    (tmp_path / "path.csv").write_text(
        "x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n1,0.5,2,90,-20,0\n"
    )
    code, _, err = command(
        "render", "scene.gltf", "--camera", "bug", "--path", "path.csv", "-o", "out.npy"
    )
    assert code == 0, err
    found = np.load(tmp_path / "out.npy")
    # By hand: the eye as large as the camera makes it.
    scene = omma.load_scene(tmp_path / "scene.gltf")
    eye = omma.load_eye(tmp_path / "bug.eye", unit="m")
    large = eye.replace(
        position_m=eye.position_m * scale, focal_offset_m=eye.focal_offset_m * scale
    )
    poses = omma.load_poses(tmp_path / "path.csv")
    assert found == pytest.approx(omma.Renderer(scene, large).render(poses), abs=2e-3)
    # The first pose is the camera's.
    at = omma.render_file(tmp_path / "scene.gltf", tmp_path / "at.npy", camera="bug")
    assert at.ommatidia == 30
    assert found[:1] == pytest.approx(np.load(tmp_path / "at.npy"), abs=2e-3)


def test_a_path_is_for_eyes(tmp_path):
    write_gltf(tmp_path / "scene.gltf", cameras=[("plain", None, {})])
    omma.save_eye(tmp_path / "e.csv", omma.eye.generate_eye(12))
    poses = np.eye(4)
    with pytest.raises(omma.Error, match="poses: is for eyes; camera 'plain' is perspective"):
        omma.render_file(tmp_path / "scene.gltf", tmp_path / "o.npy", camera="plain", poses=poses)
    with pytest.raises(omma.Error, match="camera and poses: only one of them"):
        omma.render_file(
            tmp_path / "scene.gltf",
            tmp_path / "o.npy",
            camera="plain",
            poses=poses,
            eyes=tmp_path / "e.csv",
        )


class Slow:
    """A writer that takes its time."""

    def __init__(self, s):
        self.s, self.first = s, []

    def write(self, piece):
        time.sleep(self.s * len(piece.responses))
        self.first += range(piece.first, piece.first + len(piece.responses))


def test_pieces_are_written_beside_rendering():
    def render(poses, first, progress):
        time.sleep(0.02 * len(poses))
        running.append(writer.first[-1:] + [first])
        return Piece(first, np.zeros((len(poses), 1, 3), np.float32))

    running, writer = [], Slow(0.02)
    start = time.perf_counter()
    seconds = render_pieces(render, [writer], np.tile(np.eye(4), (60, 1, 1)), 12, lambda *_: None)
    took = time.perf_counter() - start
    assert writer.first == list(range(60))  # all, in order
    # Rendered is what was rendered; what is written meanwhile takes no time of its own. Both sleep
    # for 1.2 s, so that one after the other they would take 2.4 s on any machine.
    assert 1.2 <= seconds < took
    assert took < seconds + 1.2
    assert len(running) > 3


def test_what_a_writer_cannot_ends_the_render():
    class Full:
        def write(self, piece):
            raise omma.Error("disk is full")

    def render(poses, first, progress):
        return Piece(first, np.zeros((len(poses), 1, 3), np.float32))

    with pytest.raises(omma.Error, match="disk is full"):
        render_pieces(render, [Full()], np.tile(np.eye(4), (60, 1, 1)), 12, lambda *_: None)


def test_pictures_come_in_order_from_several_threads():
    def make(i):
        time.sleep(0.001 * ((7 * i) % 5))
        return i

    assert list(on_threads(make, 50)) == list(range(50))
    assert list(on_threads(make, 1)) == [0]
    assert list(on_threads(make, 0)) == []


def test_the_parts_of_the_time_are_named(tmp_path, command):
    write_gltf(tmp_path / "scene.gltf")
    omma.save_eye(tmp_path / "e.csv", omma.eye.generate_eye(12))
    words = ("render", "scene.gltf", "--eye", "e.csv", "--position", 0, 1, 0, "-o", "o.png")
    _, told, _ = command(*words)
    (line,) = [line for line in told.splitlines() if line.startswith("time")]
    assert " s of rendering, " in line
    assert " s more of writing, after " in line
    report = omma.render_file(
        tmp_path / "scene.gltf", tmp_path / "o.npy", eyes=tmp_path / "e.csv", position=(0, 1, 0)
    )
    assert report.writing_seconds > 0


@pytest.mark.parametrize("wrong", [{"gamma": 0}, {"width": 0}, {"height": -1}])
def test_what_is_wrong_in_options_is_told_before_anything_is_read(wrong):
    (name,) = wrong
    with pytest.raises(omma.Error, match=f"^{name}: expected"):
        omma.render_file("there is none.gltf", "x.png", **wrong)


@pytest.mark.parametrize("columns", ["x,y,z,yaw_deg,pitch_deg,roll_deg", "x,y,z,qx,qy,qz,qw"])
def test_times_of_a_path_are_kept(columns, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_gltf("scene.gltf")
    omma.save_eye("e.csv", omma.eye.generate_eye(12))
    rest = ",0,0,0" + ",1" * columns.endswith("qw")
    (tmp_path / "p.csv").write_text(f"t_s,{columns}\n0.5,0,1,0{rest}\n0.75,1,1,0{rest}\n")
    omma.render_file("scene.gltf", "r.npy", omma.Fixed(1), eyes="e.csv", path="p.csv")
    data = omma.rendering.load_responses("r.npy")
    assert data.response.dims[0] == "time"
    np.testing.assert_array_equal(data.time, [0.5, 0.75])
    (tmp_path / "still.csv").write_text(f"t_s,{columns}\n0.1,0,1,0{rest}\n0.1,1,1,0{rest}\n")
    with pytest.raises(omma.Error, match=r"still\.csv, line 3: expected times that grow"):
        omma.load_poses("still.csv")


@pytest.mark.parametrize("side", [1, -1])
def test_a_head_looks_straight_up_and_down(side):
    at, pitched = (0, 1, -2), omma.poses_from_angles((0, 1, -2), (0, 90 * side, 0))
    np.testing.assert_allclose(_looking(at, (0, 1 + 2 * side, -2)), pitched, atol=1e-12)
    # What is near it goes over into it: between them the pitch differs by 1e-4 rad.
    np.testing.assert_allclose(_looking(at, (0, 1 + 2 * side, -2.0002)), pitched, atol=2e-4)
