"""What ground truth was made with, and whether that is what a data set is to say of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of
from omma.base.poses import Matrices
from omma.rendering.call import Call, Prepared
from omma.rendering.moves import Moves, MovesOptions, Things
from omma.rendering.moves_told import MovesTold
from omma.rendering.settings import Settings, frame_number, settings_as_record

# Of the numbers of a pose: as far as single precision rounds them, two are the same.
_ROUNDED = 2.0**-23


@dataclass(frozen=True)
class Origin:
    """What ground truth was rendered with, besides its poses, its eye and its world."""

    settings: Settings
    first_pose: int | None
    """Number of the first pose's frame; None where noise is frozen and none was given."""
    times_s: NDArray[np.float64] | None
    things: Things
    told: MovesTold

    @classmethod
    def of(cls, call: Call) -> Origin:
        """Of a call that was rendered."""
        names, indices, transforms = call.moves.things()
        things = names, indices.copy(), transforms.copy()
        times = call.moves.times_s
        copied = None if times is None else times.copy()
        return cls(call.renderer.settings, call.first_frame, copied, things, call.moves.told())


def check_origin(origin: Origin, renderer: Prepared, first_pose: int | None) -> None:
    """omma.Error where ground truth was rendered with other settings or as other frames."""
    here, there = (settings_as_record(one) for one in (renderer.settings, origin.settings))
    for name in here | there:
        if here.get(name) != there.get(name):
            raise Error(
                f"truth: expected that of a renderer with this one's settings, {name} "
                f"{here.get(name)}, found {there.get(name)}"
            )
    number = frame_number(first_pose)
    is_frozen = renderer.settings.is_noise_frozen
    if not is_frozen and number is not None and number != origin.first_pose:
        raise Error(
            f"first_pose: expected {origin.first_pose}, as of truth, or None, found {number}"
        )


def moves_of(
    origin: Origin | None, renderer: Prepared, matrices: Matrices, moves: MovesOptions
) -> tuple[Things, MovesTold]:
    """Where things were that were moved, and how else the scene was asked for: as ground truth has
    it, and else as the caller says; omma.Error where they do not agree."""
    asked: MovesOptions = {
        "instances": moves.get("instances"),
        "transforms": moves.get("transforms"),
        "unseen": moves.get("unseen"),
        "past": moves.get("past"),
    }
    by_light = moves.get("unseen_by_light")
    if origin is None or moves.get("unseen") is not None:
        asked["unseen_by_light"] = by_light
    given = Moves(renderer.world, matrices, asked, None)
    told = given.told().with_animation(renderer.world.scene, moves.get("animation"))
    if origin is None:
        return given.things(), told
    for name in ("animation", "unseen"):
        if moves.get(name) is not None and told.differs(origin.told, name):
            raise Error(f"{name}: expected that of truth, or None, found another")
    known = "unseen_by_light" in origin.told.attributes
    if by_light is not None and bool(by_light) != known:
        raise Error(f"unseen_by_light: expected {known}, as of truth, or None, found {by_light}")
    return _things_of(origin, given.things(), moves), origin.told


def _things_of(origin: Origin, told: Things, moves: MovesOptions) -> Things:
    if moves.get("instances") is None:
        return origin.things
    _, indices, transforms = told
    names, known, moved = origin.things
    if set(indices.tolist()) != set(known.tolist()):
        raise Error(f"instances: expected {names}, which truth has moved, found {told[0]}")
    order = [known.tolist().index(index) for index in indices.tolist()]
    near = np.isclose(moved[:, order], transforms, rtol=_ROUNDED, atol=_ROUNDED)
    other = np.argwhere(~near.all(axis=(2, 3)))
    if len(other) > 0:
        pose, thing = other[0].tolist()
        raise Error(
            f"transforms: expected those of truth, found others: of '{told[0][thing]}' at pose "
            f"{pose}"
        )
    return told


def times_of(
    origin: Origin | None, given: ArrayLike | None, count: int
) -> NDArray[np.float64] | None:
    """When each of so many poses is, s: as the caller says, and else as ground truth was rendered;
    omma.Error where they do not agree.
    """
    known = None if origin is None else origin.times_s
    if given is None:
        return known
    times: NDArray[np.float64] = array_of(given, "time_s", (count,), finite=True)
    if known is not None:
        other = np.flatnonzero(~np.isclose(times, known, rtol=_ROUNDED, atol=0))
        if len(other) > 0:
            raise Error(
                f"time_s: expected the times of truth, found others: pose {other[0]} at "
                f"{times[other[0]]:g} s here, {known[other[0]]:g} s there"
            )
    return times
