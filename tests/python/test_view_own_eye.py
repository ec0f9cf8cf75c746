"""The window with the eye that a camera of the scene names: the same as `omma render` takes."""

import shlex

import numpy as np
import pytest
from conftest import make_eye, write_gltf

import omma
from omma.view.command import Sources, render_command, render_python
from omma.view.own_eye import own_eye
from omma.view.poses import pose_from_matrix
from omma.view.state import Look, Looker
from omma.view.window import _files_of

EYED = {"compound-eye": True, "compound-structure": "bug.eye"}


@pytest.fixture
def arena(tmp_path):
    """A scene with a camera that names no eye, one that does, and one that is twice as large."""
    cameras = [
        ("plain", None, {"translation": [5, 1.0, 4]}),
        ("bug", EYED, {"translation": [0, 1.0, 4]}),
        ("large", EYED, {"translation": [2, 1.0, 4], "scale": [2, 2, 2]}),
        ("flat", EYED, {"scale": [1, 1, 2]}),
    ]
    write_gltf(tmp_path / "arena.gltf", cameras=cameras)
    eye = make_eye(40)
    # As far from the head's middle as the ground is: a camera's scale is then seen.
    omma.save_eye(tmp_path / "bug.eye", eye.replace(position_m=0.4 * eye.axis), "m")
    return tmp_path


@pytest.mark.parametrize("camera", [None, "bug", "large"])
def test_the_eye_of_the_camera_sees_what_omma_render_gives(arena, run_omma, monkeypatch, camera):
    monkeypatch.chdir(arena)
    scene = omma.load_scene("arena.gltf")
    eye, node, unit = own_eye(scene, camera)
    assert node.name == (camera or "bug")
    seen = Looker(omma.World(scene), eye).see(
        Look(pose_from_matrix(node.world_from_camera), samples=4)
    )
    words = [] if camera is None else ["--camera", camera]
    assert run_omma("render", "arena.gltf", *words, "--samples", 4, "-o", "own.npy")[0] == 0
    # The camera's scale is applied in double precision here, and to what was rounded there.
    assert np.allclose(np.load("own.npy")[0], seen.responses, atol=2e-6)
    sources = Sources("arena.gltf", (eye.path,), unit)
    command, why = render_command(sources, seen)
    assert why is None
    for line in command.splitlines():
        assert run_omma(*shlex.split(line)[1:])[0] == 0
    assert np.array_equal(np.load("view.npy")[0], seen.responses)
    names = {}
    exec(render_python(sources, seen), names)
    assert np.array_equal(names["responses"][0], seen.responses)


def test_a_window_needs_no_eye(arena):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    scene = omma.load_scene(arena / "arena.gltf")
    with omma.view.show(scene, port=0) as window:
        assert window.look.pose.position_m == (0, 1.0, 4.0)
        assert window._page.sources.eyes[0].endswith("bug.eye")
        assert window._page.sources.unit == "m"
    assert _files_of(omma.World(scene), [own_eye(scene)[0]], "mm") == Sources()


def test_a_camera_without_an_eye_is_said(arena):
    scene = omma.load_scene(arena / "arena.gltf")
    with pytest.raises(omma.Error, match=r"not the camera 'plain' of .*arena\.gltf names one"):
        own_eye(scene, "plain")
    with pytest.raises(omma.Error, match="'flat' stretches its eye by"):
        own_eye(scene, "flat")
    with pytest.raises(omma.Error, match="no camera of the scene names"):
        own_eye(omma.Scene())
