"""A generation of many different eyes in one world: eyes per second, making them included, beside a
renderer for each.

    python bench/populations.py                # 10,000 eyes of 100 ommatidia
    python bench/populations.py 1000 200       # others

The world is a striped drum, in which rays are cheap, so that what an eye costs beside its rays
shows; and the bundled meadow.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import omma

SAMPLES = 16
ALONE = 100  # eyes that are rendered one by one


def arrays(eyes: int, ommatidia: int, seed: int) -> omma.Eye:
    """All ommatidia of eyes that look all around, each with an acceptance angle of its own."""
    rng = np.random.default_rng(seed)
    axis = np.tile(omma.eye.generate_eye(ommatidia).axis, (eyes, 1))
    width = np.repeat(rng.uniform(0.02, 0.1, eyes), ommatidia)
    return omma.Eye(np.zeros_like(axis), axis, width)


def seconds(work: Callable[[], object]) -> float:
    """Of the faster of two runs."""
    times = []
    for _ in range(2):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def measure(name: str, world: omma.World, eyes: int, ommatidia: int) -> None:
    """Prints a line."""
    sizes = np.full(eyes, ommatidia)
    first = omma.Population(world, arrays(eyes, ommatidia, 1), omma.Fixed(SAMPLES), sizes=sizes)
    generation = arrays(eyes, ommatidia, 2)
    rng = np.random.default_rng(3)
    poses = omma.poses_from_angles(
        0.05 * rng.normal(size=(eyes, 3)) + (0, 0.3, 0), rng.uniform(0, 360, (eyes, 1)) * (1, 0, 0)
    )
    made = seconds(lambda: first.with_eyes(generation, sizes=sizes))
    population = first.with_eyes(generation, sizes=sizes)
    rendered = seconds(lambda: population.render(poses))
    one = [arrays(1, ommatidia, k) for k in range(ALONE)]
    renderer = omma.Renderer(world, one[0], omma.Fixed(SAMPLES))

    def by_themselves() -> None:
        for k, eye in enumerate(one):
            renderer.with_eye(eye).render(poses[k])

    alone = seconds(by_themselves) / ALONE
    print(
        f"{name}: {eyes:,} eyes of {ommatidia} ommatidia, {SAMPLES} rays: made in {made:.2f} s, "
        f"rendered in {rendered:.2f} s: {eyes / (made + rendered):,.0f} eyes/s "
        f"({eyes * ommatidia * SAMPLES / rendered / 1e6:.1f} M rays/s); one by one "
        f"{1 / alone:,.0f} eyes/s",
        flush=True,
    )


def main(eyes: int = 10_000, ommatidia: int = 100) -> None:
    """Prints both lines."""
    drum = omma.stimuli.optomotor_drum(12).scene()
    measure("a striped drum", omma.World(drum), eyes, ommatidia)
    meadow = omma.load_scene(omma.examples.meadow())
    measure("the meadow", omma.World(meadow), eyes, ommatidia)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
