"""Drawings of eyes: the ommatidia seen from afar, as facets and as axes, with a scale bar.

Orthographic, from a direction given in the head's frame. Needs matplotlib, an optional extra.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.base.arguments import checked, positive
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.figures import INK, figure_names, figure_style, load_matplotlib, plain, save_figure
from omma.base.files import PathLike
from omma.eye.measures import EyeMeasures, measure_eye
from omma.eye.neighbours import sides, surface_lattice, surface_normals
from omma.eye.properties import EyeProperty, expect_property, eye_property, is_known
from omma.picture.eye_maps import colour_scale, count_of, known_name

Style = Literal["facets", "axes", "both"]

_MM = 1e3  # drawings are laid out in millimetres
_PLAIN = "#7a93ac"
_UNKNOWN = "#9e9e9e"
_SHADE = 0.55  # of what is seen from its edge: without it what is round looks flat
_MOST_AXES_OVER_FACETS = 500


@checked
def draw_eye(
    paths: PathLike | Sequence[PathLike],
    eye: Eye,
    *,
    yaw_deg: float = 0.0,
    pitch_deg: float = 0.0,
    style: Style = "facets",
    colour: str = "interommatidial",
    back: bool = False,
    axis_length_mm: float | None = None,
    size_mm: float = 150.0,
    title: str | None = None,
    measures: EyeMeasures | None = None,
) -> None:
    """Draw an eye to `.pdf`, `.svg` and `.png` files.

    ``yaw_deg`` and ``pitch_deg`` are the azimuth and the elevation of the direction from which it
    is seen: yaw 0 is from ahead, so that the animal's right is on the left of the drawing; yaw 90
    is from its right, pitch 90 from above. Only what faces the viewer is drawn, unless ``back``.

    Args:
        style: "facets" fill the surface that the positions form, hexagons where these are a
            hexagonal lattice; "axes" are lines from the positions; "both" draws facets and some
            500 of the axes.
        colour: what colours mean: one of `omma.eye.PROPERTIES` ("interommatidial", "acceptance",
            "facet", "eye" and others), one of the eye's columns, or "none".
        axis_length_mm: length of the lines; by default a tenth of the eye.
        size_mm: width of the drawing.
        measures: of `measure_eye`, where they have been taken.

    Raises:
        omma.Error: matplotlib is missing, a name ends in none of .pdf, .svg and .png, an argument
            is wrong, a file cannot be written.
    """
    names = figure_names(paths)
    _one_of(style, ("facets", "axes", "both"), "style")
    for value, what in ((yaw_deg, "yaw_deg"), (pitch_deg, "pitch_deg")):
        if not math.isfinite(value):
            raise Error(f"{what}: expected a finite angle, found {value}")
    positive(size_mm, "size_mm")
    if axis_length_mm is not None:
        positive(axis_length_mm, "axis_length_mm")
    prop = None
    if colour != "none":
        expect_property(eye, colour, "colour")
        prop = eye_property(eye, measures or measure_eye(eye), colour, "colour")
    view = view_from(math.radians(yaw_deg), math.radians(pitch_deg))
    drawing = _Drawing(eye, view, style, back, axis_length_mm)
    with figure_style(min(9.0, max(3.0, 9 * size_mm / 150))):
        title = title or _title(eye, yaw_deg, pitch_deg, drawing)
        save_figure(_figure(drawing, prop, size_mm, title), names)


def draw_view(
    panel: Any, eye: Eye, view: Floats, prop: EyeProperty, *, shape: float, scale: EyeProperty
) -> list[str]:
    """An eye's facets in a panel that is ``shape`` times as wide as high, filled as far as they
    go. With a scale bar of its own, and shaded where they turn away from the viewer. Colours mean
    what they mean in a map of ``scale``.

    Returns:
        What is not as it looks, a note each.
    """
    from matplotlib.colors import to_rgba

    drawing = _Drawing(eye, view, "facets", False, None)
    low, high = _frame(drawing)
    middle, size = (low + high) / 2, high - low
    half = np.array([1.0, 1 / shape]) * max(size[0], shape * size[1]) / 2
    low, high = middle - half, middle + half
    _ready(panel, low, high)
    marks = _facets(drawing)
    # As lines they would only blur facets this small, and fill the file.
    marks.set(linewidth=0, rasterized=True)
    panel.add_collection(marks)
    values = np.ma.masked_invalid(prop.values[drawing.shown])
    if is_known(scale):
        marks.set_array(values)
        colour_scale(None, panel, marks, scale, None)
        _unknown_grey(marks)
        colours = marks.to_rgba(values)
    else:
        colours = np.full((len(values), 4), to_rgba(_UNKNOWN))
    facing = (drawing.normal @ view[2])[drawing.shown]
    colours[:, :3] *= (1 - _SHADE * (1 - np.clip(facing, 0, 1)))[:, None]
    marks.set_array(None)
    marks.set_facecolor(colours)
    if drawing.to_scale:
        _scale_bar(panel, low, high)
    _compass(drawing, panel, low, high)
    return drawing.notes()


class _Drawing:
    """What is to be drawn, in millimetres, right and up in the picture and towards the viewer."""

    def __init__(
        self, eye: Eye, view: Floats, style: Style, back: bool, axis_length_mm: float | None
    ) -> None:
        position = eye.position_m.astype(np.float64) * _MM
        axis = eye.axis.astype(np.float64)
        extent = float(np.max(np.ptp(position, axis=0)))
        self.length = axis_length_mm or 0.1 * extent or 1.0
        self.diameter = np.zeros(len(eye))
        self.lifted = False
        if style != "axes":
            self.diameter = _facet_diameters(position)
            if len(eye) == 1:
                self.diameter = eye.facet_diameter_m.astype(np.float64) * _MM
            # Eyes with all their ommatidia at a point have facets of no size there.
            elif np.median(self.diameter) <= 1e-4 * extent:
                position = position + axis * self.length
                self.diameter = _facet_diameters(position)
                self.lifted = True
        # One ommatidium without a facet's diameter has a size of its own: none.
        self.to_scale = style == "axes" or bool(self.diameter.any())
        if not self.to_scale:
            self.diameter = np.full(len(eye), self.length)
        self.normal = axis
        if style != "axes":
            self.normal = _normals(position, axis, eye.eye_id)
        towards = self.normal @ view[2]
        self.shown = np.arange(len(eye)) if back else np.flatnonzero(towards > 0)
        depth = position @ view[2]
        self.shown = self.shown[np.argsort(depth[self.shown], kind="stable")]
        # Beside others that have facets, an eye at a point has none that would be seen.
        self.at_points = np.count_nonzero(self.diameter[self.shown] <= 1e-4 * extent)
        self.eye, self.style, self.view, self.position = eye, style, view, position
        self.start = (position @ view.T)[:, :2]
        self.along = (axis @ view.T)[:, :2]

    def notes(self) -> list[str]:
        """What is not as it looks."""
        if self.style == "axes":
            return []
        if not self.to_scale:
            return ["not to scale: its facet's diameter is not known"]
        if self.lifted:
            return [f"an eye's ommatidia are all at one point: drawn {_length(self.length)} out"]
        if self.at_points:
            return [f"{self.at_points:,} at one point with others: no facets to be seen"]
        return []


def view_from(yaw: float, pitch: float) -> Floats:
    # Rows: right, up and towards the viewer, in the head's frame. At yaw 0 the viewer is at -Z.
    towards = [math.cos(pitch) * math.sin(yaw), math.sin(pitch), -math.cos(pitch) * math.cos(yaw)]
    right = [-math.cos(yaw), 0.0, -math.sin(yaw)]
    return np.array([right, np.cross(towards, right), towards])


def _facet_diameters(position: Floats) -> Floats:
    # The mean distance to the six nearest positions: the diameter of hexagons that fill the
    # surface, across their flats.
    from scipy.spatial import cKDTree

    count = min(6, len(position) - 1)
    if count == 0:
        return np.zeros(len(position))
    diameter = cKDTree(position).query(position, k=count + 1)[0][:, 1:].mean(axis=1)
    # The rim of an eye, and where two eyes meet, must not grow huge discs.
    return np.asarray(np.minimum(diameter, 3 * float(np.median(diameter))))


def _normals(position: Floats, axis: Floats, eye_id: NDArray[np.int32]) -> Floats:
    """The surface's normals, the axis where the positions form none: (N, 3)."""
    which = sides(position, eye_id)
    normal = surface_normals(position, surface_lattice(position, which))
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.where(length > 1e-9, normal / np.maximum(length, 1e-9), axis)


def _corners(drawing: _Drawing) -> list[Floats]:
    """The corners of the facets shown, in the picture: (corners, 2) each, mm.

    Inside the surface a facet's corners are the middles of the triangles around it, so that facets
    fill the surface. At its border, where these are not all there, they are regular hexagons with
    sides that face the neighbours: turned by the mean of e^{6iα} of the neighbours' azimuths α,
    which hexagonal symmetry leaves as it is.
    """
    position, normal = drawing.position, drawing.normal
    aside = np.cross(normal, np.array([0.0, 1.0, 0.0]))
    flat = np.linalg.norm(aside, axis=1, keepdims=True) < 1e-6
    aside = np.where(flat, np.array([1.0, 0.0, 0.0]), aside)
    aside = normalized(aside)
    over = np.cross(aside, normal)

    def azimuth(of: NDArray[np.int64], point: Floats) -> Floats:
        step = point - position[of]
        along, across = (step * over[of]).sum(axis=1), (step * aside[of]).sum(axis=1)
        return np.asarray(np.arctan2(along, across))

    lattice = surface_lattice(position, sides(position, drawing.eye.eye_id))
    turn = np.zeros(len(position), complex)
    for one, other in (lattice.pairs.T, lattice.pairs.T[::-1]):
        np.add.at(turn, one, np.exp(6j * azimuth(one, position[other])))
    angle = (np.angle(turn) / 6 + np.pi / 6)[:, None] + np.arange(6) * np.pi / 3
    radius = drawing.diameter[:, None, None] / math.sqrt(3)  # their width is across the flats
    hexagons = position[:, None] + radius * (
        np.cos(angle)[..., None] * aside[:, None] + np.sin(angle)[..., None] * over[:, None]
    )
    corners = list(hexagons)
    around = lattice.triangles.ravel()
    middle = np.repeat(position[lattice.triangles].mean(axis=1), 3, axis=0)
    order = np.lexsort((azimuth(around, middle), around))
    around, middle = around[order], middle[order]
    starts = np.flatnonzero(np.diff(around, prepend=-1))
    ends = np.append(starts[1:], len(around))
    for first, end in zip(starts.tolist(), ends.tolist(), strict=False):
        if not lattice.border[around[first]]:
            corners[around[first]] = middle[first:end]
    return [(corners[i] @ drawing.view.T)[:, :2] for i in drawing.shown]


def _figure(drawing: _Drawing, prop: EyeProperty | None, size_mm: float, title: str) -> Any:
    low, high = _frame(drawing)
    inches = size_mm / 25.4
    across_over_up = (high[0] - low[0]) / (high[1] - low[1])
    height = inches * ((0.85 if prop else 1) / across_over_up + 0.1)  # a bar beside, a title above
    figure = load_matplotlib()(figsize=(inches, max(height, 0.45 * inches)), layout="constrained")
    axes = figure.add_subplot()
    _ready(axes, low, high)
    notes = []
    if drawing.style != "axes":
        marks = _facets(drawing)
        axes.add_collection(marks)
    if drawing.style != "facets":
        every = 1
        if drawing.style == "both":
            # More would hide the facets.
            every = max(1, round(len(drawing.shown) / _MOST_AXES_OVER_FACETS))
        lines = _lines(drawing, np.sort(drawing.shown)[::every])
        axes.add_collection(lines)
        if drawing.style == "axes":
            marks = lines
        else:
            lines.set(color=INK, alpha=0.7, linewidth=0.5)
        if every > 1:
            notes.append(f"one axis in {every} is drawn")
    if prop is None:
        marks.set_color(_PLAIN if drawing.style != "axes" else INK)
    elif not is_known(prop):
        marks.set_color(_PLAIN)
        notes.append(f"{prop.label}: not known")
    else:
        marks.set_array(np.ma.masked_invalid(prop.values[drawing.shown]))
        colour_scale(figure, axes, marks, prop, "right")
        _unknown_grey(marks)
        if not np.isfinite(prop.values[drawing.shown]).all():
            notes.append("grey: not known, at a rim for want of neighbours")
    if drawing.style != "axes":
        marks.set_edgecolor("#ffffff60")
    notes += drawing.notes()
    # As many letters as fit, at 150 mm; smaller drawings have smaller type.
    words = [line for text in [*title.splitlines(), *notes] for line in textwrap.wrap(text, 82)]
    figure.suptitle(plain("\n".join(words)), color=INK, fontsize="medium")
    if drawing.to_scale:
        _scale_bar(axes, low, high)
    _compass(drawing, axes, low, high)
    return figure


def _unknown_grey(marks: Any) -> None:
    """What has no value is seen as grey, not as a hole in the eye."""
    marks.set_cmap(marks.cmap.with_extremes(bad=_UNKNOWN))


def _ready(axes: Any, low: Floats, high: Floats) -> None:
    axes.set_aspect("equal")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_axis_off()


def _lines(drawing: _Drawing, shown: NDArray[np.int64]) -> Any:
    from matplotlib.collections import LineCollection

    end = drawing.start + drawing.along * drawing.length
    lines = np.stack([drawing.start[shown], end[shown]], axis=1)
    # Many lines would melt into one another.
    return LineCollection(list(lines), linewidths=min(0.8, 25 / math.sqrt(len(shown) + 1)))


def _facets(drawing: _Drawing) -> Any:
    from matplotlib.collections import PolyCollection

    return PolyCollection(_corners(drawing), linewidths=0.2, edgecolors="#ffffff60")


def _frame(drawing: _Drawing) -> tuple[Floats, Floats]:
    # Lower left and upper right corner: what is drawn, with space below for scale and compass.
    shown = drawing.shown if len(drawing.shown) else np.arange(len(drawing.start))
    reach = drawing.start[shown]
    if drawing.style != "facets":
        reach = np.concatenate([reach, reach + drawing.along[shown] * drawing.length])
    half = float(drawing.diameter.max()) / math.sqrt(3)  # from a hexagon's middle to its corners
    low, high = reach.min(axis=0) - half, reach.max(axis=0) + half
    size = high - low
    width = float(max(size[0], 0.8 * size[1], 1e-9)) * 1.04
    middle = (low + high) / 2
    return (
        np.array([middle[0] - width / 2, low[1] - 0.2 * width]),
        np.array([middle[0] + width / 2, high[1] + 0.02 * width]),
    )


def _scale_bar(axes: Any, low: Floats, high: Floats) -> None:
    side = float(high[0] - low[0])
    length = _round_length(0.25 * side)
    left, level = low[0] + 0.03 * side, low[1] + 0.03 * side
    axes.plot([left, left + length], [level] * 2, color=INK, linewidth=2, solid_capstyle="butt")
    axes.text(left + length / 2, level + 0.015 * side, _length(length), ha="center", va="bottom")


def _compass(drawing: _Drawing, axes: Any, low: Floats, high: Floats) -> None:
    # The head's own directions, the longest first; what points at the viewer or away, or would lie
    # on another, is left out.
    side = float(high[0] - low[0])
    centre, length = np.array([high[0] - 0.1 * side, low[1] + 0.09 * side]), 0.055 * side
    signed = {
        "right": drawing.view[:2, 0],
        "up": drawing.view[:2, 1],
        "ahead": -drawing.view[:2, 2],
    }
    drawn: list[Floats] = []
    for name, along in sorted(signed.items(), key=lambda item: -float(np.linalg.norm(item[1]))):
        way = along / max(float(np.linalg.norm(along)), 1e-9)
        if np.linalg.norm(along) < 0.2 or any(way @ other > 0.9 for other in drawn):
            continue
        drawn.append(way)
        end = centre + along * length
        arrow = {"arrowstyle": "->", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", end, centre, arrowprops=arrow)
        sideways = abs(along[0]) > abs(along[1])
        axes.text(
            *(end + 0.12 * length * way),
            name,
            ha=("left" if along[0] > 0 else "right") if sideways else "center",
            va="center" if sideways else ("bottom" if along[1] > 0 else "top"),
            fontsize="small",
            color=INK,
        )


def _title(eye: Eye, yaw_deg: float, pitch_deg: float, drawing: _Drawing) -> str:
    name = f"{known}\n" if (known := known_name(eye)) else ""
    facing = "" if len(drawing.shown) == len(eye) else f": {len(drawing.shown):,} face the viewer"
    view = f"seen from yaw {yaw_deg:g}°, pitch {pitch_deg:g}°{facing}"
    return f"{name}{count_of(len(eye))}, {view}"


def _round_length(most: float) -> float:
    # 1, 2 or 5 times a power of ten, at most that.
    power = 10.0 ** math.floor(math.log10(most))
    return next(f * power for f in (5.0, 2.0, 1.0) if f * power <= most * (1 + 1e-9))


def _length(mm: float) -> str:
    return f"{mm:.3g} mm" if mm >= 0.1 else f"{mm * 1e3:.3g} µm"


def _one_of(value: str, known: tuple[str, ...], name: str) -> None:
    if value not in known:
        raise Error(f"{name}: expected {', '.join(known[:-1])} or {known[-1]}, found {value!r}")
