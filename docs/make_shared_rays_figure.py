"""Makes docs/shared-rays.png and prints its numbers in docs/sampling.md.

    .venv/bin/python docs/make_shared_rays_figure.py [--data FOLDER] [--quick]

FOLDER holds CompoundRay's scenes and eyes (scenes/natural-standin-sky.gltf,
bees/AM_60185-real.eye, ...); without it the left half and the bundled meadow are all there is.
Some minutes; --quick measures the first scene only.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import omma

ROOT = Path(__file__).resolve().parent.parent
DOCS, EXAMPLES = ROOT / "docs", ROOT / "examples"
OWN, SHARED = (1, 2, 4, 8, 16, 32, 64), (1, 2, 4, 8, 16)
SIGMA_PER_FWHM = 1 / np.sqrt(8 * np.log(2))
BLUE, RED, GREY = "#1f5fa8", "#c2452d", "#8a8a8a"


def demand_per_sr(eye: omma.Eye, directions: np.ndarray) -> np.ndarray:
    """Sum of the sampling densities of all ommatidia, per steradian and sample."""
    sigma = np.asarray(eye.acceptance_angle_rad) * SIGMA_PER_FWHM
    angle = 2 * np.arcsin(
        np.clip(np.linalg.norm(directions[:, None] - np.asarray(eye.axis)[None], axis=2) / 2, 0, 1)
    )
    return (np.exp(-0.5 * (angle / sigma) ** 2) / (2 * np.pi * sigma**2)).sum(axis=1)


def lattice(points: int) -> np.ndarray:
    """Fibonacci points on the sphere (Swinbank and Purser 2006)."""
    i = np.arange(points)
    z = 1 - (2 * i + 1) / points
    azimuth = np.pi * (3 - np.sqrt(5)) * i
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), z], 1)


def tangent_degrees(directions: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Degrees right and up of the centre, (N, 2)."""
    right = np.cross(centre, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, centre)
    return np.degrees(np.stack([directions @ right, directions @ up], 1))


def draw_lattice(axes: plt.Axes, eye: omma.Eye, samples: int, half_width_deg: float) -> None:
    """Axes, rays, and what the rays weigh in one ommatidium."""
    towards = np.asarray(eye.axis)
    one = int(np.argmax(towards @ (0.9, 0.1, -0.4)))  # well inside the right eye
    centre = towards[one]
    near = towards @ centre > np.cos(np.radians(2 * half_width_deg))
    density = float(demand_per_sr(eye, centre[None])[0]) * samples
    rays = lattice(int(4 * np.pi * density))
    rays = rays[rays @ centre > np.cos(np.radians(1.5 * half_width_deg))]
    place = tangent_degrees(rays, centre)
    sigma = np.degrees(float(np.asarray(eye.acceptance_angle_rad)[one])) * SIGMA_PER_FWHM
    weight = np.exp(-0.5 * (place**2).sum(1) / sigma**2)
    used = weight > np.exp(-8)
    axes.scatter(*place[~used].T, s=5, color=GREY, linewidths=0)
    axes.scatter(*place[used].T, s=5 + 75 * weight[used], color=BLUE, alpha=0.75, linewidths=0)
    axes.scatter(*tangent_degrees(towards[near], centre).T, s=26, marker="x", color="k", lw=0.9)
    axes.add_patch(plt.Circle((0, 0), sigma / SIGMA_PER_FWHM / 2, fill=False, color=RED, lw=1.4))
    axes.set(
        xlim=(-half_width_deg, half_width_deg), ylim=(-half_width_deg, half_width_deg),
        aspect="equal", xlabel="right (degrees)", ylabel="up (degrees)",
        title=f"{samples} rays an ommatidium: {used.sum()} count for the one in the middle",
    )  # fmt: skip
    handles = [
        plt.Line2D([], [], ls="", marker="x", color="k", label="axis of an ommatidium"),
        plt.Line2D([], [], ls="", marker=".", color=GREY, label="ray"),
        plt.Line2D([], [], ls="", marker="o", color=BLUE, label="ray, by its weight in the middle"),
        plt.Line2D([], [], color=RED, label="acceptance angle of the middle one"),
    ]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2,
                frameon=False, fontsize=9)  # fmt: skip


def rms(errors: np.ndarray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(errors))))


def neighbours_correlation(eye: omma.Eye, errors: np.ndarray) -> float:
    """Correlation of the errors of ommatidia with that of the nearest axis; errors (seed, N, C)."""
    axes = np.asarray(eye.axis)
    pick = np.random.default_rng(1).choice(len(axes), 400, replace=False)
    cosine = axes[pick] @ axes.T
    cosine[np.arange(len(pick)), pick] = -2
    other = cosine.argmax(axis=1)
    mine, theirs = errors[:, pick].ravel(), errors[:, other].ravel()
    return float(np.mean(mine * theirs) / np.sqrt(np.mean(mine**2) * np.mean(theirs**2)))


def rays_for(target: float, rays: list[float], errors: list[float]) -> float:
    """Where the error falls to the target, between the measured points on a log-log plot."""
    order = np.argsort(errors)
    return float(np.exp(np.interp(np.log(target), np.log(errors)[order], np.log(rays)[order])))


def measure(name: str, scene: omma.Scene, eye: omma.Eye, pose: np.ndarray, many: int):
    """Error per rays, own and shared, over that of 100 random rays; prints a row of the table."""
    own = omma.Renderer(scene, eye, omma.Fixed(many), seed=99)
    exact = own.render(pose)[0].astype(float)
    hundred_rays = own.with_eye(eye, omma.Fixed(100), points="random", noise="new_every_frame")
    random = hundred_rays.render(np.tile(pose, (4, 1, 1)))
    hundred = rms(random - exact)
    curves = []
    for way, counts in ((omma.Fixed, OWN), (omma.Shared, SHARED)):
        rays, errors = [], []
        for count in counts:
            seeds = [own.with_eye(eye, way(count), seed=seed) for seed in range(6)]
            rays.append(seeds[0].rays_per_frame / len(eye))
            found = np.stack([one.render(pose)[0] for one in seeds]) - exact
            errors.append(rms(found) / hundred)
            if way is omma.Shared and count == 2:
                together = neighbours_correlation(eye, found)
        curves.append((rays, errors))
    shared_rays, own_rays = rays_for(1, *curves[1]), rays_for(1, *curves[0])
    # What all seeds have in common is due to the nodal points; the product of two halves has no
    # noise left on average.
    half = [
        np.mean(
            [
                own.with_eye(eye, omma.Shared(64), seed=seed).render(pose)[0] - exact
                for seed in seeds
            ],
            axis=0,
        )
        for seeds in ((0, 1, 2, 3), (4, 5, 6, 7))
    ]
    nodal = np.sqrt(max(0.0, float(np.mean(half[0] * half[1]))))
    print(
        f"| {name} | {own_rays:.1f} | {shared_rays:.1f} | {own_rays / shared_rays:.1f} | "
        f"{nodal / hundred:.3f} | {together:.2f} |", flush=True,
    )  # fmt: skip
    return curves


def measure_overlap(scene: omma.Scene, eye: omma.Eye, poses: np.ndarray) -> None:
    """Error with shared rays over that without, where fields overlap more and more."""
    axes = np.asarray(eye.axis)
    cosine = axes @ axes.T
    np.fill_diagonal(cosine, -1)
    spacing = np.degrees(np.median(np.arccos(cosine.max(axis=1))))
    print(f"\n{len(eye)} axes, nearest neighbours {spacing:.1f} degrees apart")
    print("| acceptance, degrees | sharing | rays | 4 samples | 16 | 64 |")
    built = omma.Renderer(scene, eye, omma.Fixed(1))
    for acceptance in (2.6, 4, 5, 6, 8, 10, 16):
        as_wide = eye.replace(acceptance=np.radians(acceptance))
        exact = built.with_eye(as_wide, omma.Fixed(4096), seed=99).render(poses)
        row = []
        for samples in (4, 16, 64):
            errors = []
            for way in (omma.Shared, omma.Fixed):
                found = [built.with_eye(as_wide, way(samples), seed=seed) for seed in range(6)]
                errors.append(rms(np.stack([one.render(poses) for one in found]) - exact))
                if way is omma.Shared and samples == 16:
                    sharing = np.mean(found[0].shared_ommatidia)
                    rays = found[0].rays_per_frame / len(eye) / samples
            row.append(errors[0] / errors[1])
        print(
            f"| {acceptance:g} | {100 * sharing:.0f} % | {rays:.2f} | "
            + " | ".join(f"{ratio:.2f}" for ratio in row) + " |", flush=True,
        )  # fmt: skip


def measure_building(scene: omma.Scene, eye: omma.Eye) -> None:
    """Seconds on one thread that shared rays take to make, and how many share."""
    print(f"\nmade for {len(eye)} ommatidia, on one thread:")
    built = omma.Renderer(scene, eye, omma.Fixed(1), threads=1)
    for samples in (1, 2, 4, 16, 64, 256):
        seconds = [
            min(
                built.with_eye(
                    eye, way(samples), seed=seed
                ).build_times["directions_s"]
                for seed in range(3)
            )
            for way in (omma.Shared, omma.Fixed)
        ]  # fmt: skip
        print(f"{samples:4d} samples: {seconds[0] - seconds[1]:.3f} s", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    everything = ROOT.parent / "shared" / "data" / "compound-ray"
    parser.add_argument("--data", type=Path, default=everything)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    data = arguments.data
    figure, (left, right) = plt.subplots(1, 2, figsize=(12.4, 6.4), layout="constrained")
    cases = []
    if data.is_dir():
        eye = omma.load_eye(data / "bees" / "AM_60185-real.eye")
        pose = np.eye(4)
        pose[1, 3] = 0.15
        meadow = omma.load_scene(data / "scenes" / "natural-standin-sky.gltf")
        cases.append(("meadow", meadow, pose))
        arena = omma.load_scene(data / "scenes" / "ofstad-arena.gltf")
        camera = next(c for c in arena.cameras if c.type == "compound")
        pose = np.array(camera.world_from_camera)
        pose[:3, :3] /= np.linalg.norm(pose[:3, 0])
        cases.append(("arena", arena, pose))
    else:
        eye = omma.load_eye(EXAMPLES / "honeybee_worker_right.eye")
    bundled = omma.load_scene(EXAMPLES / "meadow.glb")
    cases.append(("bundled meadow", bundled, np.array(bundled.camera("bee").world_from_camera)))
    draw_lattice(left, eye, 4, 4.2)
    measure_building(cases[0][1], eye)
    if data.is_dir() and not arguments.quick:
        turned = np.stack([cases[0][2], cases[0][2]])
        turned[1, :3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
        few = omma.load_eye(data / "scenes" / "eyes" / "1000-equidistant.eye")
        measure_overlap(cases[1][1], few, turned)
    print("| scene | own | shared | times fewer | nodal points | neighbours |")
    for k, (name, scene, pose) in enumerate(cases[: 1 if arguments.quick else None]):
        curves = measure(name, scene, eye, pose, 4096)
        if k > 0:
            continue
        for (rays, errors), color, label in zip(
            curves, (GREY, BLUE), ("own rays", "shared rays"), strict=True
        ):
            right.loglog(rays, errors, "o-", color=color, label=label, ms=5)
        right.axhline(1, color=RED, lw=1, ls="--", label="100 random rays")
        right.set(
            xlabel="rays traced per ommatidium", title=f"The {name}",
            ylabel="RMS error over that of 100 random rays",
        )  # fmt: skip
        right.set_xticks(OWN, [str(n) for n in OWN])
        right.minorticks_off()
        right.set_yticks([0.2, 0.5, 1, 2, 5, 10], ["0.2", "0.5", "1", "2", "5", "10"])
        right.grid(alpha=0.3)
        right.legend(frameon=False)
    figure.savefig(DOCS / "shared-rays.png", dpi=110)


if __name__ == "__main__":
    main()
