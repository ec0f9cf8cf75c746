"""Figures of responses: any projection, with degrees, one scale for all, and standard errors."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, positive
from omma.base.figures import MM, figure_names, figure_style, load_matplotlib, save_figure
from omma.base.files import PathLike
from omma.eye.neighbours import Floats
from omma.picture.eye_maps import eye_title
from omma.picture.kept_ids import Ids
from omma.picture.projections import projection_ids, projection_size
from omma.picture.response_axes import draw_axes, inside_picture
from omma.picture.response_colours import (
    SHOWN_AS,
    Channel,
    Shown,
    as_colours,
    bands_shown,
    receptors_shown,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PIXELS = 1080  # across a picture of the whole sphere
_MOST_PICTURES = 24
_EMPTY = (0.9, 0.9, 0.9)  # where no ommatidium looks
_ERROR_COLOURS = "magma"
_WIDTH_MM = 180.0
_LETTERS = 90  # of a title across the figure
_UNITS = 12  # columns of the grid, which 1, 2, 3 and 4 pictures in a row divide


@dataclass(frozen=True)
class _Picture:
    """One picture: pixel values (H, W, K), NaN where no ommatidium is."""

    values: Floats
    title: str
    is_error: bool


@checked
def plot_responses(
    paths: PathLike | Sequence[PathLike],
    eye: Eye | Sequence[Eye],
    responses: Any,
    *,
    errors: Any = None,
    receptors: bool = False,
    channels: Sequence[Channel] | None = None,
    projection: str | None = None,
    full_scale: float | None = None,
    gamma: float = 2.2,
    titles: Sequence[str] | None = None,
    title: str | None = None,
) -> None:
    """Write a figure of responses to `.pdf`, `.svg` and `.png`: a picture for each pose of each
    eye, all with the same scale of colours.

    One channel is shown by a colour bar; two or three as colours, explained in the legend, with
    display value = (response / full_scale) ** (1 / gamma). What no ommatidium sees is light grey.

    Args:
        eye: an eye, or several, of different animals say.
        responses: of one eye (N, C) or (P, N, C), as `Renderer.render` gives them; of several eyes
            a sequence of such arrays.
        errors: their standard errors, of the same shape: drawn beside, as the root of the mean
            square over the channels shown.
        receptors: ``responses`` are receptors', (R,) or (P, R), as `Renderer.render_receptors`
            gives them. Without ``channels`` the kinds of receptors are shown by peak wavelength,
            the longest as red, the next as green, the shortest as blue; of two the longer as
            yellow. Where an ommatidium has none of a kind, the nearest that has one is shown.
        channels: one to three bands by number, or receptors by name, in the order red, green, blue
            (yellow, blue). Default: red, green and blue of RGB.
        projection: as in `projection_ids`, without ``_ids`` and not ``raw_ommatidial_samples``.
        full_scale: the response at the end of the scale. Default: 1 for RGB, else the largest; but
            where that is more than ten times what 99 of 100 have, as where the sun is seen, what
            these have.
        titles: of the pictures, in order: all poses of the first eye, then those of the next.
        title: above all of them.

    Raises:
        omma.Error: shapes that do not fit the eyes, over 24 pictures, another ending, Matplotlib is
            missing, a file cannot be written.
    """
    names = figure_names(paths)
    eyes = [eye] if isinstance(eye, Eye) else list(eye)
    if not eyes:
        raise Error("eye: expected at least one, found none")
    if projection is not None:
        if projection.endswith("_ids") or projection == "raw_ommatidial_samples":
            raise Error(f"projection: expected one that shows responses, found {projection!r}")
        projection_size(eyes[0], projection)
    if channels is not None and not 1 <= len(channels) <= 3:
        raise Error(f"channels: expected one to three, found {len(channels)}")
    positive(gamma, "gamma")
    single = isinstance(eye, Eye)
    shown = _all_shown(eyes, [responses] if single else responses, receptors, channels, "responses")
    beside = None
    if errors is not None:
        beside = _all_shown(eyes, [errors] if single else errors, receptors, channels, "errors")
        for one, other in zip(shown, beside, strict=True):
            if one.values.shape != other.values.shape:
                raise Error("errors: expected the shape of responses")
    if full_scale is None:
        rgb = not receptors and channels is None and len(shown[0].names) == 3
        full_scale = 1.0 if rgb else _end_of_scale(shown)
    positive(full_scale, "full_scale")
    what = "response" if 1.001 * full_scale >= _largest(shown) else "response, brighter cut off"
    count = sum(len(each.values) for each in shown)
    if count > _MOST_PICTURES:
        raise Error(f"responses: expected at most {_MOST_PICTURES} pictures, found {count}")
    if titles is not None and len(titles) != count:
        raise Error(f"titles: expected {count}, one for each picture, found {len(titles)}")
    rows = _rows(_entries(eyes, shown, beside, projection, titles))
    with figure_style():
        figure = _figure(rows, projection, eyes, shown[0].names, full_scale, gamma, beside, what)
        if title is not None:
            figure.suptitle(title, fontsize="large", weight="bold")
        save_figure(figure, names, dpi=200)


def _all_shown(
    eyes: Sequence[Eye],
    arrays: Sequence[ArrayLike],
    receptors: bool,
    channels: Sequence[Channel] | None,
    name: str,
) -> list[Shown]:
    if len(arrays) != len(eyes):
        raise Error(f"{name}: expected {len(eyes)} arrays, one for each eye, found {len(arrays)}")
    for array in arrays:
        if not np.isfinite(array_of(array, name)).all():
            raise Error(f"{name}: expected finite numbers")
    of = receptors_shown if receptors else bands_shown
    shown = [of(eye, array, channels, name) for eye, array in zip(eyes, arrays, strict=True)]
    kinds = {len(each.names) for each in shown}
    if len(kinds) > 1:
        raise Error(f"channels: expected as many of each eye, found {sorted(kinds)}")
    return shown


def _largest(shown: Sequence[Shown]) -> float:
    most = max(float(np.nanmax(each.values, initial=0.0)) for each in shown)
    return most if most > 0 else 1.0


def _end_of_scale(shown: Sequence[Shown]) -> float:
    """The largest; where a few outshine all others, what all but a hundredth have."""
    most = _largest(shown)
    known = np.concatenate([each.values[np.isfinite(each.values)].ravel() for each in shown])
    often = float(np.quantile(known, 0.99)) if known.size else 0.0
    return often if 0 < 10 * often < most else most


def _entries(
    eyes: Sequence[Eye],
    shown: Sequence[Shown],
    beside: Sequence[Shown] | None,
    projection: str | None,
    titles: Sequence[str] | None,
) -> list[list[list[_Picture]]]:
    """For each pose of each eye its pictures and, where there are errors, theirs: lists of one for
    each eye of the head that is drawn apart."""
    entries: list[list[list[_Picture]]] = []
    for k, eye in enumerate(eyes):
        maps = _id_maps(eye, projection)
        sides = ["left eye", "right eye"] if len(maps) == 2 else [f"eye {e}" for e in range(9)]
        for pose in range(len(shown[k].values)):
            name = eye_title(eye) if titles is None else titles[len(entries)]
            if titles is None and len(shown[k].values) > 1:
                name += f", pose {pose}"
            if titles is None and len(maps) > 1:
                name += " in all"
            entry = []
            for what, is_error in ((shown, False), (beside, True)):
                if what is None:
                    continue
                values = what[k].values[pose]
                entry.append(
                    [
                        _Picture(
                            _painted(ids, values),
                            "standard error"
                            if is_error
                            else f"{name}: {side}"
                            if len(maps) > 1
                            else name,
                            is_error,
                        )
                        for ids, side in zip(maps, sides, strict=False)
                    ]
                )
            entries.append(entry)
    return entries


def _id_maps(eye: Eye, projection: str | None) -> list[Ids]:
    if projection == "single_dimension_fast":
        return [projection_ids(eye, projection)]
    width, height = projection_size(eye, projection, _PIXELS)
    ids = projection_ids(eye, projection, width, height)
    return list(np.split(ids, ids.shape[1] // width, axis=1))


def _painted(ids: Ids, values: Floats) -> Floats:
    return np.concatenate([values, np.full((1, values.shape[1]), np.nan)])[ids]


def _rows(entries: list[list[list[_Picture]]]) -> list[list[_Picture]]:
    """The pictures of each row of the figure."""
    apart = any(len(pictures) > 1 for entry in entries for pictures in entry)
    if apart:
        return [pictures for entry in entries for pictures in entry]
    if len(entries[0]) > 1:
        return [[pictures[0] for pictures in entry] for entry in entries]
    columns = 1 if len(entries) <= 2 else 2 if len(entries) <= 8 else 3
    flat = [entry[0][0] for entry in entries]
    return [flat[k : k + columns] for k in range(0, len(flat), columns)]


def _figure(
    rows: Sequence[Sequence[_Picture]],
    projection: str | None,
    eyes: Sequence[Eye],
    names: Sequence[str],
    full_scale: float,
    gamma: float,
    beside: Sequence[Shown] | None,
    what: str,
) -> Figure:
    aspect = {"lambert": 1.0, "spherical_split_orientationwise": 4.0}.get(projection or "", 2.0)
    columns = max(len(row) for row in rows)
    heights = [_WIDTH_MM / (columns if len(row) > 1 else 1) / aspect + 14 for row in rows]
    heights.append(3.5 * len(names) + 10)
    figure: Any = load_matplotlib()(
        figsize=(_WIDTH_MM * MM, (sum(heights) + 6) * MM), layout="constrained"
    )
    grid = figure.add_gridspec(len(heights), _UNITS, height_ratios=heights)
    largest_error = _largest(beside) if beside is not None else 1.0
    errors = None
    for k, row in enumerate(rows):
        each = _UNITS // (columns if len(row) > 1 else 1)
        for column, picture in enumerate(row):
            panel = figure.add_subplot(grid[k, column * each : (column + 1) * each])
            marks = _draw(
                panel, picture, projection, eyes[0], full_scale, gamma, largest_error,
                _UNITS // each, k == len(rows) - 1, column == 0,
            )  # fmt: skip
            if picture.is_error:
                errors = marks
            elif len(names) == 1:
                values = marks
    # The scales side by side below.
    legend = figure.add_subplot(grid[-1, 3:6] if errors is not None else grid[-1, 4:8])
    if len(names) == 1:
        bar = figure.colorbar(values, cax=legend, orientation="horizontal")
        _name_scale(legend, f"{what}: {names[0]}", full_scale)
        bar.outline.set_visible(False)
    else:
        _strips(legend, names, full_scale, gamma, what)
    if errors is not None:
        panel = figure.add_subplot(grid[-1, 8:11])
        bar = figure.colorbar(errors, cax=panel, orientation="horizontal")
        _name_scale(panel, "standard error", largest_error)
        bar.outline.set_visible(False)
    return figure  # type: ignore[no-any-return]


def _draw(
    panel: Axes,
    picture: _Picture,
    projection: str | None,
    eye: Eye,
    full_scale: float,
    gamma: float,
    largest_error: float,
    columns: int,
    lowest: bool,
    first: bool,
) -> Any:
    values = picture.values
    inside = inside_picture(projection, values.shape[0], values.shape[1])
    known = np.isfinite(values[..., 0])
    ground = np.ones((*known.shape, 4))
    ground[..., :3] = _EMPTY
    ground[..., 3] = inside
    extent = draw_axes(panel, projection, len(eye), lowest, first)
    panel.imshow(ground, extent=extent, interpolation="nearest", zorder=0)
    one = values[..., 0]
    limits: dict[str, Any] = {"cmap": "viridis", "vmin": 0.0, "vmax": full_scale}
    if picture.is_error:
        one = np.sqrt((values**2).mean(axis=-1))
        limits = {"cmap": _ERROR_COLOURS, "vmin": 0.0, "vmax": largest_error}
    elif values.shape[-1] > 1:
        coloured = np.zeros((*known.shape, 4))
        coloured[..., :3][known] = as_colours(values[known], full_scale, gamma)
        coloured[..., 3] = known
        one, limits = coloured, {}
    if values.shape[-1] == 1 or picture.is_error:
        one = np.ma.masked_invalid(one)
    marks = panel.imshow(one, extent=extent, interpolation="nearest", zorder=0.5, **limits)
    panel.set_title(textwrap.fill(picture.title, _LETTERS // columns), loc="left")
    return marks


def _strips(panel: Axes, names: Sequence[str], full_scale: float, gamma: float, what: str) -> None:
    """The scale of each channel as a strip of what it is shown as, its name beside it."""
    steps = np.linspace(0, full_scale, 256)
    count = len(names)
    each = np.eye(count)[:, None] * steps[:, None]
    panel.imshow(
        as_colours(each, full_scale, gamma),
        extent=(0, full_scale, count, 0), aspect="auto", interpolation="nearest",
    )  # fmt: skip
    labels = [
        name if name == colour else f"{name}, shown {colour}"
        for name, colour in zip(names, SHOWN_AS[count], strict=True)
    ]
    panel.set_yticks(np.arange(count) + 0.5, labels, fontsize="small")
    for label in panel.get_yticklabels():
        label.set_in_layout(False)  # there is room beside it, which no other picture should give
    panel.tick_params(axis="y", length=0)
    _name_scale(panel, f"{what} (display gamma {gamma:g})", full_scale)
    for side in ("left", "bottom"):
        panel.spines[side].set_visible(False)


def _name_scale(panel: Axes, label: str, largest: float) -> None:
    """The label of a scale, with the power of ten of very large and very small numbers in it, as
    of photons, where Matplotlib would write it across the label."""
    if 1e-3 <= largest < 1e4:
        panel.set_xlabel(label)
        return
    power = math.floor(math.log10(largest))
    panel.xaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
    panel.set_xlabel(f"{label}, $10^{{{power}}}$")
