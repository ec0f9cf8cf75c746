"""Baked light is that of the points of a cell that eyes see."""

import numpy as np
import pytest
from lit_checks import BAND, eyes_at, matter, square

import omma
from omma.light import uniform_sky
from omma.scene import Bake

# Tiles and boards in rows along x, with gaps.
TILES_X_M = 0.2 * np.arange(-10, 10)


def seen_beside_boards(side):
    """The mean of white tiles seen from above, whose other halves lie under or over black boards.

    Args:
        side: 1: the boards lie above the tiles, -1: below.
    """
    tiles = [square(0.1, (x, 0, 0), (0, 1, 0), 0) for x in TILES_X_M]
    boards = [square(0.1, (x + 0.05, side * 1e-4, 0), (0, 1, 0), 1) for x in TILES_X_M]
    scene = omma.Scene(meshes=[*tiles, *boards], materials=[matter(1.0), matter(0.0)])
    sky = uniform_sky(1.0, below=0, bands=BAND, unit="watts")
    world = omma.World(
        scene, light=sky, lighting="baked", bake=Bake(cell_m=0.2, paths=32, cache=False)
    )
    assert world.baked.cells == 4 * len(TILES_X_M)
    u, v = np.random.default_rng(6).uniform(0, 1, (2, len(TILES_X_M), 50))
    x, z = TILES_X_M[:, None] - 0.045 + 0.04 * u, 0.09 * v - 0.045
    eye = eyes_at(np.column_stack([x.ravel(), np.full(x.size, 0.05), z.ravel()]), (0, -1, 0))
    return omma.Renderer(world, eye, omma.Fixed(4)).render(np.eye(4)).mean()


def test_what_lies_under_things_does_not_count():
    # Boards so low take a thousandth of the sky from what they leave free.
    assert seen_beside_boards(1) == pytest.approx(1, rel=0.005)


def test_what_lies_behind_does_not_hide():
    assert seen_beside_boards(-1) == pytest.approx(1, rel=2**-11)
