"""Makes docs/all-cameras.png: every camera of CompoundRay's scenes, on one sheet.

    .venv/bin/python docs/make_camera_figures.py [--scenes FOLDER]

Each scene goes through what ``omma render-cameras SCENE`` does, and, beside it, through
CompoundRay's functions under their old name.
"""

import argparse
import ctypes
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
OLD_SAMPLES = 200  # rays per ommatidium through the old name
COLUMNS = 3  # cameras in a row, two pictures each
CELL_IN = (2.8, 1.4)  # inches of a picture's place, 2 to 1 as most of them are
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
    old: np.ndarray  # uint8 RGB, the same camera through the old name


def coloured_ids(rgba: np.ndarray) -> np.ndarray:
    """Ids as omma writes them, each in a colour of its own."""
    ids = rgba.astype(np.uint32) @ np.array([1 << 24, 1 << 16, 1 << 8, 1], np.uint32)
    colors = np.random.default_rng(5).integers(40, 256, (int(ids.max()) + 1, 3), dtype=np.uint8)
    return colors[ids]


def old_library(scene: Path) -> ctypes.CDLL:
    """CompoundRay's library with a scene loaded."""
    library = ctypes.CDLL(omma.compat.compoundray_library())
    library.getCameraCount.restype = ctypes.c_size_t
    library.getCurrentEyeOmmatidialCount.restype = ctypes.c_size_t
    library.getFramePointer.restype = ctypes.POINTER(ctypes.c_ubyte)
    library.setVerbosity(False)
    library.loadGlTFscene(str(scene).encode())
    return library


def old_picture(library: ctypes.CDLL, index: int, kind: str, projection: str) -> np.ndarray:
    """A camera's frame, top row first. Perspective ones are square: they know no aspect ratio."""
    library.gotoCamera(index)
    library.setCurrentEyeSamplesPerOmmatidium(OLD_SAMPLES)
    width, height = WIDTH, WIDTH // 2
    if kind in ("perspective", "orthographic"):
        width = height
    if projection == "single_dimension_fast":
        width, height = library.getCurrentEyeOmmatidialCount(), 1
    library.setRenderSize(width, height)
    library.renderFrame()
    frame = np.ctypeslib.as_array(library.getFramePointer(), (height, width, 4))
    return frame[::-1].copy()


def pictures_of(scene: Path) -> list[Shown]:
    """Every camera of a scene."""
    shown = []
    with tempfile.TemporaryDirectory() as folder:
        report = omma.job.render_all_cameras(scene, folder, omma.Fixed(64), width=WIDTH)
        library = old_library(scene)
        assert library.getCameraCount() == len(report.cameras)
        for index, camera in enumerate(report.cameras):
            pixels = np.asarray(Image.open(camera.output))
            old = old_picture(library, index, camera.type, camera.projection)
            kind = camera.type + (f", {camera.projection}" if camera.projection else "")
            if camera.projection.endswith("_ids"):
                pixels, old = coloured_ids(pixels), coloured_ids(old)
                kind += " (in random colours)"
            if len(pixels) == 1:
                kind += " (stretched)"
            name = camera.name.removesuffix("_Orientation")
            shown.append(Shown(scene.name, name, kind, pixels[..., :3], old[..., :3]))
        library.stop()
    return shown


def draw(axes: plt.Axes, pixels: np.ndarray, label: str) -> None:
    """A picture in its cell; a single row of pixels is stretched to fill it."""
    axes.set_xticks([])
    axes.set_yticks([])
    if len(pixels) == 1:
        pixels = np.repeat(pixels, pixels.shape[1] // 2, axis=0)
    axes.imshow(pixels, interpolation="antialiased")
    axes.set_xlabel(label, fontsize=7, labelpad=2)


def main() -> None:
    """Render all scenes and save the sheet."""
    parser = argparse.ArgumentParser(description="Makes docs/all-cameras.png.")
    parser.add_argument(
        "--scenes", type=Path, default=ROOT.parent / "shared/data/compound-ray/scenes"
    )
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "all-cameras.png")
    arguments = parser.parse_args()
    shown: list[Shown] = []
    for name in SCENES:
        shown += pictures_of(arguments.scenes / name)
    rows = -(-len(shown) // COLUMNS)
    figure = plt.figure(
        figsize=(COLUMNS * 2 * CELL_IN[0], rows * (CELL_IN[1] + 0.75)), layout="constrained"
    )
    cells = np.atleast_2d(figure.subfigures(rows, COLUMNS))
    for one, cell in zip(shown, cells.flat):
        cell.suptitle(f"{one.scene}, {one.camera}\n{one.kind}", fontsize=8)
        left, right = cell.subplots(1, 2)
        draw(left, one.pixels, "omma render")
        draw(right, one.old, "libEyeRenderer3")
    figure.suptitle(
        "Every camera of CompoundRay's scenes: omma render-cameras SCENE, and "
        "the same through CompoundRay's functions"
    )
    figure.supxlabel(NOTE, fontsize=8)
    figure.savefig(arguments.output, dpi=100)
    print(f"{arguments.output}: {len(shown)} cameras")


if __name__ == "__main__":
    main()
