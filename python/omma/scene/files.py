"""Scenes from files, and in files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Camera as Camera
from omma._core import Error, Scene
from omma.base.addresses import expect_local
from omma.base.arguments import checked
from omma.base.files import PathLike
from omma.base.mesh_parts import world_from_file
from omma.base.progress import Progress
from omma.base.warn import warn_caller
from omma.scene.gltf_spz import load_spz_gltf
from omma.scene.gltf_text import GLTF_FILES, begins_as_gltf, colors_of_trimesh
from omma.scene.joining import place_scene, scale_of, warnings_of_file
from omma.scene.mesh_files import MESH_FILES, load_mesh_file
from omma.scene.point_files import POINT_FILES, is_point_file
from omma.scene.splat_files import (
    SPLAT_FILES,
    is_splat_file,
    load_splat_scene,
    refuse_other_splats,
)
from omma.scene.surfel_scenes import load_surfels
from omma.scene.without_light import is_of_light, remember_loaded

SCENE_FILES = tuple(dict.fromkeys((*GLTF_FILES, *MESH_FILES, *SPLAT_FILES, *POINT_FILES)))

# Of endings that say too little.
_OF_POINTS = (
    "points of a scan are read by omma.scene.load_points, of which omma.scene.surfels makes a scene"
)


@checked
def load_scene(
    path: PathLike,
    scene_index: int | None = None,
    *,
    color_rule: str = "gltf",
    unit: str | float | None = None,
    up: str | None = None,
    voxel_m: float | None = None,
    progress: Progress | None = None,
) -> Scene:
    """Read a glTF 2.0 scene, `.gltf` or `.glb`, the meshes of an `.obj`, `.ply` or `.stl` file, the
    points of a `.las`, `.laz`, `.e57`, `.xyz`, `.pts` or `.asc` file, or of a `.ply` file without
    faces, or the Gaussian splats of a `.ply` or `.spz` file.

    Meshes need trimesh (`pip install 'omma[meshes]'`), OBJ files on Python 3.13 and newer
    `omma[obj]` too; `omma.scene.from_trimesh` says what becomes of colours and pictures. Points
    become discs as `omma.scene.load_points` and `omma.scene.surfels` make them by default. Splats
    are those of `omma.scene.load_splats`.

    Other Python threads run meanwhile, and Ctrl-C stops the work within a second.

    Args:
        path: the file.
        scene_index: which of the file's scenes; None takes its default.
        color_rule: "gltf" takes colours as glTF 2.0 says: textures are sRGB, factors and vertex
            colours linear, and they multiply. "compoundray" is for comparison with work done with
            CompoundRay: vertex colours to the power 2.2 instead of all else, or else the factor
            times the texture to the power 2.2; everything opaque and seen from both sides
            (BrainsOnBoard/compound-ray, libEyeRenderer3/shaders.cu).
        unit: of lengths in files that do not say it, or say it wrongly: "m" (None), "mm", "um" or a
            number of metres. glTF says metres, +Y up; scanners' programs do not always heed it
            (`omma info` says how large a scene is). All lengths of the file are in it, such as the
            ranges of lamps and half extents of cameras. Eyes of a scene's cameras keep their size.
        up: the axis that points up: "y", "z", or "-y" where y points down and z ahead. None: y, in
            files of points but `.ply` z, in `.ply` files of splats -y.
        voxel_m: of points alone: side of the cells of a grid, m, in each of which their mean is one
            disc. None: each point is one.
        progress: called with the finished share (0 to 1), roughly, a few times a second. What it
            raises ends the loading and is raised here. Not for `.obj`, `.ply` and `.stl`.

    Example:
        >>> scene = omma.load_scene(omma.examples.meadow())
        >>> [camera.name for camera in scene.cameras]
        ['bee', 'bee-low', 'overview']

    Raises:
        omma.Error: the file is missing, broken or needs an extension that is not supported; it
            names the file and what is wrong.
        KeyboardInterrupt: Ctrl-C.

    Warns:
        UserWarning: what was passed over, such as skins: each of ``Scene.warnings``, but that
            surfaces are not shaded without a light, which a world without one tells once a session.
    """
    scene = read_scene(
        path,
        scene_index,
        color_rule=color_rule,
        unit=unit,
        up=up,
        voxel_m=voxel_m,
        progress=progress,
    )
    for sentence in scene.warnings:
        if not is_of_light(sentence):
            warn_caller(f"{scene.path}: {sentence}", UserWarning)
    remember_loaded(scene)
    return scene


def read_scene(
    path: PathLike,
    scene_index: int | None = None,
    *,
    color_rule: str = "gltf",
    unit: str | float | None = None,
    up: str | None = None,
    voxel_m: float | None = None,
    progress: Progress | None = None,
) -> Scene:
    """As `load_scene`, for those who hand ``Scene.warnings`` on themselves."""
    name = os.fsdecode(path)
    if Path(name).suffix.lower() in (".eye", ".csv"):
        points = "" if name.lower().endswith(".eye") else f"; {_OF_POINTS}"
        raise Error(
            f"{name}: expected a scene, .gltf or .glb, found the name of an eye file{points}"
        )
    if Path(name).suffix.lower() == ".txt":
        raise Error(f"{name}: expected a scene, .gltf or .glb, found a text file; {_OF_POINTS}")
    if Path(name).suffix.lower() == ".blend":
        raise Error(
            f"{name}: expected a scene, .gltf or .glb, found a file of Blender; there: File > "
            "Export > glTF 2.0, with the format glTF Binary (.glb)"
        )
    refuse_other_splats(name)
    ending = Path(name).suffix.lower()
    if ending not in SCENE_FILES and Path(name).is_file() and not begins_as_gltf(name):
        raise Error(
            f"{name}: expected a scene, whose name ends in {', '.join(SCENE_FILES)}, found "
            f"{'the ending ' + ending if ending else 'no ending'} and no glTF in it"
        )
    is_splats, is_points = is_splat_file(name), is_point_file(name)
    if voxel_m is not None and not is_points:
        raise Error(f"voxel_m: expected none, as {name} holds no points of a scan")
    if is_splats or is_points or Path(name).suffix.lower() in MESH_FILES:
        if scene_index is not None:
            raise Error(f"scene_index: expected none, as {name} holds no list of scenes")
        if color_rule != "gltf":
            raise Error(f"color_rule: expected gltf, as {name} is no glTF file")
        if is_splats:
            return load_splat_scene(name, "m" if unit is None else unit, up, progress)
        if is_points:
            return load_surfels(name, "m" if unit is None else unit, up, voxel_m, progress)
        return load_mesh_file(name, "m" if unit is None else unit, "y" if up is None else up)
    if scene_index is not None and scene_index < 0:
        raise Error(f"scene_index: expected 0 or more, found {scene_index}")
    index = -1 if scene_index is None else scene_index
    try:
        matrix = world_from_file("m" if unit is None else unit, "y" if up is None else up)
    except Error as error:
        raise Error(f"{name}: {error}") from None
    packed = load_spz_gltf(name, index, color_rule, progress)
    scene = _core.load_scene(path, index, color_rule, progress) if packed is None else packed
    del packed
    told = colors_of_trimesh(name) if color_rule == "gltf" else []
    if told:
        scene = _core.with_path(scene, scene.path, [*warnings_of_file(scene), *told])
    return scene if unit is None and up is None else _as_written(scene, matrix)


def _as_written(scene: Scene, matrix: NDArray[np.float64]) -> Scene:
    """A glTF scene of whoever wrote other lengths than metres, or another axis up."""
    placed = place_scene(scene, matrix)
    # A camera's scale is that of its eye, which is none of the file's lengths; its own are.
    metres = scale_of(matrix)
    keep = np.diag([1 / metres] * 3 + [1.0])
    cameras = [
        one.replace(
            world_from_camera=one.world_from_camera @ keep,
            xmag_m=one.xmag_m * metres,
            ymag_m=one.ymag_m * metres,
            znear_m=one.znear_m * metres,
            zfar_m=one.zfar_m * metres,
        )
        for one in placed.cameras
    ]
    if cameras:
        rig = placed.rig and _core.with_scaled_cameras(placed.rig, 1 / metres)
        placed = placed.replace(cameras=cameras, rig=rig)
    return _core.with_path(placed, scene.path, warnings_of_file(scene))


@checked
def save_scene(path: PathLike, scene: Scene, *, progress: Progress | None = None) -> None:
    """Write a scene as a `.glb` file, whole in itself, which `load_scene` reads to an equal one.

    Blender and other programs open it. Backgrounds, and the values of pictures in linear floats, of
    which others see 8 bits, are in the file's extras.

    The scene is written as it stands, without its animations. What nobody sees is left out: meshes
    that no instance places, pictures that no material uses.
    The others come in the order of their first use; so a scene that was made in another order is
    seen alike when it is read, but does not compare equal.

    Args:
        path: the file, whose name ends in .glb. It is there whole or not at all.
        scene: what to write.
        progress: called with the finished share (0 to 1) a few times a second. What it raises ends
            the writing and is raised here.

    Raises:
        omma.Error: another ending, more than 4 GB, or the system refuses.
    """
    name = expect_local(path, "a scene")
    if Path(name).suffix.lower() != ".glb":
        raise Error(f"{name}: expected a name that ends in .glb")
    _core.save_scene(name, scene, progress)
