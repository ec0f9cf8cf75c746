"""A method of `omma.Renderer`: one frame after the other, for more poses than memory holds."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike

from omma.base.arguments import checked, whole
from omma.base.dlpack import as_numpy
from omma.base.poses import as_poses, is_position_pair
from omma.rendering.call import Call, Poses, Prepared, Responses
from omma.rendering.moves import MovesOptions, renderer_method
from omma.rendering.settings import frame_number

if TYPE_CHECKING:
    from typing_extensions import Unpack

# Big enough to keep all threads busy, small enough to forget about.
_CHUNK_BYTES = 32 << 20


@overload
def render_iter(
    self: Prepared,
    poses: Poses | Iterable[ArrayLike],
    *,
    standard_error: Literal[False] = False,
    chunk: int | None = None,
    first_pose: int | None = None,
    **moves: Unpack[MovesOptions],
) -> Iterator[Responses]: ...


@overload
def render_iter(
    self: Prepared,
    poses: Poses | Iterable[ArrayLike],
    *,
    standard_error: Literal[True],
    chunk: int | None = None,
    first_pose: int | None = None,
    **moves: Unpack[MovesOptions],
) -> Iterator[tuple[Responses, Responses]]: ...


@checked
@renderer_method
def render_iter(
    self: Prepared,
    poses: Poses | Iterable[ArrayLike],
    *,
    standard_error: bool = False,
    chunk: int | None = None,
    first_pose: int | None = None,
    **moves: Unpack[MovesOptions],
) -> Iterator[Responses] | Iterator[tuple[Responses, Responses]]:
    """Responses (N, C) of one pose after the other, for more poses than memory holds.

    Equal, bit for bit, to what `render` gives for all poses at once. Poses are taken from
    ``poses`` as they are needed, ``chunk`` at a time.

    Args:
        poses: as in `render`, or any iterable of (4, 4) matrices, a generator too.
        standard_error: yield pairs (responses, errors).
        chunk: poses rendered at once; None takes as many as fit into 32 MB. What was yielded
            stays valid, and keeps the memory of its chunk alive.
        first_pose: as in `render`.
        instances, transforms, times_s, animation, past, unseen, unseen_by_light: as in
            `render`, for all poses, which are then an array.

    Raises:
        omma.Error: as `render`, when the pose is reached.
    """
    count = _poses_at_once(self) if chunk is None else whole(chunk, "chunk", 1, 1 << 31)
    first = frame_number(first_pose)
    return _one_by_one(_pieces(self, poses, moves, count, first), standard_error)


def _poses_at_once(renderer: Prepared) -> int:
    pose_bytes = max(1, len(renderer.eye)) * renderer.bands * 4
    return max(1, min(4096, _CHUNK_BYTES // pose_bytes))


def _one_by_one(calls: Iterator[Call], standard_error: bool) -> Iterator[Any]:
    """Responses of each pose, or pairs with their errors."""
    for call in calls:
        frames = call.render(call.new_frames(standard_error=standard_error))
        if frames.standard_error is None:
            yield from frames.responses
        else:
            yield from zip(frames.responses, frames.standard_error, strict=True)


def _pieces(
    renderer: Prepared, poses: Any, moves: MovesOptions, count: int, first: int | None
) -> Iterator[Call]:
    """Calls for ``count`` poses each; ``first``: the number of the first frame."""
    poses = as_numpy(poses, "poses")
    is_moving = any(given is not None for given in moves.values())
    if isinstance(poses, (str, np.ndarray)) or is_position_pair(poses) or is_moving:
        if not isinstance(poses, (str, np.ndarray, list, tuple)):
            raise TypeError(
                "poses: expected an array, as things move from pose to pose, found "
                f"{type(poses).__name__}"
            )
        call = Call.of(renderer, poses, moves, first)
        for begin in range(0, len(call.poses), count):
            yield call.piece(begin, count)
    elif isinstance(poses, Iterable):
        source, done = iter(poses), 0
        while taken := list(itertools.islice(source, count)):
            at = None if first is None else first + done
            yield Call.of(renderer, as_poses(taken, done), {}, at)
            done += len(taken)
    else:
        raise TypeError(f"poses: expected an array or an iterable, found {type(poses).__name__}")
