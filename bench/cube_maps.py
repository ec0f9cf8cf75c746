"""Six square pictures around a place, and what ommatidia make of their pixels: sparse matrices of
weights, made once, with which each frame's pixels are binned into responses.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, vstack
from scipy.spatial import cKDTree

# Half width over standard deviation of a Gaussian.
FWHM_SIGMAS = math.sqrt(8 * math.log(2))
# Sensitivity beyond so many standard deviations is left out, 0.03 % of all.
REACH_SIGMAS = 4.0
# Sensitivity is read in the middle of a pixel, or of its parts where a pixel is wider than this
# share of the acceptance angle. A Gaussian added up in such steps is right to 0.3 %; finer steps
# would only blur what is seen.
STEP = 0.7
AHEAD = ((0, 0, -1), (1, 0, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0), (0, -1, 0))
UP = ((0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1))


def face_turns() -> NDArray[np.float64]:
    """Turns of the six cameras, (6, 3, 3): head from camera, which looks along its -Z."""
    ahead, up = np.array(AHEAD, float), np.array(UP, float)
    return np.stack([np.cross(ahead, up), up, -ahead], axis=-1)


def face_poses(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """World from camera of the six cameras in the middle of a head, (6, 4, 4), m."""
    poses = np.tile(pose, (6, 1, 1))
    poses[:, :3, :3] = pose[:3, :3] @ face_turns()
    return poses


def tangents(pixels: int, half_width: ArrayLike) -> NDArray[np.float64]:
    """Where the middles of a row's pixels are in a plane at distance 1, (..., pixels)."""
    middle = 2 * (np.arange(pixels) + 0.5) / pixels - 1
    return middle * np.asarray(half_width, float)[..., None]


def pixel_directions(size: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of a cube map with ``size`` pixels along an edge, row 0 of each face at the top.

    Directions in the head (6 size², 3), and solid angles in sr (6 size²,).
    """
    across = tangents(size, 1.0)
    x, y = np.meshgrid(across, -across)
    local = np.stack([x, y, np.full_like(x, -1.0)], axis=-1).reshape(-1, 3)
    far = np.linalg.norm(local, axis=-1)
    directions = np.einsum("fij,pj->fpi", face_turns(), local / far[:, None])
    return directions.reshape(-1, 3), np.tile((2 / size) ** 2 / far**3, 6)


def binning_matrix(axis: ArrayLike, acceptance_angle_rad: ArrayLike, size: int) -> csr_array:
    """Responses from the pixels of a cube map, (N, 6 size²): what each pixel counts.

    A pixel counts by its solid angle and by the Gaussian sensitivity of the ommatidium in its
    middle; where pixels are wide, in the middles of its parts. Each row adds up to 1.

    Args:
        axis: viewing directions in the head, unit vectors, (N, 3).
        acceptance_angle_rad: full widths at half maximum, (N,).
        size: pixels along an edge of a face.
    """
    axis, width = np.asarray(axis, float), np.asarray(acceptance_angle_rad, float)
    parts = math.ceil(2 / size / (STEP * width.min()))
    directions, solid_angle = pixel_directions(size * parts)
    # Pixels that the parts belong to: both are ordered by face, row and column.
    face, row, column = np.unravel_index(
        np.arange(len(directions)), (6, size * parts, size * parts)
    )
    pixel = (face * size + row // parts) * size + column // parts
    reach = 2 * np.sin(np.minimum(REACH_SIGMAS * width / FWHM_SIGMAS, np.pi) / 2)
    tree = cKDTree(directions)
    blocks = []
    for first in range(0, len(axis), 256):
        own = slice(first, first + 256)
        found = tree.query_ball_point(axis[own], reach[own])
        counts = [len(one) for one in found]
        part = np.concatenate([np.asarray(one, np.int64) for one in found])
        ommatidium = np.repeat(np.arange(len(counts)), counts)
        apart = np.linalg.norm(axis[own][ommatidium] - directions[part], axis=1)
        theta = 2 * np.arcsin(apart / 2)
        weight = solid_angle[part] * sensitivity(theta, width[own][ommatidium])
        weight /= np.bincount(ommatidium, weight)[ommatidium]
        # Parts of one pixel are added up.
        block = csr_array((weight, (ommatidium, pixel[part])), (len(counts), 6 * size**2))
        block.sum_duplicates()
        blocks.append(block.astype(np.float32))
    matrix = csr_array(vstack(blocks, format="csr"))
    # Half the memory to go through in each frame.
    narrow = (matrix.indices.astype(np.int32), matrix.indptr.astype(np.int32))
    return csr_array((matrix.data, *narrow), matrix.shape)


def camera_weights(
    acceptance_angle_rad: ArrayLike, pixels: int, field_sigmas: float
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """What the pixels of a small camera count that looks along an ommatidium's axis.

    Returns weights (N, pixels, pixels), which add up to 1, and the cameras' fields of view in rad,
    (N,), which reach ``field_sigmas`` standard deviations to each side.
    """
    width = np.asarray(acceptance_angle_rad, float)
    half = np.tan(field_sigmas * width / FWHM_SIGMAS)
    parts = math.ceil(2 * field_sigmas / FWHM_SIGMAS / pixels / STEP)
    across = tangents(pixels * parts, half)
    flat2 = across[:, :, None] ** 2 + across[:, None, :] ** 2
    solid_angle = (1 + flat2) ** -1.5
    weight = solid_angle * sensitivity(np.arctan(np.sqrt(flat2)), width[:, None, None])
    weight = weight.reshape(-1, pixels, parts, pixels, parts).sum(axis=(2, 4))
    weight /= weight.sum(axis=(1, 2), keepdims=True)
    return weight.astype(np.float32), 2 * np.arctan(half)


def sensitivity(
    theta_rad: NDArray[np.float64], acceptance_angle_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Of round Gaussians, 1 along the axis."""
    return np.exp(-4 * math.log(2) * (theta_rad / acceptance_angle_rad) ** 2)
