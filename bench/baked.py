"""What baking light takes, by triangles, bands and cells: hills in the light of a clear sky.

    python bench/baked.py [--quick]

Prints CSV: seconds of processor time of all cores (other work on the machine does not count) and by
the clock, the memory that baked light has, and the most that the process had at any time, the scene
and its acceleration structure included. Each row is a process of its own. The largest takes 6 GB.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import subprocess
import sys
import time

import numpy as np
from make_large_scene import hills

import omma

COLUMNS = "triangles,bands,paths,cells,cell_m,baked_mb,cpu_s,wall_s,peak_mb"
PATHS = 16
# Triangles, bands, and the longest edge of a cell, m; None: as chosen by the scene.
ROWS = [
    (100_000, 3, None),
    (100_000, 16, None),
    (100_000, 64, None),
    (100_000, 16, 2.0),
    (100_000, 16, 1.0),
    (1_000_000, 3, None),
    (1_000_000, 16, None),
    (10_000_000, 3, None),
    (10_000_000, 16, None),
]
QUICK_ROWS = [(1_000, 3, None), (10_000, 16, 5.0)]


def scene_of(triangles: int) -> omma.Scene:
    positions, texcoords, corners = hills(math.isqrt(triangles // 2))
    squares = np.indices((8, 8)).sum(0) % 2
    picture = np.repeat((0.2 + 0.4 * squares)[..., None], 3, axis=2).astype(np.float32)
    of_checks = omma.scene.plane((1, 1), picture)
    ground = omma.scene.Mesh(
        positions, corners.astype(np.int32), texture_coordinates=texcoords, material=0
    )
    return of_checks.replace(meshes=[ground])


def bake(triangles: int, bands: int, cell_m: float | None) -> str:
    """One row."""
    scene = scene_of(triangles)
    light = omma.light.clear_sky(30, sun_azimuth_deg=135, bands=omma.light.Bands.equal(bands))
    options = omma.scene.Bake(cell_m=cell_m, paths=PATHS, cache=False, most_bytes=1 << 33)
    cpu, wall = time.process_time(), time.perf_counter()
    world = omma.World(scene, light=light, lighting="baked", ultraviolet=0.02, bake=options)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    baked = world.baked
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
    return (
        f"{scene.meshes[0].triangles.shape[0]},{bands},{baked.paths},{baked.cells},"
        f"{baked.cell_m:.3g},{baked.bytes / 1e6:.1f},{cpu:.1f},{wall:.1f},{peak_mb:.0f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="small scenes, to try it")
    parser.add_argument("--row", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.row:
        print(bake(*json.loads(arguments.row)))
        return
    print(COLUMNS, flush=True)
    for row in QUICK_ROWS if arguments.quick else ROWS:
        command = [sys.executable, __file__, "--row", json.dumps(row)]
        print(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout, end="")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
