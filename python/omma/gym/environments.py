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
from omma.gym.loop import Episode, Loop, Moment, Responses, render_poses

Bools = NDArray[np.bool_]


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
        self._episode = Episode(loop)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Responses, dict[str, Any]]:
        """Start an episode; ``options`` are not used."""
        super().reset(seed=seed)
        moment = self._seen(*self._episode.begin(self.np_random))
        return self._episode.observation(moment), {"pose": moment.pose}

    def step(self, action: Any) -> tuple[Responses, float, bool, bool, dict[str, Any]]:
        """(observation, reward, whether it ended, whether it was cut off, info)."""
        moment = self._seen(*self._episode.move(action, self.np_random))
        return (
            self._episode.observation(moment),
            *self._episode.judged(moment),
            {"pose": moment.pose},
        )

    def _seen(self, pose: Any, transforms: Any) -> Moment:
        return self._episode.see(render_poses(self.loop, self._limits, [pose], [transforms])[0])


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
        self._episodes = [Episode(loop) for _ in range(count)]
        self._rngs: list[np.random.Generator] = []
        self._over = np.zeros(count, bool)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Responses, dict[str, Any]]:
        """Start all episodes: a seed is the first one's, which the others count on from."""
        self._rngs = self._seeded(seed)
        self._over[:] = False
        begun = [
            episode.begin(rng) for episode, rng in zip(self._episodes, self._rngs, strict=True)
        ]
        moments = self._seen(begun)
        return self._observations(moments), self._infos(moments)

    def step(self, actions: Any) -> tuple[Responses, NDArray[np.float64], Bools, Bools, Any]:
        """(observations, rewards, which ended, which were cut off, infos); what was over before
        starts anew, for a reward of 0."""
        if not self._rngs:
            raise Error("step: expected reset() before it")
        where = [
            episode.begin(rng) if over else episode.move(action, rng)
            for episode, rng, over, action in zip(
                self._episodes,
                self._rngs,
                self._over,
                iterate(self.action_space, actions),
                strict=True,
            )
        ]
        moments = self._seen(where)
        rewards = np.zeros(self.num_envs)
        ended, cut_off = np.zeros(self.num_envs, bool), np.zeros(self.num_envs, bool)
        for k in np.flatnonzero(~self._over):
            rewards[k], ended[k], cut_off[k] = self._episodes[k].judged(moments[k])
        self._over = ended | cut_off
        return self._observations(moments), rewards, ended, cut_off, self._infos(moments)

    def _seeded(self, seed: int | list[int | None] | None) -> list[np.random.Generator]:
        seeds: list[int | None]
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds = [None if seed is None else int(seed) + k for k in range(self.num_envs)]
        else:
            seeds = [None if one is None else int(one) for one in seed]
        if len(seeds) != self.num_envs:
            raise Error(f"seed: expected {self.num_envs} of them, found {len(seeds)}")
        kept: list[np.random.Generator | None] = [*self._rngs] or [None] * self.num_envs
        return [
            rng if one is None and rng is not None else seeding.np_random(one)[0]
            for one, rng in zip(seeds, kept, strict=True)
        ]

    def _seen(self, where: list[Any]) -> list[Moment]:
        poses, transforms = [pose for pose, _ in where], [things for _, things in where]
        views = render_poses(self.loop, self._limits, poses, transforms)
        return [episode.see(view) for episode, view in zip(self._episodes, views, strict=True)]

    def _observations(self, moments: list[Moment]) -> Responses:
        seen = [
            episode.observation(moment)
            for episode, moment in zip(self._episodes, moments, strict=True)
        ]
        return np.stack(seen)

    def _infos(self, moments: list[Moment]) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for k, moment in enumerate(moments):
            infos = self._add_info(infos, {"pose": moment.pose}, k)
        return infos
