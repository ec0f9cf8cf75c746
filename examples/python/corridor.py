"""A fly learns to follow a winding corridor by the flow on its left and on its right.

It flies at a constant speed, straight on for a fifth of a second, then turns at once by an angle
that it chooses, as flies do in saccades; while it goes straight all that passes tells of walls.
Motion detectors between neighbours in its eyes (docs/motion-detection.md) see how much passes in
three sectors of each eye, and four numbers say how it turns by the differences of left and right
and by how it turned before. They are learned by evolution strategies from how far it comes before
rays from its eyes are shorter than 4 cm: 32 flies at a time, in one environment whose views are
rendered in one call (docs/closed-loops.md). At the end some that have learned fly another corridor,
and some that have not.

python examples/python/corridor.py -o corridor-learning.png
"""

import argparse
import time

import gymnasium
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import omma

RATE_HZ, SPEED_M_S, MOST_TURN_DEG = 40.0, 0.4, 30.0
FIXATION = 8  # frames from one saccade to the next
LENGTH_M, WIDTH_M, HEIGHT_M, BEND_M, PERIOD_M = 4.0, 0.4, 0.4, 0.22, 2.4
TOO_NEAR_M = 0.04
TAU_S, HIGH_PASS_TAU_S = 0.035, 0.25
SECTORS_DEG = ((20, 50), (50, 90), (90, 130))  # from straight ahead, in each eye
STEPS = round(1.3 * LENGTH_M / SPEED_M_S * RATE_HZ)
PAIRS, STEP_SIZE, NOISE = 16, 1.0, 0.5  # of evolution strategies


def middle_m(along_m, phase):
    """Where the middle of the corridor is across, at a distance from its beginning."""
    straight = np.clip(along_m / 0.6, 0, 1)  # it begins in the middle, without a bend
    return straight * BEND_M * (np.sin(2 * np.pi * along_m / PERIOD_M + phase) - np.sin(phase))


def make_corridor(seed, phase):
    """Walls of short planes along the bends, each with blotches of its own; a floor, no ceiling."""
    rng = np.random.default_rng(seed)
    edges = np.linspace(-0.6, LENGTH_M + 0.6, 53)
    pieces = []
    for side in (-1, 1):
        wall = np.stack([middle_m(edges, phase) + side * WIDTH_M / 2, -edges], axis=1)
        for k, (here, there) in enumerate(zip(wall[:-1], wall[1:])):
            length = np.hypot(*(there - here))
            # Blotches of 2.5 cm, and half the contrast in some of 10 cm.
            fine = rng.random((16, 4, 1)) + 0.5 * np.repeat(np.repeat(
                rng.random((4, 1, 1)), 4, 0), 4, 1)  # fmt: skip
            picture = np.repeat(fine / 1.5, 3, axis=2).astype(np.float32)
            centre = ((here[0] + there[0]) / 2, HEIGHT_M / 2, (here[1] + there[1]) / 2)
            across = np.array([there[1] - here[1], 0, here[0] - there[0]]) * side
            pieces.append(
                omma.scene.plane(
                    (length * 1.02, HEIGHT_M), picture, center_m=centre, facing=across / length,
                    name=f"wall {side} {k}",
                )
            )  # fmt: skip
    floor = rng.random((200, 80, 1)).repeat(3, 2).astype(np.float32) * 0.4
    pieces.append(omma.scene.plane((2.0, 5.5), floor, center_m=(0, 0, -LENGTH_M / 2)))
    return omma.scene.merge_scenes(pieces)


def fly_eyes():
    """Of a fruit fly's two eyes those ommatidia that look within 25° of the horizon."""
    eye = omma.species.drosophila().eye
    level = np.abs(eye.axis[:, 1]) < np.sin(np.radians(25))
    return omma.Eye(
        eye.position_m[level], eye.axis[level], eye.acceptance_angle_rad[level],
        eye_id=eye.eye_id[level],
    )  # fmt: skip


def make_loop(eye, phase, seed):
    """Fly the corridor: the state is (across, along, heading) in m and degrees."""
    sky = omma.Background.constant((0.9, 0.9, 0.9))
    world = omma.World(make_corridor(seed, phase), background=sky)

    def pose(state):
        across, along, heading = state
        here = np.array([across, HEIGHT_M / 2, -along])
        return omma.look_at(here, here + omma.eye.direction(heading, 0.0))

    def start(rng):
        state = (rng.uniform(-0.06, 0.06), 0.0, rng.uniform(-15, 15))
        return state, pose(state)

    def motion(state, action, rng):
        across, along, heading = state
        heading += np.clip(float(action[0]), -1, 1) * MOST_TURN_DEG
        step = SPEED_M_S / RATE_HZ
        across += step * np.sin(np.radians(heading))
        along += step * np.cos(np.radians(heading))
        state = (across, along, heading)
        return state, pose(state)

    def progress(moment):
        return moment.state[1] - moment.before[1]

    def over(moment):
        return moment.nearest_m.min() < TOO_NEAR_M or moment.state[1] > LENGTH_M

    return omma.gym.Loop(
        omma.Renderer(world, eye, omma.Fixed(4)), start, motion, progress,
        gymnasium.spaces.Box(-1, 1, (1,), np.float32), ended=over, most_steps=STEPS,
        distances=True,
    )  # fmt: skip


class Flow:
    """What the walls do on both sides, for many flies at once."""

    def __init__(self, eye):
        towards_front = omma.motion.neighbour_pairs(eye, ["q", "-p"])
        self.detectors = omma.motion.detector_array(
            eye, TAU_S, RATE_HZ, pairs=towards_front, high_pass_tau_s=HIGH_PASS_TAU_S
        )
        azimuth = omma.eye.azimuth_elevation_deg_of(eye.axis)[0][towards_front[:, 0]]
        self.groups = [
            [np.flatnonzero((side * azimuth > low) & (side * azimuth < high)) for side in (-1, 1)]
            for low, high in SECTORS_DEG
        ]
        self.forget()

    def forget(self):
        """What a saccade sweeps over the eye is not seen: detectors begin anew."""
        self.state, self.passed = None, 0.0

    def see(self, light):
        """Add up what passes to the back in a frame, light (flies, N)."""
        self.state, outputs = self.detectors.step(self.state, light.T.astype(float))
        # Detectors prefer motion to the front.
        means = [[-outputs[one].mean(axis=0) for one in pair] for pair in self.groups]
        self.passed = self.passed + np.array(means)

    def differences(self):
        """How much more has passed on the left, in each sector: (sectors, flies), -1 to 1."""
        left, right = np.moveaxis(self.passed, 1, 0)
        return (left - right) / (np.abs(left) + np.abs(right) + 1e-9)


def fly(loop, weights, seeds):
    """How far each fly comes, m, with weights (flies, 4) of its own; and the ways they took."""
    envs = omma.gym.eye_vector_env(loop, len(weights))
    flow = Flow(loop.renderer.eye)
    light, _ = envs.reset(seed=list(seeds))
    before = np.zeros(len(weights))
    come, going = np.zeros(len(weights)), np.ones(len(weights), bool)
    ways = []
    while going.any():
        flow.see(light[:, :, 1])
        turn = np.zeros(len(weights))
        if len(ways) % FIXATION == FIXATION - 1:
            turn = np.tanh((weights.T * [*flow.differences(), before]).sum(axis=0))
            before = turn
            flow.forget()
        light, rewards, ended, cut_off, infos = envs.step(turn[:, None].astype(np.float32))
        come += np.where(going, rewards, 0)
        ways.append(np.where(going[:, None], infos["pose"][:, [0, 2], 3], np.nan))
        going &= ~(ended | cut_off)
    return come, np.stack(ways)


def learn(loop, generations, seed=0):
    """Evolution strategies with mirrored samples (Salimans et al. 2017, arXiv:1703.03864), steps
    by rank. Weights (generations + 1, 4), and what each generation's flies came, (g, 2 PAIRS)."""
    rng = np.random.default_rng(seed)
    weights, curve, courses = np.zeros(len(SECTORS_DEG) + 1), [], []
    courses.append(weights.copy())
    for generation in range(generations):
        tried = rng.normal(size=(PAIRS, len(weights)))
        both = weights + NOISE * np.concatenate([tried, -tried])
        come, _ = fly(loop, both, np.tile(1000 * generation + np.arange(PAIRS), 2))
        rank = np.argsort(np.argsort(come)) / (len(come) - 1) - 0.5
        gain = ((rank[:PAIRS] - rank[PAIRS:])[:, None] * tried).mean(axis=0)
        weights = weights + STEP_SIZE / NOISE * gain
        curve.append(come)
        courses.append(weights.copy())
        print(f"generation {generation:2}: {come.mean():.2f} m on average, weights "
              f"{' '.join(f'{w:+.2f}' for w in weights)}", flush=True)  # fmt: skip
    return np.array(courses), np.array(curve)


def draw_ways(panel, ways, phase, colour, label):
    along = np.linspace(-0.3, LENGTH_M + 0.3, 300)
    for side in (-1, 1):
        panel.plot(along, middle_m(along, phase) + side * WIDTH_M / 2, color="0.2", lw=1.5)
    for k in range(ways.shape[1]):
        across, back = ways[:, k].T
        panel.plot(-back, across, color=colour, lw=0.8, label=label if k == 0 else None)
        last = np.flatnonzero(np.isfinite(across))[-1]
        panel.plot(-back[last], across[last], ".", color=colour, ms=5)
    panel.set(xlabel="along, m", ylabel="across, m", aspect="equal", xlim=(-0.3, LENGTH_M + 0.3))
    panel.invert_yaxis()  # seen from above, the right is below


def draw(path, curve, courses, untaught, taught, phase, seconds):
    figure = plt.figure(figsize=(12, 7.2), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.1, 1))
    left, right = upper.subplots(1, 2)
    generations = np.arange(len(curve))
    middle = np.median(curve, axis=1)
    low, high = np.quantile(curve, (0.1, 0.9), axis=1)
    left.fill_between(generations, low, high, color="#0072b2", alpha=0.2, lw=0,
                      label="middle 80 % of 32 flies")  # fmt: skip
    left.plot(generations, middle, color="#0072b2", label="median")
    left.axhline(LENGTH_M, color="0.6", ls="--", lw=1)
    left.text(0, LENGTH_M * 1.015, "the corridor's end", color="0.4", fontsize=8)
    left.set(xlabel="generation", ylabel="how far they come, m", ylim=(0, 1.12 * LENGTH_M))
    left.set_title(f"Learning: {seconds / 60:.1f} minutes on two cores", fontsize=10)
    left.legend(frameon=False, fontsize=8, loc="lower right")
    names = [f"flow, {a}° to {b}°" for a, b in SECTORS_DEG] + ["the turn before"]
    colours = ("#0072b2", "#009e73", "#56b4e9", "#d55e00")
    for name, course, colour in zip(names, courses.T, colours):
        right.plot(np.arange(len(courses)), course, label=name, color=colour)
    right.axhline(0, color="0.7", lw=0.8)
    right.set(xlabel="generation", ylabel="weight")
    right.set_title("What decides on the turn (above 0: to the right, if more passes left)",
                    fontsize=10)  # fmt: skip
    right.legend(frameon=False, fontsize=8)
    panels = lower.subplots(2, 1, sharex=True)
    draw_ways(panels[0], untaught, phase, "#d55e00", None)
    panels[0].set_title("Another corridor, seen from above: 8 flies that do not turn", fontsize=10)
    panels[0].set_xlabel("")
    draw_ways(panels[1], taught, phase, "#0072b2", None)
    panels[1].set_title("8 flies that have learned", fontsize=10)
    for panel in (left, right, *panels):
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="corridor-learning.png", help="the figure")
    parser.add_argument("--generations", type=int, default=12, help="(default: 12)")
    asked = parser.parse_args()
    eye = fly_eyes()
    began = time.perf_counter()
    courses, curve = learn(make_loop(eye, phase=0.0, seed=1), asked.generations)
    seconds = time.perf_counter() - began
    print(f"{len(eye)} ommatidia, {curve.size} flights in {seconds:.0f} s")
    other = make_loop(eye, phase=2.5, seed=2)
    seeds = 10**6 + np.arange(8)
    before, untaught = fly(other, np.zeros((8, len(courses[0]))), seeds)
    after, taught = fly(other, np.tile(courses[-1], (8, 1)), seeds)
    print(f"another corridor: {before.mean():.2f} m before, {after.mean():.2f} m after")
    draw(asked.output, curve, courses, untaught, taught, 2.5, seconds)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
