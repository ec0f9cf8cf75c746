"""What a closed loop is: who sees, how it moves by what it does, and what that is worth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import array_of, expect, whole
from omma.base.poses import as_poses
from omma.base.values import value_class
from omma.gym.bounds import response_bounds
from omma.rendering.renderer import Renderer

Floats = NDArray[np.float64]
Responses = NDArray[np.float32]

_MOST_FRAMES = 4096


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Moment:
    """What is so after a step: what rewards and ends are decided by.

    state, before: the caller's own, after the step and before it; at the start the same.
    action: what was done; None at the start.
    pose: ``world_from_head`` (4, 4), m.
    responses: (N, B), the frame that is seen now.
    step: how many steps have been taken since the start.
    nearest_m, distance_m: (N,), least and mean distance of what each ommatidium sees, infinite
        where it sees nothing, as of `Renderer.ground_truth`; None where the loop does not ask for
        ``distances``.
    """

    state: Any
    before: Any
    action: Any
    pose: Floats
    responses: Responses
    step: int
    nearest_m: Responses | None = None
    distance_m: Responses | None = None


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Loop:
    """A closed loop: an eye in a world, and plain functions that say the rest.

    `eye_env` makes a Gymnasium environment of it, `eye_vector_env` many whose frames are rendered
    together. A state is whatever the functions want it to be; they return a new one and leave the
    old one as it is.

    Attributes:
        renderer: who sees what; with frozen noise and without an impulse response, so that a frame
            depends on its pose alone.
        start: start(rng) -> (state, pose), where an episode begins; ``rng`` is the environment's
            `numpy.random.Generator`, pose is ``world_from_head`` (4, 4), m.
        motion: motion(state, action, rng) -> (state, pose), what an action does.
        reward: reward(moment) -> float, what came of it, by a `Moment`.
        action_space: a `gymnasium.spaces.Space`.
        ended: ended(moment) -> bool, whether the episode has come to its end, as by a collision;
            None: it never does.
        most_steps: after so many steps an episode is cut off; None: never.
        frames: None: observations are (N, B), the frame that is seen now; else (N, B, frames), the
            newest last. Before the first frame the world is taken to have stood still.
        distances: moments have distances, by the rays that the responses are made of; for
            renderers with `Fixed` or `ToError`.
        things: names or indices of K things that move besides the head; start and motion then
            return (state, pose, transforms), the last ``world_from_node`` (K, 4, 4), m.
        bounds: least and largest response, for the bounds of observations; a response beyond them
            is an error. None: `response_bounds` of the world.

    Raises:
        omma.Error: an argument is out of its range, or the renderer does not suit.
        TypeError: an argument is of another type.
    """

    renderer: Renderer
    start: Callable[[np.random.Generator], tuple[Any, ...]]
    motion: Callable[[Any, Any, np.random.Generator], tuple[Any, ...]]
    reward: Callable[[Moment], float]
    action_space: Any
    ended: Callable[[Moment], bool] | None = None
    most_steps: int | None = None
    frames: int | None = None
    distances: bool = False
    things: Sequence[str | int] = ()
    bounds: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        expect(self.renderer, Renderer, "renderer", "omma.Renderer(world, eye) makes one")
        for name in ("start", "motion", "reward", "ended"):
            function = getattr(self, name)
            if not callable(function) and not (name == "ended" and function is None):
                raise TypeError(f"{name}: expected a function, found {function!r:.40}")
        settings = self.renderer.settings
        if settings.noise != "frozen":
            raise Error(f"renderer: expected noise='frozen', found {settings.noise!r}")
        if settings.impulse_response is not None:
            raise Error("renderer: expected one without an impulse response, found one with")
        if self.most_steps is not None:
            whole(self.most_steps, "most_steps", 1, 2**62)
        if self.frames is not None:
            whole(self.frames, "frames", 1, _MOST_FRAMES)
        if self.bounds is not None:
            least, largest = array_of(self.bounds, "bounds", (2,))
            if not least < largest:
                raise Error(f"bounds: expected a least and a largest, found {self.bounds!r:.60}")

    def limits(self) -> tuple[float, float]:
        """Least and largest response, in single precision and not narrower."""
        least, largest = response_bounds(self.renderer.world) if self.bounds is None else (
            float(self.bounds[0]), float(self.bounds[1])
        )  # fmt: skip
        below = np.nextafter(np.float32(least), np.float32(-np.inf)) if least < 0 else least
        above = np.nextafter(np.float32(largest), np.float32(np.inf))
        return float(below), float(above)


class Episode:
    """One run of a loop, from start to start. Environments ask it for a pose, render it with those
    of others, and give it what is seen there."""

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        self._step = -1  # not begun
        self._state: Any = None
        self._before: Any = None
        self._action: Any = None
        self._pose = np.eye(4)
        self._frames: Responses | None = None

    def begin(self, rng: np.random.Generator) -> tuple[Floats, Floats | None]:
        """Where it starts: the pose, and where things are."""
        self._step, self._frames, self._action = 0, None, None
        where = self._taken(self._loop.start(rng), "start")
        self._before = self._state
        return where

    def move(self, action: Any, rng: np.random.Generator) -> tuple[Floats, Floats | None]:
        """Where an action leads: the pose, and where things are."""
        if self._step < 0:
            raise Error("step: expected reset() before it")
        self._step += 1
        self._before, self._action = self._state, action
        return self._taken(self._loop.motion(self._state, action, rng), "motion")

    def see(self, moment: dict[str, Any]) -> Moment:
        """What is so now, with what was rendered: responses, and distances if asked for."""
        responses = moment["responses"]
        if self._loop.frames is not None:
            before = self._frames
            if before is None:
                before = np.repeat(responses[..., None], self._loop.frames, axis=-1)
            self._frames = np.concatenate([before[..., 1:], responses[..., None]], axis=-1)
        return Moment(
            self._state, self._before, self._action, self._pose, step=self._step, **moment
        )

    def observation(self, moment: Moment) -> Responses:
        """As the environment gives it, for the caller to keep."""
        seen = moment.responses if self._frames is None else self._frames
        return np.array(seen, np.float32)

    def judged(self, moment: Moment) -> tuple[float, bool, bool]:
        """(reward, whether it has ended, whether it is cut off)."""
        loop = self._loop
        reward = loop.reward(moment)
        try:
            worth = float(reward)
        except (TypeError, ValueError):
            worth = np.nan
        if not np.isfinite(worth):
            raise Error(f"reward: expected a finite number, found {reward!r:.40}")
        ended = loop.ended is not None and bool(loop.ended(moment))
        return worth, ended, loop.most_steps is not None and self._step >= loop.most_steps

    def _taken(self, returned: Any, name: str) -> tuple[Floats, Floats | None]:
        things = len(self._loop.things)
        wanted = "(state, pose, transforms)" if things else "(state, pose)"
        if not isinstance(returned, tuple) or len(returned) != (3 if things else 2):
            raise Error(f"{name}: expected it to return {wanted}, found {returned!r:.60}")
        try:
            poses = as_poses(returned[1])
        except Error as error:
            raise Error(f"{name}: {error}") from None
        if len(poses) != 1:
            raise Error(f"{name}: expected one pose (4, 4), found {len(poses)}")
        self._state, self._pose = returned[0], poses[0].copy()
        if not things:
            return self._pose, None
        return self._pose, array_of(returned[2], f"{name}: transforms", (things, 4, 4))


def render_poses(
    loop: Loop, limits: tuple[float, float], poses: list[Floats], transforms: list[Floats | None]
) -> list[dict[str, Any]]:
    """What is seen at each pose, rendered in one call: `Episode.see` takes them."""
    matrices = np.stack(poses)
    moves: Any = {}
    if loop.things:
        moves = {"instances": list(loop.things), "transforms": np.stack(transforms)}  # type: ignore[arg-type]
    if loop.distances:
        truth = loop.renderer.ground_truth(matrices, **moves)
        responses = truth.responses
        found = {"nearest_m": truth.nearest_m, "distance_m": truth.distance_m}
    else:
        responses = loop.renderer.render(matrices, **moves)
        found = {}
    least, largest = float(responses.min(initial=np.inf)), float(responses.max(initial=-np.inf))
    if least < limits[0] or largest > limits[1]:
        raise Error(
            f"bounds: expected responses from {limits[0]:g} to {limits[1]:g}, found {least:g} to "
            f"{largest:g}"
        )
    return [
        {"responses": responses[k]} | {name: values[k] for name, values in found.items()}
        for k in range(len(poses))
    ]
