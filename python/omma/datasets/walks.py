"""Whole walks: along a track on the ground, or random ones with saccades, flights straight ahead
between fast turns of flight and gaze.

Of random ones the way turns at once, the head follows within a saccade's duration along a smooth
step, and is level. Where the way ahead is blocked, or leaves the box, a saccade begins too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats
from omma.base.poses import Matrices, poses_from_angles
from omma.base.velocities import velocities_from_poses
from omma.datasets.free_space import FreeSpace
from omma.datasets.samplers import PoseSet, key_of, no_free_position, sample_poses, track_of
from omma.motion.walking import walk_on

# New ways that are tried where the one ahead is blocked.
_TURNS = 64


def walk_poses(poses: PoseSet, seed: int, scene: str, walks: range, space: FreeSpace) -> Matrices:
    """Whole walks with these numbers, one after another: (walks * steps, 4, 4).

    Raises:
        omma.Error: a walk has no free position to begin or to go on, or a track no ground.
    """
    if poses.sampler == "track":
        track = track_of(poses.file, poses.lost, poses.step_s)
        return walk_on(space.world, track, height_m=poses.height_m[0], on=poses.on)
    begin = sample_poses(poses, seed, scene, walks, space)
    position = begin[:, :3, 3].copy()
    yaw = np.degrees(np.arctan2(-begin[:, 0, 2], begin[:, 2, 2]))
    draw = [
        np.random.Generator(np.random.Philox(key=key_of(seed, scene, poses.name, "walk", k)))
        for k in walks
    ]
    climb = np.array([one.uniform(*poses.climb_deg) for one in draw])
    turn_from, turned_s = yaw.copy(), np.full(len(walks), poses.saccade_s)
    found = np.empty((len(walks), poses.steps, 4, 4))
    for step in range(poses.steps):
        share = np.minimum(turned_s / poses.saccade_s, 1)
        gaze = turn_from + (yaw - turn_from) * share**2 * (3 - 2 * share)
        level = np.zeros_like(gaze)
        found[:, step] = poses_from_angles(position, np.column_stack([gaze, level, level]))
        if step + 1 == poses.steps:
            break
        turned_s = turned_s + poses.step_s
        chance = np.array([one.random() for one in draw])
        starts = (chance < poses.saccades_per_s * poses.step_s) & (turned_s >= poses.saccade_s)
        for k in np.flatnonzero(starts):
            side = draw[k].choice((-1.0, 1.0))
            yaw[k] = gaze[k] + side * draw[k].uniform(*poses.saccade_deg)
            climb[k] = draw[k].uniform(*poses.climb_deg)
        blocked = ~_can_go(poses, position, yaw, climb, space)
        for _ in range(_TURNS):
            if not blocked.any():
                break
            which = np.flatnonzero(blocked)
            for k in which:
                yaw[k] = gaze[k] + draw[k].uniform(-180, 180)
                climb[k] = draw[k].uniform(*poses.climb_deg)
            starts |= blocked
            blocked[which] = ~_can_go(poses, position[which], yaw[which], climb[which], space)
        if blocked.any():
            number = walks[int(np.argmax(blocked))]
            raise no_free_position(
                poses, scene, f"walk {number}, step {step + 1}", f"{_TURNS} ways tried"
            )
        turn_from[starts], turned_s[starts] = gaze[starts], 0.0
        position = _gone(poses, position, yaw, climb)
    return found.reshape(-1, 4, 4)


def walk_velocities(poses: PoseSet, made: Matrices) -> tuple[Floats, Floats]:
    """Linear (P, 3), m/s, and angular velocities (P, 3), rad/s, of heads on whole walks."""
    times_s = np.arange(poses.steps) * poses.step_s
    each = [velocities_from_poses(one, times_s) for one in made.reshape(-1, poses.steps, 4, 4)]
    return np.concatenate([one for one, _ in each]), np.concatenate([one for _, one in each])


def _gone(poses: PoseSet, position: Floats, yaw_deg: Floats, climb_deg: Floats) -> Floats:
    """Where a step leads."""
    yaw, climb = np.radians(yaw_deg), np.radians(climb_deg)
    ahead = np.column_stack(
        [np.sin(yaw) * np.cos(climb), np.sin(climb), -np.cos(yaw) * np.cos(climb)]
    )
    return np.asarray(position + poses.speed_m_s[0] * poses.step_s * ahead)


def _can_go(
    poses: PoseSet, position: Floats, yaw_deg: Floats, climb_deg: Floats, space: FreeSpace
) -> NDArray[np.bool_]:
    """Whether a step stays in the box, meets nothing and ends at a free position."""
    after = _gone(poses, position, yaw_deg, climb_deg)
    good: NDArray[np.bool_] = np.all((after >= poses.low_m) & (after <= poses.high_m), axis=1)
    if poses.clearance_m > 0 and good.any():
        angles = np.column_stack([yaw_deg, climb_deg, np.zeros_like(yaw_deg)])[good]
        length = poses.speed_m_s[0] * poses.step_s + poses.clearance_m
        ahead = space.is_clear_ahead(poses_from_angles(position[good], angles), length)
        good[good] = ahead & space.is_free(after[good], poses.clearance_m)
    return good
