"""Splats that stand for nothing: faint ones, and those that float far from what a scanner saw."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import array_of, positive, within
from omma.scene.points import PointCloud
from omma.scene.splat_arrays import SplatArrays
from omma.scene.splat_columns import PIECE


def cull_splats(
    splats: SplatArrays,
    *,
    least_opacity: float | None = None,
    scan: Any = None,
    distance_m: float | None = None,
) -> tuple[SplatArrays, dict[str, int]]:
    """The splats without floaters, and how many were left out, by reason.

    Args:
        least_opacity: fainter ones are left out ("opacity").
        scan: points on surfaces, an `omma.scene.PointCloud` or positions (M, 3) in the world, m.
        distance_m: splats whose centre is farther than this from the nearest point of ``scan`` are
            left out ("distance").

    Raises:
        omma.Error: one of scan and distance_m alone, no points, or no splat is left.
    """
    if (scan is None) != (distance_m is None):
        raise Error("distance_m: expected scan and distance_m together, found one of them")
    kept = np.ones(len(splats), bool)
    counts: dict[str, int] = {}
    if least_opacity is not None:
        kept = splats.opacities >= within(least_opacity, "least_opacity", 0, 1)
        counts["opacity"] = int(np.count_nonzero(~kept))
    if distance_m is not None:
        near = _near(splats, kept, scan, positive(distance_m, "distance_m"))
        counts["distance"] = int(np.count_nonzero(kept & ~near))
        kept &= near
    if not kept.any():
        why = ", ".join(f"{reason}: {count:,}" for reason, count in counts.items())
        raise Error(f"expected some splats to be left, found none of {len(splats):,} ({why})")
    if kept.all():
        return splats, counts
    return splats.chosen(kept), counts


def _near(
    splats: SplatArrays, chosen: NDArray[np.bool_], scan: Any, distance_m: float
) -> NDArray[np.bool_]:
    """Of those chosen, which have a point of the scan within that distance."""
    from scipy.spatial import cKDTree

    # About the scan's offset, so that a survey far from zero keeps its millimetres.
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
    matrix = splats.world_from_splats
    rows = np.flatnonzero(chosen)
    near = np.zeros(len(splats), bool)
    for start in range(0, len(rows), PIECE):
        some = rows[start : start + PIECE]
        places = splats.positions[some] @ matrix[:3, :3].T + (matrix[:3, 3] - offset)
        # The bound is exclusive, a limit is not.
        bound = np.nextafter(distance_m, np.inf)
        near[some] = np.isfinite(tree.query(places, distance_upper_bound=bound)[0])
    return near
