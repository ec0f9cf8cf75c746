"""What moves from pose to pose while a renderer goes through them: checked, for the engine."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of
from omma.scene.world import Animations, Instances, World

if TYPE_CHECKING:
    from typing_extensions import Self

F = TypeVar("F", bound=Callable[..., Any])
EngineMoves = tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64], NDArray[np.int32]]


class MovesOptions(TypedDict, total=False):
    """What moves from pose to pose, as keyword arguments of `Renderer.render`."""

    instances: Instances | None
    transforms: ArrayLike | None
    times_s: ArrayLike | None
    animation: Animations | None


def takes_moves(function: F) -> F:
    """The same function, whose signature says ``**moves`` one by one (`MovesOptions`)."""
    signature = inspect.signature(function)
    parameters = [one for one in signature.parameters.values() if one.kind is not one.VAR_KEYWORD]
    for name, annotation in MovesOptions.__annotations__.items():
        text = getattr(annotation, "__forward_arg__", annotation)
        parameters.append(
            inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=str(text)
            )
        )
    function.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return function


class Moves:
    """Where things are at each of some poses; empty where nothing moves.

    Args:
        world: in which they move.
        poses: how many there are.
        options: as the user gave them.
    """

    def __init__(self, world: World, poses: int, options: MovesOptions) -> None:
        self._world = world
        instances, transforms = options.get("instances"), options.get("transforms")
        times, animation = options.get("times_s"), options.get("animation")
        if (instances is None) != (transforms is None):
            given, missing = (
                ("instances", "transforms") if transforms is None else ("transforms", "instances")
            )
            raise Error(f"{missing}: expected with {given}, found None")
        self._instances = np.empty(0, np.int32)
        self._transforms = np.empty((poses, 0, 4, 4))
        if instances is not None:
            self._instances = world._indices_of(instances)
            shape = (poses, len(self._instances), 4, 4)
            self._transforms = array_of(transforms, "transforms")
            if self._transforms.shape != shape:
                raise Error(
                    f"transforms: expected shape {shape}, one for each pose and thing, found "
                    f"{self._transforms.shape}"
                )
        self._times: NDArray[np.float64] | None = None
        if times is not None:
            self._times = array_of(times, "times_s", (poses,))
        elif animation is not None:
            raise Error("animation: is for times_s, found None of these")
        self._animations = world._animations_of(animation)

    def part(self, first: int, count: int) -> Self:
        """The same of some of the poses."""
        part = object.__new__(type(self))
        vars(part).update(vars(self))
        part._transforms = self._transforms[first : first + count]
        if self._times is not None:
            part._times = self._times[first : first + count]
        return part

    def options(self) -> MovesOptions:
        """As a user gives them."""
        options: MovesOptions = {}
        if len(self._instances) > 0:
            options |= {"instances": self._instances, "transforms": self._transforms}
        if self._times is not None:
            options["times_s"] = self._times
            if len(self._animations) > 0:
                options["animation"] = int(self._animations[0])
        return options

    def for_engine(self) -> EngineMoves | None:
        """As the engine takes them; None where nothing moves."""
        if len(self._instances) == 0 and self._times is None:
            return None
        times = np.empty(0) if self._times is None else self._times
        transforms = np.ascontiguousarray(self._transforms.reshape(-1, 4, 4))
        return self._instances, transforms, np.ascontiguousarray(times), self._animations

    def note(self) -> None:
        """Have the world know what has moved, which is back where it was."""
        if self.for_engine() is not None:
            self._world._note_moves(self._instances, self._times is not None)
