"""What is drawn over the scene: the head with its facets, axes and fields of view, and the field of
the ommatidium that is picked. Shapes only, in the head's frame or the world's."""

from __future__ import annotations

import html
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arrays import Floats
from omma.eye.neighbours import direction_lattice
from omma.view.picked import Rays, cone_of, profile_of

Pixels = NDArray[np.uint8]

EYE_COLOURS = ((214, 120, 30), (40, 110, 200), (60, 150, 80), (150, 80, 170), (120, 120, 120))
PICKED = (255, 0, 220)
# More lines than these hide what is behind them.
_MOST_AXES = 600
_FIELD, _AXES = 2.2, 1.7  # where fields of view and axes end, in radii of the head
_SKY_M = 30.0  # how far a ray is drawn that meets nothing, at most


@dataclass(frozen=True)
class HeadShapes:
    """Of a head whose drawn radius is 1, in its frame. facets: (N, 3); axes: (L, 2, 3) with
    axis_colours (L, 2, 3); fields: of each eye vertices (K, 3), triangles (T, 3) and a colour."""

    facets: Floats
    axes: Floats
    axis_colours: Pixels
    fields: tuple[tuple[Floats, NDArray[np.int64], tuple[int, int, int]], ...]


def head_shapes(eye: Eye) -> HeadShapes:
    """What is drawn of an eye, or of all eyes of a head."""
    axis = eye.axis.astype(np.float64)
    every = max(1, -(-len(axis) // _MOST_AXES))
    lines = np.stack([axis[::every], _AXES * axis[::every]], axis=1)
    numbers = np.unique(eye.eye_id).tolist()
    colour_of = {number: EYE_COLOURS[k % len(EYE_COLOURS)] for k, number in enumerate(numbers)}
    colours = np.array([colour_of[number] for number in eye.eye_id[::every].tolist()], np.uint8)
    fields: list[tuple[Floats, NDArray[np.int64], tuple[int, int, int]]] = []
    for number in numbers:
        mine = np.flatnonzero(eye.eye_id == number)
        triangles = direction_lattice(axis[mine], np.zeros(len(mine), np.int32)).triangles
        if len(triangles):
            # Each a little outside the one before, so that those that overlap are both seen.
            reach = _FIELD * (1 + 0.04 * len(fields))
            fields.append((reach * axis[mine], np.asarray(triangles), colour_of[number]))
    return HeadShapes(axis, lines, np.repeat(colours[:, None], 2, axis=1), tuple(fields))


def field_lines(eye: Eye, world_from_head: Floats, ommatidium: int, distance_m: float) -> Floats:
    """The cone of half sensitivity, as lines (L, 2, 3) in the world, m."""
    turn = world_from_head[:3, :3]
    start = turn @ eye.position_m[ommatidium].astype(np.float64) + world_from_head[:3, 3]
    rim = start + distance_m * (cone_of(eye, ommatidium) @ turn.T)
    around = np.stack([rim, np.roll(rim, -1, axis=0)], axis=1)
    spokes = np.stack([np.broadcast_to(start, rim[::4].shape), rim[::4]], axis=1)
    return np.concatenate([around, spokes])


def ray_lines(rays: Rays) -> tuple[Floats, Pixels]:
    """Rays to what they meet, as lines (S, 2, 3), m, in the colour that they bring (S, 2, 3)."""
    far = np.where(np.isfinite(rays.distance_m), rays.distance_m, _SKY_M)
    ends = rays.start_m + far[:, None] * rays.direction
    seen = rays.radiance[:, :3] if rays.radiance.shape[1] >= 3 else rays.radiance[:, :1]
    full = float(seen.max()) or 1.0
    scaled = np.clip(seen / max(full, 1e-30), 0, 1) ** (1 / 2.2) * 255
    colours = np.broadcast_to(scaled, (len(seen), 3)).astype(np.uint8)
    return np.stack([rays.start_m, ends], axis=1), np.repeat(colours[:, None], 2, axis=1)


def reach_of(rays: Rays) -> float:
    """How far the picked ommatidium's cone is drawn: to what its rays meet, in the median."""
    met = rays.distance_m[np.isfinite(rays.distance_m)]
    return float(np.median(met)) if len(met) else _SKY_M


def acceptance_drawing(eye: Eye, ommatidium: int) -> str:
    """The acceptance of an ommatidium as SVG: sensitivity over degrees from its axis."""
    angle, values = profile_of(eye.acceptance(ommatidium))
    degrees = np.degrees(angle)
    reach = float(np.abs(degrees).max())
    left, top, wide, high = 34, 10, 330, 104
    x = left + wide * (degrees + reach) / (2 * reach)
    y = top + high * (1 - values)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
    step = _round_step(reach)
    marks = np.arange(-np.floor(reach / step), np.floor(reach / step) + 1) * step
    parts = [
        f'<line x1="{left}" y1="{top + high}" x2="{left + wide}" y2="{top + high}" stroke="#888"/>',
        f'<line x1="{left}" y1="{top + high / 2}" x2="{left + wide}" y2="{top + high / 2}" '
        'stroke="#bbb" stroke-dasharray="3 3"/>',
        f'<text x="{left - 5}" y="{top + 4}" text-anchor="end">1</text>',
        f'<text x="{left - 5}" y="{top + high / 2 + 4}" text-anchor="end">½</text>',
        f'<text x="{left - 5}" y="{top + high + 4}" text-anchor="end">0</text>',
    ]
    for mark in marks.tolist():
        at = left + wide * (mark + reach) / (2 * reach)
        parts.append(
            f'<text x="{at:.1f}" y="{top + high + 15}" text-anchor="middle">{mark:g}°</text>'
        )
    caption = html.escape("sensitivity, from the axis down (left) to up (right)")
    return (
        f'<svg viewBox="0 0 380 {top + high + 36}" style="width:100%" font-size="11" '
        f'fill="currentColor" role="img" aria-label="{caption}">{"".join(parts)}'
        f'<polyline points="{points}" fill="none" stroke="#d0109f" stroke-width="2"/>'
        f'<text x="{left + wide / 2}" y="{top + high + 31}" text-anchor="middle">{caption}</text>'
        "</svg>"
    )


def _round_step(reach: float) -> float:
    power = 10.0 ** np.floor(np.log10(reach))
    return float(next(f * power for f in (5.0, 2.0, 1.0, 0.5) if reach / (f * power) >= 2))
