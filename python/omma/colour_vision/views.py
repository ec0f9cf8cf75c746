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
    standard error of that, from the rays. ``enough``: whether rays have met the target. ``eye``: of
    the ommatidia that look."""

    eye: Eye
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

    def at(self, distance_m: float) -> Seen:
        """What they see from this distance between the target's middle and the head's origin."""


class View:
    """A whole eye that looks at a target."""

    def __init__(self, whole: Eye, diameter_m: float, direction: Floats) -> None:
        self._whole, self._diameter_m = whole, diameter_m
        widths_rad = _widths_rad(whole)
        self._widest_rad = float(widths_rad.max())
        # A receptor of width 0 is one ray, and catches nothing.
        self._narrowest_rad = float(np.min(widths_rad[widths_rad > 0], initial=math.inf))
        self._direction = direction
        self._position_m = whole.position_m.astype(np.float64)
        # Lenses lie so far from the middle of the head, from where they see the target elsewhere.
        self._beside_m = float(np.max(np.sqrt(np.sum(self._position_m**2, axis=1))))
        self._axis = receptor_axis(whole).astype(np.float64)
        self._ommatidium = ommatidium_of_receptor(whole)
        self._far_off_rad = self._off_axis_rad(np.broadcast_to(direction, (len(whole), 3)))
        # What turns the target's direction in the head's frame to -Z.
        self._ahead_from_head = _looking(direction).T

    def farthest_m(self) -> float:
        """From where its edges are still seen in their places."""
        return _FARTHEST * self._diameter_m

    def settled_m(self) -> float:
        """From where on no ommatidium sees more of it the farther it is. Nearer, an axis that looks
        beside it may come upon it, as the lens's place counts for less with the distance."""
        # A Gaussian of width w that looks 3 w beside it gains by b/d what it loses by 1/d², where
        # b/d is w/(12 ln 2).
        return 4 * _WIDTHS * math.log(2) * self._beside_m / self._narrowest_rad

    def nearest(self, count: int, distance_m: float) -> NDArray[np.intp]:
        """The ommatidia that look nearest to its middle at this distance, each from where its lens
        is, or all, if there are fewer."""
        towards = distance_m * self._direction - self._position_m
        length = np.sqrt(np.sum(towards**2, axis=1, keepdims=True))
        towards = np.divide(towards, length, out=np.zeros_like(towards), where=length > 0)
        return np.sort(np.argsort(self._off_axis_rad(towards), kind="stable")[:count])

    def reached(self, nearest_m: float) -> NDArray[np.intp]:
        """The ommatidia that see anything of it at this distance or beyond; at least one."""
        reach = max(self._reach_rad(nearest_m), float(self._far_off_rad.min()))
        return np.flatnonzero(self._far_off_rad <= reach)

    def is_reached(self, nearest_m: float) -> bool:
        """Whether any ommatidium sees anything of it."""
        return bool(self._far_off_rad.min() <= self._reach_rad(nearest_m))

    def _off_axis_rad(self, towards: Floats) -> Floats:
        """How far from a direction of its own (N, 3) each ommatidium's nearest receptor looks."""
        cosine = np.sum(self._axis * towards[self._ommatidium], axis=1)
        nearest = np.full(len(self._whole), np.pi)
        np.minimum.at(nearest, self._ommatidium, np.arccos(np.clip(cosine, -1, 1)))
        return nearest

    def _reach_rad(self, nearest_m: float) -> float:
        if nearest_m <= self._beside_m:
            return math.pi
        half = math.atan2(self._diameter_m / 2, nearest_m - self._beside_m)
        return half + _WIDTHS * self._widest_rad + math.asin(self._beside_m / nearest_m)

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


class Nearest:
    """At each distance those ommatidia that look nearest to the target there."""

    def __init__(self, view: View, count: int, sampling: Fixed, seed: int) -> None:
        self._view, self._count = view, count
        self._sampling, self._seed = sampling, seed
        self._known: dict[bytes, Looking] = {}

    def at(self, distance_m: float) -> Seen:
        """What they see from this distance; the same ommatidia always by the same rays."""
        which = self._view.nearest(self._count, distance_m)
        key = which.tobytes()
        if key not in self._known:
            self._known[key] = self._view.through(which, self._sampling, self._seed)
        return self._known[key].at(distance_m)


def _widths_rad(eye: Eye) -> Floats:
    own = [one.acceptance.mean_width_rad for one in eye.receptor_types if one.acceptance]
    return np.append(eye.acceptance_angle_rad.astype(np.float64), own)
