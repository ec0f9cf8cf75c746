"""Makes the pictures of the docs: docs/meadow.png.

    .venv/bin/python docs/make_figures.py

Above what is there, seen by a dense eye of one narrow ommatidium per pixel; below the same place
through the two eyes of the bundled honeybee, grey outside their visual field.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import omma

ROOT = Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 1440, 720
EXTENT = (-180, 180, -90, 90)


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
    sharp = omma.Renderer(scene, dense_eye(WIDTH, HEIGHT), omma.Fixed(16)).render("bee")[0]
    sharp_picture = omma.picture.paint(
        np.arange(WIDTH * HEIGHT, dtype=np.int32).reshape(HEIGHT, WIDTH), sharp
    )
    seen = omma.Renderer(scene, bee, omma.Fixed(256)).render("bee")[0]
    seen_picture = omma.picture.paint(omma.picture.field_ids(bee, WIDTH, HEIGHT), seen)

    figure, axes = plt.subplots(2, 1, figsize=(9, 9.6), layout="constrained", sharex=True)
    titles = ("What is there", f"What a honeybee worker sees: {len(bee):,} ommatidia, Δρ 2.6°")
    for panel, picture, title in zip(axes, (sharp_picture, seen_picture), titles, strict=True):
        panel.imshow(picture, extent=EXTENT, interpolation="nearest")
        panel.set_title(title, loc="left")
        panel.set_ylabel("elevation (°)")
        panel.set_xticks(range(-180, 181, 45))
        panel.set_yticks(range(-90, 91, 45))
    axes[1].set_xlabel("azimuth (°): left of the bee – ahead – right")
    figure.savefig(ROOT / "docs" / "meadow.png", dpi=110)


if __name__ == "__main__":
    main()
