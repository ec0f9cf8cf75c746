"""Makes docs/cloud-shadows.png: a plain below clouds, and the sun along a walk over it.

    .venv/bin/python docs/make_cloud_shadow_figure.py

Some seconds on two cores.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import omma
from omma.base.figures import COLOURS, GREY, figure_style, save_figure
from omma.light import Bands, clear_sky, clouded
from omma.scene import Instance, Material, Mesh

DOCS = Path(__file__).resolve().parent
SIZE_M, PIXELS, ABOVE_M, LINE_Z_M = 8000.0, 320, 200.0, 500.0
BANDS = Bands.equal(3, 400, 700)


def main() -> None:
    clear = clear_sky(35, sun_azimuth_deg=135, bands=BANDS)
    light = clouded(clear, 0.4, "cumulus", seed=1, shadow_height_m=1000)
    half = SIZE_M
    corners = [(-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half)]
    plain = omma.Scene(
        meshes=[Mesh(corners, [(0, 1, 2), (0, 2, 3)], material=0)],
        materials=[Material(base_color=(0.12, 0.2, 0.06, 1), specular=0.0)],
        instances=[Instance(mesh=0)],
    )
    world = omma.World(plain, light=light)
    # One ommatidium that looks straight down from a little above, at each place of the plain.
    at = (np.arange(PIXELS) + 0.5) / PIXELS * SIZE_M - SIZE_M / 2
    east, south = np.meshgrid(at, at)
    poses = np.tile(np.eye(4), (PIXELS * PIXELS, 1, 1))
    poses[:, 0, 3], poses[:, 1, 3], poses[:, 2, 3] = east.ravel(), ABOVE_M, south.ravel()
    down = omma.Eye([(0, 0, 0)], [(0, -1, 0)], [0.0])
    seen = omma.Renderer(world, down, omma.Fixed(16)).render(poses)[:, 0]
    colours = omma.picture.bands_to_rgb(seen, light).reshape(PIXELS, PIXELS, 3)

    figure_style()
    figure = Figure(figsize=(9.2, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.35])
    km = SIZE_M / 2000
    picture = omma.picture.display(0.45 * colours / np.quantile(colours, 0.995))
    left.imshow(picture, extent=(-km, km, -km, km))
    left.plot([-km, km], [-LINE_Z_M / 1000] * 2, color="white", lw=1)
    left.plot(0, 0, "o", ms=5, color="white", mec="black", mew=0.6)
    box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    left.annotate("world's origin", (0.2, 0.2), fontsize="small", bbox=box)
    x, _, z = 0.85 * km * clear.discs[0].direction
    left.annotate(
        "to the sun", (x * 1.5, -z * 1.5), (x * 0.6, -z * 0.75), fontsize="small", bbox=box,
        arrowprops={"arrowstyle": "->", "color": "white", "lw": 1.5},
    )  # fmt: skip
    left.set(xlabel="east (+X), km", ylabel="north (−Z), km", title="the plain from above")

    walk = np.zeros((2000, 3))
    walk[:, 0], walk[:, 2] = np.linspace(-SIZE_M / 2, SIZE_M / 2, len(walk)), LINE_Z_M
    assert light.cloud_shadow is not None
    share = light.cloud_shadow.transmittance(walk, clear.discs[0].direction)
    row = int((LINE_Z_M + SIZE_M / 2) / SIZE_M * PIXELS)
    ground = seen.reshape(PIXELS, PIXELS, 3)[row, :, 1]
    right.plot(walk[:, 0] / 1000, share, color=COLOURS[0], lw=1, label="of the sun, closed form")
    right.plot(
        at / 1000, ground / ground.max(), ".", ms=3, color=COLOURS[1],
        label="the ground at 550 nm over its brightest, rendered",
    )  # fmt: skip
    right.axhline(0, color=GREY, lw=0.6)
    right.set(
        xlabel="along the white line, km east", ylabel="share", xlim=(-km, km), ylim=(-0.02, 1.25),
        title="on a walk: sun and shade; in the shade the sky is left",
    )  # fmt: skip
    right.legend(frameon=False, loc="upper left")
    save_figure(figure, [str(DOCS / "cloud-shadows.png")], dpi=102)


if __name__ == "__main__":
    main()
