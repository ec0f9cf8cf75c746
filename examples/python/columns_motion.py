"""What a fruit fly's columns see of a meadow that it flies over, and the motion on them.

Two ways of one flight: rendered for the ommatidia of the right eye and brought onto the 721 hexals
of flyvis-like models with stated weights (docs/motion-detection.md), in the shape that these take;
and in place of a trained network, of which there is none here, the elementary motion detector of
omma.motion between neighbouring hexals.

python examples/python/columns_motion.py -o columns.png
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import omma

RATE_HZ, FRAMES, SPEED_M_S, HEIGHT_M = 200.0, 60, 1.0, 0.5
TAU_S, HIGH_PASS_TAU_S = 0.035, 0.25
SPACING_DEG, TOWARDS_DEG = 5.0, (75.0, 0.0)


def watch(rays=16):
    """Columns, light [sample, frame, channel, hexal] and motion vectors (T, 721, 2)."""
    eye = omma.species.drosophila().eye
    columns = omma.columns.hexal_columns(
        15, np.radians(SPACING_DEG), omma.eye.direction(*TOWARDS_DEG)
    )
    there = omma.columns.seen_by(eye, columns)
    weights = omma.columns.resampling_matrix(eye, columns.chosen(there))
    along = SPEED_M_S * np.arange(FRAMES) / RATE_HZ
    poses = np.tile(np.eye(4), (FRAMES, 1, 1))
    poses[:, :3, 3] = [0.1, HEIGHT_M, 4.7] - along[:, None] * [0, 0, 1]
    renderer = omma.Renderer(omma.load_scene(omma.examples.meadow()), eye, omma.Fixed(rays))
    seen = omma.columns.resample(renderer.render(poses)[:, :, 1:2], weights)  # green
    light = omma.columns.to_hexals(seen, columns.chosen(there), fill=np.nan)
    # Detectors between all neighbours among the hexals; where the eye does not look it is dark.
    lattice = omma.columns.eye_of_columns(columns, np.radians(SPACING_DEG))
    detectors = omma.motion.detector_array(
        lattice, TAU_S, RATE_HZ, pairs=omma.columns.column_pairs(columns),
        high_pass_tau_s=HIGH_PASS_TAU_S,
    )  # fmt: skip
    frames = np.nan_to_num(light[0, :, 0]) / np.nanmean(light)
    motion = detectors.vectors(detectors.run(frames))
    motion[:, ~there] = np.nan
    return columns, light, motion


def draw(path, columns, light, motion):
    u, v = omma.columns.hexals(15).T
    x, y = np.sqrt(3) / 2 * v, -(u + v / 2)  # as flyvis draws them: the front on the right
    figure, panels = plt.subplots(1, 2, figsize=(12, 6.2), layout="constrained")
    shade = np.clip(light[0, -1, 0], 0, 1) ** (1 / 2.2)
    seen = panels[0].scatter(x, y, c=shade, s=95, marker="H", cmap="gray", vmin=0, vmax=1)
    panels[0].set_title("Green light of the last frame (hexals; root of 2.2)", fontsize=10)
    figure.colorbar(seen, ax=panels[0], shrink=0.6, label="brightness as displayed")
    mean = np.nanmean(motion[FRAMES // 3 :], axis=0)
    # Vectors are to the right and up as the right eye sees; the picture has its front on the right.
    size = np.hypot(*mean.T)
    shown = np.flatnonzero(size > 0.02 * np.nanmax(size))
    ahead = mean[shown] * (-1, 1) / size[shown, None] * np.sqrt(size[shown, None] / np.nanmax(size))
    panels[1].scatter(x, y, c="0.9", s=95, marker="H")
    back = panels[1].quiver(
        *np.stack([x, y], 1)[shown].T, *ahead.T, ahead[:, 0], cmap="coolwarm", clim=(-1, 1),
        angles="xy", scale_units="xy", scale=0.5, width=0.004,
    )  # fmt: skip
    panels[1].set_title("Motion over 0.2 s (length: root of the detectors' output)", fontsize=10)
    figure.colorbar(back, ax=panels[1], shrink=0.6, label="to the front (above 0), to the back")
    for panel in panels:
        panel.set(aspect="equal", xticks=[], yticks=[])
        panel.set_xlabel("back   ←   in the right eye   →   front")
        panel.set_ylabel("ventral   ←      →   dorsal")
    figure.suptitle("A fly flies over a meadow: 721 hexals, columns of its right eye", fontsize=11)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="columns.png", help="the figure")
    asked = parser.parse_args()
    columns, light, motion = watch()
    print(f"light {light.shape}: [sample, frame, channel, hexal]")
    print(f"hexals that the eye does not see: {np.isnan(light[0, 0, 0]).sum()}")
    to_the_right = np.nanmean(motion[FRAMES // 3 :, :, 0])
    print(f"mean motion, to the back: {to_the_right:.2e}")
    draw(asked.output, columns, light, motion)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
