"""Makes docs/neighbours.png: the rows of Drosophila's eyes, by hexagonal coordinates.

.venv/bin/python docs/make_neighbours_figure.py
"""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import omma

OUT = Path(__file__).resolve().parent / "neighbours.png"
COLUMN = {name: k for k, name in enumerate(omma.eye.hexagonal.DIRECTIONS)}
ARROW_STEPS = 5


def main() -> None:
    head = omma.species.drosophila().eye
    found = omma.eye.hexagonal_coordinates(head, "direction")
    figure, panels = plt.subplots(1, 2, figsize=(12, 6.3), layout="constrained")
    for panel, side, name in zip(panels, (-1, 1), ("Left eye", "Right eye")):
        own = np.flatnonzero(found.side == side)
        place = np.full((len(head), 2), np.nan)
        place[own] = flat(head.axis[own].astype(float), side)
        for direction in ("v", "p", "q"):
            other = found.neighbours[own, COLUMN[direction]]
            ends = place[np.stack([own[other >= 0], other[other >= 0]])]
            panel.plot(ends[..., 0], ends[..., 1], color="0.7", lw=0.6)
        known, faults = own[found.known[own]], own[found.fault[own]]
        dots = panel.scatter(
            *place[known].T, c=found.p[known], s=18, cmap="viridis", zorder=2, vmin=-20, vmax=20
        )
        panel.scatter(
            *place[faults].T, s=26, facecolors="none", edgecolors="red", lw=1, zorder=3,
            label="fault: not six neighbours",
        )  # fmt: skip
        draw_arrows(panel, found, known, place)
        panel.set_title(f"{name}, seen from inside the head", pad=16)
        panel.set_aspect("equal")
        panel.axis("off")
        front = 0.99 if side < 0 else 0.01
        panel.text(front, 0.5, "front", transform=panel.transAxes, ha="center", va="center",
                   rotation=90, color="0.3")  # fmt: skip
        panel.text(0.5, 1.0, "dorsal", transform=panel.transAxes, ha="center", color="0.3")
    panels[0].legend(loc="lower left", fontsize=9)
    figure.colorbar(dots, ax=panels, label="p", shrink=0.7)
    figure.savefig(OUT, dpi=110)
    print(f"wrote {OUT.name}")


def flat(axis, side):
    """Lambert's equal-area projection (K, 2) around straight to the side, right and up."""
    x, y, z = axis.T
    return np.stack([z * side, y], axis=1) * np.sqrt(2 / (1 + side * x))[:, None]


def draw_arrows(panel, found, known, place) -> None:
    """Some steps in p, q and v from the place nearest to the middle that has them all."""

    def walked(start, name):
        for _ in range(ARROW_STEPS):
            if start >= 0:
                start = found.neighbours[start, COLUMN[name]]
        return start

    near = known[np.argsort(np.hypot(*place[known].T))]
    start = next(i for i in near if all(walked(i, name) >= 0 for name in ("v", "p", "q")))
    for name in ("v", "p", "q"):
        tip = place[walked(start, name)] - place[start]
        panel.annotate(
            "", place[start] + tip, place[start],
            arrowprops={"arrowstyle": "-|>", "lw": 2.2, "color": "black"}, zorder=4,
        )  # fmt: skip
        panel.text(
            *(place[start] + 1.35 * tip), f"+{name}", weight="bold", ha="center", va="center",
            zorder=5, bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none"},
        )  # fmt: skip


if __name__ == "__main__":
    main()
