"""What baked light is off by, relative to each response: the ground of the lit meadow at dusk and
at noon, as a honeybee in its grass sees it.

    python bench/baked_error.py [--quick]

Prints CSV, a row for each time of day and band: the bias (of the sum over ommatidia), the root
mean square, the median and the 95th percentile of |response - truth| / truth, and the root mean
square of the third of ommatidia that are darkest; in per cent. All are of the bake alone: the truth
is by paths, both are rendered with seeds of their own, and their spread tells the noise of rays,
which is taken off the squares; the median and the percentile have what is left of it. `rms_z` is
that of (baked - truth) / error, with the standard errors of frames of the baked world, which have
that of the bake in them. Seconds are the processor's, of all cores.
"""

from __future__ import annotations

import argparse
import time
import warnings
from datetime import datetime, timedelta, timezone

import numpy as np
from light_scenes import lit_meadow
from numpy.typing import NDArray

import omma
from omma.light import Bands
from omma.scene import Bake

COLUMNS = (
    "time,band_nm,ommatidia,rays,bias_percent,rms_percent,median_percent,percentile_95_percent,"
    "darkest_third_rms_percent,rms_z,cells,paths,bake_cpu_s,baked_mb"
)
# 21 June, 48 N 15 E.
TIMES = {"dusk": (21, 15), "noon": (13, 0)}
BANDS = 16
LOWEST_DEG = -10.0  # ground is what looks further down
OMMATIDIA, QUICK_OMMATIDIA = 1500, 100
SEEDS, TRUTH_RAYS, BAKED_RAYS = 8, 2048, 512
QUICK_RAYS = 64

Seen = NDArray[np.float64]  # [seed][ommatidium][band]


def light_at(name: str) -> omma.light.Light:
    """A clear sky and its sun at a time of day."""
    moment = datetime(2026, 6, 21, *TIMES[name], tzinfo=timezone(timedelta(hours=2)))
    return omma.light.clear_sky_at(moment, 48.0, 15.0, bands=Bands.equal(BANDS))


def seen_by(
    world: omma.World, eye: omma.Eye, pose: NDArray[np.float64], rays: int, first_seed: int
) -> Seen:
    """Frames of seeds of their own."""
    frames = [
        omma.Renderer(world, eye, omma.Fixed(rays), seed=first_seed + k).render(pose)[0]
        for k in range(SEEDS)
    ]
    return np.array(frames, float)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="few rays, to try it")
    quick = parser.parse_args().quick
    # The scene's file says of itself that without a light it is not lit, which is meant.
    warnings.simplefilter("ignore", UserWarning)
    setup = lit_meadow()
    down = setup.eye.axis @ setup.pose[1, :3] < np.sin(np.radians(LOWEST_DEG))
    chosen = np.random.default_rng(1).choice(
        np.flatnonzero(down), QUICK_OMMATIDIA if quick else OMMATIDIA, replace=False
    )
    eye = setup.eye.take(np.sort(chosen))
    bake = Bake(cache=False, most_bytes=1 << 20) if quick else Bake(cache=False)
    print(COLUMNS, flush=True)
    for name in TIMES:
        light = light_at(name)
        paths = omma.World(setup.scene, light=light, ultraviolet=0.02)
        truth = seen_by(paths, eye, setup.pose, QUICK_RAYS if quick else TRUTH_RAYS, 100)
        start = time.process_time()
        world = paths.with_light(light, lighting="baked", bake=bake)
        bake_s = time.process_time() - start
        info = world.baked
        assert info is not None
        baked = seen_by(world, eye, setup.pose, QUICK_RAYS if quick else BAKED_RAYS, 0)
        frame, error = omma.Renderer(world, eye, omma.Fixed(64)).render(
            setup.pose, standard_error=True
        )
        mean = truth.mean(axis=0)
        own = truth.var(axis=0, ddof=1) / SEEDS
        noise = (own + baked.var(axis=0, ddof=1) / SEEDS) / mean**2
        off = baked.mean(axis=0) / mean - 1
        squares = off**2 - noise
        dark = mean.mean(axis=1) <= np.quantile(mean.mean(axis=1), 1 / 3)
        z = (frame[0] - mean) / np.sqrt(error[0].astype(float) ** 2 + own)
        edges_nm = light.bands.edges_nm
        for b in range(BANDS):
            numbers = (
                baked[..., b].sum() / truth[..., b].sum() - 1,
                np.sqrt(max(0.0, squares[:, b].mean())),
                np.median(np.abs(off[:, b])),
                np.quantile(np.abs(off[:, b]), 0.95),
                np.sqrt(max(0.0, squares[dark, b].mean())),
            )
            print(
                f"{name},{edges_nm[b]:.0f}-{edges_nm[b + 1]:.0f},{len(mean)},{SEEDS * BAKED_RAYS},"
                + ",".join(f"{100 * x:.2f}" for x in numbers)
                + f",{np.sqrt(np.mean(z[:, b] ** 2)):.2f},{info.cells},{info.paths:.1f},"
                f"{bake_s:.0f},{info.bytes / 1e6:.0f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
