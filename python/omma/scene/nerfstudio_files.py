"""Cameras in JSON files: Nerfstudio's `transforms.json`, which instant-ngp and the first NeRF have
too, and the `cameras.json` that 3D Gaussian Splatting writes beside a model.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from omma import _core
from omma._core import Error
from omma.base.arrays import Floats
from omma.scene.capture_lenses import (
    ALL_ROUND,
    COLMAP_AXES,
    UNKNOWN,
    Lens,
    Shot,
    position,
    rotation,
)

# How rays fall by `camera_model`, whose names are COLMAP's and Nerfstudio's own.
_PINHOLES = ("SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "PERSPECTIVE")
_FISHEYES = (
    "OPENCV_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE", "THIN_PRISM_FISHEYE", "FISHEYE",
    "SIMPLE_FISHEYE",
)  # fmt: skip
# Beside the end of a matrix's last row, which is 0, 0, 0, 1.
_NEARLY = 1e-6


def read_json(path: str) -> Any:
    """A JSON file.

    Raises:
        omma.Error: it is none.
    """
    try:
        return json.loads(_core.read_file(path))
    except (ValueError, RecursionError) as error:
        if isinstance(error, UnicodeDecodeError):
            why = "it is no text"
        elif isinstance(error, json.JSONDecodeError):
            why = f"{error.msg}, line {error.lineno}, column {error.colno}"
        else:
            why = f"{error!s:.100}"
        raise Error(f"{path}: expected JSON, found none: {why}") from None


def is_transforms(document: Any) -> bool:
    """Whether it is Nerfstudio's file, by its shape."""
    return isinstance(document, dict) and "frames" in document


def is_splat_cameras(document: Any) -> bool:
    """Whether it is the file of 3D Gaussian Splatting, by its shape."""
    return isinstance(document, list) and all(
        isinstance(one, dict) and {"position", "rotation"} <= one.keys() for one in document
    )


def read_transforms(path: str, document: dict[str, Any], undo_applied: bool) -> list[Shot]:
    """Photographs of `transforms.json`, whose matrices are world_from_camera with +Y up and
    looking along -Z; without its `applied_transform`, where that is to be undone."""
    frames = _list(document["frames"], f"{path}, frames")
    original_from_file = np.eye(4)
    if undo_applied:
        where = f"{path}, applied_transform"
        if "applied_transform" not in document:
            raise Error(f"{where}: expected a matrix to undo, found none")
        applied = _matrix(document["applied_transform"], where)
        scale = _number(document.get("applied_scale", 1.0), f"{path}, applied_scale")
        if not 1e-12 < scale < 1e12:
            raise Error(f"{path}, applied_scale: expected a scale above 0, found {scale:g}")
        turn = rotation(applied[:3, :3], where)
        original_from_file[:3, :3] = turn.T / scale
        original_from_file[:3, 3] = -turn.T @ position(applied[:3, 3], where)
    shots = []
    for index, frame in enumerate(frames):
        where = f"{path}, frames[{index}]"
        if not isinstance(frame, dict):
            raise Error(f"{where}: expected an object, found {_short(frame)}")
        if "transform_matrix" not in frame:
            raise Error(f"{where}: expected transform_matrix, found none")
        matrix = _matrix(frame["transform_matrix"], f"{where}, transform_matrix")
        turn = rotation(matrix[:3, :3], f"{where}, transform_matrix")
        at = position(matrix[:3, 3], f"{where}, transform_matrix")
        name = frame.get("file_path", f"frame {index}")
        if not isinstance(name, str):
            raise Error(f"{where}, file_path: expected a text, found {_short(name)}")
        if undo_applied:
            with np.errstate(over="ignore"):
                at = original_from_file[:3, :3] @ at + original_from_file[:3, 3]
            turn = rotation(original_from_file[:3, :3] * scale, where) @ turn
            at = position(at, where)
        shots.append(Shot(name, at, turn, _field({**document, **frame}, where)))
    return shots


def read_splat_cameras(path: str, document: list[dict[str, Any]]) -> list[Shot]:
    """Photographs of `cameras.json`: rotation is world_from_camera, with y down and z forward."""
    shots = []
    for index, one in enumerate(document):
        where = f"{path}, [{index}]"
        turn = rotation(_numbers(one["rotation"], (3, 3), f"{where}, rotation"), where)
        at = position(_numbers(one["position"], (3,), f"{where}, position"), where)
        name = one.get("img_name", f"camera {index}")
        if not isinstance(name, str):
            raise Error(f"{where}, img_name: expected a text, found {_short(name)}")
        numbers = [_number(one[key], f"{where}, {key}") if key in one else None
                   for key in ("width", "height", "fx", "fy")]  # fmt: skip
        known = [number for number in numbers if number is not None]
        field = Lens(*known).half_angles_deg(False, where) if len(known) == 4 else UNKNOWN
        shots.append(Shot(name, at, turn @ COLMAP_AXES, field))
    return shots


def _field(about: dict[str, Any], where: str) -> tuple[float, float]:
    """Of a frame and what all frames share."""
    model = about.get("camera_model", "OPENCV")
    if not isinstance(model, str):
        raise Error(f"{where}, camera_model: expected a text, found {_short(model)}")
    if model == "EQUIRECTANGULAR":
        return ALL_ROUND
    if model not in (*_PINHOLES, *_FISHEYES):
        return UNKNOWN

    def number(key: str) -> float | None:
        return _number(about[key], f"{where}, {key}") if key in about else None

    width, height, fx, fy = number("w"), number("h"), number("fl_x"), number("fl_y")
    is_fisheye = model in _FISHEYES
    if fx is None and (angle := number("camera_angle_x")) is not None:
        if not 0 < angle < math.pi:
            raise Error(
                f"{where}, camera_angle_x: expected radians above 0 and below pi, found {angle:g}"
            )
        if width is None or height is None:
            return math.degrees(angle / 2), math.nan
        fx = width / angle if is_fisheye else width / 2 / math.tan(angle / 2)
    if fx is None or width is None or height is None:
        return UNKNOWN
    lens = Lens(width, height, fx, fx if fy is None else fy, number("cx"), number("cy"))
    return lens.half_angles_deg(is_fisheye, where)


def _matrix(value: Any, where: str) -> Floats:
    """(4, 4), of a matrix with or without its last row."""
    rows = 3 if isinstance(value, list) and len(value) == 3 else 4
    matrix = np.eye(4)
    matrix[:rows] = _numbers(value, (rows, 4), where)
    if np.abs(matrix[3] - [0, 0, 0, 1]).max() > _NEARLY:
        found = ", ".join(f"{one:g}" for one in matrix[3])
        raise Error(f"{where}: expected a last row of 0, 0, 0, 1, found {found}")
    return matrix


def _numbers(value: Any, shape: tuple[int, ...], where: str) -> Floats:
    """An array of nested lists, each of a length that is known."""
    items = _list(value, where)
    if len(items) != shape[0]:
        raise Error(f"{where}: expected {shape[0]} items, found {len(items)}")
    if len(shape) == 1:
        return np.array([_number(item, f"{where}[{k}]") for k, item in enumerate(items)])
    rows = [_numbers(item, shape[1:], f"{where}[{k}]") for k, item in enumerate(items)]
    return np.array(rows)


def _list(value: Any, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise Error(f"{where}: expected a list, found {_short(value)}")
    return value


def _number(value: Any, where: str) -> float:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    # What is whole may have too many digits for a float.
    if not is_number or not abs(value) < 1e300:
        raise Error(f"{where}: expected a finite number, found {_short(value)}")
    return float(value)


def _short(value: Any) -> str:
    """What JSON has, in words that are never long, however deep it is."""
    if isinstance(value, (list, dict)):
        return f"{'a list' if isinstance(value, list) else 'an object'} of {len(value)} items"
    return f"{value!r:.40}"
