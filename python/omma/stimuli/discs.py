"""Discs that face the head: one that looms, and a small target that flies along a path."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Scene
from omma.base.arguments import array_of
from omma.base.arrays import Floats
from omma.base.slips import warn_of_slip
from omma.base.values import value_class
from omma.scene.solids import disc
from omma.stimuli.checks import Check, check_fields, length_m, radiance_of
from omma.stimuli.discs_seen import Discs
from omma.stimuli.shapes import directions_of, facing_origin, polygon_radius_m
from omma.stimuli.stimulus import as_times, one_or_more_times

# Of the polygon that is a disc, whose area is the circle's.
_CORNERS = 256
# Of a path on a sphere: in the middle of a chord a target is 4e-4 nearer, and looks as much larger.
_CHORD_RAD = np.radians(3.0)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class LoomingDisc(Discs):
    """A disc that comes straight at the head with a constant speed, and so appears to explode.

    Its angular size is θ(t) = 2 atan(l/v / (t_c - t)), with half its width l, its speed v and the
    time of collision t_c (Gabbiani, Krapp & Laurent 1999, J Neurosci 19:1122). It stops when it is
    as large as ``largest_deg``, and stays.

    Args:
        l_over_v_s: half its width over its speed, s.
        collision_s: when it would meet the head.
        largest_deg: angular size at which it stops.
        azimuth_deg, elevation_deg: where it comes from.
        half_width_m: l; from the middle of the head one sees only l/v.
        disc: its radiance.
        background: radiance behind it.
        name: of the thing that moves.

    Example:
        >>> disc = omma.stimuli.LoomingDisc(l_over_v_s=0.05, collision_s=1.0)
        >>> disc.size_deg([0.0, 0.95]).round(2).tolist()
        [5.72, 90.0]

    Raises:
        omma.Error: a parameter out of its range.

    Warns:
        UserWarning: an l/v above 10 s, or a collision more than 60 s away from time 0.
    """

    l_over_v_s: float = 0.05
    collision_s: float = 1.0
    largest_deg: float = 120.0
    azimuth_deg: float = 0.0
    elevation_deg: float = 0.0
    half_width_m: float = 0.1
    disc: float = 0.0
    background: float = 0.5
    name: str = "disc"

    def __post_init__(self) -> None:
        check_fields(
            self,
            l_over_v_s=(1e-6, 1e6),
            collision_s=(-1e6, 1e6),
            largest_deg=(0.01, 175.0),
            half_width_m=length_m,
            disc=radiance_of,
        )
        warn_of_slip("l/v", self.l_over_v_s, "l_over_v_s")
        warn_of_slip("time of collision", self.collision_s, "collision_s")

    def size_deg(self, times_s: ArrayLike) -> Any:
        """Its angular size θ (T,), degrees, at times (T,), s; a number at one time.

        Raises:
            omma.Error: a wrong shape, or a time that is not finite.
        """
        left_s = np.maximum(self.collision_s - one_or_more_times(times_s), 0.0)
        size = 2 * np.degrees(np.arctan2(self.l_over_v_s, left_s))
        return np.minimum(size, self.largest_deg)

    def _transforms(self, times_s: Floats) -> Floats:
        distance = self.half_width_m / np.tan(np.radians(self.size_deg(times_s)) / 2)
        towards = np.broadcast_to(self._direction(), (len(distance), 3))
        return facing_origin(towards, distance)[:, None]

    @property
    def _ends_s(self) -> tuple[float, float]:
        left_s = self.l_over_v_s / np.tan(np.radians(self.largest_deg) / 2)
        return -np.inf, float(self.collision_s - left_s)

    def _bends_s(self, first_s: float, last_s: float) -> Floats:
        # It comes straight, and stops.
        _, stops = self._ends_s
        return np.array([stops] if first_s < stops < last_s else [])

    @property
    def _disc_radiance(self) -> float:
        return self.disc

    def _direction(self) -> Floats:
        return directions_of(self.azimuth_deg, self.elevation_deg)

    def _discs(self, times_s: Floats) -> Iterator[tuple[Floats, Floats]]:
        half = np.radians(self.size_deg(times_s)) / 2
        return ((self._direction()[None], one[None]) for one in half)

    def _scene(self) -> Scene:
        return _disc_scene(self.half_width_m, self.disc, self.name)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Target(Discs):
    """A small disc at a constant distance that flies along a path, on great circles from each of
    its points to the next; before the first and after the last it stays there.

    Args:
        diameter_deg: its angular size.
        path_s: (K,), times of the points of its path, which grow, s.
        azimuth_deg, elevation_deg: (K,), where it is then.
        distance_m: how far away.
        target: its radiance.
        background: radiance behind it.
        name: of the thing that moves.

    Example:
        >>> fly = omma.stimuli.Target(1.0, [0, 1], azimuth_deg=[-20, 20], elevation_deg=[0, 0])
        >>> fly.directions([0.5]).round(6).tolist()
        [[0.0, 0.0, -1.0]]

    Raises:
        omma.Error: a parameter out of its range, times that do not grow, neighbouring points that
            lie opposite to each other.
    """

    diameter_deg: float
    path_s: Floats
    azimuth_deg: Floats
    elevation_deg: Floats
    distance_m: float = 1.0
    target: float = 0.0
    background: float = 0.5
    name: str = "target"

    def __post_init__(self) -> None:
        check_fields(
            self,
            diameter_deg=(1e-3, 175.0),
            path_s=_growing_times,
            azimuth_deg=self._angles_to(3600),
            elevation_deg=self._angles_to(90),
            distance_m=length_m,
            target=radiance_of,
        )
        points = directions_of(self.azimuth_deg, self.elevation_deg)
        opposite = np.flatnonzero(np.sum(points[:-1] * points[1:], axis=1) < -1 + 1e-9)
        if opposite.size:
            first = int(opposite[0])
            raise Error(
                f"azimuth_deg: expected one way from each point to the next, found points {first} "
                f"and {first + 1} opposite to each other"
            )

    def _angles_to(self, most: int) -> Check:
        def check(value: ArrayLike, name: str) -> Floats:
            angles = _kept(array_of(value, name, self.path_s.shape))
            if not (np.abs(angles) <= most).all():
                raise Error(f"{name}: expected angles from -{most} to {most}")
            return angles

        return check

    def directions(self, times_s: ArrayLike) -> Floats:
        """Where it is: directions (T, 3) at times (T,), s; (3,) at one time.

        Raises:
            omma.Error: a wrong shape, or a time that is not finite.
        """
        given = one_or_more_times(times_s)
        return self._directions(given.ravel()).reshape(*given.shape, 3)

    def _directions(self, times_s: Floats) -> Floats:
        times = np.clip(times_s, self.path_s[0], self.path_s[-1])
        points = directions_of(self.azimuth_deg, self.elevation_deg)
        if len(points) == 1:
            return np.repeat(points, len(times), axis=0)
        before = np.clip(np.searchsorted(self.path_s, times, "right") - 1, 0, len(points) - 2)
        a, b = points[before], points[before + 1]
        share = (times - self.path_s[before]) / (self.path_s[before + 1] - self.path_s[before])
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))
        # sinc so that points at one position divide nothing by 0.
        whole = np.sinc(angle / np.pi)
        of_a = (1 - share) * np.sinc((1 - share) * angle / np.pi) / whole
        of_b = share * np.sinc(share * angle / np.pi) / whole
        return np.asarray(of_a[:, None] * a + of_b[:, None] * b)

    def _transforms(self, times_s: Floats) -> Floats:
        towards = self.directions(times_s)
        return facing_origin(towards, np.full(len(towards), self.distance_m))[:, None]

    @property
    def _ends_s(self) -> tuple[float, float]:
        return float(self.path_s[0]), float(self.path_s[-1])

    def _bends_s(self, first_s: float, last_s: float) -> Floats:
        # The points of its path, and arcs of great circles as chords.
        points = directions_of(self.azimuth_deg, self.elevation_deg)
        angles = np.arccos(np.clip(np.sum(points[:-1] * points[1:], axis=1), -1, 1))
        legs = zip(self.path_s[:-1], self.path_s[1:], angles, strict=True)
        chords = [
            np.linspace(start, end, int(angle / _CHORD_RAD) + 2)[1:-1] for start, end, angle in legs
        ]
        bends = np.sort(np.concatenate([self.path_s, *chords]))
        return bends[(bends > first_s) & (bends < last_s)]

    @property
    def _disc_radiance(self) -> float:
        return self.target

    def _discs(self, times_s: Floats) -> Iterator[tuple[Floats, Floats]]:
        half = np.array([np.radians(self.diameter_deg) / 2])
        return ((one[None], half) for one in self.directions(times_s))

    def _scene(self) -> Scene:
        radius = self.distance_m * np.tan(np.radians(self.diameter_deg) / 2)
        return _disc_scene(float(radius), self.target, self.name)


def _disc_scene(radius_m: float, radiance: float, name: str) -> Scene:
    corners = polygon_radius_m(radius_m, _CORNERS)
    return disc(corners, (radiance,) * 3, segments=_CORNERS, name=name)


def _growing_times(value: ArrayLike, name: str) -> Floats:
    times = _kept(as_times(array_of(value, name, (None,))))
    if not (len(times) and (np.diff(times) > 0).all()):
        raise Error(f"{name}: expected one or more times that grow")
    return times


def _kept(values: Floats) -> Floats:
    """A copy that nobody can write to."""
    copy = np.array(values, np.float64)
    copy.flags.writeable = False
    return copy
