"""Makes docs/light-air.png: the lit meadow through three airs, and contrast by distance.

    .venv/bin/python docs/make_air_figure.py

Half a minute on two cores.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import omma
from omma.base.figures import COLOURS, GREY, figure_style, save_figure
from omma.light import Bands, Light, clear_sky, overcast_sky, with_air

DOCS = Path(__file__).resolve().parent
CAMERA, ELEVATION_DEG, PER_DEG = "bee", 35.0, 4
# What the pictures show, degrees.
LEFT, RIGHT, LOW, HIGH = -55, 55, -24, 26
RAYS = 32
VISIBILITY_M = 2000.0


def picture(light: Light) -> NDArray[np.uint8]:
    """Of the meadow from its camera, as people see it: an ommatidium a pixel."""
    width, height = (RIGHT - LEFT) * PER_DEG, (HIGH - LOW) * PER_DEG
    azimuth_deg = LEFT + (np.arange(width) + 0.5) / PER_DEG
    elevation_deg = HIGH - (np.arange(height) + 0.5) / PER_DEG
    axis = omma.eye.direction(azimuth_deg, elevation_deg[:, None]).reshape(-1, 3)
    eye = omma.Eye(np.zeros_like(axis), axis, acceptance_angle_rad=np.radians(1 / PER_DEG))
    world = omma.World(omma.load_scene(omma.examples.lit_meadow()), light=light)
    seen = omma.Renderer(world, eye, omma.Fixed(RAYS)).render(CAMERA)[0]
    colours = omma.picture.bands_to_rgb(seen, light).reshape(height, width, 3)
    return omma.picture.display(1 - np.exp(-colours / (1.6 * colours.mean())))


def contrasts(light: Light, distances_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of black walls to the horizon behind them, rendered: (distance, band)."""
    found = []
    for far in distances_m:
        corners = [(-far, -far, -far), (far, -far, -far), (far, far, -far), (-far, far, -far)]
        scene = omma.Scene(
            meshes=[omma.scene.Mesh(corners, [(0, 1, 2), (0, 2, 3)], material=0)],
            materials=[omma.scene.Material(base_color=(0, 0, 0, 1), specular=0.0)],
            instances=[omma.scene.Instance(mesh=0)],
        )
        world = omma.World(scene, light=light, ultraviolet="dark")
        eye = omma.Eye([(0, 0, 0)], [(0, 0, -1)], [0.0])
        found.append(omma.Renderer(world, eye, omma.Fixed(1)).render(np.eye(4))[0, 0])
    return np.asarray(1 - np.array(found) / light.radiance((0, 0, -1))[0])


def main() -> None:
    figure_style()
    figure = Figure(figsize=(9.2, 5.0), layout="constrained")
    grid = figure.add_gridspec(2, 3, height_ratios=[1.0, 1.35])
    clear = clear_sky(ELEVATION_DEG, sun_azimuth_deg=135)
    overcast = overcast_sky(ELEVATION_DEG)
    airs = [
        ("the air of a clear sky", with_air(clear)),
        ("mist, visibility 60 m, 20 m high", with_air(clear, 60, layer_height_m=20)),
        ("fog, visibility 15 m, 10 m high", with_air(overcast, 15, layer_height_m=10)),
    ]
    for k, (words, light) in enumerate(airs):
        panel = figure.add_subplot(grid[0, k])
        panel.imshow(picture(light), extent=(LEFT, RIGHT, LOW, HIGH), interpolation="nearest")
        panel.set_title(words, loc="left")
        panel.set_xticks([LEFT + 5, 0, RIGHT - 5], ["50° left", "ahead", "50° right"])
        panel.set_yticks([-20, 0, 20], ["−20°", "0°", "20°"] if k == 0 else ["", "", ""])
        panel.tick_params(length=2, labelsize="small")
        panel.spines[:].set_visible(False)

    panel = figure.add_subplot(grid[1, :])
    three = Bands.equal(3, 320, 680)
    light = with_air(clear_sky(ELEVATION_DEG, sun_azimuth_deg=135, bands=three), VISIBILITY_M)
    assert light.extinction_per_m is not None
    distances_m = np.linspace(100, 4000, 14)
    found = contrasts(light, distances_m)
    line_m = np.linspace(0, 4200, 200)
    for b, colour in enumerate(COLOURS[:3]):
        middle_nm = 380 + 120 * b
        panel.plot(line_m / 1000, np.exp(-light.extinction_per_m[b] * line_m), color=colour, lw=1)
        panel.plot(
            distances_m / 1000, found[:, b], "o", color=colour, ms=4,
            label=f"{middle_nm - 60} to {middle_nm + 60} nm",
        )  # fmt: skip
    panel.axhline(0.05, color=GREY, lw=0.8, ls=":")
    panel.axvline(VISIBILITY_M / 1000, color=GREY, lw=0.8, ls=":")
    panel.set(
        xlabel="distance of a black wall, km", ylabel="contrast to the horizon", yscale="log",
        xlim=(0, 4.2), ylim=(0.002, 1.1),
        title="visibility 2 km: rendered (points) and exp(−σ d), Koschmieder (lines)",
    )  # fmt: skip
    panel.legend(frameon=False)
    save_figure(figure, [str(DOCS / "light-air.png")], dpi=102)


if __name__ == "__main__":
    main()
