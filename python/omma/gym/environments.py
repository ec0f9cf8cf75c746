"""The environments themselves, which need Gymnasium to be there: one loop, and many at once."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, iterate
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Flags
from omma.base.warn import warn_caller
from omma.gym.episodes import Where, episodes_of, see_poses
from omma.gym.loop import Loop, Responses

_NOT_OVER = np.zeros(1, bool)


def _spaces(
    loop: Loop, limits: tuple[float, float]
) -> tuple[gymnasium.spaces.Space[Any], gymnasium.spaces.Space[Any]]:
    if not isinstance(loop.action_space, gymnasium.spaces.Space):
        found = f"{type(loop.action_space).__name__} {loop.action_space!r:.40}"
        raise TypeError(f"action_space: expected a gymnasium.spaces.Space, found {found}")
    shape: tuple[int, ...] = (len(loop.renderer.eye), loop.renderer.bands)
    if loop.frames is not None:
        shape = (*shape, loop.frames)
    return gymnasium.spaces.Box(*limits, shape, np.float32), loop.action_space


def _warn_of_render() -> None:
    warn_caller(
        "render: gives None, as there is no camera and no render mode; what the eye sees is the "
        "observation, which omma.picture.plot_responses draws",
        UserWarning,
    )


class _Maker:
    """Makes environments of one loop: what their spec calls, so that Gymnasium's own tools can make
    another. Copies of a spec have the same loop, whose world may be large."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop

    def __call__(self, **_: Any) -> EyeEnv:
        return EyeEnv(self.loop)

    def __deepcopy__(self, _: dict[int, Any]) -> _Maker:
        return self


class EyeEnv(gymnasium.Env[Responses, Any]):
    """A loop as an environment; `eye_env` makes one."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.spec = EnvSpec("omma/Eye-v0", entry_point=_Maker(loop))
        self.metadata = {"render_modes": []}
        self._limits = loop.limits()
        self.observation_space, self.action_space = _spaces(loop, self._limits)
        self._episodes = episodes_of(loop, 1)
        self._over = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Responses, dict[str, Any]]:
        """Start an episode; ``options`` are not used."""
        super().reset(seed=seed)
        self._over = False
        return self._seen(self._episodes.begin([self.np_random]))

    def step(self, action: Any) -> tuple[Responses, float, bool, bool, dict[str, Any]]:
        """(observation, reward, whether it ended, whether it was cut off, info). The caller is
        warned of a step after the end of an episode, which goes on from there."""
        if self._over:
            warn_caller(
                "step: the episode is over (it ended or was cut off); expected reset() before it, "
                "and goes on where it was",
                UserWarning,
            )
        actions = np.asarray(action)[None] if self.loop.batched else [action]
        seen, info = self._seen(self._episodes.advance(actions, _NOT_OVER, [self.np_random]))
        rewards, ended, cut_off = self._episodes.judged()
        self._over = bool(ended[0] or cut_off[0])
        return seen, float(rewards[0]), bool(ended[0]), bool(cut_off[0]), info

    def render(self) -> None:
        """Nothing, with a warning: no render mode is declared."""
        _warn_of_render()

    def _seen(self, where: Where) -> tuple[Responses, dict[str, Any]]:
        observations = self._episodes.see(see_poses(self.loop, self._limits, where))
        return observations[0], {"pose": where[0][0]}


def _one_each(space: Any, actions: Any, count: int) -> list[Any]:
    """The actions of each environment, of a space of actions of all."""
    try:
        each = list(iterate(space, actions))
    except TypeError:
        raise Error(f"actions: expected {count}, found {actions!r:.40}") from None
    if len(each) != count:
        raise Error(f"actions: expected {count}, found {len(each)}")
    return each


class EyeVectorEnv(VectorEnv[Responses, Any, Any]):
    """Many environments of a loop as one; `eye_vector_env` makes it."""

    def __init__(self, loop: Loop, count: int) -> None:
        self.loop = loop
        self.num_envs = count
        self.metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}
        self._limits = loop.limits()
        self.single_observation_space, self.single_action_space = _spaces(loop, self._limits)
        self.observation_space = batch_space(self.single_observation_space, count)
        self.action_space = batch_space(self.single_action_space, count)
        self._episodes = episodes_of(loop, count)
        self._rngs: list[np.random.Generator] = []
        self._over = np.zeros(count, bool)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Responses, dict[str, Any]]:
        """Start all episodes: a seed is the first one's, which the others count on from. With
        ``options={"reset_mask": mask}``, (K,) of bool, those where it is True alone; the others
        stay where they are."""
        if options is not None and "reset_mask" in options:
            return self._begun(options["reset_mask"], seed)
        self._rngs = self._seeded(seed)
        self._over = np.zeros(self.num_envs, bool)
        return self._seen(self._episodes.begin(self._rngs))

    def step(self, actions: Any) -> tuple[Responses, NDArray[np.float64], Flags, Flags, Any]:
        """(observations, rewards, which ended, which were cut off, infos); what was over before
        starts anew, for a reward of 0."""
        if not self._rngs:
            raise Error("step: expected reset() before it")
        count, batched = self.num_envs, self.loop.batched
        each = actions if batched else _one_each(self.action_space, actions, count)
        observations, infos = self._seen(self._episodes.advance(each, self._over, self._rngs))
        rewards, ended, cut_off = self._episodes.judged()
        self._over = ended | cut_off
        return observations, rewards, ended, cut_off, infos

    def render(self) -> None:
        """Nothing, with a warning: no render mode is declared."""
        _warn_of_render()

    def _begun(
        self, mask: Any, seed: int | list[int | None] | None
    ) -> tuple[Responses, dict[str, Any]]:
        chosen = np.asarray(mask)
        if chosen.dtype != np.bool_ or chosen.shape != (self.num_envs,) or not chosen.any():
            raise Error(
                f"reset_mask: expected an array ({self.num_envs},) of bool, True somewhere, found "
                f"{chosen.dtype} {chosen.shape}"
            )
        if seed is not None:
            raise Error("seed: is for a reset of all, without a reset_mask")
        which = np.flatnonzero(chosen)
        where = self._episodes.begin_some(which, self._rngs)
        observations = self._episodes.see_some(which, see_poses(self.loop, self._limits, where))
        self._over = self._over & ~chosen
        poses = np.zeros((self.num_envs, 4, 4))
        poses[which] = where[0]
        return observations, {"pose": poses, "_pose": chosen.copy()}

    def _seeded(self, seed: int | list[int | None] | None) -> list[np.random.Generator]:
        count = 1 if self.loop.batched else self.num_envs
        seeds: list[int | None]
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds = [None if seed is None else int(seed) + k for k in range(count)]
        else:
            seeds = [None if one is None else int(one) for one in seed]
        if len(seeds) != count:
            more = ", as a batched loop has one generator" if self.loop.batched else ""
            raise Error(f"seed: expected {count} of them{more}, found {len(seeds)}")
        kept: list[np.random.Generator | None] = [*self._rngs] or [None] * count
        return [
            rng if one is None and rng is not None else seeding.np_random(one)[0]
            for one, rng in zip(seeds, kept, strict=True)
        ]

    def _seen(self, where: Where) -> tuple[Responses, dict[str, Any]]:
        observations = self._episodes.see(see_poses(self.loop, self._limits, where))
        return observations, {"pose": where[0].copy(), "_pose": np.ones(self.num_envs, bool)}
