"""Textures on the six faces of a cube, as OpenGL numbers and lays them: +X, -X, +Y, -Y, +Z, -Z.

A direction's face is where its largest component points. Geoms are cut along the edges between
faces, so that each triangle shows one picture; skies become equirectangular panoramas.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats, Ints

# Of panoramas: finer than any compound eye.
_MOST_ROWS = 2048
# Of how far the corners of a triangle are from the cube's middle: beyond, it is divided in four.
_MOST_UNEVEN = 1.2
# A corner in the middle itself, as of planes, stays uneven: three more triangles each time, until
# what is left is a millimetre of a hundred metres.
_MOST_DIVISIONS = 17


def face_of(direction: Floats) -> Ints:
    """The face (...,) that a direction (..., 3) meets."""
    axis = np.abs(direction).argmax(axis=-1)
    along = np.take_along_axis(direction, axis[..., None], -1)[..., 0]
    return np.asarray(2 * axis + (along < 0), np.int64)


def on_face(direction: Floats, face: Ints) -> Floats:
    """Texture coordinates (..., 2) of directions (..., 3) on the faces (...,) that they meet."""
    x, y, z = np.moveaxis(direction, -1, 0)
    right = np.choose(face, [-z, z, x, x, x, -x])
    down = np.choose(face, [-y, -y, z, -z, -y, -y])
    away = np.abs(np.take_along_axis(direction, (face // 2)[..., None], -1)[..., 0])
    away = np.maximum(away, np.finfo(float).tiny)
    return np.asarray(0.5 * (np.stack([right, down], -1) / away[..., None] + 1))


def cut_by_faces(
    triangles: Ints, direction: Floats, *values: Floats
) -> list[tuple[int, Floats, list[Floats]]]:
    """Triangles (T, 3) cut where the directions (V, 3) of their vertices pass from face to face.

    Args:
        values: (V, ...), what else vertices have, linear between them.

    Returns:
        For each face that is met its number, texture coordinates (3 K, 2) and values (3 K, ...) of
        the corners of its K triangles.
    """
    widths = [value.shape[1] for value in values]
    corners = np.concatenate([direction, *values], axis=1)[triangles]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        for sign in (1.0, -1.0):
            corners = _cut(corners, corners[..., a] - sign * corners[..., b])
    for _ in range(_MOST_DIVISIONS):
        away = np.abs(corners[..., :3]).max(axis=-1)
        uneven = away.max(axis=1) > _MOST_UNEVEN * away.min(axis=1)
        if not uneven.any():
            break
        corners = np.concatenate([corners[~uneven], _divided(corners[uneven])])
    face = face_of(corners[..., :3].mean(axis=1))
    found = []
    for number in np.unique(face):
        here = corners[face == number].reshape(-1, corners.shape[-1])
        which = np.full(len(here), number)
        interpolated = np.split(here[:, 3:], np.cumsum(widths)[:-1], axis=1)
        found.append((int(number), on_face(here[:, :3], which), interpolated))
    return found


def panorama(pixels: NDArray[Any]) -> NDArray[Any]:
    """The equirectangular picture of a sky of six faces (6, N, N, C), which MuJoCo has turned by a
    quarter about x so that its third face is up: as `Background.image` takes it, -Z in the middle
    and +Y at the top, where +Z is the model's zenith.
    """
    size = pixels.shape[1]
    rows = min(2 * size, _MOST_ROWS)
    elevation = np.pi * (0.5 - (np.arange(rows) + 0.5) / rows)[:, None]
    azimuth = 2 * np.pi * ((np.arange(2 * rows) + 0.5) / (2 * rows) - 0.5)
    level = np.cos(elevation)
    x, y, z = np.broadcast_arrays(
        level * np.sin(azimuth), np.sin(elevation), -level * np.cos(azimuth)
    )
    direction = np.stack([x, z, -y], -1)
    face = face_of(direction)
    column, row = np.moveaxis(np.clip(on_face(direction, face) * size - 0.5, 0, size - 1), -1, 0)
    left, above = np.floor(column).astype(int), np.floor(row).astype(int)
    right, below = np.minimum(left + 1, size - 1), np.minimum(above + 1, size - 1)
    u, v = (column - left)[..., None], (row - above)[..., None]
    mixed = (1 - v) * ((1 - u) * pixels[face, above, left] + u * pixels[face, above, right]) + v * (
        (1 - u) * pixels[face, below, left] + u * pixels[face, below, right]
    )
    if pixels.dtype == np.uint8:
        return np.asarray(np.rint(mixed), np.uint8)
    return np.asarray(mixed, pixels.dtype)


def _cut(corners: Floats, side: Floats) -> Floats:
    """Triangles (T, 3, A) cut where ``side`` (T, 3) passes 0: more triangles."""
    crossed = (side > 0).any(axis=1) & (side < 0).any(axis=1)
    if not crossed.any():
        return corners
    over = side[crossed] > 0
    alone = np.where(over.sum(axis=1) == 1, over.argmax(axis=1), (~over).argmax(axis=1))
    order = (alone[:, None] + np.arange(3)) % 3
    here = np.take_along_axis(corners[crossed], order[..., None], 1)
    s = np.take_along_axis(side[crossed], order, 1)
    tip, left, right = here[:, 0], here[:, 1], here[:, 2]
    to_left = tip + (s[:, 0] / (s[:, 0] - s[:, 1]))[:, None] * (left - tip)
    to_right = tip + (s[:, 0] / (s[:, 0] - s[:, 2]))[:, None] * (right - tip)
    pieces = np.concatenate([
        np.stack([tip, to_left, to_right], 1),
        np.stack([to_left, left, right], 1),
        np.stack([to_left, right, to_right], 1),
    ])  # fmt: skip
    # A corner on the cut makes pieces of two points.
    directions = pieces[..., :3]
    across = np.linalg.norm(
        np.cross(directions[:, 1] - directions[:, 0], directions[:, 2] - directions[:, 0]), axis=1
    )
    largest = np.abs(directions).reshape(len(pieces), -1).max(axis=1)
    return np.concatenate([corners[~crossed], pieces[across > 1e-12 * largest**2]])


def _divided(corners: Floats) -> Floats:
    """Each triangle as four."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    return np.concatenate([
        np.stack(three, 1) for three in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    ])  # fmt: skip
