"""The command line as a program: its streams, terminal and names of files."""

import os
import pty
import re
import select
import shutil
import subprocess
import sys
import time

import pytest
from conftest import make_eye

import omma


def test_no_traceback_from_the_installed_command(tmp_path):
    command = shutil.which("omma", path=os.path.dirname(sys.executable))
    if command is None:
        pytest.skip("the command omma is not installed beside this Python")
    done = subprocess.run([command, "info", "no.eye"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr == "omma: error: no.eye: there is no such file\n"


def test_a_closed_pipe_is_no_traceback(files):
    done = subprocess.run(
        f"{sys.executable} -m omma info {files / 'scene.gltf'} | true",
        shell=True,
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""


def run_in_terminal(arguments, enough):
    """Everything that a program writes to its terminal until it ends or ``enough`` says so."""
    try:
        pid, terminal = pty.fork()
    except OSError as error:
        pytest.skip(f"no terminal to be had: {error}")
    if pid == 0:
        os.execv(sys.executable, [sys.executable, "-m", "omma", *map(str, arguments)])
    seen, deadline = "", time.perf_counter() + 20
    try:
        while time.perf_counter() < deadline and not enough(seen):
            if not select.select([terminal], [], [], 0.1)[0]:
                continue
            try:
                data = os.read(terminal, 65536)
            except OSError:  # the other side is closed
                break
            if not data:
                break
            seen += data.decode(errors="replace")
    finally:
        os.kill(pid, 9)
        os.waitpid(pid, 0)
        os.close(terminal)
    return seen


def test_progress_bar_in_a_terminal(files, tmp_path):
    omma.save_eye(tmp_path / "big.eye", make_eye(3000))
    path = tmp_path / "long.csv"
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + "0,1,0,0,0,0\n" * 1000)
    arguments = ["render", files / "scene.gltf", "--eye", tmp_path / "big.eye", "--path", path]
    long = [*arguments, "--samples", 5000, "-o", tmp_path / "a.npy"]
    seen = run_in_terminal(long, lambda text: re.search(r"Rendering.*\d %", text, re.DOTALL))
    assert re.search(r"Rendering.*\d %", seen, re.DOTALL)
    # None on what is quick, and none without a terminal: test_three_outputs_of_one_render.
    quick = ["render", files / "scene.gltf", "--eye", files / "bug.eye", "-o", tmp_path / "b.npy"]
    # On a machine with other work what is quick may take a second, now and then.
    seen = [run_in_terminal(quick, lambda text: False) for _ in range(3)]
    assert all("wrote" in text for text in seen)
    assert any("Rendering" not in text for text in seen)


RENDERED = "render scene.gltf --eye bug.eye --samples 1 -o {0}/a.npy"
NO_SPACE = "omma: error: system: No space left on device\n"


# Each command writes in its own way; what is missing is seen to once for all, before any of them.
@pytest.mark.parametrize(
    ("arguments", "redirected", "code", "says"),
    [
        (RENDERED, "| head -0", None, ""),  # whoever reads has enough
        (RENDERED, "2>&-", 0, None),
        (RENDERED, "<&- >&- 2>&-", 0, ""),
        *(
            (arguments, redirected, code, says)
            for arguments in (
                RENDERED,
                "info scene.gltf",
                "eye info bug.eye",
                "eye species honeybee_worker",
                "eye acceptance bug.eye --degrees 3 -o {0}/a.csv",
                "--help",
            )
            for redirected, code, says in ((">&-", 0, ""), (">/dev/full", 1, NO_SPACE))
        ),
    ],
)
def test_output_that_goes_nowhere(files, tmp_path, arguments, redirected, code, says):
    command = f"'{sys.executable}' -m omma {arguments.format(tmp_path)} {redirected}"
    done = subprocess.run(["bash", "-c", command], cwd=files, capture_output=True, text=True)
    assert "Traceback" not in done.stderr
    assert code in (None, done.returncode)
    assert says in (None, done.stderr)
    assert (done.stdout == "") == (redirected != "2>&-")
    if "-o" in arguments:  # and what was asked for is there
        assert (tmp_path / arguments.split("{0}/")[1]).stat().st_size > 100


def test_a_closed_stream_is_not_written_into_a_file(files, tmp_path):
    """What the first file opened would get is the number of the stream that is missing."""
    command = (
        f"'{sys.executable}' -m omma render scene.gltf --eye bug.eye --samples 1 "
        f"-o {tmp_path}/a.csv -o {tmp_path}/b.csv >&- 2>&-"
    )
    subprocess.run(["bash", "-c", command], cwd=files, check=True)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_names_that_are_no_utf8_in_the_command_line(files, tmp_path):
    name = os.fsencode(tmp_path) + b"/K\xe4fer\n\x1b[31m"
    command = [sys.executable, "-m", "omma", "eye", "acceptance", "bug.eye", "--degrees", "3", "-o"]
    done = subprocess.run([*command, name + b".csv"], cwd=files, capture_output=True, check=True)
    assert os.listdir(os.fsencode(tmp_path)) == [b"K\xe4fer\n\x1b[31m.csv"]
    assert done.stdout.startswith(b"wrote ")
    done = subprocess.run([*command, name + b"/a.csv"], cwd=files, capture_output=True)
    assert done.returncode == 1
    assert rb"K\xe4fer\n\x1b[31m/a.csv: cannot be written" in done.stderr
