"""Scenes from OBJ, PLY and STL files."""

from __future__ import annotations

import os

from omma import _core
from omma._core import Error, Scene
from omma.base.mesh_parts import MeshParts, make_scene, world_from_file
from omma.base.obj_files import read_obj
from omma.base.ply_files import read_ply
from omma.scene.trimesh_scenes import from_trimesh, read_stl

MESH_FILES = (".obj", ".ply", ".stl")


def load_mesh_file(path: str, unit: str | float, up: str) -> Scene:
    """The scene of such a file; what of it was passed over is in its warnings."""
    if not os.path.isfile(path):
        found = "a directory" if os.path.isdir(path) else "none"
        raise Error(f"{path}: expected a file, found {found}")
    ending = os.path.splitext(path)[1].lower()
    told: list[str] = []
    try:
        if ending == ".stl":
            scene = from_trimesh(read_stl(path), unit=unit, up=up)
        else:
            placed = world_from_file(unit, up)
            parts: MeshParts = read_obj(path) if ending == ".obj" else read_ply(path)
            told = parts.warnings
            scene = make_scene(parts, placed)
    except MemoryError:
        raise Error(f"{path}: it takes more memory than there is") from None
    except Error as error:
        raise error if str(error).startswith(path) else Error(f"{path}: {error}") from None
    if not scene.meshes:
        raise Error(f"{path}: expected triangles, found none")
    return _core.with_path(scene, path, told)
