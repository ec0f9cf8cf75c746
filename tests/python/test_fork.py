"""A process made by fork renders with what it inherits, alone; what it cannot do it refuses."""

import pytest
from processes import Program

# A fork while other threads are in the engine; ``child()`` is run in each child, which says what it
# returned by its exit code (0: True).
SETUP = """
import os, signal, sys, threading, time
import numpy as np
import omma
axes = np.random.default_rng(0).normal(size=(500, 3))
eye = omma.Eye(1e-3 * axes, axes, 0.3)
scene = omma.load_scene(sys.argv[1])
poses = np.repeat(np.eye(4)[None], 3, axis=0)
poses[:, 1, 3] = 1, 2, 3
renderer = omma.Renderer(scene, eye)
sharing = omma.Renderer(scene, eye, omma.Shared(8))
expected = renderer.render(poses, standard_error=True)
over = threading.Event()
def work(call):
    while not over.is_set():
        call()
def forked(child, times, *busy):
    threads = [threading.Thread(target=work, args=(call,)) for call in busy]
    for thread in threads:
        thread.start()
    codes = []
    for again in range(times):
        time.sleep(0.003 * again)
        pid = os.fork()
        if pid == 0:
            signal.alarm(60)  # which ends a child that hangs
            code = 1
            try:
                code = 0 if child() else 2
            finally:
                os._exit(code)
        codes.append(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
    over.set()
    for thread in threads:
        thread.join()
    print(codes, flush=True)
def same(one, other):
    return all((a == b).all() for a, b in zip(one, other, strict=True))
def large_render():
    renderer.render(np.repeat(poses, 100, axis=0))
def refused(call):
    try:
        call()
    except omma.Error as error:
        return "'spawn' or 'forkserver'" in str(error)
"""

CHILDREN = {
    "the same renderer": (
        "lambda: same(renderer.render(poses, standard_error=True), expected)",
        "large_render, large_render",
    ),
    "with one thread": (
        "lambda: same(single.render(poses, standard_error=True), expected)",
        "lambda: single.render(np.repeat(poses, 100, axis=0))",
    ),
    "another eye": (
        "lambda: same(renderer.with_eye(eye).render(poses, standard_error=True), expected)",
        "large_render, lambda: renderer.with_eye(eye)",
    ),
    "shared rays, never used before": (
        "lambda: same(sharing.render(poses, standard_error=True), shared)",
        "lambda: sharing.with_eye(eye).render(poses, standard_error=True)",
    ),
    "a picture": (
        "lambda: (omma.render_camera(renderer, 'plain', width=80) == picture).all()",
        "lambda: omma.render_camera(renderer, 'plain', width=400)",
    ),
    "loading": (
        "lambda: omma.load_scene(sys.argv[1]).triangle_count == 2",
        "large_render, lambda: omma.load_scene(sys.argv[1])",
    ),
    "tools": (
        "lambda: same([eye.interommatidial_angle_rad(), "
        "omma.picture.projection_ids(eye, width=300)], measured)",
        "large_render, eye.interommatidial_angle_rad",
    ),
    "elliptical ommatidia": (
        "lambda: renderer.with_eye(oval).render(poses).shape == (3, 500, 3)",
        "large_render, lambda: omma.Renderer(scene, oval)",
    ),
    "building": (
        "lambda: refused(lambda: omma.Renderer(scene, eye))",
        "large_render, lambda: omma.Renderer(scene, eye)",
    ),
}
MADE = """
single = omma.Renderer(scene, eye, threads=1)
shared = omma.Renderer(scene, eye, omma.Shared(8)).render(poses, standard_error=True)
picture = omma.render_camera(renderer, "plain", width=80)
measured = [eye.interommatidial_angle_rad(), omma.picture.projection_ids(eye, width=300)]
oval = eye.replace(acceptance=omma.Acceptance.gaussian(0.2, 0.1))
"""


@pytest.mark.parametrize("name", CHILDREN)
def test_fork_while_others_work(files, name):
    child, busy = CHILDREN[name]
    with Program(SETUP + MADE + f"forked({child}, 10, {busy})", files / "scene.gltf") as program:
        assert program.end() == (0, str([0] * 10) + "\n", "")


def test_children_that_end_as_python_does(files):
    """They leave by exit(), which frees what they inherited and what they made."""
    text = SETUP + (
        "pid = os.fork()\n"
        "if pid == 0:\n"
        "    signal.alarm(60)\n"
        "    other = renderer.with_eye(eye)\n"
        "    print(same(other.render(poses, standard_error=True), expected), flush=True)\n"
        "    del renderer\n"
        "    sys.exit(7)\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))\n"
    )
    with Program(text, files / "scene.gltf") as program:
        assert program.end() == (0, "True\n7\n", "")


def test_children_that_end_as_python_does_while_others_start_threads(files):
    """The destructor of oneTBB waited for a lock which one of the others had held: 1 of 10 hung."""
    text = SETUP + (
        "make = lambda: renderer.with_eye(eye).render(poses)\n"
        "threads = [threading.Thread(target=work, args=(make,), daemon=True) for _ in range(3)]\n"
        "for thread in threads:\n"
        "    thread.start()\n"
        "codes = []\n"
        "for _ in range(60):\n"
        "    time.sleep(0.003)\n"
        "    pid = os.fork()\n"
        "    if pid == 0:\n"
        "        signal.alarm(60)\n"
        "        print(same(renderer.render(poses, standard_error=True), expected))\n"
        "        sys.exit(7)\n"
        "    codes.append(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))\n"
        "    if codes[-1] != 7:\n"
        "        break\n"
        "over.set()\n"
        "for thread in threads:\n"
        "    thread.join()\n"
        "print(codes)\n"
    )
    with Program(text, files / "scene.gltf") as program:
        assert program.end() == (0, 60 * "True\n" + f"{60 * [7]}\n", "")


def test_a_pool_of_forked_processes(files):
    text = SETUP + (
        "import multiprocessing\n"
        "def one(pose):\n"
        "    return renderer.render(poses[pose], first_pose=pose, standard_error=True)\n"
        "with multiprocessing.get_context('fork').Pool(3) as pool:\n"
        "    found = pool.map(one, range(3))\n"
        "print(all(same(a, [b[i : i + 1] for b in expected]) for i, a in enumerate(found)))\n"
    )
    with Program(text, files / "scene.gltf") as program:
        assert program.end() == (0, "True\n", "")


def test_a_fork_before_threads_are_used_changes_nothing(files):
    text = (
        "import os, sys\n"
        "import numpy as np\n"
        "import omma\n"
        "if os.fork() == 0:\n"
        "    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1)\n"
        "    renderer = omma.Renderer(omma.load_scene(sys.argv[1]), eye, threads=3)\n"
        "    print(renderer.threads, renderer.render(np.eye(4)).shape, flush=True)\n"
        "    os._exit(0)\n"
        "os.wait()\n"
    )
    with Program(text, files / "scene.gltf") as program:
        assert program.end() == (0, "3 (1, 1, 3)\n", "")


def test_a_fork_from_a_progress_callback(files):
    """The child goes on with the render that it was forked from."""
    text = SETUP + (
        "children = []\n"
        "def fork_once(fraction):\n"
        "    if not children:\n"
        "        children.append(os.fork())\n"
        "        if children[0] == 0:\n"
        "            signal.alarm(60)\n"
        "many = np.repeat(poses, 1000, axis=0)\n"
        "whole = renderer.render(many)\n"
        "result = renderer.render(many, progress=fork_once)\n"
        "if children[0] == 0:\n"
        "    os._exit(0 if (result == whole).all() else 2)\n"
        "print((result == whole).all(), os.wait()[1])\n"
    )
    with Program(text, files / "scene.gltf") as program:
        assert program.end() == (0, "True 0\n", "")
