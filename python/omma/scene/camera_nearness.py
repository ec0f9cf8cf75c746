"""How near cameras were to what an eye sees: distances, and angles at the point that is seen."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.base.arrays import Floats, Ints
from omma.base.directions import angle_of_chord, normalized
from omma.base.poses import Matrices
from omma.base.progress import Progress

# Of pairs of a direction and a camera that are looked at at once: arrays of them stay in the cache,
# which is eight times as fast as arrays of 8 MB.
_PAIRS = 1 << 14
_CAMERAS = 1 << 11
# What is farther is as good as infinitely far, and squares of it stay finite.
_FAR_M = 1e12


class Cameras(Protocol):
    """What is needed of `CaptureCameras`."""

    @property
    def positions_m(self) -> Floats: ...
    @property
    def world_from_camera(self) -> Floats: ...
    @property
    def half_angles_deg(self) -> Floats: ...


def nearest_distance_m(cameras_m: Floats, heads_m: Floats) -> Floats:
    """From each head (P, 3) to the nearest camera: (P,), m."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(cameras_m).query(heads_m)[0], np.float64)


def nearest_angle_deg(
    cameras: Cameras,
    eye: Eye,
    poses: Matrices,
    distances_m: Floats,
    progress: Progress | None = None,
) -> NDArray[np.float32]:
    """The least angle at what an ommatidium sees between it and a camera with that in its field:
    (P, N), NaN where there is no such camera."""
    middle = cameras.positions_m.mean(axis=0)
    groups = [*_groups(cameras, middle)]
    axis = eye.axis.astype(np.float64)
    start = eye.position_m - axis * eye.focal_offset_m[:, None]
    found = np.empty(distances_m.shape, np.float32)
    rows = max(1, _PAIRS // min(len(cameras.positions_m), _CAMERAS))
    blocks = [(p, first) for p in range(len(poses)) for first in range(0, len(eye), rows)]
    for done, (p, first) in enumerate(blocks):
        some = slice(first, first + rows)
        towards = normalized(axis[some] @ poses[p, :3, :3].T)
        origin = start[some] @ poses[p, :3, :3].T + (poses[p, :3, 3] - middle)
        distance = distances_m[p, some]
        is_far = (distance > _FAR_M)[:, None]
        # Of what is infinitely far only the direction counts, which then stands for the point.
        near = origin + np.minimum(distance, _FAR_M)[:, None] * towards
        point = np.where(is_far, towards, near)
        cosine, nearest = np.full(len(point), -np.inf), np.full(len(point), -1)
        for group in groups:
            group.better(point, towards, ~is_far, cosine, nearest)
        between = np.where(is_far, towards, point - (cameras.positions_m[nearest] - middle))
        angle = np.degrees(_angle(towards, between))
        found[p, some] = np.where(nearest < 0, np.nan, angle)
        if progress is not None:
            progress((done + 1) / len(blocks))
    return found


class _Group:
    """Some cameras whose fields are asked for in one way."""

    def __init__(self, cameras: Cameras, middle: Floats, members: Ints, is_wide: bool) -> None:
        turns = cameras.world_from_camera[members]
        self.members, self.is_wide = members, is_wide
        self.at = cameras.positions_m[members] - middle
        # Right, up and back of all cameras, one axis after the other.
        self.axes = turns.transpose(2, 0, 1).reshape(-1, 3)
        self.offset = np.einsum("cij,ci->jc", turns, self.at)
        half = np.radians(cameras.half_angles_deg[members].T)
        limits = [half[0], np.sin(np.minimum(half[1], np.pi / 2))] if is_wide else np.tan(half)
        # Not known: all that there is, of a pyramid all before the camera.
        self.width, self.height = np.where(np.isnan(half), np.inf, limits)

    def better(
        self,
        points: Floats,
        towards: Floats,
        is_near: NDArray[np.bool_],
        cosine: Floats,
        nearest: Ints,
    ) -> None:
        """Put those cameras into ``nearest`` that saw a point at a smaller angle."""
        count = len(self.members)
        across = (points @ self.axes.T).reshape(len(points), 3, count)
        across -= is_near[:, :, None] * self.offset
        x, y, depth = across[:, 0], across[:, 1], -across[:, 2]
        length = np.sqrt(x * x + y * y + depth * depth)
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.is_wide:
                seen = (np.abs(np.arctan2(x, depth)) <= self.width) & (length > 0)
                seen &= np.abs(y) <= length * self.height
            else:
                seen = (depth > 0) & (np.abs(x) <= depth * self.width)
                seen &= np.abs(y) <= depth * self.height
            along = (points * towards).sum(axis=1)[:, None] - is_near * (towards @ self.at.T)
            cosines = np.where(seen, along / length, -np.inf)
        best = cosines.argmax(axis=1)
        values = cosines[np.arange(len(points)), best]
        is_better = values > cosine
        cosine[is_better] = values[is_better]
        nearest[is_better] = self.members[best[is_better]]


def _groups(cameras: Cameras, middle: Floats) -> Iterator[_Group]:
    """Cameras with less than 180° both ways, whose fields are pyramids, and wider ones, whose
    fields are those of azimuth and elevation; each so many at most as memory is meant for."""
    is_wide = (cameras.half_angles_deg >= 90).any(axis=1)
    for wide in (False, True):
        members = np.flatnonzero(is_wide == wide)
        for first in range(0, len(members), _CAMERAS):
            yield _Group(cameras, middle, members[first : first + _CAMERAS], wide)


def _angle(one: Floats, other: Floats) -> Floats:
    """Between vectors (n, 3), rad, to all digits also where they are nearly the same."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return angle_of_chord(np.linalg.norm(normalized(one) - normalized(other), axis=1))
