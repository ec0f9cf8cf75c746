"""Makes docs/materials-pool.png: a basin without and with water, and the sky from within it.

    .venv/bin/python docs/make_pool_figure.py

Half a minute on two cores.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import omma
from omma.base.figures import figure_style, save_figure
from omma.scene import Material, Mesh, box, cylinder, merge_scenes, water_volume

DOCS = Path(__file__).resolve().parent
DEPTH_M, WIDTH_M = 0.6, 3.0
WIDTH, HEIGHT, RAYS = 330, 250, 64
# Where the pictures are taken from, and how far they look down.
ABOVE_M, DOWN_DEG = (0.0, 0.9, 2.3), 33.0
BELOW_M = (-0.3, -0.3, 0.6)
SKY = omma.light.clear_sky(50, sun_azimuth_deg=130)


def level(y_m: float, material: Material, tiles: int = 1) -> omma.Scene:
    """A level square, of one material, or of squares that are by turns darker."""
    half, size = WIDTH_M / 2, WIDTH_M / tiles
    meshes = []
    for i in range(tiles):
        for k in range(tiles):
            x, z = i * size - half, k * size - half
            corners = [
                (x, y_m, z),
                (x, y_m, z + size),
                (x + size, y_m, z + size),
                (x + size, y_m, z),
            ]
            meshes.append(
                Mesh(corners, [(0, 1, 2), (0, 2, 3)], material=(i + k) % 2 if tiles > 1 else 0)
            )
    dark = material.replace(base_color=(0.13, 0.17, 0.2))
    return omma.Scene(meshes=meshes, materials=[material, dark][: min(tiles, 2)])


def basin(*, filled: bool) -> omma.Scene:
    """Tiles below walls, three posts that stand in it, and a bank of grass around."""
    tile = Material("tile", base_color=(0.55, 0.55, 0.5), specular=0.3)
    grass = omma.scene.natural_material("green sward")
    wall, bank = 0.1, 3.0
    parts = [level(-DEPTH_M, tile, tiles=12)]
    for side in (-1, 1):
        at = side * (WIDTH_M + wall) / 2
        for size, center in (
            ((wall, DEPTH_M + 0.04, WIDTH_M + 2 * wall), (at, -DEPTH_M / 2, 0.0)),
            ((WIDTH_M, DEPTH_M + 0.04, wall), (0.0, -DEPTH_M / 2, at)),
        ):
            parts.append(box(size, center_m=center).replace(materials=[tile]))
        at = side * (WIDTH_M / 2 + wall + bank / 2)
        for size, center in (
            ((bank, 0.02, WIDTH_M + 2 * (wall + bank)), (at, 0.0, 0.0)),
            ((WIDTH_M + 2 * wall, 0.02, bank), (0.0, 0.0, at)),
        ):
            parts.append(box(size, center_m=center).replace(materials=[grass]))
    for x, z, colour in ((-0.7, -0.4, (0.6, 0.1, 0.08)), (0.1, 0.1, (0.6, 0.5, 0.1)),
                         (0.8, -0.7, (0.1, 0.3, 0.6))):  # fmt: skip
        post = cylinder(0.035, DEPTH_M + 0.5, center_m=(x, (0.5 - DEPTH_M) / 2, z), segments=32)
        parts.append(post.replace(materials=[Material(base_color=colour, specular=0.3)] * 2))
    if filled:
        parts.append(level(0.0, water_volume("IB")))
    return merge_scenes(parts)


def picture(
    scene: omma.Scene, position_m: tuple[float, float, float], axes: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Colours as people see them, an ommatidium a pixel; axes: (row, column, 3)."""
    flat = axes.reshape(-1, 3)
    eye = omma.Eye(np.broadcast_to(position_m, flat.shape), flat, np.radians(0.25))
    world = omma.World(scene, light=SKY, lighting="path", ultraviolet="dark")
    seen = omma.Renderer(world, eye, omma.Fixed(RAYS)).render(np.eye(4))[0]
    return np.asarray(omma.picture.bands_to_rgb(seen, SKY).reshape(*axes.shape))


def exposed(colours: NDArray[np.float64], middle: float) -> NDArray[np.uint8]:
    return omma.picture.display(1 - np.exp(-colours / (1.5 * middle)))


def ahead_and_down() -> NDArray[np.float64]:
    """Axes of a pinhole's pixels."""
    x = np.linspace(-0.62, 0.62, WIDTH)
    y = np.linspace(0.47, -0.47, HEIGHT)
    down = np.radians(DOWN_DEG)
    right, up = np.meshgrid(x, y)
    forward = np.stack(
        [right, up * np.cos(down) - np.sin(down), -np.cos(down) - up * np.sin(down)], axis=-1
    )
    return np.asarray(forward / np.linalg.norm(forward, axis=-1, keepdims=True))


def all_above() -> NDArray[np.float64]:
    """Axes of a round picture, its middle the zenith, its rim level."""
    x, y = np.meshgrid(*[np.linspace(-1, 1, HEIGHT)] * 2)
    radius, around = np.minimum(np.hypot(x, y), 1.0), np.arctan2(x, -y)
    zenith = radius * np.pi / 2
    return np.stack(
        [np.sin(zenith) * np.sin(around), np.cos(zenith), -np.sin(zenith) * np.cos(around)], axis=-1
    )


def main() -> None:
    figure_style()
    figure = Figure(figsize=(9.2, 2.9), layout="constrained")
    panels = figure.subplots(1, 3, width_ratios=[WIDTH, WIDTH, HEIGHT])
    dry, wet = basin(filled=False), basin(filled=True)
    without, filled = (picture(scene, ABOVE_M, ahead_and_down()) for scene in (dry, wet))
    middle = float(np.median(without))
    above = picture(wet, BELOW_M, all_above())
    below = exposed(above, float(np.median(above)))
    rows, columns = np.mgrid[-1 : 1 : HEIGHT * 1j, -1 : 1 : HEIGHT * 1j]
    below[np.hypot(rows, columns) > 1] = 255
    pictures = [
        ("without water", exposed(without, middle)),
        ("under 0.6 m of water", exposed(filled, middle)),
        ("up, from 0.3 m below", below),
    ]
    for panel, (words, colours) in zip(panels, pictures, strict=True):
        panel.imshow(colours, interpolation="nearest")
        panel.set_title(words, loc="left")
        panel.set_axis_off()
    save_figure(figure, [str(DOCS / "materials-pool.png")], dpi=130)


if __name__ == "__main__":
    main()
