"""How many ommatidia see a fly a metre away? A robber fly's against a honeybee's.

A dark fly takes light from an ommatidium: the share of its angular sensitivity that the fly covers.
Drones answer to 8 % less light in one ommatidium (Vallet & Coles 1993, J Comp Physiol A 172:183);
the smallest target that the robber fly attacks, 0.13° (Wardill et al. 2017, Curr Biol 27:854),
takes 6 % in this model. So those that lose 5 % are counted.

python examples/python/fly_at_a_metre.py [directory to write to]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection

import omma

FLY_M = 0.0025  # across
THRESHOLD = 0.05  # of the light
# Points spread evenly over a disc of radius 1: the fly's outline.
_turn = np.arange(300) * np.pi * (3 - 5**0.5)
_away = np.sqrt((np.arange(300) + 0.5) / 300)
DISC = np.stack([_away * np.cos(_turn), _away * np.sin(_turn)], axis=1)


def light_lost(eye, distance_m=1.0, direction=(0.0, 0.0, -1.0)):
    """The share (N,) of each ommatidium's light that a fly in that direction takes."""
    fly = distance_m * np.asarray(direction) / np.linalg.norm(direction)
    towards = fly - eye.position_m
    distance = np.linalg.norm(towards, axis=1)
    towards /= distance[:, None]
    radius = np.arcsin(FLY_M / 2 / distance)
    solid_angle = 2 * np.pi * (1 - np.cos(radius))
    off = np.arctan2(
        np.linalg.norm(np.cross(towards, eye.axis), axis=1), (towards * eye.axis).sum(1)
    )
    lost = np.zeros(len(eye))
    for i in np.flatnonzero(off < 4 * eye.acceptance_angle_rad + radius):
        points = np.array([off[i], 0]) + radius[i] * DISC
        lost[i] = eye.acceptance(i).pdf(np.hypot(*points.T)).mean() * solid_angle[i]
    return lost


def look(eye, distances=(0.1, 0.2, 0.5, 1.0)):
    """[(distance, most light lost, how many ommatidia lose more than the threshold)]."""
    found = []
    for distance in distances:
        lost = light_lost(eye, distance)
        found.append((distance, lost.max(), int((lost > THRESHOLD).sum())))
    return found


def main(directory="out"):
    out = Path(directory)
    out.mkdir(parents=True, exist_ok=True)
    figure, panels = plt.subplots(1, 2, figsize=(9.5, 4.6), layout="constrained", sharey=True)
    print(f"a dark fly of {1e3 * FLY_M:.3g} mm, straight ahead; seen: {THRESHOLD:.0%} less light")
    for panel, name in zip(panels, ("holcocephala", "honeybee_worker")):
        animal = omma.species.make(name)
        print(animal.latin)
        for distance, most, count in look(animal.eye):
            print(f"  {distance:4.1f} m: most light lost {most:7.2%}, seen by {count} ommatidia")
        right = animal.eye.select(1)
        x, y, z = right.axis.T.astype(float)
        at = np.degrees(np.stack([np.arctan2(x, -z), np.arcsin(y)], axis=1))
        width = np.degrees(right.acceptance_angle_rad)
        lost = light_lost(right)
        order = np.argsort(lost)  # those that lose most are drawn on top
        near = order[np.linalg.norm(at[order], axis=1) < 9]
        discs = EllipseCollection(
            width[near],
            width[near],
            np.zeros(len(near)),
            units="xy",
            offsets=at[near],
            transOffset=panel.transData,
            array=100 * lost[near],
            cmap="magma_r",
            clim=(0, 8),
            edgecolors="0.6",
            linewidths=0.5,
            alpha=0.8,
        )
        panel.add_collection(discs)
        panel.add_patch(plt.Circle((0, 0), np.degrees(FLY_M / 2), color="C2"))
        panel.set(
            title=f"{animal.latin}, right eye",
            xlabel="azimuth, degrees",
            xlim=(-4, 4),
            ylim=(-4, 4),
            aspect="equal",
        )
    panels[0].set_ylabel("elevation, degrees")
    panels[0].text(
        0, -3.8, "discs: Δρ of ommatidia; green: the fly", ha="center", backgroundcolor="w"
    )
    figure.colorbar(discs, ax=panels, label="light lost to a fly at 1 m, %")
    figure.savefig(out / "fly_at_a_metre.png", dpi=150)
    print(f"wrote {out / 'fly_at_a_metre.png'}")


if __name__ == "__main__":
    main(*sys.argv[1:])
