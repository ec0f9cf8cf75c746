"""One frame after the other, for more poses than memory holds: what `Renderer.render_iter` does."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from omma.base.dlpack import as_numpy
from omma.base.poses import Matrices, as_poses, is_position_pair
from omma.rendering.moves import MovesOptions

if TYPE_CHECKING:
    from omma.rendering.renderer import Renderer


def render_pieces(
    renderer: Renderer,
    poses: Any,
    moves: MovesOptions,
    count: int,
    standard_error: bool,
    first: int | None,
) -> Iterator[Any]:
    """Responses of each pose, or pairs with their errors; ``count`` poses are rendered at once.

    ``first``: the number of the first frame, as of `Renderer.render`.
    """
    done = 0
    for matrices, options in _pieces(renderer, poses, moves, count):
        at = None if first is None else first + done
        if standard_error:
            pair = renderer.render(matrices, standard_error=True, first_pose=at, **options)
            yield from zip(*pair, strict=True)
        else:
            yield from renderer.render(matrices, first_pose=at, **options)
        done += len(matrices)


def _pieces(
    renderer: Renderer, poses: Any, moves: MovesOptions, count: int
) -> Iterator[tuple[Matrices, MovesOptions]]:
    poses = as_numpy(poses, "poses")
    is_moving = any(given is not None for given in moves.values())
    if isinstance(poses, (str, np.ndarray)) or is_position_pair(poses) or is_moving:
        if not isinstance(poses, (str, np.ndarray, list, tuple)):
            raise TypeError(
                "poses: expected an array, as things move from pose to pose, found "
                f"{type(poses).__name__}"
            )
        matrices = renderer._matrices(poses)
        moving = renderer._moves(matrices, moves)
        for begin in range(0, len(matrices), count):
            piece = matrices[begin : begin + count]
            yield piece, moving.piece(begin, len(piece)).options()
    elif isinstance(poses, Iterable):
        source, done = iter(poses), 0
        while taken := list(itertools.islice(source, count)):
            yield as_poses(taken, done), {}
            done += len(taken)
    else:
        raise TypeError(f"poses: expected an array or an iterable, found {type(poses).__name__}")
