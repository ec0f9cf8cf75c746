"""How a body stands: the ground under its legs, found by rays straight down, and the plane through
it."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.motion.ground_rays import first_below, ray_bundle, shoot, upright
from omma.scene.world import World

# How far up and down a leg reaches, in distances of the farthest leg from the middle: 63 degrees of
# slope.
_REACH = 2.0
# Rounding of coordinates in single precision, as a share of them, with room for a few.
_ROUNDING = 2.0**-21
_BOUNDS: WeakKeyDictionary[World, Floats | None] = WeakKeyDictionary()
# Where coordinates are smaller than this, m, they are rounded as if they were not.
_LEAST_M = 1e-3
# Normals of one plane differ by less.
_SAME_NORMAL = 2e-6


class Below:
    """Asks a world for the ground under legs (L, 2), m, to the right and ahead."""

    def __init__(self, world: World, legs: Floats, from_m: float | None, on: Sequence[str]) -> None:
        self.world, self.legs, self.on = world, legs, on
        self.top = _top_of(world) if from_m is None else float(from_m)
        if not np.isfinite(self.top):
            raise Error(f"from_m: expected a finite number, found {from_m!r:.40}")
        self.reach_m = _REACH * float(np.hypot(*legs.T).max())
        self._origin = _traced_origin(world)
        self._down = ray_bundle(world, [[0, -1, 0]])
        self._starts = np.column_stack([legs[:, 0], np.zeros(len(legs)), -legs[:, 1]])
        self._all = ray_bundle(world, np.tile([[0, -1, 0]], (len(legs), 1)), self._starts)

    def look(self, points: Floats, start_m: Floats, yaw: Floats) -> tuple[Floats, Floats]:
        """Heights (P, L), m, and normals (P, L, 3) of what is first below (P,), m."""
        # Where rays start is a number of single precision in their frame: distances are from it.
        start = self._origin[1] + (start_m - self._origin[1]).astype(np.float32).astype(np.float64)
        poses = upright(np.column_stack([points[:, 0], start, points[:, 1]]))
        cos, sin = np.cos(yaw), np.sin(yaw)
        poses[:, 0, 0], poses[:, 0, 2], poses[:, 2, 0], poses[:, 2, 2] = cos, -sin, sin, cos
        seen = shoot(self._all, poses, self.on)
        height, normal = start[:, None] - seen.distance_m, seen.normal
        height[~np.isfinite(height)] = np.nan
        pose, leg = np.nonzero(np.isfinite(height) & ~seen.is_wanted)
        if len(pose):
            again = np.einsum("pij,pj->pi", poses[pose, :3, :3], self._starts[leg])
            again += poses[pose, :3, 3]
            step = rounding_m(self.world, again)
            again[:, 1] = height[pose, leg] - step
            height[pose, leg], normal[pose, leg] = first_below(self._down, again, step, self.on)
        return height, normal


def rounding_m(world: World, position_m: Floats) -> Floats:
    """(P,), m: more than what rays lose of positions (P, 3), in single precision."""
    size = np.abs(position_m - _traced_origin(world)).max(axis=-1)
    return np.asarray(_ROUNDING * np.maximum(size, _LEAST_M))


def standing(below: Below, points: Floats, yaw: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Heights of feet (P,), m, normals (P, 3), and which legs have ground (P, L - 1)."""
    top = np.full(len(points), below.top)
    coarse, _ = below.look(points, top, yaw)
    middle = _middle_height(coarse, below.reach_m)
    has_any = np.isfinite(middle)
    level = np.where(has_any, middle, 0)
    error = rounding_m(below.world, np.column_stack([points[:, 0], level, points[:, 1]]))
    error += _ROUNDING * (top - level)
    reach = below.reach_m + error
    height, normal = below.look(points, np.minimum(level + reach, top), yaw)
    is_near = has_any[:, None] & (np.abs(height - level[:, None]) <= reach[:, None])
    height[~is_near] = np.nan
    is_found = is_near[:, 1:]
    foot, up, is_plane = _fitted(below.legs[1:], height[:, 1:], yaw)
    flat, is_flat = _one_plane(below.legs, height, normal, yaw, error)
    up[is_flat] = flat[is_flat]
    own = ~is_plane
    foot[own], up[own] = height[own, 0], normal[own, 0]
    up[own & ~normal[:, 0].any(axis=1)] = 0, 1, 0  # upright on a splat
    return np.fmax(foot, height[:, 0]), up, is_found


def _middle_height(height: Floats, reach_m: float) -> Floats:
    """(P,), m: the ground in the middle of legs' grounds (P, L), or, where that is a hole, the
    highest of those that more than half of the legs share."""
    middle, legs = height[:, 0], height[:, 1:]
    beside = (np.abs(legs[:, :, None] - legs[:, None, :]) <= reach_m).sum(axis=2)
    shared = np.where(2 * beside > legs.shape[1], legs, -np.inf).max(axis=1)
    shared[~np.isfinite(shared)] = np.nan
    is_hole = np.isnan(middle) | (middle < shared - reach_m)
    return np.where(is_hole, shared, middle)


def _fitted(legs: Floats, height: Floats, yaw: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """The plane through legs' grounds (P, L), m, by least squares: its height below the head (P,),
    its normal (P, 3) in the world, and whether there is one."""
    size = float(np.abs(legs).max())
    rows = np.column_stack([np.ones(len(legs)), legs / size])
    on = np.isfinite(height)
    normals_of = np.einsum("pl,li,lj->pij", on, rows, rows)
    is_plane = (on.sum(axis=1) >= 3) & (np.linalg.det(normals_of) > 1e-6)
    normals_of[~is_plane] = np.eye(3)
    base = np.where(on, height, 0).sum(axis=1) / np.maximum(on.sum(axis=1), 1)
    moments = np.einsum("pl,li->pi", np.where(on, height - base[:, None], 0), rows)
    found = np.linalg.solve(normals_of, moments[:, :, None])[:, :, 0]
    right, ahead = found[:, 1] / size, found[:, 2] / size
    cos, sin = np.cos(yaw), np.sin(yaw)
    up = np.column_stack([-right * cos - ahead * sin, np.ones(len(yaw)), ahead * cos - right * sin])
    return base + found[:, 0], up, is_plane


def _one_plane(
    legs: Floats, height: Floats, normal: Floats, yaw: Floats, error_m: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """The mean normal (P, 3) of the grounds (P, L), and whether all lie in one plane with it, to
    within ``error_m`` (P,): triangles know it to more digits than heights that rays have rounded,
    where a stance is small and far from the origin. Splats have no normals, and so no such plane.
    """
    on = np.isfinite(height)
    number = np.maximum(on.sum(axis=1), 1)
    all_normals = np.where(on[:, :, None], normal, 0)
    mean = all_normals.sum(axis=1) / number[:, None]
    apart = np.where(on[:, :, None], np.abs(normal - mean[:, None]), 0).max(axis=(1, 2))
    cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    right, ahead = legs[:, 0], legs[:, 1]
    x, z = right * cos + ahead * sin, right * sin - ahead * cos
    steep = np.maximum(mean[:, 1:2], 1e-6)
    offset = height + (mean[:, 0:1] * x + mean[:, 2:3] * z) / steep
    spread = np.where(on, offset, -np.inf).max(axis=1) - np.where(on, offset, np.inf).min(axis=1)
    is_known = np.linalg.norm(mean, axis=1) > 0.5  # else 0: those of one plane are of length 1
    return mean, is_known & (apart <= _SAME_NORMAL) & (spread <= 2 * error_m)


def bounds_of(world: World) -> Floats | None:
    """Lower and upper corner (2, 3), m, of the world's scene, which never change; found once, as
    all vertices are read for it."""
    if world not in _BOUNDS:
        _BOUNDS[world] = world.scene.bounds
    return _BOUNDS[world]


def _traced_origin(world: World) -> Floats:
    """(3,), m: from where the engine traces, in single precision (src/model/scene_place.cpp)."""
    bounds = bounds_of(world)
    if bounds is None:
        return np.zeros(3)
    middle = np.asarray(bounds.mean(axis=0))
    half, distance = 0.5 * float(np.ptp(bounds, axis=0).max()), float(np.abs(middle).max())
    if distance <= 4 * half:
        return np.zeros(3)
    step = 2.0 ** np.floor(np.log2(max(half, distance * 2.0**-20)))
    return np.asarray(np.round(middle / step) * step)


def _top_of(world: World) -> float:
    """A y, m, above everything in a world, also of what has moved or has another shape."""
    scene, bounds = world.scene, bounds_of(world)
    boxes = [] if bounds is None else [bounds]
    for mesh in world._engine.reshaped:
        shape = world._engine.positions(mesh)
        local = np.stack([shape.min(axis=0), shape.max(axis=0)])
        boxes += [
            _moved_box(local, one.world_from_mesh) for one in scene.instances if one.mesh == mesh
        ]
    if not boxes:
        raise Error("no ground: the scene has no surfaces")
    rest = np.stack([np.min(boxes, axis=(0, 1)), np.max(boxes, axis=(0, 1))])
    tops, instances = [rest[1, 1]], world.instances if world._moved else []
    for index, before in world._moved.items():
        by = instances[index].world_from_node @ np.linalg.inv(before)
        tops.append(_moved_box(rest, by)[1, 1])
    return float(max(tops)) + max(1e-3, 1e-3 * float(np.ptp(rest, axis=0).max()))


def _moved_box(box: Floats, transform: Floats) -> Floats:
    corners = np.array([[*np.choose(k, box)] for k in np.ndindex(2, 2, 2)])
    placed = corners @ transform[:3, :3].T + transform[:3, 3]
    return np.stack([placed.min(axis=0), placed.max(axis=0)])
