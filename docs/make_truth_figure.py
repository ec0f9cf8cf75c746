"""Makes the figure of docs/ground-truth.md: what a fruit fly in the meadow sees, how far away, of
what, and how it moves past, flying ahead and turning.

.venv/bin/python docs/make_truth_figure.py
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.patches as patches
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import omma
from omma.picture.eye_maps import project_directions

OUT = Path(__file__).resolve().parent / "ground-truth.png"
# Ahead, and to the right: a flight of fruit flies and a slow saccade.
SPEED_M_S, TURN_DEG_S = 0.5, 100.0
ARROWS_S = 0.2
KINDS = {
    "grass": (("turf", "grass", "blades", "verges"), (0.35, 0.62, 0.20)),
    "flowers": (
        ("poppies", "daisies", "buttercups", "clover", "cornflowers"), (0.80, 0.25, 0.45),
    ),
    "trees and hedges": (("oak", "birch", "tree", "hedge", "bush"), (0.12, 0.33, 0.30)),
    "land, path, stones": (("land", "path", "stone"), (0.76, 0.62, 0.42)),
}  # fmt: skip
SKY = (0.80, 0.89, 0.97)
WIDTH = 900
# Arrows on a grid of this step, radians, so that none lies on another.
STEP = 0.21


def main() -> None:
    scene = omma.load_scene(omma.examples.meadow())
    eye = omma.species.drosophila().eye
    renderer = omma.Renderer(scene, eye, omma.Fixed(64))
    pose = scene.camera("bee").world_from_camera
    ahead, up = -pose[:3, 2], pose[:3, 1]
    flying = (SPEED_M_S * ahead, np.zeros(3))
    turning = (np.zeros(3), -np.radians(TURN_DEG_S) * up)
    kind_of, names = kinds_of(renderer.world)
    truth = renderer.ground_truth(pose, shares=names, head_velocity=flying)
    turned = renderer.ground_truth(pose, head_velocity=turning)

    figure, panels = plt.subplots(3, 2, figsize=(12, 11), layout="constrained")
    seen, distance, shares, spread, flown, turns = panels.ravel()
    ids = omma.picture.projection_ids(eye, "mollweide", WIDTH, WIDTH // 2)
    shown = omma.picture.display(truth.responses) / 255  # (1, N, 3)
    show(seen, paint(ids, shown[0]), "What it sees")
    image = show(
        distance, paint(ids, truth.distance_m[0, :, None])[..., 0],
        "Mean distance of what is met (white: sky alone)",
        norm=LogNorm(0.3, 300), cmap="viridis_r",
    )  # fmt: skip
    add_bar(figure, image, distance, [0.3, 1, 3, 10, 30, 100, 300], "distance (m)")
    show(shares, paint(ids, mixed(truth, kind_of)), "What fills the field, by shares")
    colours = [*((name, colour) for name, (_, colour) in KINDS.items()), ("sky", SKY)]
    # The mean of 1/distance is what a translation makes flow of.
    image = show(
        spread, paint(ids, truth.inverse_distance_per_m[0, :, None])[..., 0],
        "Mean inverse distance, 0 where sky is", vmin=0, vmax=2, cmap="viridis",
    )  # fmt: skip
    add_bar(figure, image, spread, [0, 1, 2], "1/distance (per metre)")
    shares.legend(
        handles=[patches.Patch(color=colour, label=name) for name, colour in colours],
        loc="upper center", bbox_to_anchor=(0.5, 0.02), ncols=5, frameon=False, fontsize=9,
        handlelength=1.2, columnspacing=1.2,
    )  # fmt: skip
    chosen = thinned(eye)
    for panel, motion, colour, title in (
        (flown, truth, "#0072b2", f"Optic flow, flying ahead at {SPEED_M_S:g} m/s"),
        (turns, turned, "#d55e00", f"Optic flow, turning right at {TURN_DEG_S:g}° per second"),
    ):
        show(panel, np.full((WIDTH // 2, WIDTH, 3), 0.96), title)
        draw_flow(panel, eye, motion.flow_rad_s[0], chosen, colour)
        note = f"arrows: how far in {ARROWS_S:g} s"
        panel.text(0, -1.5, note, ha="center", va="top", fontsize=9)
    figure.savefig(OUT, dpi=110)
    print(f"wrote {OUT.name}")


def kinds_of(world) -> tuple[np.ndarray, list[str]]:
    """Names of all things, each once, and the kind of each."""
    names = sorted({one.name for one in world.instances})

    def kind(name: str) -> int:
        return next(
            k for k, (words, _) in enumerate(KINDS.values()) if any(w in name for w in words)
        )

    return np.array([kind(name) for name in names]), names


def mixed(truth, kind_of) -> np.ndarray:
    """Colours of kinds, each by its share of an ommatidium's field; the rest is sky: (N, 3)."""
    colours = np.array([colour for _, colour in KINDS.values()])
    share = np.stack([truth.shares[0][:, kind_of == k].sum(1) for k in range(len(KINDS))], 1)
    return share @ colours + (1 - truth.met[0])[:, None] * np.array(SKY)


def paint(ids, values) -> np.ndarray:
    """Values of ommatidia (N, C) on the map, NaN where there is none."""
    return np.concatenate([values, np.full((1, values.shape[1]), np.nan)])[ids]


def show(panel, picture, title, **options):
    """A map in its panel, (H, W) or (H, W, 3), white where nothing is seen."""
    extent = (-2 * np.sqrt(2), 2 * np.sqrt(2), -np.sqrt(2), np.sqrt(2))
    if picture.ndim == 3:
        picture = np.where(np.isnan(picture), 1.0, np.clip(picture, 0, 1))
    image = panel.imshow(picture, extent=extent, interpolation="nearest", **options)
    oval = patches.Ellipse((0, 0), 4 * np.sqrt(2), 2 * np.sqrt(2), fill=False, color="0.4", lw=0.8)
    panel.add_patch(oval)
    image.set_clip_path(oval)
    for azimuth, text in ((-90, "left −90°"), (0, "ahead 0°"), (90, "right 90°")):
        x = project_directions(omma.eye.direction(azimuth, 0), "mollweide")[0]
        panel.text(x, 1.46, text, ha="center", va="bottom", fontsize=8, color="0.35")
    panel.set_title(title, pad=16)
    panel.set_xlim(-2.9, 2.9)
    panel.set_ylim(-1.48, 1.6)
    panel.axis("off")
    return image


def thinned(eye) -> np.ndarray:
    """Ommatidia at even distances over the field."""
    axis = eye.axis.astype(float)
    chosen: list[int] = []
    for i in np.argsort(np.abs(axis[:, 1])):
        if not chosen or (axis[chosen] @ axis[i]).max() < np.cos(STEP):
            chosen.append(int(i))
    return np.array(chosen)


def add_bar(figure, image, panel, ticks, label) -> None:
    """A colour bar with plain numbers."""
    bar = figure.colorbar(image, ax=panel, label=label, shrink=0.75, ticks=ticks)
    bar.ax.set_yticklabels([f"{tick:g}" for tick in ticks])
    bar.ax.minorticks_off()


def draw_flow(panel, eye, flow_rad_s, chosen, colour) -> None:
    """Arrows on the map: where what is seen would be after a moment."""
    axis, up = eye.axis[chosen].astype(float), eye.up[chosen].astype(float)
    shift = flow_rad_s[chosen, :1] * np.cross(axis, up) + flow_rad_s[chosen, 1:] * up
    after = axis + ARROWS_S * shift
    after /= np.linalg.norm(after, axis=1, keepdims=True)
    start, end = (project_directions(d, "mollweide") for d in (axis, after))
    step = end - start
    near = np.abs(step[:, 0]) < 1  # not across the map's edge
    panel.quiver(
        *start[near].T, *step[near].T, color=colour, angles="xy", scale_units="xy", scale=1,
        width=0.0035, headwidth=4, headlength=4.5,
    )  # fmt: skip


if __name__ == "__main__":
    main()
