"""`omma view`: where it says the page is, how it ends, and what it says of bad input."""

import shlex
import subprocess
import sys

import numpy as np
import pytest
from view_checks import ask

import omma
from omma.cli import view as view_command
from omma.view.command import render_command, render_python
from omma.view.poses import HeadPose
from omma.view.state import Look, Looker


def test_the_command_says_where_and_ends_with_ctrl_c(ground):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    words = [sys.executable, "-m", "omma", "view", "ground.gltf", "--eye", "plain.csv",
             "--no-browser", "--port", "0"]  # fmt: skip
    with subprocess.Popen(
        words, cwd=ground, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as program:
        try:
            url = program.stdout.readline().strip()
            port, path = url.removeprefix("http://127.0.0.1:").split("/", 1)
            status = ask(port, f"/{path}")[0]
        finally:
            program.send_signal(2)
        out, err = program.communicate(timeout=60)
    assert status == 200
    assert program.returncode == 0
    # A slow machine may say that it prepares the page; of ending there is nothing to say.
    assert all(line.startswith("omma: Preparing the page: ") for line in err.splitlines())
    assert "viser" not in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing.gltf", "--eye", "plain.csv"], "nothing.gltf"),
        (["ground.gltf", "--eye", "nothing.csv"], "nothing.csv"),
        (["ground.gltf", "--eye", "empty.csv"], "empty.csv"),
        (["ground.gltf", "--eye", "plain.csv", "--camera", "x"], "camera"),
        (["ground.gltf", "--eye", "plain.csv", "--look-at", "0", "0", "0"], "--look-at"),
        (["ground.gltf", "--eye", "plain.csv", "--host", "no.such.invalid"], "--host"),
        (["ground.gltf"], "no camera of ground.gltf names one"),
        (["ground.gltf", "--camera", "bee"], "not the camera 'bee'"),
        (["ground.gltf", "--eye", "plain.csv", "--proxy", "lab.example"], "--proxy"),
    ],
)
def test_the_command_says_what_is_wrong(ground, run_omma, monkeypatch, words, said):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    monkeypatch.chdir(ground)
    header = (ground / "plain.csv").read_text().splitlines()[0]
    (ground / "empty.csv").write_text(header + "\n")
    code, _, err = run_omma("view", *words, "--no-browser", "--port", "0")
    assert code != 0
    assert err.count("\n") == 1
    assert said in err


def test_unit_and_up_of_a_mesh_are_those_of_render(ground, run_omma, monkeypatch):
    pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
    monkeypatch.chdir(ground)
    # A wall of 2 m in millimetres, upright where z is up.
    corners = "v -1000 0 0\nv 1000 0 0\nv 1000 0 2000\nv -1000 0 2000\n"
    (ground / "wall.obj").write_text(f"{corners}f 1 2 3 4\nf 4 3 2 1\n")
    opened = []

    def open_window(world, eye, sources, _):
        opened.append((world, eye, sources))
        raise omma.Error("seen enough")

    monkeypatch.setattr(view_command, "open_window", open_window)
    words = ["--scene-unit", "mm", "--scene-up", "z", "--eye", "plain.csv", "--no-browser"]
    assert run_omma("view", "wall.obj", *words)[0] == 1
    world, eye, sources = opened[0]
    assert world.scene == omma.load_scene("wall.obj", unit="mm", up="z")
    pose = HeadPose((0.0, 1.0, 3.0), 0.0, 0.0, 0.0)
    seen = Looker(world, eye).see(Look(pose, samples=4))
    assert len(np.unique(seen.responses, axis=0)) > 1  # the wall and what is beside it
    command, why = render_command(sources, seen)
    assert why is None
    assert run_omma(*shlex.split(command.splitlines()[-1])[1:])[0] == 0
    assert np.array_equal(np.load("view.npy")[0], seen.responses)
    names = {}
    exec(render_python(sources, seen), names)
    assert np.array_equal(names["responses"][0], seen.responses)
