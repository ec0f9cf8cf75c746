"""Files that are read are never written over: by whatever option, name or link they come."""

import os
import shutil

import numpy as np
import pytest
from conftest import make_eye, write_gltf

import omma
from omma.base.files import digests_of
from omma.job import render_like
from omma.picture.files import save_png

REPLACE = "would replace what it is made from"
PATH = "x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n0,1,0,5,0,0\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A scene that names pic.png, eye.csv, path.csv, pano.png, and those by other names."""
    monkeypatch.chdir(tmp_path)
    save_png("pic.png", np.full((2, 4, 3), 90, np.uint8))
    shutil.copy("pic.png", "pano.png")
    shutil.copy("pic.png", "pano_0001.png")
    write_gltf(
        "scene.gltf",
        cameras=[("pic", None, {"translation": [0, 1, 0]})],
        images=[{"uri": "pic.png"}],
        textures=[{"source": 0}],
    )
    omma.save_eye("eye.csv", make_eye(12))
    (tmp_path / "path.csv").write_text(PATH)
    os.symlink("eye.csv", "link.csv")
    os.symlink(tmp_path, "again")
    os.link("eye.csv", "hard.csv")
    return tmp_path


def contents(folder):
    return {one.name: one.read_bytes() for one in folder.iterdir() if one.is_file()}


RENDER = ["render", "scene.gltf", "--eye", "eye.csv", "--samples", "1"]
COMMANDS = [
    ([*RENDER, "-o", "eye.csv"], "eye.csv: " + REPLACE),
    ([*RENDER, "-o", "new.npy", "-o", "eye.csv"], "eye.csv: " + REPLACE),
    ([*RENDER, "-o", "link.csv"], "link.csv: " + REPLACE),
    ([*RENDER, "-o", "hard.csv"], "hard.csv: " + REPLACE),
    ([*RENDER, "-o", "again/eye.csv"], REPLACE),
    ([*RENDER, "--path", "path.csv", "-o", "path.csv"], "path.csv: " + REPLACE),
    ([*RENDER, "--path", "path.csv", "-o", "eye.csv"], "eye.csv: " + REPLACE),
    ([*RENDER, "--background", "pano.png", "-o", "pano.png"], "pano.png: " + REPLACE),
    ([*RENDER, "-o", "pic.png"], "pic.png: " + REPLACE),
    (
        [*RENDER, "--path", "path.csv", "--background", "pano_0001.png", "-o", "pano.png"],
        "pano_0001.png: " + REPLACE,
    ),
    ([*RENDER, "-o", "new.csv", "-o", "again/new.csv"], "new.csv: is an output twice"),
    (["render-cameras", "scene.gltf", "--width", "8", "--samples", "1", "-o", "."], REPLACE),
    (["eye", "acceptance", "eye.csv", "--degrees", "3", "-o", "eye.csv"], "eye.csv: " + REPLACE),
    (["eye", "convert", "eye.csv", "-o", "link.csv"], "link.csv: " + REPLACE),
    (["eye", "split", "eye.csv", "--left", "eye.csv"], "eye.csv: " + REPLACE),
    (["eye", "split", "eye.csv", "-o", "n.csv", "--left", "n.csv"], "n.csv: is an output twice"),
    (["eye", "info", "eye.csv", "-o", "eye.csv"], "eye.csv: " + REPLACE),
    (["eye", "join", "eye.csv", "link.csv", "-o", "hard.csv"], "hard.csv: " + REPLACE),
    (
        ["measure", "speed", "scene.gltf", "--eye", "eye.csv", "--frames", "1", "-o", "eye.csv"],
        "eye.csv: " + REPLACE,
    ),
]


@pytest.mark.parametrize(("arguments", "words"), COMMANDS)
def test_commands_keep_what_they_read(folder, run_omma, arguments, words):
    before = contents(folder)
    code, _, err = run_omma(*arguments)
    assert code == 1
    assert words in err
    assert contents(folder) == before


def test_render_file_and_render_like_keep_what_they_read(folder):
    one = omma.Fixed(1)
    with pytest.raises(omma.Error, match=f"eye.csv: {REPLACE}"):
        omma.render_file("scene.gltf", "eye.csv", one, eyes="eye.csv", position=(0, 1, 0))
    omma.render_file("scene.gltf", "r.npy", one, eyes="eye.csv", position=(0, 1, 0))
    before = contents(folder)
    with pytest.raises(omma.Error, match=f"r.npy: {REPLACE}"):
        render_like("r.npy", ["s.csv", "r.npy"])
    with pytest.raises(omma.Error, match=f"eye.csv: {REPLACE}"):
        render_like("r.npy", "eye.csv")
    assert contents(folder) == before


def test_what_is_read_by_nobody_is_replaced(folder, run_omma):
    for _ in range(2):
        code, _, err = run_omma(*RENDER, "--path", "path.csv", "-o", "new.csv", "-o", "pano.png")
        assert (code, err) == (0, "")
    assert (folder / "pano_0000.png").exists()


@pytest.fixture
def meshes(folder):
    """A mesh of each kind that names files, some of which have spaces in their names."""
    for name in ("a picture.png", "cut.png", "bumps.png", "ply.png"):
        shutil.copy("pic.png", name)
    corners = [(-1, 0, -3), (1, 0, -3), (0, 2, -3)]
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
    (folder / "leaf.obj").write_text(f"mtllib \\\n some leaf.mtl\n{rows}usemtl a\nf 1 2 3\n")
    (folder / "some leaf.mtl").write_text(
        "newmtl a\nmap_Kd -s 1 1 1 a picture.png\nmap_d cut.png\n\tbump -bm 2 bumps.png\n"
    )
    (folder / "leaf.ply").write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile ply.png\nelement vertex 3\n"
        "property float x\nproperty float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
        + "".join(f"{x} {y} {z}\n" for x, y, z in corners)
        + "3 0 1 2\n"
    )
    return folder


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("leaf.obj", ["some leaf.mtl", "a picture.png", "cut.png", "bumps.png"]),
        ("leaf.ply", ["ply.png"]),
    ],
)
def test_what_meshes_name_is_kept(meshes, scene, names):
    """Pictures under names that commands write, and materials, in whose place some might be."""
    one = omma.Fixed(1)
    before = contents(meshes)
    for name in names:
        output = name
        if name.endswith(".mtl"):
            os.symlink(name, "out.png")
            output = "out.png"
        with pytest.raises(omma.Error, match=f"{output}: {REPLACE}"):
            omma.render_file(scene, output, one, eyes="eye.csv", position=(0, 1, 0))
    assert set(digests_of(scene)) == {scene, *names}
    assert contents(meshes).items() >= before.items()


def test_a_picture_of_a_mesh_that_changed_is_not_rendered_again(meshes):
    pytest.importorskip("tinyobjloader")
    given = {"eyes": "eye.csv", "position": (0, 1, 0)}
    omma.render_file("leaf.obj", "r.npy", omma.Fixed(1), **given)
    render_like("r.npy", "again.npy")
    save_png("a picture.png", np.full((2, 4, 3), 20, np.uint8))
    with pytest.raises(omma.Error, match=r"a picture\.png: is not what"):
        render_like("r.npy", "again.npy")
