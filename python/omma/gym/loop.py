"""What a closed loop is: who sees, how it moves by what it does, and what that is worth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import array_of, expect, whole
from omma.base.arrays import Floats
from omma.base.values import value_class
from omma.gym.bounds import response_bounds
from omma.rendering.renderer import Renderer
from omma.scene.world_moves import indices_of

Responses = NDArray[np.float32]

_MOST_FRAMES = 4096
# Of a moment, where the loop asks for them.
_DISTANCES = ("nearest_m", "distance_m")


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Moment:
    """What is so after a step: what rewards and ends are decided by.

    Of a batched loop all is of K environments: arrays with them along the first axis.

    state, before: the caller's own, after the step and before it; at the start the same.
    action: what was done; None at the start (batched: at the start of all).
    pose: ``world_from_head`` (4, 4), m.
    responses: (N, B), the frame that is seen now.
    step: how many steps have been taken since the start.
    nearest_m, distance_m: (N,), least and mean distance of what each ommatidium sees, infinite
        where it sees nothing, as of `Renderer.ground_truth`. An omma.Error says so where the loop
        does not ask for them (``distances=True``).
    """

    state: Any
    before: Any
    action: Any
    pose: Floats
    responses: Responses
    step: Any
    nearest_m: Responses | None = None
    distance_m: Responses | None = None

    def __getattribute__(self, name: str) -> Any:
        value = super().__getattribute__(name)
        if value is None and name in _DISTANCES:
            raise Error(f"{name}: expected a loop with distances=True, found one without")
        return value


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
        action_space: a `gymnasium.spaces.Space`. Actions beyond it reach ``motion`` as they are;
            Gymnasium's wrapper `ClipAction` clips them.
        ended: ended(moment) -> bool, whether the episode has come to its end, as by a collision;
            None: it never does.
        most_steps: after so many steps an episode is cut off; None: never.
        frames: None: observations are (N, B), the frame that is seen now; else (N, B, frames), the
            newest last. Before the first frame the world is taken to have stood still.
        distances: moments have distances, by the rays that the responses are made of; for
            renderers with `Fixed` or `ToError`.
        things: names or indices of K things that move besides the head, or that of one; start and
            motion then return (state, pose, transforms), the last ``world_from_node`` (K, 4, 4), m.
            Several environments share the world, which functions leave as it is.
        bounds: least and largest response, for the bounds of observations; a response beyond them
            is an error. None: `response_bounds` of the world.
        batched: functions are of K environments at a time, so that what they do is done in arrays:
            start(count, rng) -> (states, poses (count, 4, 4)); motion(states, actions, rng) ->
            (states, poses (K, 4, 4)), with ``transforms`` (K, T, 4, 4) of T things behind;
            reward(moment) -> (K,), ended(moment) -> (K,) of bool, by a `Moment` of all. States are
            an array with environments along its first axis, or a dictionary or tuple of such;
            actions are an array. One generator is that of all environments.

    Raises:
        omma.Error: an argument is out of its range, or the renderer does not suit.
        TypeError: an argument is of another type.
    """

    renderer: Renderer
    start: Callable[..., tuple[Any, ...]]
    motion: Callable[[Any, Any, np.random.Generator], tuple[Any, ...]]
    reward: Callable[[Moment], Any]
    action_space: Any
    ended: Callable[[Moment], Any] | None = None
    most_steps: int | None = None
    frames: int | None = None
    distances: bool = False
    things: Sequence[str | int] = ()
    bounds: tuple[float, float] | None = None
    batched: bool = False

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
        if not isinstance(self.batched, (bool, np.bool_)):
            raise TypeError(f"batched: expected True or False, found {self.batched!r:.40}")
        things: Any = self.things
        if isinstance(things, str) or not hasattr(things, "__iter__"):
            things = (things,)
        object.__setattr__(self, "things", tuple(things))
        indices_of(self.renderer.world, self.things)  # a name that nothing has is told here
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
