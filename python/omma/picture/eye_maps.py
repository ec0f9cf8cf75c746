"""Maps of an eye's properties over the directions it sees: Mercator, Mollweide, Lambert.

Each ommatidium is the cell of directions nearest to its axis, as far as the visual field goes (see
eye/field.py). Where two eyes look, the one is shown whose middle is nearer: their cells between one
another would be a pattern that neither has. Ahead is in the middle, right to the right, up at the
top, as in all pictures.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from omma._core import Error, Eye
from omma.base.arguments import checked
from omma.base.arrays import Flags, Floats, Ints
from omma.base.directions import direction
from omma.base.figures import (
    COLOURS,
    INK,
    MM,
    figure_names,
    figure_style,
    legend_of,
    load_matplotlib,
    plain,
    save_figure,
)
from omma.base.files import PathLike
from omma.base.progress import Stage
from omma.eye.field import in_field
from omma.eye.measures import EyeMeasures, measure_eye
from omma.eye.properties import EyeProperty, expect_property, eye_property, is_known
from omma.picture.fields import largest_gap_sr, without_gaps
from omma.picture.map_projections import (
    MAP_HALVES,
    MERCATOR_EDGE,
    PROJECTIONS,
    Projection,
    map_directions,
    project_directions,
)
from omma.picture.unseen import NOT_KNOWN, hatched_ground
from omma.species.animals import name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PIXELS = 1100  # across a map
# Directions that are looked up between two reports of progress.
_PIECE = 50_000
#: What a map of an eye's property does not show in colours.
MAP_NOTE = "hatched: no ommatidium looks there; grey: not known, at a rim for want of neighbours"


@dataclass(frozen=True)
class EyeMap:
    """Which ommatidium is where on a map.

    ommatidium: (H, W), row 0 at the top; -1 where the map shows a direction that no eye sees, -2
        outside the map. Of several eyes that see a direction, the one whose mean axis is nearest.
    seen: (E, H, W), which of the eyes see each direction.
    extent: left, right, bottom, top, in the map's units.
    """

    projection: Projection
    ommatidium: Ints
    seen: Flags
    extent: tuple[float, float, float, float]


def make_map(
    measures: EyeMeasures,
    projection: Projection,
    width: int | None = None,
    progress: Stage | None = None,
) -> EyeMap:
    """The map of an eye, ``width`` pixels wide; 1100 where it is left out.

    Raises:
        omma.Error: there is no such projection.
    """
    from scipy.spatial import cKDTree

    if projection not in PROJECTIONS:
        raise Error(f"projection: expected {', '.join(PROJECTIONS)}, found {projection!r}")
    right, top = MAP_HALVES[projection]
    width = width or _PIXELS
    height = round(width * top / right)
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * right
    y = (1 - (np.arange(height) + 0.5) / height * 2) * top
    directions = map_directions(projection, *np.meshgrid(x, y))
    inside = np.isfinite(directions[..., 0])
    shown = directions[inside]
    eyes = np.unique(measures.eye_id)
    seen = np.zeros((len(eyes), *inside.shape), bool)
    pieces = np.array_split(np.arange(len(shown)), max(1, round(len(shown) / _PIECE)))
    for k, which in enumerate(eyes):
        seen_here = np.zeros(len(shown), bool)
        for done, piece in enumerate(pieces):
            if progress is not None:
                progress("map", (k + done / len(pieces)) / len(eyes))
            seen_here[piece] = in_field(
                shown[piece],
                measures.axis,
                measures.eye_id,
                int(which),
                measures.lattice,
                measures.cell_rad,
            )
        seen[k][inside] = seen_here
    each = _solid_angles(projection, inside, y)
    for k, which in enumerate(eyes):
        least = largest_gap_sr(measures.cell_rad[measures.eye_id == which])
        seen[k] = without_gaps(seen[k] | ~inside, each, least) & inside
    ommatidium = np.where(inside, np.int64(-1), np.int64(-2))
    nearest = np.full(inside.shape, -np.inf)
    for k, which in enumerate(eyes):
        members = np.flatnonzero(measures.eye_id == which)
        middle = measures.axis[members].mean(axis=0)
        towards = np.where(seen[k], directions @ (middle / max(np.linalg.norm(middle), 1e-9)), -9)
        chosen = seen[k] & (towards > nearest)
        nearest[chosen] = towards[chosen]
        ommatidium[chosen] = members[cKDTree(measures.axis[members]).query(directions[chosen])[1]]
    return EyeMap(projection, ommatidium, seen, (-right, right, -top, top))


def _solid_angles(projection: Projection, inside: Flags, y: Floats) -> Floats:
    """Of each pixel of a map, sr: (H, W) or (H, 1). y: (H,), of the rows."""
    if projection != "mercator":  # the others keep areas
        return np.full((len(y), 1), 4 * math.pi / int(inside.sum()))
    side = 2 * math.pi / inside.shape[1]
    return np.asarray((side / np.cosh(y)) ** 2)[:, None]


@checked
def plot_eye_maps(
    paths: PathLike | Sequence[PathLike],
    eye: Eye,
    properties: Sequence[str] | None = None,
    *,
    projection: Projection = "mollweide",
    title: str | None = None,
    measures: EyeMeasures | None = None,
    progress: Stage | None = None,
) -> None:
    """Write maps of an eye's properties to `.pdf`, `.svg` and `.png`: a panel each.

    Args:
        properties: of `omma.eye.PROPERTIES`, or names of the eye's columns. Default: Δφ, the
            smaller and the larger angle between the axes of facets that touch, Δρ, and of Δρ/Δφ,
            facet diameter, eye parameter and sensitivity those that are known.
        projection: "mercator" (to 80° up and down), "mollweide" or "lambert" (both equal-area).
        measures: of `measure_eye`, where they have been taken.
        progress: called as progress(stage, finished fraction or None) now and then.

    Raises:
        omma.Error: a property or projection that there is not, or that no ommatidium has; another
            ending; Matplotlib is missing; a file cannot be written.
    """
    names = figure_names(paths)
    for name in properties or ():
        expect_property(eye, name)
    measures = measures or measure_eye(eye)
    if properties is None:
        always = ("interommatidial", "smaller", "larger", "acceptance")
        shown = [eye_property(eye, measures, name) for name in always]
        more = ("ratio", "facet", "eye-parameter", "sensitivity")
        shown += [p for p in (eye_property(eye, measures, name) for name in more) if is_known(p)]
    else:
        shown = [eye_property(eye, measures, name) for name in properties]
        for name, prop in zip(properties, shown, strict=True):
            if not is_known(prop):
                raise Error(f"property: {name} is not known of any ommatidium of this eye")
    the_map = make_map(measures, projection, progress=progress)
    with figure_style():
        columns = 1 if len(shown) == 1 else (3 if projection == "lambert" else 2)
        columns = min(columns, len(shown))
        rows = math.ceil(len(shown) / columns)
        each = 130.0 if columns == 1 else 180.0 / columns
        tall = {"mercator": 0.84, "mollweide": 0.58, "lambert": 1.08}[projection]
        figure = load_matplotlib()(
            figsize=(each * columns * MM, (each * tall * rows + 13) * MM), layout="constrained"
        )
        for k, prop in enumerate(shown):
            if progress is not None:
                progress("drawing", k / len(shown))
            panel = figure.add_subplot(rows, columns, k + 1)
            draw_map(figure, panel, the_map, prop, labels=True)
        figure.suptitle(plain(title or eye_title(eye)), fontsize="medium", weight="bold")
        figure.supxlabel(MAP_NOTE, fontsize="x-small")
        if progress is not None:
            progress("writing the figure", None)
        save_figure(figure, names, dpi=300)


def draw_map(
    figure: Figure,
    panel: Axes,
    the_map: EyeMap,
    prop: EyeProperty,
    *,
    labels: bool = True,
) -> None:
    """One map in a panel, with its graticule, the outline of each eye's field, a colour bar; grey
    throughout where no ommatidium has a value."""
    left, right, bottom, top = the_map.extent
    panel.set_axis_off()
    panel.set_aspect("equal")
    panel.set(xlim=(left * 1.02, right * 1.02), ylim=(bottom * 1.02, top * 1.02))
    ground = hatched_ground(the_map.ommatidium == -1, the_map.ommatidium != -2)
    ground[the_map.ommatidium >= 0, :3] = NOT_KNOWN
    panel.imshow(ground, extent=the_map.extent, interpolation="nearest")
    padded = np.concatenate([prop.values, [np.nan, np.nan]])
    image = panel.imshow(
        np.ma.masked_invalid(padded[the_map.ommatidium]),
        extent=the_map.extent,
        interpolation="nearest",
    )
    draw_graticule(panel, the_map.projection, labels)
    _outlines(panel, the_map)
    if not is_known(prop):
        text = f"{prop.label}: not known"
        panel.text(0.5, -0.06, text, transform=panel.transAxes, ha="center", va="top")
        return
    colour_scale(figure, panel, image, prop, location="bottom")


def colour_scale(
    figure: Figure | None, panel: Axes, marks: Any, prop: EyeProperty, location: str | None
) -> None:
    """The colours of ``marks`` and a bar, or of classes a legend, that says what they mean.

    ``location`` of the bar is "right" or "bottom"; None leaves it out, and needs no figure.
    """
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.patches import Patch

    if prop.classes:
        colours = [COLOURS[k % len(COLOURS)] for k in range(len(prop.classes))]
        marks.set(cmap=ListedColormap(colours), clim=(-0.5, len(colours) - 0.5))
        if location is not None:
            patches = [Patch(color=one) for one in colours]
            place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0)}
            legend_of(panel, patches, prop.classes, **place, ncol=6)
        return
    low, high, extend = colour_limits(prop.values)
    constant = high - low <= 1e-4 * max(abs(low), abs(high))
    if not constant and is_crowded(prop.values, low, high):
        marks.set(cmap="viridis", norm=LogNorm(low, high))
    else:
        marks.set(cmap="viridis", clim=(low, high))
    if constant:
        marks.set_clim(low - 1, low + 1)
    if location is None or figure is None:
        return
    if constant:
        text = f"{prop.label}: {low:.3g} throughout"
        panel.text(0.5, -0.06, text, transform=panel.transAxes, ha="center", va="top")
        return
    bar = figure.colorbar(
        marks, ax=panel, location=location, shrink=0.75 if location == "right" else 0.6,
        aspect=30, pad=0.02, extend=extend,
    )  # fmt: skip
    bar.set_label(prop.label)
    if isinstance(marks.norm, LogNorm):
        bar.set_label(f"{prop.label}, log scale")
        ticks = np.unique([float(f"{tick:.2g}") for tick in np.geomspace(low, high, 6)])
        bar.set_ticks(ticks.tolist(), labels=[f"{tick:g}" for tick in ticks])
        bar.minorticks_off()
    bar.outline.set_visible(False)


def colour_limits(values: Floats) -> tuple[float, float, str]:
    """What colours span, and where a bar has a pointed end: a few ommatidia at the rim would take
    all the colours; where they are far out, the bar ends before them and says so."""
    known = values[np.isfinite(values)]
    least, low, high, most = np.percentile(known, [0, 1, 99, 100])
    below, above = low - least > 0.25 * (high - low), most - high > 0.25 * (high - low)
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}
    return (
        float(low if below else least),
        float(high if above else most),
        extend[int(below), int(above)],
    )


def is_crowded(values: Floats, low: float, high: float) -> bool:
    """Whether half of the values would have the same colours, the first tenth of the scale: they
    are then told apart by their ratio."""
    known = values[np.isfinite(values)]
    return bool(low > 0 and high >= 2 * low and np.median(known) < low + 0.1 * (high - low))


def draw_graticule(panel: Axes, projection: Projection, labels: bool) -> None:
    """Circles of azimuth and elevation each 30°, with their degrees, and the map's edge."""
    edge = math.degrees(MERCATOR_EDGE) if projection == "mercator" else 90.0
    fine: dict[str, Any] = {"color": INK, "linewidth": 0.35, "alpha": 0.45}
    upwards = np.linspace(-edge, edge, 181)
    around = np.linspace(-180 + 1e-6, 180 - 1e-6, 361)
    for azimuth in range(-150, 180, 30):
        _line(panel, projection, np.full(181, float(azimuth)), upwards, fine)
    for elevation in range(-60, 90, 30):
        _line(panel, projection, around, np.full(361, float(elevation)), fine)
    rim: dict[str, Any] = {"color": INK, "linewidth": 0.7}
    if projection == "lambert":
        turn = np.linspace(0, 2 * np.pi, 361)
        panel.plot(2 * np.cos(turn), 2 * np.sin(turn), **rim)
        _line(panel, projection, np.full(181, 180.0), upwards, fine)
    else:
        for end in (around[0], around[-1]):
            _line(panel, projection, np.full(181, end), upwards, rim)
        for end in (-edge, edge):
            _line(panel, projection, around, np.full(361, end), rim)
    if labels:
        _degrees(panel, projection)


def _degrees(panel: Axes, projection: Projection) -> None:
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=1.6, foreground="white")]
    font: dict[str, Any] = {"fontsize": "x-small", "color": INK, "path_effects": halo, "zorder": 5}
    low = {"mercator": -80.0}.get(projection, 0.0)
    step = 90 if projection == "lambert" else 60
    for azimuth in range(-180 + step, 180, step):
        x, y = project_directions(direction(azimuth, low), projection)
        name = {-90: "left −90°", 0: "ahead 0°", 90: "right 90°"}.get(
            azimuth, f"{azimuth}°".replace("-", "−")
        )
        panel.annotate(
            name,
            (x, y),
            (0, -2),
            textcoords="offset points",
            ha="center",
            va="top",
            **font,
        )
    for elevation in (-60, -30, 30, 60):
        at = 0.0 if projection == "lambert" else -180 + 1e-6
        x, y = project_directions(direction(at, elevation), projection)
        panel.annotate(
            f"{elevation}°".replace("-", "−"),
            (x, y),
            (0, 0) if projection == "lambert" else (-2, 0),
            textcoords="offset points",
            ha="center" if projection == "lambert" else "right",
            va="center",
            **font,
        )


def _line(
    panel: Axes, projection: Projection, azimuth: Floats, elevation: Floats, style: dict[str, Any]
) -> None:
    panel.plot(*project_directions(direction(azimuth, elevation), projection).T, **style)


def _outlines(panel: Axes, the_map: EyeMap) -> None:
    height, width = the_map.ommatidium.shape
    left, right, bottom, top = the_map.extent
    x = left + (np.arange(width) + 0.5) / width * (right - left)
    y = top - (np.arange(height) + 0.5) / height * (top - bottom)
    for seen in the_map.seen:
        if seen.any():
            # Masked outside the map, so that its rim is no edge of a field.
            field = np.ma.masked_where(the_map.ommatidium == -2, seen.astype(float))
            panel.contour(x, y, field, [0.5], colors=INK, linewidths=0.8)


def eye_title(eye: Eye) -> str:
    """What the eye is called, where that is known, and how many ommatidia there are."""
    return f"{known_title(eye)}{count_of(len(eye))}"


def count_of(ommatidia: int) -> str:
    """How many ommatidia there are, in words of figures."""
    return f"{ommatidia:,} ommatidi{'um' if ommatidia == 1 else 'a'}"


def known_title(eye: Eye) -> str:
    """What the eye is called and a colon, where that is known."""
    name = known_name(eye)
    return f"{name}: " if name else ""


def known_name(eye: Eye) -> str:
    """The file's name where the eye is of one, else its animal's; "" where neither is known."""
    if eye.path:
        return Path(eye.path).name if " + " not in eye.path else ""
    animal = name_of(eye)
    return animal.replace("_", " ").capitalize() if animal else ""
