"""What there is to say of the cameras of a captured world, in words."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from omma.base.files import PathLike
from omma.job.extents import describe_extent, without_rounding
from omma.job.places import place_words
from omma.job.results_info import Lines
from omma.scene.capture_cameras import CaptureCameras, load_capture_cameras

# The axes that may be up in a file.
_UPS = ("y", "z", "-y")
# Where photographs are held upright, more or less: the length of the mean of their own up axes,
# and how far that mean may be off up before another axis is looked for.
_ALIKE, _TILTED_DEG = 0.5, 45.0


def describe_capture(path: PathLike, unit: str | float | None, up: str | None) -> Lines:
    """Number, box, spacing, heights and fields of cameras, and whether they are upright."""
    cameras = load_capture_cameras(path, unit="m" if unit is None else unit, up=up)
    low, high = cameras.bounds
    largest = float(np.max(high - low))
    low, high = without_rounding(low, largest), without_rounding(high, largest)
    heights = without_rounding(np.quantile(cameras.positions_m[:, 1], (0, 0.5, 1)), largest)
    lines = [
        ("cameras", cameras.path or "in memory"),
        ("number", f"{len(cameras):,}"),
        ("bounds", f"{place_words(low)} to {place_words(high)} m"),
        ("extent", describe_extent(high - low, up=None)),
        ("lowest", f"y = {heights[0]:.4g} m, median {heights[1]:.4g}, highest {heights[2]:.4g}"),
    ]
    if len(cameras) > 1:
        near, median, far = np.quantile(_to_next(cameras.positions_m), (0, 0.5, 1))
        lines.append(("spacing", f"{median:.4g} m to the next, median ({near:.4g} to {far:.4g} m)"))
    lines.append(("upright", _upright(cameras, path)))
    lines.append(("field of view", _fields(cameras.half_angles_deg)))
    unknown = int(np.isnan(cameras.half_angles_deg).any(axis=1).sum())
    if unknown:
        lines.append(("unknown fields", f"{unknown:,}: count as seeing all before the camera"))
    return lines


def _upright(cameras: CaptureCameras, path: PathLike) -> str:
    """How far from +Y the cameras' own up is on average, and which axis would be nearer."""
    tilt_deg = _tilt_deg(cameras)
    if math.isnan(tilt_deg):
        return "photographs are turned every way, which says nothing of what is up"
    text = f"the cameras' own up is {tilt_deg:.0f}° from +Y on average"
    if tilt_deg > _TILTED_DEG:
        others = {up: _tilt_deg(load_capture_cameras(path, up=up)) for up in _UPS}
        best = min(others, key=lambda up: others[up])
        if others[best] < _TILTED_DEG:
            text += f", and {others[best]:.0f}° with --up {best} (--capture-up {best} of a render)"
    return text


def _tilt_deg(cameras: CaptureCameras) -> float:
    """Between the mean of the cameras' up axes and +Y; NaN where they have nothing in common."""
    mean = cameras.world_from_camera[:, :, 1].mean(axis=0)
    length = float(np.linalg.norm(mean))
    return math.degrees(math.acos(mean[1] / length)) if length > _ALIKE else math.nan


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
