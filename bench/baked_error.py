"""What baked light is off by, relative to each response: the ground of the lit meadow at dusk and
at noon, as a honeybee in its grass sees it; a room with one window; and a corridor.

    python bench/baked_error.py [SCENE ...] [--quick]

Prints CSV, a row for each scene and band: the bias (of the sum over ommatidia), the root mean
square, the median and the 95th percentile of |response - truth| / truth, and the root mean square
of the third of ommatidia that are darkest; in per cent. All are of the bake alone: the truth is by
paths, both are rendered with seeds of their own, and their spread tells the noise of rays, which
is taken off the squares; the median and the percentile have what is left of it. `rms_z` is that of
z = (baked - truth) / error, with the standard errors of frames of the baked world, which have that
of the bake in them, and `z_below_2_percent` says of how many it is less than 2. Seconds are the
processor's, of all cores.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
from light_scenes import lit_meadow
from numpy.typing import NDArray

import omma
from omma.light import Bands, Light
from omma.scene import Bake

sys.path.append(str(Path(__file__).resolve().parents[1] / "docs"))
from make_baked_light_figures import Setup, corridor, pixels, room

COLUMNS = (
    "scene,band_nm,ommatidia,rays,bias_percent,rms_percent,median_percent,percentile_95_percent,"
    "darkest_third_rms_percent,rms_z,z_below_2_percent,cells,paths,bake_cpu_s,baked_mb"
)
# 21 June, 48 N 15 E.
TIMES = {"dusk": (21, 15), "noon": (13, 0)}
BANDS = 16
LOWEST_DEG = -10.0  # ground is what looks further down
OMMATIDIA, QUICK_OMMATIDIA = 1500, 100
WIDTH, HEIGHT = 48, 36  # of what is seen of rooms, an ommatidium for each pixel
SEEDS, BAKED_RAYS, QUICK_RAYS = 8, 512, 64
# Of the truth. In rooms paths are noisier.
MEADOW_RAYS, ROOM_RAYS = 2048, 8192

# A world by paths, an eye, its pose, and rays of the truth.
Case = tuple[omma.World, omma.Eye, NDArray[np.float64], int]


def meadow_at(name: str, quick: bool) -> Case:
    """The lit meadow at a time of day, and ommatidia that look at its ground."""
    moment = datetime(2026, 6, 21, *TIMES[name], tzinfo=timezone(timedelta(hours=2)))
    light = omma.light.clear_sky_at(moment, 48.0, 15.0, bands=Bands.equal(BANDS))
    setup = lit_meadow()
    down = setup.eye.axis @ setup.pose[1, :3] < np.sin(np.radians(LOWEST_DEG))
    chosen = np.random.default_rng(1).choice(
        np.flatnonzero(down), QUICK_OMMATIDIA if quick else OMMATIDIA, replace=False
    )
    world = omma.World(setup.scene, light=light, ultraviolet=0.02)
    return world, setup.eye.take(np.sort(chosen)), setup.pose, MEADOW_RAYS


def indoors(setup: Setup) -> Case:
    """A scene of docs/light.md, from where its picture shows it."""
    world = omma.World(setup.scene, light=setup.light)
    return world, pixels(WIDTH, HEIGHT, setup.height_deg), setup.pose, ROOM_RAYS


CASES: dict[str, Callable[[bool], Case]] = {
    "dusk": lambda quick: meadow_at("dusk", quick),
    "noon": lambda quick: meadow_at("noon", quick),
    "room": lambda quick: indoors(room()),
    "corridor": lambda quick: indoors(corridor()),
}


def seen_by(
    world: omma.World, eye: omma.Eye, pose: NDArray[np.float64], rays: int, first_seed: int
) -> NDArray[np.float64]:
    """Frames of seeds of their own, [seed][ommatidium][band]."""
    frames = [
        omma.Renderer(world, eye, omma.Fixed(rays), seed=first_seed + k).render(pose)[0]
        for k in range(SEEDS)
    ]
    return np.array(frames, float)


def print_rows(name: str, case: Case, quick: bool) -> None:
    """A row for each band of a scene."""
    paths, eye, pose, truth_rays = case
    light = paths.light
    assert isinstance(light, Light)
    truth = seen_by(paths, eye, pose, QUICK_RAYS if quick else truth_rays, 100)
    bake = Bake(cache=False, most_bytes=1 << 20) if quick else Bake(cache=False)
    start = time.process_time()
    world = paths.with_light(light, lighting="baked", bake=bake)
    bake_s = time.process_time() - start
    info = world.baked
    assert info is not None
    rays = QUICK_RAYS if quick else BAKED_RAYS
    baked = seen_by(world, eye, pose, rays, 0)
    frame, error = omma.Renderer(world, eye, omma.Fixed(64)).render(pose, standard_error=True)
    mean = truth.mean(axis=0)
    lit = mean > 0
    relative = np.where(lit, mean, np.inf)
    own = truth.var(axis=0, ddof=1) / SEEDS
    noise = (own + baked.var(axis=0, ddof=1) / SEEDS) / relative**2
    off = np.where(lit, baked.mean(axis=0) / relative - 1, 0)
    squares = off**2 - noise
    dark = mean.mean(axis=1) <= np.quantile(mean.mean(axis=1), 1 / 3)
    spread = np.sqrt(error[0].astype(float) ** 2 + own)
    z = (frame[0] - mean) / np.where(spread > 0, spread, np.inf)
    edges_nm = light.bands.edges_nm
    for b in range(len(light.bands)):
        numbers = (
            baked[..., b].sum() / truth[..., b].sum() - 1,
            np.sqrt(max(0.0, squares[:, b].mean())),
            np.median(np.abs(off[:, b])),
            np.quantile(np.abs(off[:, b]), 0.95),
            np.sqrt(max(0.0, squares[dark, b].mean())),
        )
        print(
            f"{name},{edges_nm[b]:.0f}-{edges_nm[b + 1]:.0f},{len(mean)},{SEEDS * rays},"
            + ",".join(f"{100 * x:.2f}" for x in numbers)
            + f",{np.sqrt(np.mean(z[:, b] ** 2)):.2f},{100 * np.mean(np.abs(z[:, b]) < 2):.1f}"
            f",{info.cells},{info.paths:.1f},"
            f"{bake_s:.0f},{info.bytes / 1e6:.0f}",
            flush=True,
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("scenes", metavar="SCENE", nargs="*", help=f"of {', '.join(CASES)}")
    parser.add_argument("--quick", action="store_true", help="few rays, to try it")
    given = parser.parse_args()
    if unknown := set(given.scenes) - set(CASES):
        parser.error(f"expected scenes of {', '.join(CASES)}, found {', '.join(unknown)}")
    # The scene's file says of itself that without a light it is not lit, which is meant.
    warnings.simplefilter("ignore", UserWarning)
    print(COLUMNS, flush=True)
    for name in given.scenes or CASES:
        print_rows(name, CASES[name](given.quick), given.quick)


if __name__ == "__main__":
    main()
