"""Sky maps as the engine has them: radiance looked up by direction, added up over a hemisphere,
turned, and made from equirectangular pictures.

A map is (2, rows, columns, components, channels): the half above the horizon, then the one below;
rows from the horizon to the zenith or the nadir, both included; columns from -Z (azimuth 0) to the
right; I, or I, Q, U with the reference axis up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats, Ints

Map = NDArray[np.float32]

# Of sums over a hemisphere: intervals between rows are cut to this, or finer where the map is.
_STEP_DEG = 1.0


def sky_nodes(rows: int, columns: int) -> tuple[Floats, Floats]:
    """Elevations (2, rows) and azimuths (columns,) of a map's nodes, rad."""
    above = np.linspace(0, np.pi / 2, rows)
    return np.stack([above, -above]), np.arange(columns) * 2 * np.pi / columns


def look_up(sky: Map, direction: Floats) -> Floats:
    """What a map says of directions (..., 3): (..., components, channels)."""
    elevation = np.arcsin(np.clip(direction[..., 1], -1, 1))
    azimuth = np.arctan2(direction[..., 0], -direction[..., 2])
    return _mixed(sky, (elevation < 0).astype(np.int64), np.abs(elevation), azimuth)


def irradiance(sky: Map, normal: Floats) -> Floats:
    """What falls on a surface with that normal (3,), from all of a map: (channels,) of I.

    Gauss-Legendre over elevation, the mean over azimuth: to 1e-5, and 1e-4 where the surface's own
    horizon cuts through the map.
    """
    rows, columns = sky.shape[1:3]
    pieces = (rows - 1) * max(1, int(np.ceil(90 / (rows - 1) / _STEP_DEG)))
    x, w = np.polynomial.legendre.leggauss(3)
    edges = np.linspace(0, np.pi / 2, pieces + 1)
    half = (edges[1] - edges[0]) / 2
    above = ((edges[:-1] + half)[:, None] + half * x).ravel()
    weight = np.tile(half * w, pieces) * np.cos(above)
    around = columns * max(1, int(np.ceil(360 / columns)))
    azimuth = (np.arange(around) + 0.5) * 2 * np.pi / around
    total = np.zeros(2 * rows * columns)
    for k, elevation in enumerate((above, -above)):
        e, a = np.meshgrid(elevation, azimuth, indexing="ij")
        towards = np.stack([np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)], -1)
        share_of = np.maximum(towards @ normal, 0) * (weight * 2 * np.pi / around)[:, None]
        half_of = np.full(e.shape, k)
        for share, _, node in _corners(rows, columns, half_of, np.abs(e), a):
            index = np.ravel_multi_index(node, (2, rows, columns))
            total += np.bincount(index.ravel(), (share * share_of).ravel(), len(total))
    return np.asarray(total @ sky[:, :, :, 0].reshape(len(total), -1).astype(np.float64))


def level_weights(rows: int, columns: int) -> Floats:
    """What a node of each row of the upper half counts in the irradiance of level ground, (rows,):
    the integral of its share in a map between nodes, times sine and cosine of elevation."""
    x, w = np.polynomial.legendre.leggauss(5)
    edges = np.linspace(0, np.pi / 2, rows)
    half = (edges[1] - edges[0]) / 2
    elevation = edges[:-1, None] + half * (1 + x)
    each = half * w * np.sin(elevation) * np.cos(elevation) * 2 * np.pi / columns
    weights = np.zeros(rows)
    weights[:-1] += (each * (1 - x) / 2).sum(axis=1)
    weights[1:] += (each * (1 + x) / 2).sum(axis=1)
    return weights


def turned(sky: Map, azimuth_rad: float) -> Map:
    """The map turned to the right, seen from above; between columns as it is looked up."""
    elevation, azimuth = sky_nodes(*sky.shape[1:3])
    half, height, before = np.broadcast_arrays(
        np.arange(2)[:, None, None], np.abs(elevation)[:, :, None], azimuth - azimuth_rad
    )
    return _mixed(sky, half, height, before).astype(np.float32)


def added(one: Map, other: Map) -> Map:
    """The sum of two maps with the same channels, on the finer grid of rows and of columns."""
    rows, columns = (max(one.shape[k], other.shape[k]) for k in (1, 2))
    components = max(one.shape[3], other.shape[3])
    total = np.zeros((2, rows, columns, components, one.shape[4]))
    for each in (one, other):
        total[:, :, :, : each.shape[3]] += on_grid(each, rows, columns)
    return total.astype(np.float32)


def on_grid(sky: Map, rows: int, columns: int) -> Map:
    """A map at other nodes, as it is looked up; the map itself where they are its own."""
    if sky.shape[1:3] == (rows, columns):
        return sky
    elevation, azimuth = sky_nodes(rows, columns)
    half, height, around = np.broadcast_arrays(
        np.arange(2)[:, None, None], np.abs(elevation)[:, :, None], azimuth
    )
    return _mixed(sky, half, height, around).astype(np.float32)


def from_equirectangular(picture: Floats) -> Map:
    """The map of an equirectangular picture (height, width, components, channels): ahead (-Z) in
    the middle, row 0 at the top.

    Nodes are as far apart as pixels, between them; the rows next to the horizon belong to one half
    each, and at the zenith and the nadir all columns are the mean of the rows there.
    """
    height, width = picture.shape[:2]
    rows, columns = max(2, (height + 1) // 2 + 1), max(4, width)
    elevation, azimuth = sky_nodes(rows, columns)
    # Column 0 looks ahead, which is the picture's middle.
    column = (azimuth / (2 * np.pi) + 0.5) * width - 0.5
    left = np.floor(column).astype(int)
    share = (column - left)[:, None, None]
    across = (1 - share) * picture[:, left % width] + share * picture[:, (left + 1) % width]
    halves = []
    for k, nodes in enumerate(elevation):
        row = (0.5 - nodes / np.pi) * height - 0.5
        low, high = (0, (height - 1) // 2) if k == 0 else (height // 2, height - 1)
        row = np.clip(row, low, high)
        top = np.floor(row).astype(int)
        down = (row - top)[:, None, None, None]
        half = (1 - down) * across[top] + down * across[np.minimum(top + 1, high)]
        half[-1] = _pole(half[-1], azimuth if k == 0 else -azimuth)
        halves.append(half)
    return np.stack(halves).astype(np.float32)


def _pole(values: Floats, axis: Floats) -> Floats:
    """The mean of what columns say of the zenith or the nadir, for each in its own frame:
    (columns, components, channels). ``axis``: how far reference axes have turned, rad."""
    mean = np.broadcast_to(values.mean(axis=0), values.shape).copy()
    if values.shape[1] == 3:
        to_own = np.exp(2j * axis)[:, None]
        polarised = ((values[:, 1] + 1j * values[:, 2]) / to_own).mean(axis=0) * to_own
        mean[:, 1], mean[:, 2] = polarised.real, polarised.imag
    return np.asarray(mean)


def _mixed(sky: Map, half: Ints, height: Floats, azimuth: Floats) -> Floats:
    """A map between its nodes; ``height`` is the elevation without its sign, rad.

    Each node has a reference axis of its own. Carried along a circle of elevation without being
    turned it comes to lie beside that of the direction, by the azimuth between them times the sine
    of elevation. So a polarisation that is one all about the zenith stays as strong between nodes.
    """
    found = np.zeros((*azimuth.shape, *sky.shape[3:]))
    sine = np.sin(height) * np.where(half == 0, 1, -1)
    for share, beside, node in _corners(sky.shape[1], sky.shape[2], half, height, azimuth):
        own = sky[node].astype(np.float64)
        if sky.shape[3] == 3:
            cos, sin = np.cos(2 * beside * sine)[..., None], np.sin(2 * beside * sine)[..., None]
            q, u = own[..., 1, :].copy(), own[..., 2, :].copy()
            own[..., 1, :], own[..., 2, :] = cos * q - sin * u, sin * q + cos * u
        found += share[..., None, None] * own
    return found


def _corners(
    rows: int, columns: int, half: Ints, height: Floats, azimuth: Floats
) -> list[tuple[Floats, Floats, tuple[Ints, ...]]]:
    """The four nodes around directions: their bilinear weights, the angle by which the direction is
    to their right, rad, and their indices."""
    row = np.clip(height / (np.pi / 2), 0, 1) * (rows - 1)
    low = np.minimum(row.astype(np.int64), rows - 2)
    up = row - low
    column = (azimuth / (2 * np.pi)) % 1.0 * columns
    left = column.astype(np.int64) % columns
    along = column - np.floor(column)
    right = (left + 1) % columns
    step = 2 * np.pi / columns
    return [
        ((1 - up) * (1 - along), step * along, (half, low, left)),
        ((1 - up) * along, step * (along - 1), (half, low, right)),
        (up * (1 - along), step * along, (half, low + 1, left)),
        (up * along, step * (along - 1), (half, low + 1, right)),
    ]
