"""Random dots that turn around the head, and stars that it flies through."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Instance, Material, Mesh, Scene
from omma.base.arguments import array_of
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.values import value_class
from omma.base.velocities import velocities_between
from omma.scene.paint import painted_scene
from omma.stimuli.checks import check_fields, length_m, radiance_of, whole_from
from omma.stimuli.discs_seen import Discs
from omma.stimuli.jumps import MOMENT_S, Motion, whole_counts
from omma.stimuli.shapes import (
    SPHERE_RADIUS_M,
    facing_origin,
    polygon,
    polygon_radius_m,
)
from omma.stimuli.stimulus import as_times
from omma.stimuli.turning import Turning

_COUNT = whole_from(1, 100_000)
# Corners of a dot and of a star.
_CORNERS = 32
# Of a cube's edge: a way on which its stars turn evenly.
_STEP = 0.005


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class RandomDots(Discs, Turning):
    """Dots all around the head, anywhere with the same chance, that turn together.

    They may lie over each other: of a sphere with n dots, each of the solid angle Ω, they cover
    1 - (1 - Ω/4π)^n on average.

    Args:
        count: n, of dots on the whole sphere.
        diameter_deg: of each.
        speed_deg_s: of their drift about the poles across its direction.
        direction_deg: where they drift as seen ahead: 0 is to the right, 90 upwards.
        seed: of their positions.
        dot: their radiance.
        background: radiance between them.
        name: of the thing that turns.

    Example:
        >>> round(omma.stimuli.RandomDots(1000, 5.0).coverage, 4)
        0.3787

    Raises:
        omma.Error: a parameter out of its range.
    """

    count: int = 500
    diameter_deg: float = 5.0
    speed_deg_s: float = 30.0
    direction_deg: float = 0.0
    seed: int = 0
    dot: float = 0.0
    background: float = 0.5
    name: str = "dots"

    def __post_init__(self) -> None:
        check_fields(self, count=_COUNT, diameter_deg=(1e-3, 90.0), dot=radiance_of)

    @property
    def coverage(self) -> float:
        """Share of the sphere that dots cover, on average over seeds."""
        of_one = (1 - np.cos(np.radians(self.diameter_deg) / 2)) / 2
        return float(1 - (1 - of_one) ** self.count)

    @cached_property
    def _centres(self) -> Floats:
        """Directions (n, 3) in the pattern's frame."""
        drawn = np.random.default_rng(self.seed).normal(size=(self.count, 3))
        return normalized(drawn)

    @property
    def _disc_radiance(self) -> float:
        return self.dot

    def _discs(self, times_s: Floats) -> Iterator[tuple[Floats, Floats]]:
        half = np.full(self.count, np.radians(self.diameter_deg) / 2)
        for transform in self._transforms(times_s)[:, 0]:
            yield self._centres @ transform[:3, :3].T, half

    def _scene(self) -> Scene:
        radius = SPHERE_RADIUS_M * np.tan(np.radians(self.diameter_deg) / 2)
        flat, triangles = polygon(polygon_radius_m(float(radius), _CORNERS), _CORNERS)
        transforms = facing_origin(self._centres, np.full(self.count, SPHERE_RADIUS_M))
        positions = flat @ np.swapaxes(transforms[:, :3, :3], 1, 2) + transforms[:, None, :3, 3]
        first = len(flat) * np.arange(self.count)
        surface = (
            positions.reshape(-1, 3),
            (triangles + first[:, None, None]).reshape(-1, 3),
            np.zeros((self.count * len(flat), 2)),
        )
        return painted_scene([("dot", surface, (self.dot,) * 3)], self.name, (0, 0, 0))


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Starfield(Discs):
    """Discs that float in a cube around the head, each facing it, and move past it all alike: what
    flying straight ahead looks like. A star that leaves the cube on one side comes in on the other,
    which is no motion for `play` and `velocities`.

    Args:
        count: of stars.
        radius_m: of each.
        velocity_m_s: (3,), of the stars in the world; (0, 0, 1) is what one sees who flies ahead at
            1 m/s.
        cube_m: length of the cube's edges; its middle is the origin.
        seed: of their positions.
        star: their radiance.
        background: radiance between them.
        name: of the stars: they are called "star 0", "star 1" and so on, each a thing that moves.

    Raises:
        omma.Error: a parameter out of its range, stars larger than the cube.
    """

    count: int = 500
    radius_m: float = 0.02
    velocity_m_s: tuple[float, float, float] = (0.0, 0.0, 1.0)
    cube_m: float = 4.0
    seed: int = 0
    star: float = 1.0
    background: float = 0.0
    name: str = "star"

    def __post_init__(self) -> None:
        check_fields(
            self,
            count=_COUNT,
            radius_m=(1e-6, length_m(self.cube_m, "cube_m") / 4),
            velocity_m_s=_velocity,
            cube_m=length_m,
            star=radiance_of,
        )

    @property
    def names(self) -> list[str]:
        """Of the stars."""
        return [f"{self.name} {number}" for number in range(self.count)]

    def positions_m(self, time_s: float) -> Floats:
        """Where the stars are at a time, s: (count, 3), m."""
        moved = self._at_start + np.array(self.velocity_m_s) * as_times([time_s])[0]
        return np.asarray(np.mod(moved + self.cube_m / 2, self.cube_m) - self.cube_m / 2)

    @cached_property
    def _at_start(self) -> Floats:
        drawn = np.random.default_rng(self.seed).random((self.count, 3))
        return np.asarray((drawn - 0.5) * self.cube_m)

    def _transforms(self, times_s: Floats) -> Floats:
        found = [facing_origin(*self._seen(time_s)) for time_s in times_s]
        return np.array(found).reshape(len(found), self.count, 4, 4)

    def _velocities(self, times_s: Floats) -> Motion:
        velocity = np.array(self.velocity_m_s)
        linear = np.empty((len(times_s), self.count, 3))
        angular = np.empty_like(linear)
        for t, time_s in enumerate(times_s):
            positions = self.positions_m(time_s)
            # Not by positions a moment later, which may be in again on the other side.
            before, after = (
                facing_origin(*self._seen_at(positions + side * MOMENT_S * velocity))
                for side in (-1, 1)
            )
            linear[t], angular[t] = velocities_between(before, after, 2 * MOMENT_S)
        return linear, angular

    def _jumps_s(self, first_s: float, last_s: float) -> Floats:
        entered = self._at_start / self.cube_m + 0.5
        rates = np.array(self.velocity_m_s) / self.cube_m
        along = zip(entered.T, rates, strict=True)
        found = [whole_counts(starts, float(rate), first_s, last_s) for starts, rate in along]
        return np.unique(np.concatenate(found))

    @property
    def _even_for_s(self) -> float:
        # On so short a way only stars that are very near turn much to face the head.
        speed = float(np.linalg.norm(self.velocity_m_s))
        return _STEP * self.cube_m / speed if speed else np.inf

    @property
    def _disc_radiance(self) -> float:
        return self.star

    def _discs(self, times_s: Floats) -> Iterator[tuple[Floats, Floats]]:
        for time_s in times_s:
            centres, distance = self._seen(time_s)
            yield centres, np.arctan2(self.radius_m, distance)

    def _seen(self, time_s: float) -> tuple[Floats, Floats]:
        """Directions to the stars, (count, 3), and how far they are, (count,), m."""
        return self._seen_at(self.positions_m(time_s))

    def _seen_at(self, positions: Floats) -> tuple[Floats, Floats]:
        # One that were in the very middle would have no direction.
        distance = np.maximum(np.linalg.norm(positions, axis=1), 1e-9 * self.cube_m)
        ahead = np.array([0.0, 0.0, -1.0])
        inside = distance <= 1e-9 * self.cube_m
        directions = np.where(inside[:, None], ahead, positions / distance[:, None])
        return directions, distance

    def _scene(self) -> Scene:
        flat, triangles = polygon(polygon_radius_m(self.radius_m, _CORNERS), _CORNERS)
        return Scene(
            meshes=[Mesh(flat, triangles, name=self.name, material=0)],
            instances=[Instance(0, name=name) for name in self.names],
            materials=[Material(self.name, base_color=(*(self.star,) * 3, 1.0), double_sided=True)],
        )


def _velocity(value: ArrayLike, name: str) -> tuple[float, ...]:
    velocity = array_of(value, name, (3,))
    if not (np.abs(velocity) <= 1e6).all():
        raise Error(f"{name}: expected -1e6 to 1e6, found {velocity.tolist()}")
    return tuple(velocity.tolist())
