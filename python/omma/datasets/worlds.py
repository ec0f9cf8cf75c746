"""What a job is rendered with: its eyes, its worlds and renderers, each made once and kept.

A worker process keeps one `Workshop` for each job, whatever number of its threads make shards.
"""

from __future__ import annotations

import threading
import warnings
from collections import OrderedDict
from typing import Any

import numpy as np

from omma import light, species
from omma._core import Error, Eye, Scene
from omma.base.arguments import as_named, one_of
from omma.base.arrays import Floats
from omma.base.poses import Matrices, poses_from_angles
from omma.base.progress import Stage
from omma.datasets.free_space import FreeSpace
from omma.datasets.job_file import Job
from omma.datasets.job_inputs import Condition, EyeInput, PlacedObject, SceneInput
from omma.datasets.plan import Block
from omma.datasets.samplers import sample_poses, sample_velocities
from omma.datasets.walks import walk_poses, walk_velocities
from omma.eye.files import load_head
from omma.light import Bands, Light
from omma.rendering.renderer import Renderer
from omma.scene.backgrounds import parse_background
from omma.scene.building import BAKING, Baking
from omma.scene.capture_cameras import CaptureCameras, load_capture_cameras
from omma.scene.files import read_scene
from omma.scene.joining import merge_scenes, place_scene
from omma.scene.light_words import warnings_of
from omma.scene.world import World

# Worlds and walks that are kept: those that neighbouring shards share.
_WORLDS = 2
_WALKS = 4


def load_eyes(job: Job) -> dict[str, Eye]:
    """The eyes of a job, by name.

    Raises:
        omma.Error: one cannot be read, or has no receptors where they are an output.
    """
    found = {}
    for k, one in enumerate(job.eyes):
        eye = found[one.name] = _eye(one)
        if "receptors" in job.outputs and len(eye.receptor_type) == 0:
            raise Error(
                f"{job.path}, eye[{k}]: expected receptors, as they are among dataset.outputs, "
                f"found none in {one.name!r}; omma.receptors.assign_receptors gives it some"
            )
    return found


def load_cameras(job: Job) -> dict[str, CaptureCameras]:
    """From which captured scenes are known, by the scene's name."""
    found = {}
    for one in job.scenes:
        if one.capture is not None:
            given = one.capture
            with as_named(unit="capture_unit", up="capture_up"):
                found[one.name] = load_capture_cameras(given.path, unit=given.unit, up=given.up)
    return found


def make_light(condition: str, sky: str, options: dict[str, Any], bands: int) -> Light | None:
    """What lights the worlds of a condition of that name; None where nothing does."""
    if not sky:
        return None
    chosen = Bands.equal(bands) if bands else Bands.equal()
    try:
        made: Light = getattr(light, sky)(bands=chosen, **options)
    except (Error, TypeError) as error:
        raise Error(f"condition {condition!r}, light: {error}") from None
    return made


class Workshop:
    """Everything that shards of a job are made with."""

    def __init__(
        self, job: Job, digests: dict[str, str], threads: int = 0, tell: Stage | None = None
    ) -> None:
        """``digests``: of the inputs, as they were when the data set was begun; ``tell`` is told of
        light that is baked."""
        self.job, self._tell = job, tell
        self.eyes = load_eyes(job)
        self._cameras = load_cameras(job)
        self._digests, self._threads = digests, threads
        self.warnings: dict[str, None] = {}
        """What there is to warn of the scenes that were read, in their order."""
        files = [file for one in job.eyes for file in one.files]
        files += [file for one in job.poses for file in one.files]
        files += [file for one in job.scenes if one.capture for file in one.capture.files]
        for file in files:
            self._check(file)
        self._lock = threading.Lock()  # threads of one worker wait for the world one of them builds
        self._worlds: OrderedDict[tuple[Any, ...], tuple[World, FreeSpace]] = OrderedDict()
        self._renderers: dict[tuple[int, int, str], Renderer] = {}
        self._walks: OrderedDict[tuple[Any, ...], Matrices] = OrderedDict()

    def renderer(self, block: Block, eye: str) -> Renderer:
        """What renders the views of a block for an eye."""
        with self._lock:
            scene, condition = self.job.scenes[block.scene], self.job.conditions[block.condition]
            world, _ = self._world(scene, condition)
            key = (block.scene, block.condition, eye)
            if key not in self._renderers:
                self._renderers[key] = Renderer(
                    self._lit(block, world, condition),
                    self.eyes[eye],
                    self.job.settings.sampling,
                    threads=self._threads,
                    **self.job.settings.options(),
                )
            return self._renderers[key]

    def cameras(self, block: Block) -> CaptureCameras | None:
        """From which the scene of a block is known, where it was captured."""
        return self._cameras.get(self.job.scenes[block.scene].name)

    def poses(self, block: Block, numbers: range) -> Matrices:
        """The poses (P, 4, 4) of a block with these numbers."""
        scene, condition = self.job.scenes[block.scene], self.job.conditions[block.condition]
        poses = self.job.poses[block.poses]
        with self._lock:
            _, space = self._world(scene, condition)
        if not poses.is_walk:
            return sample_poses(poses, self.job.seed, scene.name, numbers, space)
        found, first = self._walked(block, numbers)
        return found[numbers.start - first : numbers.stop - first]

    def velocities(self, block: Block, numbers: range, made: Matrices) -> tuple[Floats, Floats]:
        """How heads move at the poses of a block with these numbers, ``made`` (P, 4, 4): linear
        (P, 3), m/s, and angular velocity (P, 3), rad/s, in the world's frame."""
        scene, poses = self.job.scenes[block.scene], self.job.poses[block.poses]
        if not poses.is_walk:
            return sample_velocities(poses, self.job.seed, scene.name, numbers, made)
        found, first = self._walked(block, numbers)
        linear, angular = walk_velocities(poses, found)
        some = slice(numbers.start - first, numbers.stop - first)
        return linear[some], angular[some]

    def _walked(self, block: Block, numbers: range) -> tuple[Matrices, int]:
        """Whole walks that have the poses with these numbers, and the number of their first."""
        scene, condition = self.job.scenes[block.scene], self.job.conditions[block.condition]
        poses = self.job.poses[block.poses]
        with self._lock:
            _, space = self._world(scene, condition)
        walks = range(numbers.start // poses.steps, -(-numbers.stop // poses.steps))
        key = (block.scene, condition.objects, block.poses, walks)
        found = self._walks.get(key)
        if found is None:
            found = walk_poses(poses, self.job.seed, scene.name, walks, space)
            self._walks[key] = found
            while len(self._walks) > _WALKS:
                self._walks.popitem(last=False)
        return found, walks.start * poses.steps

    def _world(self, scene: SceneInput, condition: Condition) -> tuple[World, FreeSpace]:
        """A scene and what a condition puts into it, without light, and the `FreeSpace` that asks
        it for free space."""
        key = (scene.name, condition.objects)
        if key not in self._worlds:
            while len(self._worlds) >= _WORLDS:
                self._worlds.popitem(last=False)
                self._renderers.clear()
            parts = [self._read(scene.file, scene.options)]
            parts += [_placed(self._read(one.file, {}), one) for one in condition.objects]
            whole = parts[0] if len(parts) == 1 else merge_scenes(parts)
            job = self.job
            world = World(whole, threads=self._threads, backend=job.backend, devices=job.devices)
            self._worlds[key] = (world, FreeSpace(world, self._threads))
        self._worlds.move_to_end(key)
        return self._worlds[key]

    def _lit(self, block: Block, world: World, condition: Condition) -> World:
        """The world that all eyes see: light is baked once for them."""
        for (scene, of_condition, _), renderer in self._renderers.items():
            if (scene, of_condition) == (block.scene, block.condition):
                return renderer.world
        return self._in_condition(world, self.job.scenes[block.scene], condition)

    def _in_condition(self, world: World, scene: SceneInput, condition: Condition) -> World:
        if condition.background:
            world = world.with_background(parse_background(condition.background))
        made = make_light(*condition.light, self.job.bands)
        if made is None:
            return world
        baking = None
        if self._tell is not None and condition.world_options["lighting"] == "baked":
            where = f" in {scene.name!r}" if len(self.job.scenes) > 1 else ""
            baking = Baking(self._tell, f"{BAKING} of {condition.name!r}{where}")
        return world.with_light(made, **condition.world_options, progress=baking)

    def _check(self, file: str) -> None:
        """omma.Error where a file is not what the data set was begun with."""
        for name, digest in self.job.digests(file).items():
            if self._digests.get(name) != digest:
                raise Error(f"{name}: has changed since the data set was begun")

    def _read(self, file: str, options: dict[str, Any]) -> Scene:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = read_scene(file, **options)
        is_lit = any(one.sky for one in self.job.conditions)
        told = (f"{file}: {sentence}" for sentence in warnings_of(scene, is_lit))
        self.warnings |= dict.fromkeys(told)
        self._check(file)
        return scene


def backend_of(job: Job) -> str:
    """What renders a job's views here."""
    world = World(Scene(), backend=job.backend, devices=job.devices, threads=1)
    return world.backend


def check_instances(job: Job) -> None:
    """omma.Error where none of a job's scenes has a thing whose share of the field it asks for."""
    files = {one.file: one.options for one in job.scenes}
    for condition in job.conditions:
        files |= {one.file: {} for one in condition.objects if one.file not in files}
    known: dict[str, None] = {}
    for file, options in files.items() if job.instances else ():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            known |= dict.fromkeys(names_of_things(read_scene(file, **options)))
    for name in job.instances:
        one_of(name, sorted(known), f"{job.path}, dataset.instances")


def names_of_things(scene: Scene) -> list[str]:
    """Of instances and clouds of splats, whose shares of the field can be told."""
    return [*(one.name for one in scene.instances), *(one.name for one in scene.splats)]


def _eye(one: EyeInput) -> Eye:
    if one.species:
        return species.make(one.species).eye
    return load_head(one.files, one.unit)


def _placed(scene: Scene, one: PlacedObject) -> Scene:
    pose = poses_from_angles(np.array(one.position_m), (one.yaw_deg, 0, 0))[0]
    pose[:3, :3] *= one.scale
    # Its cameras are of no use here, and may have names that the scene's have too.
    return place_scene(scene.replace(cameras=[]), pose)
