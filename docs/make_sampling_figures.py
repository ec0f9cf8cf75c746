"""Makes the pictures of docs/sampling.md and bench/notes/compoundray-protocols.md,
docs/sampling-*.png, and prints their numbers as tables.

    .venv/bin/python docs/make_sampling_figures.py [--data FOLDER] [samples maps aliasing speed]

FOLDER holds CompoundRay's scenes and eyes (scenes/ofstad-arena.gltf, scenes/eyes, ...); what it
lacks is left out. Nothing else should run meanwhile: the times are printed too. Some minutes each.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import omma
from omma.study.speed_test import machine_name
from omma.study.variance import COMPOUNDRAY, OURS

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
MEADOW = ROOT / "examples" / "meadow.glb"
PARTS = ("samples", "maps", "aliasing", "speed")
# Of the arena, whose radius is 12.2 m and whose height 9.6 m: its inner part, where no field is all
# black, and up to a quarter of a metre from the wall.
ARENA_PLACE = omma.study.Cylinder((0, 0.25, 0), 9.0, 9.1)
ARENA_WHOLE = omma.study.Cylinder((0, 0.25, 0), 11.97, 9.1)


def say(*what: object) -> None:
    """A line of the report."""
    print(*what, flush=True)


def table(*names: str) -> None:
    """The head of a Markdown table."""
    say("\n|", " | ".join(names), "|\n|", " | ".join("---" for _ in names), "|")


def row(*cells: object) -> None:
    """A line of a Markdown table."""
    say("|", " | ".join(str(cell) for cell in cells), "|")


def show(stage: str, fraction: float | None) -> None:
    """Progress, where someone is looking."""
    if sys.stderr.isatty():
        percent = 100 * (fraction or 0)
        print(f"\r{stage} {percent:3.0f} %\x1b[K", end="", file=sys.stderr, flush=True)


def searches(name: str, scene: omma.Scene, where, measure: str) -> list[omma.study.MinimumSamples]:
    """A row for each method."""
    found = []
    for method in (COMPOUNDRAY, OURS):
        one = omma.study.minimum_samples(
            scene, where, method=method, measure=measure, progress=show
        )
        row(
            name, measure, one.method.name, f"{one.rays_per_sr:,}",
            " ".join(f"{v:.2f}" for v in one.pose[:3, 3]), f"{one.poses_rendered:,}",
            f"{one.rays_traced / 1e6:,.0f} million", f"{one.seconds:.1f} s",
        )  # fmt: skip
        found.append(one)
    return found


def minimum_samples(scenes: Path) -> None:
    """Rays per steradian of three scenes, the published number, and what the rule is worth."""
    table("scene", "measure", "method", "rays/sr", "worst at (m)", "poses", "rays", "time")
    arena_file, natural = scenes / "ofstad-arena.gltf", scenes / "natural-standin-sky.gltf"
    if arena_file.exists():
        arena = omma.load_scene(arena_file)
        found = searches("arena", arena, ARENA_PLACE, "linear")
        omma.study.save_minimum_samples(DOCS / "sampling-arena.png", found)
        searches("arena, to the wall", arena, ARENA_WHOLE, "linear")
        searches("arena", arena, ARENA_PLACE, "compoundray")
        searches("arena, to the wall", arena, ARENA_WHOLE, "compoundray")
    if natural.exists():
        # Above the ground, which is at -10.9 m and lower there.
        above = omma.study.Box((-50, -10.5, -50), (50, 10, 50))
        for measure in ("linear", "compoundray"):
            searches("natural stand-in", omma.load_scene(natural), above, measure)
    flight = omma.load_poses(ROOT / "examples" / "flight.csv")
    searches("meadow, along flight.csv", omma.load_scene(MEADOW), flight, "linear")
    if arena_file.exists():
        published(arena)
        worth(arena, omma.load_eye(scenes / "eyes" / "1000-equidistant.eye"), found)


def published(arena: omma.Scene) -> None:
    """CompoundRay's search in the arena with several seeds."""
    table("seed", "rays/sr", "where its script stops (published: 1,065)", "worst at (m)")
    stops = []
    for seed in range(8):
        one = omma.study.minimum_samples(
            arena, ARENA_PLACE, method=COMPOUNDRAY, measure="compoundray", seed=seed, progress=show
        )
        stops.append(one.script_rays_per_sr)
        place = " ".join(f"{v:.2f}" for v in one.pose[:3, 3])
        row(seed, f"{one.rays_per_sr:,}", f"{one.script_rays_per_sr:,}", place)
    say(f"\nScript stops: {min(stops):,} to {max(stops):,}, median {np.median(stops):,.0f}.")


def worth(arena: omma.Scene, eye: omma.Eye, found: list[omma.study.MinimumSamples]) -> None:
    """How far the responses of a real eye scatter with the rays that the rule gives it."""
    table("method", "rays per ommatidium", "largest standard deviation", "root mean square")
    pose = arena.camera("insect-eye-equidistant").world_from_camera.copy()
    pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)
    for one in found:
        by_rule = omma.study.rays_per_ommatidium(eye, one.rays_per_sr)
        for rays in (by_rule, 4 * by_rule, one.rays_per_sr):
            variance = omma.study.response_variances(
                arena, eye, pose, rays=rays, repeats=64, method=one.method, seeds=4
            )
            rms = np.sqrt(variance.mean())
            row(one.method.name, rays, f"{np.sqrt(variance.max()):.3f}", f"{rms:.4f}")


def maps(scenes: Path) -> None:
    """Maps of the arena and of the meadow."""
    plans = [("meadow", MEADOW, (0, 1, 0), 20.0)]
    if (scenes / "ofstad-arena.gltf").exists():
        plans.append(("arena", scenes / "ofstad-arena.gltf", (0, 2, 0), 17.0))
    for name, file, centre, size in plans:
        variance = omma.study.variance_map(
            omma.load_scene(file), centre, size, steps=41, statistic="mean", progress=show
        )
        picture = DOCS / f"sampling-map-{name}.png"
        omma.study.save_variance_map(picture, variance, centre, size, statistic="mean")
        least, most = np.sqrt([variance.min(), variance.max()])
        say(
            f"\nMap of the {name}: {size:g} m wide at y = {centre[1]} m, {least:.3f} to {most:.3f}."
        )


def aliasing(scenes: Path) -> None:
    """The alias demonstration: two eyes, in CompoundRay's natural scene."""
    natural = scenes / "natural-standin-sky.gltf"
    if not natural.exists():
        return
    scene, rays = omma.load_scene(natural), [2**k for k in range(10)]
    names = {"variable": "1000-horizontallyAcute-variableDegree", "equidistant": "1000-equidistant"}
    for short, name in names.items():
        eye = omma.load_eye(scenes / "eyes" / f"{name}.eye")
        curves = {
            method: omma.study.alias_curve(
                scene, eye, np.eye(4), rays, repeats=32, method=method, progress=show
            )
            for method in (COMPOUNDRAY, omma.study.Method("gaussian", "random"), OURS)
        }
        omma.study.save_alias_curves(DOCS / f"sampling-aliasing-{short}.png", rays, curves)
        say(f"\n{name}: SD / solid angle (1/sr), and in brackets the root mean square SD")
        table("rays", *(method.name for method in curves))
        for k, n in enumerate(rays):
            row(n, *(f"{per_sr[k]:.3g} ({rms[k]:.2g})" for per_sr, rms in curves.values()))


def speed(scenes: Path) -> None:
    """The speed test in the arena, with the eye of the published one."""
    arena_file = scenes / "ofstad-arena.gltf"
    if not arena_file.exists():
        return
    scene = omma.load_scene(arena_file)
    pose = scene.camera("panoramic").world_from_camera.copy()
    pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)
    eye = omma.load_eye(scenes / "eyes" / "1000-equidistant.eye")
    found = omma.study.measure_speed(scene, eye, pose, frames=50, progress=show)
    omma.study.save_speed_test(DOCS / "sampling-speed.png", found)
    table("rays per ommatidium", "frames/s", "frames/s, all in one call")
    for n, single, batch in zip(found.rays, found.frames_per_s, found.batch_frames_per_s):
        row(f"{n:,}", f"{single:,.0f}", f"{batch:,.0f}")
    say(f"\n{found.backend}, {found.threads} threads")


def main() -> None:
    """Make what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = ROOT.parent / "shared" / "data" / "compound-ray"
    parser.add_argument("--data", type=Path, default=default, help="CompoundRay's scenes and eyes")
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}")
    chosen = parser.parse_args()
    unknown = set(chosen.parts) - set(PARTS)
    if unknown:
        parser.error(f"expected {', '.join(PARTS)}, found {', '.join(sorted(unknown))}")
    say(f"{machine_name()}, Omma {omma.__version__}")
    work = (minimum_samples, maps, aliasing, speed)
    for name, make in zip(PARTS, work, strict=True):
        if not chosen.parts or name in chosen.parts:
            make(chosen.data / "scenes")


if __name__ == "__main__":
    main()
