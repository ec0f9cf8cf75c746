"""`omma view`: where it says the page is, how it ends, and what it says of bad input."""

import subprocess
import sys

import pytest
from view_checks import ask


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
    assert (program.returncode, err) == (0, "")
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
