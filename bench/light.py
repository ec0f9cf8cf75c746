"""What light costs: worlds without light, baked, in direct light and with whole paths, by bands and
with polarisation, one beside the other; and beside Mitsuba's LLVM variants, where they are
installed.

    python bench/light.py [DATA] [--quick]

Prints CSV. DATA is the folder with CompoundRay's scenes and eyes; without it the light meadow is
left out. Baking takes minutes the first time; afterwards its cache has it. Mitsuba is
`pip install mitsuba`, and DRJIT_LIBLLVM_PATH names a libLLVM.

All takes turns on one thread, so that other work on the machine disturbs all alike: times are the
processor's, medians over the turns, and a ratio is the median of the ratios within each turn.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from light_peer import Peer, peer_variants
from light_scenes import Setup, diffuse_setup, given_setups, grey_light
from numpy.typing import NDArray

import omma
from omma.light import Bands, Disc, Light
from omma.scene import Bake

COLUMNS = "scene,ommatidia,rays,way,bands,depth,polarized,ns_per_ray,compared_with,times"
BANDS = (3, 8, 16, 32)
DEPTHS = (1, 2, 4, 8, None)
SUN_ELEVATION_DEG, SUN_AZIMUTH_DEG = 30.0, 135.0
RAYS, QUICK_RAYS = 200_000, 50_000
TURNS, QUICK_TURNS = 7, 3
# A call of Mitsuba takes some 10 ms besides its rays: so many that this does not count.
PEER_RAYS, QUICK_PEER_RAYS = 1_000_000, 200_000
PEER_DEPTHS = (1, 4, 8)
# For each side of a cell: how long a render takes does not depend on it.
BAKED_PATHS = 16


@dataclass(frozen=True)
class Way:
    """One way to render, and the one that it is compared with.

    run: renders once, and returns how many rays that were.
    """

    name: str
    run: Callable[[], int]
    compared_with: str = ""
    bands: int = 16
    depth: int | None = None
    polarized: bool = False


@functools.cache
def clear_light(bands: int) -> Light:
    """A clear sky and its sun."""
    return omma.light.clear_sky(
        SUN_ELEVATION_DEG, sun_azimuth_deg=SUN_AZIMUTH_DEG, bands=Bands.equal(bands)
    )


def sun_below(light: Light) -> Light:
    """The sun alone, straight under the ground: asked for light, without a shadow ray."""
    down = [Disc((0.0, -1.0, 0.0), one.angular_radius_rad, one.radiance) for one in light.discs]
    return replace(light, sky=None, discs=tuple(down), recipe=None)


def renders(world: omma.World, setup: Setup, rays: int) -> Callable[[], int]:
    """Renders of one frame, of about as many rays."""
    samples = max(1, round(rays / len(setup.eye)))
    renderer = omma.Renderer(world, setup.eye, omma.Fixed(samples), threads=1)
    count = samples * len(setup.eye)

    def run() -> int:
        renderer.render(setup.pose)
        return count

    return run


def lit_ways(setup: Setup, rays: int) -> list[Way]:
    """The unlit world, and the same world in the light of a clear sky."""
    unlit = omma.World(setup.scene, threads=1)
    base = omma.World(
        setup.scene, light=clear_light(16), ultraviolet=0.02, threads=1, lighting="path"
    )
    edges_nm = Bands.equal(16).edges_nm
    empty = omma.Scene()

    def in_light(light: Light, depth: int | None, polarized: bool = False) -> Callable[[], int]:
        return renders(base.with_light(light, depth=depth, polarized=polarized), setup, rays)

    def alone(light: Light) -> Callable[[], int]:
        return renders(omma.World(empty, light=light, depth=1, threads=1), setup, rays)

    clear = clear_light(16)
    dark = replace(clear, sky=None, discs=(), recipe=None)
    spectral = omma.World(setup.scene, band_from_rgb=omma.light.band_from_rgb(edges_nm), threads=1)
    ways = [
        Way("unlit", renders(unlit, setup, rays), bands=3),
        Way("unlit in bands", renders(spectral, setup, rays), "unlit"),
        Way("nothing, unlit", renders(omma.World(empty, threads=1), setup, rays), bands=3),
        Way("nothing, dark", alone(dark), depth=1),
        Way("nothing, sky", alone(replace(clear, discs=(), recipe=None)), "nothing, dark", depth=1),
        Way("dark", in_light(dark, 1), "unlit in bands", depth=1),
        Way("sun below", in_light(sun_below(clear), 1), "dark", depth=1),
        Way("sun", in_light(replace(clear, sky=None, recipe=None), 1), "dark", depth=1),
        Way("sky", in_light(replace(clear, discs=(), recipe=None), 1), "dark", depth=1),
    ]
    bake = Bake(paths=BAKED_PATHS)
    for sun in ("exact", "map"):
        baked = base.with_light(clear, lighting="baked", sun=sun, bake=bake)
        ways.append(Way(f"baked, sun {sun}", renders(baked, setup, rays), "unlit"))
    for depth in DEPTHS:
        ways.append(Way(path_name(depth), in_light(clear, depth), "unlit", depth=depth))
    for depth in (1, None):
        name = path_name(depth)
        run = in_light(clear, depth, polarized=True)
        ways.append(Way(f"{name}, polarised", run, name, depth=depth, polarized=True))
        for bands in BANDS:
            if bands != 16:
                run = in_light(clear_light(bands), depth)
                ways.append(Way(f"{name}, {bands} bands", run, name, bands, depth))
    return ways


def path_name(depth: int | None) -> str:
    """What a depth is called."""
    if depth is None:
        return "paths"
    return "direct light" if depth == 1 else f"up to {depth}"


def peer_ways(setup: Setup, rays: int) -> list[Way]:
    """Omma and Mitsuba on one flattened, diffuse scene in one grey light."""
    light = grey_light(clear_light(16), Bands.equal(16, 400.0, 700.0))
    plain = diffuse_setup(setup)
    base = omma.World(plain.scene, light=light, threads=1, lighting="path")
    peers = [Peer(variant, plain, light, rays) for variant in peer_variants()]
    ways = []
    for depth in PEER_DEPTHS:
        name = f"Omma, {path_name(depth)}"
        ways.append(
            Way(name, renders(base.with_light(light, depth=depth), plain, rays), depth=depth)
        )
        for peer in peers:
            run = functools.partial(peer.render, depth)
            ways.append(Way(f"{peer.variant}, {path_name(depth)}", run, name, peer.bands, depth))
    return ways


def measure(ways: list[Way], turns: int) -> NDArray[np.float64]:
    """Nanoseconds a ray, [way, turn], after a turn that warms up."""
    for way in ways:
        way.run()
    taken = np.empty((len(ways), turns))
    for turn in range(turns):
        for k, way in enumerate(ways):
            start = time.process_time()
            count = way.run()
            taken[k, turn] = 1e9 * (time.process_time() - start) / count
    return taken


def print_rows(setup: Setup, rays: int, ways: list[Way], turns: int) -> None:
    """The ways of one scene, a row each."""
    taken = measure(ways, turns)
    row_of = {way.name: k for k, way in enumerate(ways)}
    for k, way in enumerate(ways):
        times = ""
        if way.compared_with:
            times = f"{np.median(taken[k] / taken[row_of[way.compared_with]]):.3f}"
        cells = (
            setup.name,
            len(setup.eye),
            rays,
            f'"{way.name}"',
            way.bands,
            "" if way.depth is None else way.depth,
            int(way.polarized),
            f"{np.median(taken[k]):.1f}",
            f'"{way.compared_with}"',
            times,
        )
        print(",".join(str(cell) for cell in cells), flush=True)


def main() -> None:
    """Print the table."""
    setups, quick = given_setups(__doc__)
    rays, peer_rays, turns = RAYS, PEER_RAYS, TURNS
    if quick:
        rays, peer_rays, turns = QUICK_RAYS, QUICK_PEER_RAYS, QUICK_TURNS
    print(COLUMNS)
    for setup in setups:
        print_rows(setup, rays, lit_ways(setup, rays), turns)
        if peer_variants():
            print_rows(setup, peer_rays, peer_ways(setup, peer_rays), turns)


if __name__ == "__main__":
    main()
