"""Sky maps as the engine has them: radiance looked up by direction, added up over a hemisphere,
turned, and made from equirectangular pictures.

A map is (2, rows, columns, components, channels): the half above the horizon, then the one below;
rows from the horizon to the zenith or the nadir, both included; columns from -Z (azimuth 0) to the
right; I, or I, Q, U with the reference axis up.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import array_of
from omma.base.arrays import Floats, Ints

Map = NDArray[np.float32]

# Of sums over a hemisphere: intervals between rows are cut to this, or finer where the map is.
_STEP_DEG = 1.0
# So that what is computed on the way to a map takes little beside it.
_NODES_AT_ONCE = 1 << 16
# Of a picture whose map has nodes half a pixel apart; in larger ones they are a pixel apart, as
# maps of four times their size would not fit.
_FINE_PIXELS = 2048 * 1024
# And of its longer side, of a strip: skies have 65,536 columns and 32,768 rows at most.
_FINE_SIDE = 1 << 15


def checked_sky(sky: Any, bands: int, matrix: Floats | None) -> Map:
    """A map of one's own that nobody can change, or omma.Error where it is none for these bands."""
    array = array_of(sky, "sky", (2, None, None, None, None), np.float32)
    _, rows, columns, components, channels = array.shape
    expected = bands if matrix is None else matrix.shape[1]
    if rows < 2 or columns < 4 or components not in (1, 3) or channels != expected:
        raise Error(
            "sky: expected 2 halves, 2 or more rows, 4 or more columns, 1 or 3 components, "
            f"{expected} channels, found {array.shape}"
        )
    if not np.all(np.isfinite(array)) or np.any(array[:, :, :, 0] < 0):
        raise Error("sky: expected finite radiances of at least 0")
    if components == 3:
        intensity = array[:, :, :, 0]
        polarised = np.hypot(array[:, :, :, 1], array[:, :, :, 2])
        # Rounding of what is fully polarised.
        if np.any(polarised > intensity * np.float32(1 + 1e-5)):
            raise Error("sky: expected a polarised radiance, sqrt(Q² + U²), of at most I")
    # Not the caller's own, which may change.
    array = np.ascontiguousarray(array).copy() if array is sky else np.ascontiguousarray(array)
    array.flags.writeable = False
    return array


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
    half_step = (edges[1] - edges[0]) / 2
    height = ((edges[:-1] + half_step)[:, None] + half_step * x).ravel()
    # Directions between two columns lie side by side, (columns, between).
    between = max(1, int(np.ceil(360 / columns)))
    along = (np.arange(between) + 0.5) / between
    azimuth = (np.arange(columns)[:, None] + along) * 2 * np.pi / columns
    sideways = np.sin(azimuth) * normal[0] - np.cos(azimuth) * normal[2]
    weight = np.tile(half_step * w, pieces) * np.cos(height) * 2 * np.pi / azimuth.size
    low = np.minimum((height / (np.pi / 2) * (rows - 1)).astype(int), rows - 2)
    up = height / (np.pi / 2) * (rows - 1) - low
    total = np.zeros((2, rows, columns))
    for half, sign in enumerate((1, -1)):
        for k, e in enumerate(height):
            facing = np.maximum(np.cos(e) * sideways + sign * np.sin(e) * normal[1], 0) * weight[k]
            of_column = facing @ (1 - along) + np.roll(facing @ along, 1)
            total[half, low[k]] += (1 - up[k]) * of_column
            total[half, low[k] + 1] += up[k] * of_column
    return np.asarray(np.einsum("hrc,hrck->k", total, sky[:, :, :, 0]))


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
    rows, columns = sky.shape[1:3]
    before = -azimuth_rad * columns / (2 * np.pi)
    left = int(np.floor(before))
    along = before - left
    step = 2 * np.pi / columns
    sine = np.sin(sky_nodes(rows, columns)[0])[:, :, None]
    found = (1 - along) * _carried(np.roll(sky, -left, axis=2), step * along * sine)
    found += along * _carried(np.roll(sky, -left - 1, axis=2), step * (along - 1) * sine)
    return np.asarray(found, np.float32)


def added(one: Map, other: Map) -> Map:
    """The sum of two maps with the same channels, on the finer grid of rows and of columns."""
    rows, columns = (max(one.shape[k], other.shape[k]) for k in (1, 2))
    components = max(one.shape[3], other.shape[3])
    total = np.zeros((2, rows, columns, components, one.shape[4]), np.float32)
    for each in (one, other):
        total[:, :, :, : each.shape[3]] += on_grid(each, rows, columns)
    return total


def on_grid(sky: Map, rows: int, columns: int) -> Map:
    """A map at other nodes, as it is looked up; the map itself where they are its own."""
    if sky.shape[1:3] == (rows, columns):
        return sky
    elevation, azimuth = sky_nodes(rows, columns)
    found = np.empty((2, rows, columns, *sky.shape[3:]), np.float32)
    at_once = max(1, _NODES_AT_ONCE // columns)
    for half in range(2):
        for first in range(0, rows, at_once):
            height, around = np.broadcast_arrays(
                elevation[0, first : first + at_once, None], azimuth
            )
            part = _mixed(sky, np.full(height.shape, half), height, around)
            found[half, first : first + at_once] = part
    return found


def from_equirectangular(picture: Floats) -> Map:
    """The map of an equirectangular picture (height, width, components, channels): ahead (-Z) in
    the middle, row 0 at the top.

    Nodes are half a pixel apart, in the middle of pixels and between them, so that between nodes
    the map is what the picture is on straight lines from middle to middle of its pixels, around the
    seam and across the horizon too. In pictures of more than 2,048 x 1,024 pixels they are a pixel
    apart, and where they lie between pixels they are the mean of those beside them. At the zenith
    and the nadir all columns are the mean of the last row.
    """
    height, width = picture.shape[:2]
    rows, columns = height + 1, max(4, 2 * width)
    if height * width > _FINE_PIXELS or max(height, width) >= _FINE_SIDE:
        rows, columns = max(2, (height + 1) // 2 + 1), max(4, width)
    # In pixels from the middle of the first. Column 0 looks ahead, which is the picture's middle.
    column = (width - 1) / 2 + np.arange(columns) * (width / columns)
    left = np.floor(column).astype(int)
    along = (column - left)[:, None, None]
    left, right = left % width, (left + 1) % width
    azimuth = sky_nodes(rows, columns)[1]
    sky = np.empty((2, rows, columns, *picture.shape[2:]), np.float32)
    for half, sign in enumerate((1, -1)):
        for k in range(rows):
            row = (height - 1) / 2 - sign * k * (height / 2 / (rows - 1))
            row = min(max(row, 0), height - 1)
            top = int(row)
            down = row - top
            of_row = (1 - down) * picture[top] + down * picture[min(top + 1, height - 1)]
            sky[half, k] = (1 - along) * of_row[left] + along * of_row[right]
        sky[half, -1] = _pole(sky[half, -1].astype(np.float64), sign * azimuth)
    return sky


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
        found += share[..., None, None] * _carried(sky[node].astype(np.float64), beside * sine)
    return found


def _carried(stokes: NDArray[Any], angle: Floats) -> NDArray[Any]:
    """Stokes vectors (..., components, channels), whose axes are turned by ``angle``, rad."""
    if stokes.shape[-2] != 3:
        return stokes
    turn = np.exp(2j * angle)[..., None]
    found: NDArray[Any] = stokes.copy()
    polarised = (stokes[..., 1, :] + 1j * stokes[..., 2, :]) * turn
    found[..., 1, :], found[..., 2, :] = polarised.real, polarised.imag
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
