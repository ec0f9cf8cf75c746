"""What a frame in light takes to an error relative to each response: by paths, baked, and by
Mitsuba's path integrator, where it is installed.

    python bench/light_to_error.py [DATA] [--quick]

Prints CSV. DATA is the folder with CompoundRay's scenes and eyes; without it the light meadow is
left out. Mitsuba is `pip install mitsuba`, and DRJIT_LIBLLVM_PATH names a libLLVM.

The error is the root mean square over ommatidia of (response - truth) / truth, in the mean over
bands. Each way renders several frames with random numbers of their own: their spread is the noise,
which falls with the root of the rays, and what their mean is off by beyond it stays (what is baked
errs alike in all frames). The truth is by paths, with so many rays that its own noise hardly
counts; it is taken off. So a frame to an error e takes t * noise^2 / (e^2 - fixed^2), where t is
what the measured frame took. That is `ms_to_5_percent`. A mean hides those that are worse:
`ms_to_5_percent_each` is when all but a twentieth of the ommatidia have less noise than 5 % of
their own response. Where all get the same rays the noisiest say how many; `omma.ToError` gives each
what it needs. Of Mitsuba the noise alone counts: it has a sun without a width and a
sky of another grid, which is what it is off by. All is on one thread; times are the processor's,
medians. Ommatidia within 10 degrees of the sun are left out, as a sun without a width is not met.
"""

from __future__ import annotations

import functools
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from light_peer import Peer, peer_variants
from light_scenes import (
    Setup,
    diffuse_setup,
    given_setups,
    grey_light,
    grey_setup,
)
from numpy.typing import NDArray

import omma
from light import clear_light
from omma.light import Bands
from omma.scene import Bake

COLUMNS = (
    "scene,way,ommatidia,rays,ms_a_frame,bake_cpu_s,noise_percent,fixed_percent,"
    "median_percent,percentile_95_percent,ms_to_5_percent,ms_to_5_percent_each"
)
AIM = 0.05
OF_EACH = 0.95  # of ommatidia whose own noise is below the aim
MOST_RAYS = 1 << 16
FROM_SUN_DEG = 10.0
OMMATIDIA, QUICK_OMMATIDIA = 1345, 200
RAYS = 64
FRAMES, QUICK_FRAMES = 12, 4
TRUTH_RAYS, QUICK_TRUTH_RAYS = 1024, 128
TRUTH_FRAMES = 8

Frame = NDArray[np.float64]  # [ommatidium][band]


@dataclass(frozen=True)
class Way:
    """One way to render a frame, by the number of its random numbers.

    rays: of an ommatidium, in the mean.
    bake_s: core-seconds that were spent before the first one.
    is_peer: whether what its mean is off by is left out, as its light is another one.
    """

    name: str
    render: Callable[[int], Frame]
    rays: float
    bake_s: float = 0.0
    is_peer: bool = False


def fewer(setup: Setup, ommatidia: int) -> Setup:
    """Every so manieth ommatidium of those that do not look at the sun."""
    eye = setup.eye
    axes = eye.axis @ setup.pose[:3, :3].T
    towards = np.asarray(clear_light(3).discs[0].direction)
    away = np.flatnonzero(axes @ towards < np.cos(np.radians(FROM_SUN_DEG)))
    chosen = away[np.linspace(0, len(away) - 1, min(ommatidia, len(away))).astype(int)]
    return replace(setup, eye=eye.take(chosen))


def by_omma(name: str, world: omma.World, setup: Setup, sampling: omma.Fixed | omma.ToError) -> Way:
    """Frames of one thread."""
    renderer = omma.Renderer(world, setup.eye, sampling, noise="new_every_frame", threads=1)

    def render(number: int) -> Frame:
        return renderer.render(setup.pose, first_pose=number)[0].astype(float)

    if isinstance(sampling, omma.Fixed):
        return Way(name, render, sampling.samples)
    return Way(name, render, renderer.render(setup.pose, report=True)[1].mean_rays)


def by_paths(world: omma.World, setup: Setup) -> list[Way]:
    """Paths of equally many rays, and of as many as each ommatidium needs."""
    each = omma.ToError(relative_error=AIM, most=MOST_RAYS)
    return [
        by_omma("Omma, paths", world, setup, omma.Fixed(RAYS)),
        by_omma("Omma, paths to an error", world, setup, each),
    ]


def measure(way: Way, frames: int) -> tuple[NDArray[np.float64], float]:
    """Frames [frame][ommatidium][band] and the median of their processor times, s."""
    found, taken = [], []
    way.render(0)
    for number in range(1, frames + 1):
        start = time.process_time()
        found.append(way.render(number))
        taken.append(time.process_time() - start)
    return np.array(found), float(np.median(taken))


def errors(
    found: NDArray[np.float64], truth: NDArray[np.float64]
) -> tuple[NDArray[np.float64], ...]:
    """Of frames beside those of the truth: variance of a frame and the square of what stays, both
    relative to each response, [ommatidium], means over bands; and how far a frame is off."""
    mean = truth.mean(axis=0)
    lit = np.where(mean > 0, mean, np.inf)
    noise = (found.var(axis=0, ddof=1) / lit**2).mean(axis=1)
    of_truth = (truth.var(axis=0, ddof=1) / lit**2).mean(axis=1) / len(truth)
    off = (((found.mean(axis=0) - mean) / lit) ** 2).mean(axis=1)
    single = np.sqrt((((found[0] - mean) / lit) ** 2).mean(axis=1))
    return noise, off - noise / len(found) - of_truth, single


def print_rows(name: str, ways: list[Way], truth: Way, frames: int) -> None:
    """A row for each way."""
    exact = np.array([truth.render(1000 + k) for k in range(TRUTH_FRAMES)])
    for way in ways:
        found, seconds = measure(way, frames)
        # Mitsuba's colours are alike: all bands are grey.
        bands = min(found.shape[2], exact.shape[2])
        noise, fixed, single = errors(found[..., :bands], exact[..., :bands])
        noise_2, fixed_2 = float(noise.mean()), max(0.0, float(fixed.mean()))
        reached, stays_2 = "", 0.0 if way.is_peer else fixed_2
        if stays_2 < AIM**2:
            reached = f"{1e3 * seconds * noise_2 / (AIM**2 - stays_2):.1f}"
        of_each = ""
        if way.bake_s == 0:  # what a bake errs by is not known of each
            of_each = f"{1e3 * seconds * np.quantile(noise, OF_EACH) / AIM**2:.1f}"
        cells = (
            f'"{name}"', f'"{way.name}"', found.shape[1], f"{way.rays:.0f}", f"{1e3 * seconds:.2f}",
            f"{way.bake_s:.0f}", f"{100 * np.sqrt(noise_2):.2f}", f"{100 * np.sqrt(fixed_2):.2f}",
            f"{100 * np.median(single):.2f}", f"{100 * np.quantile(single, 0.95):.2f}", reached,
            of_each,
        )  # fmt: skip
        print(",".join(str(one) for one in cells), flush=True)


def omma_ways(world: omma.World, setup: Setup, cache: str) -> list[Way]:
    """By paths and baked."""
    start = time.process_time()
    light = world.light
    assert light is not None
    baked = world.with_light(light, lighting="baked", bake=Bake(cache=cache))
    bake_s = time.process_time() - start
    of_baked = by_omma("Omma, baked", baked, setup, omma.Fixed(RAYS))
    return [*by_paths(world, setup), replace(of_baked, bake_s=bake_s)]


def peer_ways(setup: Setup, light: omma.light.Light, frames: int) -> list[Way]:
    """Mitsuba's, of as many rays; making these is not timed."""
    ways = []
    for variant in peer_variants():
        peer = Peer(variant, setup, light, RAYS * len(setup.eye))
        for number in range(frames + 1):
            peer.prepare(number)
        render = functools.partial(peer.responses, len(setup.eye))
        ways.append(Way(variant, render, RAYS, is_peer=True))
    return ways


def main() -> None:
    """Print the table."""
    setups, quick = given_setups(__doc__)
    frames, truth_rays = (QUICK_FRAMES, QUICK_TRUTH_RAYS) if quick else (FRAMES, TRUTH_RAYS)
    ommatidia = QUICK_OMMATIDIA if quick else OMMATIDIA
    print(COLUMNS, flush=True)
    with tempfile.TemporaryDirectory() as cache:
        for whole in setups:
            setup = fewer(whole, ommatidia)
            world = omma.World(setup.scene, light=clear_light(16), ultraviolet=0.02)
            truth = by_omma("truth", world, setup, omma.Fixed(truth_rays))
            if not quick:
                print_rows(setup.name, omma_ways(world, setup, cache), truth, frames)
            light = grey_light(clear_light(16), Bands.equal(16, 400.0, 700.0))
            plain = grey_setup(diffuse_setup(setup))
            world = omma.World(plain.scene, light=light)
            truth = by_omma("truth", world, plain, omma.Fixed(truth_rays))
            ways = [*by_paths(world, plain), *peer_ways(plain, light, frames)]
            print_rows(f"{setup.name}, grey", ways, truth, frames)


if __name__ == "__main__":
    main()
