"""A render whose scene has been read: by which camera it goes, which eye it has and where."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma import _core
from omma._core import Background, Camera, Error, Eye, Scene
from omma.base.arguments import array_of, as_named
from omma.base.arrays import Floats
from omma.base.files import PathLike
from omma.base.poses import Matrices, as_poses, load_timed_poses, poses_from_angles
from omma.base.progress import Stage
from omma.eye.files import load_head
from omma.job.outputs import check_series, output_names
from omma.job.render_job import RenderJob
from omma.motion.tracks import Track, load_track
from omma.motion.walking import walk_on
from omma.picture.cameras import camera_eye
from omma.rendering.settings import fixed_samples
from omma.scene.backgrounds import parse_background
from omma.scene.building import READING, build_world
from omma.scene.capture_cameras import CaptureCameras, capture_files, load_capture_cameras
from omma.scene.files import read_scene
from omma.scene.light_words import parse_light
from omma.scene.world import World


@dataclass(frozen=True)
class Begun:
    """What is known of a job when its scene has been read."""

    job: RenderJob
    names: list[str]
    """Of the outputs."""
    scene: Scene
    camera: Camera | None
    """That is rendered, or that the head is at."""
    background: Background | None
    light: dict[str, Any]
    """Arguments of the world."""
    cameras: CaptureCameras | None
    """From which a captured world is known."""
    started: float
    """When reading began, s."""
    tell: Stage

    def world(self) -> World:
        """The world, which is built now."""
        return build_world(
            self.scene,
            self.tell,
            threads=self.job.threads,
            background=self.background,
            backend=self.job.backend,
            devices=self.job.devices,
            **self.light,
        )

    @property
    def own_eye_elsewhere(self) -> bool:
        """Whether a camera says which eye it is, and something else where that is."""
        return not self.job.eye_files and self.job.head_is_at not in (None, "camera")


@dataclass(frozen=True)
class View:
    """An eye, and the poses that it sees from."""

    head: Eye
    """All eyes as one."""
    files: list[str]
    """That they came from."""
    poses: Matrices
    text: str
    """Where the poses come from, in words."""
    times_s: Floats | None = None
    """When each pose is, where a track says so."""


def begin(job: RenderJob, tell: Stage) -> Begun:
    """Check what can be checked without an eye, and read the scene."""
    is_captured = job.capture_cameras is not None
    names = output_names(job.outputs, job.standard_error, job.resume, input_files(job), is_captured)
    start = time.perf_counter()
    tell(READING, None)
    with as_named(unit="scene_unit", up="scene_up", voxel_m="scene_voxel_m"):
        scene = read_scene(
            job.scene,
            job.scene_index,
            unit=job.scene_unit,
            up=job.scene_up,
            voxel_m=job.scene_voxel_m,
            progress=partial(tell, READING),
        )
    cameras = _cameras(job)
    camera = _camera(scene, job)
    given = job.background
    background = parse_background(given) if isinstance(given, str) else given
    light = {} if job.light is None else parse_light(job.light)
    begun = Begun(job, names, scene, camera, background, light, cameras, start, tell)
    if camera is not None and begun.own_eye_elsewhere and camera.type != "compound":
        raise Error(f"{job.head_is_at}: is for eyes; camera '{camera.name}' is {camera.type}")
    return begun


def view_of(begun: Begun) -> View:
    """The eye of a job, read, and its poses."""
    job = begun.job
    if job.ultraviolet is not None and not job.receptors:
        raise Error("ultraviolet: is for receptors=True")
    if job.receptors:
        fixed_samples(job.settings.sampling, "receptors")
        for name in begun.names:
            if Path(name).suffix.lower() in (".png", ".mp4"):
                raise Error(
                    f"{name}: expected numbers, not a picture, for responses of receptors; of "
                    ".npy files, in Python, omma.picture.plot_responses(picture, eye, "
                    "numpy.load(file), receptors=True) draws one"
                )
    begun.tell("Reading the eye", None)
    head, files = _head(begun)
    if job.receptors and len(head.receptor_type) == 0:
        raise Error(
            f"{head.path or 'eye'}: expected receptors, found none (.csv eyes can have them, "
            "`omma eye species` writes such, omma.receptors.assign_receptors makes them)"
        )
    view = View(head, files, *_poses(begun))
    check_series(begun.names, len(view.poses), [*input_files(job), *files])
    return view


def input_files(job: RenderJob) -> list[PathLike]:
    """All files that a job says are to be read."""
    files = [job.scene, *job.eye_files, *([] if job.path is None else [job.path])]
    if isinstance(job.background, str) and Path(job.background).exists():
        files.append(job.background)
    return files + ([] if job.capture_cameras is None else capture_files(job.capture_cameras))


def _cameras(job: RenderJob) -> CaptureCameras | None:
    """Those of the capture, in the scene's unit and with its axis up unless a job says others."""
    if job.capture_cameras is None:
        return None
    unit = job.scene_unit if job.capture_unit is None else job.capture_unit
    with as_named(unit="capture_unit", up="capture_up"):
        return load_capture_cameras(
            job.capture_cameras,
            unit="m" if unit is None else unit,
            up=job.scene_up if job.capture_up is None else job.capture_up,
        )


def _camera(scene: Scene, job: RenderJob) -> Camera | None:
    """The camera that is rendered, or that the head is at; None where there is none to take."""
    if job.camera is not None:
        return scene.camera(job.camera)
    compound = [each for each in scene.cameras if each.type == "compound"]
    if job.eye_files:
        return None if job.head_is_at or not scene.cameras else scene.cameras[0]
    if compound:
        return compound[0]
    if job.head_is_at:
        raise Error(f"{scene.path}: no eye is given, and no camera in the scene names one")
    if not scene.cameras:
        raise Error(f"{scene.path}: no eye is given, and the scene has no camera")
    return scene.cameras[0]


def _head(begun: Begun) -> tuple[Eye, list[str]]:
    """All eyes as one, and the files they came from."""
    job, camera = begun.job, begun.camera
    if job.eye_files:
        head = load_head(job.eye_files, "mm" if job.unit is None else job.unit)
        return head, [os.fsdecode(name) for name in job.eye_files]
    assert camera is not None
    own = camera_eye(begun.scene, camera, "m" if job.unit is None else job.unit)
    return _as_large(own, camera) if begun.own_eye_elsewhere else own, [own.path]


def _as_large(eye: Eye, node: Camera) -> Eye:
    """A camera's own eye as large as its node makes it, for poses that only turn and move."""
    sizes = np.linalg.norm(node.world_from_camera[:3, :3], axis=0)
    if np.abs(sizes - 1).max() < 1e-6:
        return eye
    large: Eye = _core.merge_eyes([(eye, np.diag([*sizes, 1.0]))])
    return large


def _walked(begun: Begun, track: Track, height_m: float) -> Matrices:
    """Poses on the ground, in a world without light, as only distances are asked for."""
    job = begun.job
    world = World(begun.scene, threads=job.threads, backend=job.backend, devices=tuple(job.devices))
    with as_named(height_m="on_ground", on="ground"):
        return walk_on(world, track, height_m=height_m, on=job.ground_names)


def _poses(begun: Begun) -> tuple[Matrices, str, Floats | None]:
    """Poses (P, 4, 4), in words where they come from, and when they are, where that is known."""
    job = begun.job
    if job.path is not None and job.on_ground is not None:
        track = load_track(job.path, lost=job.lost)
        text = f"track {os.fsdecode(job.path)}"
        return _walked(begun, track, job.on_ground), text, track.times_s
    if job.path is not None:
        matrices, times_s = load_timed_poses(job.path)
        return matrices, f"path {os.fsdecode(job.path)}", times_s
    return *_untimed(begun), None


def _looking(position_m: ArrayLike, target_m: ArrayLike) -> Matrices:
    """(1, 4, 4), upright; straight up or down as of a head that has lifted or lowered its view from
    along -Z."""
    x, y, z = array_of(target_m, "look_at", (3,)) - array_of(position_m, "position", (3,))
    # As near to it as `look_at` takes no upright head.
    is_vertical = np.hypot(x, z) <= 2e-9 * abs(y)
    up = (0, 0, np.sign(y)) if is_vertical and y != 0 else (0, 1, 0)
    return _core.look_at(position_m, target_m, up)[None]


def _untimed(begun: Begun) -> tuple[Matrices, str]:
    """Poses of which nothing says when they are."""
    job, camera = begun.job, begun.camera
    if job.poses is not None:
        matrices = as_poses(job.poses)
        if not np.isfinite(matrices).all():
            raise Error("poses: expected finite numbers")
        return matrices, "poses that were given"
    if job.position is not None and job.look_at is not None:
        return _looking(job.position, job.look_at), "position, looking at a point"
    if job.position is not None:
        return poses_from_angles(job.position, (0, 0, 0)), "position, looking along -Z"
    if camera is not None:
        return camera.world_from_camera[None], f"camera {camera.name}"
    return np.eye(4)[None], "the origin, looking along -Z"
