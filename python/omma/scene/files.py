"""Scenes from files."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from omma import _core
from omma._core import Camera as Camera
from omma._core import Error, Scene
from omma.base.arguments import checked
from omma.base.files import PathLike
from omma.base.warn import warn_caller


@checked
def load_scene(
    path: PathLike,
    scene_index: int | None = None,
    *,
    color_rule: str = "gltf",
    progress: Callable[[float], object] | None = None,
) -> Scene:
    """Read a glTF 2.0 scene, `.gltf` or `.glb`.

    Other Python threads run meanwhile, and Ctrl-C stops the work within a second.

    Args:
        path: the file.
        scene_index: which of the file's scenes; None takes its default.
        color_rule: "gltf" takes colours as glTF 2.0 says: textures are sRGB, factors and vertex
            colours linear, and they multiply. "compoundray" is for comparison with work done with
            CompoundRay: vertex colours to the power 2.2 in place of all else, or else the factor
            times the texture to the power 2.2; everything opaque and seen from both sides
            (BrainsOnBoard/compound-ray, libEyeRenderer3/shaders.cu).
        progress: called with the finished share (0 to 1), roughly, a few times a second. What it
            raises ends the loading and is raised here.

    Raises:
        omma.Error: the file is missing, broken or needs an extension that is not supported; it
            names the file and what is wrong.
        KeyboardInterrupt: Ctrl-C.

    Warns:
        UserWarning: what was passed over, such as lights: each of ``Scene.warnings``.
    """
    scene = read_scene(path, scene_index, color_rule=color_rule, progress=progress)
    for sentence in scene.warnings:
        warn_caller(f"{scene.path}: {sentence}", UserWarning)
    return scene


def read_scene(
    path: PathLike,
    scene_index: int | None = None,
    *,
    color_rule: str = "gltf",
    progress: Callable[[float], object] | None = None,
) -> Scene:
    """As `load_scene`, for those who hand ``Scene.warnings`` on themselves."""
    name = os.fsdecode(path)
    if Path(name).suffix.lower() in (".eye", ".csv"):
        raise Error(f"{name}: expected a scene, .gltf or .glb, found the name of an eye file")
    if scene_index is not None and scene_index < 0:
        raise Error(f"scene_index: expected 0 or more, found {scene_index}")
    index = -1 if scene_index is None else scene_index
    return _core.load_scene(path, index, color_rule, progress)
