"""Figures of responses: any projection, with degrees, one scale for all, and standard errors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import checked, expect, positive
from omma.base.arrays import Floats
from omma.base.figures import (
    MM,
    figure_names,
    figure_style,
    load_matplotlib,
    plain,
    save_figure,
    wrapped,
)
from omma.base.files import PathLike
from omma.light import Light
from omma.picture.projections import projection_size
from omma.picture.response_axes import LISTED, draw_axes
from omma.picture.response_colours import (
    Channel,
    Shown,
    as_colours,
    bands_shown,
    is_grey,
    receptors_shown,
)
from omma.picture.response_legend import (
    Scale,
    centers_nm,
    draw_strips,
    legend_mm,
    name_scale,
    names_of_all,
    unit_of,
)
from omma.picture.response_pictures import Picture, pictures_of
from omma.picture.response_scale import (
    check_colours,
    cut_off,
    end_of_scale,
    is_signed,
    missing_words,
    within_period,
)
from omma.picture.unseen import (
    CYCLIC_COLOURS,
    NOT_KNOWN,
    aspect_of,
    hatched_ground,
    inside_outline,
    unseen,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PICTURES = 24
_COLOURS, _ERROR_COLOURS = "viridis", "magma"
_SIGNED_COLOURS = "RdBu_r"  # white at 0, told apart by colour-blind eyes
_WIDTH_MM = 180.0
_OUTSHINE = 2.0  # of errors: some are many times what most are, at edges and in glitter
_LETTERS = 90  # of a title across the figure
_LETTERS_OF_SCALE = {False: 110, True: 48}  # below one scale, below each of two
_UNITS = 12  # columns of the grid, which 1, 2, 3 and 4 pictures in a row divide


@checked
def plot_responses(
    paths: PathLike | Sequence[PathLike],
    eye: Eye | Sequence[Eye],
    responses: Any,
    *,
    errors: Any = None,
    receptors: bool = False,
    channels: Sequence[Channel] | None = None,
    light: Light | None = None,
    projection: str | None = None,
    full_scale: float | None = None,
    cyclic: float | None = None,
    gamma: float = 2.2,
    quantity: str | None = None,
    titles: Sequence[str] | None = None,
    title: str | None = None,
) -> None:
    """Write a figure of responses to `.pdf`, `.svg` and `.png`: a picture for each pose of each
    eye, all with the same scale of colours.

    One channel is shown by a colour bar: from 0 on, or where numbers lie below 0, from blue over
    white at 0 to red, as far below as above. Infinite numbers and NaN are grey, which is said below
    the figure. Two or three channels are shown as colours, explained in the legend, with display
    value = (response / full_scale) ** (1 / gamma). Colours cannot show numbers below 0: down to a
    tenth of the scale (of red, green and blue their luminance) they are cut off and the legend says
    so, beyond it is an error. Red, green and blue that are the same throughout are one channel,
    grey. Where channels have other names in one eye than in another, as receptors of another peak,
    the legend says which are whose. Directions that no ommatidium sees are hatched.

    Args:
        eye: an eye, or several, of different animals say.
        responses: of one eye (N, C) or (P, N, C), as `Renderer.render` gives them, or of one
            channel (N,) or (P, N), as distances are; of several eyes a sequence of such arrays.
        errors: their standard errors, of the same shape: drawn beside, as the root of the mean
            square over the channels shown. Their scale goes to the largest, or where that is more
            than twice what 99 of 100 have, as far as these.
        receptors: ``responses`` are receptors', (R,) or (P, R), as `Renderer.render_receptors`
            gives them. Without ``channels`` the kinds of receptors are shown by peak wavelength,
            the longest as red, the next as green, the shortest as blue; of two the longer as
            yellow. Receptors of one peak with microvilli in several directions (from the up vector
            of each ommatidium, not from the vertical) are a kind for each, if there are then no
            more than three; else the legend says that they are a mean. Where an ommatidium has none
            of a kind, the nearest that has one is shown.
        channels: one to three bands by number, or receptors by name, in the order red, green, blue
            (yellow, blue). Default: red, green and blue of RGB, which three bands are where
            neither ``light`` nor a labelled array says otherwise; ``quantity`` names others.
        light: what lit the world that was seen: names the bands and the unit in the legend. Arrays
            that `omma.rendering.load_responses` and `Renderer.dataset` give know their unit, and
            those of ground truth what they are.
        projection: as in `projection_ids`, without ``_ids`` and not ``raw_ommatidial_samples``.
        full_scale: the response at the end of the scale. Default: 1 for RGB, else the largest, by
            its size where numbers lie below 0; but where that is more than ten times what 99 of 100
            have, as where the sun is seen, what these have.
        cyclic: the period of numbers that come back to where they began: 180 of the angle of
            polarisation in degrees, 360 of azimuths. They are drawn from minus half of it to half
            of it, in colours that are the same at both ends.
        quantity: what the numbers are, with its unit, where they are not responses: instead of what
            the legend would say of them.
        titles: of the pictures, in order: all poses of the first eye, then those of the next.
        title: above all of them.

    Raises:
        omma.Error: shapes that do not fit the eyes, two or three channels with numbers that are not
            finite or far below 0, errors below 0, a period of several channels, of receptors or
            with a full_scale, over 24 pictures, another ending, Matplotlib is missing, a file
            cannot be written.
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
    if light is not None:
        expect(light, Light, "light", "omma.light.clear_sky makes one")
    arrays = [responses] if single else responses
    shown = _all_shown(eyes, arrays, receptors, channels, light, "responses")
    beside = None
    if errors is not None:
        beside = _all_shown(
            eyes, [errors] if single else errors, receptors, channels, light, "errors"
        )
        for one, other in zip(shown, beside, strict=True):
            if one.values.shape != other.values.shape:
                raise Error("errors: expected the shape of responses")
        if any(np.any(each.values < 0) for each in beside):
            raise Error("errors: expected numbers from 0 on, found some below")
    coloured, grey = len(shown[0].names) > 1, is_grey(shown)
    if grey:
        shown = [Shown(each.values[..., :1], ("red = green = blue",)) for each in shown]
        # A bar shows what greys cannot.
        coloured = not is_signed(shown) and not missing_words(shown)
    if cyclic is not None:
        full_scale = _half_period(cyclic, full_scale, coloured, receptors)
        shown = [within_period(each, cyclic) for each in shown]
    if full_scale is None:
        rgb = not receptors and channels is None and coloured and (grey or len(shown[0].names) == 3)
        full_scale = 1.0 if rgb else end_of_scale(shown)
    positive(full_scale, "full_scale")
    if coloured:
        check_colours(shown, full_scale, "responses")
    known_as = shown[0].quantity if quantity is None else quantity
    channel_names = names_of_all(eyes, shown)
    what = known_as or "response"
    if not coloured and quantity is None and channel_names[0]:
        what += f": {channel_names[0]}"
    what += cut_off(shown, full_scale, coloured, "more" if known_as else "brighter")
    unit = unit_of(light, arrays) if quantity is None else ""
    scale = Scale(
        channel_names, coloured, full_scale, gamma, what, unit,
        signed=cyclic is not None or (not coloured and is_signed(shown)), cyclic=cyclic is not None,
    )  # fmt: skip
    count = sum(len(each.values) for each in shown)
    if count > _MOST_PICTURES:
        raise Error(f"responses: expected at most {_MOST_PICTURES} pictures, found {count}")
    if titles is not None and len(titles) != count:
        raise Error(f"titles: expected {count}, one for each picture, found {len(titles)}")
    rows = _rows(pictures_of(eyes, shown, beside, projection, titles))
    with figure_style():
        figure = _figure(rows, projection, eyes, scale, beside)
        if missing := missing_words([*shown, *(beside or ())]):
            figure.supxlabel(f"grey: {missing}", fontsize="x-small")
        if title is not None:
            figure.suptitle(plain(title), fontsize="large", weight="bold")
        save_figure(figure, names, dpi=200)


def _half_period(cyclic: float, full_scale: float | None, coloured: bool, receptors: bool) -> float:
    if full_scale is not None:
        raise Error("cyclic: expected no full_scale beside it, as the period is the scale")
    if receptors:
        raise Error(
            "cyclic: expected numbers of ommatidia, found those of receptors, of which "
            "means are drawn"
        )
    if coloured:
        raise Error("cyclic: expected one channel, found several; choose by channels=[0]")
    return positive(cyclic, "cyclic") / 2


def _all_shown(
    eyes: Sequence[Eye],
    arrays: Sequence[ArrayLike],
    receptors: bool,
    channels: Sequence[Channel] | None,
    light: Light | None,
    name: str,
) -> list[Shown]:
    if len(arrays) != len(eyes):
        raise Error(f"{name}: expected {len(eyes)} arrays, one for each eye, found {len(arrays)}")
    of = receptors_shown if receptors else partial(bands_shown, centers_nm=centers_nm(light))
    shown = [of(eye, array, channels, name) for eye, array in zip(eyes, arrays, strict=True)]
    kinds = {len(each.names) for each in shown}
    if len(kinds) > 1:
        raise Error(f"channels: expected as many of each eye, found {sorted(kinds)}")
    return shown


def _rows(entries: list[list[list[Picture]]]) -> list[list[Picture]]:
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
    rows: Sequence[Sequence[Picture]],
    projection: str | None,
    eyes: Sequence[Eye],
    scale: Scale,
    beside: Sequence[Shown] | None,
) -> Figure:
    # Two whole spheres side by side.
    aspect = 4 if projection == "spherical_split_orientationwise" else aspect_of(projection)
    columns = max(len(row) for row in rows)
    heights = [_WIDTH_MM / (columns if len(row) > 1 else 1) / aspect + 14 for row in rows]
    letters = _LETTERS_OF_SCALE[beside is not None]
    heights.append(legend_mm(scale, letters))
    figure: Any = load_matplotlib()(
        figsize=(_WIDTH_MM * MM, (sum(heights) + 6) * MM), layout="constrained"
    )
    grid = figure.add_gridspec(len(heights), _UNITS, height_ratios=heights)
    drawn_errors = [Shown(_over_channels(each.values)[..., None], ("",)) for each in beside or ()]
    largest_error = end_of_scale(drawn_errors, _OUTSHINE) if drawn_errors else 1.0
    errors = None
    for k, row in enumerate(rows):
        each = _UNITS // (columns if len(row) > 1 else 1)
        for column, picture in enumerate(row):
            panel = figure.add_subplot(grid[k, column * each : (column + 1) * each])
            extent = draw_axes(panel, projection, len(eyes[0]), k == len(rows) - 1, column == 0)
            marks = _draw(panel, picture, projection, extent, scale, largest_error)
            title = wrapped(picture.title, _LETTERS // (_UNITS // each))
            panel.set_title(plain(title), loc="left")
            if picture.is_error:
                errors = marks
            elif not scale.coloured:
                values = marks
    # The scales side by side below.
    legend = figure.add_subplot(grid[-1, 3:6] if errors is not None else grid[-1, 4:8])
    if not scale.coloured:
        bar = figure.colorbar(values, cax=legend, orientation="horizontal")
        name_scale(legend, scale.what, scale.full_scale, scale.unit, letters)
        if scale.cyclic:
            legend.set_xticks(np.linspace(-scale.full_scale, scale.full_scale, 5))
        bar.outline.set_visible(False)
    else:
        draw_strips(legend, scale, letters)
    if errors is not None:
        panel = figure.add_subplot(grid[-1, 8:11])
        bar = figure.colorbar(errors, cax=panel, orientation="horizontal")
        what = f"standard error{cut_off(drawn_errors, largest_error, False, 'larger')}"
        name_scale(panel, what, largest_error, scale.unit, letters)
        bar.outline.set_visible(False)
    return figure  # type: ignore[no-any-return]


def _draw(
    panel: Axes,
    picture: Picture,
    projection: str | None,
    extent: Any,
    scale: Scale,
    largest_error: float,
) -> Any:
    values = picture.values
    known = np.isfinite(values).all(axis=-1)
    ground = hatched_ground(
        unseen(np.where(picture.seen, 0, -1), projection), inside_outline(projection, *known.shape)
    )
    ground[picture.seen & ~known] = (NOT_KNOWN, NOT_KNOWN, NOT_KNOWN, 1)
    panel.imshow(ground, extent=extent, interpolation="nearest", zorder=0)
    one = values[..., 0]
    limits: dict[str, Any] = {
        "cmap": CYCLIC_COLOURS if scale.cyclic else _SIGNED_COLOURS if scale.signed else _COLOURS,
        "vmin": -scale.full_scale if scale.signed else 0.0,
        "vmax": scale.full_scale,
    }
    if picture.is_error:
        one = _over_channels(values)
        limits = {"cmap": _ERROR_COLOURS, "vmin": 0.0, "vmax": largest_error}
    elif scale.coloured:
        coloured = np.zeros((*known.shape, 4))
        coloured[..., :3][known] = as_colours(values[known], scale.full_scale, scale.gamma)
        coloured[..., 3] = known
        one, limits = coloured, {}
    if limits:
        one = np.ma.masked_invalid(one)
    marks = panel.imshow(one, extent=extent, interpolation="nearest", zorder=0.5, **limits)
    if projection in LISTED:
        panel.set_aspect("auto")  # the layout has space for the title of what fills its place
    return marks


def _over_channels(errors: Floats) -> Floats:
    """The root of the mean square."""
    return np.asarray(np.sqrt((errors**2).mean(axis=-1)))
