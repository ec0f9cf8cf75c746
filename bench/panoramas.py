"""A honeybee before panoramas: frames per second as a sparse matrix, and as rays, in the same run,
with the error that they have.

    python bench/panoramas.py
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

import omma
from omma.rendering import Equirectangular, PanoramaView

FRAMES = 200
ROWS = (90, 180, 360)


def noise(rows: int) -> NDArray[np.float32]:
    """Radiance (rows, 2 rows, 3) with the spectrum of natural scenes."""
    each = [
        omma.stimuli.NoisePanorama(pixel_deg=180 / rows, seed=seed).picture for seed in range(3)
    ]
    return np.stack(each, axis=-1).astype(np.float32)


def rays(eye: omma.Eye, picture: NDArray[np.float32], exact: NDArray[np.float32]) -> None:
    """Frames per second of rays, and their rms error as share of the pictures' standard deviation
    over the eye."""
    # Nearly nothing, with the eye in the middle of it.
    specks = [omma.scene.box((1e-6, 1e-6, 1e-6), center_m=(0, y, 0)) for y in (-0.01, 0.01)]
    world = omma.World(
        omma.scene.merge_scenes(specks), background=omma.Background.image(picture), backend="embree"
    )
    poses = np.tile(np.eye(4), (50, 1, 1))
    for sampling in (omma.Shared(2), omma.Fixed(16), omma.Fixed(256)):
        renderer = omma.Renderer(world, eye, sampling)
        seen = renderer.render(poses[:1])[0]
        start = time.perf_counter()
        renderer.render(poses)
        rate = len(poses) / (time.perf_counter() - start)
        error = np.sqrt(np.mean((seen - exact) ** 2)) / exact.std()
        print(f"    {sampling!r}: {rate:.0f} frames/s, error {error:.2%} of the contrast")


def main() -> None:
    """Prints one size of picture after the other."""
    eye = omma.species.honeybee_worker().eye
    print(f"{len(eye)} ommatidia, acceptance angles of "
          f"{np.degrees(np.median(eye.acceptance_angle_rad)):.1f} deg")  # fmt: skip
    for rows in ROWS:
        picture = noise(rows)
        start = time.perf_counter()
        view = PanoramaView(eye, Equirectangular(rows, 2 * rows))
        ready_s = time.perf_counter() - start
        film = np.tile(picture, (FRAMES, 1, 1, 1))
        exact = view.see(picture)
        start = time.perf_counter()
        view.see(film)
        rate = FRAMES / (time.perf_counter() - start)
        print(f"pixels of {180 / rows:g} deg: ready in {ready_s:.1f} s, "
              f"{view.weights.nnz / len(eye):.0f} weights each, {rate:.0f} frames/s")  # fmt: skip
        rays(eye, picture, exact)


if __name__ == "__main__":
    main()
