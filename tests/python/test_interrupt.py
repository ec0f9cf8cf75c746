"""Ctrl-C: a long render ends within a second, and nothing goes on in the background."""

import signal
import subprocess
import sys
import time

import pytest
from processes import Program

PROGRAM = """
import os, sys, time
import numpy as np
import omma

rng = np.random.default_rng(0)
eye = omma.Eye(np.zeros((2000, 3)), rng.normal(size=(2000, 3)), 0.1)
renderer = omma.Renderer(omma.Scene(), eye, omma.Fixed(65536))
poses = np.repeat(np.eye(4)[None], 1000, axis=0)
print("rendering", flush=True)
try:
    renderer.render(poses)
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    busy = time.process_time()
    time.sleep(0.5)
    print("busy for", time.process_time() - busy, flush=True)
    # and the renderer still works
    print("again", renderer.render(np.eye(4)[None][:0]).shape, flush=True)
"""


def test_ctrl_c_stops_a_render():
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout.readline() == "rendering\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "interrupted\n"
        busy = float(process.stdout.readline().removeprefix("busy for"))
        # Of 0.5 s on every core; the interpreter itself needs next to nothing asleep.
        assert busy < 0.1
        assert process.stdout.readline() == "again (0, 2000, 3)\n"
        assert process.wait(timeout=10) == 0
    finally:
        process.kill()
        process.communicate()


def long_render(files, tmp_path, *more):
    """``omma render`` of a path that takes minutes, once it is at work."""
    path = tmp_path / "long.csv"
    rows = "0,1,0,0,0,0\n" * 5000
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + rows)
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "omma", "render", files / "scene.gltf"),
            *("--eye", files / "bug.eye", "--path", path, "--samples", "200000"),
            *("-o", tmp_path / "out.npy", "-o", tmp_path / "out.csv", *more),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.perf_counter() + 60
    while not list(tmp_path.glob(".out.npy*.partial")):  # the temporary file: rendering has begun
        assert time.perf_counter() < deadline
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.02)
    time.sleep(0.3)
    return process


@pytest.mark.parametrize(
    ("number", "says"),
    [
        (signal.SIGINT, "interrupted"),
        (signal.SIGTERM, "interrupted by SIGTERM"),
        (signal.SIGHUP, "interrupted by SIGHUP"),
    ],
)
def test_signals_in_the_command_line(files, tmp_path, number, says):
    process = long_render(files, tmp_path)
    process.send_signal(number)
    out, err = process.communicate(timeout=20)  # against hangs: the render would take an hour
    assert process.returncode == 128 + number
    assert (out, err) == ("", f"omma: error: {says}\n")
    assert [p.name for p in tmp_path.iterdir()] == ["long.csv"]


def test_several_signals_at_once(files, tmp_path):
    process = long_render(files, tmp_path)
    for _ in range(3):
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGINT)
        time.sleep(0.01)
    process.communicate(timeout=20)
    assert process.returncode not in (0, None)
    assert [p.name for p in tmp_path.iterdir()] == ["long.csv"]


def test_what_is_ignored_stays_ignored(files, tmp_path):
    """nohup: the terminal goes, the work goes on."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # children inherit it
    try:
        process = long_render(files, tmp_path)
    finally:
        signal.signal(signal.SIGHUP, before)
    process.send_signal(signal.SIGHUP)
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=20)
    assert process.returncode == 128 + signal.SIGTERM


def test_importing_omma_changes_no_signal():
    program = (
        "import signal, omma, omma.cli.main\n"
        "print([signal.getsignal(s) == signal.SIG_DFL for s in (signal.SIGTERM, signal.SIGHUP)])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "[True, True]\n"


# One block, that is one task of one thread, of 67 million paths in 128 bands.
ONE_BLOCK = """
import numpy as np, omma
light = omma.light.clear_sky(2.0, bands=omma.light.Bands.equal(128))
world = omma.World(omma.load_scene(omma.examples.lit_meadow()), light=light, polarized=True)
eye = omma.species.honeybee_worker().eye.take(np.arange(3000, 3064))
most = omma.ToError(relative_error=1e-9, least=1 << 20, most=1 << 20)
renderer = omma.Renderer(world, eye, most, threads=1)
print("rendering", flush=True)
try:
    renderer.render("bee")
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_ctrl_c_ends_a_long_block():
    with Program(ONE_BLOCK) as program:
        assert program.line() == "rendering"
        time.sleep(2)
        program.interrupt()
        assert program.line() == "interrupted"  # or the program is killed before its block ends
        assert program.end() == (0, "", "")
