"""Figures of colours: loci in the hexagon, the Maxwell triangle, the tetrahedron and the plane of
flies, and distances beside what is just told apart.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats
from omma.base.figures import (
    GREY,
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
from omma.colour_vision.plot_parts import (
    MOST_MARKS,
    Spectrum,
    draw_locus,
    locus_of,
    mark,
    name_corners,
    named,
    outline,
    ring,
)
from omma.colour_vision.spaces import (
    TETRAHEDRON_CORNERS,
    fly_opponents,
    hexagon,
    maxwell_triangle,
    tetrahedron,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Paths = PathLike | Sequence[PathLike]
# Names of a legend, one below the other, that a figure has room for.
_MOST_ROWS = 18
_HEXAGON = {
    "blue": (0, 1, 0), "blue-green": (0, 1, 1), "green": (0, 0, 1),
    "UV-green": (1, 0, 1), "UV": (1, 0, 0), "UV-blue": (1, 1, 0),
}  # fmt: skip


@checked
def plot_hexagon(
    paths: Paths,
    excited: ArrayLike,
    *,
    labels: Sequence[str] = (),
    spectrum: Spectrum | None = None,
    title: str | None = None,
) -> None:
    """Write a figure of loci in the colour hexagon of bees.

    With its six corners, borders of the six sectors, and rings 0.2 hexagon units apart.

    Args:
        paths: names ending in .pdf, .svg or .png.
        excited: (..., 3), excitations of ultraviolet, blue and green receptors, as `hexagon` takes
            them.
        labels: a name for each locus, in their order; those of one name share a mark.
        spectrum: wavelengths (W,), nm, and excitations (W, 3) by monochromatic lights of them, as
            `excitations` makes them of catches, for the spectrum locus. It depends on how bright
            these are.

    Example:
        >>> excited = [[0.2, 0.6, 0.7], [0.4, 0.5, 0.5]]
        >>> omma.colour_vision.plot_hexagon("hexagon.png", excited, labels=["petal", "leaf"])

    Raises:
        omma.Error: excitations beyond 0 to 1, labels or wavelengths of another number, another
            ending, Matplotlib is missing, a file cannot be written.
    """

    def draw(panel: Axes) -> None:
        corners = {name: hexagon(np.array(one, float)) for name, one in _HEXAGON.items()}
        for radius in (0.2, 0.4, 0.6, 0.8):
            ring(panel, radius)
        for angle in np.radians(np.arange(0, 360, 60)):
            # Borders are half-way between corners, where the edge is cos 30° from the middle.
            end = math.cos(math.pi / 6) * np.array([math.cos(angle), math.sin(angle)])
            panel.plot([0, end[0]], [0, end[1]], color=GREY, linewidth=0.4, linestyle="--")
        outline(panel, corners)

    points = hexagon(excited)
    locus = locus_of(spectrum, hexagon)
    _plot(paths, [(draw, points, locus, "")], labels, title or "Colour hexagon")


@checked
def plot_triangle(
    paths: Paths,
    catches: ArrayLike,
    *,
    labels: Sequence[str] = (),
    classes: Sequence[str] = ("UV", "blue", "green"),
    spectrum: Spectrum | None = None,
    title: str | None = None,
) -> None:
    """Write a figure of loci in the Maxwell triangle.

    Args:
        paths: names ending in .pdf, .svg or .png.
        catches: (..., 3), of short, medium and long wavelengths, as `maxwell_triangle` takes them.
        labels: a name for each locus, in their order; those of one name share a mark.
        classes: names of the three classes, for the corners.
        spectrum: wavelengths (W,), nm, and catches (W, 3) of monochromatic lights of them, in the
            unit of ``catches``, for the spectrum locus.

    Example:
        >>> catches = [[0.5, 1.2, 2.0], [1.0, 1.0, 1.0]]
        >>> omma.colour_vision.plot_triangle("triangle.svg", catches, labels=["petal", "leaf"])

    Raises:
        omma.Error: catches that are negative or all 0, labels, classes or wavelengths of another
            number, another ending, Matplotlib is missing, a file cannot be written.
    """
    names = named(classes, "classes", 3)

    def draw(panel: Axes) -> None:
        outline(panel, dict(zip(names, maxwell_triangle(np.eye(3)), strict=True)))

    points, locus = maxwell_triangle(catches), locus_of(spectrum, maxwell_triangle)
    _plot(paths, [(draw, points, locus, "")], labels, title or "Maxwell triangle")


@checked
def plot_tetrahedron(
    paths: Paths,
    catches: ArrayLike,
    *,
    labels: Sequence[str] = (),
    classes: Sequence[str] = ("UV", "S", "M", "L"),
    spectrum: Spectrum | None = None,
    title: str | None = None,
) -> None:
    """Write a figure of loci in the tetrahedron of four classes: two projections, true to scale.

    From the side, along y, with z up; and from above, along -z, with y up. Edges behind are dashed.

    Args:
        paths: names ending in .pdf, .svg or .png.
        catches: (..., 4), of ultraviolet, short, medium and long wavelengths, as `tetrahedron`
            takes them.
        labels: a name for each locus, in their order; those of one name share a mark.
        classes: names of the four classes, for the corners.
        spectrum: wavelengths (W,), nm, and catches (W, 4) of monochromatic lights of them, in the
            unit of ``catches``, for the spectrum locus.

    Example:
        >>> catches = [[0.2, 0.5, 1.0, 1.2], [1.0, 1.0, 1.0, 1.0]]
        >>> omma.colour_vision.plot_tetrahedron("tetrahedron.pdf", catches)

    Raises:
        omma.Error: catches that are negative or all 0, labels, classes or wavelengths of another
            number, another ending, Matplotlib is missing, a file cannot be written.
    """
    names = named(classes, "classes", 4)
    points = tetrahedron(catches).position
    locus = locus_of(spectrum, lambda seen: tetrahedron(seen).position)
    panels = []
    # Behind: the edges at the class of medium wavelengths from the side, none from above.
    for axes, behind, seen in (([0, 2], {2}, "from the side"), ([0, 1], set(), "from above")):

        def draw(panel: Axes, axes: list[int] = axes, behind: set[int] = behind) -> None:
            corners = TETRAHEDRON_CORNERS[:, axes]
            for pair in itertools.combinations(range(4), 2):
                far = bool(behind & set(pair))
                panel.plot(
                    *corners[list(pair)].T, color=GREY if far else INK, linewidth=0.6,
                    linestyle="--" if far else "-", zorder=1,
                )  # fmt: skip
            name_corners(panel, dict(zip(names, corners, strict=True)))

        flat = None if locus is None else (locus[0], locus[1][:, axes])
        panels.append((draw, points[..., axes], flat, seen))
    _plot(paths, panels, labels, title or "Tetrahedron of four receptor classes")


@checked
def plot_fly_categories(
    paths: Paths, catches: ArrayLike, *, labels: Sequence[str] = (), title: str | None = None
) -> None:
    """Write a figure of loci in the plane of what flies compare, with its four categories.

    Args:
        paths: names ending in .pdf, .svg or .png.
        catches: (..., 4), of R7p, R8p, R7y and R8y, as `fly_opponents` takes them.
        labels: a name for each locus, in their order; those of one name share a mark.

    Example:
        >>> omma.colour_vision.plot_fly_categories("fly.png", [[3, 1, 1, 2], [1, 3, 1, 2]])

    Raises:
        omma.Error: catches that are negative or all 0, labels of another number, another ending,
            Matplotlib is missing, a file cannot be written.
    """

    def draw(panel: Axes) -> None:
        # Shares add up to 1, so that |x| + |y| is at most that.
        ends = np.array([(1, 0), (0, 1), (-1, 0), (0, -1), (1, 0)])
        panel.plot(*ends.T, color=INK, linewidth=0.6, zorder=1)
        for p, y in itertools.product((1, -1), repeat=2):
            name = f"p{'+' if p > 0 else '-'}y{'+' if y > 0 else '-'}"
            panel.text(0.62 * p, 0.62 * y, name, ha="center", va="center")
        panel.plot([-1, 1], [0, 0], color=GREY, linewidth=0.6, zorder=1)
        panel.plot([0, 0], [-1, 1], color=GREY, linewidth=0.6, zorder=1)
        panel.text(0.9, -0.02, "R7p - R8p", va="top", ha="right", fontsize="small")
        panel.text(0.02, 0.6, "R7y - R8y", va="center", ha="left", fontsize="small")

    points = fly_opponents(catches)
    _plot(paths, [(draw, points, None, "")], labels, title or "Colour categories of flies")


@checked
def plot_distances(
    paths: Paths,
    distances: ArrayLike,
    labels: Sequence[str],
    *,
    series: Sequence[str] = (),
    threshold: float = 1.0,
    title: str | None = None,
) -> None:
    """Write a figure of distances in just-noticeable differences, with the line at which colours
    are just told apart.

    Args:
        paths: names ending in .pdf, .svg or .png.
        distances: (N,), as `noise_limited_distance` gives them, or (N, M) of M series, such as
            lights or animals; from 0 on. NaN, of a colour without a value, leaves a gap: its name
            is there, and no mark.
        labels: N names of what is compared, from the top.
        series: M names; may be left out where there is one.
        threshold: where the line is.

    Example:
        >>> omma.colour_vision.plot_distances("distances.png", [8.6, 0.7], ["petal", "sepal"])

    Raises:
        omma.Error: distances that are negative or infinite, or NaN throughout, labels or series of
            another number, another ending, Matplotlib is missing, a file cannot be written.
    """
    names = figure_names(paths)
    shown = array_of(distances, "distances", [("N",), ("N", "M")])
    if shown.size == 0:
        raise Error(f"distances: expected numbers, found shape {shown.shape}")
    known = ~np.isnan(shown)
    if not np.all((shown[known] >= 0) & np.isfinite(shown[known])) or not known.any():
        raise Error("distances: expected finite numbers from 0 on, or NaN where there is none")
    least = positive(threshold, "threshold")
    columns = shown if shown.ndim == 2 else shown[:, None]
    rows = named(labels, "labels", len(columns))
    kinds = named(series or ([""] if columns.shape[1] == 1 else series), "series", columns.shape[1])
    if len(kinds) > MOST_MARKS:
        raise Error(f"series: expected at most {MOST_MARKS}, found {len(kinds)}")
    with figure_style():
        height = 24 + 5.5 * len(rows)
        figure = load_matplotlib()(figsize=(120 * MM, height * MM), layout="constrained")
        panel = figure.add_subplot()
        at = np.arange(len(rows))
        panel.hlines(at, 0, np.nan_to_num(columns).max(axis=1), color=GREY, linewidth=0.4, zorder=1)
        drawn = [
            panel.plot(columns[:, k], at, linestyle="", label=name, **mark(k))[0]
            for k, name in enumerate(kinds)
        ]
        panel.axvline(least, color=INK, linewidth=0.8, linestyle="--")
        panel.annotate(
            f"told apart from {least:g} on", (least, 1), (3, 2),
            xycoords=("data", "axes fraction"), textcoords="offset points", va="bottom",
            fontsize="small",
        )  # fmt: skip
        panel.set_yticks(at, [plain(one) for one in rows])
        panel.set(
            xlabel="distance (just-noticeable differences)",
            xlim=(0, 1.06 * max(float(np.nanmax(shown)), 1.5 * least)),
            ylim=(len(rows) - 0.4, -0.6),
        )
        if any(kinds):
            legend_of(panel, drawn, kinds, loc="center left", bbox_to_anchor=(1.01, 0.5))
        if title:
            panel.set_title(plain(title), pad=12)
        save_figure(figure, names, dpi=200)


# What frames a space, its loci (..., 2), a spectrum locus with its wavelengths, and from where it
# is seen.
_Panel = tuple[Callable[["Axes"], None], Floats, tuple[Floats, Floats] | None, str]


def _plot(paths: Paths, panels: Sequence[_Panel], labels: Sequence[str], title: str) -> None:
    names = figure_names(paths)
    count = panels[0][1].size // 2
    if count == 0:
        raise Error("expected at least one colour, found none")
    words = named(labels, "labels", count) if len(labels) else [""] * count
    kinds = list(dict.fromkeys(words))
    if len(kinds) > MOST_MARKS:
        raise Error(f"labels: expected at most {MOST_MARKS} different ones, found {len(kinds)}")
    with figure_style():
        # As wide as the longest name of the legend needs it, in as many columns as there must be.
        beside_each = max(32.0, 12 + 1.4 * max(map(len, kinds)))
        legend_columns = math.ceil(len(kinds) / _MOST_ROWS)
        beside = legend_columns * beside_each if any(kinds) else 0
        width = 84 * len(panels) + beside
        figure = load_matplotlib()(figsize=(width * MM, 84 * MM), layout="constrained")
        for k, (draw, points, locus, seen) in enumerate(panels):
            panel = figure.add_subplot(1, len(panels), k + 1)
            panel.set_aspect("equal")
            panel.set_axis_off()
            draw(panel)
            # Where receptors adapted to the background see it.
            panel.plot(0, 0, "+", color=INK, markersize=6, markeredgewidth=0.8, zorder=2)
            if locus is not None:
                draw_locus(panel, *locus)
            flat = points.reshape(-1, 2)
            drawn = []
            for n, kind in enumerate(kinds):
                which = [word == kind for word in words]
                drawn += panel.plot(*flat[which].T, linestyle="", label=kind, **mark(n))
            panel.set_title(seen)
            panel.margins(0.12)
        if any(kinds):
            # The figure's own, for which the layout leaves space beside panels that keep shapes.
            legend_of(figure, drawn, kinds, loc="outside right center", ncol=legend_columns)
        figure.suptitle(plain(title), fontsize="medium", weight="bold")
        save_figure(figure, names, dpi=200)
