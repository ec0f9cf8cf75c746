"""Environments in the hands of who knows Gymnasium's: steps before the begin and after the end,
pictures of them, and no Gymnasium."""

import sys
import warnings
from dataclasses import replace

import numpy as np
import pytest

import omma

gymnasium = pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'omma[gym]'")


@pytest.fixture(scope="module")
def loop():
    """An eye that goes ahead until it has gone three steps or is behind what it started from."""
    scene = omma.scene.box(center_m=(0, 0, -9))
    return omma.gym.Loop(
        omma.Renderer(scene, omma.eye.generate_eye(20), omma.Fixed(1), threads=1),
        start=lambda rng: (0.0, np.eye(4)),
        motion=lambda z, action, rng: (z + float(action[0]), np.eye(4)),
        reward=lambda moment: moment.state,
        action_space=gymnasium.spaces.Box(-1, 1, (1,), np.float32),
        ended=lambda moment: moment.state < 0,
        most_steps=3,
    )


def test_steps_before_a_start(loop):
    for env in (omma.gym.eye_env(loop), omma.gym.eye_vector_env(loop, 2)):
        with pytest.raises(omma.Error, match=r"step: expected reset\(\) before it"):
            env.step(env.action_space.sample())
    with pytest.raises(omma.Error, match="seed: expected 2 of them, found 1"):
        omma.gym.eye_vector_env(loop, 2).reset(seed=[1])


@pytest.mark.parametrize("way", [[-1.0], [1.0, 1.0, 1.0]])
def test_steps_after_the_end_are_told(loop, way):
    """As Gymnasium's own environments do; what comes after is up to the caller."""
    env = omma.gym.eye_env(loop)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(2):  # a reset begins anew
            env.reset(seed=1)
            over = [any(env.step(np.array([by]))[2:4]) for by in way]
            assert over == [False] * (len(way) - 1) + [True]
        # In many at once what is over starts anew by itself.
        many = omma.gym.eye_vector_env(loop, 2)
        many.reset(seed=1)
        for _ in range(5):
            many.step(np.full((2, 1), -1, np.float32))
    with pytest.warns(UserWarning, match=r"step: the episode is over .*expected reset\(\)"):
        env.step(np.array([1.0]))


def test_actions_beyond_the_space_are_for_wrappers_or_the_caller(loop):
    """As Gymnasium's checker of environments has it."""
    env, envs = omma.gym.eye_env(loop), omma.gym.eye_vector_env(loop, 2)
    env.reset(seed=1)
    assert env.step(np.array([5.0]))[1] == 5
    clipped = gymnasium.wrappers.ClipAction(env)
    clipped.reset(seed=1)
    assert clipped.step(np.array([5.0], np.float32))[1] == 1
    many = gymnasium.wrappers.vector.ClipAction(envs)
    many.reset(seed=1)
    assert many.step(np.array([[5.0], [0.5]], np.float32))[1].tolist() == [1, 0.5]


@pytest.mark.parametrize("name", ["nearest_m", "distance_m"])
def test_distances_that_no_loop_asked_for(loop, name):
    env = omma.gym.eye_env(replace(loop, ended=lambda moment: getattr(moment, name).min() < 1))
    env.reset(seed=1)
    with pytest.raises(omma.Error, match=rf"{name}: expected a loop with distances=True"):
        env.step(np.array([1.0]))


def test_there_are_no_pictures_of_environments(loop):
    for env in (omma.gym.eye_env(loop), omma.gym.eye_vector_env(loop, 2)):
        assert env.metadata["render_modes"] == []
        assert env.render_mode is None
        env.reset(seed=1)
        with pytest.warns(UserWarning, match="render: gives None.*plot_responses"):
            assert env.render() is None


def test_without_gymnasium(loop, monkeypatch):
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(omma.Error, match=r"pip install 'omma\[gym\]'"):
        omma.gym.eye_env(loop)
