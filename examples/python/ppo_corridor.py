"""A fly learns to steer through a winding corridor by proximal policy optimisation (PPO).

The corridor is that of corridor.py, where evolution finds four weights of a rule; here a network
with 28,000 weights finds its own, from what 200 ommatidia see in two frames. All 32 flies are one
environment whose poses, rewards and ends are arrays (docs/closed-loops.md). The algorithm is in
this one file, in the manner of CleanRL (Huang et al. 2022, J Mach Learn Res 23:274), after Schulman
et al. 2017 (arXiv:1707.06347); `--stable-baselines3` learns the same with that library besides, in
the same environment.

    pip install 'omma[learning]'
    python examples/python/ppo_corridor.py -o ppo-corridor.png
"""

import argparse
import time
from dataclasses import dataclass

import gymnasium
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import torch
from corridor import HEIGHT_M, LENGTH_M, TOO_NEAR_M, draw_ways, make_corridor
from torch import nn

import omma

RATE_HZ, SPEED_M_S, MOST_TURN_DEG = 10.0, 0.4, 25.0
STEPS = round(1.3 * LENGTH_M / SPEED_M_S * RATE_HZ)  # of an episode at most
OMMATIDIA, RAYS, FRAMES = 200, 8, 2


@dataclass
class Settings:
    """Of PPO; as CleanRL names them."""

    total_steps: int = 50_000
    num_envs: int = 32
    num_steps: int = 64  # of each environment between updates
    learning_rate: float = 1e-3  # falls to 0
    gamma: float = 0.98
    gae_lambda: float = 0.95
    update_epochs: int = 6
    num_minibatches: int = 8
    clip_coef: float = 0.2
    vf_coef: float = 0.5
    max_grad_norm: float = 0.5
    seed: int = 1


def fly_eye():
    """Ommatidia that look within 30° of the horizon, all around but behind."""
    eye = omma.eye.generate_eye(2 * OMMATIDIA)
    ahead = np.argsort(eye.axis[:, 2] + 2 * np.abs(eye.axis[:, 1]))[:OMMATIDIA]
    return eye.take(np.sort(ahead))


def make_loop(eye, phase, seed):
    """Fly the corridor: states are (across, along, heading) in m and degrees, of all flies."""
    world = omma.World(
        make_corridor(seed, phase), background=omma.Background.constant((0.9, 0.9, 0.9))
    )

    def poses_of(states):
        poses = np.tile(np.eye(4), (len(states), 1, 1))
        cos, sin = np.cos(np.radians(states[:, 2])), np.sin(np.radians(states[:, 2]))
        poses[:, [0, 2], [0, 2]], poses[:, 0, 2], poses[:, 2, 0] = cos[:, None], -sin, sin
        poses[:, 0, 3], poses[:, 1, 3], poses[:, 2, 3] = states[:, 0], HEIGHT_M / 2, -states[:, 1]
        return poses

    def start(count, rng):
        across, heading = rng.uniform(-0.06, 0.06, count), rng.uniform(-15, 15, count)
        states = np.stack([across, np.zeros(count), heading], axis=1)
        return states, poses_of(states)

    def motion(states, actions, rng):
        across, along, heading = states.T
        heading = heading + MOST_TURN_DEG * np.clip(actions[:, 0], -1, 1)
        ahead = SPEED_M_S / RATE_HZ * omma.eye.direction(heading, 0.0)
        states = np.stack([across + ahead[:, 0], along - ahead[:, 2], heading], axis=1)
        return states, poses_of(states)

    def reward(moment):
        """Decimetres along the corridor; a collision costs one."""
        return 10 * (moment.state[:, 1] - moment.before[:, 1]) - collides(moment)

    def collides(moment):
        return moment.nearest_m.min(axis=1) < TOO_NEAR_M

    def ended(moment):
        return collides(moment) | (moment.state[:, 1] > LENGTH_M)

    return omma.gym.Loop(
        omma.Renderer(world, eye, omma.Fixed(RAYS)), start, motion, reward,
        gymnasium.spaces.Box(-1, 1, (1,), np.float32), ended=ended, most_steps=STEPS,
        frames=FRAMES, distances=True, batched=True,
    )  # fmt: skip


def features(observations):
    """Green of the two frames, around 0: (K, N, B, F) to (K, 2 N)."""
    green = torch.as_tensor(observations[:, :, 1, :])
    return (green.flatten(1) - 0.5) / 0.25


class Agent(nn.Module):
    """A policy and a value, each of two layers; the policy's spread is learned."""

    def __init__(self):
        super().__init__()
        self.critic = self.layers(1, 1.0)
        self.actor = self.layers(1, 0.01)
        self.log_deviation = nn.Parameter(torch.full((1,), -0.5))

    @staticmethod
    def layers(outputs, gain):
        sizes, made = (FRAMES * OMMATIDIA, 32, 32, outputs), []
        for into, out, scale in zip(sizes[:-1], sizes[1:], (2**0.5, 2**0.5, gain)):
            layer = nn.Linear(into, out)
            nn.init.orthogonal_(layer.weight, scale)
            nn.init.zeros_(layer.bias)
            made += [layer, nn.Tanh()]
        return nn.Sequential(*made[:-1])

    def policy(self, seen):
        return torch.distributions.Normal(self.actor(seen), self.log_deviation.exp())

    def turn(self, observations):
        """What it would do if it did not try: (K, 1), for flights after learning."""
        with torch.no_grad():
            return self.actor(features(observations)).numpy()


class Flights:
    """How far flights come, as they end, by the number of steps so far and the time."""

    def __init__(self, count):
        self.now, self.ended, self.began = np.zeros(count), [], time.perf_counter()
        self.steps = 0

    def add(self, infos, rewards, over, started):
        self.steps += len(over)
        self.now = np.where(started, 0.0, -infos["pose"][:, 2, 3])
        passed = time.perf_counter() - self.began
        self.ended += [(self.steps, passed, far) for far in self.now[over]]

    def curve(self, pieces=40):
        """(steps, seconds, mean m) of the flights that ended in each piece of the learning."""
        ended = np.array(self.ended)
        which = np.minimum((ended[:, 0] / self.steps * pieces).astype(int), pieces - 1)
        return np.array([ended[which == k].mean(axis=0) for k in np.unique(which)])


def learn(loop, settings):
    """PPO; the agent, and its flights."""
    torch.manual_seed(settings.seed)
    envs = omma.gym.eye_vector_env(loop, settings.num_envs)
    agent = Agent()
    adam = torch.optim.Adam(agent.parameters(), settings.learning_rate, eps=1e-5)
    shape = (settings.num_steps, settings.num_envs)
    updates = max(1, settings.total_steps // (shape[0] * shape[1]))
    flights = Flights(settings.num_envs)
    observations, _ = envs.reset(seed=settings.seed)
    over = np.zeros(settings.num_envs, bool)
    for update in range(updates):
        adam.param_groups[0]["lr"] = settings.learning_rate * (1 - update / updates)
        seen = torch.zeros((*shape, FRAMES * OMMATIDIA))
        actions, log_chances = torch.zeros((*shape, 1)), torch.zeros(shape)
        rewards, values = torch.zeros(shape), torch.zeros((shape[0] + 1, shape[1]))
        # Where an episode starts anew the action does nothing: such steps do not count.
        counts, goes_on, not_cut = torch.zeros(shape), torch.zeros(shape), torch.zeros(shape)
        for step in range(shape[0]):
            seen[step] = features(observations)
            with torch.no_grad():
                policy = agent.policy(seen[step])
                actions[step] = policy.sample()
                log_chances[step] = policy.log_prob(actions[step]).sum(1)
                values[step] = agent.critic(seen[step])[:, 0]
            started = over
            observations, gained, ended, cut_off, infos = envs.step(actions[step].numpy())
            over = ended | cut_off
            flights.add(infos, gained, over, started)
            rewards[step] = torch.as_tensor(gained)
            counts[step] = torch.as_tensor(~started)
            goes_on[step], not_cut[step] = torch.as_tensor(~ended), torch.as_tensor(~over)
        with torch.no_grad():
            values[-1] = agent.critic(features(observations))[:, 0]
        advantages = estimate_advantages(rewards, values, goes_on, not_cut, settings)
        chosen = counts.flatten() > 0
        batch = [
            value.flatten(0, 1)[chosen]
            for value in (seen, actions, log_chances, advantages, advantages + values[:-1])
        ]
        improve(agent, adam, batch, settings)
    return agent, flights


def estimate_advantages(rewards, values, goes_on, not_cut, settings):
    """Generalised advantages (Schulman et al. 2016, arXiv:1506.02438): an end is worth nothing
    further, a cut-off what the critic says of where it was cut."""
    advantages, later = torch.zeros_like(rewards), torch.zeros(rewards.shape[1])
    for step in reversed(range(len(rewards))):
        surprise = rewards[step] + settings.gamma * values[step + 1] * goes_on[step] - values[step]
        later = surprise + settings.gamma * settings.gae_lambda * not_cut[step] * later
        advantages[step] = later
    return advantages


def improve(agent, adam, batch, settings):
    """Some epochs of the clipped objective."""
    count = len(batch[0])
    for _ in range(settings.update_epochs):
        for part in torch.randperm(count).chunk(settings.num_minibatches):
            seen, actions, old, advantages, returns = (value[part] for value in batch)
            policy = agent.policy(seen)
            ratio = (policy.log_prob(actions).sum(1) - old).exp()
            advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
            clipped = ratio.clamp(1 - settings.clip_coef, 1 + settings.clip_coef)
            gain = torch.minimum(ratio * advantages, clipped * advantages).mean()
            miss = 0.5 * (agent.critic(seen)[:, 0] - returns).square().mean()
            adam.zero_grad()
            (settings.vf_coef * miss - gain).backward()
            nn.utils.clip_grad_norm_(agent.parameters(), settings.max_grad_norm)
            adam.step()


def learn_with_stable_baselines3(loop, settings):
    """The same by Stable-Baselines3: what turns, and the flights."""
    import stable_baselines3
    from stable_baselines3.common.vec_env import VecEnv

    flights = Flights(settings.num_envs)

    class Together(VecEnv):
        """The environments as that library has them: they start anew in the step that ends."""

        def __init__(self):
            self.envs = omma.gym.eye_vector_env(loop, settings.num_envs)
            seen = gymnasium.spaces.Box(-10, 10, (FRAMES * OMMATIDIA,), np.float32)
            super().__init__(settings.num_envs, seen, loop.action_space)

        def reset(self):
            return features(self.envs.reset(seed=settings.seed)[0]).numpy()

        def step_async(self, actions):
            self.actions = actions

        def step_wait(self):
            observations, gained, ended, cut_off, infos = self.envs.step(self.actions)
            over = ended | cut_off
            flights.add(infos, gained, over, np.zeros(settings.num_envs, bool))
            seen, told = features(observations).numpy(), [{} for _ in over]
            if over.any():
                for k in np.flatnonzero(over):
                    told[k] = {
                        "terminal_observation": seen[k],
                        "TimeLimit.truncated": bool(cut_off[k] and not ended[k]),
                    }
                seen = features(self.envs.reset(options={"reset_mask": over})[0]).numpy()
            return seen, gained.astype(np.float32), over, told

        def close(self):
            self.envs.close()

        def get_attr(self, name, indices=None):
            return [getattr(self, name, None)] * self.num_envs

        def set_attr(self, name, value, indices=None):
            raise NotImplementedError

        def env_method(self, name, *arguments, indices=None, **named):
            raise NotImplementedError

        def env_is_wrapped(self, wrapper_class, indices=None):
            return [False] * self.num_envs

    size = settings.num_envs * settings.num_steps
    model = stable_baselines3.PPO(
        "MlpPolicy", Together(), learning_rate=lambda left: settings.learning_rate * left,
        n_steps=settings.num_steps, batch_size=size // settings.num_minibatches,
        n_epochs=settings.update_epochs, gamma=settings.gamma, gae_lambda=settings.gae_lambda,
        clip_range=settings.clip_coef, vf_coef=settings.vf_coef,
        max_grad_norm=settings.max_grad_norm, seed=settings.seed, device="cpu",
        policy_kwargs={"net_arch": [32, 32], "log_std_init": -0.5},
    )  # fmt: skip
    model.learn(settings.total_steps)

    def turn(observations):
        return model.predict(features(observations).numpy(), deterministic=True)[0]

    return turn, flights


def fly(loop, turn, count=8):
    """How far flies come, m, and their ways (steps, flies, 2) as corridor.py draws them."""
    envs = omma.gym.eye_vector_env(loop, count)
    observations, _ = envs.reset(seed=10**6)
    come, going, ways = np.zeros(count), np.ones(count, bool), []
    while going.any():
        observations, _, ended, cut_off, infos = envs.step(turn(observations))
        place = infos["pose"][:, [0, 2], 3]
        come = np.where(going, -place[:, 1], come)
        ways.append(np.where(going[:, None], place, np.nan))
        going &= ~(ended | cut_off)
    return come, np.stack(ways)


def draw(path, curves, ways, phase):
    """Curves: (name, curve of `Flights`)."""
    figure = plt.figure(figsize=(12, 6.4), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.2, 1))
    panels = upper.subplots(1, 2, sharey=True)
    for (name, curve), colour in zip(curves, ("#0072b2", "#d55e00")):
        panels[0].plot(curve[:, 0] / 1000, curve[:, 2], color=colour, label=name)
        panels[1].plot(curve[:, 1] / 60, curve[:, 2], color=colour, label=name)
    for panel, text in zip(panels, ("thousand steps of a fly", "minutes on two cores")):
        panel.axhline(LENGTH_M, color="0.6", ls="--", lw=1)
        panel.set(xlabel=text, ylim=(0, 1.1 * LENGTH_M))
        panel.spines[["top", "right"]].set_visible(False)
    panels[0].text(0, LENGTH_M * 1.02, "the corridor's end", color="0.4", fontsize=8)
    panels[0].set_ylabel("how far flights come, m")
    panels[0].set_title("Learning, with the turns that are tried", fontsize=10, loc="left")
    panels[1].legend(frameon=False, fontsize=8, loc="lower right")
    below = lower.subplots(1, 1)
    draw_ways(below, ways, phase, "#0072b2", None)
    below.set_title("8 flies that have learned, in another corridor, from above",
                    fontsize=10, loc="left")  # fmt: skip
    below.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="ppo-corridor.png", help="the figure")
    parser.add_argument("--steps", type=int, default=Settings.total_steps,
                        help="of all flies together (default: %(default)s)")  # fmt: skip
    parser.add_argument("--seed", type=int, default=Settings.seed, help="(default: %(default)s)")
    parser.add_argument("--stable-baselines3", action="store_true", help="learn by it besides")
    asked = parser.parse_args()
    torch.set_num_threads(1)  # small layers; the other core renders
    settings = Settings(total_steps=asked.steps, seed=asked.seed)
    eye = fly_eye()
    loop, other = make_loop(eye, phase=0.0, seed=1), make_loop(eye, phase=2.5, seed=2)
    agent, flights = learn(loop, settings)
    curves = [("PPO in this file", flights.curve())]
    come, ways = fly(other, agent.turn)
    print(f"{flights.steps:,} steps in {curves[0][1][-1, 1]:.0f} s; the last flights came "
          f"{curves[0][1][-1, 2]:.2f} m, in another corridor {come.mean():.2f} m")  # fmt: skip
    if asked.stable_baselines3:
        turn, flights = learn_with_stable_baselines3(loop, settings)
        curves.append(("Stable-Baselines3", flights.curve()))
        come, _ = fly(other, turn)
        print(f"Stable-Baselines3: {curves[1][1][-1, 1]:.0f} s; the last flights came "
              f"{curves[1][1][-1, 2]:.2f} m, in another corridor {come.mean():.2f} m")  # fmt: skip
    draw(asked.output, curves, ways, 2.5)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
