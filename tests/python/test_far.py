"""Far away: rays that cannot be traced are refused whatever sends them there, scenes far from the
origin are seen as near it, and what single precision loses is a warning with a number."""

import json
import subprocess
import sys
import threading
import warnings

import numpy as np
import pytest
from conftest import make_eye, write_gltf

import omma

TOO_FAR_M = 2e18  # Embree ends the process from 1.844e18 m on


def pose_at(x, y, z):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def moved(path, folder, *, by=(0.0, 0.0, 0.0), vertices_by=None, **scene):
    """The scene of ``write_gltf`` under a node that moves everything, or with moved vertices."""
    document = json.loads(write_gltf(folder / path, **scene).read_text())
    roots = document["scenes"][0]["nodes"]
    document["nodes"].append({"name": "there", "children": roots, "translation": list(by)})
    document["scenes"][0]["nodes"] = [len(document["nodes"]) - 1]
    if vertices_by is not None:
        corners = np.array([[-10, 0, -10], [10, 0, -10], [10, 0, 10], [-10, 0, 10]])
        positions = (corners + vertices_by).astype("<f4")
        document["buffers"].append({"uri": "far.bin", "byteLength": 48})
        (folder / "far.bin").write_bytes(positions.tobytes())
        document["bufferViews"].append({"buffer": 1, "byteLength": 48})
        document["accessors"][0] |= {
            "bufferView": 3,
            "min": positions.min(axis=0).tolist(),
            "max": positions.max(axis=0).tolist(),
        }
    (folder / path).write_text(json.dumps(document))
    return folder / path


@pytest.mark.parametrize("axis", range(3))
def test_poses_too_far_away_are_refused(renderer, axis):
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[2, axis, 3] = -TOO_FAR_M
    for render in (renderer.render, renderer.render_rays, lambda p: list(renderer.render_iter(p))):
        with pytest.raises(omma.Error, match=r"poses\[2\]: expected .*1e\+18 m.*found .*2e\+18 m"):
            render(poses)


def test_eyes_and_cameras_too_far_away_are_refused(tmp_path):
    far = {"translation": [0, TOO_FAR_M, 0]}
    path = write_gltf(tmp_path / "far.gltf", cameras=[("satellite", None, far)])
    scene = omma.load_scene(path)
    with pytest.raises(omma.Error, match="satellite"):
        omma.render_camera(scene, "satellite", width=8, height=8)
    with pytest.raises(omma.Error, match=r"poses\[0\]"):
        omma.Renderer(scene, make_eye()).render("satellite")
    (tmp_path / "far.eye").write_text(f"0 {TOO_FAR_M * 1000} 0 0 0 1 0.1 0\n")
    eye = omma.load_eye(tmp_path / "far.eye")
    with pytest.raises(omma.Error, match=r"poses\[0\]: .*position"):
        omma.Renderer(scene, eye).render(np.eye(4))
    offset = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1, 1e19)
    with pytest.raises(omma.Error, match=r"poses\[0\]: .*focal offset"):
        omma.Renderer(scene, offset).render(np.eye(4))
    (tmp_path / "path.csv").write_text(f"x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,{TOO_FAR_M},0,0,0\n")
    with pytest.raises(omma.Error, match=r"poses\[0\]"):
        omma.Renderer(scene, make_eye()).render(omma.load_poses(tmp_path / "path.csv"))


# Without a copy the check and the render read other numbers, and Embree ends the process: so it is
# another one.
CHANGES = """
import threading
import numpy as np
import omma
rng = np.random.default_rng(1)
axis = rng.normal(size=(2000, 3))
eye = omma.Eye(np.zeros_like(axis), axis, 0.1)
scene = omma.load_scene(__import__("sys").argv[1])
renderer = omma.Renderer(scene, eye, omma.Fixed(64))
poses = np.tile(np.eye(4), (400, 1, 1))
poses[:, 1, 3] = 1
expected = renderer.render(poses)
given = poses.copy()
begun = threading.Event()
def change():
    begun.wait()
    given[:, 1, 3] = 1e30
thread = threading.Thread(target=change)
thread.start()
found = renderer.render(given, progress=lambda done: begun.set())
begun.set()
thread.join()
assert (given[:, 1, 3] == 1e30).all()
assert (found == expected).all()
print("done")
"""


def test_poses_that_change_during_a_render(files):
    ran = subprocess.run(
        [sys.executable, "-c", CHANGES, str(files / "scene.gltf")],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout == "done\n"


@pytest.mark.parametrize("distance_m", [1e5, 5e5, 5e6, 1e7])
def test_scenes_far_from_the_origin(tmp_path, distance_m):
    camera = [("head", None, {"translation": [0.5371, 1.1234, 0.2713]})]  # not round
    near = omma.load_scene(write_gltf(tmp_path / "near.gltf", cameras=camera))
    by = (0.81234567 * distance_m, 12.3, -0.5 * distance_m)
    far = omma.load_scene(moved("there.gltf", tmp_path, by=by, cameras=camera))
    assert far.warnings == []
    eye = make_eye(400)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        expected = omma.Renderer(near, eye, omma.Fixed(64)).render("head")
        found = omma.Renderer(far, eye, omma.Fixed(64)).render("head")
        pictures = [omma.render_camera(scene, "head", width=64, height=64) for scene in (near, far)]
    # The ground's colours change by 0.1 a metre and floats are 1e-7 of its 10 m, doubles 1e-9 m at
    # 1e7 m; a ray or two of all may fall on the other side of an edge.
    assert np.abs(found - expected).max() <= 2 / 64
    assert np.abs(found - expected).mean() <= 1e-5
    assert np.abs(pictures[1] - pictures[0]).mean() <= 1e-4


def test_rounded_vertices_are_a_warning_with_a_number(tmp_path):
    away = (5e6, 0.0, 0.0)
    (warning,) = omma.load_scene(moved("far.gltf", tmp_path, vertices_by=away)).warnings
    assert "up to 0.3 m, in a scene of 2" in warning
    # Brought home by its node the vertices stay what the file made of them.
    home = moved("home.gltf", tmp_path, vertices_by=away, by=(-5e6, 0, 0))
    (warning,) = omma.load_scene(home).warnings
    assert "up to 0.3 m" in warning
    # Said once where the whole is turned and scaled, too.
    (warning,) = omma.load_scene(moved("far.gltf", tmp_path, vertices_by=away), up="z").warnings
    assert "up to 0.3 m" in warning


def test_geometry_too_far_away_is_a_warning(tmp_path):
    path = moved("huge.gltf", tmp_path)
    document = json.loads(path.read_text())
    document["nodes"][0]["scale"] = [1e19, 1e19, 1e19]
    path.write_text(json.dumps(document))
    (warning,) = omma.load_scene(path).warnings
    assert "not seen" in warning
    assert '"ground"' in warning


def test_what_is_lost_at_a_pose_is_a_warning_with_a_number(scene, eye, capfd):
    renderer = omma.Renderer(scene, eye)
    far = pose_at(5e6, 1, 0)
    with pytest.warns(RuntimeWarning, match=r"poses\[1\] lies 5e\+06 m .* within 0.3 m") as found:
        renderer.render([np.eye(4), far])
    assert found[0].filename == __file__
    with pytest.warns(RuntimeWarning, match="within 0.3 m"):
        renderer.render_rays(far)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        renderer.render([np.eye(4), pose_at(100, 1, 3)])


NUMBERS_OF_THREADS = """
import numpy as np
import omma
rng = np.random.default_rng(1)
eye = omma.Eye(np.zeros((50, 3)), rng.normal(size=(50, 3)), 0.1)
renderers = []
for threads in (3, 8, 1, 2, 64, 5, 50):
    renderers.append(omma.Renderer(omma.Scene(), eye, threads=threads))
    assert renderers[-1].threads == threads
    for renderer in renderers:
        renderer.render(np.eye(4))
"""


def test_numbers_of_threads_mix_without_a_word():
    ran = subprocess.run(
        [sys.executable, "-c", NUMBERS_OF_THREADS],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")


def test_threads_may_be_more_than_the_machine_has(scene, eye):
    # From several Python threads, each with a renderer of its own.
    expected = omma.Renderer(scene, eye, threads=1).render(np.eye(4))
    found = {}

    def render(count):
        found[count] = omma.Renderer(scene, eye, threads=count).render(np.eye(4))

    threads = [threading.Thread(target=render, args=(count,)) for count in (2, 17, 33, 64)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for responses in found.values():
        assert (responses == expected).all()
    assert len(found) == 4


def test_colours_beyond_single_precision_are_refused(tmp_path):
    path = write_gltf(tmp_path / "bright.gltf")
    document = json.loads(path.read_text())
    document["materials"] = [{"emissiveFactor": [1, 1, 1], "name": "sun"}]
    document["materials"][0]["extensions"] = {
        "KHR_materials_emissive_strength": {"emissiveStrength": 1e38}
    }
    document["extensionsUsed"] = ["KHR_materials_emissive_strength"]
    document["meshes"][0]["primitives"][0]["material"] = 0
    path.write_text(json.dumps(document))
    with pytest.raises(
        omma.Error, match=r'material 0 "sun": its emission .* expected at most 1e15'
    ):
        omma.load_scene(path)
    with pytest.raises(omma.Error, match="background: its radiance"):
        omma.Renderer(omma.Scene(), make_eye(), background=omma.Background.constant((1e38, 0, 0)))
