"""Glass with a thickness on a surface that bounds no volume is told; blocks and waters are not."""

import warnings

import numpy as np
import pytest
from lit_checks import BAND, square

import omma
from omma.scene import Instance, Material, Mesh, water_volume

GLASS = Material("glass", ior=1.5, transmission=1, roughness=0, thickness_m=0.004)
SKY = omma.light.uniform_sky(1.0, bands=BAND, unit="watts")
SIDES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]


def block(sides=SIDES):
    return [square(2, side, side) for side in sides]


def told(scene):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        omma.World(scene, light=SKY)
    return [str(one.message) for one in found if "thickness_m" in str(one.message)]


def made_of(material, meshes, **more):
    return omma.Scene(meshes=meshes, materials=[material], **more)


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0, -1, 0), (0, 0.4, 0.9)])
def test_a_single_pane_is_told(normal):
    scene = made_of(GLASS, [square(1, (0, 0, 0), np.array(normal) / np.linalg.norm(normal))])
    (sentence,) = told(scene)
    assert 'material "glass"' in sentence
    assert "thickness_m=0" in sentence
    assert not told(scene.replace(materials=[GLASS.replace(thickness_m=0)]))
    with pytest.warns(UserWarning, match='material "glass"'):
        omma.World(scene).with_light(SKY)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.World(scene)


def test_a_block_without_a_side_is_told():
    assert told(made_of(GLASS, block(SIDES[:-1])))


@pytest.mark.parametrize("flip", [1, -1])
def test_closed_meshes_are_not_told(flip):
    ball = omma.scene.sphere(0.5).replace(materials=[GLASS])
    assert not told(ball)
    placed = np.diag([flip * 2.0, 1, 0.1, 1])
    assert not told(made_of(GLASS, block()))  # six planes, which together are closed
    sides = block()
    instances = [Instance(mesh, placed) for mesh in range(len(sides))]
    assert not told(made_of(GLASS, sides, instances=instances))


def test_a_mirrored_pane_faces_where_it_is_seen_from():
    """A level plane is water where its front is above; mirrored upside down its front goes too."""
    plane = [square(1, (0, 0, 0), (0, 1, 0))]
    for placed, is_told in ((np.diag([-1.0, 1, 1, 1]), False), (np.diag([1.0, -1, 1, 1]), True)):
        assert bool(told(made_of(GLASS, plane, instances=[Instance(0, placed)]))) == is_told


def test_waters_are_not_told():
    """Level ones, waves, and a basin with walls of glass that stands on its bottom."""
    rng = np.random.default_rng(0)
    across = np.linspace(-1, 1, 21)
    x, z = np.meshgrid(across, across)
    waves = np.stack([x, 0.05 * rng.standard_normal(x.shape), z], axis=-1).reshape(-1, 3)
    first = (np.arange(20)[:, None] * 21 + np.arange(20)).ravel()
    triangles = np.concatenate(
        [
            np.stack([first, first + 21, first + 1], 1),
            np.stack([first + 1, first + 21, first + 22], 1),
        ]
    )
    for meshes in (
        [square(2, (0, 0, 0), (0, 1, 0))],
        [Mesh(waves, triangles, material=0)],
        block([side for side in SIDES if side[1] >= 0]),
    ):
        assert not told(made_of(water_volume("IB"), meshes))
