"""The slow renderer of splats against closed forms, and its harmonics against SciPy's."""

import numpy as np
import pytest
import slow_splats
from scipy import special
from scipy.spatial.transform import Rotation

from omma.scene import SplatCloud, splat_harmonics

RNG = np.random.default_rng(5)


def unit(rows):
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


def splats_of(positions, scales=0.1, opacities=0.5, colours=(1.0, 0.5, 0.25), rotations=None):
    positions = np.atleast_2d(np.asarray(positions, np.float32))
    count = len(positions)
    rgb = np.broadcast_to(np.asarray(colours, float), (count, 3))
    quaternions = np.tile([0, 0, 0, 1.0], (count, 1)) if rotations is None else rotations
    return SplatCloud(
        positions,
        np.broadcast_to(scales, (count, 3)).astype(np.float32),
        np.asarray(quaternions, np.float32),
        np.broadcast_to(opacities, count).astype(np.float32),
        ((rgb - 0.5) / slow_splats.C0)[:, None].astype(np.float32),
    )


def trace(splats, origins, directions, far=np.inf):
    origins = np.atleast_2d(origins)
    return slow_splats.trace(splats, origins, np.atleast_2d(directions), np.full(len(origins), far))


def test_harmonics_are_scipys_up_to_sign():
    directions = unit(RNG.normal(size=(200, 3)))
    theta = np.arccos(directions[:, 2])
    phi = np.arctan2(directions[:, 1], directions[:, 0])
    found = slow_splats.basis(directions)
    for column, (degree, order) in enumerate((n, m) for n in range(4) for m in range(-n, n + 1)):
        value = special.sph_harm_y(degree, abs(order), theta, phi)
        part = value.imag if order < 0 else value.real
        expected = part * (np.sqrt(2) if order else 1)
        sign = np.sign((found[:, column] * expected).sum())
        assert found[:, column] == pytest.approx(sign * expected, abs=1e-14)
        # The complex ones have the Condon-Shortley phase, and so have 3DGS's.
        assert sign == 1


def test_the_package_has_the_same_harmonics():
    directions = unit(RNG.normal(size=(50, 3)))
    for terms in (1, 4, 9, 16):
        expected = slow_splats.basis(directions)[:, :terms]
        assert splat_harmonics.basis(directions, terms) == pytest.approx(expected, abs=1e-14)


def test_one_gaussian_along_its_axis_and_beside_it():
    splats = splats_of([0, 0, -2], opacities=0.8)
    # 0.1 beside the centre: one standard deviation.
    rgb, through, depth, half = trace(splats, [[0, 0, 0], [0.1, 0, 0]], [[0, 0, -1]] * 2)
    alphas = 0.8 * np.exp([0, -0.5])
    assert through == pytest.approx(1 - alphas, abs=1e-7)
    assert rgb == pytest.approx(alphas[:, None] * [1, 0.5, 0.25], abs=1e-6)
    assert depth == pytest.approx([2, 2])
    assert half[0] == pytest.approx(2)
    assert np.isinf(half[1])


def test_what_does_not_count():
    splats = splats_of([0, 0, -2])
    beyond = 0.1 * np.sqrt(2 * np.log(255 * 0.5))  # where alpha is 1/255
    origins = [[0, 0, -3], [0, 0, 0], [beyond * 1.001, 0, 0], [beyond * 0.999, 0, 0]]
    found = slow_splats.trace(splats, origins, [[0, 0, -1]] * 4, [9, 1.9, 9, 9])
    assert found[1][:3] == pytest.approx(1)
    assert found[1][3] == pytest.approx(1 - 1 / 255, abs=1e-4)


def test_two_in_both_orders():
    near, far = ([1, 0, 0], 0.6), ([0, 1, 0], 0.9)
    for first, second in ((near, far), (far, near)):
        splats = splats_of(
            [[0, 0, -3], [0, 0, -1]],
            opacities=[second[1], first[1]],
            colours=[second[0], first[0]],
        )
        rgb, through, depth, _ = trace(splats, [0, 0, 0], [0, 0, -1])
        weights = np.array([first[1], (1 - first[1]) * second[1]])
        assert rgb[0] == pytest.approx(weights @ [first[0], second[0]], abs=1e-6)
        assert through == pytest.approx(1 - weights.sum(), abs=1e-6)
        assert depth == pytest.approx(weights @ [1, 3] / weights.sum(), abs=1e-6)


def test_opaque_ones_let_a_hundredth_through_and_end_at_the_threshold():
    splats = splats_of([[0, 0, -z] for z in range(1, 9)], opacities=1)
    _, through, _, half = trace(splats, [0, 0, 0], [0, 0, -1])
    # 1e-4 after two, which rounding puts above or below the threshold.
    assert through[0] == pytest.approx(0.01**2, rel=1e-9) or through[0] == pytest.approx(1e-6)
    assert half == pytest.approx(1)


def test_turned_and_stretched_gaussians():
    # A long one along x, turned a quarter about z: long along y.
    quarter = Rotation.from_euler("z", 90, degrees=True).as_quat()
    splats = splats_of([0, 0, -2], [[0.4, 0.1, 0.1]], rotations=[quarter])
    _, through, _, _ = trace(splats, [[0, 0.4, 0], [0.1, 0, 0]], [[0, 0, -1]] * 2)
    assert through == pytest.approx(1 - 0.5 * np.exp(-0.5), abs=1e-6)


@pytest.mark.parametrize("direction", ["center", "ray"])
def test_harmonics_along_the_direction_that_is_asked_for(direction):
    splats = splats_of([0.05, 0, -2]).replace(
        harmonics=RNG.normal(size=(1, 16, 3)).astype(np.float32) * 0.1,
        direction=direction,
    )
    rgb, through, _, _ = trace(splats, [0, 0, 0], [0, 0, -1])
    seen = unit(np.array([0.05, 0, -2])) if direction == "center" else np.array([0, 0, -1.0])
    colour = 0.5 + slow_splats.basis(seen) @ splats.harmonics[0]
    assert rgb[0] / (1 - through[0]) == pytest.approx(colour, abs=1e-6)


def test_placed_clouds_look_as_their_numbers_do_in_the_world():
    count = 40
    quaternions = unit(RNG.normal(size=(count, 4)))
    splats = splats_of(
        RNG.normal(size=(count, 3)),
        RNG.uniform(0.1, 0.5, (count, 3)),
        RNG.uniform(0.1, 0.9, count),
        rotations=quaternions,
    ).replace(harmonics=RNG.normal(size=(count, 16, 3)).astype(np.float32) * 0.1)
    matrix = np.eye(4)
    matrix[:3, :3] = 2.5 * Rotation.from_rotvec([0.3, -1, 0.4]).as_matrix()
    matrix[:3, 3] = [1, -2, 0.5]
    placed = splats.replace(world_from_splats=matrix)
    moved = splat_harmonics.moved_splats(placed, matrix)
    assert moved.world_from_splats == pytest.approx(np.eye(4), abs=1e-12)
    origins, directions = RNG.normal(size=(30, 3)) * 4, unit(RNG.normal(size=(30, 3)))
    directions = unit(-origins + directions)
    expected = trace(placed, origins, directions)
    assert (expected[1] < 0.9).sum() > 10
    for found, wanted in zip(trace(moved, origins, directions), expected):
        # Single precision of what was moved.
        assert found == pytest.approx(wanted, abs=1e-4)
