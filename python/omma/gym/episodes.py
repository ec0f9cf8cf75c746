"""Episodes of a loop, as many at once as there are environments: where they go, what is seen there,
and what that is worth. Environments ask for poses, render them in one call and give back what is
seen.

`EpisodesInTurn` calls a loop's functions for one environment after another, `EpisodesTogether`
those of a batched loop for all at once. Both count environments along the first axis.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import array_of
from omma.base.arrays import Flags, Floats, Ints
from omma.base.poses import as_pose, as_poses
from omma.gym.loop import Loop, Moment, Responses
from omma.gym.states import check_states, choose, merge

# Poses (K, 4, 4), and where things are (K, T, 4, 4), None where a loop moves none.
Where = tuple[Floats, Floats | None]
# What was rendered, by the names of `Moment`: arrays (K, ...).
Views = dict[str, Responses]
Judged = tuple[Floats, Flags, Flags]

_MASK_FIRST = "reset: expected a reset() of all before one of some"


def episodes_of(loop: Loop, count: int) -> EpisodesInTurn | EpisodesTogether:
    """So many episodes of a loop."""
    return EpisodesTogether(loop, count) if loop.batched else EpisodesInTurn(loop, count)


class _Frames:
    """What each environment has seen last: one frame, or several where observations have them."""

    def __init__(self, frames: int | None) -> None:
        self._number = frames
        self._kept: Responses | None = None

    def add(self, responses: Responses, begun: Flags) -> Responses:
        """Observations, for the caller to keep; where an episode has begun the world is taken to
        have stood still before."""
        still = self._still(responses)
        if self._number is None or self._kept is None:
            self._kept = np.array(still, np.float32)
        else:
            self._kept = np.concatenate([self._kept[..., 1:], responses[..., None]], axis=-1)
            self._kept[begun] = still[begun]
        return np.array(self._kept)

    def begin(self, which: Ints, responses: Responses) -> Responses:
        """Observations of all, of whom some have begun an episode, with ``responses``."""
        assert self._kept is not None
        self._kept[which] = self._still(responses)
        return np.array(self._kept)

    def _still(self, responses: Responses) -> Responses:
        if self._number is None:
            return responses
        return np.broadcast_to(responses[..., None], (*responses.shape, self._number))


class EpisodesInTurn:
    """Episodes whose functions are called for one environment after another."""

    def __init__(self, loop: Loop, count: int) -> None:
        self._loop, self._count = loop, count
        self._steps = [-1] * count  # not begun
        self._states: list[Any] = [None] * count
        self._before: list[Any] = [None] * count
        self._actions: list[Any] = [None] * count
        self._begun = np.ones(count, bool)
        self._frames = _Frames(loop.frames)
        self._moments: list[Moment] = []
        self._poses: Floats | None = None

    def begin(self, rngs: Sequence[np.random.Generator]) -> Where:
        """Where all start."""
        returned = [self._start(k, rng) for k, rng in enumerate(rngs)]
        self._begun = np.ones(self._count, bool)
        return self._placed(returned)

    def advance(
        self, actions: Iterable[Any], over: Flags, rngs: Sequence[np.random.Generator]
    ) -> Where:
        """Where actions lead; those that are over start anew."""
        if self._steps[0] < 0:
            raise Error("step: expected reset() before it")
        returned = []
        for k, (action, starts, rng) in enumerate(zip(actions, over.tolist(), rngs, strict=True)):
            if starts:
                returned.append(self._start(k, rng))
                continue
            self._steps[k] += 1
            before = self._before[k] = self._states[k]
            self._actions[k] = action
            moved = _called(self._loop, self._count, "motion", before, action, rng)
            returned.append(_taken(self._loop, moved, "motion"))
            self._states[k] = moved[0]
        self._begun = over
        return self._placed(returned)

    def begin_some(self, which: Ints, rngs: Sequence[np.random.Generator]) -> Where:
        """Where some start anew, while the others stay."""
        if self._steps[0] < 0:
            raise Error(_MASK_FIRST)
        return self._placed([self._start(k, rngs[k]) for k in which.tolist()])

    def see_some(self, which: Ints, views: Views) -> Responses:
        """Observations of all, by what was rendered for those that have started anew."""
        return self._frames.begin(which, views["responses"])

    def see(self, views: Views) -> Responses:
        """Observations, by what was rendered at these poses."""
        assert self._poses is not None
        rows = [dict(zip(views, values)) for values in zip(*views.values())]
        self._moments = [
            Moment(state, before, action, pose, step=step, **row)
            for state, before, action, pose, step, row in zip(
                self._states, self._before, self._actions, self._poses, self._steps, rows,
                strict=True,
            )
        ]  # fmt: skip
        return self._frames.add(views["responses"], self._begun)

    def judged(self) -> Judged:
        """Rewards, which have ended, which are cut off; 0 and not, where an episode has begun."""
        loop = self._loop
        rewards = np.zeros(self._count)
        ended, cut_off = np.zeros(self._count, bool), np.zeros(self._count, bool)
        for k in np.flatnonzero(~self._begun).tolist():
            moment = self._moments[k]
            reward = _called(loop, self._count, "reward", moment)
            try:
                rewards[k] = worth = float(reward)
            except (TypeError, ValueError):
                worth = np.nan
            if not np.isfinite(worth):
                raise Error(f"reward: expected a finite number, found {reward!r:.40}")
            if loop.ended is not None:
                ended[k] = _is_over(_called(loop, self._count, "ended", moment))
            cut_off[k] = loop.most_steps is not None and self._steps[k] >= loop.most_steps
        return rewards, ended, cut_off

    def _start(self, k: int, rng: np.random.Generator) -> tuple[Any, Any, str]:
        self._steps[k], self._actions[k] = 0, None
        begun = _called(self._loop, self._count, "start", rng)
        taken = _taken(self._loop, begun, "start")
        self._states[k] = self._before[k] = begun[0]
        return taken

    def _placed(self, returned: list[tuple[Any, Any, str]]) -> Where:
        poses = [pose for pose, _, _ in returned]
        self._poses = _checked_at_once(poses)
        if self._poses is None:  # one by one, as errors say which function it was
            self._poses = np.stack([as_pose(pose, name) for pose, _, name in returned])
        things = len(self._loop.things)
        if not things:
            return self._poses, None
        placed = [
            array_of(transforms, f"{name}: transforms", (things, 4, 4))
            for _, transforms, name in returned
        ]
        return self._poses, np.stack(placed)


class EpisodesTogether:
    """Episodes of a batched loop, whose functions are called for all at once."""

    def __init__(self, loop: Loop, count: int) -> None:
        self._loop, self._count = loop, count
        self._steps: NDArray[np.int64] | None = None  # not begun
        self._states: Any = None
        self._before: Any = None
        self._actions: Any = None
        self._begun = np.ones(count, bool)
        self._frames = _Frames(loop.frames)
        self._moment: Moment | None = None
        self._poses = np.empty((count, 4, 4))

    def begin(self, rngs: Sequence[np.random.Generator]) -> Where:
        """Where all start; the one generator is theirs together."""
        self._steps = np.zeros(self._count, np.int64)
        self._begun, self._actions = np.ones(self._count, bool), None
        self._states, self._poses, things = self._started(self._count, rngs[0])
        self._before = self._states
        return self._poses, things

    def advance(self, actions: Any, over: Flags, rngs: Sequence[np.random.Generator]) -> Where:
        """Where actions lead, first all that go on; then those that are over start anew."""
        if self._steps is None:
            raise Error("step: expected reset() before it")
        given = np.empty(0) if isinstance(actions, (tuple, dict)) else np.asarray(actions)
        if given.dtype.kind not in "biuf" or given.shape[:1] != (self._count,):
            raise Error(
                f"actions: expected one array of {self._count} actions for a batched loop, found "
                f"{type(actions).__name__} {np.shape(given)}"
            )
        self._begun, self._actions = over, given
        if not over.any():
            self._steps, self._before = self._steps + 1, self._states
            self._states, self._poses, things = self._moved(self._states, given, rngs[0])
            return self._poses, things
        self._steps = np.where(over, 0, self._steps + 1)
        goes = np.flatnonzero(~over)
        begins = np.flatnonzero(over)
        old, moved = self._states, None
        if len(goes):
            moved = self._moved(choose(old, goes), given[goes], rngs[0])
        begun = self._started(len(begins), rngs[0])
        if moved is None:
            self._states, self._poses, things = begun
            self._before = self._states
            return self._poses, things
        self._states = merge(moved[0], goes, begun[0], begins)
        self._before = merge(choose(old, goes), goes, begun[0], begins)
        self._poses = merge(moved[1], goes, begun[1], begins)
        things = None if moved[2] is None else merge(moved[2], goes, begun[2], begins)
        return self._poses, things

    def begin_some(self, which: Ints, rngs: Sequence[np.random.Generator]) -> Where:
        """Where some start anew, while the others stay."""
        if self._steps is None:
            raise Error(_MASK_FIRST)
        states, poses, things = self._started(len(which), rngs[0])
        stays = np.setdiff1d(np.arange(self._count), which)
        if len(stays):
            states = merge(choose(self._states, stays), stays, states, which)
        self._states, self._steps = states, self._steps.copy()
        self._steps[which] = 0
        return poses, things

    def see_some(self, which: Ints, views: Views) -> Responses:
        """Observations of all, by what was rendered for those that have started anew."""
        return self._frames.begin(which, views["responses"])

    def see(self, views: Views) -> Responses:
        """Observations, by what was rendered at these poses."""
        self._moment = Moment(
            self._states, self._before, self._actions, self._poses, step=self._steps, **views
        )
        return self._frames.add(views["responses"], self._begun)

    def judged(self) -> Judged:
        """Rewards, which have ended, which are cut off; 0 and not, where an episode has begun."""
        loop, goes = self._loop, ~self._begun
        assert self._moment is not None
        assert self._steps is not None
        reward = _called(loop, self._count, "reward", self._moment)
        rewards = array_of(reward, "reward", (self._count,))
        bad = rewards[~np.isfinite(rewards)]
        if len(bad):
            raise Error(f"reward: expected finite numbers, found {bad[0]:g}")
        ended = np.zeros(self._count, bool)
        if loop.ended is not None:
            ended = np.asarray(_called(loop, self._count, "ended", self._moment))
            if ended.dtype != np.bool_ or ended.shape != (self._count,):
                raise Error(
                    f"ended: expected an array ({self._count},) of bool, found {ended.dtype} "
                    f"{ended.shape}"
                )
        cut_off = np.zeros(self._count, bool)
        if loop.most_steps is not None:
            cut_off = self._steps >= loop.most_steps
        return np.where(goes, rewards, 0.0), ended & goes, cut_off & goes

    def _started(self, count: int, rng: np.random.Generator) -> tuple[Any, Floats, Floats | None]:
        begun = _called(self._loop, self._count, "start", count, rng)
        return self._checked(begun, count, "start")

    def _moved(
        self, states: Any, actions: NDArray[Any], rng: np.random.Generator
    ) -> tuple[Any, Floats, Floats | None]:
        moved = _called(self._loop, self._count, "motion", states, actions, rng)
        return self._checked(moved, len(actions), "motion")

    def _checked(self, returned: Any, count: int, name: str) -> tuple[Any, Floats, Floats | None]:
        poses, transforms, _ = _taken(self._loop, returned, name)
        check_states(returned[0], count, name)
        try:
            matrices = as_poses(poses)
        except Error as error:
            raise Error(f"{name}: {error}") from None
        if len(matrices) != count:
            raise Error(f"{name}: expected poses ({count}, 4, 4), found {len(matrices)}")
        if transforms is None:
            return returned[0], matrices, None
        shape = (count, len(self._loop.things), 4, 4)
        return returned[0], matrices, array_of(transforms, f"{name}: transforms", shape)


def _called(loop: Loop, count: int, name: str, *arguments: Any) -> Any:
    """What a function of a loop returns; omma.Error where it changes the world that several
    environments see."""
    changes = loop.renderer.world._changes
    before = changes.count
    returned = getattr(loop, name)(*arguments)
    if count > 1 and changes.count != before:
        raise Error(
            f"{name}: expected it to leave the world as it is, which {count} environments share, "
            "found that it moved or changed it; a Loop with things= has start and motion return "
            "where each environment has its own"
        )
    return returned


def _taken(loop: Loop, returned: Any, name: str) -> tuple[Any, Any, str]:
    """The pose or poses and the transforms (None: no things) of what a function returned."""
    wanted = "(state, pose, transforms)" if loop.things else "(state, pose)"
    if not isinstance(returned, tuple) or len(returned) != (3 if loop.things else 2):
        is_tuple = isinstance(returned, tuple)
        found = f"a tuple of {len(returned)}" if is_tuple else f"{returned!r:.60}"
        raise Error(f"{name}: expected it to return {wanted}, found {found}")
    return returned[1], returned[2] if loop.things else None, name


def _is_over(said: Any) -> bool:
    """What ``ended`` said of one environment."""
    if said is None or np.size(said) != 1:
        found = "None" if said is None else f"{type(said).__name__} of shape {np.shape(said)}"
        raise Error(f"ended: expected True or False, found {found}")
    return bool(said)


def _checked_at_once(poses: list[Any]) -> Floats | None:
    """Poses (K, 4, 4); None where they are no matrices, or one is wrong."""
    if not all(isinstance(pose, np.ndarray) and pose.shape == (4, 4) for pose in poses):
        return None
    try:
        return as_poses(np.stack(poses))
    except (Error, TypeError, ValueError):
        return None


def see_poses(loop: Loop, limits: tuple[float, float], where: Where) -> Views:
    """What is seen at each pose, rendered in one call."""
    poses, transforms = where
    moves: Any = {}
    if transforms is not None:
        moves = {"instances": list(loop.things), "transforms": transforms}
    if loop.distances:
        truth = loop.renderer.ground_truth(poses, **moves)
        views = {
            "responses": truth.responses,
            "nearest_m": truth.nearest_m,
            "distance_m": truth.distance_m,
        }
    else:
        views = {"responses": loop.renderer.render(poses, **moves)}
    seen = views["responses"]
    least, largest = float(seen.min(initial=np.inf)), float(seen.max(initial=-np.inf))
    if least < limits[0] or largest > limits[1]:
        raise Error(
            f"bounds: expected responses from {limits[0]:g} to {limits[1]:g}, found {least:g} to "
            f"{largest:g}"
        )
    return views
