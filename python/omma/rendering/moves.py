"""What moves from pose to pose while a renderer goes through them: checked, for the engine."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of
from omma.base.methods import method_of
from omma.base.poses import Matrices, as_poses
from omma.base.slips import warn_of_slip
from omma.base.velocities import (
    is_stretched,
    times_about,
    velocities_about,
    velocities_from_poses,
)
from omma.base.warn import warn_caller
from omma.photoreceptors import ImpulseResponse
from omma.rendering.moves_told import MovesTold, Past
from omma.scene.world import World
from omma.scene.world_moves import (
    Animations,
    Instances,
    animations_of,
    indices_of,
    note_moves,
)

if TYPE_CHECKING:
    from typing_extensions import Self

# Before and after a moment: how fast animations move then. Long beside the rounding of key times,
# float32, and short beside any key.
_MOMENT_S = 1e-4

# Things that a warning names.
_MOST_NAMES = 5

# Groups of things that one call can keep from being seen: bits of a ray's mask.
MOST_UNSEEN = 31

F = TypeVar("F", bound=Callable[..., Any])
# Things that are moved: names, indices (K,) in `World.instances`, and where they are, (P, K, 4, 4).
Things = tuple[list[str], NDArray[np.int32], NDArray[np.float64]]
EngineMoves = tuple[
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    list[list[int]],
    NDArray[np.int32],
    bool,
]


class MovesOptions(TypedDict, total=False):
    """What moves from pose to pose, as keyword arguments of `Renderer.render`."""

    instances: Instances | None
    transforms: ArrayLike | None
    times_s: ArrayLike | None
    animation: Animations | None
    past: (
        tuple[ArrayLike | tuple[ArrayLike, ArrayLike], ArrayLike]
        | tuple[ArrayLike | tuple[ArrayLike, ArrayLike], ArrayLike, ArrayLike]
        | None
    )
    unseen: Sequence[Instances | None] | None
    unseen_by_light: bool | None


def renderer_method(function: F) -> F:
    """The same function as a method of `omma.Renderer`, whose signature says ``**moves`` one by one
    (`MovesOptions`)."""
    method_of("omma.rendering.renderer", "Renderer")(function)
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
    function.__annotations__ |= get_type_hints(MovesOptions)
    return function


class Moves:
    """Where things are at each of some poses; empty where nothing moves.

    Args:
        world: in which they move.
        matrices: the poses, (P, 4, 4).
        options: as the user gave them.
        impulse_response: of the renderer's settings; None: frames are instants.
        tells_flow: whether times that grow tell how the head moves, also where nothing else does.
    """

    def __init__(
        self,
        world: World,
        matrices: Matrices,
        options: MovesOptions,
        impulse_response: ImpulseResponse | None,
        tells_flow: bool = False,
    ) -> None:
        self._world = world
        self._poses, poses = matrices, len(matrices)
        self._longest_s = None if impulse_response is None else impulse_response.duration_s
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
            self._instances = indices_of(world, instances)
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
            moving = instances is not None or len(world.scene.animations) > 0
            if not moving and impulse_response is None and not (tells_flow and self.is_path()):
                found = f"found neither in {world.scene.path or 'the scene'}"
                if tells_flow:
                    raise Error(
                        "times_s: expected two or more that grow, by which the head moves, or "
                        f"instances and transforms or a scene with an animation, {found}"
                    )
                raise Error(
                    "times_s: expected instances and transforms or a scene with an animation, "
                    f"{found}; of a world that stands still dataset takes time_s=times_s, and "
                    "ground_truth takes times_s for the head's velocity"
                )
        elif animation is not None:
            raise Error("animation: is for times_s, found None of these")
        if impulse_response is not None and self._times is None:
            raise Error(
                "times_s: expected when each pose is, as frames last with an impulse response, "
                "found None"
            )
        if impulse_response is not None and self._times is not None and poses > 1:
            # Of the shortest: rests between sequences may be long.
            shortest = float(np.diff(self._times).min())
            if shortest > impulse_response.duration_s:
                warn_of_slip("time between frames", shortest, "times_s")
        self._animations = animations_of(world.scene, animation)
        self._past = np.empty((0, 4, 4)), np.empty(0)
        self._past_transforms = np.empty((0, len(self._instances), 4, 4))
        self._told_past: Past | None = None
        if options.get("past") is not None:
            if impulse_response is None:
                raise Error("past: is for renderers with an impulse response, found one without")
            past = past_of(options["past"], len(self._instances))
            self._past, self._past_transforms = (past.poses, past.times_s), past.transforms
            self._told_past = past
        self._groups, self._group_of_pose = _groups_of(world, options.get("unseen"), poses)
        by_light = options.get("unseen_by_light")
        if by_light and options.get("unseen") is None:
            raise Error("unseen_by_light: goes with unseen, found None of that")
        self._by_light = bool(by_light)
        self._animation = animation

    def told(self) -> MovesTold:
        """What data sets say of it, in a world as it is now."""
        unseen = self._groups, self._group_of_pose
        told = replace(MovesTold.of(self._world, unseen, self._by_light), past=self._told_past)
        return told.with_animation(self._world.scene, self._animation)

    def piece(self, first: int, count: int) -> Self:
        """The same of some of the poses."""
        piece = object.__new__(type(self))
        vars(piece).update(vars(self))
        piece._transforms = self._transforms[first : first + count]
        piece._poses = self._poses[first : first + count]
        piece._group_of_pose = self._group_of_pose[first : first + count]
        if self._longest_s is not None and self._times is not None:
            # What the first of them still sees, and one before.
            times = np.concatenate([self._past[1], self._times[:first]])
            seen = int(np.searchsorted(times, self._times[first] - self._longest_s))
            kept = slice(max(0, seen - 1), None)
            before = np.concatenate([self._past[0], self._poses[:first]])
            piece._past = np.ascontiguousarray(before[kept]), times[kept]
            known = self._past_transforms
            if len(known) < len(self._past[1]):  # things stood as they are at the first pose
                known = self._transforms[:1].repeat(len(self._past[1]), axis=0)
            piece._past_transforms = np.concatenate([known, self._transforms[:first]])[kept]
        if self._times is not None:
            piece._times = self._times[first : first + count]
        return piece

    def for_engine(self) -> EngineMoves | None:
        """As the engine takes them; None where nothing moves."""
        # Of a scene without animations, times say when poses and transforms are (`head_velocity`,
        # `velocities`) and no more.
        are_seen = self._longest_s is not None or len(self._world.scene.animations) > 0
        seen = self._times if are_seen else None
        if len(self._instances) == 0 and seen is None and not self._groups:
            return None
        times = np.empty(0) if seen is None else seen
        transforms = np.ascontiguousarray(self._transforms.reshape(-1, 4, 4))
        times = np.ascontiguousarray(times)
        return (
            self._instances,
            transforms,
            times,
            self._animations,
            *self._past,
            np.ascontiguousarray(self._past_transforms.reshape(-1, 4, 4)),
            self._groups,
            self._group_of_pose,
            self._by_light,
        )

    def is_path(self) -> bool:
        """Whether its times say when poses are, one after the other."""
        if self._times is None or len(self._times) < 2 or not np.isfinite(self._times).all():
            return False
        return bool((np.diff(self._times) > 0).all())

    def head_velocity(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The head's linear and angular velocity along a path, each (P, 3)."""
        assert self._times is not None
        return velocities_from_poses(self._poses, self._times)

    @property
    def times_s(self) -> NDArray[np.float64] | None:
        """(P,), when each pose is, where that is known."""
        return self._times

    def things(self) -> Things:
        """What ``transforms`` move: names, indices (K,) in `World.instances`, and where they are,
        (P, K, 4, 4)."""
        instances = self._world.instances if len(self._instances) else ()
        names = [instances[thing].name for thing in self._instances]
        return names, self._instances, self._transforms

    def velocities(self, told: Collection[int]) -> dict[int, tuple[Any, Any]]:
        """{thing: (linear, angular)}, each (P, 3), of what moves as time goes by.

        Those of ``transforms`` along their path, those of animations about each moment, at their
        first and last key on the inner side; none where the caller has told them, or there are no
        times. Warns of what grows, is stretched or bent.
        """
        found: dict[int, tuple[Any, Any]] = {}
        stretched: list[int] = []
        if self._times is None:
            return found
        for k, thing in enumerate(self._instances.tolist()):
            if thing in told:
                continue
            try:
                found[thing] = velocities_from_poses(self._transforms[:, k], self._times)
            except Error as problem:
                raise Error(
                    f"velocities: expected that of instance {thing}, as the path of its transforms "
                    f"does not tell it ({problem})"
                ) from problem
            if is_stretched(self._transforms[:, k]):
                stretched.append(thing)
        animated = [
            (k, thing)
            for k, thing in enumerate(self._world._engine.animated)
            if thing not in found and thing not in told
        ]
        animations = self._animations.tolist()
        if animated:
            ends = self._world._rig_parts.ends_s(animations)
            times = times_about(self._times, _MOMENT_S, ends)
            places = np.stack([[self._animated_at(time) for time in some] for some in times])
            for k, thing in animated:
                found[thing] = velocities_about(places[:, :, k], times)
                # So short a time has little of it, and less of rounding, as keys are exact.
                if is_stretched(np.concatenate([places[1, :, k], places[2, :, k]]), 1e-6):
                    stretched.append(thing)
        if stretched:
            warn_caller(
                f"optic flow: {self._names(stretched)} "
                f"{'changes' if len(stretched) == 1 else 'change'} size or shape on the way; only "
                "how things go and turn is in it, not how they grow or are stretched",
                UserWarning,
            )
        moments = self._times[np.isfinite(self._times)]
        bent = self._world._rig_parts.bent(moments, _MOMENT_S, animations)
        bent = [thing for thing in bent if thing not in told]
        if bent:
            warn_caller(
                f"optic flow: bones or morph targets move the vertices of {self._names(bent)}; a "
                "thing counts as its node moves, not as its vertices do; velocities= tells how it "
                "goes and turns as a whole",
                UserWarning,
            )
        return found

    def _names(self, things: Sequence[int]) -> str:
        instances = self._world.instances
        names = [repr(instances[thing].name) for thing in things[:_MOST_NAMES]]
        more = len(things) - len(names)
        return ", ".join(names) + (f" and {more} more" if more else "")

    def _animated_at(self, time_s: float) -> NDArray[np.float64]:
        return self._world._engine.animated_at(float(time_s), self._animations)

    def note(self) -> None:
        """Have the world know what has moved, which is back where it was."""
        unseen = [thing for group in self._groups for thing in group]
        if len(self._instances) > 0 or self._times is not None or unseen:
            things = np.concatenate([self._instances, np.array(unseen, np.int32)])
            note_moves(self._world, things, self._times is not None)


def past_of(past: Any, things: int) -> Past:
    """What users say of what was before the first pose, where so many things are moved."""
    if not isinstance(past, (tuple, list)) or len(past) not in (2, 3):
        raise Error(
            f"past: expected (poses, times_s) or (poses, times_s, transforms), found {past!r:.40}"
        )
    matrices = as_poses(past[0])
    times = np.ascontiguousarray(array_of(past[1], "past", (len(matrices),)))
    transforms = np.empty((0, things, 4, 4))
    if len(past) == 3:
        transforms = array_of(past[2], "past", (len(matrices), things, 4, 4))
    return Past(matrices, times, transforms)


def _groups_of(world: World, unseen: Any, poses: int) -> tuple[list[list[int]], NDArray[np.int32]]:
    """Groups of things that rays do not meet, and which one each pose has, -1 for none."""
    if unseen is None:
        return [], np.empty(0, np.int32)
    if isinstance(unseen, str) or not hasattr(unseen, "__len__") or len(unseen) != poses:
        raise Error(
            f"unseen: expected None, or the things that are not seen, for each of {poses} poses, "
            f"found {unseen!r:.60}"
        )
    found: dict[tuple[int, ...], int] = {}
    of_pose = np.full(poses, -1, np.int32)
    for pose, things in enumerate(unseen):
        if things is not None:
            indices = tuple(sorted(set(indices_of(world, things).tolist())))
            if indices:
                of_pose[pose] = found.setdefault(indices, len(found))
    if not found:
        return [], np.empty(0, np.int32)
    if len(found) > MOST_UNSEEN:
        raise Error(
            f"unseen: expected at most {MOST_UNSEEN} different groups of things in one call, found "
            f"{len(found)}"
        )
    return [list(indices) for indices in found], of_pose
