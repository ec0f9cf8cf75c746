"""Ommatidia on surfaces: directions given and positions found, or positions given and axes found.

Real eyes are skewed: their ommatidia do not look along the normal of the surface they sit on, so
an eye sees more, or less, than its curvature spans. Here that is a function of its own: from the
direction to the normal at a position, or from a position to the axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, positive
from omma.base.directions import normalized
from omma.eye.facets import set_facets
from omma.eye.relaxation import Bools, Domain, Progress, Region, grown, started
from omma.eye.surfaces import Surface

Floats = NDArray[np.float64]
NormalOf = Callable[[Floats], Floats]
AxisAt = Callable[[Floats, Floats], ArrayLike]

_PIECE = 4096  # directions whose positions are looked for at once


@checked
def eye_on_surface(
    directions: ArrayLike,
    surface: Surface,
    *,
    normal: NormalOf | None = None,
    acceptance_ratio: float = 1.0,
    eye_id: int = 0,
    progress: Progress | None = None,
) -> Eye:
    """The eye that looks in given directions from a surface; facets are its lenses' spacing.

    Args:
        directions: (N, 3), as from `lay_directions`; they become the axes.
        surface: `sphere`, `ellipsoid`, `mesh_surface` or `load_surface`.
        normal: the surface's normal where the ommatidium of a direction sits, as a function of
            directions (K, 3) to vectors (K, 3), as `squeezed` makes; None: the direction itself.
        acceptance_ratio: acceptance angle as a multiple of the local interommatidial angle.
        progress: called as progress(stage, finished fraction or None) now and then.

    Raises:
        omma.Error: directions, normals or a ratio that are none; several lenses at one position, as
            on a mesh without curvature.
    """
    axes = _vectors(directions, "directions")
    normals = axes if normal is None else _vectors(normal(axes), "normal", len(axes))
    tell = progress or (lambda stage, fraction: None)
    positions = []
    # In pieces, so that progress is told and Ctrl-C heard.
    for start in range(0, len(axes), _PIECE):
        tell("placing ommatidia", start / len(axes))
        positions.append(surface.point_of_normal(normals[start : start + _PIECE]))
    tell("measuring neighbours", None)
    return _finished(Eye(np.concatenate(positions), axes, 0.0, 0.0, eye_id), acceptance_ratio)


@checked
def squeezed(towards: ArrayLike, factor: float) -> NormalOf:
    """A skew for `eye_on_surface`: the surface's normal is ``factor`` times as far from the
    direction ``towards`` as the axis. With 0.6, an eye that sees 180° spans 108° on its surface.

    Raises:
        omma.Error: a direction that is none, a factor that is not above 0.
    """
    centre = _vectors(np.atleast_2d(array_of(towards, "towards")), "towards", 1)[0]
    positive(factor, "factor")

    def normal(directions: Floats) -> Floats:
        along = directions @ centre
        across = directions - along[:, None] * centre
        size = np.linalg.norm(across, axis=1)
        angle = factor * np.arctan2(size, along)
        # Towards and away there is no way across; the angle's sine is 0 towards.
        across /= np.maximum(size, 1e-300)[:, None]
        return np.asarray(np.cos(angle)[:, None] * centre + np.sin(angle)[:, None] * across)

    return normal


@checked
def squeeze_for_skew(
    directions: ArrayLike,
    surface: Surface,
    towards: ArrayLike,
    median_rad: float,
    *,
    centre_m: ArrayLike | None = None,
) -> float:
    """The factor with which `squeezed` gives a median skew: of the angle between axis and surface
    normal or, with ``centre_m``, between axis and position from there.

    Raises:
        omma.Error: no factor from 0.02 to 1 gives it; the message says what they give.
    """
    axes = _vectors(directions, "directions")
    positive(median_rad, "median_rad")

    def median(factor: float) -> float:
        normals = squeezed(towards, factor)(axes)
        positions = normals
        if centre_m is not None:
            positions = normalized(
                surface.point_of_normal(normals) - array_of(centre_m, "centre_m", (3,))
            )
        return float(np.median(angle_between(axes, positions)))

    factors = np.linspace(1.0, 0.02, 50)
    medians = np.array([median(factor) for factor in factors])
    above = medians >= median_rad
    change = np.flatnonzero(above[1:] != above[:-1])
    if len(change) == 0:
        raise Error(
            f"median_rad: expected {math.degrees(medians.min()):.3g} to "
            f"{math.degrees(medians.max()):.3g}°, which is what squeezing gives here, found "
            f"{math.degrees(median_rad):.4g}°"
        )
    # The one that squeezes least.
    low, high = factors[change[0]], factors[change[0] + 1]
    low_is_above = bool(above[change[0]])
    for _ in range(40):
        middle = (low + high) / 2
        if (median(middle) >= median_rad) == low_is_above:
            low = middle
        else:
            high = middle
    return float((low + high) / 2)


@checked
def skew_rad(
    eye: Eye, *, centre_m: ArrayLike = (0.0, 0.0, 0.0), surface: Surface | None = None
) -> Floats:
    """The angle (N,) between each axis and the position seen from ``centre_m`` (by default the
    origin, an eye's or a head's middle), or the normal of ``surface`` where it is given.

    Raises:
        omma.Error: an ommatidium at the centre.
    """
    position = eye.position_m.astype(np.float64)
    if surface is not None:
        across = surface.normals(surface.onto(position))
    else:
        across = position - array_of(centre_m, "centre_m", (3,))
        if not np.linalg.norm(across, axis=1).all():
            raise Error("skew_rad: an ommatidium sits at the centre, so it has no direction")
    return angle_between(eye.axis.astype(np.float64), across)


def angle_between(first: Floats, second: Floats) -> Floats:
    """Angles (K,) between vectors (K, 3), rad."""
    # Near 0 the cosine alone would lose half the digits.
    across = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(across, np.sum(first * second, axis=1)))


@checked
def lay_on_surface(
    surface: Surface,
    spacing_m: float | Callable[[Floats], ArrayLike],
    *,
    inside: Callable[[Floats], ArrayLike] | None = None,
    count: int | None = None,
    axis: AxisAt | None = None,
    acceptance_ratio: float = 1.0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Eye:
    """An eye of lenses in a hexagonal lattice over a surface; whole facets up to where it ends.

    Args:
        spacing_m: distance between neighbours, so the facets' diameter: a number or a function of
            points on the surface (K, 3), metres, to (K,) metres.
        inside: where on the surface the eye is, a function of points (K, 3) to truth values (K,);
            None: all over.
        count: how many, exactly; the distances are all multiplied by what that takes. None: as
            many as they make.
        axis: viewing directions as a function of points (K, 3) and outward normals there (K, 3) to
            vectors (K, 3); None: the normals.
        acceptance_ratio: acceptance angle as a multiple of the local interommatidial angle.
        seed, progress: as for `lay_directions`.

    Raises:
        omma.Error: an argument out of range, a spacing too wide for the surface.
    """
    random, tell = started(count, seed, progress)
    scale = 1.0

    def spacing(points: Floats) -> Floats:
        return scale * _spacings(spacing_m, points)

    def sees(points: Floats) -> Bools:
        seen = np.ones(len(points), bool)
        if inside is not None:
            given = np.asarray(inside(points))
            if given.shape != (len(points),) or given.dtype != np.bool_:
                raise Error(
                    f"inside: expected truth values of shape ({len(points)},), found "
                    f"{given.dtype} of shape {given.shape}"
                )
            seen = given
        edge = surface.to_edge(points)
        # Facets reach half a spacing beyond their middle.
        return seen if edge is None else seen & (edge >= 0.5 * spacing(points))

    def metric(points: Floats) -> Floats:
        normals = surface.near(points)[1]
        # Across the axis that the normal is furthest from.
        least = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
        first = normalized(np.cross(normals, least))
        both = np.stack([first, np.cross(normals, first)], axis=1)
        return np.asarray(both / spacing(points)[:, None, None])

    samples, area = surface.samples(200_000)
    total = 0.0
    # How much of the surface whole facets cover depends on their size.
    for _ in range(4):
        fraction = area * 2 / (math.sqrt(3) * spacing(samples) ** 2)
        within = sees(samples)
        total = float(fraction[within].sum())
        if total < 2:
            raise Error(f"spacing_m: too wide, the surface holds {total:.2g} such facets")
        if count is None or abs(total / count - 1) < 1e-4:
            break
        scale *= math.sqrt(total / count)
    wanted = count or round(total)
    if len(samples) < 10 * wanted:
        samples, area = surface.samples(20 * wanted)
        fraction = area * 2 / (math.sqrt(3) * spacing(samples) ** 2)
        within = sees(samples)
    closed = bool(within.all())
    region = Region(sees, metric, samples, within)
    outside = None if closed else region.outside
    domain = Domain(lambda points: surface.near(points)[0], metric, outside, samples, fraction)
    points = grown(domain, wanted, random, partial(tell, "placing ommatidia"))
    if not closed:
        points = region.deepest(points, wanted)
    points = surface.onto(points)
    normals = surface.normals(points)
    axes = normals if axis is None else _vectors(axis(points, normals), "axis", len(points))
    return _finished(Eye(points, axes, 0.0), acceptance_ratio)


def _finished(eye: Eye, acceptance_ratio: float) -> Eye:
    positive(acceptance_ratio, "acceptance_ratio")
    return set_facets(
        eye.replace(acceptance_angle_rad=acceptance_ratio * eye.interommatidial_angle_rad())
    )


def _spacings(spacing_m: float | Callable[[Floats], ArrayLike], points: Floats) -> Floats:
    values = array_of(spacing_m(points) if callable(spacing_m) else spacing_m, "spacing_m")
    if values.ndim == 0:
        values = np.full(len(points), float(values))
    if values.shape != (len(points),):
        raise Error(f"spacing_m: expected shape ({len(points)},), found {values.shape}")
    if not np.all(np.isfinite(values) & (values > 0)):
        raise Error("spacing_m: expected lengths above 0")
    return values


def _vectors(values: ArrayLike, name: str, count: int | None = None) -> Floats:
    vectors = array_of(values, name)
    if vectors.ndim != 2 or vectors.shape[1] != 3 or (count is not None and len(vectors) != count):
        wanted = "N" if count is None else count
        raise Error(f"{name}: expected shape ({wanted}, 3), found {vectors.shape}")
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    if not np.all(np.isfinite(size) & (size > 0)):
        raise Error(f"{name}: expected finite vectors that are not 0")
    return np.asarray(vectors / size)
