"""Worlds: what is moved is seen there, by all who see it; what cannot be moved says why."""

import threading

import numpy as np
import pytest
from conftest import make_eye, write_gltf
from processes import Program

import omma


def moved_by(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


@pytest.fixture
def grounds(tmp_path):
    """Three grounds of the same mesh, one above the other: "low", "high", "high"."""
    path = write_gltf(tmp_path / "grounds.gltf", cameras=[("cam", None, {})])
    nodes = [
        {"name": "low", "mesh": 0, "translation": [0, -2, 0]},
        {"name": "high", "mesh": 0, "translation": [0, 200, 0]},
        {"name": "high", "mesh": 0, "translation": [0, 300, 0]},
        {"name": "cam", "camera": 0, "translation": [0, 0, 5]},
    ]
    scenes = [{"name": "main", "nodes": [0, 1, 2, 3]}]
    return omma.load_scene(
        write_gltf(path, cameras=[("cam", None, {})], nodes=nodes, scenes=scenes)
    )


@pytest.fixture
def down():
    """A single ray down from the origin."""
    return omma.Eye([[0, 0, 0]], [[0, -1, 0]], 0.0)


def test_things_are_listed_and_found(grounds):
    world = omma.World(grounds)
    assert world.scene is grounds
    assert [one.name for one in world.instances] == ["low", "high", "high"]
    assert np.array_equal(world.instances[0].world_from_node, moved_by(y=-2))
    assert world.index("low") == 0
    with pytest.raises(omma.Error, match='2 things are called "high": 1, 2'):
        world.index("high")
    with pytest.raises(omma.Error, match='nothing called "lwo" to move; nearest to it are "low"'):
        world.index("lwo")
    assert "3 things" in repr(world)
    assert world.backend == omma.World(grounds, backend="embree").backend
    assert set(world.build_times) == {"scene_s", "acceleration_s"}


def test_what_moves_is_seen_there_by_all(grounds, down):
    world = omma.World(grounds, background=omma.Background.constant((0, 0, 0)))
    one = omma.Renderer(world, down, omma.Fixed(1))
    other = one.with_eye(down)
    white = omma.Renderer(world, down, background=omma.Background.constant((9, 9, 9)))
    assert one.world is world
    assert other.world is world
    assert one.scene is grounds
    on_it = one.render(np.eye(4))
    world.set_transforms("low", moved_by(x=100))
    assert (one.render(np.eye(4)) == 0).all()
    assert (other.render(np.eye(4)) == 0).all()
    assert (white.render(np.eye(4)) == 9).all()
    world.set_transforms([1, "low"], [moved_by(y=-1), moved_by(x=200)])
    assert np.allclose(one.render(np.eye(4)), on_it, atol=1e-6)  # the same mesh
    assert np.array_equal(white.render(np.eye(4)), one.render(np.eye(4)))
    assert np.array_equal(world.instances[0].world_from_node, moved_by(x=200))
    world.set_transforms(np.array([1]), np.diag([-1.0, 1, 1, 1]) @ moved_by(y=-1))
    assert (one.render(np.eye(4)) > 0).any()


def test_a_moved_world_is_one_built_there(grounds, tmp_path, flight):
    eye = make_eye(300, acceptance_deg=8)
    world = omma.World(grounds)
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    turn = omma.poses_from_angles((0.5, -1, 0.25), (20, 10, 5))[0]
    world.set_transforms([2], turn)
    nodes = [
        {"mesh": 0, "translation": [0, -2, 0]},
        {"mesh": 0, "translation": [0, 200, 0]},
        {"mesh": 0, "matrix": turn.T.ravel().tolist()},
    ]
    path = write_gltf(tmp_path / "built.gltf", nodes=nodes, scenes=[{"nodes": [0, 1, 2]}])
    built = omma.Renderer(omma.load_scene(path), eye, omma.Fixed(4)).render(flight)
    # Single precision, but for a ray in a thousand that passes an edge.
    assert (np.abs(renderer.render(flight) - built) > 1e-4).mean() < 1e-3


def test_pictures_are_of_the_world(grounds):
    world = omma.World(grounds, background=omma.Background.constant((0, 0, 0)))
    renderer = omma.Renderer(world, make_eye(3))
    before = omma.render_camera(world, "cam", width=60, samples=2)
    assert np.array_equal(before, omma.render_camera(grounds, "cam", width=60, samples=2,
                          background=omma.Background.constant((0, 0, 0))))  # fmt: skip
    world.set_transforms(["low"], [moved_by(x=500)])
    assert (omma.render_camera(renderer, "cam", width=60, samples=2) == 0).all()
    world.set_transforms(["low"], [moved_by(y=-2)])
    again = omma.render_camera(world, "cam", width=60, samples=2)
    assert (np.abs(again - before) > 1e-4).mean() < 1e-3
    with pytest.raises(omma.Error, match="the world that is given has its own"):
        omma.render_camera(world, "cam", threads=2)


def test_what_cannot_be_moved_says_why(grounds, down):
    world = omma.World(grounds)
    renderer = omma.Renderer(world, down, omma.Fixed(1))
    world.set_transforms("low", moved_by(y=-3))
    before = renderer.render(np.eye(4))
    flat = np.diag([1.0, 0, 1, 1])
    wrong = {
        "instances\\[0\\]: expected an index into the 3": (3, np.eye(4)),
        "is there twice": ([0, 0], [np.eye(4)] * 2),
        'transforms\\[0\\], of "low": expected a finite': (0, np.full((4, 4), np.nan)),
        "without an inverse": ([1, 0], [np.eye(4), flat]),
        "expected shape \\(2, 4, 4\\), found \\(1, 4, 4\\)": ([0, 1], [np.eye(4)]),
        "expected shape \\(1, 4, 4\\), found \\(3, 4\\)": (0, np.eye(4)[:3]),
        "1e\\+12 m": (0, moved_by(x=1e13)),
        "instances\\[0\\]: expected 0 to": (-1, np.eye(4)),
    }
    for message, (instances, transforms) in wrong.items():
        with pytest.raises(omma.Error, match=message):
            world.set_transforms(instances, transforms)
        assert np.array_equal(renderer.render(np.eye(4)), before)
    with pytest.raises(TypeError, match="whole number"):
        world.set_transforms(1.5, np.eye(4))
    with pytest.raises(TypeError, match="scene: expected omma"):
        omma.World("meadow.glb")
    with pytest.raises(omma.Error, match=r'backend: .* \(embree, portable.*\), found "metal"'):
        omma.World(grounds, backend="metal")


def test_frames_and_moves_take_turns(grounds):
    world = omma.World(grounds)
    renderer = omma.Renderer(world, make_eye(200), omma.Fixed(16))
    found = []

    def move(fraction):
        with pytest.raises(omma.Error, match="something is being rendered"):
            world.set_transforms("low", np.eye(4))
        found.append(fraction)

    renderer.render(np.eye(4), progress=move)
    omma.render_camera(world, "cam", width=40, progress=move)
    assert found

    told = []

    def render(fraction):
        with pytest.raises(omma.Error, match="moving something"):
            renderer.render(np.eye(4))
        told.append(fraction)

    world.set_transforms("low", np.eye(4), progress=render)
    assert told[-1] == 1
    assert np.array_equal(world.instances[0].world_from_node, np.eye(4))

    def stop(fraction):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        world.set_transforms(1, np.eye(4), progress=stop)
    assert np.array_equal(world.instances[1].world_from_node, moved_by(y=200))


def test_threads_that_render_and_move_at_once(grounds, down):
    world = omma.World(grounds, background=omma.Background.constant((0, 0, 0)))
    here, there = moved_by(y=-1), moved_by(x=100)
    world.set_transforms("low", here)
    seen, over = set(), threading.Event()

    def render():
        eye = omma.Eye(np.zeros((50, 3)), np.tile([[0, -1, 0]], (50, 1)), 0.0)
        renderer = omma.Renderer(world, eye, omma.Fixed(1))
        while not over.is_set():
            try:
                lit = (renderer.render(np.eye(4)) > 0).any(axis=-1)
            except omma.Error:
                continue
            seen.add((lit.all(), lit.any()))

    workers = [threading.Thread(target=render) for _ in range(2)]
    for worker in workers:
        worker.start()
    moves = 0
    for _ in range(200_000):
        try:
            world.set_transforms("low", there if moves % 2 == 0 else here)
        except omma.Error:
            continue
        moves += 1
        if moves >= 20 and len(seen) == 2:
            break
    over.set()
    for worker in workers:
        worker.join()
    assert moves >= 20
    assert seen <= {(True, True), (False, False)}


def test_forked_processes_move_nothing(files):
    text = (
        "import os, sys\n"
        "import numpy as np\n"
        "import omma\n"
        "scene = omma.load_scene(sys.argv[1])\n"
        "world = omma.World(scene)\n"
        "renderer = omma.Renderer(world, omma.Eye([[0, 1, 0]], [[0, -1, 0]], 0.1))\n"
        "world.set_transforms(0, np.eye(4))\n"
        "expected = renderer.render(np.eye(4))\n"
        "pid = os.fork()\n"
        "if pid == 0:\n"
        "    try:\n"
        "        world.set_transforms(0, np.eye(4))\n"
        "    except omma.Error as error:\n"
        "        print(\"'spawn' or 'forkserver'\" in str(error))\n"
        "    print((renderer.render(np.eye(4)) == expected).all(), flush=True)\n"
        "    os._exit(0)\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))\n"
    )
    with Program(text, files / "scene.gltf") as program:
        assert program.end() == (0, "True\nTrue\n0\n", "")
