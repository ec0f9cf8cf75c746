"""Memory and time of large point clouds: `python bench/point_clouds.py 20000000 [voxel_m]`.

Writes a LAS file of a gently waved ground with random points, 3 mm apart on average, reads it,
makes surfels and a world, and says seconds, processor seconds and the largest memory by then.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from pathlib import Path

import laspy
import numpy as np

import omma

_SPACING_M = 3e-3
_PIECE = 2_000_000


def write_ground(path: Path, count: int) -> None:
    rng = np.random.default_rng(1)
    side = _SPACING_M * count**0.5
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.scales = [1e-4] * 3
    with laspy.open(path, mode="w", header=header) as writer:
        for start in range(0, count, _PIECE):
            n = min(_PIECE, count - start)
            some = laspy.ScaleAwarePointRecord.zeros(n, header=header)
            # In strips, as scanners have them.
            x = side * (start + rng.random(n) * n) / count
            y = side * rng.random(n)
            some.x, some.y, some.z = x, y, 0.02 * np.sin(3 * x) * np.cos(4 * y)
            some.red, some.green, some.blue = rng.integers(0, 65536, (3, n))
            some.classification = 2 + (x > side / 2)
            writer.write_points(some)


def say(what: str, begun: tuple[float, float]) -> None:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    wall, busy = time.perf_counter() - begun[0], time.process_time() - begun[1]
    print(f"{what:<34} {wall:8.1f} s {busy:8.1f} CPU s   peak {peak:6.2f} GB", flush=True)


def main() -> None:
    count = int(float(sys.argv[1]))
    voxel_m = float(sys.argv[2]) if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ground.las"
        write_ground(path, count)
        print(f"{count:,} points, {os.path.getsize(path) / 1e9:.2f} GB")
        begun = time.perf_counter(), time.process_time()
        say("begin", begun)
        cloud = omma.scene.load_points(path, voxel_m=voxel_m)
        say(f"load_points: {len(cloud):,} points", begun)
        begun = time.perf_counter(), time.process_time()
        scene = omma.scene.surfels(cloud)
        say(f"surfels: {scene.triangle_count:,} triangles", begun)
        del cloud
        begun = time.perf_counter(), time.process_time()
        world = omma.World(scene)
        omma.Renderer(world, omma.eye.generate_eye(1000), omma.Fixed(4)).render(np.eye(4))
        say("world and a first frame", begun)


if __name__ == "__main__":
    main()
