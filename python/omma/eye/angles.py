"""What lattices of directions are made of: fields of view and tables of interommatidial angles."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Flags, Floats
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import PathLike
from omma.base.tables import as_grid, read_table
from omma.eye.lattice import Angle

__all__ = ["angle_table", "load_angle_table", "outline"]


_COLUMNS = ("azimuth_deg", "elevation_deg", "dphi_h_deg", "dphi_v_deg")


@checked
def window(
    azimuth_deg: tuple[float, float] = (-180.0, 180.0),
    elevation_deg: tuple[float, float] = (-90.0, 90.0),
) -> Callable[[Floats], Flags]:
    """The field of view between two azimuths and two elevations, as `lay_directions` takes it.

    Azimuths may go beyond ±180, as those of an eye that looks across the back: (-40, 215).

    Raises:
        omma.Error: limits that are not in order, azimuths more than 360 apart.
    """
    left, right = array_of(azimuth_deg, "azimuth_deg", (2,)).tolist()
    low, high = array_of(elevation_deg, "elevation_deg", (2,)).tolist()
    if not (left < right <= left + 360):
        raise Error(f"azimuth_deg: expected two ascending, 360 apart at most, found {azimuth_deg}")
    if not (-90 <= low < high <= 90):
        raise Error(f"elevation_deg: expected two ascending from -90 to 90, found {elevation_deg}")

    def sees(directions: Floats) -> Flags:
        azimuth, elevation = azimuth_elevation_deg_of(directions)
        seen = (elevation >= low) & (elevation <= high)
        return np.asarray(seen & ((azimuth - left) % 360 <= right - left))

    return sees


@checked
def outline(azimuth_elevation_deg: ArrayLike) -> Callable[[Floats], Flags]:
    """The field of view inside a polygon of azimuths and elevations (M, 2), degrees; its sides are
    straight in azimuth and elevation. Azimuths may go beyond ±180.

    Raises:
        omma.Error: less than three corners, or corners that are none.
    """
    corners = array_of(azimuth_elevation_deg, "outline")
    if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 3:
        raise Error(f"outline: expected at least 3 corners, (M, 2), found {corners.shape}")
    if not np.isfinite(corners).all() or np.abs(corners[:, 1]).max() > 90:
        raise Error("outline: expected finite azimuths and elevations from -90 to 90")
    least = corners[:, 0].min()

    def sees(directions: Floats) -> Flags:
        azimuth, elevation = azimuth_elevation_deg_of(directions)
        first = least + (azimuth - least) % 360
        seen = np.zeros(len(directions), bool)
        # A polygon wider than a turn meets some azimuths twice.
        for turn in range(1 + int(np.ptp(corners[:, 0]) // 360)):
            crossings = np.zeros(len(directions), bool)
            x = first + 360 * turn
            for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0)):
                if y0 == y1:
                    continue
                level = (y0 <= elevation) != (y1 <= elevation)
                crossings ^= level & (x < x0 + (elevation - y0) * (x1 - x0) / (y1 - y0))
            seen |= crossings
        return seen

    return sees


@checked
def angle_table(
    azimuth_deg: ArrayLike, elevation_deg: ArrayLike, angle_deg: ArrayLike
) -> Callable[[Floats], Floats]:
    """Angles on a grid as `lay_directions` takes them: linear between, constant beyond the edges.

    Args:
        azimuth_deg: (A,) ascending; where they span 360 the table goes all round.
        elevation_deg: (E,) ascending.
        angle_deg: (E, A) angles, degrees.

    Raises:
        omma.Error: not such a grid.
    """
    azimuths = array_of(azimuth_deg, "azimuth_deg")
    elevations = array_of(elevation_deg, "elevation_deg")
    angles = array_of(angle_deg, "angle_deg")
    for name, values in (("azimuth_deg", azimuths), ("elevation_deg", elevations)):
        if values.ndim != 1 or len(values) < 1 or not np.all(np.diff(values) > 0):
            raise Error(f"{name}: expected ascending numbers, found {values!r:.60}")
    if np.ptp(azimuths) > 360:
        raise Error(f"azimuth_deg: expected a turn at most, found {np.ptp(azimuths)}")
    if angles.shape != (len(elevations), len(azimuths)):
        expected = (len(elevations), len(azimuths))
        raise Error(f"angle_deg: expected shape {expected}, found {angles.shape}")
    if not np.all(np.isfinite(angles) & (angles > 0) & (angles < 180)):
        raise Error("angle_deg: expected angles above 0 and below 180")
    # Half of what is left of the turn goes to each edge.
    least = azimuths[0] - (360 - np.ptp(azimuths)) / 2

    def angle(directions: Floats) -> Floats:
        azimuth, elevation = azimuth_elevation_deg_of(directions)
        column, across = _between(azimuths, least + (azimuth - least) % 360)
        row, up = _between(elevations, elevation)
        next_column = np.minimum(column + 1, len(azimuths) - 1)
        next_row = np.minimum(row + 1, len(elevations) - 1)
        low = angles[row, column] * (1 - across) + angles[row, next_column] * across
        high = angles[next_row, column] * (1 - across) + angles[next_row, next_column] * across
        return np.radians(low * (1 - up) + high * up)

    return angle


def _between(knots: Floats, values: Floats) -> tuple[NDArray[np.int64], Floats]:
    # Knot below and the share of the way to the one above.
    position = np.interp(values, knots, np.arange(len(knots), dtype=np.float64))
    below = np.minimum(position.astype(np.int64), max(0, len(knots) - 2))
    return below, position - below


@checked
def load_angle_table(
    path: PathLike,
) -> tuple[Callable[[Floats], Floats], Callable[[Floats], Floats] | None]:
    """Horizontal and vertical angles from a CSV file, as `lay_directions` takes them.

    Its columns are named: azimuth_deg, elevation_deg, dphi_h_deg and, where the vertical angle is
    another, dphi_v_deg; lines in any order, one for each azimuth at each elevation. Empty lines,
    and what follows a ``#``, are passed over.

    Raises:
        omma.Error: the file cannot be read or is no such table; it names the line.
    """
    _, table, _ = read_table(path, (_COLUMNS[:3], _COLUMNS), "angle")
    azimuths, elevations, *angles = as_grid(path, table, "azimuths", "elevations")
    try:
        fields = [angle_table(azimuths, elevations, angle) for angle in angles]
    except Error as error:
        raise Error(f"{os.fsdecode(path)}: {error}") from None
    return fields[0], fields[1] if len(fields) > 1 else None


@checked
def acute_angle(
    angle_rad: Angle, density: Callable[[Floats], ArrayLike], *, one_way: bool = False
) -> Callable[[Floats], Floats]:
    """Angles made smaller where ``density`` (as of `AcuteZone` or `acute_zones`) is above 1.

    Divided by its square root, for horizontal and vertical angles alike, they give that many times
    as many ommatidia. With ``one_way`` they are divided by it, so that it is enough to do that to
    the vertical (or the horizontal) angles: a streak.
    """

    def angle(directions: Floats) -> Floats:
        base = np.asarray(angle_rad(directions) if callable(angle_rad) else angle_rad, np.float64)
        times = np.asarray(density(directions), dtype=np.float64)
        return np.asarray(base / (times if one_way else np.sqrt(times)))

    return angle
