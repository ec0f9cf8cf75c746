"""Eyes made to order: ommatidia spread over a sphere or an ellipsoid, evenly or with acute zones.

Points repel their neighbours on the surface until the forces balance, as in `relaxation`, but all
from the beginning: the force between two points a distance r apart, where the wanted spacing is a,
is a (a/r)^7, away from each other, and the spacing follows a. Lloyd's method weighted with a^-4 has
the same balance, but needs samples all over the surface and more steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye, expect_eye_radius
from omma.base.arguments import array_of, checked, positive, within
from omma.base.arrays import Floats
from omma.base.progress import Stage
from omma.base.slips import warn_of_slip
from omma.base.values import value_class
from omma.eye.cells import NEIGHBOURS
from omma.eye.relaxation import (
    STEPS_PER_SEARCH,
    bisected,
    limited,
    pushed,
    repulsion,
    started,
)
from omma.eye.surfaces import Ellipsoid, even_directions, stretched

Density = Callable[[Floats], ArrayLike]

_STEPS = 500
_MOST_CANDIDATES = 5_000_000


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class AcuteZone:
    """More ommatidia per steradian around a direction: ``factor`` times at its centre, falling off
    as a Gaussian of full width at half maximum ``width_rad``; a factor below 1 thins them out.

    With ``band`` the zone is all around the head at the elevation of the direction.
    Azimuth 0 is ahead and grows to the right.
    """

    azimuth_rad: float
    elevation_rad: float
    width_rad: float
    factor: float
    band: bool = False

    def __post_init__(self) -> None:
        positive(self.width_rad, "width_rad")
        positive(self.factor, "factor")
        within(self.azimuth_rad, "azimuth_rad", -math.tau, math.tau)
        within(self.elevation_rad, "elevation_rad", -math.pi / 2, math.pi / 2)
        warn_of_slip("width of an acute zone", self.width_rad, "width_rad")

    def density(self, directions: Floats) -> Floats:
        """Relative number of ommatidia per steradian at directions (K, 3), head frame: (K,)."""
        directions = array_of(directions, "directions", (None, 3))
        if self.band:
            elevation = np.arcsin(np.clip(directions[:, 1], -1, 1))
            angle = np.abs(elevation - self.elevation_rad)
        else:
            level = math.cos(self.elevation_rad)
            centre = np.array(
                [
                    level * math.sin(self.azimuth_rad),
                    math.sin(self.elevation_rad),
                    -level * math.cos(self.azimuth_rad),
                ]
            )
            angle = np.arccos(np.clip(directions @ centre, -1, 1))
        bump = np.exp(-4 * math.log(2) * (angle / self.width_rad) ** 2)
        return np.asarray(1 + (self.factor - 1) * bump)


@checked
def acute_zones(zones: Sequence[AcuteZone]) -> Density:
    """The density of several zones together: their product."""

    def density(directions: Floats) -> Floats:
        product = np.ones(len(directions))
        for zone in zones:
            product *= zone.density(directions)
        return product

    return density


@checked
def generate_eye(
    count: int,
    *,
    radius_m: float | Sequence[float] = 1e-3,
    density: Density | None = None,
    acceptance_ratio: float = 1.0,
    seed: int = 0,
    progress: Stage | None = None,
    allow_unusual: bool = False,
) -> Eye:
    """An eye of ``count`` ommatidia spread over a sphere or an ellipsoid by relaxation.

    Positions lie on the surface, axes are normal to it. Without ``density`` the ommatidia are
    spread evenly over the surface: facets of one size. With it, `radius_m` still says where they
    sit, and the density how many look where.

    Args:
        radius_m: radius of the sphere, or the three semi-axes (right, up, forward), metres.
        density: relative number of ommatidia per steradian, as a function of viewing directions:
            directions (K, 3) in the head's frame (+X right, +Y up, -Z ahead) to (K,) numbers of
            at least 0. Where it is 0 there are none.
        acceptance_ratio: acceptance angle as a multiple of the local interommatidial angle.
        seed: the same seed gives the same eye (on one machine); another one, another arrangement.
        progress: called as progress(stage, share done) now and then.
        allow_unusual: a radius beyond those of animals' eyes (1 µm to 10 cm) is meant.

    Example:
        >>> len(omma.eye.generate_eye(500))
        500

    Raises:
        omma.Error: an argument out of range, a density that is negative, not finite, 0 everywhere
            or too peaked.
    """
    random, tell = started(count, seed, progress)
    positive(acceptance_ratio, "acceptance_ratio")
    surface = _Crowded(_semi_axes(radius_m, allow_unusual), density)
    points = _seeds(surface, count, random)
    points = _relaxed(surface, points, tell)
    axes = surface.normals(points)
    spaced = Eye(points, axes, 0.0)
    return Eye(points, axes, acceptance_ratio * spaced.interommatidial_angle_rad())


class _Crowded:
    """An ellipsoid, and how many ommatidia there are to be per area of it."""

    def __init__(self, semi_axes: Floats, density: Density | None) -> None:
        self.semi_axes = semi_axes
        right, up, forward = semi_axes.tolist()
        ellipsoid = Ellipsoid((right, up, forward))
        self.onto, self.normals = ellipsoid.onto, ellipsoid.normals
        self._density = density
        self._scale = 1.0  # from relative to actual numbers per area

    def per_area(self, points: Floats) -> Floats:
        """Ommatidia per area, once `fit` has been called; until then relative."""
        if self._density is None:
            return np.full(len(points), self._scale)
        normals = self.normals(points)
        values = np.asarray(self._density(normals), dtype=np.float64)
        if values.shape != (len(points),):
            raise Error(f"density: expected shape ({len(points)},), found {values.shape}")
        if not np.all(np.isfinite(values) & (values >= 0)):
            bad = int(np.flatnonzero(~(np.isfinite(values) & (values >= 0)))[0])
            raise Error(
                f"density: expected finite numbers of at least 0, found {values[bad]} in direction "
                f"{np.round(normals[bad], 4).tolist()}"
            )
        # The Gaussian curvature is the solid angle of the normals per area.
        gradient_squared = np.sum((points / self.semi_axes**2) ** 2, axis=1)
        curvature = 1 / (np.prod(self.semi_axes) * gradient_squared) ** 2
        return np.asarray(self._scale * values * curvature)

    def fit(self, count: int, relative_total: float) -> None:
        """From now on `per_area` adds up to ``count`` over the surface."""
        self._scale = count / relative_total

    def spacing(self, points: Floats) -> Floats:
        """Distance of neighbours in the hexagonal lattice of that density; inf where there is none:
        a lattice of spacing a has 2/(√3 a²) points per area."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.sqrt(2 / math.sqrt(3) / self.per_area(points)))


def _seeds(surface: _Crowded, count: int, random: np.random.Generator) -> Floats:
    turn = _random_turn(random)
    number = 32 * count
    for _ in range(2):
        candidates, fraction = _candidates(surface, number, turn)
        total = float(fraction.sum())
        if not total > 0:
            raise Error(f"density: is 0 in all of {number:,} directions all round")
        # Four candidates to an ommatidium where they are densest.
        needed = math.ceil(number * max(1.0, 4 * float(fraction.max()) / total * count))
        if needed <= number:
            break
        if needed > max(_MOST_CANDIDATES, 4 * number):
            raise Error("density: is too peaked: nearly all ommatidia fall into one narrow spot")
        number = needed
    surface.fit(count, total)
    kept = fraction > 0
    candidates, fraction = candidates[kept], fraction[kept]
    if len(fraction) < count:
        raise Error("density: is above 0 in too narrow a spot for that many ommatidia")
    return bisected(candidates, fraction, count)


def _candidates(surface: _Crowded, number: int, turn: Floats) -> tuple[Floats, Floats]:
    points, stretch = stretched(even_directions(number) @ turn, surface.semi_axes)
    return points, surface.per_area(points) * stretch * (4 * math.pi / number)


def _relaxed(surface: _Crowded, points: Floats, tell: Stage) -> Floats:
    velocity = np.zeros_like(points)
    spacing = surface.spacing(points)
    for step in range(_STEPS):
        if step % STEPS_PER_SEARCH == 0:
            neighbours = _nearest(points, spacing, min(NEIGHBOURS, len(points) - 1))
            tell("placing ommatidia", step / _STEPS)
        apart = points[:, None, :] - points[neighbours]
        wanted = 0.5 * (spacing[:, None] + spacing[neighbours])
        _, strength = repulsion(np.einsum("nkc,nkc->nk", apart, apart) / wanted**2)
        force = np.einsum("nkc,nk->nc", apart, strength)
        velocity = pushed(velocity, force, surface.normals(points))
        velocity = limited(velocity, np.linalg.norm(velocity, axis=1), spacing)
        moved = surface.onto(points + velocity)
        new_spacing = surface.spacing(moved)
        stays = ~np.isfinite(new_spacing)  # there is to be no ommatidium
        moved[stays], velocity[stays], new_spacing[stays] = points[stays], 0, spacing[stays]
        points, spacing = moved, new_spacing
    tell("placing ommatidia", 1.0)
    return points


def _nearest(points: Floats, spacing: Floats, count: int) -> NDArray[np.int64]:
    # Indices of the nearest by distance over the sum of both wanted spacings, (N, count), in no
    # order: by one spacing alone points of a sparse region would only interact with a dense one's.
    # Neighbours in the array are neighbours on the eye, so each piece is compared with what is near
    # it only.
    found = np.empty((len(points), count), dtype=np.int64)
    size = 128
    for start in range(0, len(points), size):
        piece = slice(start, min(start + size, len(points)))
        to_centre = np.linalg.norm(points - points[piece].mean(axis=0), axis=1)
        # Three spacings hold more than the two rings of a hexagonal lattice.
        near_enough = to_centre[piece].max() + 1.5 * (spacing[piece].max() + spacing)
        near = np.flatnonzero(to_centre <= near_enough)
        if len(near) <= count:
            near = np.arange(len(points))
        # Not by a product of matrices: too small for threads, which NumPy's would start.
        distance = np.zeros((piece.stop - start, len(near)))
        for axis in range(3):
            distance += (points[piece, None, axis] - points[near, axis]) ** 2
        distance /= (spacing[piece, None] + spacing[near]) ** 2
        own = np.searchsorted(near, np.arange(start, piece.stop))
        distance[np.arange(len(own)), own] = np.inf
        found[piece] = near[np.argpartition(distance, count - 1, axis=1)[:, :count]]
    return found


def _semi_axes(radius_m: float | Sequence[float], allow_unusual: bool) -> Floats:
    try:
        values = np.asarray(radius_m, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.zeros(2)
    if values.shape not in ((), (3,)) or not np.all(np.isfinite(values) & (values > 0)):
        raise Error(f"radius_m: expected one or three lengths above 0, found {radius_m!r}")
    for length in values.ravel().tolist():
        expect_eye_radius("radius_m", length, allow_unusual)
    return np.ones(3) * values


def _random_turn(random: np.random.Generator) -> Floats:
    rotation: Floats = np.linalg.qr(random.standard_normal((3, 3)))[0]
    return rotation
