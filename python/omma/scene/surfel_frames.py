"""Normals and radii of surfels from the neighbours of each point.

The normal is the direction in which the nearest neighbours spread least (Hoppe, DeRose, Duchamp,
McDonald & Stuetzle 1992, Surface reconstruction from unorganized points, section 3.2). The radius
is the distance to the farthest corner of the point's Voronoi cell in the tangent plane: each cell
then lies in its own disc, and as the cells fill the plane, so do the discs. Those of a sphere's
tangent planes meet where its cells do, and hold likewise.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats32
from omma.base.progress import Progress

# Neighbours of each point: a Voronoi cell of random points has 6 sides on average, more than 10 in
# 2 of 100. Beside a gap, where a cell is open or reaches this share of the way to the last
# neighbour, those across it are missing, and more are asked.
NEIGHBOURS = 12
_SURE = 0.75
_MORE = 64
_SECTORS = 16
# Of whose distances the widest gap between points is taken that is no hole of the surface.
_NEAREST = 6
_GAP = 1.5
# Points at once: what is worked on stays in a processor's cache.
_BLOCK = 1 << 13
# Neighbours spread less than this across a line than along it, by variance, say no normal.
_LINE = 1e-3


@dataclass
class Frames:
    """Of each point: unit normal (N, 3) and radius (N,), m; how many had neighbours in a line, and
    how many normals of the file were of no length."""

    normals: Floats32
    radius_m: Floats32
    in_a_line: int
    without_length: int


def distinct(positions: Floats32) -> NDArray[np.intp] | None:
    """Which points are left when of those at the same position one is; None: all."""
    as_bytes = np.ascontiguousarray(positions + np.float32(0)).view("V12").ravel()
    first = np.unique(as_bytes, return_index=True)[1]
    return None if len(first) == len(positions) else np.sort(first)


def frames_of(
    positions: Floats32,
    normals: Floats32 | None,
    scanners: NDArray[np.float64] | None,
    progress: Progress | None = None,
) -> Frames:
    """Frames of points none of which lies on another."""
    from scipy.spatial import cKDTree

    count = len(positions)
    if count <= NEIGHBOURS:
        raise Error(
            f"expected more than {NEIGHBOURS} points at different places, for normals and radii, "
            f"found {count:,}; omma.scene.surfels takes these too, as normals and radius_m"
        )
    tree = cKDTree(positions)
    made = Frames(np.empty((count, 3), np.float32), np.empty(count, np.float32), 0, 0)
    reach = np.empty(count, np.float32)  # distance to the last neighbour
    near = np.empty((count, _NEAREST), np.int32 if count < 1 << 31 else np.int64)

    def fill(start: int) -> tuple[int, int]:
        rows = slice(start, min(start + _BLOCK, count))
        distance, index = tree.query(positions[rows], NEIGHBOURS + 1)
        distance, index = distance[:, 1:].astype(np.float32), index[:, 1:]
        reach[rows], near[rows] = distance[:, -1], index[:, :_NEAREST]
        across = positions[index] - positions[rows, None]
        found, lines, short = _normals(across, None if normals is None else normals[rows])
        radius, is_open = _radii(across, distance, found)
        unsure = np.flatnonzero(is_open | (radius > _SURE * distance[:, -1]))
        if len(unsure) and count > _MORE:
            here = positions[rows][unsure]
            distance, index = tree.query(here, _MORE + 1)
            wide = positions[index[:, 1:]] - here[:, None]
            distance = distance[:, 1:]
            radius[unsure] = _radii(wide, distance.astype(np.float32), found[unsure])[0]
        made.radius_m[rows] = radius
        made.normals[rows] = _turned(found, positions[rows], scanners)
        return lines, short

    with ThreadPoolExecutor() as pool:  # what each works on is done by NumPy and SciPy
        try:
            for done, (lines, short) in enumerate(pool.map(fill, range(0, count, _BLOCK)), 1):
                made.in_a_line += lines
                made.without_length += short
                if progress is not None:
                    progress(min(done * _BLOCK / count, 1.0))
        except BaseException:  # Ctrl-C does not wait for the blocks that have not begun
            pool.shutdown(cancel_futures=True)
            raise
    # A point off the surface has neighbours far away, which are near each other: no disc spans
    # farther than they do.
    for start in range(0, count, _BLOCK):
        rows = slice(start, start + _BLOCK)
        most = _GAP * np.median(reach[near[rows]], axis=1)
        made.radius_m[rows] = np.minimum(made.radius_m[rows], most)
    return made


def _normals(across: Floats32, given: Floats32 | None) -> tuple[Floats32, int, int]:
    """Those given, made of length 1, and for the others of the neighbours' positions (n, k, 3)."""
    without = np.arange(len(across))
    found: Floats32 = np.empty((len(across), 3), np.float32)
    if given is not None:
        length = np.linalg.norm(given.astype(np.float64), axis=1)
        without = np.flatnonzero(length < 1e-12)
        found[:] = given / np.maximum(length, 1e-300)[:, None]
    if not len(without):
        return found, 0, 0
    some = across[without].astype(np.float64)
    some /= np.abs(some).max(axis=(1, 2), keepdims=True)
    centred = some - some.sum(axis=1, keepdims=True) / (NEIGHBOURS + 1)
    mean = some.sum(axis=1) / (NEIGHBOURS + 1)
    spread = np.einsum("nki,nkj->nij", centred, centred) + mean[:, :, None] * mean[:, None, :]
    variance, axes = np.linalg.eigh(spread)
    found[without] = axes[:, :, 0]
    lines = int((variance[:, 1] < _LINE * variance[:, 2]).sum())
    return found, lines, 0 if given is None else len(without)


def _turned(
    normals: Floats32, positions: Floats32, scanners: NDArray[np.float64] | None
) -> Floats32:
    """Towards the nearest scanner; without one upwards, level ones along +X, else +Z."""
    if scanners is not None:
        to = scanners[None] - positions[:, None].astype(np.float64)
        nearest = (to**2).sum(axis=2).argmin(axis=1)
        side = (normals * to[np.arange(len(to)), nearest]).sum(axis=1)
    else:
        side = normals @ np.array([1e-3, 1, 1e-6], np.float32)
    return np.where(side[:, None] < 0, -normals, normals)


def tangents(normals: Floats32) -> tuple[Floats32, Floats32]:
    """Two directions across each normal: right-handed with it (Duff et al. 2017, Building an
    orthonormal basis, revisited)."""
    x, y, z = normals.T
    sign = np.where(z < 0, np.float32(-1), np.float32(1))
    a = -1 / (sign + z)
    b = x * y * a
    first = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return first, np.stack([b, sign + y * y * a, -y], axis=1)


def _radii(
    across: Floats32, distance: Floats32, normals: Floats32
) -> tuple[Floats32, NDArray[np.bool_]]:
    """Distance to the farthest corner of the Voronoi cell among neighbours (n, k, 3), and whether
    the cell is open.

    Neighbours are turned into the tangent plane, so that one above the point is no nearer than it
    is. A corner is where bisectors of two neighbours meet, if no other neighbour is nearer to it.
    Of many neighbours the nearest in each of 16 sectors count: a cell among fewer is larger, so
    that its disc covers the other's. There corners farther than half the way to the last neighbour
    are left out: they are gaps in the surface, or its edge.
    """
    u, v = tangents(normals)
    x, y = np.einsum("nki,ni->nk", across, u), np.einsum("nki,ni->nk", across, v)
    length = np.hypot(x, y)
    most = np.float32(np.inf)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        stretch = np.where(length > 0, distance / length, 0)
        x, y = x * stretch, y * stretch
        angle = np.arctan2(y, x)
        if x.shape[1] > NEIGHBOURS:
            most = distance[:, -1:] / 2
            sector = ((angle / np.pi + 1) * (_SECTORS / 2)).astype(np.int8) % _SECTORS
            # Neighbours come by distance; where a sector has none, the nearest stands twice.
            first = np.stack([(sector == k).argmax(axis=1) for k in range(_SECTORS)], axis=1)
            x, y, angle = (np.take_along_axis(one, first, axis=1) for one in (x, y, angle))
        square = x * x + y * y
        i, j = np.triu_indices(x.shape[1], 1)
        twice = 2 * (x[:, i] * y[:, j] - y[:, i] * x[:, j])
        cx = (y[:, j] * square[:, i] - y[:, i] * square[:, j]) / twice
        cy = (x[:, i] * square[:, j] - x[:, j] * square[:, i]) / twice
        far = cx * cx + cy * cy
        is_corner = far <= most**2
        for k in range(x.shape[1]):
            nearer = cx * x[:, k, None] + cy * y[:, k, None]
            is_corner &= 2 * nearer <= square[:, k, None] * np.float32(1 + 1e-4)
    far = np.where(is_corner, far, 0).max(axis=1)
    angle = np.sort(angle, axis=1)
    widest = np.diff(angle, axis=1, append=angle[:, :1] + np.float32(2 * np.pi)).max(axis=1)
    radius = np.where(far > 0, np.sqrt(far), distance[:, 0] / 2)
    return radius.astype(np.float32), widest >= np.pi


def spacing_of(positions: Floats32, most: int = 20_000) -> float:
    """Median distance from a point to its nearest neighbour, of some of them; 0 for one point."""
    from scipy.spatial import cKDTree

    if len(positions) < 2:
        return 0.0
    some = positions[:: -(-len(positions) // most)]
    found: Any = cKDTree(positions).query(some, 2)[0]
    return float(np.median(found[:, 1]))
