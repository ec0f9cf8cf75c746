"""Loading and building: progress, Ctrl-C and exceptions on the way, large scenes."""

import importlib.util
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import omma

ROOT = Path(__file__).parents[2]

# Says when the work has begun, and how it ended.
PROGRAM = """
import sys
import omma

def begun(share, told=[]):
    if not told:
        told.append(print("begun", flush=True))

try:
    if sys.argv[1] == "build":
        scene = omma.load_scene(sys.argv[2])
        eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1)
        omma.Renderer(scene, eye, threads=1, progress=begun)
    else:
        while True:
            omma.load_scene(sys.argv[2], progress=begun)
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """A scene whose building takes seconds on one thread."""
    place = ROOT / "bench" / "make_large_scene.py"
    made = importlib.util.spec_from_file_location("make_large_scene", place)
    module = importlib.util.module_from_spec(made)
    made.loader.exec_module(module)
    path = tmp_path_factory.mktemp("large") / "hills.glb"
    assert module.write_scene(path, 4_000_000) >= 4_000_000
    return path


@pytest.mark.parametrize("binary", [True, False])
def test_the_script_for_large_scenes(tmp_path, binary):
    path = tmp_path / ("hills.glb" if binary else "hills.gltf")
    made = subprocess.run(
        [sys.executable, ROOT / "bench" / "make_large_scene.py", "1000", path],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    assert made.stdout == f"{path}: 1,058 triangles\n"
    scene = omma.load_scene(path)
    assert scene.triangle_count == 2 * 23**2
    assert scene.warnings == []
    assert scene.bounds[:, [0, 2]].tolist() == [[-500, -500], [500, 500]]


def test_progress_of_both(files, eye):
    shares = []
    scene = omma.load_scene(files / "scene.gltf", progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1
    shares.clear()
    renderer = omma.Renderer(scene, eye, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert (renderer.render(np.eye(4)) == omma.Renderer(scene, eye).render(np.eye(4))).all()


def test_what_progress_raises_comes_out(files, scene, eye):
    def stop(share):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        omma.load_scene(files / "scene.gltf", progress=stop)
    with pytest.raises(LookupError, match="enough"):
        omma.Renderer(scene, eye, progress=stop)


def test_errors_come_before_progress(tmp_path):
    with pytest.raises(omma.Error, match="no such file"):
        omma.load_scene(tmp_path / "none.glb", progress=lambda share: None)


@pytest.mark.parametrize("work", ["load", "build"])
def test_ctrl_c(large, work):
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, work, large],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert process.stdout.readline() == "begun\n"
        process.send_signal(signal.SIGINT)
        sent = time.perf_counter()
        out, err = process.communicate(timeout=20)
        # A second for the work, and some for the interpreter to go down.
        assert time.perf_counter() - sent < 2.0
        assert (process.returncode, out, err) == (0, "interrupted\n", "")
    finally:
        process.kill()
        process.communicate()
