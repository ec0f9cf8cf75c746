"""What the commands of ``omma measure`` share: their options, the scene, the pose and the files to
write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np

from omma._core import Scene
from omma.base.arguments import as_named
from omma.base.figures import load_matplotlib
from omma.base.files import check_ending
from omma.base.poses import Matrices, poses_from_angles
from omma.cli.options import help_of
from omma.cli.parameters import option, out
from omma.cli.working import DelayedBar, check_outputs, say
from omma.rendering.renderer import Renderer
from omma.rendering.settings import PointsName
from omma.scene.building import BUILDING, READING, stage_of
from omma.scene.files import load_scene
from omma.study.variance import scene_renderer

Corner = tuple[float, float, float]
EyeFiles = Annotated[list[Path], option("Eye file; several make one head.", "EYE", name="--eye")]
Outputs = Annotated[list[Path] | None, out("File to write; may be given again.")]
CameraOption = Annotated[str | None, option("Camera of the scene to look from.", "NAME")]
PositionOption = Annotated[
    tuple[float, float, float] | None,
    option("Where the head is, in metres; it looks along -Z.", "X Y Z"),
]
MeasureOption = Annotated[
    Literal["linear", "compoundray"],
    option(
        "Of linear responses, of the channel that scatters most; or as CompoundRay does, of "
        "8-bit gamma-encoded colours, as distance in RGB."
    ),
]
SensitivityOption = Annotated[
    Literal["gaussian", "pillbox", "compoundray"], option("Angular sensitivity.")
]
PointsOption = Annotated[PointsName, option(help_of("points"))]
SeedOption = Annotated[int, option(help_of("seed"), "N")]


class SceneFile(NamedTuple):
    """A scene's file and how it is read."""

    path: Path
    unit: str | None
    up: str | None
    voxel_m: float | None


def scene_of(scene: SceneFile, bar: DelayedBar) -> Scene:
    """What is in the file."""
    with as_named(unit="scene_unit", up="scene_up", voxel_m="scene_voxel_m"):
        return load_scene(
            scene.path,
            unit=scene.unit,
            up=scene.up,
            voxel_m=scene.voxel_m,
            progress=bar.fraction_of(READING),
        )


def renderer_of(scene: SceneFile, threads: int, bar: DelayedBar) -> Renderer:
    """A renderer of the scene, to make others from."""
    return scene_renderer(scene_of(scene, bar), threads, stage_of(bar.show, BUILDING))


def pose_of(scene: Scene, camera: str | None, position: Corner | None) -> Matrices:
    """Position of the head, else that of a camera, else of the scene's first, else the origin.

    Without the camera's scale: `--unit` says how large the eye is.
    """
    if position is not None:
        return poses_from_angles(position, (0, 0, 0))
    node = scene.camera(camera) if camera is not None else next(iter(scene.cameras), None)
    pose = np.eye(4) if node is None else node.world_from_camera.copy()
    pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)
    return pose[None]


def files_to_write(outputs: list[Path] | None, *known: str) -> list[Path]:
    """The files to write; an error now, not after minutes of work."""
    for name in outputs or ():
        check_ending(name, *known)
        if name.suffix.lower() == ".png":
            load_matplotlib()
    check_outputs(*(outputs or ()))
    return outputs or []


def say_written(names: Sequence[Path]) -> None:
    """The last lines of a command that wrote files."""
    for name in names:
        say(f"wrote      {name}")
