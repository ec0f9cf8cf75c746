"""Several animals in one world, each with an eye and a body that the others see."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, expect
from omma.base.progress import Progress, share_of
from omma.rendering.call import Responses
from omma.rendering.moves import MOST_UNSEEN
from omma.rendering.renderer import Renderer
from omma.scene.world import World
from omma.scene.world_moves import indices_of

# Of transforms that are handed over at once.
_MOST_BYTES = 1 << 26


@checked
def render_agents(
    renderers: Sequence[Renderer],
    poses: ArrayLike,
    *,
    bodies: Sequence[Mapping[str | int, ArrayLike]] | None = None,
    times_s: ArrayLike | None = None,
    unseen_by_light: bool = False,
    progress: Progress | None = None,
) -> list[Responses]:
    """What each of several animals sees while all of them move, bodies and all.

    An animal's own eye does not see its body. The others do, and light does: its shadow and its
    mirror image are seen by all, but for itself where that is asked for.

    Args:
        renderers: the eye of each of A animals, in one world; several may have the same renderer.
        poses: ``world_from_head`` (T, A, 4, 4), m: where each head is in each frame.
        bodies: for each animal its things, names or indices of `World.instances`, and where each is
            held, ``head_from_node`` (4, 4), m: it goes where the head goes. None: nobody has one.
        times_s: (T,), s: when each frame is, for the animations of the scene and for renderers with
            an impulse response, as of `Renderer.render`.
        unseen_by_light: nobody sees the shadow or mirror image of its own body either, as of
            `Renderer.render`.
        progress: called with the finished share (0 to 1) a few times a second; what it raises ends
            the work and is raised here.

    Returns:
        for each animal its responses, (T, N, C) of its eye. Afterwards all things are where they
        were.

    Raises:
        omma.Error: renderers of several worlds, a thing that is part of two bodies, a wrong shape,
            and as `Renderer.render`.
    """
    animals = len(renderers)
    if animals == 0:
        raise Error("renderers: expected one or more, found none")
    for a, renderer in enumerate(renderers):
        expect(renderer, Renderer, f"renderers[{a}]", "omma.Renderer(world, eye) makes one")
    world = renderers[0].world
    for a, renderer in enumerate(renderers):
        if renderer.world is not world:
            raise Error(f"renderers[{a}]: expected one of the world of renderers[0], found another")
    heads = array_of(poses, "poses", ("frames", animals, 4, 4))
    frames = len(heads)
    lost = np.argwhere(~np.isfinite(heads).all(axis=(2, 3)))
    if len(lost):
        raise Error(f"poses[{lost[0, 0]}, {lost[0, 1]}]: expected finite numbers, found others")
    times = None if times_s is None else array_of(times_s, "times_s", (frames,))
    lasting = any(one.settings.impulse_response is not None for one in renderers)
    if lasting and times is not None and not np.all(np.diff(times) > 0):
        raise Error("times_s: expected times that grow, as frames last, found others")
    held = _held(world, bodies, animals)
    things = [thing for own, _ in held for thing in own]
    placed = np.concatenate([heads[:, a, None] @ held[a][1] for a in range(animals)], axis=1)
    responses = [np.empty((frames, len(one.eye), one.bands), np.float32) for one in renderers]
    done = 0.0
    for group in _rendered_together(renderers):
        renderer, size = renderers[group[0]], len(group)
        lasts = renderer.settings.impulse_response is not None
        at_once = frames if lasts else max(1, _MOST_BYTES // (128 * size * (1 + len(things))))
        for first in range(0, frames, at_once):
            piece = slice(first, min(first + at_once, frames))
            count = piece.stop - piece.start
            share = count * size / (frames * animals)
            options: dict[str, Any] = {
                "unseen": [held[a][0] for a in group] * count,
                "unseen_by_light": unseen_by_light,
                "progress": share_of(progress, done, min(done + share, 1.0)),
            }
            if things:
                options["instances"] = things
                options["transforms"] = np.repeat(placed[piece], size, axis=0)
            if times is not None:
                options["times_s"] = np.repeat(times[piece], size)
            found = renderer.render(heads[piece][:, group].reshape(-1, 4, 4), **options)
            done += share
            for k, a in enumerate(group):
                responses[a][piece] = found[k::size]
    return responses


def _rendered_together(renderers: Sequence[Renderer]) -> list[list[int]]:
    """Groups of animals that are rendered in one call: those with one renderer, at most as many as
    there are bits of a mask. Animals whose frames last are alone, as each has a path of its own."""
    groups: list[list[int]] = []
    for a, renderer in enumerate(renderers):
        lasts = renderer.settings.impulse_response is not None
        for group in groups:
            if renderers[group[0]] is renderer and not lasts and len(group) < MOST_UNSEEN:
                group.append(a)
                break
        else:
            groups.append([a])
    return groups


def _held(
    world: World, bodies: Sequence[Mapping[str | int, ArrayLike]] | None, animals: int
) -> list[tuple[list[int], NDArray[np.float64]]]:
    """For each animal its things, and where they are held, (K, 4, 4)."""
    if bodies is None:
        return [([], np.empty((0, 4, 4)))] * animals
    if len(bodies) != animals:
        raise Error(f"bodies: expected one for each of {animals} animals, found {len(bodies)}")
    found: list[tuple[list[int], NDArray[np.float64]]] = []
    owner: dict[int, int] = {}
    for a, body in enumerate(bodies):
        if not isinstance(body, Mapping):
            raise Error(f"bodies[{a}]: expected {{thing: head_from_node}}, found {body!r:.40}")
        held = np.empty((len(body), 4, 4))
        own = []
        for k, (name, matrix) in enumerate(body.items()):
            held[k] = array_of(matrix, f"bodies[{a}][{name!r}]", (4, 4))
            thing = int(indices_of(world, [name])[0])
            if thing in owner:
                raise Error(
                    f"bodies[{a}]: expected things of its own, found {name!r}, which is part of "
                    f"bodies[{owner[thing]}]"
                )
            owner[thing] = a
            own.append(thing)
        found.append((own, held))
    return found
