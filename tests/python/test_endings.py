"""Whoever writes a file knows its ending, or says which there are, before any work is done."""

import numpy as np
import pytest
from conftest import make_eye

import omma


@pytest.mark.parametrize("name", ["a.foo", "a", "a.eye.txt", "a.npy"])
def test_eyes(tmp_path, name):
    expected = r"expected a name ending in \.csv, \.gltf, \.glb or \.eye"
    with pytest.raises(omma.Error, match=expected):
        omma.save_eye(tmp_path / name, make_eye())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a.foo", "a", "a.jpg"])
def test_other_writers(tmp_path, name, renderer):
    path = tmp_path / name
    eye = make_eye()
    responses = np.zeros((1, 60, 3), np.float32)
    measures = omma.eye.measure_eye(eye)
    writers = [
        lambda: omma.save_png(path, np.zeros((2, 2, 3), np.uint8)),
        lambda: omma.save_responses(path, responses, eye),
        lambda: omma.eye.save_eye_table(path, eye, measures),
        lambda: omma.study.save_variance_map(path, np.zeros((4, 4)), (0, 0, 0), 1.0),
    ]
    for write in writers:
        with pytest.raises(omma.Error, match="expected a name ending in"):
            write()
    assert list(tmp_path.iterdir()) == []


COMMANDS = [
    "render scene.gltf --eye bug.eye -o x.foo",
    "render scene.gltf --camera plain -o x.foo",
    "render-again out.npy -o x.foo",
    "eye make 50 -o x.foo",
    "eye mirror bug.eye -o x.foo",
    "eye place bug.eye -o x.foo",
    "eye scale bug.eye --factor 2 -o x.foo",
    "eye join bug.eye left.eye -o x.foo",
    "eye split bug.eye -o x.foo",
    "eye split bug.eye --left x.foo",
    "eye split bug.eye --right x.foo",
    "eye acceptance bug.eye --degrees 2 -o x.foo",
    "eye convert bug.eye -o x.foo",
    "eye species holcocephala -o x.foo",
    "eye species holcocephala --facts x.foo",
    "eye info bug.eye -o x.foo",
    "eye info bug.eye --json x.foo",
    "eye info bug.eye --map x.foo",
    "eye plot bug.eye -o x.foo",
    "eye draw bug.eye -o x.foo",
    "measure min-samples scene.gltf --eye bug.eye -o x.foo",
    "measure variance-map scene.gltf --centre 0 1 0 --size 1 -o x.foo",
    "measure aliasing scene.gltf --eye bug.eye -o x.foo",
    "measure speed scene.gltf --eye bug.eye -o x.foo",
]


@pytest.mark.parametrize("command", COMMANDS)
def test_commands(command, files, tmp_path, monkeypatch, run_omma):
    for name in ("scene.gltf", "bug.eye", "left.eye"):
        (tmp_path / name).symlink_to(files / name)
    monkeypatch.chdir(tmp_path)
    if "render-again" in command:
        pytest.importorskip("xarray")
        omma.render_file("scene.gltf", "out.npy", omma.Fixed(1), eyes="bug.eye")
    before = sorted(tmp_path.iterdir())
    code, _, err = run_omma(*command.split())
    assert code == 1
    assert "x.foo: expected a name ending in ." in err
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", ["job.py", "model.fbx", "thing"])
def test_what_no_scene_is_called_is_told_the_endings(tmp_path, name):
    path = tmp_path / name
    path.write_text("import omma\n")
    with pytest.raises(omma.Error, match=r"\.gltf, \.glb, \.obj.*\.spz.*\.las"):
        omma.load_scene(path)
    # A scene by another name is one.
    omma.scene.save_scene(tmp_path / "box.glb", omma.scene.box())
    (tmp_path / "box.glb").rename(path)
    assert omma.load_scene(path).triangle_count == 12
