"""The triangles of a mesh file and nothing else: what an eye's surface needs of it."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error
from omma.base.obj_files import read_obj
from omma.base.optional import needs
from omma.base.ply_files import read_ply

_READERS = {".obj": read_obj, ".ply": read_ply}


def triangles_of_file(path: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices (V, 3) in the file's unit and triangles (T, 3); of other formats by trimesh."""
    read = _READERS.get(os.path.splitext(path)[1].lower())
    if read is None:
        return _by_trimesh(path)
    pieces = read(path).pieces
    if not pieces:
        raise Error(f"{path}: expected triangles, found none")
    starts = np.cumsum([0] + [len(one.positions) for one in pieces])
    return (
        np.concatenate([one.positions for one in pieces]),
        np.concatenate([one.triangles + start for one, start in zip(pieces, starts.tolist())]),
    )


def _by_trimesh(path: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    _core.read_file(path)  # the engine tells of what is not there or no file
    trimesh = needs("trimesh", "meshes", "load_surface: needs trimesh")
    try:
        mesh = trimesh.load_scene(path).to_mesh()
        return np.asarray(mesh.vertices), np.asarray(mesh.faces)
    except OSError as error:
        raise Error(f"{path}: cannot be read: {error.strerror or error}") from None
    except Exception as error:  # trimesh raises whatever its parsers meet
        raise Error(f"{path}: cannot be read as a mesh: {error}") from None
