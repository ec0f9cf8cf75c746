"""Makes docs/all-cameras.png: every camera of CompoundRay's scenes, on one sheet.

    .venv/bin/python docs/make_camera_figures.py [--scenes FOLDER] [--ppm FOLDER]

Each scene goes through what ``omma render SCENE --all-cameras`` does. With --ppm every picture has
a second one below it, of the same camera, from FOLDER/<scene without ending>/<camera>.ppm: those
that a script saved through the library under its old name.
"""

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

import omma

ROOT = Path(__file__).resolve().parent.parent
SCENES = (
    "natural-standin-sky.gltf",
    "test-scene.gltf",
    "test-scene-sky.gltf",
    "env_2.gltf",
    "environment.glb",
    "ofstad-arena.gltf",
)
WIDTH = 600  # pixels of a picture
COLUMNS = 4
CELL_IN = (3.6, 1.8)  # inches of a picture's place, 2 to 1 as most of them are
NOTE = (
    "env_2.gltf and environment.glb: their cameras stand inside the black sphere in the middle, "
    "from where the experiment moves them; the eye in env_2.gltf is larger than the sphere and "
    "sees the white walls."
)


@dataclass
class Shown:
    """A picture and what is written above it."""

    scene: str
    camera: str
    kind: str
    pixels: np.ndarray  # uint8 RGB
    other: np.ndarray | None  # the same camera through the old name


def coloured_ids(rgba: np.ndarray) -> np.ndarray:
    """Ids as omma writes them, each in a colour of its own."""
    ids = rgba.astype(np.uint32) @ np.array([1 << 24, 1 << 16, 1 << 8, 1], np.uint32)
    colors = np.random.default_rng(5).integers(40, 256, (int(ids.max()) + 1, 3), dtype=np.uint8)
    return colors[ids]


def pictures_of(scene: Path, ppm: Path | None) -> list[Shown]:
    """Every camera of a scene."""
    shown = []
    with tempfile.TemporaryDirectory() as folder:
        report = omma.render_all_cameras(scene, folder, width=WIDTH, samples=64)
        for camera in report.cameras:
            pixels = np.asarray(Image.open(camera.output))
            kind = camera.type + (f", {camera.projection}" if camera.projection else "")
            if camera.projection.endswith("_ids"):
                pixels, kind = coloured_ids(pixels), kind + " (in random colours)"
            if len(pixels) == 1:
                kind += " (stretched)"
            other = None
            if ppm is not None:
                file = ppm / scene.stem / f"{Path(camera.output).stem}.ppm"
                other = np.asarray(Image.open(file)) if file.is_file() else None
            name = camera.name.removesuffix("_Orientation")
            shown.append(Shown(scene.name, name, kind, pixels[..., :3], other))
    return shown


def draw(axes: plt.Axes, pixels: np.ndarray | None) -> None:
    """A picture in its cell; a single row of pixels is stretched to fill it."""
    axes.set_xticks([])
    axes.set_yticks([])
    if pixels is None:
        axes.axis("off")
        return
    if len(pixels) == 1:
        pixels = np.repeat(pixels, pixels.shape[1] // 2, axis=0)
    axes.imshow(pixels, interpolation="antialiased")


def main() -> None:
    """Render all scenes and save the sheet."""
    parser = argparse.ArgumentParser(description="Makes docs/all-cameras.png.")
    parser.add_argument(
        "--scenes", type=Path, default=ROOT.parent / "shared/data/compound-ray/scenes"
    )
    parser.add_argument("--ppm", type=Path, help="pictures through the old name, to set below")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "all-cameras.png")
    arguments = parser.parse_args()
    shown: list[Shown] = []
    for name in SCENES:
        shown += pictures_of(arguments.scenes / name, arguments.ppm)
    each = 1 if arguments.ppm is None else 2  # rows of axes for one row of pictures
    rows = -(-len(shown) // COLUMNS)
    size = (COLUMNS * CELL_IN[0], rows * (each * CELL_IN[1] + 0.5))
    figure, axes = plt.subplots(each * rows, COLUMNS, figsize=size, layout="constrained")
    for index in range(rows * COLUMNS):
        row, column = each * (index // COLUMNS), index % COLUMNS
        if index >= len(shown):
            for below in range(each):
                axes[row + below, column].axis("off")
            continue
        one = shown[index]
        draw(axes[row, column], one.pixels)
        title = f"{one.scene}\n{one.camera}"
        axes[row, column].set_title(f"{title}\n{one.kind}", fontsize=8)
        if each == 2:
            draw(axes[row + 1, column], one.other)
            axes[row + 1, column].set_title("through libEyeRenderer3", fontsize=7)
    figure.suptitle("Every camera of CompoundRay's scenes: omma render SCENE --all-cameras")
    figure.supxlabel(NOTE, fontsize=8)
    figure.savefig(arguments.output, dpi=110)
    print(f"{arguments.output}: {len(shown)} cameras")


if __name__ == "__main__":
    main()
