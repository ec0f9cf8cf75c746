"""Loading and building: progress, Ctrl-C and exceptions on the way, large scenes."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import load_script
from processes import Program

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


# Says by how many bytes loading and building raised the peak of the process.
PEAK = """
import resource, sys
import omma

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

before = peak()
scene = omma.load_scene(sys.argv[1])
omma.Renderer(scene, omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1), threads=1)
print(peak() - before)
"""

WRITE_PNG = """
import sys, threading, time
import numpy as np
import omma

noise = np.random.default_rng(0).integers(0, 256, (6000, 6000, 3), np.uint8)

def tell():
    begun = time.process_time()
    while time.process_time() < begun + 0.3:
        time.sleep(0.01)
    print("writing", flush=True)

try:
    threading.Thread(target=tell, daemon=True).start()
    omma.save_png(sys.argv[1], noise)
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """A scene whose building takes seconds on one thread."""
    module = load_script(ROOT / "bench" / "make_large_scene.py")
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
    fractions = []
    scene = omma.load_scene(files / "scene.gltf", progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1
    fractions.clear()
    renderer = omma.Renderer(scene, eye, progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1
    assert (renderer.render(np.eye(4)) == omma.Renderer(scene, eye).render(np.eye(4))).all()


def test_what_progress_raises_comes_out(files, scene, eye):
    def stop(fraction):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        omma.load_scene(files / "scene.gltf", progress=stop)
    with pytest.raises(LookupError, match="enough"):
        omma.Renderer(scene, eye, progress=stop)


def test_errors_come_before_progress(tmp_path):
    with pytest.raises(omma.Error, match="no such file"):
        omma.load_scene(tmp_path / "none.glb", progress=lambda fraction: None)


def test_a_large_texture_is_held_once(tmp_path):
    size = 4608
    omma.save_png(tmp_path / "grey.png", np.full((size, size, 3), 90, np.uint8))
    scene = {
        "asset": {"version": "2.0"},
        "images": [{"uri": "grey.png"}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    }
    path = tmp_path / "grey.gltf"
    path.write_text(json.dumps(scene))
    ran = subprocess.run(
        [sys.executable, "-c", PEAK, path], check=True, capture_output=True, text=True
    )
    # Of each texel: 4 bytes in the scene, 8/3 of coarser levels, 1 while these are made. Twice
    # over, or as 16 bits, it would be 12 and more. The rest is what a renderer of nothing needs.
    assert int(ran.stdout) < 10 * size**2


def test_ctrl_c_while_a_png_is_written(tmp_path):
    with Program(WRITE_PNG, tmp_path / "noise.png") as program:
        assert program.line() == "writing"  # some tenths of a second of several
        program.interrupt()
        assert program.end() == (0, "interrupted\n", "")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("work", ["load", "build"])
def test_ctrl_c(large, work):
    with Program(PROGRAM, work, large) as program:
        assert program.line() == "begun"
        program.interrupt()
        assert program.end() == (0, "interrupted\n", "")
