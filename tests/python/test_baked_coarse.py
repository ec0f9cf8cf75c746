"""Cells whose light is known badly are not read where the eye sees them: however coarse they are, a
response is that of its own place. A trench with black walls and a white floor of two cells, open to
the sky or below a strip that shines.
"""

from dataclasses import replace

import numpy as np
import pytest
from lit_checks import BAND, look_many, matter, shining

import omma
from omma.light import Disc, uniform_sky
from omma.scene import Bake, Instance, Mesh

WIDTH_M, DEPTH_M, LENGTH_M = 1.0, 1.0, 40.0
# Of the whole floor one triangle is a cell. Its 16 paths find the sky now and then.
BAKE = Bake(cell_m=2 * LENGTH_M, paths=16, cache=False)
# From one wall, which a floor of one value would not tell apart.
X_M = np.array([0.02, 0.1, 0.25, 0.5])
REPEATS = 40


def strip(x_m, y_m, material):
    """A rectangle along z that crosses x as given, (2,) each."""
    z = LENGTH_M / 2
    corners = [[x_m[0], y_m[0], z], [x_m[1], y_m[1], z], [x_m[1], y_m[1], -z], [x_m[0], y_m[0], -z]]
    return Mesh(corners, [[0, 1, 2], [0, 2, 3]], material=material)


def baked_trench(light, *above, sun="exact"):
    """A world whose floor's cells are coarse."""
    meshes = [
        strip((0, WIDTH_M), (0, 0), 0),
        strip((0, 0), (DEPTH_M, 0), 1),
        strip((WIDTH_M, WIDTH_M), (0, DEPTH_M), 1),
        *above,
    ]
    scene = omma.Scene(
        meshes=meshes,
        materials=[matter(1.0), matter(0.0), shining(1.0)],
        instances=[Instance(k, name=f"strip {k}") for k in range(len(meshes))],
    )
    world = omma.World(scene, light=light, lighting="baked", sun=sun, bake=BAKE)
    assert world.baked.error_median > 0.2
    return world


def seen_of_floor(world, samples):
    """What places at X_M send straight up, (REPEATS, place); each from a place along z of its own,
    with random numbers of its own."""
    z = np.linspace(-2, 2, REPEATS)
    x, z = (each.ravel() for each in np.meshgrid(X_M, z))
    at = np.column_stack([x, np.full(x.size, 0.5), z])
    seen, error = look_many(world, at, (0, -1, 0), samples=samples, repeats=2)
    assert (seen >= 0).all()
    return seen[:, 0].reshape(REPEATS, len(X_M)), error


def sine_to(x_m, y_m):
    return x_m / np.hypot(x_m, y_m)


@pytest.mark.parametrize("sun", ["exact", "map"])
def test_sky_and_sun_over_a_trench(sun):
    sky = uniform_sky(1.0, below=0, bands=BAND, unit="watts")
    # From the zenith, as much as half the sky. A map of the sun says nothing of the sky.
    radius = 0.005
    disc = Disc((0, 1, 0), radius, [0.5 / np.sin(radius) ** 2])
    world = baked_trench(replace(sky, discs=(disc,)), sun=sun)
    seen, _ = seen_of_floor(world, samples=256)
    # The part of a uniform sky that a floor between endless walls gets: the mean of the sines of
    # both rims' angles from the zenith.
    exact = 0.5 + (sine_to(X_M, DEPTH_M) + sine_to(WIDTH_M - X_M, DEPTH_M)) / 2
    error = seen.std(axis=0, ddof=1) / np.sqrt(REPEATS)
    assert (error < 0.01 * exact).all()
    assert (np.abs(seen.mean(axis=0) - exact) < 4 * error).all()
    # Which no single value is.
    assert exact.max() > 1.05 * exact.min()


def test_a_strip_that_shines_over_a_trench():
    """It is sampled as by paths, not found by chance."""
    dark = uniform_sky(1e-12, below=0, bands=BAND, unit="watts")
    half_m, height_m = 0.005, 0.9
    lamp = strip((WIDTH_M / 2 + half_m, WIDTH_M / 2 - half_m), (height_m, height_m), 2)
    world = baked_trench(dark, lamp)
    seen, _ = seen_of_floor(world, samples=256)
    first, last = WIDTH_M / 2 - half_m - X_M, WIDTH_M / 2 + half_m - X_M
    exact = (sine_to(last, height_m) - sine_to(first, height_m)) / 2
    error = seen.std(axis=0, ddof=1) / np.sqrt(REPEATS)
    # Of 2 x 256 x REPEATS rays found by chance, 1 / sqrt(n exact) would be 0.09 to 0.11.
    assert (error < 0.03 * exact).all()
    assert (np.abs(seen.mean(axis=0) - exact) < 4 * error).all()
