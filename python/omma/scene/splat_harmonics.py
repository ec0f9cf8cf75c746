"""Spherical harmonics of Gaussian splats, and what becomes of splats that are turned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, SplatCloud
from omma.base.arrays import Floats
from omma.base.directions import normalized

# What a matrix may be off turns and one scale, of that scale.
_RIGID = 1e-6
# A factor of turned harmonics this near a whole number is one: of quarter and half turns.
_WHOLE = 1e-12


def basis(directions: Floats, terms: int) -> Floats:
    """(N, terms) real spherical harmonics of unit directions (N, 3), with 3DGS's order and signs.

    Order: degree, then -degree to degree; signs with the Condon-Shortley phase (Kerbl et al. 2023,
    its sh_utils, which writes the square roots as decimals).
    """
    x, y, z = directions.T
    pi = np.pi
    first, second = np.sqrt(3 / (4 * pi)), np.sqrt(15 / (4 * pi))
    columns = [
        np.full(len(directions), np.sqrt(1 / (4 * pi))),
        -first * y,
        first * z,
        -first * x,
        second * x * y,
        -second * y * z,
        np.sqrt(5 / (16 * pi)) * (2 * z * z - x * x - y * y),
        -second * x * z,
        np.sqrt(15 / (16 * pi)) * (x * x - y * y),
        -np.sqrt(35 / (32 * pi)) * y * (3 * x * x - y * y),
        np.sqrt(105 / (4 * pi)) * x * y * z,
        -np.sqrt(21 / (32 * pi)) * y * (4 * z * z - x * x - y * y),
        np.sqrt(7 / (16 * pi)) * z * (2 * z * z - 3 * x * x - 3 * y * y),
        -np.sqrt(21 / (32 * pi)) * x * (4 * z * z - x * x - y * y),
        np.sqrt(105 / (16 * pi)) * z * (x * x - y * y),
        -np.sqrt(35 / (32 * pi)) * x * (x * x - 3 * y * y),
    ]
    return np.stack(columns[:terms], axis=1)


def turned_harmonics(rotation: Floats, terms: int) -> Floats:
    """(terms, terms): of coefficients, what they are when all that they describe is turned."""
    # Each degree's functions are each other's sums when turned; which, some directions tell.
    directions = np.random.default_rng(1).normal(size=(64, 3))
    directions = normalized(directions)
    turned = basis(directions @ rotation.T, terms)
    matrix = np.linalg.lstsq(turned, basis(directions, terms), rcond=None)[0]
    whole = np.round(matrix)
    return np.where(np.abs(matrix - whole) < _WHOLE, whole, matrix)


def moved_splats(splats: SplatCloud, frame_from_splats: Floats) -> SplatCloud:
    """The same splats with other numbers, in a frame that lies otherwise; in the world they stay
    where they are.

    Raises:
        omma.Error: a matrix that mirrors, or stretches more one way than another, or numbers that
            are then out of reach.
    """
    linear = frame_from_splats[:3, :3]
    size = np.cbrt(np.linalg.det(linear))
    rotation = linear / size if size > 0 else linear
    if not (size > 0 and np.allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=_RIGID)):
        raise Error("world_from_splats: expected turns, one scale and a translation")
    world = splats.world_from_splats @ np.linalg.inv(frame_from_splats)
    if np.array_equal(frame_from_splats, np.eye(4)):
        return splats
    terms = splats.harmonics.shape[1]
    matrix = turned_harmonics(rotation, terms)
    harmonics = np.einsum("jk,nkc->njc", matrix, splats.harmonics, optimize=True)
    return splats.replace(
        positions_m=(splats.positions_m @ linear.T + frame_from_splats[:3, 3]).astype(np.float32),
        scales_m=(splats.scales_m * size).astype(np.float32),
        rotations=_turned_quaternions(rotation, splats.rotations),
        harmonics=harmonics.astype(np.float32),
        world_from_splats=world,
    )


def _turned_quaternions(rotation: Floats, quaternions: NDArray[np.float32]) -> NDArray[np.float32]:
    from scipy.spatial.transform import Rotation

    ax, ay, az, aw = Rotation.from_matrix(rotation).as_quat()
    x, y, z, w = quaternions.astype(np.float64).T
    turned = (
        aw * x + ax * w + ay * z - az * y,
        aw * y - ax * z + ay * w + az * x,
        aw * z + ax * y - ay * x + az * w,
        aw * w - ax * x - ay * y - az * z,
    )
    return np.stack(turned, axis=1).astype(np.float32)
