"""Axes of pictures of responses: degrees, where a projection has them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from omma.base.arrays import Floats
from omma.base.directions import direction
from omma.base.figures import INK
from omma.picture.eye_maps import draw_graticule
from omma.picture.map_projections import MAP_HALVES, Projection

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Extent = tuple[float, float, float, float]

# Ommatidia beside each other by their number, in no direction.
LISTED = ("single_dimension", "single_dimension_fast")
_SPHERE: Extent = (-180.0, 180.0, -90.0, 90.0)


def draw_axes(
    panel: Axes, projection: str | None, ommatidia: int, lowest: bool, first: bool
) -> Extent:
    """Draws what says where directions are; where a picture goes: left, right, bottom, top."""
    if projection in ("mollweide", "lambert"):
        the_map = cast(Projection, projection)
        right, top = MAP_HALVES[the_map]
        extent = (-right, right, -top, top)
        panel.set_axis_off()
        panel.set_aspect("equal")
        panel.set(xlim=(extent[0] * 1.02, extent[1] * 1.02))
        panel.set(ylim=(extent[2] * 1.02, extent[3] * 1.02))
        draw_graticule(panel, the_map, labels=True)
        return extent
    if projection == "hemisphere":
        _hemispheres(panel)
        return (-2.0, 2.0, -1.0, 1.0)
    if projection == "facets":
        panel.set(xticks=[], yticks=[])
        for side in panel.spines.values():
            side.set_visible(False)
        panel.set_xlabel("the eyes' own facets, seen from within the head, up at the top")
        return (0.0, 2.0, 0.0, 1.0)
    if projection in LISTED:
        panel.set(xlabel="ommatidium", yticks=[])
        return (0.0, float(ommatidia), 0.0, ommatidia / 2)
    if projection == "spherical_split_orientationwise":
        ticks = np.arange(-120, 121, 60)
        panel.set_xticks([*(ticks - 180), *(ticks + 180)], [_degrees(t) for t in (*ticks, *ticks)])
        panel.axvline(0, color=INK, linewidth=0.8)
        _elevations(panel, first)
        panel.set_xlabel("azimuth (°), of the left eye and of the right eye")
        return (-360.0, 360.0, -90.0, 90.0)
    panel.set_xticks(range(-180, 181, 60), [_degrees(t) for t in range(-180, 181, 60)])
    if lowest:
        panel.set_xlabel("azimuth (°): left – ahead – right")
    if projection == "cylindrical":
        panel.set(yticks=[], ylabel="height on the eye")
    else:
        _elevations(panel, first)
    return _SPHERE


def _elevations(panel: Axes, first: bool) -> None:
    panel.set_yticks(range(-90, 91, 30), [_degrees(t) for t in range(-90, 91, 30)])
    if first:
        panel.set_ylabel("elevation (°)")


def _degrees(value: float) -> str:
    return f"{value:.0f}".replace("-", "−")


def _hemispheres(panel: Axes) -> None:
    """The left and the right half of the sphere as discs, equal-area, with circles each 30°."""
    panel.set_axis_off()
    panel.set_aspect("equal")
    panel.set(xlim=(-2.03, 2.03), ylim=(-1.2, 1.03))
    fine: dict[str, Any] = {"color": INK, "linewidth": 0.35, "alpha": 0.45}
    turn = np.linspace(0, 2 * np.pi, 181)
    for middle in (-1.0, 1.0):
        panel.plot(middle + np.cos(turn), np.sin(turn), color=INK, linewidth=0.7)
        azimuths = np.linspace(0, 180, 91) * middle
        for elevation in range(-60, 90, 30):
            panel.plot(*_on_disc(azimuths, np.full(91, elevation), middle), **fine)
        for azimuth in range(30, 180, 30):
            up = np.linspace(-90, 90, 91)
            panel.plot(*_on_disc(np.full(91, azimuth * middle), up, middle), **fine)
        word = "left −90°" if middle < 0 else "right 90°"
        panel.text(middle, -1.04, word, ha="center", va="top", fontsize="small")
    panel.text(0, -1.04, "ahead 0°", ha="center", va="top", fontsize="small")


def _on_disc(azimuth_deg: Floats, elevation_deg: Floats, middle: float) -> tuple[Floats, Floats]:
    x, y, z = np.moveaxis(direction(azimuth_deg, elevation_deg), -1, 0)
    stretch = 1 / np.sqrt(1 + np.clip(x * middle, 0, 1))
    return middle + middle * z * stretch, y * stretch
