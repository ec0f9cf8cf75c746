"""Ommatidia on surfaces: directions given and positions found, or positions given and axes found.

Real eyes are skewed (`omma.eye.skew`). Here that is a function of its own: from the direction to
the normal at a position, or from a position to the axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Flags, Floats
from omma.base.directions import angle_of_chord, normalized
from omma.base.progress import Stage
from omma.base.warn import warn_caller
from omma.eye.facets import set_facets
from omma.eye.relaxation import Domain, Region, grown, started
from omma.eye.skew import NormalOf, vectors_of
from omma.eye.surfaces import Surface

AxisAt = Callable[[Floats, Floats], ArrayLike]

_PIECE = 4096  # directions whose positions are looked for at once
# As of `lay_directions`.
_MOST = 200_000
# Where a surface has a normal that points in a direction, the one found is closer to it: on meshes
# of ellipsoids six times as long as wide 1.2 degrees off at most.
_ASTRAY_RAD = math.radians(2)


@checked
def eye_on_surface(
    directions: ArrayLike,
    surface: Surface,
    *,
    normal: NormalOf | None = None,
    acceptance_ratio: float = 1.0,
    eye_id: int = 0,
    progress: Stage | None = None,
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

    Warns:
        UserWarning: normals that no part of a mesh has; those ommatidia sit where its normal is the
            nearest.
    """
    axes = vectors_of(directions, "directions")
    normals = axes if normal is None else vectors_of(normal(axes), "normal", len(axes))
    tell = progress or (lambda stage, fraction: None)
    positions = []
    # In pieces, so that progress is told and Ctrl-C heard.
    for start in range(0, len(axes), _PIECE):
        tell("placing lenses on the surface", start / len(axes))
        positions.append(surface.point_of_normal(normals[start : start + _PIECE]))
    _tell_of_astray(normals, surface.normals(np.concatenate(positions)))
    tell("measuring neighbours", None)
    return _finished(Eye(np.concatenate(positions), axes, 0.0, 0.0, eye_id), acceptance_ratio)


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
    progress: Stage | None = None,
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
        omma.Error: an argument out of range, a spacing too wide for the surface or so narrow that
            there would be more than 200,000 lenses; ``inside`` holds nothing of the surface.
    """
    random, tell = started(count, seed, progress)
    scale = 1.0

    def spacing(points: Floats) -> Floats:
        return scale * _spacings(spacing_m, points)

    def sees(points: Floats) -> Flags:
        seen = np.ones(len(points), bool) if inside is None else _inside(inside, points)
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
    if inside is not None and not _inside(inside, samples).any():
        raise Error(f"inside: holds none of {len(samples):,} points all over the surface")
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
    if wanted > _MOST:
        raise Error(
            f"spacing_m: expected at most {_MOST:,} facets, found {total:.3g}: the surface has "
            f"{area.sum() * 1e6:.3g} mm² of which they would be "
            f"{spacing(samples).min() * 1e6:.3g} µm or more wide; is one of them in another unit?"
        )
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
    axes = normals if axis is None else vectors_of(axis(points, normals), "axis", len(points))
    return _finished(Eye(points, axes, 0.0), acceptance_ratio)


def _tell_of_astray(wanted: Floats, found: Floats) -> None:
    """Tell the caller of the package of normals that a surface has nowhere."""
    off = angle_of_chord(np.linalg.norm(normalized(wanted) - found, axis=1))
    astray = int((off > _ASTRAY_RAD).sum())
    if astray:
        warn_caller(
            f"eye_on_surface: no normal of the surface points as {astray:,} of {len(off):,} "
            "directions want it; those ommatidia sit where it is nearest, up to "
            f"{math.degrees(off.max()):.3g}° off",
            UserWarning,
        )


def _inside(inside: Callable[[Floats], ArrayLike], points: Floats) -> Flags:
    given = np.asarray(inside(points))
    if given.shape != (len(points),) or given.dtype != np.bool_:
        raise Error(
            f"inside: expected truth values of shape ({len(points)},), found {given.dtype} of "
            f"shape {given.shape}"
        )
    return given


def _finished(eye: Eye, acceptance_ratio: float) -> Eye:
    positive(acceptance_ratio, "acceptance_ratio")
    return set_facets(
        eye.replace(acceptance_angle_rad=acceptance_ratio * eye.interommatidial_angle_rad())
    )


def _spacings(spacing_m: float | Callable[[Floats], ArrayLike], points: Floats) -> Floats:
    given = spacing_m(points) if callable(spacing_m) else spacing_m
    values = array_of(given, "spacing_m", [(), (len(points),)])
    if not np.all(np.isfinite(values) & (values > 0)):
        raise Error("spacing_m: expected lengths above 0")
    return values + np.zeros(len(points))
