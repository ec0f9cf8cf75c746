"""What readers of photographs' poses hand on, and how wide a camera's lens sees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from omma._core import Error
from omma.base.arrays import Floats

# What a matrix of a file may be off a rotation, in any of its numbers: some write three decimals.
_ROUNDED = 5e-3
# No camera is farther from zero, in the file's unit.
_MOST = 1e18
# (x right, y down, z forward), as COLMAP has it, in (x right, y up, z backward).
COLMAP_AXES = np.diag([1.0, -1.0, -1.0])
# Width and height, degrees, of what a panorama shows, and of what is not known.
ALL_ROUND = (180.0, 90.0)
UNKNOWN = (math.nan, math.nan)


@dataclass(frozen=True)
class Shot:
    """One photograph: where its camera was in the file's frame, in the file's unit."""

    name: str
    position: Floats  # (3,)
    file_from_camera: Floats  # (3, 3), which looks along its -Z with +Y up
    half_angles_deg: tuple[float, float]  # of width and height


@dataclass(frozen=True)
class Lens:
    """Size of a picture and what a camera's focal lengths are, all in pixels."""

    width: float
    height: float
    fx: float
    fy: float
    cx: float | None = None
    cy: float | None = None

    def half_angles_deg(self, is_fisheye: bool, where: str) -> tuple[float, float]:
        """Half of the field, by the side that is nearer to the principal point; what distortion
        adds is left out.

        Raises:
            omma.Error: sizes or focal lengths that are not above 0.
        """
        if not (self.width > 0 and self.height > 0 and self.fx > 0 and self.fy > 0):
            raise Error(
                f"{where}: expected a size and focal lengths above 0, found {self.width:g} x "
                f"{self.height:g} pixels, {self.fx:g} and {self.fy:g}"
            )
        angles = []
        for size, middle, focal in (
            (self.width, self.cx, self.fx),
            (self.height, self.cy, self.fy),
        ):
            half = size / 2 if middle is None else max(min(middle, size - middle), 0.0)
            angle = half / focal if is_fisheye else math.atan(half / focal)
            angles.append(min(math.degrees(angle), 180.0))
        return angles[0], angles[1]


def rotation(matrix: Floats, where: str) -> Floats:
    """The rotation nearest to a matrix (3, 3).

    Raises:
        omma.Error: none is near.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(matrix.T @ matrix - np.eye(3)).max() if np.isfinite(matrix).all() else np.inf
    if not off < _ROUNDED:
        lengths = ", ".join(f"{np.linalg.norm(column):.4g}" for column in matrix.T)
        raise Error(f"{where}: expected a rotation, found columns of the lengths {lengths}")
    if np.linalg.det(matrix) < 0:
        raise Error(f"{where}: expected a rotation, found one that mirrors")
    left, _, right = np.linalg.svd(matrix)
    return np.asarray(left @ right)


def rotation_of_quaternion(quaternion: Sequence[float], where: str) -> Floats:
    """(3, 3), of a quaternion (w, x, y, z) of any length.

    Raises:
        omma.Error: its length is 0.
    """
    from scipy.spatial.transform import Rotation

    length = math.hypot(*quaternion)
    if not 1e-12 < length < math.inf:
        raise Error(f"{where}: expected a quaternion, found one of length {length:g}")
    w, x, y, z = (one / length for one in quaternion)  # squares of a long one overflow
    rotation: Floats = Rotation.from_quat([x, y, z, w]).as_matrix()
    return rotation


def position(values: Floats, where: str) -> Floats:
    """Coordinates (3,) that can be used."""
    if not np.abs(values).max() <= _MOST:  # nor is NaN
        found = ", ".join(f"{one:g}" for one in values)
        raise Error(f"{where}: expected coordinates within {_MOST:g}, found ({found})")
    return values
