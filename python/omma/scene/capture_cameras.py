"""Where a captured world was photographed from: the cameras of COLMAP, Nerfstudio and 3D Gaussian
Splatting, and how near they were to what an eye sees.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, Eye
from omma.base import mesh_parts
from omma.base.arguments import array_of, checked
from omma.base.arrays import Floats
from omma.base.files import PathLike
from omma.base.poses import as_poses
from omma.base.progress import Progress
from omma.base.values import value_class
from omma.scene.camera_nearness import nearest_angle_deg, nearest_distance_m
from omma.scene.capture_lenses import Shot, position, rotation
from omma.scene.colmap_files import colmap_files, colmap_folder, read_colmap
from omma.scene.nerfstudio_files import (
    is_splat_cameras,
    is_transforms,
    read_json,
    read_splat_cameras,
    read_transforms,
)

# What a transform may be off a rotation times a scale, relative to that.
_SIMILAR = 1e-6
_KNOWN = (
    "a folder of COLMAP, transforms.json of Nerfstudio (an object with frames) or cameras.json of "
    "3D Gaussian Splatting (a list of objects with position and rotation)"
)
# Of poses: coordinates, and lengths of their axes.
_FARTHEST_M, _LEAST_SIZE = 1e18, 1e-15


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class CaptureCameras:
    """N cameras from which a captured world is known: of its photographs, one each.

    ``positions_m`` (N, 3) and ``world_from_camera`` (N, 3, 3), rotations, are in the scene's frame,
    with +Y up, in metres; a camera looks along its -Z, its +Y is up and its +X right, as Omma's and
    glTF's do. ``half_angles_deg`` (N, 2) are half its field of view in width and height, NaN where
    that is not known; 180 and 90 are all round. ``names`` are those of the photographs, N or none,
    ``path`` is where they came from.

    Raises:
        omma.Error: no camera, shapes that do not go together, numbers that are not finite, matrices
            that are no rotations, angles beyond 0 to 180.
    """

    positions_m: Floats
    world_from_camera: Floats
    half_angles_deg: Floats
    names: tuple[str, ...] = ()
    path: str = ""

    @checked
    def __init__(
        self,
        positions_m: ArrayLike,
        world_from_camera: ArrayLike,
        half_angles_deg: ArrayLike | None = None,
        *,
        names: tuple[str, ...] = (),
        path: str = "",
    ) -> None:
        positions = array_of(positions_m, "positions_m", (None, 3))
        count = len(positions)
        if count == 0:
            raise Error("positions_m: expected a camera or more, found none")
        turns = array_of(world_from_camera, "world_from_camera", (count, 3, 3))
        angles = np.full((count, 2), np.nan)
        if half_angles_deg is not None:
            angles = array_of(half_angles_deg, "half_angles_deg", (count, 2))
        if ((angles < 0) | (angles > 180)).any():
            raise Error("half_angles_deg: expected 0 to 180, or NaN where they are not known")
        if not isinstance(names, tuple) or not all(isinstance(one, str) for one in names):
            raise TypeError(f"names: expected a tuple of texts, found {names!r:.40}")
        if len(names) not in (0, count):
            raise Error(f"names: expected {count}, one of each camera, or none, found {len(names)}")
        made: dict[str, Any] = {
            "positions_m": np.array(
                [position(one, f"positions_m[{k}]") for k, one in enumerate(positions)]
            ),
            "world_from_camera": np.array(
                [rotation(one, f"world_from_camera[{k}]") for k, one in enumerate(turns)]
            ),
            "half_angles_deg": angles.copy(),
            "names": names,
            "path": path,
        }
        for name, value in made.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.positions_m)

    @property
    def bounds(self) -> Floats:
        """Lower and upper corner of the box around all cameras: (2, 3), m."""
        return np.array([self.positions_m.min(axis=0), self.positions_m.max(axis=0)])

    @checked
    def nearness(
        self,
        eye: Eye,
        poses: ArrayLike | tuple[ArrayLike, ArrayLike],
        *,
        distance_m: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> tuple[Floats, NDArray[np.float32]]:
        """How far from an eye the nearest camera was, in place and in angle.

        The angle is that between the directions in which an ommatidium and a camera see the same
        point: p lies along the ommatidium's axis, as far from where its rays start as
        ``distance_m`` says, and of all cameras that had p in their field the one with the least
        angle at p between eye and camera counts. Where nothing is, p is infinitely far: 0 where a
        camera's field held that direction. Whether something stood between a camera and p is not
        asked. A camera whose field is not known counts as if it had seen all before it.

        Args:
            poses: (P, 4, 4) or (4, 4), or positions and quaternions, as a renderer takes them.
            distance_m: (P, N), of what each ommatidium sees, such as `GroundTruth.distance_m`;
                infinite where there is nothing. None: all is infinitely far.
            progress: called with the finished share (0 to 1). What it raises is raised here.

        Returns:
            (P,), m, from the head to the nearest camera, and (P, N), degrees, NaN where no camera
            had p in its field.

        Raises:
            omma.Error: poses that are none, distances of another shape or below 0.
        """
        matrices = as_poses(poses)
        # As far, as large and as small as the engine takes them.
        if not np.abs(matrices).max(initial=0) <= _FARTHEST_M:  # nor is NaN
            raise Error(f"poses: expected finite numbers within {_FARTHEST_M:g}")
        sizes = np.linalg.norm(matrices[:, :3, :3], axis=1)
        if not (sizes >= _LEAST_SIZE).all():
            raise Error(f"poses: expected axes of lengths above {_LEAST_SIZE:g}")
        distances = np.full((len(matrices), len(eye)), np.inf)
        if distance_m is not None:
            distances = array_of(distance_m, "distance_m", distances.shape)
        if not (distances >= 0).all():
            raise Error("distance_m: expected distances of 0 or more")
        return (
            nearest_distance_m(self.positions_m, matrices[:, :3, 3]),
            nearest_angle_deg(self, eye, matrices, distances, progress),
        )


@checked
def load_capture_cameras(
    path: PathLike,
    *,
    unit: str | float = "m",
    up: str | None = None,
    world_from_file: ArrayLike | None = None,
    undo_applied: bool = False,
) -> CaptureCameras:
    """Read where photographs were taken from, of which a world was made.

    Known are folders of COLMAP (`cameras` and `images`, as .bin or .txt, also in `sparse/0` below),
    Nerfstudio's `transforms.json` and the `cameras.json` of 3D Gaussian Splatting. Their axes are
    turned into Omma's: COLMAP and `cameras.json` have y down and z forward in the camera,
    Nerfstudio looks along -Z. The world's frame is that of the scene which was made of the same
    photographs if ``unit`` and ``up``, or ``world_from_file``, are those that the scene has.

    Args:
        path: the folder or file.
        unit: of its lengths: "m", "mm", "um" or a number of metres. COLMAP's unit is whatever the
            photographs gave, until somebody measures it.
        up: the axis that points up in it, "y", "z" or "-y"; None: -y (y down, z ahead), as in the
            `.ply` files of splats that are trained there, in `transforms.json` z.
        world_from_file: (4, 4), instead of both: a rotation times a scale, and a translation.
        undo_applied: of `transforms.json`: take its `applied_transform` and `applied_scale` off, so
            that cameras are in the frame from which it was made (COLMAP's, with -y for ``up``).

    Raises:
        omma.Error: no such file, one that is cut off or of another shape, no photograph with a
            pose, one whose camera is missing, a quaternion of length 0, a matrix that is no
            rotation, numbers that are not finite.

    Warns:
        UserWarning: a quaternion's length is further from 1 than 0.01.
    """
    name = os.fsdecode(path)
    shots, file_up = _read(name, undo_applied)
    if not shots:
        raise Error(f"{name}: expected photographs with poses, found none")
    if world_from_file is None:
        world = mesh_parts.world_from_file(unit, file_up if up is None else up)
    elif unit != "m" or up is not None:
        raise Error("world_from_file: not together with unit and up")
    else:
        world = array_of(world_from_file, "world_from_file", (4, 4))
    return CaptureCameras(
        np.array([shot.position for shot in shots]) @ world[:3, :3].T + world[:3, 3],
        _rotation_in(world) @ np.array([shot.file_from_camera for shot in shots]),
        [shot.half_angles_deg for shot in shots],
        names=tuple(shot.name for shot in shots),
        path=name,
    )


def capture_files(path: PathLike) -> list[str]:
    """The files of cameras that `load_capture_cameras` reads: one, or those of COLMAP's folder.

    Raises:
        omma.Error: a folder without them.
    """
    name = os.fsdecode(path)
    if not os.path.isdir(name):
        return [name]
    folder = colmap_folder(name)
    if folder is None:
        raise Error(_no_colmap(name))
    return colmap_files(folder)


def is_capture(path: PathLike) -> bool:
    """Whether a name is that of a folder of COLMAP, or of a JSON file of cameras: by its name, else
    by what is in it, as responses have JSON files too."""
    name = os.fsdecode(path)
    base = os.path.basename(name).lower()
    if not base.endswith(".json"):
        return os.path.isdir(name) and colmap_folder(name) is not None
    if base.startswith("transforms") or base == "cameras.json":
        return True
    try:
        document = read_json(name)
    except Error:
        return False
    return is_transforms(document) or is_splat_cameras(document)


def _read(path: str, undo_applied: bool) -> tuple[list[Shot], str]:
    """The photographs, and which axis is up unless the caller knows better."""
    document: Any = None if os.path.isdir(path) else _read_cameras(path)
    if is_transforms(document):
        return read_transforms(path, document, undo_applied), "-y" if undo_applied else "z"
    if undo_applied:
        raise Error(f"undo_applied: is for Nerfstudio's transforms.json, found {path}")
    if is_splat_cameras(document):
        return read_splat_cameras(path, document), "-y"
    folder = colmap_folder(path)
    if folder is not None:
        return read_colmap(folder), "-y"
    if os.path.isdir(path):
        raise Error(_no_colmap(path))
    raise Error(f"{path}: expected {_KNOWN}, found another shape")


def _read_cameras(path: str) -> Any:
    """The JSON of a file; of one that is not called so, what may be read."""
    try:
        return read_json(path)
    except Error:
        if path.lower().endswith(".json") or not os.path.isfile(path):
            raise
    raise Error(f"{path}: expected {_KNOWN}, found a file that is no JSON")


def _no_colmap(folder: str) -> str:
    return (
        f"{folder}: expected a folder of COLMAP, with cameras.bin and images.bin or cameras.txt "
        "and images.txt in it or in its sparse/0, found none of them"
    )


def _rotation_in(world: Floats) -> Floats:
    """Of a matrix (4, 4) that is a rotation times a scale and a translation."""
    linear = world[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        scale = float(np.cbrt(np.linalg.det(linear))) if np.isfinite(world).all() else 0.0
        is_similar = (
            1e-12 < scale < 1e12
            and np.abs(linear.T @ linear / scale**2 - np.eye(3)).max() < _SIMILAR
            and np.abs(world[3] - [0, 0, 0, 1]).max() < _SIMILAR
        )
    if not is_similar:
        raise Error(
            "world_from_file: expected a rotation times a scale above 0 and a translation, found "
            "another matrix"
        )
    return np.asarray(linear / scale)
