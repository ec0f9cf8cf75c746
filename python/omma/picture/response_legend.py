"""What the legend of a figure of responses says: channels, colours, and the unit of the numbers."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omma._core import Eye
from omma.base.figures import plain, wrapped
from omma.light import Light
from omma.picture.eye_maps import known_name
from omma.picture.response_colours import SHOWN_AS, Shown, as_colours
from omma.picture.sky_plots import RADIANCE_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LETTERS = 34  # as many as fit beside the strips


@dataclass(frozen=True)
class Scale:
    """How responses are shown: names of the channels, and what is said below the scale.

    coloured: as display colours, else by a colour bar; of a signed one 0 is the middle, a cyclic
    one ends in the colour that it begins with. unit: of responses, "" where they have none, None
    where nobody said.
    """

    names: tuple[str, ...]
    coloured: bool
    full_scale: float
    gamma: float
    what: str
    unit: str | None
    signed: bool = False
    cyclic: bool = False


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


def names_of_all(eyes: Sequence[Eye], shown: Sequence[Shown]) -> tuple[str, ...]:
    """Of each channel its name; where eyes have others, each after its eye's."""
    if len({each.names for each in shown}) == 1:
        return shown[0].names
    called = [known_name(eye) for eye in eyes]
    if "" in called or len(set(called)) < len(called):
        called = [f"eye {k + 1} of {len(eyes)}" for k in range(len(eyes))]
    found = []
    for channel in zip(*(each.names for each in shown), strict=True):
        owners: dict[str, list[str]] = {}
        for eye, name in zip(called, channel, strict=True):
            owners.setdefault(name, []).append(eye)
        one = len(owners) == 1
        parts = [name if one else f"{', '.join(who)}: {name}" for name, who in owners.items()]
        found.append("; ".join(parts))
    return tuple(found)


def legend_mm(scale: Scale, letters: int) -> float:
    """How high the legend is, where the label below has so many letters in a line."""
    lines = [name.count("\n") + 1 for name in _row_names(scale.names)] if scale.coloured else [1]
    below = len(_label(_what(scale), scale.full_scale, scale.unit, letters).splitlines())
    return 7 + 3 * below + len(scale.names) * max(3.5, 2.8 * max(lines))


def _row_names(names: Sequence[str]) -> list[str]:
    called = [
        name if name == colour or len(names) == 1 else f"{name}, shown {colour}"
        for name, colour in zip(names, SHOWN_AS[len(names)], strict=True)
    ]
    return [textwrap.fill(each, _LETTERS) for each in called]


def draw_strips(panel: Axes, scale: Scale, letters: int) -> None:
    """The scale of each channel as a strip of what it is shown as, its name beside it."""
    steps = np.linspace(0, scale.full_scale, 256)
    count = len(scale.names)
    each = np.eye(count)[:, None] * steps[:, None]
    panel.imshow(
        as_colours(each, scale.full_scale, scale.gamma),
        extent=(0, scale.full_scale, count, 0), aspect="auto", interpolation="nearest",
    )  # fmt: skip
    labels = [plain(one) for one in _row_names(scale.names)]
    panel.set_yticks(np.arange(count) + 0.5, labels, fontsize="small")
    for label in panel.get_yticklabels():
        label.set_in_layout(False)  # there is space beside it, which no other picture should give
    panel.tick_params(axis="y", length=0)
    name_scale(panel, _what(scale), scale.full_scale, scale.unit, letters)
    for side in ("left", "bottom"):
        panel.spines[side].set_visible(False)


def _what(scale: Scale) -> str:
    gamma = f" (display gamma {scale.gamma:g})" if scale.coloured else ""
    return f"{scale.what}{gamma}"


def name_scale(panel: Axes, label: str, largest: float, unit: str | None, letters: int) -> None:
    """The label of a scale with its unit, and before that the power of ten of very large and very
    small numbers, as of photons, which Matplotlib would write across the label."""
    panel.set_xlabel(_label(label, largest, unit, letters))
    if power := _power(largest):
        panel.xaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")


def _label(label: str, largest: float, unit: str | None, letters: int) -> str:
    power = _power(largest)
    if not power:
        return wrapped(f"{label}, {unit}" if unit else label, letters)
    times = "unit not given (light=)" if unit is None else unit
    return wrapped(f"{label}, $10^{{{power}}}$ {times}".rstrip(), letters)


def _power(largest: float) -> int:
    """Of ten, that is said beside the unit; 0 of numbers that are neither large nor small."""
    return 0 if 1e-3 <= largest < 1e4 else math.floor(math.log10(largest))
