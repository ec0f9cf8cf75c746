"""A graphics card beside the processor, in one run: whether both render the same, and how fast each
is. `scripts/bench gpu` calls this; with OMMA_CUDA_DRIVER and OMMA_NVRTC naming the tests' stand-in
for a card it can be tried without one.

    python bench/gpu.py [--quick]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import omma
from omma import Fixed, Shared, ToError
from omma.light import Bands, clear_sky
from omma.scene import devices

# Single precision rounds otherwise where a card computes roots and powers: of a path's throughput
# some tens of roundings of 6e-8 add up, and in a hundred thousand rays some meet another leaf.
ALLOWED = 1e-4  # of the mean response, in the mean over the eye
SECONDS = 1.0  # that a case is timed for


@dataclass(frozen=True)
class Case:
    """Something to render: in what world, how, and from how many poses at once."""

    name: str
    world: dict[str, Any]
    sampling: Fixed | Shared | ToError
    poses: int = 1


def cases(quick: bool) -> list[Case]:
    """From one small frame to many; lit, polarised, shared and to an error."""
    sun = {"light": clear_sky(30, bands=Bands.equal(12, 400, 700)), "ultraviolet": "dark"}
    few, many = (1, 2) if quick else (16, 1024)
    return [
        Case("unlit", {}, Fixed(few)),
        Case("unlit, a batch", {}, Fixed(few), many),
        Case("shared rays, a batch", {}, Shared(2), many),
        Case("to an error", {}, ToError(0.05, 4 * few), min(many, 16)),
        Case("lit by paths", sun, Fixed(few)),
        Case("lit, polarised", {**sun, "polarized": True}, Fixed(few)),
        Case("lit by paths, a batch", sun, Fixed(few), min(many, 64)),
    ]


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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few rays and poses, timed once")
    quick = parser.parse_args().quick
    card = devices()[1]
    if card.why_not:
        raise SystemExit(f"no card: {card.why_not}")
    scene = omma.load_scene(omma.examples.meadow())
    eye = omma.eye.generate_eye(40) if quick else omma.species.honeybee_worker().eye
    print(f"# {card.name}; processor, {devices()[0].name}; omma {omma.__version__}")
    print("case,poses,ommatidia,processor_ms,card_ms,times_as_fast,differs_by")
    too_far = []
    for case in cases(quick):
        poses = poses_of(case.poses)
        results, taken = [], []
        for backend in ("portable", "cuda"):
            world = omma.World(scene, backend=backend, **case.world)
            renderer = omma.Renderer(world, eye, case.sampling, seed=1)
            results.append(renderer.render(poses).astype(np.float64))
            taken.append(1e3 * time_of(lambda r=renderer, p=poses: r.render(p), quick))
        processor, on_card = results
        differs = np.abs(on_card - processor).mean() / processor.mean()
        if not differs <= ALLOWED:
            too_far.append(case.name)
        print(
            f"{case.name},{case.poses},{len(eye)},{taken[0]:.2f},{taken[1]:.2f},"
            f"{taken[0] / taken[1]:.2f},{differs:.1e}",
            flush=True,
        )
    if too_far:
        sys.exit("the card's responses differ too far: " + ", ".join(too_far))


if __name__ == "__main__":
    main()
