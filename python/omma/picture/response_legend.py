"""What the legend of a figure of responses says: channels, colours, and the unit of the numbers."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omma.light import Light
from omma.picture.response_colours import SHOWN_AS, as_colours
from omma.picture.sky_plots import RADIANCE_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LETTERS = 34  # as many as fit beside the strips


@dataclass(frozen=True)
class Scale:
    """How responses are shown: names of the channels, and what is said below the scale.

    coloured: as display colours, else by a colour bar; of a signed one 0 is the middle. unit: of
    responses, "" where they have none, None where nobody said.
    """

    names: tuple[str, ...]
    coloured: bool
    full_scale: float
    gamma: float
    what: str
    unit: str | None
    signed: bool = False


def centers_nm(light: Light | None) -> list[float] | None:
    return None if light is None else [float(each) for each in light.bands.centers_nm]


def unit_of(light: Light | None, arrays: Sequence[Any]) -> str | None:
    """As the light says it, or arrays with units of their own; "" for numbers without one."""
    if light is not None:
        return RADIANCE_UNITS[light.unit]
    said = {getattr(each, "attrs", {}).get("units") for each in arrays}
    unit = said.pop() if len(said) == 1 else None
    if not isinstance(unit, str):
        return None
    return "" if unit == "1" else re.sub(r"(?<=[a-z])-(\d)", _raised, unit)


def _raised(power: re.Match[str]) -> str:
    return "⁻" + "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(power[1])]


def legend_mm(scale: Scale) -> float:
    """How high the legend is."""
    lines = max(name.count("\n") + 1 for name in _row_names(scale.names)) if scale.coloured else 1
    return 10 + len(scale.names) * max(3.5, 2.8 * lines)


def _row_names(names: Sequence[str]) -> list[str]:
    called = [
        name if name == colour or len(names) == 1 else f"{name}, shown {colour}"
        for name, colour in zip(names, SHOWN_AS[len(names)], strict=True)
    ]
    return [textwrap.fill(each, _LETTERS) for each in called]


def draw_strips(panel: Axes, scale: Scale) -> None:
    """The scale of each channel as a strip of what it is shown as, its name beside it."""
    steps = np.linspace(0, scale.full_scale, 256)
    count = len(scale.names)
    each = np.eye(count)[:, None] * steps[:, None]
    panel.imshow(
        as_colours(each, scale.full_scale, scale.gamma),
        extent=(0, scale.full_scale, count, 0), aspect="auto", interpolation="nearest",
    )  # fmt: skip
    labels = _row_names(scale.names)
    panel.set_yticks(np.arange(count) + 0.5, labels, fontsize="small")
    for label in panel.get_yticklabels():
        label.set_in_layout(False)  # there is space beside it, which no other picture should give
    panel.tick_params(axis="y", length=0)
    name_scale(panel, f"{scale.what} (display gamma {scale.gamma:g})", scale.full_scale, scale.unit)
    for side in ("left", "bottom"):
        panel.spines[side].set_visible(False)


def name_scale(panel: Axes, label: str, largest: float, unit: str | None) -> None:
    """The label of a scale with its unit, and before that the power of ten of very large and very
    small numbers, as of photons, which Matplotlib would write across the label."""
    if 1e-3 <= largest < 1e4:
        panel.set_xlabel(f"{label}, {unit}" if unit else label)
        return
    power = math.floor(math.log10(largest))
    panel.xaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
    times = "unit not given (light=)" if unit is None else unit
    panel.set_xlabel(f"{label}, $10^{{{power}}}$ {times}".rstrip())
