"""A network in the shape of the fly's motion pathway learns direction selectivity from what Omma
renders: from a world to T4 and T5, without anything to download.

Cells of 23 types stand in each of 61 columns, wired as they are known to be in *Drosophila*, in
short: R1-6, L1, L2, L3 and L5; Mi1, Tm3, Mi4, Mi9 and CT1 to T4 for brightening; Tm1, Tm2, Tm4, Tm9
and CT1 to T5 for darkening; four subtypes of both (names, partners and signs as in Shinomiya et al.
2019, eLife 8:e40025, and Borst, Haag and Mauss 2020, J Comp Physiol A 206:109; recalled, not read,
and simplified). Signs are fixed, strengths and time constants are learned, the same in all columns.
T4 and T5 get each input from seven columns; which of them counts for which subtype is not told. The
task is the direction of motion, as in Lappalainen et al. 2024 (Nature 634:1132): activities of the
subtypes, as vectors to the four sides, are to add up to it. Gratings and edges of Omma's stimuli
are seen through ommatidia of 5°, by a lattice in the order of flyvis' hexals.

    pip install 'omma[torch,plots]'
    python examples/python/t4t5.py -o t4t5.png
"""

import argparse
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import torch
from torch import nn

import omma

SPACING_DEG, RATE_HZ, FRAMES, SETTLING = 5.0, 100.0, 60, 12
RADIUS = 4  # 61 columns
# After whom, and by which sign, within a column; in the order in which signals pass.
WIRING = {
    "R": (),
    "L1": (("R", -1),), "L2": (("R", -1),), "L3": (("R", -1),), "L5": (("L1", -1),),
    "Mi1": (("L1", -1),), "Tm3": (("L1", -1),), "Mi4": (("L5", 1),), "Mi9": (("L3", 1),),
    "CT1 M10": (("Mi1", 1),),
    "Tm1": (("L2", 1),), "Tm2": (("L2", 1),), "Tm4": (("L2", 1),), "Tm9": (("L3", 1),),
    "CT1 Lo1": (("Tm9", 1),),
}  # fmt: skip
INPUTS = {
    "T4": (("Mi1", 1), ("Tm3", 1), ("Mi4", -1), ("Mi9", -1), ("CT1 M10", -1)),
    "T5": (("Tm1", 1), ("Tm2", 1), ("Tm4", 1), ("Tm9", 1), ("CT1 Lo1", -1)),
}
# What activity is at an even field of 0.5, and how slow a cell is, before learning: s.
REST = {"R": 0.5, "L1": 0.5, "L2": 0.5, "L3": 0.5, "Mi9": 0.5}
TAU_S = {"Mi4": 0.06, "Mi9": 0.06, "Tm9": 0.06, "CT1 M10": 0.06, "CT1 Lo1": 0.06}
SHARPNESS = 20.0  # of the threshold of cells: at it their rate is 0.03
# Of the sum of subtypes; and the mean rate at which learning holds each: that of cells which have
# 1 / GAIN for their direction and nothing for the others, as the mean of max(cos θ, 0) is 1/π.
GAIN = 10.0
ACTIVITY = 1 / (np.pi * GAIN)
SUBTYPES = {"a": 0.0, "b": 180.0, "c": 90.0, "d": -90.0}  # to the right, left, up, down


def column_lattice(radius=RADIUS):
    """An eye of one ommatidium for each hexal, that looks ahead; and the seven hexals around each
    (M, 7), itself first, then by direction from the right on; itself where there is none."""
    columns = omma.columns.hexal_columns(radius, np.radians(SPACING_DEG), (0, 0, -1))
    eye = omma.columns.eye_of_columns(columns, np.radians(SPACING_DEG))
    towards = np.stack(omma.eye.azimuth_elevation_deg_of(columns.axis), axis=1)
    steps = towards[None] - towards[:, None]
    near = np.hypot(*np.moveaxis(steps, -1, 0)) < 1.5 * SPACING_DEG
    around = np.tile(np.arange(len(eye))[:, None], (1, 7))
    for cell in range(len(eye)):
        for other in np.flatnonzero(near[cell]):
            if other != cell:
                angle = np.degrees(np.arctan2(*steps[cell, other, ::-1]))
                around[cell, 1 + round((angle - 30) / 60) % 6] = other
    inner = (around[:, 1:] != np.arange(len(eye))[:, None]).all(axis=1)
    return eye, around, inner


def watch(eye, stimuli, rays=16):
    """Light on all columns (S, T, M), float32."""
    times = np.arange(FRAMES) / RATE_HZ
    seen = []
    for one in stimuli:
        renderer = omma.Renderer(one.world(), eye, omma.Fixed(rays))
        seen.append(one.play(renderer, times)[:, :, 1])
    return torch.from_numpy(np.stack(seen))


def gratings(directions_deg, wavelengths_deg, frequencies_hz):
    """Stimuli and where they go, unit vectors (S, 2); 0 where they stand still."""
    made = [
        (omma.stimuli.SphereGrating(wavelength, frequency, direction_deg=direction,
                                    phase_deg=77.0 * k), frequency > 0)
        for k, direction in enumerate(directions_deg)
        for wavelength in wavelengths_deg
        for frequency in frequencies_hz
    ]  # fmt: skip
    return [one for one, _ in made], np.array([unit(one.direction_deg) * go for one, go in made])


def edges(directions_deg, speeds_deg_s, brightening):
    """ON or OFF edges that pass the columns, and where they go."""
    light = {"behind": 0.9, "ahead": 0.1} if brightening else {"behind": 0.1, "ahead": 0.9}
    made = [
        omma.stimuli.edge(speed, -0.5 * speed * FRAMES / RATE_HZ, direction_deg=direction, **light)
        for direction in directions_deg
        for speed in speeds_deg_s
    ]
    return made, np.array([unit(one.direction_deg) for one in made])


def unit(direction_deg):
    return np.array([np.cos(np.radians(direction_deg)), np.sin(np.radians(direction_deg))])


def rate(potential):
    """A soft threshold at 0, below which learning still finds a way back."""
    return nn.functional.softplus(potential, beta=SHARPNESS)


class Network(nn.Module):
    """Leaky cells: τ dV/dt = -V + bias + Σ ± strength × rate of a potential, with drives that
    stand still for a frame. Strengths are positive (softplus) and the same in all columns. Signals
    pass from cell to cell without a way back, so that each type is filtered in time at once."""

    def __init__(self, around, seed=0):
        super().__init__()
        generator = torch.Generator().manual_seed(seed)
        # Whether a column is one of the seven around another: (from, to, which).
        self.seven = torch.eye(len(around))[:, torch.as_tensor(around)]
        self.bias, self.log_tau, self.strength = (nn.ParameterDict() for _ in range(3))
        for name, partners in WIRING.items():
            into = sum(sign * REST.get(other, 0.0) for other, sign in partners)
            rest = REST.get(name, 0.0) - (0.5 if name == "R" else into)
            self.bias[name] = nn.Parameter(torch.tensor(rest))
            self.log_tau[name] = nn.Parameter(torch.tensor(np.log(TAU_S.get(name, 0.015))))
            for other, _ in partners:
                # The softplus of this is 1.
                self.strength[f"{other} {name}"] = nn.Parameter(torch.tensor(np.log(np.e - 1)))
        for kind, partners in INPUTS.items():
            self.bias[kind] = nn.Parameter(torch.tensor(0.0))
            self.log_tau[kind] = nn.Parameter(torch.tensor(np.log(0.015)))
            # Excitation and inhibition are balanced at first, and fall where they may.
            signs = np.array([sign for _, sign in partners])
            share = torch.tensor([1 / (7 * (signs == sign).sum()) for sign in signs])
            drawn = torch.rand((4, len(partners), 7), generator=generator)
            self.strength[kind] = nn.Parameter(
                torch.expm1((0.2 + 1.6 * drawn) * share[:, None]).log()
            )
        self.float()

    def kernels(self, kind):
        """Strengths (subtype, input, hexal) of T4 or T5, with their signs."""
        signs = torch.tensor([float(sign) for _, sign in INPUTS[kind]])
        return nn.functional.softplus(self.strength[kind]) * signs[:, None]

    def filtered(self, name, drive):
        """Potentials (S, T, ...) of drives, of which the first has stood for ever."""
        frames = torch.arange(drive.shape[1])
        since = (frames[:, None] - frames).float()
        rate = 1 / (RATE_HZ * self.log_tau[name].exp())
        kept = torch.where(since >= 0, torch.exp(-since.clamp(min=0) * rate), 0.0)
        weights = (1 - torch.exp(-rate)) * kept
        first = torch.exp(-(frames + 1) * rate)  # what is left of the time before
        weights = torch.cat([weights[:, :1] + first[:, None], weights[:, 1:]], dim=1)
        return torch.einsum("ut,st...->su...", weights, drive)

    def forward(self, light):
        """Rates of T4 and T5 over time, {kind: (S, T, 4, M)}, of light (S, T, M), of which the
        first frame has stood for ever."""
        rates = {}
        for name, partners in WIRING.items():
            drive = self.bias[name] + (light if name == "R" else 0)
            for other, sign in partners:
                strength = nn.functional.softplus(self.strength[f"{other} {name}"])
                drive = drive + sign * strength * rates[other]
            rates[name] = rate(self.filtered(name, drive))
        found = {}
        for kind, partners in INPUTS.items():
            inputs = torch.cat([rates[other] for other, _ in partners], dim=2)
            weights = torch.einsum("kih,mnh->imkn", self.kernels(kind), self.seven)
            drive = (inputs @ weights.flatten(2).flatten(0, 1)).unflatten(-1, (4, -1))
            found[kind] = rate(self.filtered(kind, self.bias[kind] + drive))
        return found

    def motion(self, rates):
        """The direction that subtypes tell together: (S, T, M, 2)."""
        sides = torch.tensor(np.array([unit(angle) for angle in SUBTYPES.values()])).float()
        return GAIN * torch.einsum("stkm,kd->stmd", sum(rates.values()), sides)


def learn(network, light, towards, inner, updates, log=print):
    """Adam on the mean motion of each stimulus; what was missed, at each update."""
    towards, inner = torch.as_tensor(towards).float(), torch.as_tensor(inner)
    adam = torch.optim.Adam(network.parameters(), 0.02)
    plan = torch.optim.lr_scheduler.OneCycleLR(adam, 0.03, total_steps=updates)
    generator, misses = torch.Generator().manual_seed(1), []
    for update in range(updates):
        some = torch.randperm(len(light), generator=generator)[:24]
        rates = network(light[some])
        told = network.motion(rates)[:, SETTLING:, inner].mean(dim=(1, 2))
        missed = (told - towards[some]).square().sum(1).mean()
        # Each subtype is to have so much to say in the mean, so that none falls silent for good.
        active = torch.cat([one.mean(dim=(0, 1, 3)) for one in rates.values()])
        adam.zero_grad()
        (missed + 100 * (active - ACTIVITY).square().sum()).backward()
        adam.step()
        plan.step()
        misses.append(missed.item())
        if update % 50 == 0:
            log(f"update {update:3}: missed by {missed.item():.3f}")
    return np.array(misses)


def tuning(network, light, inner):
    """Mean rates of stimuli, {kind: (S, 4)}."""
    with torch.no_grad():
        rates = network(light)
    return {
        kind: values[:, SETTLING:, :, torch.as_tensor(inner)].mean(dim=(1, 3)).numpy()
        for kind, values in rates.items()
    }


def selectivity(directions_deg, rates):
    """Direction selectivity |Σ r exp(iθ)| / Σ r, and the preferred direction, deg, of rates (S,
    ...) to directions (S,) that are evenly spread."""
    turned = np.exp(1j * np.radians(directions_deg))
    total = np.tensordot(turned, rates, 1)
    return np.abs(total) / np.maximum(rates.sum(0), 1e-12), np.degrees(np.angle(total))


def draw(path, network, misses, directions_deg, of_gratings, of_edges, seconds):
    """Of edges: {"ON": ..., "OFF": ...} as of gratings."""
    figure = plt.figure(figsize=(13, 7.4), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1, 1.25))
    colours = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
    upper, lower = left.subfigures(2, 1, height_ratios=(1, 1.9))
    panel = upper.subplots()
    panel.semilogy(misses, color="#0072b2", lw=1)
    panel.set(xlabel="update", ylabel="missed", title=f"Learning the direction: {seconds:.0f} s")
    panel.spines[["top", "right"]].set_visible(False)
    rows = lower.subplots(4, 5)
    lower.suptitle("Inputs of T4 (a to d): excitation red, inhibition blue", fontsize=10)
    angle = np.radians(30 + 60 * np.arange(6))
    x, y = np.r_[0, np.cos(angle)], np.r_[0, np.sin(angle)]
    kernels = network.kernels("T4").detach().numpy()
    for k, row in enumerate(rows):
        for i, one in enumerate(row):
            largest = np.abs(kernels).max()
            one.scatter(x, y, c=kernels[k, i], s=300, marker="h", cmap="RdBu_r", vmin=-largest,
                        vmax=largest, edgecolors="0.7", linewidths=0.5)  # fmt: skip
            one.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6), aspect="equal", xticks=[], yticks=[])
            one.axis("off")
            if k == 0:
                one.set_title(INPUTS["T4"][i][0], fontsize=9)
            if i == 0:
                one.text(-2.3, 0, "abcd"[k], fontsize=11, color=colours[k], va="center")
    polar = right.subplots(2, 3, subplot_kw={"projection": "polar"})
    closed = np.radians(np.r_[directions_deg, directions_deg[0]])
    shown = {"gratings": of_gratings, "ON edges": of_edges["ON"], "OFF edges": of_edges["OFF"]}
    for row, kind in zip(polar, INPUTS):
        top = max(rates[kind].max() for rates in shown.values())
        for one, (name, rates) in zip(row, shown.items()):
            for k, colour in enumerate(colours):
                values = rates[kind][:, k]
                one.plot(closed, np.r_[values, values[0]], color=colour, label=f"{kind}{'abcd'[k]}")
            one.set(
                ylim=(0, 1.05 * top), yticks=[top / 2, top], yticklabels=[], title=f"{kind}, {name}"
            )
            one.set_xticks(np.radians([0, 90, 180, 270]), ["right", "up", "left", "down"])
            one.tick_params(labelsize=8)
        below = row[1].legend(
            loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=4, frameon=False
        )
        below.set_in_layout(False)  # it may be wider than the panel
    right.suptitle("Mean rates to what was not shown while learning, by direction", fontsize=10)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("-o", "--output", default="t4t5.png", help="the figure")
    parser.add_argument("--updates", type=int, default=500, help="(default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="(default: %(default)s)")
    asked = parser.parse_args()
    torch.set_num_threads(1)  # small matrices
    eye, around, inner = column_lattice()
    eight, began = 45.0 * np.arange(8), time.perf_counter()
    shown = [
        gratings(eight, (20.0, 40.0), (0.0, 2.0, 5.0)),
        edges(eight, (40.0, 90.0), brightening=True),
        edges(eight, (40.0, 90.0), brightening=False),
    ]
    light = watch(eye, [one for stimuli, _ in shown for one in stimuli])
    towards = np.concatenate([vectors for _, vectors in shown])
    print(f"light {tuple(light.shape)}, [stimulus, frame, column], in "
          f"{time.perf_counter() - began:.0f} s")  # fmt: skip
    network = Network(around, asked.seed)
    began = time.perf_counter()
    misses = learn(network, light, towards, inner, asked.updates)
    seconds = time.perf_counter() - began
    # Others than those that were learned: directions, wavelengths, frequencies, speeds.
    twelve = 15.0 + 30.0 * np.arange(12)
    of_gratings = tuning(network, watch(eye, gratings(twelve, (30.0,), (3.0,))[0]), inner)
    of_edges = {
        name: tuning(network, watch(eye, edges(twelve, (60.0,), name == "ON")[0]), inner)
        for name in ("ON", "OFF")
    }
    for kind, edge in (("T4", "ON"), ("T5", "OFF")):
        for what, rates in (("gratings", of_gratings), (f"{edge} edges", of_edges[edge])):
            index, preferred = selectivity(twelve, rates[kind])
            print(f"{kind}, {what}: selectivity {np.round(index, 2)}, "
                  f"prefer {np.round(preferred)}°")  # fmt: skip
    draw(asked.output, network, misses, twelve, of_gratings, of_edges, seconds)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
