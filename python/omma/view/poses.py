"""The head's pose as the page keeps it: numbers short enough to be written into a command."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of
from omma.base.poses import look_at, poses_from_angles
from omma.base.values import value_class

Matrix = NDArray[np.float64]

_METRES, _DEGREES = 6, 4  # decimals that are kept: micrometres, a third of an arc second
# Nearer to straight up or down a point to look at says nothing of where the head's own up is.
_STEEP_DEG = 89.0
_FARTHEST_M = 1e6

# Steps and small turns, as keys and buttons make them.
WAYS = {
    "ahead": (1, 0, 0), "back": (-1, 0, 0), "left": (0, -1, 0), "right": (0, 1, 0),
    "up": (0, 0, 1), "down": (0, 0, -1),
}  # fmt: skip
_STEP_DEG = 3.0
# Beyond, left and right change places.
_STEEPEST_DEG = 89.0


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class HeadPose:
    """Where the head is and how it is turned, as the numbers that a command line or a file says.

    Rounded to micrometres and ten thousandths of a degree, so that what is shown is what these
    numbers give. Yaw turns to the right, pitch lifts the view, roll lowers the right side.

    Raises:
        omma.Error: numbers that are not finite, a position 1,000 km and more away.
    """

    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0

    def __post_init__(self) -> None:
        position = array_of(self.position_m, "position_m", (3,))
        angles = array_of([self.yaw_deg, self.pitch_deg, self.roll_deg], "angles", (3,))
        if not np.isfinite(angles).all():
            raise Error(f"pose: expected finite angles, found {angles.tolist()}")
        if not np.isfinite(position).all() or np.abs(position).max() > _FARTHEST_M:
            raise Error(
                f"pose: expected a position within {_FARTHEST_M:g} m, found {position.tolist()}"
            )
        # Adding 0 makes 0 of -0, which would be another text.
        x, y, z = (np.round(position, _METRES) + 0.0).tolist()
        object.__setattr__(self, "position_m", (x, y, z))
        for name, angle in zip(("yaw_deg", "pitch_deg", "roll_deg"), angles.tolist(), strict=True):
            object.__setattr__(self, name, round((angle + 180) % 360 - 180, _DEGREES) + 0.0)

    @property
    def target_m(self) -> tuple[float, float, float] | None:
        """The point 1 m ahead, by which a level head's pose is said; None of one that rolls or
        looks straight up or down."""
        if self.roll_deg != 0 or abs(self.pitch_deg) > _STEEP_DEG:
            return None
        yaw, pitch = np.radians([self.yaw_deg, self.pitch_deg])
        ahead = [np.sin(yaw) * np.cos(pitch), np.sin(pitch), -np.cos(yaw) * np.cos(pitch)]
        x, y, z = (np.round(np.add(self.position_m, ahead), _METRES) + 0.0).tolist()
        return x, y, z

    @property
    def world_from_head(self) -> Matrix:
        """(4, 4), m: exactly what ``omma render`` makes of the same numbers."""
        target = self.target_m
        if target is not None:
            return look_at(self.position_m, target)
        angles = (self.yaw_deg, self.pitch_deg, self.roll_deg)
        matrix: Matrix = poses_from_angles(self.position_m, angles)[0]
        return matrix


def pose_from_matrix(world_from_head: ArrayLike) -> HeadPose:
    """The pose nearest to a transform (4, 4), m, whose scale is left out."""
    matrix = array_of(world_from_head, "world_from_head", (4, 4), finite=True)
    columns = matrix[:3, :3]
    length = np.linalg.norm(columns, axis=0)
    if not (length > 0).all():
        raise Error("world_from_head: expected a transform that does not flatten")
    turn = columns / length
    ahead = -turn[:, 2]
    yaw = np.arctan2(ahead[0], -ahead[2])
    pitch = np.arcsin(np.clip(ahead[1], -1, 1))
    level = poses_from_angles((0, 0, 0), np.degrees([yaw, pitch, 0.0]))[0, :3, :3]
    tilt = level.T @ turn
    yaw_deg, pitch_deg, roll_deg = np.degrees([yaw, pitch, np.arctan2(tilt[0, 1], tilt[0, 0])])
    x, y, z = matrix[:3, 3].tolist()
    return HeadPose((x, y, z), float(yaw_deg), float(pitch_deg), float(roll_deg))


def quaternion_wxyz(matrix: Matrix) -> tuple[float, float, float, float]:
    """The turn of a transform, as viser takes it: w, x, y, z."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(matrix[:3, :3]).as_quat().tolist()
    return w, x, y, z


def matrix_from_wxyz(wxyz: ArrayLike, position_m: ArrayLike) -> Matrix:
    """(4, 4), of what viser says."""
    from scipy.spatial.transform import Rotation

    w, x, y, z = np.asarray(wxyz, np.float64)
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
    matrix[:3, 3] = np.asarray(position_m, np.float64)
    return matrix


def stepped(pose: HeadPose, way: str, step_m: float) -> HeadPose:
    """The pose a step away: ahead, back, left, right, up, down."""
    ahead, right, up = (step_m * one for one in WAYS[way])
    return moved(pose, ahead, right, up)


def turned_aside(pose: HeadPose, side: str) -> HeadPose:
    """The pose turned a little to the left or to the right."""
    return turned(pose, -_STEP_DEG if side == "left" else _STEP_DEG, 0.0)


def turned(pose: HeadPose, yaw_deg: float, pitch_deg: float) -> HeadPose:
    """The pose turned to the right and up, never beyond the vertical."""
    # A pose that is steeper already stays so until it is turned back.
    most = max(_STEEPEST_DEG, abs(pose.pitch_deg))
    pitch = min(max(pose.pitch_deg + pitch_deg, -most), most)
    return HeadPose(pose.position_m, pose.yaw_deg + yaw_deg, pitch, pose.roll_deg)


def moved(
    pose: HeadPose, ahead_m: float = 0.0, right_m: float = 0.0, up_m: float = 0.0
) -> HeadPose:
    """The pose some way ahead and to the right, as the head is turned, and up in the world."""
    matrix = pose.world_from_head
    step = matrix[:3, :3] @ np.array([right_m, 0.0, -ahead_m]) + np.array([0.0, up_m, 0.0])
    x, y, z = (np.array(pose.position_m) + step).tolist()
    return HeadPose((x, y, z), pose.yaw_deg, pose.pitch_deg, pose.roll_deg)
