"""Ctrl-C ends whatever is going on, and lets other threads run until then.

Each work takes minutes: one that did not listen to Ctrl-C would be killed on the way.
"""

import textwrap

import pytest
from conftest import write_gltf
from oces_builder import OcesFile
from processes import Program

# Says "begun" when another thread has run for a while during the work.
WATCHED = """
import sys, threading, time
import numpy as np
import omma
{setup}
def count():
    for tick in range(20):
        time.sleep(0.01)
    print("begun", flush=True)
threading.Thread(target=count, daemon=True).start()
try:
    {work}
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""

# Where all axes are the same, all others are looked at to find the nearest.
CROWD = """
axes = np.tile([0.0, 0, -1], (300_000, 1))
crowd = omma.Eye(0 * axes, axes, 0.1)
"""
ALL_ROUND = """
axes = np.random.default_rng(0).normal(size=(20_000, 3))
eye = omma.Eye(0 * axes, axes, 0.2)
"""
KNOTS = """
angles = np.linspace(0, 0.2, 1_000_000)
table = omma.Acceptance.table(angles, np.exp(-0.5 * (angles / 0.05) ** 2))
"""
MAPS = """
angles, random = np.linspace(-0.1, 0.1, 40), np.random.default_rng(0)
maps = [omma.Acceptance.table_2d(angles, angles, random.random((40, 40))) for i in range(3000)]
axes = np.tile([0.0, 0, -1], (3000, 1))
"""
RENDER = "renderer.render(np.repeat(np.eye(4)[None], 1000, axis=0))"
RENDERER = ALL_ROUND + "renderer = omma.Renderer(omma.Scene(), eye, {settings})"

WORKS = {
    "interommatidial angles": (CROWD, "crowd.interommatidial_angle_rad()"),
    "a projection": (
        CROWD,
        "omma.picture.projection_ids(crowd, 'spherical_orientationwise', 2000, 1000)",
    ),
    "modulation transfer": (KNOTS, "table.mtf(np.linspace(0, 100, 10_000))"),
    "a large table": (
        KNOTS + "eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], acceptance=table)",
        "[omma.Renderer(omma.Scene(), eye) for again in range(100)]",
    ),
    "widths of many maps": (MAPS, "omma.Eye(axes, axes, acceptance=maps)"),
    "a render": (RENDERER.format(settings="omma.Fixed(65536)"), RENDER),
    "a render with one thread": (RENDERER.format(settings="omma.Fixed(65536), threads=1"), RENDER),
    "a render of random rays": (
        RENDERER.format(settings="omma.Fixed(65536), points='random', threads=2"),
        RENDER,
    ),
    "a render piece by piece": (
        RENDERER.format(settings="omma.Fixed(256)"),
        "for response in renderer.render_iter((np.eye(4) for i in range(100_000)), chunk=8): pass",
    ),
    "shared rays for standard errors": (
        RENDERER.format(settings="omma.Shared(2)"),
        "while True: renderer.with_eye(eye).render(np.eye(4), standard_error=True)",
    ),
    "a design": (
        "",
        "while True: omma.eye.generate_eye(200_000)",
    ),
}


def run_interrupted(setup, work, *arguments):
    """Interrupts ``work`` after a while; it must end with KeyboardInterrupt."""
    text = WATCHED.format(setup=setup, work=textwrap.indent(work, "    ").lstrip())
    with Program(text, *arguments) as program:
        assert program.line() == "begun"
        program.interrupt()
        assert program.end() == (0, "interrupted\n", "")


@pytest.mark.parametrize("name", WORKS)
def test_work_in_memory(name):
    run_interrupted(*WORKS[name])


def test_an_oces_file_of_spheres(tmp_path):
    file = OcesFile()
    diameter = file.coarse(0.01)
    eyes = [
        file.eye("SPHERICAL", {"DIAMETER": diameter}, radius=1, ommatidialCount=200_000)
        for _ in range(10)
    ]
    file.node({"head": True}, children=[file.node({"eye": eye}) for eye in eyes])
    path = file.write(tmp_path / "spheres.gltf")
    run_interrupted("", "omma.load_eye(sys.argv[1])", path)


def test_points_in_a_hit_box(tmp_path):
    mesh = {"name": "ground", "extras": {"hitbox": "true"}}
    mesh["primitives"] = [{"attributes": {"POSITION": 0}, "indices": 2}]
    box = write_gltf(tmp_path / "box.gltf", meshes=[mesh])
    run_interrupted(
        "scene = omma.load_scene(sys.argv[1])\n"
        "points = np.random.default_rng(0).random((20_000_000, 3))",
        "while True: scene.is_inside('ground', points)",
        box,
    )


def test_nothing_goes_on_afterwards_and_the_renderer_still_works():
    text = (
        ALL_ROUND + "renderer = omma.Renderer(omma.Scene(), eye, omma.Fixed(4096))\n"
        "def stop(share):\n"
        "    raise KeyboardInterrupt\n"
        "try:\n"
        "    renderer.render(np.repeat(np.eye(4)[None], 1000, axis=0), progress=stop)\n"
        "except KeyboardInterrupt:\n"
        "    busy = time.process_time()\n"
        "    time.sleep(0.5)\n"
        "    print(time.process_time() - busy)\n"
        "print(renderer.render(np.eye(4)[None][:0]).shape)\n"
    )
    with Program("import time\nimport numpy as np\nimport omma\n" + text) as program:
        # Of 0.5 s on every core; the interpreter itself needs next to nothing asleep.
        assert float(program.line()) < 0.1
        assert program.end() == (0, "(0, 20000, 3)\n", "")
