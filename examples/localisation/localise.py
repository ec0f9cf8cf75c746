"""How well do a bee's eyes say where a thing is? The experiment of CompoundRay's paper with Omma.

A black sphere hangs in a white room. An eye sees it from thousands of random places; a small
network learns to say from the responses alone where the eye was. The same is done for the eye as it
is and for the same eye made spherical, and the learning curves are drawn into one plot.

load -> render -> train -> plot: `main` at the end of this file is the way through; README.md beside
it says where everything comes from (Millward, Maddock, Mangan, eLife 2022, 73893) and what differs.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import math
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

# The matrices are small: one thread is as fast as several on an idle machine and, where others
# work beside it, ten times faster. It counts only before NumPy is there.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import matplotlib
import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

import omma

matplotlib.use("Agg")  # files only, no display needed
import matplotlib.pyplot as plt

BOX_MM = 50.0  # the eye is anywhere in a cube of this side around the sphere
TARGET_SCALE_MM = 14.5  # the network answers in this unit; about the spread of ±25 (14.43)
WHITE = 1.0  # the response of an ommatidium that sees nothing of the sphere
HIDDEN = (1000, 256)
BATCH = 64
LEARNING_RATE = 1e-3
TRAINING_FRACTION = 0.8
PART = 500  # views in one file: what is lost, at most, when a render is stopped

PUBLISHED = {  # the last of the paper's curves
    **{"AM_60185-real": 0.4136, "AM_60185-single": 0.4167, "AM_60185-split": 0.4372},
    **{"BT_77973-real": 0.4855, "BT_77973-single": 0.4871, "BT_77973-split": 0.5001},
}
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#000000")

Tick = Callable[[], object]


# Render ------------------------------------------------------------------------------------------


def positions_mm(part: int, seed: int) -> np.ndarray:
    """Where the eye is in the views of one file: (PART, 3), the same for every eye."""
    return np.random.default_rng([seed, part]).uniform(-BOX_MM / 2, BOX_MM / 2, (PART, 3))


def views_folder(out: Path, scene: Path, eye: Path, rays: int, sensitivity: str, seed: int) -> Path:
    """A folder for each setting, so that views of one are never taken for those of another."""
    content = hashlib.sha256(scene.read_bytes() + eye.read_bytes()).hexdigest()[:8]
    return out / "views" / f"{eye.stem}_{rays}rays_{sensitivity}_seed{seed}_{content}"


def render_views(
    scene: Path,
    eye: Path,
    folder: Path,
    frames: int,
    rays: int,
    sensitivity: str,
    seed: int,
    tick: Tick,
) -> None:
    """Write what the eye sees to ``folder``, PART views a file; files that are there are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    # The numbers of the eye file are millimetres, and so are the units of this scene.
    renderer = omma.Renderer(
        omma.load_scene(scene),
        omma.load_eye(eye, unit="m"),
        omma.Fixed(rays),
        seed=seed,
        angular_sensitivity=sensitivity,
        noise="new_every_frame",
    )
    for part in range(math.ceil(frames / PART)):
        file = folder / f"{part:05}.npz"
        if not file.exists():
            poses = np.tile(np.eye(4), (PART, 1, 1))  # never turned, as in the paper
            poses[:, :3, 3] = positions_mm(part, seed)
            responses = renderer.render(poses, first_pose=part * PART)
            unfinished = folder / f".{part:05}.npz"
            red = responses[..., 0]  # the scene is black and white: one channel says it all
            np.savez_compressed(unfinished, responses=red, position_mm=poses[:, :3, 3])
            unfinished.replace(file)
        tick()


# Views as the network gets them -------------------------------------------------------------------


@dataclass
class Views:
    """Views, normalised: ommatidia that see nothing of the sphere are all at ``white``, the others,
    a few dozen of thousands, at ``white + dark``. Those of view i are ``start[i]:start[i + 1]``.
    """

    ommatidia: int
    start: np.ndarray  # (views + 1,)
    which: np.ndarray  # ommatidia that see some of the sphere, view after view
    dark: np.ndarray  # how much darker than white they are, float32
    white: float
    target: np.ndarray  # (views, 3), float32, position / TARGET_SCALE_MM
    training: int  # the first views are for training, the others for validation

    def of(self, view: int) -> tuple[np.ndarray, np.ndarray]:
        part = slice(self.start[view], self.start[view + 1])
        return self.which[part], self.dark[part]

    def dense(self, views: np.ndarray) -> np.ndarray:
        """Whole responses, normalised: (views, ommatidia)."""
        full = np.full((len(views), self.ommatidia), self.white, np.float32)
        for row, view in enumerate(views):
            which, dark = self.of(view)
            full[row, which] += dark
        return full


def load_views(folder: Path, frames: int) -> Views:
    """Read ``frames`` views and normalise them by mean and standard deviation of all responses of
    the training views together.
    """
    counts, which, dark, target = [], [], [], []
    for part in range(math.ceil(frames / PART)):
        with np.load(folder / f"{part:05}.npz") as file:
            responses = file["responses"][: frames - part * PART]
            target.append(file["position_mm"][: frames - part * PART] / TARGET_SCALE_MM)
        view, ommatidium = np.nonzero(responses != WHITE)
        counts.append(np.bincount(view, minlength=len(responses)))
        which.append(ommatidium.astype(np.int32))
        dark.append(responses[view, ommatidium].astype(np.float64) - WHITE)
    ommatidia = responses.shape[1]
    start = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
    below = np.concatenate(dark)
    training = int(frames * TRAINING_FRACTION)
    seen, total = below[: start[training]], training * ommatidia
    mean_below = seen.sum() / total
    deviation = math.sqrt((seen**2).sum() / total - mean_below**2)
    return Views(
        ommatidia=ommatidia,
        start=start,
        which=np.concatenate(which),
        dark=(below / deviation).astype(np.float32),
        white=float(-mean_below / deviation),
        target=np.concatenate(target).astype(np.float32),
        training=training,
    )


# Train -------------------------------------------------------------------------------------------


class Network:
    """N -> 1000 -> 256 -> 3 with ReLU; plain gradient descent on the mean absolute error.

    All ommatidia but a few are at ``white`` in any one view. So the N x 1000 weights of the first
    layer are kept as V + 1 u, and ``base`` is what a wholly white view would give: a view then
    costs as many rows of V as ommatidia see the sphere, not N. It is the dense network written in
    another way: its outputs and its steps are the same but for rounding.
    """

    def __init__(self, views: Views, seed: int) -> None:
        rng = np.random.default_rng(seed)

        def layer(inputs: int, outputs: int) -> tuple[np.ndarray, np.ndarray]:
            bound = inputs**-0.5  # as PyTorch's nn.Linear starts
            weights = rng.uniform(-bound, bound, (inputs, outputs))
            return weights.astype(np.float32), rng.uniform(-bound, bound, outputs).astype("f4")

        self.views = views
        self.v, bias = layer(views.ommatidia, HIDDEN[0])
        self.u = np.zeros_like(bias)
        self.base = np.float32(views.white) * self.v.sum(axis=0) + bias
        self.w2, self.b2 = layer(*HIDDEN)
        self.w3, self.b3 = layer(HIDDEN[1], 3)

    def forward(self, batch: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Both hidden layers, the answers (batch, 3), and the summed darkness of each view."""
        first = np.empty((len(batch), HIDDEN[0]), np.float32)
        total = np.empty((len(batch), 1), np.float32)
        for row, view in enumerate(batch):
            which, dark = self.views.of(view)
            first[row] = dark @ self.v[which]
            total[row] = dark.sum()
        first += total * self.u + self.base
        np.maximum(first, 0, out=first)
        second = np.maximum(first @ self.w2 + self.b2, 0)
        return first, second, second @ self.w3 + self.b3, total

    def step(self, batch: np.ndarray) -> float:
        """One step down the gradient on a batch of views; returns their loss before it."""
        first, second, answer, total = self.forward(batch)
        error = answer - self.views.target[batch]
        # Gradient of the mean absolute error, times the learning rate from here on.
        d3 = np.float32(LEARNING_RATE / error.size) * np.sign(error)
        d2 = (d3 @ self.w3.T) * (second > 0)
        d1 = (d2 @ self.w2.T) * (first > 0)
        self.w3 -= second.T @ d3
        self.b3 -= d3.sum(axis=0)
        self.w2 -= first.T @ d2
        self.b2 -= d2.sum(axis=0)
        for row, view in enumerate(batch):
            which, dark = self.views.of(view)
            if len(which):
                self.v[which] -= np.outer(dark, d1[row])
        # With weights W = V + 1 u and base = white (sum of W over ommatidia) + bias: what the
        # gradients of W, dark·d1 + white 1·d1, and of the bias, d1, do to u and base.
        white, summed = np.float32(self.views.white), d1.sum(axis=0)
        self.u -= white * summed
        self.base -= white * (total.T @ d1)[0] + (white**2 * self.views.ommatidia + 1) * summed
        return float(np.abs(error).mean())

    def loss(self, views: range) -> float:
        """Mean absolute error over views and coordinates, in units of TARGET_SCALE_MM."""
        total = 0.0
        for i in range(0, len(views), 1024):
            batch = np.asarray(views[i : i + 1024])
            total += float(np.abs(self.forward(batch)[2] - self.views.target[batch]).sum())
        return total / (3 * len(views))


def train(views: Views, epochs: int, seed: int, tick: Tick) -> list[tuple[float, float]]:
    """Loss in training and in validation after each epoch."""
    network = Network(views, seed)
    rng = np.random.default_rng([seed, 1])
    curve = []
    for _ in range(epochs):
        order = rng.permutation(views.training)
        batches = [order[i : i + BATCH] for i in range(0, len(order), BATCH)]
        losses = [network.step(batch) for batch in batches]
        validation = range(views.training, len(views.target))
        curve.append((float(np.mean(losses)), network.loss(validation)))
        tick()
    return curve


def lowest_loss(views: Views) -> tuple[float, float]:
    """Share of validation views in which the eye sees the sphere, and the loss of one who answers
    rightly then and, in the other views, which are all alike, with the best one answer.
    """
    seen = np.diff(views.start)[views.training :] > 0
    unseen = views.target[views.training :][~seen]
    if len(unseen) == 0:
        return 1.0, 0.0
    guess = np.abs(unseen - np.median(unseen, axis=0)).mean()
    return float(seen.mean()), float(guess * (1 - seen.mean()))


# Plot --------------------------------------------------------------------------------------------

# Of each eye, for each draw of places and each network, (training, validation) loss after each
# epoch.
Curves = dict[str, list[list[list[tuple[float, float]]]]]


def save_curves(file: Path, curves: Curves) -> None:
    """All curves as a table: eye, draw, network, epoch, training_l1, validation_l1."""
    with file.open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["eye", "draw", "network", "epoch", "training_l1", "validation_l1"])
        for eye, draws in curves.items():
            for draw, networks in enumerate(draws):
                for number, curve in enumerate(networks):
                    for epoch, losses in enumerate(curve, start=1):
                        table.writerow([eye, draw, number, epoch, *(f"{x:.6f}" for x in losses)])


def plot_curves(file: Path, curves: Curves, title: str) -> None:
    """Validation loss against epochs, a colour for each eye; dotted where the paper's ended."""
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for (eye, draws), colour in zip(curves.items(), COLOURS * len(curves)):
        networks = [curve for draw in draws for curve in draw]
        validation = np.array(networks)[:, :, 1]
        epochs = np.arange(1, validation.shape[1] + 1)
        mean = validation.mean(axis=0)
        label = f"{eye}: {mean[-1]:.4f}"
        if len(networks) > 1:
            low, high = validation.min(axis=0), validation.max(axis=0)
            axes.fill_between(epochs, low, high, color=colour, alpha=0.2, linewidth=0)
        if eye in PUBLISHED:
            label += f" (published, dotted: {PUBLISHED[eye]:.4f})"
            axes.axhline(PUBLISHED[eye], color=colour, linestyle=":", linewidth=1)
        axes.plot(epochs, mean, color=colour, label=label)
    axes.set(xlabel="epoch", ylabel=f"validation L1 (units of {TARGET_SCALE_MM} mm)", title=title)
    in_mm = (lambda loss: loss * TARGET_SCALE_MM, lambda mm: mm / TARGET_SCALE_MM)
    axes.secondary_yaxis("right", functions=in_mm).set_ylabel("mean error per coordinate (mm)")
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(file, dpi=150)
    plt.close(figure)


# Compare -----------------------------------------------------------------------------------------


@dataclass
class Comparison:
    """What several draws of places say about an eye, beside the first of them all."""

    final: float  # mean over draws
    final_scatter: float  # standard deviation over draws, nan for one draw
    above: float  # final loss less the lowest possible one for the same places, mean
    less_first: float  # ``above`` less that of the first eye, at the same places, mean
    less_first_error: float  # its standard error
    anew: float  # standard deviation of that difference, had each eye places of its own


def compare(finals: dict[str, np.ndarray], lowest: dict[str, np.ndarray]) -> dict[str, Comparison]:
    """From the final losses (draws, networks) and the lowest possible ones (draws,) of each eye."""
    above = {eye: final.mean(axis=1) - lowest[eye] for eye, final in finals.items()}
    first = next(iter(above.values()))

    def scatter(values: np.ndarray) -> float:
        return float(np.std(values, ddof=1)) if len(values) > 1 else math.nan

    result = {}
    for eye, final in finals.items():
        apart = above[eye] - first
        result[eye] = Comparison(
            final=float(final.mean()),
            final_scatter=scatter(final.mean(axis=1)),
            above=float(above[eye].mean()),
            less_first=float(apart.mean()),
            less_first_error=scatter(apart) / math.sqrt(len(apart)),
            anew=math.hypot(scatter(above[eye]), scatter(first)),
        )
    return result


# The way through ---------------------------------------------------------------------------------

EXAMPLES = """examples:
  A first look, some minutes:
    python localise.py --scene env_2.gltf AM_60185-{real,single,split}.eye -o out
  The paper's size (the views are kept, and more are added to those that are there):
    python localise.py --scene env_2.gltf AM_60185-{real,single,split}.eye -o out --frames 100000
  Is a difference more than luck? Five draws of places, and of each another network:
    python localise.py --scene env_2.gltf BT_77973-{real,single}.eye -o out --draws 5
"""


def arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("eyes", nargs="+", type=Path, metavar="EYE", help=".eye files to compare")
    parser.add_argument("--scene", type=Path, required=True, help="the room with the sphere, glTF")
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for views and plot")
    parser.add_argument("--frames", type=int, default=10_000, help="views per eye (10000)")
    parser.add_argument("--rays", type=int, default=16, help="rays per ommatidium (16)")
    parser.add_argument("--epochs", type=int, default=100, help="times over the training set (100)")
    parser.add_argument("--draws", type=int, default=1, help="times that places are drawn anew (1)")
    parser.add_argument("--networks", type=int, default=1, help="networks per eye and draw (1)")
    parser.add_argument("--seed", type=int, default=0, help="of places and networks (0)")
    parser.add_argument(
        "--angular-sensitivity",
        "--kernel",  # its old name
        default="gaussian",
        choices=["gaussian", "compoundray"],
        help="(gaussian)",
    )
    given = parser.parse_args(argv)
    for name in ("frames", "rays", "epochs", "draws", "networks"):
        if getattr(given, name) < (10 if name == "frames" else 1):
            parser.error(f"--{name}: {getattr(given, name)} is too few")
    for file in (given.scene, *given.eyes):
        if not file.is_file():
            parser.error(f"{file}: no such file")
    return given


@contextmanager
def bar(what: str, steps: int) -> Iterator[Tick]:
    columns = (TextColumn("{task.description:32}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task(what, total=steps)
        yield lambda: progress.advance(task)


def main(argv: list[str] | None = None) -> Curves:
    given = arguments(argv)
    curves: Curves = {eye.stem: [] for eye in given.eyes}
    bounds: dict[str, list[tuple[float, float]]] = {eye.stem: [] for eye in given.eyes}
    title = (
        f"{given.frames:,} views, {given.rays} rays per ommatidium, "
        f"{given.angular_sensitivity} sensitivity"
    )
    for draw in range(given.draws):
        setting = (given.rays, given.angular_sensitivity, given.seed + draw)
        for eye in given.eyes:
            what = eye.stem if given.draws == 1 else f"{eye.stem}, draw {draw}"
            folder = views_folder(given.out, given.scene, eye, *setting)
            with bar(f"{what}: rendering", math.ceil(given.frames / PART)) as tick:
                render_views(given.scene, eye, folder, given.frames, *setting, tick)
            views = load_views(folder, given.frames)
            first = given.seed + draw * given.networks
            with bar(f"{what}: training", given.epochs * given.networks) as tick:
                curves[eye.stem].append(
                    [
                        train(views, given.epochs, first + number, tick)
                        for number in range(given.networks)
                    ]
                )
            bounds[eye.stem].append(lowest_loss(views))
            done = {name: draws for name, draws in curves.items() if draws}
            save_curves(given.out / "curves.csv", done)
            plot_curves(given.out / "curves.png", done, title)
    print_results(curves, bounds)
    Console().print(f"Curves: {given.out / 'curves.png'}, {given.out / 'curves.csv'}")
    return curves


def print_results(curves: Curves, bounds: dict[str, list[tuple[float, float]]]) -> None:
    """A line for each eye and draw, and where there are several draws what they say together."""
    table = Table("eye", "draw", "final L1", "published", "sees the sphere in", "lowest L1")
    for eye, draws in curves.items():
        for draw, networks in enumerate(draws):
            final = ", ".join(f"{curve[-1][1]:.4f}" for curve in networks)
            published = f"{PUBLISHED[eye]:.4f}" if eye in PUBLISHED else ""
            seen, lowest = bounds[eye][draw]
            table.add_row(eye, str(draw), final, published, f"{seen:.1%}", f"{lowest:.4f}")
    Console().print(table)
    if len(next(iter(curves.values()))) == 1:
        return
    finals = {
        eye: np.array([[curve[-1][1] for curve in networks] for networks in draws])
        for eye, draws in curves.items()
    }
    compared = compare(finals, {eye: np.array(b)[:, 1] for eye, b in bounds.items()})
    first = next(iter(compared))
    table = Table("eye", "final L1 ± scatter", "above the lowest", f"less {first}", "drawn anew")
    for eye, c in compared.items():
        less = "" if eye == first else f"{c.less_first:+.4f} ± {c.less_first_error:.4f}"
        anew = "" if eye == first else f"± {c.anew:.4f}"
        table.add_row(eye, f"{c.final:.4f} ± {c.final_scatter:.4f}", f"{c.above:.4f}", less, anew)
    Console().print(table)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("Stopped. Views rendered so far are kept and will be used the next time.")
    except omma.Error as error:
        sys.exit(f"error: {error}")
