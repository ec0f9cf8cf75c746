"""Draws docs/eye-design.png and prints the table of docs/eyes.md.

    python docs/make_eye_design_figures.py [folder]

Lattices are laid for several fields of interommatidial angles and compared with them; on two cores
that takes some two minutes, most of it for 30,000 ommatidia.
"""

import sys
import time
from pathlib import Path

import matplotlib
import numpy as np

import omma

matplotlib.use("Agg")
import matplotlib.pyplot as plt

D = np.radians


def off(directions, azimuth_deg, elevation_deg):
    """Angles (K,) from a direction, rad."""
    centre = omma.eye.direction(azimuth_deg, elevation_deg)
    return np.arccos(np.clip(directions @ centre, -1, 1))


def acute(factor):
    zone = omma.eye.AcuteZone(0.0, 0.0, D(60), factor)
    return omma.eye.acute_angle(D(3), zone.density)


def streak(directions):
    return D(0.75) + D(2.25) * (1 - np.exp(-((np.arcsin(directions[:, 1]) / D(20)) ** 2)))


def fovea(directions):
    return D(0.28) + D(4.2) * (1 - np.exp(-((off(directions, 0, 0) / D(12)) ** 2)))


def dragonfly(directions):
    return D(0.24) + D(0.9) * (1 - np.exp(-((off(directions, 0, 53) / D(30)) ** 2)))


ASIDE = omma.eye.window((-20, 160), (-80, 80))
# Name: horizontal and vertical angle, field of view, count.
FIELDS = {
    "all round, even": (D(3), None, None, 5000),
    "upper half, even": (D(3), None, omma.eye.window(elevation_deg=(0, 90)), 5000),
    "acute zone, 4 times as dense": (acute(4), None, ASIDE, 3000),
    "acute zone, 16 times as dense": (acute(16), None, ASIDE, 3000),
    "streak: 3° across, 0.75° to 3° up": (
        D(3),
        streak,
        omma.eye.window((-10, 170), (-50, 50)),
        None,
    ),
    "fovea: 0.28° in a spot, 4.5° around": (fovea, None, ASIDE, None),
    "dragonfly, from 0.24°": (dragonfly, None, ASIDE, 30_000),
}
DRAWN = ["acute zone, 16 times as dense", "streak: 3° across, 0.75° to 3° up",
         "fovea: 0.28° in a spot, 4.5° around"]  # fmt: skip


def scaled(angle, scale):
    if angle is None:
        return None
    return lambda d: scale * (angle(d) if callable(angle) else np.full(len(d), angle))


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent
    print("| field | N | seconds | median error | 95 % below | six neighbours |")
    print("| --- | --- | --- | --- | --- | --- |")
    figure, axes = plt.subplots(2, 3, figsize=(15, 9.5), layout="constrained")
    for name, (across, up, seen, count) in FIELDS.items():
        start = time.perf_counter()
        lattice = omma.eye.lay_directions(across, up, field_of_view=seen, count=count)
        seconds = time.perf_counter() - start
        check = omma.eye.lattice.check_lattice(
            lattice.directions, scaled(across, lattice.scale), scaled(up, lattice.scale)
        )
        print(
            f"| {name} | {len(lattice.directions):,} | {seconds:.0f} | {check.median_error:.1%} | "
            f"{check.p95_error:.1%} | {check.six_fraction:.1%} |",
            flush=True,
        )
        if name in DRAWN:
            draw(axes[:, DRAWN.index(name)], name, lattice.directions, check)
    figure.savefig(folder / "eye-design.png", dpi=90)


def draw(axes, name, directions, check):
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(directions)
    eye = omma.Eye(directions, directions, 0.0)
    degrees = np.degrees(eye.interommatidial_angle_rad())
    size = 3 if len(directions) > 2500 else 5
    # At the rim the six nearest are not all around it: farther away than neighbours are.
    axes[0].scatter(
        azimuth[~check.inner], elevation[~check.inner], c="#c8c8c8", s=size, label="rim"
    )
    inner = check.inner
    dots = axes[0].scatter(
        azimuth[inner], elevation[inner], c=degrees[inner], s=size, cmap="viridis"
    )
    axes[0].legend(loc="lower right", fontsize=8, framealpha=0.9)
    plt.colorbar(dots, ax=axes[0], label="Δφ to the six nearest (°)", orientation="horizontal")
    axes[0].set_title(f"{name}: {len(directions):,}")
    colours = {5: "#d55e00", 7: "#0072b2"}
    for degree, colour in [(6, "#bbbbbb"), (5, colours[5]), (7, colours[7])]:
        chosen = check.inner & (check.degree == degree)
        axes[1].scatter(
            azimuth[chosen], elevation[chosen], c=colour, s=size if degree == 6 else 14,
            label=f"{degree} neighbours",
        )  # fmt: skip
    axes[1].legend(loc="lower right", fontsize=8, framealpha=0.9)
    for axis in axes:
        axis.set_xlabel("azimuth (°)")
        axis.set_ylabel("elevation (°)")
        axis.set_xlim(-25, 85)
        axis.set_ylim(-55, 55)
        axis.set_aspect("equal")


if __name__ == "__main__":
    main()
