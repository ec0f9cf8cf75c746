"""Figures of the angular sensitivity of chosen ommatidia, and of its modulation transfer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from omma._core import Acceptance, Error, Eye
from omma.base.arguments import checked
from omma.base.arrays import Floats
from omma.base.figures import (
    COLOURS,
    GREY,
    INK,
    MM,
    figure_names,
    figure_style,
    load_matplotlib,
    plain,
    save_figure,
)
from omma.base.files import PathLike
from omma.eye.measures import EyeMeasures, measure_eye
from omma.picture.eye_maps import eye_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: An ommatidium by its index, or by the direction (azimuth, elevation) in degrees nearest to which
#: it looks.
Chosen = int | tuple[float, float]

_MOST = len(COLOURS)
_AZIMUTHS = 36  # tried for the widest and the narrowest profile, over half a turn
_LEVELS = (0.1, 0.25, 0.5, 0.75, 0.9)


@checked
def plot_acceptance(
    paths: PathLike | Sequence[PathLike],
    eye: Eye,
    ommatidia: Sequence[Chosen] | None = None,
    *,
    title: str | None = None,
    measures: EyeMeasures | None = None,
) -> None:
    """Write a figure of angular sensitivities and their modulation transfer functions.

    Profiles through the axis, with the width at half maximum and, dashed, the Gaussian of that
    width; of what is not round along its widest and its narrowest azimuth, and a map. Beside them
    the modulation transfer for gratings that vary along these azimuths, with the sampling frequency
    1/(2Δφ) as a dotted line.

    Args:
        paths: names ending in .pdf, .svg or .png.
        ommatidia: up to six, each an index or a direction (azimuth, elevation) in degrees. Default:
            those with the smallest, the median and the largest (95th percentile) Δφ.

    Raises:
        omma.Error: an index out of range, too many, another ending, Matplotlib is missing, a file
            cannot be written.
    """
    names = figure_names(paths)
    if ommatidia is not None:
        _expect_chosen(eye, ommatidia)  # before it is measured, which may take long
    measures = measures or measure_eye(eye)
    chosen = choose(eye, measures, ommatidia)
    odd = [i for i in chosen if not eye.acceptance(i).is_round]
    with figure_style():
        below = len(odd) > 2
        figure = load_matplotlib()(
            figsize=(180 * MM, (135 if below else 88) * MM), layout="constrained"
        )
        upper: Any
        beside: Any = None
        if below:
            rows = figure.add_gridspec(2, 1, height_ratios=(85, 50))
            upper, beside = rows[0].subgridspec(1, 2), rows[1].subgridspec(1, len(odd))
        else:
            upper = figure.add_gridspec(1, 3 if odd else 2, width_ratios=(3, 3, 2)[: 2 + bool(odd)])
            if odd:
                beside = upper[2].subgridspec(len(odd), 1)
        draw_profiles(figure.add_subplot(upper[0]), eye, chosen)
        draw_transfer(figure.add_subplot(upper[1]), eye, measures, chosen)
        for k, i in enumerate(odd):
            panel = figure.add_subplot(beside[k])
            _contours(panel, eye.acceptance(i), f"S of ommatidium {i}", _colour(chosen, i))
        figure.suptitle(plain(title or eye_title(eye)), fontsize="medium", weight="bold")
        save_figure(figure, names, dpi=300)


def choose(eye: Eye, measures: EyeMeasures, ommatidia: Sequence[Chosen] | None) -> list[int]:
    """Indices of chosen ommatidia, each once; see `plot_acceptance`."""
    if ommatidia is None:
        angle = measures.interommatidial_rad
        known = np.flatnonzero(np.isfinite(angle))
        if len(known) == 0:
            return [0]
        order = known[np.argsort(angle[known], kind="stable")]
        ends = [order[0], order[len(order) // 2], order[int(0.95 * (len(order) - 1))]]
        return list(dict.fromkeys(int(i) for i in ends))
    _expect_chosen(eye, ommatidia)
    return list(dict.fromkeys(_index(measures, one) for one in ommatidia))


def _expect_chosen(eye: Eye, ommatidia: Sequence[Chosen]) -> None:
    if not 1 <= len(ommatidia) <= _MOST:
        raise Error(f"ommatidia: expected 1 to {_MOST}, found {len(ommatidia)}")
    for one in ommatidia:
        if not isinstance(one, tuple) and not 0 <= one < len(eye):
            raise Error(f"ommatidia: expected indices from 0 to {len(eye) - 1}, found {one}")


def draw_profiles(panel: Axes, eye: Eye, chosen: Sequence[int]) -> None:
    """S(θ) of each, with its half maximum and the Gaussian of the same width."""
    reach = max(_widest(eye.acceptance(i))[1] for i in chosen) * 1.6 or math.radians(1)
    theta = np.linspace(-reach, reach, 601)
    panel.axhline(0.5, color=GREY, linewidth=0.6, linestyle=":")
    compared = False
    for acceptance, members, colour in _shared(eye, chosen):
        for azimuth, width, style, which in _profiles(acceptance):
            values = _signed(acceptance, theta, azimuth)
            label = f"{members}{which}: {acceptance.kernel.replace('_', ' ')}"
            label += f", Δρ {math.degrees(width):.2f}°"
            if acceptance.kernel == "compoundray":
                # Per solid angle it has no largest value: it grows as 1/θ towards the axis.
                values = 0.5 * values / acceptance.eval(width / 2)
                label += ", drawn as ½ at Δρ/2"
            panel.plot(np.degrees(theta), values, style, color=colour, label=label)
            if acceptance.kernel != "gaussian":
                gaussian = np.exp(-4 * math.log(2) * (theta / max(width, 1e-9)) ** 2)
                panel.plot(np.degrees(theta), gaussian, **_thin(colour))
                compared = True
            ends = _half_maximum(theta, values)
            if ends is not None:
                panel.plot(np.degrees(ends), [0.5, 0.5], "|", color=colour, markersize=7)
    if compared:
        panel.plot([], [], **_thin(GREY), label="Gaussian of the same Δρ")
    panel.set(
        xlabel="angle from the axis θ (°)",
        ylabel="relative sensitivity S(θ)",
        xlim=np.degrees((-reach, reach)),
        ylim=(-0.02, 1.05),
    )
    panel.annotate(
        "half maximum", (1, 0.5), (-2, 2), xycoords=("axes fraction", "data"),
        textcoords="offset points", ha="right", va="bottom", color=GREY, fontsize="x-small",
    )  # fmt: skip
    _legend(panel, "ommatidium")


def draw_transfer(panel: Axes, eye: Eye, measures: EyeMeasures, chosen: Sequence[int]) -> None:
    """The modulation transfer of each, with its sampling frequency 1/(2Δφ)."""
    narrow = min(width for i in chosen for _, width, _, _ in _profiles(eye.acceptance(i)))
    # A Gaussian passes 1 % at 1.14/Δρ.
    most = 1.3 / max(narrow, math.radians(0.01))
    sampling = measures.sampling_per_rad[list(chosen)]
    if np.isfinite(sampling).any():
        most = max(most, 1.15 * float(np.nanmax(sampling)))
    frequency = np.linspace(0, most, 401)
    least = -0.02
    for acceptance, _, colour in _shared(eye, chosen):
        for azimuth, width, style, _ in _profiles(acceptance):
            values = np.asarray(acceptance.mtf(frequency, azimuth), dtype=np.float64)
            least = min(least, 1.1 * float(values.min()))
            panel.plot(np.radians(frequency), values, style, color=colour)
            if acceptance.kernel != "gaussian":
                gaussian = np.exp(-(math.pi**2 / (4 * math.log(2))) * (frequency * width) ** 2)
                panel.plot(np.radians(frequency), gaussian, **_thin(colour))
    for i, each in zip(chosen, sampling.tolist(), strict=True):
        if math.isfinite(each):
            at = math.radians(each)  # per degree there is less of it
            label = f"{i}: 1/(2Δφ) = {at:.3g} cycles/°"
            colour = _colour(chosen, i)
            panel.axvline(at, color=colour, linewidth=0.9, linestyle=":", label=label)
    panel.axhline(0, color=GREY, linewidth=0.6)
    panel.set(
        xlabel="spatial frequency ν (cycles/°)",
        ylabel="modulation transfer M(ν)",
        xlim=(0, math.radians(most)),
        ylim=(least, 1.05),
    )
    if np.isfinite(sampling).any():
        _legend(panel, "sampling frequency of ommatidium")


def _contours(panel: Axes, acceptance: Acceptance, name: str, colour: str) -> None:
    reach = 0.9 * _widest(acceptance)[1]
    along = np.linspace(-reach, reach, 121)
    right, up = np.meshgrid(along, along)
    values = acceptance.eval(np.hypot(right, up), np.arctan2(right, up))
    degrees = np.degrees(along)
    panel.contourf(degrees, degrees, values, np.linspace(0, 1, 21), cmap="Greys")
    widths = [1.6 if level == 0.5 else 0.6 for level in _LEVELS]
    lines = panel.contour(degrees, degrees, values, _LEVELS, colors=colour, linewidths=widths)
    panel.clabel(lines, [0.1, 0.5], fontsize="x-small", fmt="%g")
    panel.set_aspect("equal")
    panel.set(xlabel="to its right (°)", ylabel="up (°)", title=name)


def _profiles(acceptance: Acceptance) -> list[tuple[float, float, str, str]]:
    # Azimuth, width, line style and what to add to a name: one of what is round, else the widest
    # and the narrowest.
    if acceptance.is_round:
        return [(0.0, acceptance.width_rad(), "-", "")]
    found = []
    for narrowest, style, word in ((False, "-", "widest"), (True, "-.", "narrowest")):
        azimuth, width = _widest(acceptance, narrowest)
        found.append((azimuth, width, style, f" {word}, at {math.degrees(azimuth):.0f}°"))
    return found


def _shared(eye: Eye, chosen: Sequence[int]) -> list[tuple[Acceptance, str, str]]:
    # Each sensitivity once: with the names of those that have it, in their colour or, of several,
    # in black.
    groups: list[tuple[Acceptance, list[int]]] = []
    for i in chosen:
        acceptance = eye.acceptance(i)
        for other, members in groups:
            if other == acceptance:
                members.append(i)
                break
        else:
            groups.append((acceptance, [i]))
    return [
        (acceptance, ", ".join(map(str, of)), _colour(chosen, of[0]) if len(of) == 1 else INK)
        for acceptance, of in groups
    ]


def _thin(colour: str) -> Any:
    return {"color": colour, "linestyle": "--", "linewidth": 0.6, "alpha": 0.8}


def _widest(acceptance: Acceptance, narrowest: bool = False) -> tuple[float, float]:
    if acceptance.is_round:
        return 0.0, acceptance.width_rad()
    tried = [math.pi * k / _AZIMUTHS for k in range(_AZIMUTHS)]
    widths = [acceptance.width_rad(azimuth) for azimuth in tried]
    at = int(np.argmin(widths) if narrowest else np.argmax(widths))
    return tried[at], widths[at]


def _signed(acceptance: Acceptance, theta: Floats, azimuth: float) -> Floats:
    # Left of the axis is half a turn away.
    return np.asarray(
        acceptance.eval(np.abs(theta), np.where(theta < 0, azimuth + math.pi, azimuth)),
        dtype=np.float64,
    )


def _half_maximum(theta: Floats, values: Floats) -> tuple[float, float] | None:
    above = np.flatnonzero(values >= 0.5 * values.max())
    if len(above) == 0 or above[0] == 0 or above[-1] == len(theta) - 1:
        return None
    return float(theta[above[0]]), float(theta[above[-1]])


def _index(measures: EyeMeasures, one: Chosen) -> int:
    if isinstance(one, tuple):
        azimuth, elevation = np.radians(one)
        level = math.cos(elevation)
        towards = [level * math.sin(azimuth), math.sin(elevation), -level * math.cos(azimuth)]
        return int(np.argmax(measures.axis @ np.array(towards)))
    return one


def _colour(chosen: Sequence[int], which: int) -> str:
    return COLOURS[list(chosen).index(which) % len(COLOURS)]


def _legend(panel: Axes, title: str) -> None:
    panel.legend(
        title=title, fontsize="x-small", title_fontsize="x-small", labelspacing=0.25,
        frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.17), handlelength=2.6,
    )  # fmt: skip
