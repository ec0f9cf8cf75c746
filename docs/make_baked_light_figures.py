"""Makes docs/baked-light.png: three scenes by paths, with baked light, and the difference of both.

.venv/bin/python docs/make_baked_light_figures.py          some 5 minutes on two cores
.venv/bin/python docs/make_baked_light_figures.py draft    coarse and noisy, a minute
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import omma
from omma.base.figures import figure_style, save_figure
from omma.light import Light
from omma.scene import Instance, Material, Mesh

DOCS = Path(__file__).resolve().parent
FULL_PERCENT = 20.0  # at the ends of the scale of differences
BANDS = omma.light.Bands.equal(6, 400, 700)
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Setup:
    """A scene with its light, and what is looked at."""

    title: str
    scene: omma.Scene
    light: Light
    pose: NDArray[np.float64]  # where it is seen from
    height_deg: float  # of the picture
    cell_m: float


def wall(corner: Point, along: Point, up: Point, paint: Point) -> omma.Scene:
    """A rectangle without thickness, seen from both sides: its corner and its two edges, m."""
    one, first, second = (np.array(each, float) for each in (corner, along, up))
    positions = [one, one + first, one + first + second, one + second]
    surface = Mesh(np.array(positions), np.array([[0, 1, 2], [0, 2, 3]]), material=0)
    material = Material(base_color=(*paint, 1.0), double_sided=True)
    return omma.Scene(meshes=[surface], materials=[material], instances=[Instance(0)])


def room() -> Setup:
    """A room of 4 x 5 x 2.5 m with a window in its right wall, through which the sun shines, and a
    door ahead that ends 3 cm above the floor. Floor and walls meet in their edges."""
    white, wood, red = (0.7, 0.7, 0.68), (0.45, 0.3, 0.18), (0.5, 0.12, 0.08)
    parts = [
        wall((-2, 0, 2.5), (4, 0, 0), (0, 0, -5), wood),
        wall((-2, 2.5, -2.5), (4, 0, 0), (0, 0, 5), white),
        wall((-2, 0, 2.5), (0, 0, -5), (0, 2.5, 0), white),
        wall((2, 0, 2.5), (-4, 0, 0), (0, 2.5, 0), white),
        # Right, around a window of 1.2 x 1.2 m.
        wall((2, 0, -2.5), (0, 0, 5), (0, 0.9, 0), white),
        wall((2, 2.1, -2.5), (0, 0, 5), (0, 0.4, 0), white),
        wall((2, 0.9, -2.5), (0, 0, 1.5), (0, 1.2, 0), white),
        wall((2, 0.9, 0.2), (0, 0, 2.3), (0, 1.2, 0), white),
        # Ahead, around the door.
        wall((-2, 0, -2.5), (1.5, 0, 0), (0, 2.5, 0), white),
        wall((0.4, 0, -2.5), (1.6, 0, 0), (0, 2.5, 0), white),
        wall((-0.5, 2, -2.5), (0.9, 0, 0), (0, 0.5, 0), white),
        wall((-0.5, 0.03, -2.5), (0.9, 0, 0), (0, 1.97, 0), red),
        omma.scene.sphere(0.3, (0.6, 0.6, 0.6), center_m=(1.1, 0.3, -1.5), segments=32),
        omma.scene.box((0.9, 0.06, 0.6), wood, center_m=(-1.3, 0.7, -1.5)),
    ]
    at = omma.look_at((0.2, 1.5, 2.4), (0.0, 1.1, -2.5))
    light = omma.light.clear_sky(35, sun_azimuth_deg=75, bands=BANDS)
    return Setup("a room with one window", omma.scene.merge_scenes(parts), light, at, 69, 0.25)


def leaves() -> Setup:
    """A box of 1 m without a lid, in it 1,500 leaves of 10 cm, which let light through. It stands
    on ground that goes on below it."""
    rng = np.random.default_rng(5)
    count = 1500
    middle = rng.uniform((-0.45, 0.05, -0.45), (0.45, 0.95, 0.45), (count, 3))
    across = rng.normal(size=(count, 3))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(across, rng.normal(size=(count, 3)))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    corners = np.stack(
        [middle + 0.05 * along, middle + 0.02 * across, middle - 0.05 * along,
         middle - 0.02 * across], axis=1
    )  # fmt: skip
    first = 4 * np.arange(count)[:, None]
    foliage = omma.Scene(
        meshes=[
            Mesh(
                corners.reshape(-1, 3),
                np.concatenate([first + (0, 1, 2), first + (0, 2, 3)]),
                material=0,
            )
        ],
        materials=[omma.scene.natural_material("green leaf")],
        instances=[Instance(0)],
    )
    card, ground = (0.6, 0.5, 0.35), (0.3, 0.28, 0.25)
    parts = [
        foliage,
        wall((-0.5, 0, 0.5), (0, 0, -1), (0, 1, 0), card),
        wall((0.5, 0, 0.5), (0, 0, -1), (0, 1, 0), card),
        wall((-0.5, 0, -0.5), (1, 0, 0), (0, 1, 0), card),
        wall((-0.5, 0, 0.5), (1, 0, 0), (0, 0.3, 0), card),
        omma.scene.plane((3, 3), ground),
    ]
    at = omma.look_at((0.4, 1.3, 1.75), (0, 0.42, 0))
    light = omma.light.clear_sky(50, sun_azimuth_deg=200, bands=BANDS)
    return Setup("a box of leaves", omma.scene.merge_scenes(parts), light, at, 43, 0.1)


def corridor() -> Setup:
    """A corridor of 6 x 1 x 1 m with striped walls, floor and ceiling, open at both ends; a box
    hangs in it, 10 cm above the floor."""
    stripes = np.array([[[0.08, 0.08, 0.08], [0.75, 0.75, 0.75]]])
    walls = omma.scene.corridor(
        6, 1, 1, stripes, stripes, floor=(0.35, 0.33, 0.3), ceiling=(0.6, 0.6, 0.6),
        picture_length_m=1.0, sharp=True,
    )  # fmt: skip
    box = omma.scene.box((0.25, 0.25, 0.25), (0.6, 0.25, 0.1), center_m=(-0.2, 0.225, -2.2))
    at = omma.look_at((0, 0.5, -0.5), (0, 0.45, -6))
    light = omma.light.clear_sky(25, sun_azimuth_deg=20, bands=BANDS)
    return Setup("a corridor", omma.scene.merge_scenes([walls, box]), light, at, 63, 0.25)


@dataclass(frozen=True)
class Found:
    """Pictures (H, W, 3) by paths and baked, their difference (H, W) in percent, and numbers."""

    by_paths: NDArray[np.float32]
    baked: NDArray[np.float32]
    percent: NDArray[np.float64]
    numbers: str


def pixels(width: int, height: int, height_deg: float) -> omma.Eye:
    """An eye with an ommatidium for each pixel of a flat picture, row by row from the top left."""
    half = np.tan(np.radians(height_deg) / 2)
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * half * width / height
    y = (1 - (np.arange(height) + 0.5) / height * 2) * half
    towards = np.stack([*np.meshgrid(x, y), np.full((height, width), -1.0)], axis=-1)
    axis = (towards / np.linalg.norm(towards, axis=-1, keepdims=True)).reshape(-1, 3)
    return omma.Eye(np.zeros_like(axis), axis, acceptance_angle_rad=2 * half / height)


def compare(setup: Setup, width: int, rays: int, paths: int) -> Found:
    """Both ways, each in two halves with random numbers of their own, which tell its noise."""
    bake = omma.scene.Bake(cell_m=setup.cell_m, paths=paths)
    world = omma.World(setup.scene, light=setup.light, lighting="baked", bake=bake)
    by_paths = world.with_light(setup.light, lighting="path")
    eye = pixels(width, round(width * 0.75), setup.height_deg)
    seen = [
        [
            omma.picture.bands_to_rgb(
                omma.Renderer(one, eye, omma.Fixed(rays // 2), seed=seed).render(setup.pose)[0],
                setup.light,
            ).reshape(round(width * 0.75), width, 3)
            for seed in (1, 2)
        ]
        for one in (by_paths, world)
    ]
    reference, baked = (sum(halves) / 2 for halves in seen)
    scale = 100 / float((reference @ LUMINANCE).mean())
    percent = (baked - reference) @ LUMINANCE * scale
    noise = [float((((a - b) / 2) @ LUMINANCE * scale).std()) for a, b in seen]
    numbers = (
        f"rms {np.sqrt((percent**2).mean()):.2f} %, bias {percent.mean():+.2f} %".replace("-", "−")
        + f" of the mean\nnoise of the pictures {noise[0]:.2f} % and {noise[1]:.2f} %"
    )
    print(setup.title, numbers, world.baked, f"largest {np.abs(percent).max():.1f} %", sep="\n  ")
    return Found(reference, baked, percent, numbers)


def exposed(picture: NDArray[np.float32], reference: NDArray[np.float32]) -> NDArray[np.uint8]:
    """For the screen; both pictures of a scene alike."""
    film = 1 - np.exp(-np.clip(picture, 0, None) * (0.6 / np.median(reference @ LUMINANCE)))
    return omma.picture.display(film.astype(np.float32))


def figure(setups: list[Setup], found: list[Found]) -> Figure:
    """A row of three pictures for each scene."""
    drawing = Figure(figsize=(7.2, 2.2 * len(setups) + 0.8), layout="constrained")
    panels = drawing.subplots(len(setups), 3)
    for row, setup, one in zip(panels, setups, found):
        row[0].imshow(exposed(one.by_paths, one.by_paths))
        row[1].imshow(exposed(one.baked, one.by_paths))
        shown = row[2].imshow(one.percent, cmap="RdBu_r", vmin=-FULL_PERCENT, vmax=FULL_PERCENT)
        row[0].set_ylabel(setup.title)
        row[2].set_xlabel(one.numbers, fontsize="small")
        for panel in row:
            panel.set(xticks=[], yticks=[])
            panel.spines[:].set_visible(False)
    for panel, title in zip(panels[0], ("by paths", "baked", "baked − paths")):
        panel.set_title(title)
    bar = drawing.colorbar(
        shown, ax=panels, location="bottom", shrink=0.5, aspect=40, extend="both", pad=0.02
    )
    bar.set_label("difference of luminance, % of the picture's mean")
    bar.outline.set_visible(False)
    return drawing


def main() -> None:
    draft = sys.argv[1:] == ["draft"]
    width, rays, paths = (96, 16, 16) if draft else (120, 1024, 512)
    setups = [room(), leaves(), corridor()]
    found = [compare(one, width, rays, paths) for one in setups]
    with figure_style(8.0):
        save_figure(figure(setups, found), [str(DOCS / "baked-light.png")])


if __name__ == "__main__":
    main()
