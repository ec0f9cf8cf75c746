"""Splats that stand for nothing: faint ones, those that float far from what a scanner saw, and
those that stand for a sky."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, SplatCloud
from omma.base.arguments import array_of, checked, positive, within
from omma.base.arrays import Floats
from omma.scene.points import PointCloud
from omma.scene.splat_columns import PIECE, chosen


@checked
def cull_splats(
    splats: SplatCloud,
    *,
    least_opacity: float | None = None,
    scan: PointCloud | ArrayLike | None = None,
    distance_m: float | None = None,
    beyond_m: float | None = None,
    center_m: ArrayLike = (0.0, 0.0, 0.0),
    above_m: float | None = None,
) -> tuple[SplatCloud, dict[str, int]]:
    """Gaussian splats without floaters and sky, and how many were left out, by reason.

    Optimisers leave splats where no surface is, and paint the sky on splats far away, in place of
    which a `Background` or a light is then seen. A splat is where its middle is, in the world.

    Args:
        splats: of `load_splats`, of a scene, or made.
        least_opacity: fainter ones, of 0 to 1, are left out ("opacity").
        scan: points on surfaces, an `omma.scene.PointCloud` or positions (M, 3) in the world, m.
        distance_m: those farther than this from the nearest point of ``scan`` are left out
            ("distance").
        beyond_m: those farther than this from ``center_m`` are left out ("beyond").
        center_m: (3,), in the world, m.
        above_m: those whose y in the world is more than this, m, are left out ("above").

    Example:
        >>> cloud = omma.scene.SplatCloud(
        ...     [(0, 0, -1), (0, 900, 0)], np.full((2, 3), 0.1), [(0, 0, 0, 1)] * 2, [0.9, 0.9],
        ...     np.zeros((2, 1, 3)),
        ... )
        >>> omma.scene.cull_splats(cloud, beyond_m=100)
        (<omma.scene.SplatCloud of 1 splats>, {'beyond': 1})

    Raises:
        omma.Error: numbers out of range, one of scan and distance_m alone, no points, or no splat
            is left.
    """
    if (scan is None) != (distance_m is None):
        raise Error("distance_m: expected scan and distance_m together, found one of them")
    count = len(splats.positions_m)
    kept = np.ones(count, bool)
    counts: dict[str, int] = {}

    def keep(reason: str, fits: NDArray[np.bool_]) -> None:
        counts[reason] = int(np.count_nonzero(kept & ~fits))
        np.logical_and(kept, fits, out=kept)

    if least_opacity is not None:
        keep("opacity", splats.opacities >= within(least_opacity, "least_opacity", 0, 1))
    center = array_of(center_m, "center_m", (3,), finite=True)
    if beyond_m is not None:
        most = positive(beyond_m, "beyond_m")
        keep("beyond", _each(splats, center, lambda at: np.linalg.norm(at, axis=1) <= most))
    if above_m is not None:
        height = within(above_m, "above_m", -1e12, 1e12)
        keep("above", _each(splats, np.zeros(3), lambda at: at[:, 1] <= height))
    if scan is not None and distance_m is not None:
        keep("distance", _near(splats, kept, scan, positive(distance_m, "distance_m")))
    if not kept.any():
        why = ", ".join(f"{reason}: {left:,}" for reason, left in counts.items())
        raise Error(f"expected some splats to be left, found none of {count:,} ({why})")
    return (splats if kept.all() else chosen(splats, kept)), counts


def _positions(splats: SplatCloud, rows: NDArray[np.intp] | slice, offset: Floats) -> Floats:
    """(n, 3), in the world, from an offset on: so that a survey far from zero keeps its
    millimetres."""
    matrix = splats.world_from_splats
    placed: Floats = splats.positions_m[rows] @ matrix[:3, :3].T + (matrix[:3, 3] - offset)
    return placed


def _each(
    splats: SplatCloud, offset: Floats, fits: Callable[[Floats], NDArray[np.bool_]]
) -> NDArray[np.bool_]:
    """Of all splats, by their positions from an offset on, in pieces."""
    count = len(splats.positions_m)
    found = np.ones(count, bool)
    for start in range(0, count, PIECE):
        rows = slice(start, start + PIECE)
        found[rows] = fits(_positions(splats, rows, offset))
    return found


def _near(
    splats: SplatCloud, rows: NDArray[np.bool_], scan: PointCloud | ArrayLike, distance_m: float
) -> NDArray[np.bool_]:
    """Of those in some rows, which have a point of the scan within that distance."""
    from scipy.spatial import cKDTree

    offset = np.zeros(3)
    if isinstance(scan, PointCloud):
        offset, points = scan.offset_m, scan.positions_m
    else:
        points = array_of(scan, "scan", (None, 3))
        if not np.isfinite(points).all():
            raise Error("scan: expected finite positions")
    if not len(points):
        raise Error("scan: expected points, found none")
    tree = cKDTree(points)
    numbers = np.flatnonzero(rows)
    near = np.zeros(len(rows), bool)
    for start in range(0, len(numbers), PIECE):
        some = numbers[start : start + PIECE]
        # The bound is exclusive, a limit is not.
        bound = np.nextafter(distance_m, np.inf)
        found, _ = tree.query(_positions(splats, some, offset), distance_upper_bound=bound)
        near[some] = np.isfinite(found)
    return near
