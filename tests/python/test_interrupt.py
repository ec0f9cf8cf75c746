"""Ctrl-C: a long render ends within a second, and nothing goes on in the background."""

import signal
import subprocess
import sys
import time

PROGRAM = """
import os, sys, time
import numpy as np
import omma

rng = np.random.default_rng(0)
eye = omma.Eye(np.zeros((2000, 3)), rng.normal(size=(2000, 3)), 0.1)
renderer = omma.Renderer(omma.Scene(), eye, samples=65536)
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
        sent = time.perf_counter()
        assert process.stdout.readline() == "interrupted\n"
        assert time.perf_counter() - sent < 1.0
        busy = float(process.stdout.readline().removeprefix("busy for"))
        # Of 0.5 s on every core; the interpreter itself needs next to nothing asleep.
        assert busy < 0.1
        assert process.stdout.readline() == "again (0, 2000, 3)\n"
        assert process.wait(timeout=10) == 0
    finally:
        process.kill()
        process.communicate()


def test_ctrl_c_in_the_command_line(files, tmp_path):
    path = tmp_path / "long.csv"
    rows = "0,1,0,0,0,0\n" * 5000
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + rows)
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "omma", "render", files / "scene.gltf"),
            *("--eye", files / "bug.eye", "--path", path, "--samples", "200000"),
            *("-o", tmp_path / "out.npy", "-o", tmp_path / "out.csv"),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.perf_counter() + 20
    while not list(tmp_path.glob(".out*.npy")):  # the temporary file: rendering has begun
        assert time.perf_counter() < deadline
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.02)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    sent = time.perf_counter()
    out, err = process.communicate(timeout=20)
    # A second for the render, and some for the interpreter to go down.
    assert time.perf_counter() - sent < 2.0
    assert process.returncode == 130
    assert (out, err) == ("", "omma: error: interrupted\n")
    assert [p.name for p in tmp_path.iterdir()] == ["long.csv"]
