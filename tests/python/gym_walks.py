"""A walk in a room, as a loop that tests of environments share."""

import numpy as np
import pytest

import omma

gymnasium = pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'omma[gym]'")

WALL_M = 2.0


def make_walker():
    """An eye in a room of blotches, in whose middle stands a box: it walks and turns."""
    picture = np.random.default_rng(2).random((8, 40, 3)).astype(np.float32)
    box = omma.scene.box((0.4, 0.4, 0.4), (0.1, 0.2, 0.3), name="crate")
    world = omma.World(omma.scene.merge_scenes([omma.scene.drum(WALL_M, 4.0, picture), box]))
    return omma.Renderer(world, omma.eye.generate_eye(40, radius_m=1e-3), omma.Fixed(4), threads=1)


def start(rng):
    state = (float(rng.uniform(0.9, 1.1)), float(rng.uniform(0, 360)))
    return state, pose_of(state)


def pose_of(state):
    return omma.look_at((0, 0, state[0]), (0, 0, state[0]) + omma.eye.direction(state[1], 0))


def walk(state, action, rng):
    away, azimuth = state
    state = (away + 0.05 * float(action[0]) + 0.001 * rng.normal(), azimuth + 5 * float(action[1]))
    return state, pose_of(state)


def closeness(moment):
    return -abs(moment.state[0] - 1)


def collided(moment):
    return bool(moment.nearest_m.min() < 0.3)


def loop_of(renderer, **changes):
    """A walk between the box and the wall, over after 12 steps or where either is near."""
    parts = {
        "start": start,
        "motion": walk,
        "reward": closeness,
        "action_space": gymnasium.spaces.Box(-1, 1, (2,), np.float32),
        "ended": collided,
        "most_steps": 12,
        "distances": True,
    }
    return omma.gym.Loop(renderer, **(parts | changes))
