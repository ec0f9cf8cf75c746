"""Marks on maps of skies: neutral points with their names, and the sun and the moon."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from omma.base.arrays import Floats
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.figures import COLOURS, INK
from omma.light.discs import Disc
from omma.light.lights import Light

# In units of a map whose horizon is 1 from its middle, of letters of size x-small.
_LETTER, _LINE, _MARK, _APART = 0.068, 0.12, 0.05, 0.06
_EDGE = 1.25  # of what is free for names: bars of colours begin there
_LEAST_SHARE = 0.01  # of the sky's light, of a disc that shines


class _Box(NamedTuple):
    left: float
    bottom: float
    right: float
    top: float


def on_map(towards: Floats) -> tuple[float, float]:
    """East and north of the middle of a map, whose horizon is 1 from it."""
    azimuth, elevation = azimuth_elevation_deg_of(towards)
    r = 1 - float(elevation) / 90
    return r * float(np.sin(np.radians(azimuth))), r * float(np.cos(np.radians(azimuth)))


def shining(light: Light) -> list[Disc]:
    """Discs above the horizon that give a hundredth of what the sky does, or more: no sun behind
    clouds, no star beside a moon."""
    level = light.irradiance()[0]
    found = []
    for disc in light.discs:
        coming = disc.irradiance()
        if light.cloud_shadow is not None:
            coming = coming * light.cloud_shadow.transmittance((0, 0, 0), disc.direction)
        if disc.direction[1] > 0 and np.any((coming > 0) & (coming >= _LEAST_SHARE * level)):
            found.append(disc)
    return found


def mark_discs(panel: Any, discs: list[Disc]) -> None:
    for disc in discs:
        panel.plot(
            *on_map(disc.direction), "o", color="#ffd23f", markersize=4, markeredgecolor=INK,
            markeredgewidth=0.5,
        )  # fmt: skip


def mark_neutral(panel: Any, points: list[tuple[str, Floats]], discs: list[Disc]) -> None:
    """Crosses, and beside each its name where it lies on no other mark or name."""
    taken = [_around(*on_map(towards)) for _, towards in points]
    taken += [_around(*on_map(disc.direction)) for disc in discs]
    for name, towards in points:
        x, y = on_map(towards)
        panel.plot(x, y, "+", color="w", markersize=6, markeredgewidth=1.6)
        panel.plot(x, y, "+", color=COLOURS[1], markersize=5, markeredgewidth=0.9)
        if not name:
            continue
        box = min(_places(name, x, y), key=lambda one: _hidden(one, taken))
        taken.append(box)
        panel.text(
            (box.left + box.right) / 2, (box.bottom + box.top) / 2, name, fontsize="x-small",
            ha="center", va="center", color="w", path_effects=_outline(),
        )  # fmt: skip


def _places(name: str, x: float, y: float) -> list[_Box]:
    """Of a name beside a point, the best first: towards the middle of the map, where no bar of
    colours is, below, above, and on the other side."""
    half, up = _LETTER * len(name) / 2, _LINE / 2
    side = -1 if x > 0.3 else 1
    beside, above = _APART + half, _APART + up
    middles = [(x + side * beside, y), (x, y - above), (x, y + above), (x - side * beside, y)]
    return [_Box(a - half, b - up, a + half, b + up) for a, b in middles]


def _around(x: float, y: float) -> _Box:
    return _Box(x - _MARK, y - _MARK, x + _MARK, y + _MARK)


def _hidden(box: _Box, taken: list[_Box]) -> float:
    """How much of a name lies on marks and names, or beyond the map."""
    lost = 0.0
    for other in taken:
        wide = min(box.right, other.right) - max(box.left, other.left)
        high = min(box.top, other.top) - max(box.bottom, other.bottom)
        lost += max(wide, 0.0) * max(high, 0.0)
    beyond = max(abs(box.left), abs(box.right), abs(box.bottom), abs(box.top)) - _EDGE
    return lost + max(beyond, 0.0) * _LINE


def _outline() -> list[Any]:
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=1.4, foreground=INK)]
