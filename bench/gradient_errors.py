"""How well error bars of gradients hold in a world of small things, the meadow, by a small eye, and
how many renders they cost.

    python bench/gradient_errors.py                 # 8, 32 and 128 rays
    python bench/gradient_errors.py 512             # others
    python bench/gradient_errors.py --lit           # the lit meadow, towards the sun and the pond

z is how far a derivative is off one of 200,000 rays (lit: 20,000), in their common standard
errors, over all ommatidia, bands and directions and 20 seeds. With errors of eight estimates z
follows Student's t of 7 degrees of freedom if these are normal: its rms is then 1.18, and 5 % are
beyond 2.36.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import omma

OMMATIDIA, SEEDS, RAYS = 60, 20, (8, 32, 128)
MANY, MANY_LIT, OTHER_SEED = 200_000, 20_000, 99
BEYOND = 2.36


def main() -> None:
    eye = omma.eye.generate_eye(OMMATIDIA)
    lit = "--lit" in sys.argv
    world = lit_meadow() if lit else omma.World(omma.load_scene(omma.examples.meadow()))
    pose = world.scene.camera("bee").world_from_camera
    many = omma.Fixed(MANY_LIT if lit else MANY)
    truth = omma.Renderer(world, eye, many, seed=OTHER_SEED).jacobian(pose)
    scale = rms(truth.responses) if lit else 1.0  # daylight is 10^17
    for rays in [int(one) for one in sys.argv[1:] if one != "--lit"] or RAYS:
        found = [
            omma.Renderer(world, eye, omma.Fixed(rays), seed=seed).jacobian(pose)
            for seed in range(SEEDS)
        ]
        for name, true in truth.values.items():
            off = np.stack([one.values[name] - true for one in found])
            told = np.stack([one.errors[name] for one in found])
            z = off / np.hypot(told, truth.errors[name])
            print(
                f"{rays:5} rays, by {name:20} z: rms {rms(z):.2f}, mean {z.mean():+.2f}, beyond "
                f"{BEYOND} {np.mean(np.abs(z) > BEYOND):.1%}; off by {rms(off) / scale:.3f} "
                f"rms, told {rms(told) / scale:.3f}, of {rms(true) / scale:.3f}; worst of a call "
                f"{worst(z)}"
            )

        renderer = omma.Renderer(world, eye, omma.Fixed(rays))
        renders = seconds(renderer.jacobian, pose) / seconds(renderer.render, pose)
        print(f"{rays:5} rays: by all three {renders:.1f} times the processor's time of a render")


def lit_meadow() -> omma.World:
    """With the sun 30° high, before the eye, and its image in the pond."""
    light = omma.light.clear_sky(30, bands=omma.light.Bands.equal(4, 300, 700))
    return omma.World(omma.load_scene(omma.examples.lit_meadow()), light=light)


def seconds(work: Callable[[np.ndarray], object], pose: np.ndarray) -> float:
    """The processor's, of the quickest of five."""
    taken = []
    for _ in range(5):
        start = time.process_time()
        work(pose)
        taken.append(time.process_time() - start)
    return min(taken)


def worst(z: np.ndarray) -> str:
    """Of the largest of each call, the least and the largest."""
    largest = np.abs(z).reshape(len(z), -1).max(axis=1)
    return f"{largest.min():.0f} to {largest.max():.0f}"


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    main()
