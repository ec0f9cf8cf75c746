"""Methods of `omma.World` that move its things and change their shape."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Camera, Error, Scene, WorldInstance
from omma.base.arguments import array_of, checked, whole
from omma.base.methods import method_of
from omma.base.progress import Progress
from omma.scene.rig_parts import RigParts
from omma.scene.world_changes import Changes

Animations = str | int
Instances = str | int | Sequence[str | int] | NDArray[np.integer]


class Movable(Protocol):
    """What moving needs of `omma.World`."""

    _engine: _core.World
    _moved: dict[int, NDArray[np.float64]]
    _last_at: list[tuple[float, Animations | None]]
    _changes: Changes

    @property
    def _rig_parts(self) -> RigParts: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def instances(self) -> list[WorldInstance]: ...
    def index(self, name: str) -> int: ...


M = TypeVar("M", bound=Movable)
_world_method = method_of("omma.scene.world", "World")


@_world_method
def set_transforms(
    self: Movable,
    instances: Instances,
    transforms: ArrayLike,
    *,
    progress: Progress | None = None,
) -> None:
    """Move things to where they are seen from now on, by all renderers of this world.

    The first time that something moves, what does not is built again without it: as long as
    making the world takes. From then on it costs some microseconds for each thing that moves
    (docs/motion-and-time.md). Moving something back gives what was seen before to within single
    precision.

    Args:
        instances: which: a name or an index in `instances`, or K of them.
        transforms: ``world_from_node``, (4, 4) or (K, 4, 4), m: where each is to be, not by how
            much it is moved. May mirror, but not flatten.
        progress: called with the finished share (0 to 1) where all is built again. What it
            raises ends that and is raised here; so does Ctrl-C.

    Raises:
        omma.Error: no such thing, one twice, a transform that is not finite or not invertible,
            or that takes something over 1e12 m away; something of this world is being rendered,
            in another thread or by the call whose progress function this is; or this is a
            process made by fork. All is then where it was.
    """
    indices = indices_of(self, instances)
    matrices = array_of(transforms, "transforms")
    if matrices.ndim == 2:
        matrices = matrices[None]
    if matrices.shape != (len(indices), 4, 4):
        raise Error(
            f"transforms: expected shape ({len(indices)}, 4, 4), found {np.shape(transforms)}"
        )
    before = _places_before(self, indices)
    self._engine.set_transforms(indices, np.ascontiguousarray(matrices), progress)
    self._moved.update(before)
    self._changes.note()


@checked
@_world_method
def at(
    self: M,
    time_s: float,
    animation: Animations | None = None,
    *,
    progress: Progress | None = None,
) -> M:
    """Move all that the scene's animations move to where it is at a time; returns the world.

    Nodes go where their animations say, and meshes take the shape that their bones and morph
    targets give them. Before its first key an animation is as at the first, after its last as
    at the last. What `set_transforms` has put elsewhere comes back where an animation moves it;
    what bones bend can be put anywhere by it. Cameras that are named from now on, as to `render`
    and `render_camera`, are where they are then. The first time costs what the first
    `set_transforms` does (docs/motion-and-time.md).

    Args:
        time_s: s, of the animations' own time.
        animation: which: a name or an index in ``scene.animations``; what only others move is
            as the file has it. None: all of them together.
        progress: as of `set_transforms`.

    Raises:
        omma.Error: there is no such animation; two of all of them move the same; something is
            flattened then, as where its scale is 0; or what `set_transforms` raises.
    """
    before = _places_before(self, self._engine.animated)
    self._engine.set_time(float(time_s), animations_of(self.scene, animation), progress)
    self._moved.update(before)
    self._last_at[:] = [(float(time_s), animation)]
    self._changes.note()
    return self


@checked
@_world_method
def camera_at(
    self: Movable, name_or_index: str | int, time_s: float, animation: Animations | None = None
) -> NDArray[np.float64]:
    """The pose ``world_from_camera`` (4, 4) of a camera of the scene at a time, s.

    It moves as the scene's animations say, in the world as the file has it; where none moves
    it, it is where it always is.

    Args:
        name_or_index: as `Scene.camera` takes it.
        time_s, animation: as of `at`.

    Raises:
        omma.Error: no such camera or animation.
    """
    index = _camera_index(self.scene, name_or_index)
    animations = animations_of(self.scene, animation).tolist()
    return _core.camera_at(self.scene, index, float(time_s), animations)


@checked
@_world_method
def set_vertices(
    self: Movable,
    mesh: int,
    positions_m: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    progress: Progress | None = None,
) -> None:
    """Give a mesh another shape, for all its instances and all renderers of this world.

    The scene keeps its own. The first time costs what the first `set_transforms` does, and the
    mesh's instances count as moved; from then on its hierarchy is fitted to the new positions
    (docs/motion-and-time.md).

    Args:
        mesh: which, an index in ``scene.meshes``.
        positions_m: (V, 3), m, of each of its vertices, in its own frame.
        normals: (V, 3), where it has normals. None: those of its triangles, the mean around
            each vertex, weighed by area.
        progress: as of `set_transforms`.

    Raises:
        omma.Error: no such mesh, a wrong shape, a number that is not finite, or what
            `set_transforms` raises.
    """
    which = whole(mesh, "mesh", 0, (1 << 31) - 1)
    across = None if normals is None else _vectors(normals, "normals")
    positions = _vectors(positions_m, "positions_m")
    self._engine.set_vertices(which, positions, across, progress)
    self._changes.note()


@checked
@_world_method
def vertices(self: Movable, mesh: int) -> NDArray[np.float32]:
    """The vertices of a mesh as it is now: (V, 3), m, in its own frame.

    Args:
        mesh: an index in ``scene.meshes``.

    Raises:
        omma.Error: no such mesh.
    """
    return self._engine.positions(whole(mesh, "mesh", 0, (1 << 31) - 1))


def indices_of(world: Movable, instances: Instances) -> NDArray[np.int32]:
    """Indices in `instances` of what is given by names or indices."""
    listed: Any = instances
    if isinstance(instances, str) or not hasattr(instances, "__iter__"):
        listed = [instances]
    indices = [
        world.index(one)
        if isinstance(one, str)
        else whole(one, f"instances[{k}]", 0, (1 << 31) - 1)
        for k, one in enumerate(listed)
    ]
    return np.array(indices, np.int32)


def camera_now(world: Movable, name_or_index: str | int) -> Camera:
    """A camera as the world has it now: where animations move it, at the time of the last
    `World.at`; else where the scene has it."""
    camera = world.scene.camera(name_or_index)
    if not world._last_at:
        return camera
    ((time_s, animation),) = world._last_at
    pose = camera_path(world, name_or_index, [time_s], animation)[0]
    return camera.replace(world_from_camera=pose)


def camera_path(
    world: Movable, name_or_index: str | int, times_s: ArrayLike, animation: Animations | None
) -> NDArray[np.float64]:
    """Where a camera is at these times, (P, 4, 4): where animations move it, as they say, else
    where the scene has it."""
    times = array_of(times_s, "times_s", (None,)).tolist()
    index = _camera_index(world.scene, name_or_index)
    animations = animations_of(world.scene, animation).tolist()
    if not world._rig_parts.moves_camera(index, animations):
        pose = world.scene.cameras[index].world_from_camera
        return np.tile(pose, (len(times), 1, 1))
    poses = [_core.camera_at(world.scene, index, time_s, animations) for time_s in times]
    return np.array(poses).reshape(-1, 4, 4)


def animations_of(scene: Scene, animation: Animations | None) -> NDArray[np.int32]:
    """Indices in ``scene.animations``; none for all."""
    if animation is None:
        return np.empty(0, np.int32)
    if isinstance(animation, str):
        return np.array([_core.find_animation(scene, animation)], np.int32)
    return np.array([whole(animation, "animation", 0, (1 << 31) - 1)], np.int32)


def note_moves(world: Movable, indices: NDArray[np.int32], animated: bool) -> None:
    """Remember what a render has moved and put back."""
    things = [*indices.tolist(), *(world._engine.animated if animated else ())]
    world._moved.update(_places_before(world, things))


def _camera_index(scene: Scene, name_or_index: str | int) -> int:
    camera = scene.camera(name_or_index)
    return scene.cameras.index(camera) if isinstance(name_or_index, str) else int(name_or_index)


def _places_before(world: Movable, indices: Iterable[int]) -> dict[int, NDArray[np.float64]]:
    """Where those of these things are that have never been moved."""
    new = {int(index) for index in indices} - world._moved.keys()
    instances = world.instances if new else []
    return {k: instances[k].world_from_node for k in sorted(new) if k < len(instances)}


def _vectors(values: ArrayLike, name: str) -> NDArray[np.float32]:
    return np.ascontiguousarray(array_of(values, name, (None, 3), np.float32))
