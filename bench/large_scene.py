"""What it takes to load a large scene, to make a world of it and to see a frame: seconds, and the
most memory so far.

    python bench/large_scene.py place.glb
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import omma


@contextmanager
def step(name: str) -> Iterator[None]:
    """Prints how long what is inside took."""
    start = time.perf_counter()
    yield
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(f"{name}: {time.perf_counter() - start:.1f} s, {peak / 1e9:.1f} GB at most", flush=True)


def main() -> None:
    """One step after the other."""
    parser = argparse.ArgumentParser(description="Load a scene, make a world, see a frame.")
    parser.add_argument("file", type=Path)
    file = parser.parse_args().file
    told: list[float] = []
    with step(f"{file.name}, {file.stat().st_size / 1e9:.2f} GB, read"):
        scene = omma.load_scene(file, progress=told.append)
    print(f"{scene.triangle_count:,} triangles, {scene.image_count} pictures; progress was told "
          f"{len(told)} times")  # fmt: skip
    with step("world"):
        world = omma.World(scene)
    eye = omma.species.honeybee_worker().eye
    renderer = omma.Renderer(world, eye, omma.Fixed(16))
    pose = omma.look_at((0, 8, 0), (100, 0, 40))
    with step("first frame of a honeybee, 16 rays"):
        seen = renderer.render(pose)
    with step("second"):
        renderer.render(pose)
    print(f"backend {world.backend}, mean response {np.mean(seen):.3f}")


if __name__ == "__main__":
    main()
