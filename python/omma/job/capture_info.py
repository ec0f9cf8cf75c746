"""What there is to say of the cameras of a captured world, in words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma.job.extents import describe_extent
from omma.job.results_info import Lines
from omma.scene.capture_cameras import CaptureCameras


def describe_capture(cameras: CaptureCameras) -> Lines:
    """Number, box, spacing, heights and fields of cameras."""
    low, high = cameras.bounds
    corners = [", ".join(f"{x:.4g}" for x in corner) for corner in (low, high)]
    heights = np.quantile(cameras.positions_m[:, 1], (0, 0.5, 1))
    lines = [
        ("cameras", cameras.path or "in memory"),
        ("number", f"{len(cameras):,}"),
        ("bounds", f"({corners[0]}) to ({corners[1]}) m"),
        ("extent", describe_extent(high - low)),
        ("lowest", f"y = {heights[0]:.4g} m, median {heights[1]:.4g}, highest {heights[2]:.4g}"),
    ]
    if len(cameras) > 1:
        near, median, far = np.quantile(_to_next(cameras.positions_m), (0, 0.5, 1))
        lines.append(("spacing", f"{median:.4g} m to the next, median ({near:.4g} to {far:.4g} m)"))
    lines.append(("field of view", _fields(cameras.half_angles_deg)))
    unknown = int(np.isnan(cameras.half_angles_deg).any(axis=1).sum())
    if unknown:
        lines.append(("unknown fields", f"{unknown:,}: count as seeing all before the camera"))
    return lines


def _to_next(positions_m: NDArray[np.float64]) -> NDArray[np.float64]:
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(positions_m).query(positions_m, k=2)[0][:, 1])


def _fields(half_angles_deg: NDArray[np.float64]) -> str:
    """Of width by height, from the narrowest to the widest where they differ."""
    known = half_angles_deg[~np.isnan(half_angles_deg).any(axis=1)]
    if not len(known):
        return "not said by the file"
    texts = []
    for column in known.T:
        ends = {f"{2 * one:.1f}°": None for one in (column.min(), column.max())}
        texts.append(" to ".join(ends))
    return " x ".join(texts)
