"""Sets of poses: what a job says of one, and the poses with these numbers.

Pose number i of a set depends on the seed, the scene and i alone, whoever asks for it and for what
others beside it: random numbers are drawn from Philox, keyed by all that and by the attempt.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.poses import Matrices, load_poses, poses_from_angles
from omma.base.velocities import velocities_from_poses
from omma.datasets.free_space import FreeSpace
from omma.datasets.tables import Table, choices, count, name, number_above_0, numbers, span, texts
from omma.datasets.tables import text as a_text
from omma.motion.tracks import LOST, Track, load_track

SAMPLERS = ("uniform", "surface", "path", "walk", "track")

# Positions that are tried for a pose.
_TRIES = 1000
# Random numbers of an attempt at a pose: a whole number of Philox's blocks of four.
_DRAWN = 8


@dataclass(frozen=True)
class PoseSet:
    """Poses that one sampler makes. Angles are as of `omma.poses_from_angles`."""

    name: str
    sampler: str  # one of SAMPLERS
    count: int
    scenes: tuple[str, ...]  # in which it is used
    file: str = ""  # path: a CSV file of poses; track: of positions
    lost: str = "refuse"  # track: positions that lack a number
    low_m: tuple[float, ...] = ()  # uniform, walk: corners of a box (3,); surface: x and z
    high_m: tuple[float, ...] = ()
    yaw_deg: tuple[float, float] = (-180.0, 180.0)
    pitch_deg: tuple[float, float] = (0.0, 0.0)
    roll_deg: tuple[float, float] = (0.0, 0.0)
    height_m: tuple[float, float] = (0.0, 0.0)  # surface, track
    on: tuple[
        str, ...
    ] = ()  # surface, track: names of instances; none: what is met first from above
    clearance_m: float = 0.0  # from everything; 0: not asked for
    speed_m_s: tuple[float, float] = (0.0, 0.0)  # straight ahead; not path
    turn_deg_s: tuple[float, float] = (
        0.0,
        0.0,
    )  # uniform, surface: about the head's up, to the right
    steps: int = 0  # walk, track: poses of one walk
    step_s: float = 0.0  # walk, path, track: between two poses; 0: not told
    saccades_per_s: float = 0.0
    saccade_deg: tuple[float, float] = (0.0, 0.0)
    saccade_s: float = 0.0
    climb_deg: tuple[float, float] = (0.0, 0.0)

    @property
    def files(self) -> tuple[str, ...]:
        """What it is read from."""
        return (self.file,) if self.file else ()

    @property
    def is_walk(self) -> bool:
        """Whether its poses are made by whole walks."""
        return self.steps > 0

    @property
    def is_moving(self) -> bool:
        """Whether it is known how heads move at its poses."""
        return self.step_s > 0 or self.speed_m_s != (0, 0) or self.turn_deg_s != (0, 0)


def read_pose_set(table: Table, folder: Path, scenes: list[str]) -> PoseSet:
    """What a table [[poses]] says."""
    kind = table.take("sampler", choices(SAMPLERS))
    found: dict[str, Any] = {
        "name": table.take("name", name, kind),
        "sampler": kind,
        "scenes": table.take("scenes", texts, tuple(scenes)),
    }
    for one in found["scenes"]:
        choices(scenes)(one, f"{table.where}.scenes")
    if kind == "path":
        file = str(folder / table.take("file", a_text))
        found |= {"file": file, "count": len(load_poses(file))}
        found["step_s"] = table.take("step_s", number_above_0, 0.0)
        if found["step_s"] and found["count"] < 2:
            raise Error(f"{table.where}.step_s: expected two poses or more in {file}, found one")
        table.end()
        return PoseSet(**found)
    if kind == "track":
        return PoseSet(**found, **_read_track(table, folder))
    corner = numbers(2 if kind == "surface" else 3)
    low = table.take("low_m", corner)
    high = table.take("high_m", corner)
    if any(a > b for a, b in zip(low, high)):
        raise Error(f"{table.where}.high_m: expected at least low_m {list(low)}, found {high}")
    found |= {"low_m": low, "high_m": high}
    found["clearance_m"] = table.take("clearance_m", number_above_0, 0.0)
    if kind == "walk":
        walks = table.take("walks", count)
        found["steps"] = table.take("steps", count)
        found["count"] = walks * found["steps"]
        found["step_s"] = table.take("step_s", number_above_0, 0.01)
        found["speed_m_s"] = (table.take("speed_m_s", number_above_0),) * 2
        found["saccades_per_s"] = table.take("saccades_per_s", number_above_0, 1.0)
        found["saccade_deg"] = table.take("saccade_deg", span, (30.0, 120.0))
        found["saccade_s"] = table.take("saccade_s", number_above_0, 0.05)
        climb = found["climb_deg"] = table.take("climb_deg", span, (0.0, 0.0))
        if not climb[0] <= 0 <= climb[1]:
            raise Error(
                f"{table.where}.climb_deg: expected a range to draw from with level ways in it, "
                f"as [-10, 10], found {list(climb)}, by which walks leave any box"
            )
    else:
        found["count"] = table.take("count", count)
        for angle in ("yaw_deg", "pitch_deg", "roll_deg"):
            found[angle] = table.take(angle, span, getattr(PoseSet, angle))
        for rate in ("speed_m_s", "turn_deg_s"):
            found[rate] = table.take(rate, span, getattr(PoseSet, rate))
    if kind == "surface":
        found["height_m"] = table.take("height_m", span)
        found["on"] = table.take("on", texts, ())
    table.end()
    return PoseSet(**found)


def track_of(file: str, lost: str, step_s: float) -> Track:
    """A track that a file has, at equal steps of time where it has times and steps are told."""
    track = load_track(file, lost=lost)
    return track.every(step_s) if step_s and track.times_s is not None else track


def walks_of(poses: PoseSet) -> NDArray[np.int32]:
    """Which walk of its set each pose is of, (P,); -1 where poses do not follow one another."""
    if poses.is_walk:
        return (np.arange(poses.count) // poses.steps).astype(np.int32)
    return np.full(poses.count, 0 if poses.sampler == "path" else -1, np.int32)


def times_of(poses: PoseSet) -> Floats:
    """When each pose is, (P,), s from the begin of its walk, of tracks as their file says; NaN
    where that is not told."""
    if poses.sampler == "track":
        times_s = track_of(poses.file, poses.lost, poses.step_s).times_s
        if times_s is not None:
            return times_s
    if poses.step_s == 0:
        return np.full(poses.count, np.nan)
    steps = np.arange(poses.count) % (poses.steps or poses.count)
    return np.asarray(steps * poses.step_s, np.float64)


def _read_track(table: Table, folder: Path) -> dict[str, Any]:
    """What a table [[poses]] says of a track."""
    file = str(folder / table.take("file", a_text))
    step_s = table.take("step_s", number_above_0, 0.0)
    lost = table.take("lost", choices(LOST), "refuse")
    number = len(track_of(file, lost, step_s).xz_m)
    if step_s and number < 2:
        raise Error(f"{table.where}.step_s: expected two positions or more in {file}, found one")
    height_m = (table.take("height_m", number_above_0),) * 2
    found = {"file": file, "lost": lost, "count": number, "steps": number, "step_s": step_s}
    found |= {"height_m": height_m, "on": table.take("on", texts, ())}
    table.end()
    return found


def key_of(*parts: object) -> NDArray[np.uint64]:
    """A key for Philox from texts and numbers."""
    digest = hashlib.sha256("/".join(map(str, parts)).encode()).digest()
    return np.frombuffer(digest[:16], np.uint64)


def sample_poses(
    poses: PoseSet, seed: int, scene: str, numbers: range, space: FreeSpace
) -> Matrices:
    """Poses (P, 4, 4) with these numbers, of a set whose sampler is no walk.

    Raises:
        omma.Error: no free position was found for one of them.
    """
    if poses.sampler == "path":
        return load_poses(poses.file)[numbers.start : numbers.stop]
    position = np.full((len(numbers), 3), np.nan)
    angles = np.empty((len(numbers), 3))
    left = np.arange(len(numbers))
    for attempt in range(_TRIES):
        stream = np.random.Philox(key=key_of(seed, scene, poses.name, attempt))
        # A step of the counter gives four numbers.
        stream.advance(numbers.start * (_DRAWN // 4))
        drawn = np.random.Generator(stream).random((len(numbers), _DRAWN))[left]
        tried = _positions(poses, drawn, space)
        good = np.asarray(np.isfinite(tried).all(axis=1))
        if poses.clearance_m > 0:
            good[good] = space.is_free(tried[good], poses.clearance_m)
        position[left[good]] = tried[good]
        for k, (low, high) in enumerate((poses.yaw_deg, poses.pitch_deg, poses.roll_deg)):
            angles[left[good], k] = low + (high - low) * drawn[good, 4 + k]
        left = left[~good]
        if len(left) == 0:
            return poses_from_angles(position, angles)
    raise no_free_position(poses, scene, f"pose {numbers[left[0]]}", f"{_TRIES} positions tried")


def sample_velocities(
    poses: PoseSet, seed: int, scene: str, numbers: range, made: Matrices
) -> tuple[Floats, Floats]:
    """How heads move at poses (P, 4, 4) with these numbers, of a set whose sampler is no walk:
    linear (P, 3), m/s, and angular velocity (P, 3), rad/s, in the world's frame."""
    if poses.sampler == "path":
        whole = load_poses(poses.file)
        linear, angular = velocities_from_poses(whole, np.arange(len(whole)) * poses.step_s)
        return linear[numbers.start : numbers.stop], angular[numbers.start : numbers.stop]
    stream = np.random.Philox(key=key_of(seed, scene, poses.name, "velocity"))
    stream.advance(numbers.start)  # four numbers for each pose
    drawn = np.random.Generator(stream).random((len(numbers), 4))
    (slow, fast), (left, right) = poses.speed_m_s, poses.turn_deg_s
    speed = slow + (fast - slow) * drawn[:, :1]
    turn = np.radians(left + (right - left) * drawn[:, 1:2])
    # Ahead is -Z of the head; to the right is left-handed about its +Y.
    return -speed * made[:, :3, 2], -turn * made[:, :3, 1]


def no_free_position(poses: PoseSet, scene: str, which: str, tried: str) -> Error:
    """What to say where no free position is found."""
    clear = f" with clearance_m {poses.clearance_m:g}" if poses.clearance_m > 0 else ""
    where = f" on {', '.join(poses.on)}" if poses.on else ""
    return Error(
        f"poses {poses.name!r}: found no free position in scene {scene!r} for {which}{where} from "
        f"low_m {list(poses.low_m)} to high_m {list(poses.high_m)}{clear}: {tried}. Give it "
        "more space, or less clearance_m"
    )


def _positions(poses: PoseSet, drawn: Floats, space: FreeSpace) -> Floats:
    """Positions (P, 3), m, from random numbers; NaN where there is none."""
    low, high = np.array(poses.low_m), np.array(poses.high_m)
    spread: Floats = low + (high - low) * drawn[:, : len(low)]
    if poses.sampler != "surface":
        return spread
    ground = space.ground_below(spread, poses.on)
    bottom, top = poses.height_m
    above = bottom + (top - bottom) * drawn[:, 3]
    return np.column_stack([spread[:, 0], ground + above, spread[:, 1]])
