"""The search for the farthest distance at which a target is told, by more and more rays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from omma.colour_vision.views import Looking
from omma.rendering.settings import Fixed

# The standard error of a distance, as a share of it, that is small enough.
_ENOUGH = 0.005
# By how many standard errors a target is told, or not, at the end of where it is looked for.
_SURE = 4
# How near the two distances come between which the answer is taken as on a straight line, and how
# far apart those are from which its error follows.
_CLOSE, _STEP = 1.002, 1.1

# By how much a criterion is passed at a distance, and the standard error of that.
Excess = Callable[[Looking, float], tuple[float, float]]


@dataclass(frozen=True)
class Answer:
    """A distance with its standard error, whether that is small enough, and from where to look on
    by more rays."""

    distance_m: float
    standard_error_m: float
    sure: bool
    begin_m: float


class Search:
    """Looks between two distances for the farthest at which a criterion is passed.

    ``settled_m``: from where on less is seen of a target the farther it is. Nearer it may be told
    beyond distances at which it is not, so that all are looked at, in small steps. ``by`` gives
    those who look at a target by so many rays from a distance, and beyond it.
    """

    def __init__(
        self,
        between_m: tuple[float, float],
        settled_m: float,
        by: Callable[[Fixed, float], Looking],
        excess: Excess,
    ) -> None:
        self._near, self._far = between_m
        self._settled_m, self._by, self._excess = settled_m, by, excess

    def begin_m(self, rays: Fixed) -> float:
        """The farthest distance at which a step finds the target told, or where it is most nearly
        told."""
        found, most = self._near, -math.inf
        for one in self._steps():
            value = self._excess(self._by(rays, one), one)[0]
            if value >= 0:
                found, most = one, math.inf
            elif value > most:
                found, most = one, value
            if value < 0 and one >= self._settled_m:
                break
        return found

    def answer(self, rays: Fixed, begin_m: float) -> Answer:
        """By so many rays, from a distance where it is told, or nearly."""
        low = begin_m
        seen_by = self._by(rays, low)
        value = self._excess(seen_by, low)
        most = value, low
        # Fewer rays may have missed the target, or met too much of it.
        while value[0] < 0 and low > self._near:
            low = max(low / self._stride(low), self._near)
            seen_by = self._by(rays, low)
            value = self._excess(seen_by, low)
            most = max(most, (value, low))
        if value[0] < 0:
            return self._at_an_end(0.0, *most)
        high = low
        while value[0] >= 0 and high < self._far:
            low, high = high, min(self._stride(high) * high, self._far)
            value = self._excess(seen_by, high)
        last = max(self._far / 2, self._near)
        if value[0] >= 0:
            return self._at_an_end(math.inf, value, last)
        found, error = _between(self._excess, seen_by, low, high)
        begin = min(max(found / math.sqrt(2), self._near), last)
        return Answer(found, error, error <= _ENOUGH * found, begin)

    def _at_an_end(self, found: float, value: tuple[float, float], begin_m: float) -> Answer:
        excess, error = value
        told = math.nan if math.isfinite(error) else math.inf
        return Answer(found, told, abs(excess) > _SURE * error, begin_m)

    def _steps(self) -> Iterator[float]:
        one = self._near
        while one < self._far:
            yield one
            one *= self._stride(one)

    def _stride(self, distance_m: float) -> float:
        return math.sqrt(2) if distance_m < self._settled_m else 2.0


def _between(excess: Excess, seen_by: Looking, low: float, high: float) -> tuple[float, float]:
    """Where between two distances the criterion is reached, and the standard error of that."""
    above, below = (excess(seen_by, one)[0] for one in (low, high))
    # Of the whole, which falls even where the seven that look nearest change on the way.
    whole = (above - below) / math.log(high / low)
    while high / low > _CLOSE:
        middle = math.sqrt(low * high)
        value = excess(seen_by, middle)[0]
        if value >= 0:
            low, above = middle, value
        else:
            high, below = middle, value
    found = low * (high / low) ** (above / (above - below))
    error = excess(seen_by, found)[1]
    near, far = (excess(seen_by, found * step)[0] for step in (1 / _STEP, _STEP))
    slope = (near - far) / (2 * math.log(_STEP))
    if slope <= 0:
        slope = whole
    # Without an error no ray is at the target's edge, and the criterion is passed by a step.
    return found, found * error / slope if error > 0 else math.inf
