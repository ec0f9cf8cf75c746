"""How an eye looks at a target from a distance: which ommatidia see it, from where, and what comes
of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arrays import Floats
from omma.base.poses import look_at
from omma.receptors.sensitivity import ommatidium_of_receptor, receptor_axis
from omma.rendering.settings import Fixed

# Widths of an acceptance beyond which it sees nothing: a Gaussian is 1e-11 there.
_WIDTHS = 3.0
# Relative error of what the target adds to a receptor from which on its rays are too few to say how
# large it is: sixteen of them.
_TOO_FEW = 0.25
# Beyond so many diameters single precision would not have a target's edges in their places.
_FARTHEST = 1e5


@dataclass(frozen=True, eq=False)
class Seen:
    """Photons of each receptor (R,): without the target, and how many more there are with it; the
    standard error of that, from the rays. ``enough``: whether rays have met the target."""

    background: Floats
    added: Floats
    error: Floats
    enough: bool


def met(added: Floats, error: Floats) -> bool:
    """Whether enough rays have met the target, by the receptor to which it adds most."""
    most = int(np.argmax(np.abs(added)))
    return bool(added[most] != 0 and error[most] <= _TOO_FEW * abs(added[most]))


class Looking(Protocol):
    """Some ommatidia that look at a target, always by the same rays."""

    eye: Eye

    def at(self, distance_m: float) -> Seen:
        """What they see from this distance between the target's middle and the head's origin."""


class View:
    """A whole eye that looks at a target."""

    def __init__(self, whole: Eye, diameter_m: float, direction: Floats) -> None:
        self._whole, self._diameter_m = whole, diameter_m
        self._widest_rad = _widest_rad(whole)
        self._off_axis_rad = _off_axis_rad(whole, direction)
        # What turns the target's direction in the head's frame to -Z.
        self._ahead_from_head = _looking(direction).T

    def farthest_m(self) -> float:
        """From where its edges are still seen in their places."""
        return _FARTHEST * self._diameter_m

    def nearest(self, count: int) -> NDArray[np.intp]:
        """The ommatidia that look nearest to its middle, or all, if there are fewer."""
        return np.sort(np.argsort(self._off_axis_rad, kind="stable")[:count])

    def reached(self, nearest_m: float) -> NDArray[np.intp]:
        """The ommatidia that see anything of it at this distance or beyond; at least one."""
        reach = max(self._reach_rad(nearest_m), float(self._off_axis_rad.min()))
        return np.flatnonzero(self._off_axis_rad <= reach)

    def is_reached(self, nearest_m: float) -> bool:
        """Whether any ommatidium sees anything of it."""
        return bool(self._off_axis_rad.min() <= self._reach_rad(nearest_m))

    def _reach_rad(self, nearest_m: float) -> float:
        reach = math.atan2(self._diameter_m / 2, nearest_m) + _WIDTHS * self._widest_rad
        # Lenses lie beside the middle of the head, from where they see the target elsewhere.
        beside = float(np.max(np.sqrt(np.sum(self._whole.position_m**2, axis=1))))
        return reach + math.asin(min(beside / nearest_m, 1.0))

    def through(self, ommatidia: NDArray[np.intp], sampling: Fixed, seed: int) -> Looking:
        """These ommatidia, by so many rays."""
        raise NotImplementedError

    def pose_on(self, center_m: Floats, towards: Floats) -> Floats:
        """The pose of a head in the middle of a target (3,) that looks against ``towards``."""
        pose = np.eye(4)
        pose[:3, :3] = _looking(-towards) @ self._ahead_from_head
        pose[:3, 3] = center_m
        return pose


def _looking(direction: Floats) -> Floats:
    up = (0, 1, 0) if abs(direction[1]) < 0.99 else (0, 0, 1)
    return look_at((0, 0, 0), direction, up)[:3, :3]


def _widest_rad(eye: Eye) -> float:
    own = [one.acceptance.mean_width_rad for one in eye.receptor_types if one.acceptance]
    return max([float(np.max(eye.acceptance_angle_rad)), *own])


def _off_axis_rad(eye: Eye, direction: Floats) -> Floats:
    """How far from a direction the nearest receptor of each ommatidium looks: (N,)."""
    cosine = np.clip(receptor_axis(eye).astype(np.float64) @ direction, -1, 1)
    nearest = np.full(len(eye), np.pi)
    np.minimum.at(nearest, ommatidium_of_receptor(eye), np.arccos(cosine))
    return nearest
