"""Random dots that turn around the head, and stars that it flies through."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from omma._core import Error, Instance, Material, Mesh, Scene
from omma.base.arguments import array_of, whole, within
from omma.base.values import value_class
from omma.scene.paint import painted_scene
from omma.stimuli.checks import angle_deg, angular_speed, keep, length_m, name_of, radiance_of
from omma.stimuli.gaussian import Floats, caps_share
from omma.stimuli.shapes import (
    SPHERE_RADIUS_M,
    drifted,
    facing_origin,
    polygon,
    polygon_radius_m,
)
from omma.stimuli.stimulus import Stimulus, as_times

_MOST = 100_000
# Corners of a dot and of a star.
_CORNERS = 32


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class RandomDots(Stimulus):
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
        keep(
            self,
            count=whole(self.count, "count", 1, _MOST),
            diameter_deg=within(self.diameter_deg, "diameter_deg", 1e-3, 90.0),
            speed_deg_s=angular_speed(self.speed_deg_s, "speed_deg_s"),
            direction_deg=angle_deg(self.direction_deg, "direction_deg"),
            seed=whole(self.seed, "seed", 0, (1 << 63) - 1),
            dot=radiance_of(self.dot, "dot"),
            background=radiance_of(self.background, "background"),
            name=name_of(self.name, "name"),
        )

    @property
    def coverage(self) -> float:
        """Share of the sphere that dots cover, on average over seeds."""
        of_one = (1 - np.cos(np.radians(self.diameter_deg) / 2)) / 2
        return float(1 - (1 - of_one) ** self.count)

    @cached_property
    def _centres(self) -> Floats:
        """Directions (n, 3) in the pattern's frame."""
        drawn = np.random.default_rng(self.seed).normal(size=(self.count, 3))
        return np.asarray(drawn / np.linalg.norm(drawn, axis=1, keepdims=True))

    def _transforms(self, times_s: Floats) -> Floats:
        return drifted(self._drift_deg(times_s), self.direction_deg)[:, None]

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        centres = self._centres_at(time_s)
        half = np.full(self.count, np.radians(self.diameter_deg) / 2)
        on_dot = _on_any(directions, centres, half)
        return np.where(on_dot, self.dot, self.background)

    def _centres_at(self, time_s: float) -> Floats:
        turn = drifted(self._drift_deg(np.array([time_s])), self.direction_deg)[0, :3, :3]
        return np.asarray(self._centres @ turn.T)

    def _drift_deg(self, times_s: Floats) -> Floats:
        return np.asarray(np.mod(self.speed_deg_s * times_s, 360.0))

    def _expected(self, axes: Floats, acceptance_rad: Floats, times_s: Floats) -> Floats:
        half = np.full(self.count, np.radians(self.diameter_deg) / 2)
        covered = [
            _covered(axes, acceptance_rad, self._centres_at(time_s), half) for time_s in times_s
        ]
        shares = np.array(covered).reshape(len(times_s), len(axes))
        return np.asarray(self.background + (self.dot - self.background) * shares)

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
class Starfield(Stimulus):
    """Discs that float in a cube around the head, each facing it, and move past it all alike: what
    flying straight ahead looks like. A star that leaves the cube on one side comes in on the other.

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
        velocity = array_of(self.velocity_m_s, "velocity_m_s", (3,))
        if not (np.abs(velocity) <= 1e6).all():
            raise Error(f"velocity_m_s: expected -1e6 to 1e6, found {velocity.tolist()}")
        cube = length_m(self.cube_m, "cube_m")
        keep(
            self,
            count=whole(self.count, "count", 1, _MOST),
            radius_m=within(self.radius_m, "radius_m", 1e-6, cube / 4),
            velocity_m_s=tuple(velocity.tolist()),
            cube_m=cube,
            seed=whole(self.seed, "seed", 0, (1 << 63) - 1),
            star=radiance_of(self.star, "star"),
            background=radiance_of(self.background, "background"),
            name=name_of(self.name, "name"),
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
        found = []
        for time_s in times_s:
            directions, distance = self._seen(time_s)
            found.append(facing_origin(directions, distance))
        return np.array(found).reshape(len(found), self.count, 4, 4)

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        centres, distance = self._seen(time_s)
        half = np.arctan2(self.radius_m, distance)
        on_star = _on_any(directions, centres, half)
        return np.where(on_star, self.star, self.background)

    def _seen(self, time_s: float) -> tuple[Floats, Floats]:
        """Directions to the stars, (count, 3), and how far they are, (count,), m."""
        positions = self.positions_m(time_s)
        # One that were in the very middle would have no direction.
        distance = np.maximum(np.linalg.norm(positions, axis=1), 1e-9 * self.cube_m)
        ahead = np.array([0.0, 0.0, -1.0])
        inside = distance <= 1e-9 * self.cube_m
        directions = np.where(inside[:, None], ahead, positions / distance[:, None])
        return directions, distance

    def _expected(self, axes: Floats, acceptance_rad: Floats, times_s: Floats) -> Floats:
        covered = []
        for time_s in times_s:
            centres, distance = self._seen(time_s)
            half = np.arctan2(self.radius_m, distance)
            covered.append(_covered(axes, acceptance_rad, centres, half))
        shares = np.array(covered).reshape(len(times_s), len(axes))
        return np.asarray(self.background + (self.star - self.background) * shares)

    def _scene(self) -> Scene:
        flat, triangles = polygon(polygon_radius_m(self.radius_m, _CORNERS), _CORNERS)
        return Scene(
            meshes=[Mesh(flat, triangles, name=self.name, material=0)],
            instances=[Instance(0, name=name) for name in self.names],
            materials=[Material(self.name, base_color=(*(self.star,) * 3, 1.0), double_sided=True)],
        )


def _covered(
    axes: Floats, acceptance_rad: Floats, centres: Floats, half_rad: Floats
) -> list[float]:
    """The share of each ommatidium's sensitivity that falls on discs: N."""
    return [
        caps_share(axis, width, centres, half_rad)
        for axis, width in zip(axes, acceptance_rad, strict=True)
    ]


def _on_any(directions: Floats, centres: Floats, half_rad: Floats) -> Floats:
    """Whether directions (..., 3) meet any of the discs."""
    flat = directions.reshape(-1, 3)
    found = np.zeros(len(flat), bool)
    for centre, cosine in zip(centres, np.cos(half_rad), strict=True):
        found |= flat @ centre > cosine
    return found.reshape(directions.shape[:-1])
