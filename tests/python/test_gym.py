"""Closed loops as environments: Gymnasium's own checker, frames, many at once to the same bits, and
memory."""

import gc
import resource
import warnings

import numpy as np
import pytest
from gym_walks import (
    gymnasium,
    loop_of,
    make_walker,
)
from gymnasium.utils.env_checker import check_env

import omma


@pytest.fixture(scope="module")
def walker():
    return make_walker()


@pytest.mark.parametrize("frames", [None, 3])
def test_gymnasium_has_nothing_to_say(walker, frames):
    loop = loop_of(walker, frames=frames)
    gymnasium.register("omma-test-v0", entry_point=lambda: omma.gym.eye_env(loop))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            env = gymnasium.make("omma-test-v0", disable_env_checker=True).unwrapped
            check_env(env)
    finally:
        gymnasium.registry.pop("omma-test-v0")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(omma.gym.eye_env(loop))  # as it is made, not registered
    shape = (40, 3) if frames is None else (40, 3, frames)
    assert env.observation_space.shape == shape
    assert env.observation_space.dtype == np.float32


def test_the_spec_makes_another_of_the_same_loop(walker):
    loop = loop_of(walker)
    env = omma.gym.eye_env(loop)
    wrapped = gymnasium.wrappers.TimeLimit(env, 5)  # wrappers copy what the spec holds
    for made in (env.spec.make(), wrapped.spec.make()):
        assert made.unwrapped.loop is loop
        assert (made.reset(seed=2)[0] == env.reset(seed=2)[0]).all()


def test_the_observation_is_what_the_eye_sees(walker):
    env = omma.gym.eye_env(loop_of(walker))
    seen, info = env.reset(seed=4)
    assert (seen == walker.render(info["pose"])[0]).all()
    before = seen.copy()
    after, reward, ended, cut_off, info = env.step(np.array([1.0, 0.5], np.float32))
    assert (after == walker.render(info["pose"])[0]).all()
    assert (after != seen).any()
    assert (seen == before).all()  # it is the caller's
    assert -1 < reward < 0
    assert (ended, cut_off) == (False, False)


def test_frames_follow_each_other(walker):
    env = omma.gym.eye_env(loop_of(walker, frames=3))
    first, _ = env.reset(seed=4)
    assert (first == first[..., :1]).all()
    second = env.step(np.ones(2, np.float32))[0]
    third = env.step(np.ones(2, np.float32))[0]
    assert (second[..., :2] == first[..., 1:]).all()
    assert (third[..., :2] == second[..., 1:]).all()
    assert (third[..., 2] != second[..., 2]).any()


@pytest.mark.parametrize("frames", [None, 2])
def test_many_at_once_are_single_ones_to_the_bit(walker, frames):
    """Over ends, cut-offs and new starts; against Gymnasium's own way of taking turns."""
    loop = loop_of(walker, frames=frames, most_steps=18)
    together = omma.gym.eye_vector_env(loop, 5)
    in_turn = gymnasium.vector.SyncVectorEnv([lambda: omma.gym.eye_env(loop)] * 5)
    assert together.metadata["autoreset_mode"] == in_turn.metadata["autoreset_mode"]
    assert together.observation_space == in_turn.observation_space
    assert together.single_observation_space == in_turn.single_observation_space
    assert together.action_space == in_turn.action_space
    in_turn.action_space.seed(3)
    one, other = together.reset(seed=8), in_turn.reset(seed=8)
    ends = np.zeros(2, int)
    for step in range(120):
        assert (one[0] == other[0]).all()
        assert one[0].dtype == other[0].dtype == np.float32
        for mine, theirs in zip(one[1:-1], other[1:-1], strict=True):
            assert mine.dtype == theirs.dtype
            assert (mine == theirs).all()
        assert one[-1].keys() == other[-1].keys()
        assert all((one[-1][name] == other[-1][name]).all() for name in one[-1])
        if step == 70:  # again, with what their generators are by now
            one, other = together.reset(), in_turn.reset()
            continue
        actions = in_turn.action_space.sample()
        actions[:2, 0] = 1  # run into the wall
        one, other = together.step(actions), in_turn.step(actions)
        ends += one[2].sum(), one[3].sum()
    assert (ends > 3).all()
    in_turn.close()


@pytest.mark.parametrize("frames", [None, 2])
def test_some_start_anew_as_in_gymnasium(walker, frames):
    """``reset_mask``, for those who do so as soon as an episode is over."""
    loop = loop_of(walker, frames=frames)
    together = omma.gym.eye_vector_env(loop, 4)
    in_turn = gymnasium.vector.SyncVectorEnv([lambda: omma.gym.eye_env(loop)] * 4)
    in_turn.action_space.seed(3)
    together.reset(seed=8)
    in_turn.reset(seed=8)
    begun = 0
    for step in range(40):
        actions = in_turn.action_space.sample()
        actions[0, 0] = 1  # run into the wall
        one, other = together.step(actions), in_turn.step(actions)
        for mine, theirs in zip(one[:-1], other[:-1], strict=True):
            assert (mine == theirs).all()
        over = one[2] | one[3]
        if step % 3 == 0:
            over[2] = True  # one that is not over
        if over.any() and step % 5 != 4:
            begun += 1
            one = together.reset(options={"reset_mask": over})
            other = in_turn.reset(options={"reset_mask": over})
            assert (one[0] == other[0]).all()
            assert all((one[1][name] == other[1][name]).all() for name in other[1])
    assert begun > 8
    in_turn.close()
    for mask, message in (
        (np.zeros(4, bool), "reset_mask: expected an array"),
        ([0, 1, 0, 1], "reset_mask: expected an array"),
        (np.ones(3, bool), "reset_mask: expected an array"),
    ):
        with pytest.raises(omma.Error, match=message):
            together.reset(options={"reset_mask": mask})
    with pytest.raises(omma.Error, match="seed: is for a reset of all"):
        together.reset(seed=1, options={"reset_mask": np.ones(4, bool)})
    with pytest.raises(omma.Error, match=r"expected a reset\(\) of all before"):
        omma.gym.eye_vector_env(loop, 4).reset(options={"reset_mask": np.ones(4, bool)})


def test_many_are_rendered_in_one_call(walker, monkeypatch):
    calls = []
    render = omma.Renderer.render

    def counted(self, poses, **options):
        calls.append(len(poses))
        return render(self, poses, **options)

    monkeypatch.setattr(omma.Renderer, "render", counted)
    envs = omma.gym.eye_vector_env(loop_of(walker, distances=False, ended=None), 7)
    envs.reset(seed=0)
    for _ in range(3):
        envs.step(envs.action_space.sample())
    assert calls == [7] * 4


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def test_nothing_is_left_of_steps(walker):
    """5,000 steps; bench/gym_steps.py takes 100,000."""
    env = omma.gym.eye_env(loop_of(walker, frames=2))
    env.action_space.seed(0)
    env.reset(seed=0)
    sizes = []
    for step in range(5000):
        _, _, ended, cut_off, _ = env.step(env.action_space.sample())
        if ended or cut_off:
            env.reset()
        if step % 1000 == 999:
            gc.collect()
            sizes.append(resident_bytes())
    # An observation that stayed behind at each step would be 1,000 bytes: 1 MB in each thousand.
    # What allocators and other threads take comes at once, and then not for a while.
    assert np.diff(sizes).min() < 5e5
