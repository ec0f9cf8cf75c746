"""Steps a second of one environment and of many in one call, by how much an episode's own Python
costs beside its frame.

.venv/bin/python bench/gym_vector.py [together] [ommatidia] [rays]

A body flies in a drum of blotches; its physics are Euler steps in NumPy, so many each step. The
same functions serve one environment, many of them one after another (`omma.gym.Loop`), and many in
arrays (`Loop(batched=True)`). All take turns, and the best of some rounds counts, as on a busy
machine it is nearest to an idle one.
"""

import platform
import sys
import time

import gymnasium
import numpy as np

import omma

SUBSTEPS = (0, 10, 20, 40)
ROUNDS, SECONDS = 12, 0.25
STEP_S, DRAG_S, SPIN_S = 1e-3, 0.05, 0.02


def pose_of(state):
    """(K, 4, 4) of K bodies."""
    poses = np.zeros((len(state), 4, 4))
    sin, cos = np.sin(state[:, 6]), np.cos(state[:, 6])
    poses[:, 0, 0], poses[:, 0, 2], poses[:, 2, 0], poses[:, 2, 2] = cos, -sin, sin, cos
    poses[:, 1, 1] = poses[:, 3, 3] = 1
    poses[:, :3, 3] = state[:, :3]
    return poses


def fly(state, action, substeps):
    """Positions and velocities (K, 3), yaw and its rate: (K, 8) after an action (K, 2)."""
    place, speed, yaw, rate = state[:, :3], state[:, 3:6], state[:, 6], state[:, 7]
    for _ in range(substeps):
        ahead = np.stack([np.sin(yaw), np.zeros_like(yaw), -np.cos(yaw)], axis=1)
        speed = speed + STEP_S * (20.0 * action[:, :1] * ahead - speed / DRAG_S)
        place = place + STEP_S * speed
        rate = rate + STEP_S * (300.0 * action[:, 1] - rate / SPIN_S)
        yaw = yaw + STEP_S * rate
    return np.concatenate([place, speed, yaw[:, None], rate[:, None]], axis=1)


def loops(renderer, substeps):
    """The same flight, one environment at a time and in arrays."""

    def start(count, rng):
        state = np.zeros((count, 8))
        state[:, 2] = rng.uniform(0.9, 1.1, count)
        state[:, 6] = rng.uniform(0, 2 * np.pi, count)
        return state, pose_of(state)

    def motion(states, actions, rng):
        states = fly(states, actions, substeps)
        return states, pose_of(states)

    def reward(moment):
        return -np.abs(moment.state[..., 2] - 1) - 0.01 * np.abs(moment.state[..., 7])

    def start_one(rng):
        states, poses = start(1, rng)
        return states[0], poses[0]

    def motion_one(state, action, rng):
        states, poses = motion(state[None], action[None], rng)
        return states[0], poses[0]

    common = {
        "reward": reward,
        "action_space": gymnasium.spaces.Box(-1, 1, (2,), np.float32),
        "ended": lambda moment: moment.responses.mean(axis=(-2, -1)) < 0.05,
        "most_steps": 200,
    }
    plain = omma.gym.Loop(renderer, start_one, motion_one, **common)
    batched = omma.gym.Loop(renderer, start, motion, batched=True, **common)
    return plain, batched, motion_one


def timed(step):
    """Seconds a call takes, of calls for a while."""
    number, began = 0, time.perf_counter()
    while (passed := time.perf_counter() - began) < SECONDS or number < 3:
        step()
        number += 1
    return passed / number


def main():
    together, ommatidia, rays = (int(n) for n in (*sys.argv[1:4], 64, 200, 8)[:3])
    picture = np.random.default_rng(2).random((8, 40, 3)).astype(np.float32)
    box = omma.scene.box((0.4, 0.4, 0.4), (0.1, 0.2, 0.3))
    world = omma.World(omma.scene.merge_scenes([omma.scene.drum(2.0, 4.0, picture), box]))
    renderer = omma.Renderer(world, omma.eye.generate_eye(ommatidia), omma.Fixed(rays))
    print(f"{platform.processor() or platform.machine()}, {ommatidia} ommatidia of {rays} rays, "
          f"{together} together, best of {ROUNDS}; times in µs")  # fmt: skip
    print("substeps | own Python | frame alone | frame in a batch | one: steps/s | in turn: steps/s"
          " | in arrays: steps/s | times one")  # fmt: skip
    for substeps in SUBSTEPS:
        found = measured(renderer, substeps, together)
        own, alone, batch, single, turns, array = found
        print(f"{substeps} | {1e6 * own:.0f} | {1e6 * alone:.0f} | {1e6 * batch / together:.0f} | "
              f"{1 / single:,.0f} | {together / turns:,.0f} | {together / array:,.0f} | "
              f"{together / array * single:.1f}", flush=True)  # fmt: skip


def measured(renderer, substeps, together):
    """Seconds of the own Python of a step, of a frame alone, of a batch of frames, and of a step of
    one environment, of many in turn, of many in arrays."""
    plain, batched, motion_one = loops(renderer, substeps)
    one = omma.gym.eye_env(plain)
    many = omma.gym.eye_vector_env(plain, together)
    arrays = omma.gym.eye_vector_env(batched, together)
    one.reset(seed=0)
    for envs in (many, arrays):
        envs.action_space.seed(0)
        envs.reset(seed=0)
    actions = many.action_space.sample()
    state, poses = batched.start(together, np.random.default_rng(0))

    def step_one():
        if any(one.step(actions[0])[2:4]):
            one.reset()

    ways = [
        lambda: motion_one(state[0], actions[0], None),
        lambda: renderer.render(poses[:1]),
        lambda: renderer.render(poses),
        step_one,
        lambda: many.step(actions),
        lambda: arrays.step(actions),
    ]
    return np.min([[timed(way) for way in ways] for _ in range(ROUNDS)], axis=0)


if __name__ == "__main__":
    main()
