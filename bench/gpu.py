"""A graphics card beside two cores of a processor, in one run: whether both render the same, and
how fast each is. `scripts/bench gpu` calls this; with OMMA_CUDA_DRIVER and OMMA_NVRTC naming the
tests' stand-in for a card it can be tried without one.

    python bench/gpu.py [DATA] [--quick]

DATA is CompoundRay's data, for the meadow that comes with it.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from baked import scene_of
from light_scenes import LIT_MEADOW
from numpy.typing import NDArray

import omma
from omma import Fixed, Shared, ToError
from omma.light import Bands, clear_sky
from omma.scene import devices

# Single precision rounds otherwise where a card computes roots and powers: of a path's throughput
# some tens of roundings of 6e-8 add up, and in a hundred thousand rays some meet another leaf.
ALLOWED = 1e-4  # of the mean response, in the mean over the eye
SECONDS = 1.0  # that a case is timed for
THREADS = 2  # of the processor
COLUMNS = (
    "scene,case,poses,ommatidia,processor_ms,card_ms,times_as_fast,card_frames_per_s,"
    "card_mrays_per_s,differs_by"
)
# Frames a second of an RTX 2080 Ti, published: Millward, Maddock, Mangan 2022, eLife 73893.
COMPOUNDRAY = {
    "natural, 1,000 ommatidia at 1 ray": 5175,
    "natural, 1,000 ommatidia at 10 rays": 5091,
    "natural, 1,000 ommatidia at 100 rays": 4104,
    "natural, 1,000 ommatidia at 1000 rays": 1470,
}


@dataclass(frozen=True)
class Case:
    """Something to render: what, with which eye, how, and from how many poses at once."""

    name: str
    eye: omma.Eye
    sampling: Fixed | Shared | ToError
    poses: int = 1
    world: dict[str, Any] = field(default_factory=dict)


def scenes(data: Path | None, quick: bool) -> Iterator[tuple[str, omma.Scene]]:
    """The meadows, and hills of one texture."""
    yield "bundled meadow", omma.load_scene(omma.examples.meadow())
    if data is not None:
        yield "meadow", omma.load_scene(data / "scenes" / "natural-standin-sky.gltf")
    yield "hills", scene_of(1_000 if quick else 1_000_000)


def cases(name: str, quick: bool) -> Iterator[Case]:
    """From one ray and one small frame to many; lit, polarised, shared and to an error."""
    few, many = (1, 2) if quick else (16, 1024)
    bee = omma.eye.generate_eye(40) if quick else omma.species.honeybee_worker().eye
    # Neighbours' single rays, unlit: what is left is the search through the hierarchy.
    yield Case("a ray an ommatidium", bee, Fixed(1), min(many, 256))
    for batch in (1,) if quick else (1, 16, 256, 1024):
        yield Case("unlit", bee, Fixed(few), batch)
    if name != "bundled meadow":
        return
    yield Case("shared rays", bee, Shared(2), many)
    yield Case("to an error", bee, ToError(0.05, 4 * few), min(many, 16))
    fly = omma.eye.generate_eye(20) if quick else omma.species.drosophila().eye
    yield Case("flies", fly, Fixed(few), many)
    sun = {"light": clear_sky(30, bands=Bands.equal(12, 400, 700)), "ultraviolet": "dark"}
    yield Case("lit by paths", bee, Fixed(few), 1, sun)
    yield Case("lit by paths", bee, Fixed(few), min(many, 64), sun)
    yield Case("lit, polarised", bee, Fixed(few), 1, {**sun, "polarized": True})


def poses_of(count: int) -> NDArray[np.float64]:
    """(count, 4, 4), a flight through the meadow."""
    along = np.linspace(0, 2, count)
    return np.stack([omma.look_at((0.1, 0.3, 2 - t), (0.1, 0.3, -5 - t)) for t in along])


def time_of(render: Callable[[], object], quick: bool) -> float:
    """Seconds a call, the median of as many as fit."""
    taken: list[float] = []
    while not taken or (not quick and sum(taken) < SECONDS):
        start = time.perf_counter()
        render()
        taken.append(time.perf_counter() - start)
    return float(np.median(taken))


def measure(name: str, scene: omma.Scene, case: Case, quick: bool) -> bool:
    """Prints a line; whether both render the same."""
    poses = poses_of(case.poses)
    results, taken = [], []
    for backend in ("portable", "cuda"):
        world = omma.World(scene, backend=backend, **case.world)
        threads = THREADS if backend == "portable" else 0
        renderer = omma.Renderer(world, case.eye, case.sampling, seed=1, threads=threads)
        results.append(renderer.render(poses).astype(np.float64))
        taken.append(time_of(lambda r=renderer, p=poses: r.render(p), quick))
    processor, card = results
    rays = ""  # how many shared rays there are, and those to an error, only the engine knows
    if isinstance(case.sampling, Fixed):
        each = case.poses * len(case.eye) * case.sampling.samples
        rays = f"{1e-6 * each / taken[1]:.0f}"
    differs = np.abs(card - processor).mean() / processor.mean()
    print(
        f"{name},{case.name},{case.poses},{len(case.eye)},{1e3 * taken[0]:.2f},"
        f"{1e3 * taken[1]:.3f},{taken[0] / taken[1]:.1f},{case.poses / taken[1]:.0f},"
        f"{rays},{differs:.1e}",
        flush=True,
    )
    return bool(differs <= ALLOWED)


def measure_bake(quick: bool) -> None:
    """Prints how long light takes to be baked in the lit meadow."""
    scene = scene_of(1_000) if quick else omma.load_scene(LIT_MEADOW)
    light = clear_sky(30, bands=Bands.equal(12, 300, 700))
    taken = []
    for backend in ("portable", "cuda"):
        start = time.perf_counter()
        omma.World(
            scene,
            backend=backend,
            light=light,
            lighting="baked",
            ultraviolet="dark",
            bake=omma.scene.Bake(cache=False, paths=16 if quick else None),
        )
        taken.append(time.perf_counter() - start)
    print(
        f"lit meadow,baking its light,,,{1e3 * taken[0]:.0f},{1e3 * taken[1]:.0f},"
        f"{taken[0] / taken[1]:.1f},,,",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, nargs="?")
    parser.add_argument("--quick", action="store_true", help="few rays and poses, timed once")
    given = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)  # of scenes that are unlit here, which is meant
    card = devices()[1]
    if card.why_not:
        raise SystemExit(f"no card: {card.why_not}")
    print(f"# {card.name}; processor, {THREADS} threads; omma {omma.__version__}")
    print(COLUMNS)
    too_far = []
    for name, scene in scenes(given.data, given.quick):
        for case in cases(name, given.quick):
            if not measure(name, scene, case, given.quick):
                too_far.append(f"{name}, {case.name}")
    measure_bake(given.quick)
    for of, frames in COMPOUNDRAY.items():
        print(f'CompoundRay,"{of}",,,,,,{frames},,')
    if too_far:
        sys.exit("the card's responses differ too far: " + ", ".join(too_far))


if __name__ == "__main__":
    main()
