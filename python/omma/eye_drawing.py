"""Drawings of eyes: the ommatidia seen from afar, as facets or as axes, with a scale bar.

Orthographic, from a direction given in the head's frame. Needs matplotlib, an optional extra.
"""

from __future__ import annotations

import io
import math
import os
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye
from omma.arguments import positive
from omma.files import PathLike, WholeFiles, check_target
from omma.sampling_plots import load_matplotlib

Floats = NDArray[np.float64]
Style = Literal["facets", "axes"]
Colour = Literal["interommatidial", "acceptance", "eye", "none"]

_MM = 1e3  # drawings are laid out in millimetres
_INK = "#222222"
# Left and right as on ships would do, were red and green easy to tell apart for everyone.
_EYE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")


def draw_eye(
    paths: PathLike | Sequence[PathLike],
    eye: Eye,
    *,
    yaw_deg: float = 0.0,
    pitch_deg: float = 0.0,
    style: Style = "facets",
    colour: Colour = "interommatidial",
    back: bool = False,
    axis_length_mm: float | None = None,
    size_mm: float = 150.0,
    title: str | None = None,
) -> None:
    """Draw an eye to `.svg` and `.png` files.

    ``yaw_deg`` and ``pitch_deg`` are the azimuth and the elevation of the direction from which it
    is seen: yaw 0 is from ahead, so that the animal's right is on the left of the drawing; yaw 90
    is from its right, pitch 90 from above. Only what faces the viewer is drawn, unless ``back``.

    Args:
        style: "facets" are discs, as wide as the distance to the six nearest positions and turned
            as the axis is; "axes" are lines from the positions.
        colour: "interommatidial" (local interommatidial angle), "acceptance" (acceptance angle),
            "eye" (which eye) or "none".
        axis_length_mm: length of the lines; by default a tenth of the eye.
        size_mm: width of the drawing.

    Raises:
        omma.Error: matplotlib is missing, a name ends in neither .svg nor .png, an argument is
            wrong, a file cannot be written.
    """
    names = check_names(paths)
    _one_of(style, ("facets", "axes"), "style")
    _one_of(colour, ("interommatidial", "acceptance", "eye", "none"), "colour")
    for value, what in ((yaw_deg, "yaw_deg"), (pitch_deg, "pitch_deg")):
        if not math.isfinite(value):
            raise Error(f"{what}: expected a finite angle, found {value}")
    positive(size_mm, "size_mm")
    if axis_length_mm is not None:
        positive(axis_length_mm, "axis_length_mm")
    view = _view(math.radians(yaw_deg), math.radians(pitch_deg))
    drawing = _Drawing(eye, view, style, back, axis_length_mm)
    load_matplotlib()
    from matplotlib import rc_context

    size_pt = min(9.0, max(3.0, 9 * size_mm / 150))
    # Text as outlines, and no ids or dates that change: the same eye gives the same bytes.
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "omma", "font.size": size_pt}):
        title = title or _title(eye, yaw_deg, pitch_deg, drawing)
        figure = _figure(drawing, colour, size_mm, title)
        with WholeFiles() as files:
            for name in names:
                kind = Path(name).suffix.lower()[1:]
                picture = io.BytesIO()
                metadata = {"Date": None} if kind == "svg" else {}
                figure.savefig(picture, format=kind, dpi=200, metadata=metadata)
                files.open(name).write(picture.getvalue())


def check_names(paths: PathLike | Sequence[PathLike]) -> list[str]:
    """The names; omma.Error where one ends in neither .svg nor .png or cannot be written."""
    given = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    names = [os.fsdecode(path) for path in given]
    for name in names:
        if Path(name).suffix.lower() not in (".svg", ".png"):
            raise Error(f"{name}: expected a name ending in .svg or .png")
        check_target(name)
    return names


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
        if style == "facets":
            self.diameter = _facet_diameters(position)
            # Eyes with all their ommatidia at a point have facets of no size there.
            if np.median(self.diameter) <= 1e-4 * extent:
                position = position + axis * self.length
                self.diameter = _facet_diameters(position)
                self.lifted = True
        towards = axis @ view[2]
        self.shown = np.arange(len(eye)) if back else np.flatnonzero(towards > 0)
        depth = position @ view[2]
        self.shown = self.shown[np.argsort(depth[self.shown], kind="stable")]
        self.eye, self.style, self.view = eye, style, view
        self.start = (position @ view.T)[:, :2]
        self.along = (axis @ view.T)[:, :2]
        self.towards = towards


def _view(yaw: float, pitch: float) -> Floats:
    # Rows: right, up and towards the viewer, in the head's frame. At yaw 0 the viewer is at -Z.
    towards = [math.cos(pitch) * math.sin(yaw), math.sin(pitch), -math.cos(pitch) * math.cos(yaw)]
    right = [-math.cos(yaw), 0.0, -math.sin(yaw)]
    return np.array([right, np.cross(towards, right), towards])


def _facet_diameters(position: Floats) -> Floats:
    # The mean distance to the six nearest positions: the diameter of hexagons that fill the
    # surface, across their flats.
    count = min(6, len(position) - 1)
    diameter = np.zeros(len(position))
    if count == 0:
        return diameter
    squared = np.sum(position**2, axis=1)
    for start in range(0, len(position), 512):
        rows = position[start : start + 512]
        distance = squared[start : start + 512, None] + squared - 2 * rows @ position.T
        distance[np.arange(len(rows)), np.arange(start, start + len(rows))] = np.inf
        nearest = np.partition(np.maximum(distance, 0), count - 1, axis=1)[:, :count]
        diameter[start : start + 512] = np.sqrt(nearest).mean(axis=1)
    # The rim of an eye, and where two eyes meet, must not grow huge discs.
    return np.minimum(diameter, 3 * float(np.median(diameter)))


def _figure(drawing: _Drawing, colour: Colour, size_mm: float, title: str) -> Any:
    values, label, tell_apart = _values(drawing.eye, colour)
    low, high = _frame(drawing)
    inches = size_mm / 25.4
    across_over_up = (high[0] - low[0]) / (high[1] - low[1])
    height = inches * ((0.85 if label else 1) / across_over_up + 0.1)  # a bar beside, a title above
    figure = load_matplotlib()(figsize=(inches, max(height, 0.45 * inches)), layout="constrained")
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_axis_off()
    marks = _marks(drawing, axes)
    if values is not None:
        least, most, extend = _limits(values)
        marks.set_array(values[drawing.shown])
        marks.set(clim=(least, most), cmap="viridis")
        bar = figure.colorbar(marks, ax=axes, shrink=0.75, aspect=30, extend=extend, pad=0.02)
        bar.set_label(label)
        bar.outline.set_visible(False)
    elif tell_apart:
        which = drawing.eye.eye_id[drawing.shown]
        marks.set_color([_EYE_COLOURS[i % len(_EYE_COLOURS)] for i in which])
        _legend(axes, np.unique(which))
    else:
        marks.set_color("#7a93ac" if drawing.style == "facets" else _INK)
    if drawing.style == "facets":
        marks.set_edgecolor("#ffffff60")
    axes.add_collection(marks)
    notes = [label] if values is None and label else []
    if drawing.lifted:
        notes.append(
            f"an eye's ommatidia are all at one point: drawn {_length(drawing.length)} out"
        )
    # As many letters as fit, at 150 mm; smaller drawings have smaller type.
    lines = [line for text in [*title.splitlines(), *notes] for line in textwrap.wrap(text, 82)]
    figure.suptitle("\n".join(lines), color=_INK, fontsize="medium")
    _scale_bar(axes, low, high)
    _compass(drawing, axes, low, high)
    return figure


def _marks(drawing: _Drawing, axes: Any) -> Any:
    from matplotlib.collections import EllipseCollection, LineCollection

    shown = drawing.shown
    if drawing.style == "axes":
        end = drawing.start + drawing.along * drawing.length
        lines = np.stack([drawing.start[shown], end[shown]], axis=1)
        # Many lines would melt into one another.
        return LineCollection(list(lines), linewidths=min(0.8, 25 / math.sqrt(len(shown) + 1)))
    diameter = drawing.diameter[shown]
    return EllipseCollection(
        np.maximum(np.abs(drawing.towards[shown]), 0.02) * diameter,
        diameter,
        np.degrees(np.arctan2(drawing.along[shown, 1], drawing.along[shown, 0])),
        units="xy",
        offsets=drawing.start[shown],
        offset_transform=axes.transData,
        linewidths=0.2,
    )


def _values(eye: Eye, colour: Colour) -> tuple[Floats | None, str, bool]:
    # What colours mean: a number each, its label, or that they tell eyes apart.
    if colour == "eye":
        return None, "", True
    if colour == "none":
        return None, "", False
    if colour == "acceptance":
        values, label = eye.acceptance_angle_rad, "acceptance angle"
    else:
        values, label = eye.interommatidial_angle_rad(), "local interommatidial angle"
    degrees = np.degrees(values.astype(np.float64))
    if np.ptp(degrees) <= 1e-4 * degrees.max():
        return None, f"{label} {degrees[0]:.3g}° throughout", False
    return degrees, f"{label} (°)", False


def _limits(values: Floats) -> tuple[float, float, str]:
    # A few ommatidia at the rim would take all the colours; where they are far out, the bar ends
    # before them and says so.
    least, low, high, most = np.percentile(values, [0, 1, 99, 100])
    below, above = low - least > 0.25 * (high - low), most - high > 0.25 * (high - low)
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}
    return (
        float(low if below else least),
        float(high if above else most),
        extend[int(below), int(above)],
    )


def _frame(drawing: _Drawing) -> tuple[Floats, Floats]:
    # Lower left and upper right corner: what is drawn, with room below for scale and compass.
    shown = drawing.shown if len(drawing.shown) else np.arange(len(drawing.start))
    reach = drawing.start[shown]
    if drawing.style == "axes":
        reach = np.concatenate([reach, reach + drawing.along[shown] * drawing.length])
    half = 0.5 * float(drawing.diameter.max())
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
    axes.plot([left, left + length], [level] * 2, color=_INK, linewidth=2, solid_capstyle="butt")
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
        unit = along / max(float(np.linalg.norm(along)), 1e-9)
        if np.linalg.norm(along) < 0.2 or any(unit @ other > 0.9 for other in drawn):
            continue
        drawn.append(unit)
        end = centre + along * length
        arrow = {"arrowstyle": "->", "color": _INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", end, centre, arrowprops=arrow)
        sideways = abs(along[0]) > abs(along[1])
        axes.text(
            *(end + 0.12 * length * unit),
            name,
            ha=("left" if along[0] > 0 else "right") if sideways else "center",
            va="center" if sideways else ("bottom" if along[1] > 0 else "top"),
            fontsize="small",
            color=_INK,
        )


def _legend(axes: Any, eyes: NDArray[np.int32]) -> None:
    from matplotlib.patches import Patch

    handles = [
        Patch(color=_EYE_COLOURS[i % len(_EYE_COLOURS)], label=f"eye {i}") for i in eyes.tolist()
    ]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0), ncol=6, frameon=False)


def _title(eye: Eye, yaw_deg: float, pitch_deg: float, drawing: _Drawing) -> str:
    name = f"{Path(eye.path).name}\n" if eye.path and " + " not in eye.path else ""
    shown = (
        f"{len(eye):,} ommatidia"
        if len(drawing.shown) == len(eye)
        else f"{len(drawing.shown):,} of {len(eye):,} ommatidia"
    )
    return f"{name}{shown}, seen from yaw {yaw_deg:g}°, pitch {pitch_deg:g}°"


def _round_length(most: float) -> float:
    # 1, 2 or 5 times a power of ten, at most that.
    power = 10.0 ** math.floor(math.log10(most))
    return next(f * power for f in (5.0, 2.0, 1.0) if f * power <= most * (1 + 1e-9))


def _length(mm: float) -> str:
    return f"{mm:.3g} mm" if mm >= 0.1 else f"{mm * 1e3:.3g} µm"


def _one_of(value: str, known: tuple[str, ...], name: str) -> None:
    if value not in known:
        raise Error(f"{name}: expected {', '.join(known[:-1])} or {known[-1]}, found {value!r}")
