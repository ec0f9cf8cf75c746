"""Makes the pictures of the docs: docs/meadow.png.

    .venv/bin/python docs/make_figures.py

Above what is there, seen by a dense eye of one narrow ommatidium per pixel; below the same place
through the two eyes of the bundled honeybee, each apart and empty outside its visual field.
"""

from pathlib import Path

import numpy as np

import omma

ROOT = Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 1440, 720


def dense_eye(width: int, height: int) -> omma.Eye:
    """One ommatidium per pixel of an equirectangular picture, row by row from the top left."""
    azimuth = np.radians((np.arange(width) + 0.5) / width * 360 - 180)
    elevation = np.radians(90 - (np.arange(height) + 0.5) / height * 180)
    azimuth, elevation = np.meshgrid(azimuth, elevation)
    axis = np.stack(
        [
            np.sin(azimuth) * np.cos(elevation),
            np.sin(elevation),
            -np.cos(azimuth) * np.cos(elevation),
        ],
        axis=-1,
    ).reshape(-1, 3)
    count = len(axis)
    return omma.Eye(
        position_m=np.zeros((count, 3)),
        axis=axis,
        acceptance_angle_rad=np.full(count, np.pi / height),
        focal_offset_m=np.zeros(count),
    )


def main() -> None:
    """Render both views and save the figure."""
    scene = omma.load_scene(ROOT / "examples" / "meadow.glb")
    sides = ("left", "right")
    bee = omma.eye.merge_eyes(
        [omma.load_eye(ROOT / "examples" / f"honeybee_worker_{side}.eye") for side in sides]
    )
    dense = dense_eye(WIDTH, HEIGHT)
    sharp = omma.Renderer(scene, dense, omma.Fixed(16)).render("bee")[0]
    seen = omma.Renderer(scene, bee, omma.Fixed(256)).render("bee")[0]
    omma.picture.plot_responses(
        ROOT / "docs" / "meadow.png",
        [dense, bee],
        [sharp, seen],
        titles=["What is there", f"Honeybee worker, {len(bee) // 2:,} ommatidia"],
    )


if __name__ == "__main__":
    main()
