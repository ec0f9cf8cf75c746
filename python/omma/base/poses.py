"""Poses ``world_from_head`` in all the forms they come in: matrices, quaternions, angles, files.

The head looks along its -Z, +X is its right, +Y up (glTF's camera frame); lengths are metres.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Camera, Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.base.dlpack import as_numpy
from omma.base.tables import HEADINGS, TIMES, check_growing, read_table, say_units
from omma.base.warn import warn_caller

Matrices = NDArray[np.float64]

QUATERNION_COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")
# Kinds of NumPy's types that would become numbers by chance, or would lose something.
_NO_NUMBERS = {
    "b": "True or False",
    "c": "complex numbers",
    "S": "texts",
    "U": "texts, of which a renderer takes one, a camera's name",
    "O": "objects",
    "M": "dates",
    "m": "durations",
}
ANGLE_COLUMNS = ("x", "y", "z", "yaw_deg", "pitch_deg", "roll_deg")
# Quarter turns in radians as people type them, 1.57 or 1.571, and eighths: 0.785.
_TYPED_RAD = np.array(
    [round(k * np.pi / 2, digits) for k in range(1, 5) for digits in (2, 3)]
    + [round(k * np.pi / 4, 3) for k in range(1, 8, 2)]
)
# Further from 1 a quaternion's length is no rounding, as of three digits.
_ROUNDED = 0.01


def numbers(values: Any, name: str, columns: int) -> Matrices:
    """``values`` as float64 (P, columns); a single row is one pose."""
    given = array_of(values, name)
    rows = given[None] if given.ndim == 1 else given
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise Error(f"{name}: expected shape (P, {columns}) or ({columns},), found {given.shape}")
    if not np.isfinite(rows).all():
        bad = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
        raise Error(f"{name}: expected finite numbers, found {rows[bad].tolist()} in row {bad}")
    return rows


@checked
def look_at(
    position_m: ArrayLike, target_m: ArrayLike, up: ArrayLike = (0.0, 1.0, 0.0)
) -> Matrices:
    """The pose of a head at a position (3,), m, that looks towards a target (3,), m: (4, 4).

    Args:
        up: (3,), what is roughly up.

    Example:
        >>> omma.look_at((0, 1, 0), (0, 1, -5))[:3, 3].tolist()
        [0.0, 1.0, 0.0]

    Raises:
        omma.Error: the target is the position, or ``up`` is along the view, as it is by itself
            where a head looks straight up or down.
    """
    try:
        return _core.look_at(position_m, target_m, up)
    except Error as problem:
        if "along the view" not in str(problem) or not np.any(up):
            raise
        view = np.subtract(target_m, position_m)
        side = int(np.sign(view[1]))
        other = "up=(0, 1, 0)"
        if np.hypot(view[0], view[2]) < 1e-6 * abs(view[1]):
            # As of a head that has lifted or lowered its view from straight ahead.
            other = f"up=(0, 0, {side}), or poses_from_angles(position_m, (0, {90 * side}, 0))[0]"
        raise Error(
            f"up: expected a direction across the view, found {np.asarray(up).tolist()} along it; "
            f"give another one, as {other}"
        ) from None


@checked
def poses_from_quaternions(positions_m: ArrayLike, quaternions: ArrayLike) -> Matrices:
    """Poses (P, 4, 4) from positions (P, 3), m, and quaternions (P, 4) in the order x, y, z, w.

    The quaternion turns head directions into world directions; it is normalised. One position or
    one quaternion serves for all.

    Raises:
        omma.Error: a wrong shape, a number that is not finite, a quaternion of length 0.

    Warns:
        UserWarning: a quaternion's length is further from 1 than 0.01.
    """
    turns = numbers(quaternions, "quaternions", 4)
    warn_of_lengths(turns, lambda row: f"quaternions, row {row}")
    return _from_quaternions(positions_m, turns)


def warn_of_lengths(quaternions: Matrices, where: Callable[[int], str]) -> None:
    """Warns of quaternions (P, 4) that are further from length 1 than rounding takes them, as other
    columns would be; ``where`` names the place of a row."""
    with np.errstate(over="ignore"):
        length = np.linalg.norm(quaternions, axis=1)
    odd = np.flatnonzero((np.abs(length - 1) > _ROUNDED) & (length > 0))
    if not len(odd):
        return
    more = f", and in {len(odd) - 1:,} more" if len(odd) > 1 else ""
    warn_caller(
        f"{where(int(odd[0]))}: expected a quaternion of length 1, found one of length "
        f"{length[odd[0]]:.4g}{more}; it is normalised",
        UserWarning,
    )


def _from_quaternions(positions_m: ArrayLike, turns: Matrices) -> Matrices:
    positions = numbers(positions_m, "positions_m", 3)
    length = np.linalg.norm(turns, axis=1, keepdims=True)
    if not (length > 0).all():
        row = int(np.flatnonzero(length[:, 0] == 0)[0])
        raise Error(f"quaternions: row {row} has length 0")
    x, y, z, w = (turns / length).T
    rotation = np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=-1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=-1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )
    return _matrices(positions, rotation, "quaternions")


@checked
def poses_from_angles(positions_m: ArrayLike, yaw_pitch_roll_deg: ArrayLike) -> Matrices:
    """Poses (P, 4, 4) from positions (P, 3), m, and yaw, pitch, roll (P, 3) in degrees.

    Yaw turns to the right (0 looks along -Z, 90 along +X), then pitch lifts the view, then roll
    lowers the right side: R = Ry(-yaw) Rx(pitch) Rz(-roll). One row serves for all.

    Example:
        >>> # A quarter turn to the right: the head's -Z, where it looks, is the world's +X.
        >>> poses = omma.poses_from_angles((0, 1, 0), (90, 0, 0))
        >>> poses[0, :3, 2].round(6).tolist()
        [-1.0, 0.0, 0.0]

    Raises:
        omma.Error: a wrong shape or a number that is not finite.

    Warns:
        UserWarning: the angles look like radians.
    """
    positions = numbers(positions_m, "positions_m", 3)
    angles_deg = numbers(yaw_pitch_roll_deg, "yaw_pitch_roll_deg", 3)
    warn_of_radians(angles_deg, "yaw_pitch_roll_deg")
    yaw, pitch, roll = np.radians(angles_deg).T
    zero, one = np.zeros_like(yaw), np.ones_like(yaw)

    def matrix(*entries: Matrices) -> Matrices:
        return np.stack(entries, axis=-1).reshape(-1, 3, 3)

    cy, sy, cp, sp, cr, sr = *_cos_sin(yaw), *_cos_sin(pitch), *_cos_sin(roll)
    turn = matrix(cy, zero, -sy, zero, one, zero, sy, zero, cy)
    lift = matrix(one, zero, zero, zero, cp, -sp, zero, sp, cp)
    tilt = matrix(cr, sr, zero, -sr, cr, zero, zero, zero, one)
    return _matrices(positions, turn @ lift @ tilt, "yaw_pitch_roll_deg")


def warn_of_radians(angles_deg: Matrices, name: str) -> None:
    """Warns of angles (P, A), of which the first turn all around, that look like radians: all
    within a turn, and multiples of an eighth of a turn or, where there are many, spread over all of
    it; or nothing but such multiples of two or three decimals."""
    size = np.abs(angles_deg)
    if not size.size or size.max() > 2 * np.pi + 1e-6:
        return
    quarters = size / (np.pi / 4)
    is_quarter = (quarters > 0.5) & (np.abs(quarters - np.round(quarters)) < 1e-4)
    is_typed = (np.abs(size[..., None] - _TYPED_RAD) < 1e-6).any(axis=-1)
    if (is_typed | (size == 0)).all():
        is_quarter |= is_typed
    turned = angles_deg[:, 0]
    all_around = len(turned) >= 8 and np.ptp(turned) > 0.85 * 2 * np.pi
    if is_quarter.any():
        seen = float(angles_deg[is_quarter][0])
    elif all_around:
        seen = float(turned.max())
    else:
        return
    warn_caller(
        f"{name}: expected degrees, found {seen:.5g} and nothing beyond "
        f"{size.max():.4g}; {seen:.5g} radians would be {np.degrees(seen):.4g}",
        UserWarning,
    )


@checked
def load_poses(path: str | os.PathLike[str]) -> Matrices:
    """Poses (P, 4, 4) from a CSV file, one a line.

    The first line names the columns: either ``x,y,z,qx,qy,qz,qw`` (quaternion, see
    `poses_from_quaternions`) or ``x,y,z,yaw_deg,pitch_deg,roll_deg`` (see `poses_from_angles`);
    x, y, z are the head's position in metres in the scene's frame. Times in seconds, ``t_s``, that
    grow may be a column too; `omma.render_file` keeps them. Empty lines, and what follows a
    ``#``, are passed over.

    Example:
        >>> omma.load_poses(omma.examples.flight()).shape
        (120, 4, 4)

    Raises:
        omma.Error: the file cannot be read, or a line is wrong; it names the line.

    Warns:
        UserWarning: a quaternion's length is further from 1 than 0.01, with the line; the angles
            look like radians.
    """
    return load_timed_poses(path)[0]


def load_timed_poses(path: str | os.PathLike[str]) -> tuple[Matrices, Floats | None]:
    """As `load_poses`, and when they are (P,), s, where the file has ``t_s``."""
    plain = (QUATERNION_COLUMNS, ANGLE_COLUMNS)
    headers = [*plain, *(("t_s", *columns) for columns in plain)]
    columns, table, lines = read_table(path, headers, "pose", remedy=_remedy)
    times_s = None
    if columns[0] == "t_s":
        times_s, table, columns = table[:, 0], table[:, 1:], columns[1:]
        check_growing(os.fsdecode(path), times_s, lines)
    if columns == QUATERNION_COLUMNS:
        nowhere = np.flatnonzero(~table[:, 3:].any(axis=1))
        if len(nowhere):
            line = lines[nowhere[0]]
            raise Error(f"{os.fsdecode(path)}, line {line}: the quaternion has length 0")
        name = os.fsdecode(path)
        warn_of_lengths(table[:, 3:], lambda row: f"{name}, line {lines[row]}")
        return _from_quaternions(table[:, :3], table[:, 3:]), times_s
    return poses_from_angles(table[:, :3], table[:, 3:]), times_s


def _remedy(columns: tuple[str, ...]) -> str:
    """What to do about a file whose columns are called otherwise."""
    names = {one: "t_s" for one in TIMES} | {one: one for one in "xyz"}
    if not {*QUATERNION_COLUMNS[3:]} <= {*columns}:
        names |= {one: "yaw_deg" for one in ("yaw", *HEADINGS)}
        names |= {one: f"{one}_deg" for one in ("pitch", "roll")}
    return say_units(columns, names)


def as_poses(poses: Any, first: int = 0) -> Matrices:
    """``poses`` as C-contiguous float64 (P, 4, 4): matrices, or (positions, quaternions).

    ``first`` is the number of the first one, for messages.
    """
    if is_position_pair(poses):
        return poses_from_quaternions(*poses)
    poses = as_numpy(poses, "poses")
    expected = "poses: expected (P, 4, 4) or (4, 4) matrices world_from_head"
    if isinstance(poses, Camera):
        raise Error(
            f"{expected}, found a camera; its .world_from_camera is one, and renderers take its "
            f"name, {poses.name!r}"
        )
    try:
        found = np.asarray(poses)
    except (TypeError, ValueError):
        raise Error(f"{expected}, found rows of different lengths") from None
    if found.dtype.kind in _NO_NUMBERS:
        raise Error(f"{expected}, found {_NO_NUMBERS[found.dtype.kind]}: {poses!r:.60}")
    given = np.asarray(found, dtype=np.float64, order="C")
    matrices = given[None] if given.ndim == 2 else given
    if matrices.ndim != 3 or matrices.shape[1:] != (4, 4):
        raise Error(f"{expected}, found shape {given.shape}")
    bad = np.flatnonzero((matrices[:, 3] != (0, 0, 0, 1)).any(axis=1))
    if bad.size:
        found = matrices[bad[0], 3].tolist()
        if not np.isfinite(found).all():
            raise Error(f"poses: pose {first + bad[0]} is not finite, its last row is {found}")
        raise Error(
            f"poses: pose {first + bad[0]} has the last row {found}, expected [0, 0, 0, 1] "
            "(the translation belongs into the last column)"
        )
    return matrices


def as_pose(pose: Any, name: str) -> Matrices:
    """One pose (4, 4), in any form that `as_poses` takes; omma.Error names the argument."""
    try:
        poses = as_poses(pose)
    except Error as error:
        raise Error(f"{name}: {error}") from None
    if len(poses) != 1:
        raise Error(f"{name}: expected one pose (4, 4), found {len(poses)}")
    one: Matrices = poses[0]
    return one


def is_position_pair(poses: Any) -> bool:
    """Whether ``poses`` is (positions (P, 3), quaternions (P, 4)), not two matrices."""
    if not isinstance(poses, tuple) or len(poses) != 2:
        return False
    try:
        return bool(np.shape(as_numpy(poses[0], "poses"))[-1:] == (3,))
    except ValueError:  # rows of different lengths
        return False


def _cos_sin(angle: Matrices) -> tuple[Matrices, Matrices]:
    return np.cos(angle), np.sin(angle)


def _matrices(positions: Matrices, rotation: Matrices, name: str) -> Matrices:
    count = max(len(positions), len(rotation))
    if len(positions) not in (1, count) or len(rotation) not in (1, count):
        raise Error(
            f"{name}: expected as many rows as positions_m, found {len(rotation)} for "
            f"{len(positions)} positions"
        )
    result = np.zeros((count, 4, 4))
    result[:, :3, :3] = rotation
    result[:, :3, 3] = positions
    result[:, 3, 3] = 1
    return result
