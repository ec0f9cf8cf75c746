"""Cameras of COLMAP: the folder of a sparse reconstruction, as text or binary.

`cameras` are lenses, `images` photographs with their poses, each of which names its lens. Poses are
camera_from_world, with x right, y down and z forward in the camera (COLMAP's page Output Format).
"""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from omma import _core
from omma._core import Error
from omma.base.files import open_text
from omma.base.poses import warn_of_lengths
from omma.scene.capture_lenses import (
    ALL_ROUND,
    COLMAP_AXES,
    UNKNOWN,
    Lens,
    Shot,
    position,
    rotation_of_quaternion,
)

# Where a reconstruction may lie in a folder.
_FOLDERS = ("", "sparse/0", "sparse", "colmap/sparse/0")
# By number in binary files: name, how many parameters, of these how many are focal lengths, and how
# rays fall (COLMAP's page Camera Models).
_MODELS = (
    ("SIMPLE_PINHOLE", 3, 1, "pinhole"),
    ("PINHOLE", 4, 2, "pinhole"),
    ("SIMPLE_RADIAL", 4, 1, "pinhole"),
    ("RADIAL", 5, 1, "pinhole"),
    ("OPENCV", 8, 2, "pinhole"),
    ("OPENCV_FISHEYE", 8, 2, "fisheye"),
    ("FULL_OPENCV", 12, 2, "pinhole"),
    ("FOV", 5, 2, "unknown"),
    ("SIMPLE_RADIAL_FISHEYE", 4, 1, "fisheye"),
    ("RADIAL_FISHEYE", 5, 1, "fisheye"),
    ("THIN_PRISM_FISHEYE", 12, 2, "fisheye"),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, "fisheye"),
    ("SIMPLE_DIVISION", 4, 1, "pinhole"),
    ("DIVISION", 5, 2, "pinhole"),
    ("SIMPLE_FISHEYE", 3, 1, "fisheye"),
    ("FISHEYE", 4, 2, "fisheye"),
    ("EUCM", 6, 2, "unknown"),
    ("EQUIRECTANGULAR", 2, 0, "all round"),
)
_NUMBER_OF = {name: number for number, (name, *_) in enumerate(_MODELS)}
_LONGEST_NAME = 4096
# What COLMAP writes into the first lines of a text file.
_COUNT = re.compile(r"#\s*Number of (cameras|images):\s*([0-9]{1,18})\b")


class _Pose(NamedTuple):
    where: str
    numbers: tuple[float, ...]  # quaternion w, x, y, z; translation
    camera: int
    name: str


def colmap_folder(path: str) -> str | None:
    """The folder with the files, at ``path`` or where COLMAP puts it below; None: there is none."""
    for below in _FOLDERS:
        folder = os.path.join(path, below) if below else path
        if _ending(folder) is not None:
            return folder
    return None


def colmap_files(folder: str) -> list[str]:
    """The two that are read of such a folder."""
    ending = _ending(folder)
    return [os.path.join(folder, f"{one}{ending}") for one in ("cameras", "images")]


def _ending(folder: str) -> str | None:
    for ending in (".bin", ".txt"):
        if all(os.path.isfile(os.path.join(folder, one + ending)) for one in ("cameras", "images")):
            return ending
    return None


def read_colmap(folder: str) -> list[Shot]:
    """All photographs that have a pose, as the files order them."""
    cameras, images = colmap_files(folder)
    is_text = images.endswith(".txt")
    fields = dict(_text_cameras(cameras) if is_text else _binary_cameras(cameras))
    shots: list[Shot] = []
    places: list[str] = []
    quaternions: list[tuple[float, ...]] = []
    for pose in _text_images(images) if is_text else _binary_images(images):
        if pose.camera not in fields:
            raise Error(
                f"{pose.where}: expected a camera of {cameras}, found {pose.camera}, which is not "
                "there"
            )
        camera_from_world = rotation_of_quaternion(pose.numbers[:4], pose.where)
        with np.errstate(over="ignore", invalid="ignore"):
            at = -camera_from_world.T @ np.array(pose.numbers[4:])
        turn = camera_from_world.T @ COLMAP_AXES
        shots.append(Shot(pose.name, position(at, pose.where), turn, fields[pose.camera]))
        places.append(pose.where)
        quaternions.append(pose.numbers[:4])
    warn_of_lengths(np.reshape(quaternions, (-1, 4)), lambda row: places[row])
    return shots


def _field(
    number: int, size: tuple[float, float], parameters: tuple[float, ...], where: str
) -> tuple[float, float]:
    _, _, focal, kind = _MODELS[number]
    if kind == "all round":
        return ALL_ROUND
    if not np.isfinite(parameters).all():
        raise Error(f"{where}: expected finite numbers, found {parameters!r:.60}")
    if kind == "unknown":
        return UNKNOWN
    fx, fy = parameters[0], parameters[focal - 1]
    lens = Lens(*size, fx, fy, parameters[focal], parameters[focal + 1])
    return lens.half_angles_deg(kind == "fisheye", where)


class _Promise:
    """How many records a text file says that it has, and whether it has them."""

    def __init__(self, path: str, what: str) -> None:
        self._path, self._what = path, what
        self._said: tuple[int, int] | None = None  # the number, its line
        self.found = 0

    def heed(self, comment: str, line_number: int) -> None:
        said = _COUNT.match(comment.strip())
        if said is not None and said[1] == self._what:
            self._said = int(said[2]), line_number

    def expect_all(self) -> None:
        if self._said is not None and self._said[0] != self.found:
            count, line_number = self._said
            raise Error(
                f"{self._path}: expected {count:,} {self._what}, as line {line_number} says, found "
                f"{self.found:,}: the file is cut off, or that line is not of it"
            )


def _text_cameras(path: str) -> Iterator[tuple[int, tuple[float, float]]]:
    promise = _Promise(path, "cameras")
    with open_text(path) as file:
        for line_number, line in enumerate(file, 1):
            where, words = f"{path}, line {line_number}", line.split()
            if not words or words[0].startswith("#"):
                promise.heed(line, line_number)
                continue
            number = _NUMBER_OF.get(words[1]) if len(words) > 3 else None
            if number is None:
                raise Error(
                    f"{where}: expected CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS, with one of "
                    f"COLMAP's models, found {line.strip()!r:.60}"
                )
            count = _MODELS[number][1]
            if len(words) != 4 + count:
                raise Error(
                    f"{where}: expected {count} parameters of {words[1]}, found {len(words) - 4}"
                )
            width, height, *parameters = _floats(words[2:], where)
            found = _field(number, (width, height), tuple(parameters), where)
            promise.found += 1
            yield _whole(words[0], where), found
    promise.expect_all()


def _text_images(path: str) -> Iterator[_Pose]:
    promise = _Promise(path, "images")
    with open_text(path) as file:
        lines = enumerate(file, 1)
        for line_number, line in lines:
            where, words = f"{path}, line {line_number}", line.split(maxsplit=9)
            if not words or words[0].startswith("#"):
                promise.heed(line, line_number)
                continue
            if len(words) != 10:
                raise Error(
                    f"{where}: expected IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME, "
                    f"found {line.strip()!r:.60}"
                )
            numbers = tuple(_floats(words[1:8], where))
            promise.found += 1
            yield _Pose(where, numbers, _whole(words[8], where), words[9].strip())
            points_at, points = next(lines, (0, ""))  # the last line may be left out
            if not _are_points(points):
                raise Error(
                    f"{path}, line {points_at}: expected the points of the photograph above, X, Y, "
                    f"POINT3D_ID of each, or an empty line, found {points.strip()!r:.60}"
                )
    promise.expect_all()


def _are_points(line: str) -> bool:
    """Whether a line has three numbers of each point. Its first and last point are looked at: a
    photograph's own line ends with a name."""
    words = line.split()
    try:
        for one in words[:3] + words[-3:]:
            float(one)
    except ValueError:
        return False
    return len(words) % 3 == 0


def _floats(words: list[str], where: str) -> list[float]:
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if not numbers or not np.isfinite(numbers).all():
        raise Error(f"{where}: expected finite numbers, found {' '.join(words)!r:.60}")
    return numbers


def _whole(word: str, where: str) -> int:
    if not (word.isascii() and word.isdecimal() and len(word) <= 20):
        raise Error(f"{where}: expected a whole number, found {word!r:.40}")
    return int(word)


class _Bytes:
    """A binary file that is read from its beginning to its end."""

    def __init__(self, path: str) -> None:
        self.path, self.at, self.data = path, 0, _core.read_file(path)

    def take(self, form: str, what: str) -> tuple[float, ...]:
        size = struct.calcsize(form)
        if self.at + size > len(self.data):
            raise Error(
                f"{self.path}, byte {self.at}: expected {what}, found the end of the file, which "
                "is cut off"
            )
        self.at += size
        return struct.unpack_from(form, self.data, self.at - size)

    def count(self, each: int, what: str) -> int:
        """How many records follow, of so many bytes at least."""
        before = self.at
        number = int(self.take("<Q", f"the number of {what}")[0])
        rest = len(self.data) - self.at
        if number > rest // each:
            raise Error(
                f"{self.path}, byte {before}: expected at most {rest // each:,} {what} in "
                f"the {rest:,} bytes that follow, found {number:,}: the file is cut off or broken"
            )
        return number

    def name(self) -> str:
        end = self.data.find(b"\0", self.at, self.at + _LONGEST_NAME)
        if end < 0:
            raise Error(f"{self.path}, byte {self.at}: expected a name that ends, found none")
        name = self.data[self.at : end].decode("utf-8", "replace")
        self.at = end + 1
        return name

    def expect_end(self) -> None:
        if self.at != len(self.data):
            raise Error(
                f"{self.path}, byte {self.at}: expected the end of the file, found "
                f"{len(self.data) - self.at:,} more bytes"
            )


def _binary_cameras(path: str) -> Iterator[tuple[int, tuple[float, float]]]:
    file = _Bytes(path)
    for _ in range(file.count(24 + 16, "cameras")):
        where = f"{path}, byte {file.at}"
        identifier, number, width, height = file.take("<IiQQ", "a camera")
        if not 0 <= number < len(_MODELS):
            known = f"0 to {len(_MODELS) - 1}"
            raise Error(f"{where}: expected a camera's model, {known}, found {number}")
        parameters = file.take(f"<{_MODELS[int(number)][1]}d", "a camera's parameters")
        yield int(identifier), _field(int(number), (width, height), parameters, where)
    file.expect_end()


def _binary_images(path: str) -> Iterator[_Pose]:
    file = _Bytes(path)
    for _ in range(file.count(4 + 7 * 8 + 4 + 1 + 8, "images")):
        where = f"{path}, byte {file.at}"
        _, *numbers, camera = file.take("<I7dI", "an image")
        if not np.isfinite(numbers).all():
            raise Error(f"{where}: expected finite numbers, found {numbers!r:.60}")
        name = file.name()
        points = file.count(24, "points")  # x, y and the number of each
        file.at += 24 * points
        yield _Pose(where, tuple(numbers), int(camera), name)
    file.expect_end()
