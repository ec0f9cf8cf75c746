"""What baked light is off by: the lit meadow under a clear sky, as a honeybee in its grass sees it,
by paths and baked, with the same rays.

    python bench/baked_error.py [--quick]

Prints CSV, a row for each band: the mean difference and its root mean square over ommatidia, in per
cent of the mean response, both with their standard errors. Both are without the noise of rays: all
is rendered with seeds that are independent, the mean square is the mean of products of differences
of two seeds, and standard errors come from leaving out one seed at a time. The noise of the bake
counts as difference, as no seed of a render changes it.

Ommatidia that look to within 10° of the sun are left out: the few rays that meet its disc are most
of what such a one sees, by paths and baked alike. Seconds are the processor's, of all cores.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import warnings
from dataclasses import dataclass

import numpy as np
from light_scenes import Setup, lit_meadow
from numpy.typing import NDArray

import omma
from light import clear_light
from omma.scene import Bake

COLUMNS = (
    "sun,band_nm,ommatidia,rays,bias_percent,bias_error,rms_percent,rms_error,"
    "noise_percent,cells,paths,bake_cpu_s,baked_mb"
)
BANDS = 16
SEEDS, RAYS = 8, 256
QUICK_SEEDS, QUICK_RAYS = 3, 2
FROM_SUN_DEG = 10.0

# Responses to independent rays: [seed, ommatidium, band].
Seen = NDArray[np.float64]


@dataclass(frozen=True)
class Difference:
    """How one way to render differs from another, [band], as shares of the mean response.

    noise: the standard deviation that the difference has with all rays of all seeds.
    """

    bias: NDArray[np.float64]
    bias_error: NDArray[np.float64]
    rms: NDArray[np.float64]
    rms_error: NDArray[np.float64]
    noise: NDArray[np.float64]


def seen_by(world: omma.World, setup: Setup, seeds: int, rays: int) -> Seen:
    """By ommatidia that do not look at the sun."""
    assert world.light is not None
    axes = setup.eye.axis @ setup.pose[:3, :3].T
    towards = np.asarray(world.light.discs[0].direction)
    keeps = axes @ (towards / np.linalg.norm(towards)) < np.cos(np.radians(FROM_SUN_DEG))
    found = []
    for seed in range(seeds):
        renderer = omma.Renderer(world, setup.eye, omma.Fixed(rays), seed=seed)
        found.append(renderer.render(setup.pose)[0][keeps].astype(float))
    return np.array(found)


def compare(found: Seen, truth: Seen) -> Difference:
    """Of the same seeds."""
    seeds = len(truth)
    off = (found - truth) / truth.mean(axis=(0, 1))
    bias = off.mean(axis=1)

    def mean_square(of: Seen) -> NDArray[np.float64]:
        n = len(of)
        products = of.sum(axis=0) ** 2 - (of**2).sum(axis=0)
        return products.mean(axis=0) / (n * (n - 1))

    square = mean_square(off)
    without = np.array([mean_square(np.delete(off, k, axis=0)) for k in range(seeds)])
    square_error = np.sqrt((seeds - 1) * without.var(axis=0))
    rms = np.sqrt(np.maximum(square, 0))
    return Difference(
        bias.mean(axis=0),
        bias.std(axis=0, ddof=1) / np.sqrt(seeds),
        rms,
        square_error / (2 * np.maximum(rms, np.sqrt(square_error))),
        np.sqrt(off.var(axis=0, ddof=1).mean(axis=0) / seeds),
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="few rays, to try it")
    given = parser.parse_args()
    # The scene's file says of itself that without a light it is not lit, which is meant.
    warnings.simplefilter("ignore", UserWarning)
    seeds, rays = (QUICK_SEEDS, QUICK_RAYS) if given.quick else (SEEDS, RAYS)
    setup = lit_meadow()
    light = clear_light(BANDS)
    paths = omma.World(setup.scene, light=light, ultraviolet=0.02, lighting="path")
    truth = seen_by(paths, setup, seeds, rays)
    print(COLUMNS, flush=True)
    with tempfile.TemporaryDirectory() as cache:
        bake = Bake(most_bytes=1 << 20, cache=cache) if given.quick else Bake(cache=cache)
        start = time.process_time()
        baked = paths.with_light(light, lighting="baked", bake=bake)
        bake_s = time.process_time() - start
        mapped = paths.with_light(light, lighting="baked", sun="map", bake=bake)
    info = baked.baked
    assert info is not None
    edges_nm = light.bands.edges_nm
    for sun, world in (("exact", baked), ("map", mapped)):
        off = compare(seen_by(world, setup, seeds, rays), truth)
        for b in range(BANDS):
            of_band = (off.bias[b], off.bias_error[b], off.rms[b], off.rms_error[b], off.noise[b])
            shares = ",".join(f"{100 * x:.3f}" for x in of_band)
            print(
                f"{sun},{edges_nm[b]:.0f}-{edges_nm[b + 1]:.0f},{truth.shape[1]},{seeds * rays},"
                f"{shares},{info.cells},{info.paths},{bake_s:.0f},{info.bytes / 1e6:.0f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
