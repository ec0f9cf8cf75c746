"""Figures of where photographs were taken from, of which a world was made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import checked, positive
from omma.base.arrays import Floats
from omma.base.figures import COLOURS, GREY, MM, figure_names, figure_style, load_matplotlib, plain
from omma.base.figures import save_figure as save
from omma.base.files import PathLike
from omma.base.poses import as_poses
from omma.scene.capture_cameras import CaptureCameras

# Around all that is drawn, and how long a camera's line of sight is, of the longest side, which is
# so many metres at least.
_MARGIN, _SIGHT, _SMALLEST_M = 0.08, 0.05, 0.1
# Height over width of a panel, at least and at most, so that a walk along a line is a figure still.
_FLATTEST, _TALLEST = 0.15, 1.5


@checked
def plot_capture_cameras(
    paths: PathLike | Sequence[PathLike],
    cameras: CaptureCameras,
    *,
    poses: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None,
    title: str | None = None,
    size_mm: float = 120.0,
) -> None:
    """Draw the cameras of a captured world from above and from the side, in the hull around them,
    and where heads are.

    From above -Z is at the top and +X at the right, from the side +Y is at the top, both with one
    scale. A line from each camera says where it looked. Outside the hull, and far from all cameras
    inside it, the world was seen by nobody.

    Args:
        paths: .pdf, .svg or .png, one or several.
        poses: of heads, as a renderer takes them.
        title: by default how many cameras there are, and where they come from.
        size_mm: width of the figure.

    Raises:
        omma.Error: Matplotlib is missing, a name ends in something else, an argument is out of
            range, a file cannot be written.
    """
    names = figure_names(paths)
    positive(size_mm, "size_mm")
    heads = np.empty((0, 3)) if poses is None else as_poses(poses)[:, :3, 3]
    if not np.isfinite(heads).all():
        raise Error("poses: expected finite numbers")
    if title is None:
        title = f"{len(cameras):,} camera{'s' if len(cameras) > 1 else ''}"
        title += f" of {cameras.path}" if cameras.path else ""
    with figure_style(max(3.0, 7.5 * size_mm / 120)):
        save(_figure(cameras, heads, title, size_mm), names)


def hull_outline(points: Floats) -> Floats:
    """Corners of the hull around points (N, 2), in their order: (K, 2); the two ends where all lie
    on a line."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        along = points @ (np.linalg.svd(points - points.mean(axis=0))[2][0])
        return np.asarray(points[[along.argmin(), along.argmax()]])


def _figure(cameras: CaptureCameras, heads: Floats, title: str, size_mm: float) -> Any:
    everything = np.concatenate([cameras.positions_m, heads])
    low, high = everything.min(axis=0), everything.max(axis=0)
    longest = max(float((high - low).max()), _SMALLEST_M)
    low, high = low - _MARGIN * longest, high + _MARGIN * longest
    size = high - low
    heights = [float(np.clip(size[axis] / size[0], _FLATTEST, _TALLEST)) for axis in (2, 1)]
    figure = load_matplotlib()(
        figsize=(size_mm * MM, size_mm * MM * (0.85 * sum(heights) + 0.4)), layout="constrained"
    )
    figure.suptitle(plain(title))
    panels = figure.subplots(2, 1, height_ratios=heights, sharex=True)
    sights = -_SIGHT * longest * cameras.world_from_camera[:, :, 2]
    for panel, name, axis, label in (
        (panels[0], "from above", 2, "z (m)"),
        (panels[1], "from the side", 1, "y (m)"),
    ):
        _draw(panel, cameras.positions_m[:, [0, axis]], sights[:, [0, axis]], heads[:, [0, axis]])
        panel.set(title=name, ylabel=label, aspect="equal")
        panel.set(xlim=(low[0], high[0]), ylim=(low[axis], high[axis]))
        panel.ticklabel_format(useOffset=False, style="plain")
        panel.locator_params(nbins=6)
    panels[1].set_xlabel("x (m)")
    panels[0].invert_yaxis()  # -Z at the top
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False
    )
    return figure


def _draw(panel: Any, at: Floats, sights: Floats, heads: Floats) -> None:
    from matplotlib.collections import LineCollection

    outline = hull_outline(at)
    closed = np.concatenate([outline, outline[:1]])
    panel.fill(*outline.T, color=COLOURS[0], alpha=0.1, linewidth=0)
    panel.plot(*closed.T, color=COLOURS[0], linewidth=0.8, label="hull of the cameras")
    panel.add_collection(
        LineCollection([*np.stack([at, at + sights], axis=1)], colors=GREY, linewidths=0.5)
    )
    panel.plot(*at.T, "o", color=COLOURS[0], markersize=2, label="camera, and where it looked")
    if len(heads):
        panel.plot(*heads.T, "x", color=COLOURS[1], markersize=3.5, label="head")
