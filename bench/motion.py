"""What motion and time cost: a still world beside one in which 100 things move, frames that last,
and ground truth, one beside the other; how long one turn of a closed loop takes, and a frame of a
skin that bends.

    python bench/motion.py [--quick]

Prints CSV. Frames take turns on one thread, in processor time, so that other work on the machine
disturbs all alike: each number is a median over the turns, each ratio the median of those within a
turn. The loop and the skin are measured in wall time, as a user waits for them, so keep the machine
idle.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "python"))

from animated_scenes import Builder, tube

import omma
from omma.scene import Instance, Material

COLUMNS = "scene,what,setting,value"
OMMATIDIA, RAYS, THINGS = 1000, 16, 100
POSES, QUICK_POSES = 60, 10
TURNS, QUICK_TURNS = 9, 3
LOOPS, QUICK_LOOPS = 5000, 200
SKIN_RINGS, SKIN_SIDES, BONES = 250, 200, 20
# Of the histogram, µs.
EDGES = np.geomspace(100, 20_000, 61)


def scene_of_things(name: str) -> omma.Scene:
    """The bundled meadow or a plain, and small spheres above it."""
    if name == "meadow":
        ground = omma.load_scene(omma.examples.meadow())
    else:
        tiles = np.random.default_rng(2).uniform(0.2, 0.8, (64, 64, 3)).astype(np.float32)
        ground = omma.scene.plane((40, 40), tiles)
    ball = omma.scene.sphere(0.05, segments=16)
    rng = np.random.default_rng(1)
    instances = []
    for k in range(THINGS):
        place = np.eye(4)
        place[:3, 3] = rng.uniform((-3, 0.5, -4), (3, 2.0, 1))
        instances.append(Instance(0, place, name=f"ball {k}"))
    balls = omma.Scene(
        meshes=ball.meshes, materials=[Material("ball", double_sided=True)], instances=instances
    )
    return omma.scene.merge_scenes([ground, balls])


def flight(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Poses (count, 4, 4) through the meadow at 1 m/s, and their times, s."""
    times = np.arange(count) * 0.01
    return np.stack([omma.look_at((t, 1, 3), (t + 0.5, 0.9, -5)) for t in times]), times


def moves(world: omma.World, names: list[str], count: int) -> NDArray[np.float64]:
    """Where things are at each pose, each on a small circle: (count, K, 4, 4)."""
    where = {one.name: one.world_from_node for one in world.instances}
    found = np.tile(np.stack([where[name] for name in names]), (count, 1, 1, 1))
    turn = 2 * np.pi * np.arange(count)[:, None] / 50 + np.arange(len(names))
    found[..., 0, 3] += 0.1 * np.cos(turn)
    found[..., 1, 3] += 0.1 * np.sin(turn)
    return found


def cpu_s(run: Callable[[], object]) -> float:
    """Processor time of a call, s."""
    start = time.process_time()
    run()
    return time.process_time() - start


def print_rates(of: str, quick: bool) -> None:
    """Frames per second of each way, and of a still world's."""
    count, turns = (QUICK_POSES, QUICK_TURNS) if quick else (POSES, TURNS)
    eye = omma.eye.generate_eye(OMMATIDIA)
    scene = scene_of_things(of)
    names = [f"ball {k}" for k in range(THINGS)]
    still = omma.Renderer(omma.World(scene, threads=1), eye, omma.Fixed(RAYS), threads=1)
    moving = omma.Renderer(omma.World(scene, threads=1), eye, omma.Fixed(RAYS), threads=1)
    poses, times = flight(count)
    where = moves(moving.world, names, count)
    lasting = still.with_eye(
        eye, impulse_response=omma.photoreceptors.published_response("blowfly")
    )
    both = moving.with_eye(eye, impulse_response=omma.photoreceptors.published_response("blowfly"))
    velocity = (np.tile([1.0, 0, 0], (count, 1)), np.zeros((count, 3)))
    ways: dict[str, Callable[[], object]] = {
        "still": lambda: still.render(poses),
        f"{THINGS} things move": lambda: moving.render(poses, instances=names, transforms=where),
        "frames that last": lambda: lasting.render(poses, times_s=times),
        f"frames that last and {THINGS} things move": lambda: both.render(
            poses, times_s=times, instances=names, transforms=where
        ),
        "ground truth with flow and shares": lambda: still.ground_truth(
            poses, shares=names[:3], head_velocity=velocity
        ),
    }
    taken: dict[str, list[float]] = {name: [] for name in ways}
    for turn in range(turns + 1):
        for name, run in ways.items():
            took = cpu_s(run)
            if turn > 0:  # the first warms up
                taken[name].append(took)
    for name, found in taken.items():
        ratios = np.array(taken["still"]) / found
        print(f"{of},frames per second,{name},{count / np.median(found):.1f}")
        print(f"{of},of the still world,{name},{np.median(ratios):.3f}", flush=True)


def print_loop(quick: bool) -> None:
    """Wall time of set_transforms, render and reading what was rendered."""
    eye = omma.eye.generate_eye(OMMATIDIA)
    world = omma.World(scene_of_things("plain"))
    renderer = omma.Renderer(world, eye, omma.Fixed(RAYS))
    names = [f"ball {k}" for k in range(10)]
    count = QUICK_LOOPS if quick else LOOPS
    where = moves(world, names, 256)
    poses, _ = flight(256)
    out = np.empty((1, OMMATIDIA, 3), np.float32)
    indices = [world.index(name) for name in names]
    taken = []
    for k in range(count + 200):
        start = time.perf_counter()
        world.set_transforms(indices, where[k % 256])
        renderer.render(poses[k % 256], out=out)
        float(out.mean())
        taken.append(1e6 * (time.perf_counter() - start))
    taken = taken[200:]
    for percent in (50, 90, 99, 99.9):
        print(f"plain,loop µs,{percent} %,{np.percentile(taken, percent):.0f}")
    counts, _ = np.histogram(np.clip(taken, EDGES[0], EDGES[-1]), EDGES)
    for edge, number in zip(EDGES, counts, strict=False):
        print(f"plain,loop histogram µs,{edge:.1f},{number}")


def skinned_tube(folder: str) -> omma.Scene:
    """A tube of 50,000 vertices on a chain of bones, each of which swings."""
    length = 2.0
    positions, normals, triangles = tube(SKIN_RINGS, SKIN_SIDES, length)
    made = Builder()
    # Each vertex between two bones.
    place = positions[:, 1] / length * (BONES - 1)
    below = np.minimum(place.astype(int), BONES - 2)
    joints, weights = np.zeros((len(positions), 4)), np.zeros((len(positions), 4))
    joints[:, 0], joints[:, 1] = below, below + 1
    weights[:, 1] = place - below
    weights[:, 0] = 1 - weights[:, 1]
    mesh = made.mesh(
        positions, triangles, normals=normals,
        JOINTS_0=made.accessor(joints, "u2"), WEIGHTS_0=made.accessor(weights),
    )  # fmt: skip
    step = length / (BONES - 1)
    bones, parent = [], None
    for k in range(BONES):
        parent = made.node(parent, name=f"bone {k}", translation=[0, step if k else 0, 0])
        bones.append(parent)
    inverse_bind = np.tile(np.eye(4), (BONES, 1, 1))
    inverse_bind[:, 1, 3] = -step * np.arange(BONES)
    made.node(name="tube", mesh=mesh, skin=made.skin(bones, inverse_bind))
    angle = 0.05
    keys = [[0, 0, s * np.sin(angle), np.cos(angle)] for s in (-1, 1, -1)]
    made.animation([(bone, "rotation", [0, 0.5, 1], keys, "LINEAR") for bone in bones])
    return omma.load_scene(made.write(Path(folder, "tube.gltf")))


def print_skin(quick: bool) -> None:
    """Wall time of bending the skin to a time and of rendering a frame of it, ms."""
    with tempfile.TemporaryDirectory() as folder:
        world = omma.World(skinned_tube(folder))
    renderer = omma.Renderer(world, omma.eye.generate_eye(OMMATIDIA), omma.Fixed(RAYS))
    pose = omma.look_at((0, 1, 3), (0, 1, 0))
    bending, rendering = [], []
    for k in range((QUICK_LOOPS if quick else LOOPS) // 10 + 20):
        start = time.perf_counter()
        world.at(k % 97 / 97)
        middle = time.perf_counter()
        renderer.render(pose)
        bending.append(1e3 * (middle - start))
        rendering.append(1e3 * (time.perf_counter() - middle))
    what = f"skin of {SKIN_RINGS * SKIN_SIDES} vertices ms"
    both = np.add(bending, rendering)[20:]
    for name, taken in (("bending", bending[20:]), ("rendering", rendering[20:]), ("both", both)):
        print(f"tube,{what},{name},{np.median(taken):.2f}")
    print(f"tube,{what},both 99 %,{np.percentile(both, 99):.2f}", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)
    print(COLUMNS)
    for of in ("plain", "meadow"):
        print_rates(of, given.quick)
    print_loop(given.quick)
    print_skin(given.quick)


if __name__ == "__main__":
    main()
