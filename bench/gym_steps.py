"""100,000 steps of a closed loop in a small scene: steps a second, and memory on the way.

.venv/bin/python bench/gym_steps.py [steps] [together]

A walk in a drum of blotches, as in tests/python/test_gym.py, whose episodes end by rays or are cut
off; ``together`` environments are rendered in one call. Prints the resident memory at each tenth.
"""

import gc
import resource
import sys
import time

import gymnasium
import numpy as np

import omma


def pose_of(state):
    return omma.look_at((0, 0, state[0]), (0, 0, state[0]) + omma.eye.direction(state[1], 0))


def start(rng):
    state = (float(rng.uniform(0.9, 1.1)), float(rng.uniform(0, 360)))
    return state, pose_of(state)


def walk(state, action, rng):
    state = (state[0] + 0.05 * float(action[0]), state[1] + 5 * float(action[1]))
    return state, pose_of(state)


def resident_mb():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


def main():
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    together = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    picture = np.random.default_rng(2).random((8, 40, 3)).astype(np.float32)
    box = omma.scene.box((0.4, 0.4, 0.4), (0.1, 0.2, 0.3))
    world = omma.World(omma.scene.merge_scenes([omma.scene.drum(2.0, 4.0, picture), box]))
    renderer = omma.Renderer(world, omma.eye.generate_eye(100, radius_m=1e-3), omma.Fixed(8))
    loop = omma.gym.Loop(
        renderer,
        start,
        walk,
        reward=lambda moment: -abs(moment.state[0] - 1),
        action_space=gymnasium.spaces.Box(-1, 1, (2,), np.float32),
        ended=lambda moment: bool(moment.nearest_m.min() < 0.3),
        most_steps=200,
        frames=2,
        distances=True,
    )
    envs = omma.gym.eye_vector_env(loop, together)
    envs.action_space.seed(0)
    envs.reset(seed=0)
    done, episodes, began = 0, 0, time.perf_counter()
    tenth = steps // 10
    while done < steps:
        before = done
        _, _, ended, cut_off, _ = envs.step(envs.action_space.sample())
        done += together
        episodes += int((ended | cut_off).sum())
        if done // tenth > before // tenth:
            gc.collect()
            rate = done / (time.perf_counter() - began)
            print(f"{done:9,} steps, {episodes:6,} episodes, {rate:8,.0f} steps/s, "
                  f"{resident_mb():7.1f} MB", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
