"""Single rays that ask a world where its surfaces are.

An eye whose ommatidia take one ray each is a bundle of rays; ground truth says how far each went
and what it met. Single-sided surfaces are met from their front only.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Eye, merge_eyes
from omma.base.arrays import Floats
from omma.rendering.call import Call
from omma.rendering.renderer import Renderer
from omma.rendering.settings import Fixed
from omma.rendering.truth import groups_of_shares
from omma.scene.world import World
from omma.scene.world_names import check_named, names_in

# Most surfaces that a vertical line is followed through.
LAYERS = 256
_PIECE = 4096  # positions in one render
_MOST_M = 0.05


@dataclass(frozen=True)
class Met:
    """What rays met first."""

    distance_m: Floats
    """(P, N), infinite where nothing was."""
    normal: Floats
    """(P, N, 3), in the world, on the side that the ray came from."""
    is_wanted: NDArray[np.bool_]
    """(P, N), whether it is one of the instances asked for."""


def ray_bundle(
    world: World, directions: ArrayLike, starts_m: ArrayLike | None = None, threads: int = 0
) -> Renderer:
    """One ray for each direction (N, 3), from (N, 3), m, in the head."""
    axis = np.asarray(directions, dtype=np.float64)
    start = np.zeros_like(axis) if starts_m is None else np.asarray(starts_m, np.float64)
    # Made small and enlarged where an eye of that size would be warned of, as no animal has it; by
    # a power of two, which rounds nothing.
    largest = float(np.abs(start).max(initial=0.0))
    size = 2.0 ** np.ceil(np.log2(largest / _MOST_M)) if largest > _MOST_M else 1.0
    eye = Eye(start / size, axis, 0.0)
    whole = eye if size == 1 else merge_eyes([(eye, np.diag([size, size, size, 1.0]))])
    return Renderer(world, whole, Fixed(1), threads=threads)


def names_of_ground(world: World, on: str | Sequence[str]) -> Sequence[str]:
    """Names of what is ground, each once, as callers say it: several or one; omma.Error where
    nothing is called so, TypeError of what are no names."""
    asked = tuple(on) if isinstance(on, Iterable) and not isinstance(on, str) else (on,)
    if not all(isinstance(name, str) for name in asked):
        raise TypeError(f"on: expected names of instances, found {on!r:.40}")
    names = names_in(world) if asked else []
    for name in asked:
        check_named(names, name, "on")
    return tuple(dict.fromkeys(asked))


def shoot(rays: Renderer, poses: Floats, on: Sequence[str] = ()) -> Met:
    """What a bundle meets from poses (P, 4, 4), and whether that is one of the instances named;
    without names all is wanted."""
    distance, normal, wanted = [], [], []
    asked: dict[str, Any] = {}
    if len(on) > 0:
        asked["share_of_instance"] = groups_of_shares(rays.world, on)[1]
    for first in range(0, len(poses), _PIECE):
        call = Call.of(rays, poses[first : first + _PIECE], {}, None)
        found = {name: np.empty(call.size, np.float32) for name in ("met", "nearest_m")}
        found["normal"] = np.empty((*call.size, 3), np.float32)
        if len(on) > 0:
            found["shares"] = np.empty((*call.size, len(on)), np.float32)
        responses = {"responses": call.new_frames().responses}
        call.quiet().render_truth(responses | found | asked)
        distance.append(found["nearest_m"].astype(np.float64))
        normal.append(found["normal"].astype(np.float64))
        wanted.append(found["shares"].sum(axis=-1) > 0 if len(on) > 0 else found["met"] > 0)
    return Met(np.concatenate(distance), np.concatenate(normal), np.concatenate(wanted))


def first_below(
    down: Renderer, start_m: Floats, step_m: ArrayLike, on: Sequence[str] = ()
) -> tuple[Floats, Floats]:
    """Heights (P,), m, and normals (P, 3) of the first surface straight below (P, 3), m, that is of
    the instances named, through whatever is above it; NaN where there is none.

    Args:
        down: a bundle of one ray down.
        step_m: (P,) or one for all: how far below a surface the ray goes on.
    """
    height, normal = np.full(len(start_m), np.nan), np.full((len(start_m), 3), np.nan)
    position, step = start_m.copy(), np.broadcast_to(step_m, len(start_m))
    left = np.arange(len(start_m))
    for _ in range(LAYERS):
        if len(left) == 0:
            break
        seen = shoot(down, upright(position[left]), on)
        distance = seen.distance_m[:, 0]
        met = np.isfinite(distance)
        found = met & seen.is_wanted[:, 0]
        at = position[left, 1] - distance
        height[left[found]] = at[found]
        normal[left[found]] = seen.normal[found, 0]
        position[left, 1] = np.where(met, at - step[left], 0)
        left = left[met & ~found]
    return height, normal


def upright(positions_m: Floats) -> Floats:
    """Poses (P, 4, 4) of heads that are not turned."""
    poses = np.tile(np.eye(4), (len(positions_m), 1, 1))
    poses[:, :3, 3] = positions_m
    return poses
