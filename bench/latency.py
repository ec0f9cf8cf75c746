"""Measures one frame at a time from Python, as a closed loop does (one pose, its responses, the
next pose), and prints it as CSV in the columns of bench/frames.cpp. The same scene, eyes and poses.

    python bench/latency.py DATA [--quick]

DATA is the folder with CompoundRay's scenes and eyes.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import omma


def flight(count: int) -> NDArray[np.float64]:
    """Poses (count, 4, 4) on a small circle in the middle of the meadow, turning with it."""
    turn = 2 * np.pi * np.arange(count) / 256
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, 0, 0] = poses[:, 2, 2] = np.cos(turn)
    poses[:, 0, 2], poses[:, 2, 0] = np.sin(turn), -np.sin(turn)
    poses[:, :3, 3] = np.stack(
        [0.05 * np.cos(turn), np.full(count, 0.15), 0.05 * np.sin(turn)], axis=1
    )
    return poses


def batch_us(renderer: omma.Renderer, poses: NDArray[np.float64], least_s: float) -> float:
    """Microseconds a frame, in one call for all: the best of at least three."""
    out = np.empty((len(poses), len(renderer.eye), 3), np.float32)
    best, begin, rounds = np.inf, time.perf_counter(), 0
    while rounds < 3 or time.perf_counter() - begin < least_s:
        start = time.perf_counter()
        renderer.render(poses, out=out)
        best = min(best, time.perf_counter() - start)
        rounds += 1
    return 1e6 * best / len(poses)


def single_us(renderer: omma.Renderer, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Microseconds of each frame, in a call of its own. The first tenth warms up."""
    out = np.empty((1, len(renderer.eye), 3), np.float32)
    taken = []
    for pose in poses:
        start = time.perf_counter()
        renderer.render(pose, out=out)
        taken.append(1e6 * (time.perf_counter() - start))
    return np.array(taken[len(taken) // 10 :])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    scene = omma.load_scene(given.data / "scenes" / "natural-standin-sky.gltf")
    small = omma.load_eye(given.data / "scenes" / "eyes" / "1000-equidistant.eye")
    bee = omma.load_eye(given.data / "bees" / "AM_60185-real.eye")
    print("language,scene,ommatidia,rays,median_us,p99_us,batch_us")
    for eye, samples in ((small, 1), (small, 16), (bee, 16)):
        renderer = omma.Renderer(scene, eye, omma.Fixed(samples))
        rays = len(eye) * samples
        batch = flight(int(np.clip((1e5 if given.quick else 5e6) / rays, 1, 1024)))
        least_s = 0.0 if given.quick else 1.0
        best = batch_us(renderer, batch, least_s)
        single = single_us(renderer, flight(100 if given.quick else 4000))
        best = min(best, batch_us(renderer, batch, least_s))
        middle, slow = np.percentile(single, [50, 99])
        name = "natural-standin-sky"
        print(f"Python,{name},{len(eye)},{samples},{middle:.1f},{slow:.1f},{best:.1f}", flush=True)


if __name__ == "__main__":
    main()
