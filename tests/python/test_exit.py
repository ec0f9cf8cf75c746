"""Python ends while threads are at work in the engine: cleanly, and at once."""

import contextlib
import signal
import subprocess
import sys

import pytest
from processes import PATIENCE_S, Program

# How often: what could go wrong depends on what each thread does at the moment.
TIMES = 20

SETUP = """
import atexit, sys, threading, time
joined = []  # at exit, after all that omma does there
atexit.register(lambda: [thread.join() for thread in joined])
import numpy as np
import omma
axes = np.random.default_rng(0).normal(size=(2000, 3))
eye = omma.Eye(0 * axes, axes, 0.1)
poses = np.repeat(np.eye(4)[None], 10_000, axis=0)
renderer = omma.Renderer(omma.Scene(), eye, omma.Fixed(1024), threads=1)
out = np.zeros((10_000, 2000, 3), np.float32)
begun = threading.Event()
def render(progress=None):
    begun.set()
    renderer.render(poses, out=out, progress=progress)
def told(share):
    begun.set()
def build():
    begun.set()
    while True:
        omma.Renderer(omma.Scene(), eye, omma.Fixed(256), threads=1)
def measure():
    crowd = omma.Eye(np.zeros((100_000, 3)), np.tile([0.0, 0, -1], (100_000, 1)), 0.1)
    begun.set()
    while True:
        crowd.interommatidial_angle_rad()
def start(*work, daemon=True):
    thread = threading.Thread(target=work[0], args=work[1:], daemon=daemon)
    thread.start()
    begun.wait()
    time.sleep(float(sys.argv[1]))
    return thread
"""

ENDS = {
    "rendering": "start(render)",
    "rendering with a callback": "start(render, told)",
    "building": "start(build)",
    "measuring": "start(measure)",
    "two of them": "start(render, told); start(build)",
    "by sys.exit": "start(render); sys.exit(0)",
    "joined at exit": "joined.append(start(render))",
    "a callback that waits": "start(render, lambda done: (begun.set(), threading.Event().wait()))",
}


@pytest.mark.parametrize("name", ENDS)
def test_python_ends_while_a_daemon_thread_works(name):
    """Moments from 0 to 0.3 s after the work began."""
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", SETUP + ENDS[name], str(0.015 * i)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for i in range(TIMES)
    ]  # fmt: skip
    try:
        ends = [process.communicate(timeout=PATIENCE_S) for process in processes]
    finally:
        for process in processes:
            process.kill()
    codes = [process.returncode for process in processes]
    assert list(zip(codes, ends, strict=True)) == [(0, ("", ""))] * TIMES


@pytest.mark.parametrize("daemon", [True, False])
def test_ctrl_c_while_the_main_thread_waits_for_another(daemon):
    """A daemon thread's work is given up; any other's goes on until Ctrl-C comes once more."""
    text = SETUP + (
        f"thread = start(render, daemon={daemon})\n"
        "try:\n"
        "    print('begun', flush=True)\n"
        "    thread.join()\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
        "    time.sleep(0.1)\n"
    )
    for i in range(TIMES):
        with Program(text, 0.01 * i) as program:
            assert program.line() == "begun"
            program.interrupt()
            assert program.line() == "interrupted"
            if not daemon:
                # Python waits for the thread now, in threading._shutdown.
                while program.process.poll() is None:
                    program.interrupt()
                    with contextlib.suppress(subprocess.TimeoutExpired):
                        program.process.wait(0.2)
            code, out, err = program.end()
            assert out == ""
            if daemon:
                assert (code, err) == (0, "")
            else:
                # Where Python is when Ctrl-C comes decides what it says; it must not abort.
                assert code in (0, 1, -signal.SIGINT)
