"""Makes docs/thin-films.png: what two stacks of layers reflect, and balls of them and of gold.

.venv/bin/python docs/make_thin_film_figure.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import omma
from omma.scene import LayerStack, refractive_index

FOLDER = Path(__file__).resolve().parent
NM = np.arange(300.0, 701.0)
ANGLES = [0, 15, 30, 45, 60, 75]
SPLIT_DEG = 60  # whose s and p are drawn
# Twice the optical thickness of a pair of layers is the wavelength of the peak.
PEAK_NM = 530.0
DEPTH_NM = PEAK_NM / 2 / (1.7 + 1.6)

STACKS = {
    "Morpho-like scales": LayerStack(
        [(80, 1.31), (130, 1.0)] * 6, substrate=1.56 + 0.06j, spread=0.06
    ),
    "jewel beetle, Chrysochroa": LayerStack(
        [(DEPTH_NM, 1.7), (DEPTH_NM, 1.6)] * 8, substrate=1.6, spread=0.02
    ),
    "gold": LayerStack(substrate=refractive_index("gold")),
}
ROUGHNESS = 0.3
WIDTH, HEIGHT, RAYS = 540, 190, 64


def spectra(panel: Axes, title: str, stack: LayerStack) -> None:
    a, b, _ = np.moveaxis(stack.mueller(NM, ANGLES), -1, 0)
    for k, angle in enumerate(ANGLES):
        color = plt.get_cmap("plasma")(0.9 * k / (len(ANGLES) - 1))
        panel.plot(NM, a[:, k], color=color, lw=1.7, label=f"{angle}°")
        if angle == SPLIT_DEG:
            panel.plot(NM, a[:, k] + b[:, k], color=color, lw=1, ls="--", label=f"{angle}°, s")
            panel.plot(NM, a[:, k] - b[:, k], color=color, lw=1, ls=":", label=f"{angle}°, p")
    panel.axvspan(300, 400, color="0.93", lw=0)
    panel.set_title(title, loc="left", fontsize=10)
    panel.set_xlim(300, 700)
    panel.set_ylim(0, 1)
    panel.set_xlabel("wavelength (nm)", fontsize=9)
    panel.tick_params(labelsize=8.5)
    panel.spines[["top", "right"]].set_visible(False)


def balls() -> tuple[np.ndarray, np.ndarray]:
    """Three balls in a row: as people see them, and their degree of polarisation, 0 to 1."""
    light = omma.light.clear_sky(40, sun_azimuth_deg=150)
    scenes = []
    for i, (name, stack) in enumerate(STACKS.items()):
        ball = omma.scene.sphere(0.5, center_m=(1.15 * (i - 1), 0, 0), segments=192)
        scenes.append(ball.replace(materials=[stack.material(name, ROUGHNESS)]))
    scene = omma.scene.merge_scenes(scenes)
    world = omma.World(scene, light=light, polarized=True, lighting="path")
    across, up = np.meshgrid(np.linspace(-1.8, 1.8, WIDTH), np.linspace(0.62, -0.62, HEIGHT))
    axes = np.stack([across, up, np.full_like(up, -6.0)], axis=-1).reshape(-1, 3)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    eye = omma.Eye(np.zeros_like(axes), axes, np.radians(0.03))
    pose = omma.look_at((0, 0, 6), (0, 0, 0))
    stokes = omma.Renderer(world, eye, omma.Fixed(RAYS)).render_stokes(pose)[0]
    stokes = stokes.reshape(HEIGHT, WIDTH, 3, -1)
    colours = omma.picture.bands_to_rgb(stokes[:, :, 0], light)
    i, q, u = np.moveaxis(stokes.sum(axis=-1, dtype=float), -1, 0)
    return omma.picture.display(np.clip(0.6 * colours, 0, 1)), np.hypot(q, u) / i


def main() -> None:
    figure, rows = plt.subplot_mosaic(
        "AB;CC;DD", figsize=(9.6, 9.4), height_ratios=[1.25, 1.1, 1.1], layout="constrained"
    )
    for panel, (title, stack) in zip("AB", STACKS.items()):
        spectra(rows[panel], title, stack)
    rows["A"].set_ylabel("reflectance", fontsize=9)
    rows["B"].legend(fontsize=8, frameon=False, loc="upper right", title="angle of incidence",
                     title_fontsize=8)  # fmt: skip
    seen, degree = balls()
    rows["C"].imshow(seen)
    rows["C"].set_title("under a clear sky, as people see them", loc="left", fontsize=10)
    shown = rows["D"].imshow(degree, cmap="magma", vmin=0, vmax=1)
    rows["D"].set_title("degree of polarisation, all bands together", loc="left", fontsize=10)
    figure.colorbar(shown, ax=rows["D"], fraction=0.02, pad=0.01)
    for panel in "CD":
        rows[panel].set_xticks([])
        rows[panel].set_yticks([])
        for i, name in enumerate(STACKS):
            rows[panel].text(
                WIDTH * (i * 1.15 - 1.15 + 1.8) / 3.6, HEIGHT - 6, name,
                color="white", fontsize=8.5, ha="center", va="bottom",
            )  # fmt: skip
    figure.savefig(FOLDER / "thin-films.png", dpi=100)


if __name__ == "__main__":
    main()
