"""Surfaces by their curvature, for eyes with steep foveas.

A facet of diameter D on a surface of radius of curvature R, looking along the surface's normal,
is D/R away in angle from its neighbour. Where a fovea has both large facets and small angles, the
surface is flat there: R = D/Δφ. So such an eye is made from its profile of curvature and its
facets, and the angles along and across follow.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from omma.base.arrays import Floats
from omma.base.spirals import golden_angles


class Profile:
    """A meridian of a surface, by its radius of curvature over the angle of its normal.

    The angle is that between the normal and the normal where the meridian begins; ``radius_m``
    gives the radius of curvature there.
    """

    def __init__(self, radius_m: Callable[[Floats], Floats], most_rad: float) -> None:
        self._angle = np.linspace(0.0, most_rad, 4001)
        self._radius = radius_m(self._angle)
        # Along the meridian ds = R dangle; the trapezium's error is far below a micrometre.
        self._level = self._summed(np.cos(self._angle))
        self._drop = self._summed(np.sin(self._angle))
        self._arc = self._summed(np.ones_like(self._angle))

    def _summed(self, part: Floats) -> Floats:
        slope = self._radius * part
        steps = np.diff(self._angle) * (slope[1:] + slope[:-1]) / 2
        return np.concatenate([[0.0], np.cumsum(steps)])

    def radius(self, angle_rad: Floats) -> Floats:
        """Radius of curvature of the meridian (K,), metres."""
        return np.interp(np.abs(angle_rad), self._angle, self._radius)

    def along(self, angle_rad: Floats) -> Floats:
        """How far along the plane that touches at angle 0, metres, signed."""
        level = np.interp(np.abs(angle_rad), self._angle, self._level)
        return np.asarray(np.sign(angle_rad) * level)

    def length(self, angle_rad: Floats) -> Floats:
        """Length of the meridian from angle 0, metres."""
        return np.interp(np.abs(angle_rad), self._angle, self._arc)

    def drop(self, angle_rad: Floats) -> Floats:
        """How far below that plane, metres."""
        return np.interp(np.abs(angle_rad), self._angle, self._drop)


class Revolution:
    """A surface of revolution that faces ahead (-Z) by its meridian, for `omma.eye.lay_on_surface`.

    It begins at ``tip_m`` (3,) and ends where its normal is ``most_rad`` from ahead.
    """

    def __init__(self, profile: Profile, most_rad: float, tip_m: Floats) -> None:
        from scipy.spatial import cKDTree

        self._profile = profile
        self._most = most_rad
        self._tip = tip_m
        self._angle = np.linspace(0.0, most_rad, 20_001)
        self._tree = cKDTree(self._meridian(self._angle))

    def angle(self, points: Floats) -> Floats:
        """The angle (K,) between ahead and the normal at the point nearest to points (K, 3)."""
        return self._place(points)[0]

    def onto(self, points: Floats) -> Floats:
        angle, turn = self._place(points)
        out, back = self._meridian(angle).T
        return self._around(out, back, turn)

    def normals(self, points: Floats) -> Floats:
        angle, turn = self._place(points)
        out = np.sin(angle)
        return np.stack([out * np.cos(turn), out * np.sin(turn), -np.cos(angle)], axis=1)

    def near(self, points: Floats) -> tuple[Floats, Floats]:
        return self.onto(points), self.normals(points)

    def point_of_normal(self, directions: Floats) -> Floats:
        angle = np.arctan2(np.hypot(directions[:, 0], directions[:, 1]), -directions[:, 2])
        out, back = self._meridian(np.minimum(angle, self._most)).T
        turn = np.arctan2(directions[:, 1], directions[:, 0])
        return self._around(out, back, turn)

    def samples(self, count: int) -> tuple[Floats, Floats]:
        # Rings of equal area, one sample in each, a golden angle on from the last.
        ring = self._meridian(self._angle)[:, 0] * self._profile.radius(self._angle)
        steps = np.diff(self._angle) * (ring[1:] + ring[:-1]) / 2
        area = 2 * np.pi * np.concatenate([[0.0], np.cumsum(steps)])
        fraction = (np.arange(count) + 0.5) / count * area[-1]
        out, back = self._meridian(np.interp(fraction, area, self._angle)).T
        return self._around(out, back, golden_angles(count)), np.full(count, area[-1] / count)

    def to_edge(self, points: Floats) -> Floats:
        end = self._profile.length(np.array([self._most]))
        return np.asarray(end - self._profile.length(self.angle(points)))

    def _meridian(self, angle: Floats) -> Floats:
        # Away from the axis and back from the tip, (K, 2).
        return np.stack([self._profile.along(angle), self._profile.drop(angle)], axis=1)

    def _around(self, out: Floats, back: Floats, turn: Floats) -> Floats:
        points = np.stack([out * np.cos(turn), out * np.sin(turn), back], axis=1)
        return np.asarray(self._tip + points)

    def _place(self, points: Floats) -> tuple[Floats, Floats]:
        x, y, z = (points - self._tip).T
        flat = np.stack([np.hypot(x, y), z], axis=1)
        found = self._tree.query(flat)[1]
        angle = self._angle[found]
        # From the nearest point of the table along the meridian's tangent.
        apart = flat - np.asarray(self._tree.data)[found]
        along = apart[:, 0] * np.cos(angle) + apart[:, 1] * np.sin(angle)
        angle = np.clip(angle + along / self._profile.radius(angle), 0.0, self._most)
        return angle, np.arctan2(y, x)
