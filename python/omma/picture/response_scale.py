"""What the scale of a figure of responses spans: from 0 on, or as far below 0 as above it; and what
it cannot show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.picture.response_colours import SHOWN_AS, Shown

# Below 0 by this share of the largest is 0: single precision, and sums of it.
_ROUNDING = 1e-5
# Of the scale's end, as noise may.
_MOST_BELOW = 0.1
# Of linear sRGB (IEC 61966-2-1). Colours that no screen has, as under water, have a negative red,
# green or blue; but no light has a luminance below 0.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def largest(shown: Sequence[Shown]) -> float:
    """The largest of all numbers, by its size; 1 where there is none but 0."""
    known = _known(shown)
    most = float(np.abs(known).max(initial=0.0))
    return most if most > 0 else 1.0


def end_of_scale(shown: Sequence[Shown], outshine: float = 10.0) -> float:
    """The largest; where a few ``outshine`` all others so many times, what all but a hundredth
    have."""
    most = largest(shown)
    known = np.abs(_known(shown))
    often = float(np.quantile(known, 0.99)) if known.size else 0.0
    return often if 0 < outshine * often < most else most


def within_period(shown: Shown, period: float) -> Shown:
    """Numbers that come back to where they began, from minus half a period to half a period."""
    with np.errstate(invalid="ignore"):
        turned = np.mod(shown.values + period / 2, period) - period / 2
    return replace(shown, values=np.where(np.isinf(shown.values), shown.values, turned))


def is_signed(shown: Sequence[Shown]) -> bool:
    """Whether numbers lie below 0, by more than rounding."""
    return _lowest(shown) < -_ROUNDING * largest(shown)


def check_colours(shown: Sequence[Shown], full_scale: float, name: str) -> None:
    """omma.Error where two or three channels have numbers that colours cannot show."""
    way_out = "; draw one channel at a time, as by channels=[0]"
    if words := missing_words(shown):
        raise Error(f"{name}: expected finite numbers to show as colours, found {words}{way_out}")
    for each in shown:
        below = (
            is_rgb_below_0(each.values / full_scale)
            if each.names == SHOWN_AS[3]
            else (each.values.min() < -_MOST_BELOW * full_scale)
        )
        if below:
            low = each.values.min()
            raise Error(
                f"{name}: expected numbers from 0 on to show as colours, found {low:.3g}{way_out}"
            )


def is_rgb_below_0(values: NDArray[Any]) -> bool:
    """Whether red, green and blue (..., 3), displayed from 0 to 1, are no light's: NaN is passed
    over."""
    return bool(np.any(values @ _LUMINANCE < -_MOST_BELOW))


def missing_words(shown: Sequence[Shown]) -> str:
    """What there is instead of numbers that can be drawn; "" where there is nothing of it."""
    infinite = any(np.isinf(each.values).any() for each in shown)
    no_number = any(np.isnan(each.values).any() for each in shown)
    found = ["infinite"] * infinite + ["not a number"] * no_number
    return " or ".join(found)


def cut_off(shown: Sequence[Shown], full_scale: float, coloured: bool, brighter: str) -> str:
    """What the legend says of numbers that lie beyond its scale."""
    found = []
    if 1.001 * full_scale < largest(shown):
        found.append(brighter)
    if coloured and is_signed(shown):
        found.append("below 0")
    return f", {' and '.join(found)} cut off" if found else ""


def _known(shown: Sequence[Shown]) -> Floats:
    return np.concatenate([each.values[np.isfinite(each.values)].ravel() for each in shown])


def _lowest(shown: Sequence[Shown]) -> float:
    return float(_known(shown).min(initial=0.0))
