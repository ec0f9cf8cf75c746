"""How well error bars of gradients hold in a world of small things: the meadow, by a small eye.

    python bench/gradient_errors.py                 # 8, 32 and 128 rays
    python bench/gradient_errors.py 512             # others

z is how far a derivative is off one of 200,000 rays, in their common standard errors, over all
ommatidia, bands and directions and 20 seeds. With errors of eight estimates z follows Student's t
of 7 degrees of freedom if these are normal: its rms is then 1.18, and 5 % are beyond 2.36.
"""

from __future__ import annotations

import sys

import numpy as np

import omma

OMMATIDIA, SEEDS, RAYS = 60, 20, (8, 32, 128)
MANY, OTHER_SEED = 200_000, 99
BEYOND = 2.36


def main() -> None:
    eye = omma.eye.generate_eye(OMMATIDIA)
    world = omma.World(omma.load_scene(omma.examples.meadow()))
    pose = world.scene.camera("bee").world_from_camera
    truth = omma.Renderer(world, eye, omma.Fixed(MANY), seed=OTHER_SEED).jacobian(pose)
    for rays in [int(one) for one in sys.argv[1:]] or RAYS:
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
                f"{BEYOND} {np.mean(np.abs(z) > BEYOND):.1%}; off by {rms(off):.3f} rms, told "
                f"{rms(told):.3f}, of {rms(true):.3f}; worst of a call {worst(z)}"
            )


def worst(z: np.ndarray) -> str:
    """Of the largest of each call, the least and the largest."""
    largest = np.abs(z).reshape(len(z), -1).max(axis=1)
    return f"{largest.min():.0f} to {largest.max():.0f}"


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    main()
