"""Units of lengths that files of points say, and what there is to tell of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omma.base.arrays import Floats

# Lengths that differ by less than this share are the same: US survey feet are 2e-6 longer.
_ALIKE = 1e-7


@dataclass(frozen=True)
class Unit:
    """What it is called, and how long it is; None: it is that of an angle."""

    name: str
    metres: float | None = None


METRES, FEET, DEGREES = Unit("metres", 1.0), Unit("feet", 0.3048), Unit("degrees")
SURVEY_FEET = Unit("US survey feet", 0.3048006096)  # 1200 / 3937


def length_unit(metres: float) -> Unit | None:
    """The unit of that length; None where it is none."""
    if not 0 < metres < math.inf:
        return None
    for one in (METRES, FEET, SURVEY_FEET):
        if one.metres is not None and _alike(metres, one.metres):
            return one
    return Unit(f"units of {metres:.10g} m", metres)


@dataclass(frozen=True)
class Units:
    """What a file says of its lengths: those across, and heights; None: nothing."""

    across: Unit | None = None
    heights: Unit | None = None

    def __str__(self) -> str:
        across = "not said by the file" if self.across is None else self.across.name
        if self.heights in (None, self.across):
            return across
        return f"{across}, heights in {self.heights.name}"

    def advice(self, world_from_file: Floats) -> str:
        """How to read the file where the matrix takes a unit for another; "" where it does not."""
        read_m = float(np.cbrt(abs(np.linalg.det(world_from_file[:3, :3]))))
        is_in_metres = _alike(read_m, 1.0)
        across, heights = self.across, self.heights
        if across is not None and across.metres is None:
            told = f"its coordinates are in {across.name}, they are read as metres"
            return f"{told}: project them to metres first" if is_in_metres else ""
        across_m = read_m if across is None or across.metres is None else across.metres
        if heights is None or heights.metres is None or _alike(heights.metres, across_m):
            if across is None or _alike(across_m, 1.0) or not is_in_metres:
                return ""
            told = f"its coordinates are in {across.name}"
            told += ", of heights it says none" if heights is None else ""
            return f"{told}, they are read as metres: {_give(across_m)}"
        scales = ["1"] * 4
        scales[int(np.abs(world_from_file[:3, 2]).argmax())] = f"{heights.metres / across_m:.10g}"
        alone = f"omma.scene.place_scene(scene, numpy.diag([{', '.join(scales)}]))"
        alone = f"scale the heights of the scene alone, {alone}"
        told = f"its heights are in {heights.name}"
        if across is not None:
            first = "" if _alike(read_m, across_m) else f"{_give(across_m)} and "
            return f"{told}, the rest is in {across.name}: {first}{alone}"
        if not is_in_metres:
            return ""
        return (
            f"{told}, of the rest it says no unit, all is read as metres: {_give(heights.metres)} "
            f"if all is in {heights.name}, else {alone}"
        )


def _give(metres: float) -> str:
    return f"give unit={metres:.10g} (--unit, of a render --scene-unit)"


def _alike(one: float, other: float) -> bool:
    return abs(one - other) <= _ALIKE * other
