"""One call of the engine: what is asked for is converted once and checked once, here; nothing else
knows the engine's arguments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from threading import Lock
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Eye, Scene
from omma.base.arrays import new_floats
from omma.base.card_arrays import OnCard
from omma.base.poses import Matrices, as_poses
from omma.base.progress import Progress, share_of
from omma.rendering.moves import Moves, MovesOptions
from omma.rendering.pose_warnings import warn_of_poses
from omma.rendering.receptor_views import ReceptorViews
from omma.rendering.settings import Settings, frame_number
from omma.scene.world import World
from omma.scene.world_moves import camera_now, camera_path

Responses = NDArray[np.float32]
# Where responses are written.
Target = Responses | OnCard
Poses = ArrayLike | tuple[ArrayLike, ArrayLike] | str


class FrameCount:
    """Numbers of frames with new noise, counted on from call to call, from 0."""

    def __init__(self) -> None:
        self._next = 0
        self._lock = Lock()

    def take(self, count: int) -> int:
        """The number of the first of the next ``count`` frames."""
        with self._lock:
            first = self._next
            self._next += count
        return first


class Prepared(Protocol):
    """What a call needs of `omma.Renderer`, whose methods make calls."""

    _engine: _core.Renderer
    _frames: FrameCount

    @property
    def world(self) -> World: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def eye(self) -> Eye: ...
    @property
    def settings(self) -> Settings: ...
    @property
    def bands(self) -> int: ...
    @property
    def backend(self) -> str: ...
    @property
    def with_eye(self) -> Callable[..., Prepared]: ...
    @property
    def with_world(self) -> Callable[[World], Prepared]: ...
    def _receptor_views(self) -> tuple[ReceptorViews, Prepared]: ...


@dataclass(frozen=True)
class Frames:
    """What a call gives: arrays that the engine writes into."""

    responses: Responses
    """(P, N, C), or (P, R) of receptors."""
    standard_error: Responses | None = None
    """Of each response, where asked for."""
    rays: NDArray[np.int32] | None = None
    """(P, N), spent to reach an error, where asked for."""

    @property
    def returned(self) -> Responses | tuple[Responses, Responses]:
        """As methods of a renderer return them: with their errors where there are any."""
        if self.standard_error is None:
            return self.responses
        return self.responses, self.standard_error


@dataclass(frozen=True)
class Call:
    """Some poses that a renderer is to go through, and what moves from one to the next."""

    renderer: Prepared
    poses: Matrices
    moves: Moves
    first_frame: int | None
    """The number of the first pose's frame; None: frames are counted on."""
    progress: Progress | None
    tells_of_poses: bool = True
    """Whether the user is told what is odd about the poses."""

    @classmethod
    def of(
        cls,
        renderer: Prepared,
        poses: Poses,
        moves: MovesOptions,
        first_pose: int | None,
        progress: Progress | None = None,
        *,
        tells_flow: bool = False,
    ) -> Call:
        """What a user asks for, in arrays.

        Args:
            tells_flow: as of `Moves`.

        Raises:
            omma.Error: an argument is not what `Renderer.render` says.
            TypeError: ``first_pose`` is no whole number.
        """
        matrices = poses_of(renderer, poses, moves)
        impulse_response = renderer.settings.impulse_response
        moving = Moves(renderer.world, matrices, moves, impulse_response, tells_flow)
        return cls(renderer, matrices, moving, frame_number(first_pose), progress)

    @property
    def size(self) -> tuple[int, int]:
        """Numbers of poses and of ommatidia."""
        return len(self.poses), len(self.renderer.eye)

    def numbered(self) -> Call:
        """The same, with the number of its first frame where noise is new in every frame."""
        if self.first_frame is not None or self.renderer.settings.is_noise_frozen:
            return self
        return replace(self, first_frame=self.renderer._frames.take(len(self.poses)))

    def quiet(self) -> Call:
        """The same of poses that no user has given."""
        return replace(self, tells_of_poses=False)

    def piece(self, first: int, count: int) -> Call:
        """The same of some of the poses, with their share of the progress."""
        poses = self.poses[first : first + count]
        return replace(
            self,
            poses=poses,
            moves=self.moves.piece(first, count),
            first_frame=None if self.first_frame is None else self.first_frame + first,
            progress=share_of(
                self.progress, first / len(self.poses), (first + len(poses)) / len(self.poses)
            ),
        )

    def new_frames(
        self, outputs: int | None = None, *, standard_error: bool = False, rays: bool = False
    ) -> Frames:
        """Arrays for the engine to write into: so many outputs, or else the bands."""
        shape = (*self.size, self.renderer.bands if outputs is None else outputs)
        return Frames(
            new_floats(shape),
            new_floats(shape) if standard_error else None,
            np.empty(self.size, np.int32) if rays else None,
        )

    def new_beside(self) -> Responses:
        """An array for what is seen beside rays and for its moments: float32 (P, N, 5, C)."""
        return np.empty((*self.size, 5, self.renderer.bands), np.float32)

    def render(
        self,
        frames: Frames,
        *,
        output_from_band: NDArray[np.float64] | None = None,
        stokes: bool = False,
        ray_radiance: NDArray[np.float32] | None = None,
        beside_rays: NDArray[np.float32] | None = None,
    ) -> Frames:
        """Have the engine fill the frames, and return them.

        Args:
            frames: with arrays for what is asked for.
            output_from_band: (outputs, components x bands), mixtures that are responses; None: the
                bands are.
            stokes: responses are I, Q and U of each band.
            ray_radiance: (P, N, samples, C), for the radiance of each ray.
            beside_rays: `new_beside`, for what responses have besides the mean of those: the discs
                of sun and moon, and what ommatidia aim at; and behind it its moments, θ² and three
                across the axis (omma/render.h).
        """
        self.renderer._engine.render(
            self.poses,
            frames.responses,
            frames.standard_error,
            frames.rays,
            ray_radiance,
            beside_rays,
            self.numbered().first_frame,
            output_from_band,
            stokes,
            self.moves.for_engine(),
            self.progress,
        )
        self._tell()
        return frames

    def render_into(
        self, responses: Target, errors: Target | None, rays: NDArray[np.int32] | None
    ) -> None:
        """Have the engine fill arrays of a caller's, which may lie on a graphics card."""
        self.renderer._engine.render(
            self.poses,
            _for_engine(responses),
            None if errors is None else _for_engine(errors),
            rays,
            None,
            None,
            self.numbered().first_frame,
            None,
            False,
            self.moves.for_engine(),
            self.progress,
        )
        self._tell()

    def render_truth(self, arrays: dict[str, NDArray[np.generic]]) -> None:
        """Have the engine fill arrays by name with responses and ground truth; some of them say
        what of (omma/truth.h)."""
        _core.render_truth(
            self.renderer._engine,
            self.poses,
            arrays,
            self.numbered().first_frame,
            self.moves.for_engine(),
            self.progress,
        )
        self._tell()

    def _tell(self) -> None:
        """Tell the world what has moved, and the user what is odd about the poses."""
        self.moves.note()
        if self.tells_of_poses:
            warn_of_poses(self.renderer._engine, self.poses)


def render_eyes(
    engine: _core.Renderer,
    poses: Matrices,
    frames: Frames,
    first_frame: int | None,
    progress: Progress | None,
    output_from_band: NDArray[np.float64] | None = None,
) -> None:
    """Have the engine of a population fill frames (P, N, C), at poses (P x E, 4, 4)."""
    engine.render(
        poses, frames.responses, frames.standard_error, None, None, None, first_frame,
        output_from_band, False, None, progress,
    )  # fmt: skip
    warn_of_poses(engine, poses)


def _for_engine(target: Target) -> Responses | _core.CardSpan:
    return target.span if isinstance(target, OnCard) else target


def poses_of(renderer: Prepared, poses: Poses, moves: MovesOptions | None = None) -> Matrices:
    """Poses in any form that a renderer takes, as (P, 4, 4). A camera's name is one for each of
    ``times_s``, and without these the camera as the world has it now."""
    if not isinstance(poses, str):
        return as_poses(poses)
    times = None if moves is None else moves.get("times_s")
    if moves is None or times is None:
        return as_poses(camera_now(renderer.world, poses).world_from_camera)
    return as_poses(camera_path(renderer.world, poses, times, moves.get("animation")))
