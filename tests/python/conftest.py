"""Small scenes and eyes that the tests make themselves."""

import base64
import importlib.util
import json
import os
import re
import signal
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np
import pytest

import omma
from omma.cli.main import main

# Programs inherit which signals are ignored: Ctrl-C where a shell started the tests in the
# background, SIGHUP under nohup. Tests send both to programs that they start, so neither is ignored
# here.
if threading.current_thread() is threading.main_thread():
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# What tests bake is kept for them alone, also by the programs that they start.
_cache = tempfile.TemporaryDirectory(prefix="omma-cache-")
os.environ["OMMA_CACHE"] = _cache.name

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"


def load_script(path):
    """A script as the module that it is for who imports it."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module  # dataclasses look there
    spec.loader.exec_module(module)
    return module


def svg_texts(path):
    """The words in an SVG are outlines; what they say is in comments."""
    return re.findall(r"<!-- (.*?) -->", path.read_text())


def write_gltf(path, *, cameras=(), scene_extras=None, triangles=True, **changes):
    """A coloured ground of 20 m x 20 m at y = 0, as one self-contained `.gltf` file.

    ``cameras`` are (name, extras or None, node transform); ``changes`` replace top-level members.
    """
    positions = np.array([[-10, 0, -10], [10, 0, -10], [10, 0, 10], [-10, 0, 10]], dtype="<f4")
    colors = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], dtype="<f4")
    indices = np.array([0, 2, 1, 0, 3, 2], dtype="<u2")
    data = positions.tobytes() + colors.tobytes() + indices.tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"name": "main", "nodes": []}],
        "nodes": [],
    }
    if triangles:
        document |= {
            "buffers": [{"uri": uri, "byteLength": len(data)}],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 48},
                {"buffer": 0, "byteOffset": 48, "byteLength": 48},
                {"buffer": 0, "byteOffset": 96, "byteLength": 12},
            ],
            "accessors": [
                {
                    "bufferView": 0,
                    "componentType": 5126,
                    "count": 4,
                    "type": "VEC3",
                    "min": [-10, 0, -10],
                    "max": [10, 0, 10],
                },
                {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
                {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
            ],
            "meshes": [
                {
                    "name": "ground",
                    "primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "indices": 2}],
                }
            ],
        }
        document["nodes"].append({"name": "ground", "mesh": 0})
    if cameras:
        document["cameras"] = []
    for name, extras, transform in cameras:
        camera = {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}
        if extras is not None:
            camera["extras"] = extras
        document["nodes"].append({"name": name, "camera": len(document["cameras"]), **transform})
        document["cameras"].append(camera)
    document["scenes"][0]["nodes"] = list(range(len(document["nodes"])))
    if scene_extras:
        document["scenes"][0]["extras"] = scene_extras
    document |= changes
    path = Path(path)
    path.write_text(json.dumps(document))
    return path


def make_eye(count=60, seed=1, acceptance_deg=5.0, eye_id=0):
    """Axes all round, on a sphere of 1 mm."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    return omma.Eye(1e-3 * axis, axis, np.radians(acceptance_deg), 0.0, eye_id)


@pytest.fixture(autouse=True)
def new_session():
    """What is told once a session is told again in each test."""
    from omma.rendering import without_polarisation
    from omma.scene import without_light

    without_light._told.clear()
    without_polarisation._told.clear()


@pytest.fixture
def coarse_maps(monkeypatch):
    """Maps of few pixels: quicker, and as good for what is tested with them."""
    monkeypatch.setattr("omma.picture.eye_maps._PIXELS", 200)


@pytest.fixture(scope="session")
def files(tmp_path_factory):
    """A directory with scene.gltf (ground, sky, two cameras), bug.eye (60) and left/right.eye;
    eyeless.gltf, whose second camera names an eye that there is not, and empty.gltf."""
    folder = tmp_path_factory.mktemp("files")
    write_gltf(
        folder / "scene.gltf",
        cameras=[
            ("plain", {"note": "look", "n": [1, 2]}, {"translation": [0, 1, 0]}),
            (
                "insect",
                {"compound-eye": "true", "compound-structure": "bug.eye"},
                {"translation": [1, 2, 3], "scale": [0.5, 0.5, 0.5]},
            ),
        ],
        scene_extras={"background-shader": "simple_sky"},
    )
    eyeless = {"compound-eye": True, "compound-structure": "nowhere.eye"}
    write_gltf(folder / "eyeless.gltf", cameras=[("plain", None, {}), ("blind", eyeless, {})])
    write_gltf(folder / "empty.gltf", triangles=False)
    omma.save_eye(folder / "bug.eye", make_eye())
    for side, sign in (("left", -1), ("right", 1)):
        eye = make_eye(40, seed=3)
        axis = eye.axis * np.where(np.sign(eye.axis[:, :1]) == sign, 1, [[-1, 1, 1]])
        omma.save_eye(folder / f"{side}.eye", omma.Eye(eye.position_m, axis, 0.1))
    return folder


@pytest.fixture(scope="session")
def scene(files):
    return omma.load_scene(files / "scene.gltf")


@pytest.fixture(scope="session")
def eye(files):
    return omma.load_eye(files / "bug.eye")


@pytest.fixture(scope="session")
def renderer(scene, eye):
    return omma.Renderer(scene, eye, omma.Fixed(8), threads=2)


@pytest.fixture(scope="session")
def flight():
    """Nine poses over the ground, each somewhere else and turned: (9, 4, 4)."""
    x = np.linspace(-3, 3, 9)
    positions = np.stack([x, 1 + 0.1 * x, -x], axis=1)
    return omma.poses_from_angles(positions, np.stack([30 * x, 5 * x, 7 * x], axis=1))


@pytest.fixture
def run_omma(monkeypatch, capsys):
    """Runs ``omma ARGUMENTS`` in the current directory: exit code, stdout, stderr.

    How far it is would be told on a slow machine alone.
    """
    monkeypatch.setattr("omma.cli.working.LINE_EVERY_S", 1e6)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["omma", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        return ended.value.code, out, err

    return run


@pytest.fixture
def omma_command(files, monkeypatch, run_omma):
    """Runs ``omma ARGUMENTS`` in the directory of the test files: exit code, stdout, stderr."""
    monkeypatch.chdir(files)
    return run_omma


@pytest.fixture
def fresh(tmp_path):
    """CompoundRay's library under its old name, as a new process finds it."""
    from compoundray_lib import fresh_library

    return fresh_library(tmp_path)


@pytest.fixture
def lib(fresh):
    """The same with the room of tests/compat loaded, and quiet."""
    from compoundray_lib import load_room

    load_room(fresh)
    return fresh


@pytest.fixture
def ground(tmp_path):
    """Of the window's tests: a coloured ground as a file, and an eye as a file beside it."""
    write_gltf(tmp_path / "ground.gltf", cameras=[("bee", None, {"translation": [0, 1.0, 4]})])
    omma.save_eye(tmp_path / "plain.csv", make_eye(40))
    return tmp_path


@pytest.fixture
def looker(ground):
    """The same, ready to be looked through by the window."""
    from omma.view.state import Looker

    world = omma.World(omma.load_scene(ground / "ground.gltf"), threads=1)
    return Looker(world, omma.load_eye(ground / "plain.csv"), threads=1)
