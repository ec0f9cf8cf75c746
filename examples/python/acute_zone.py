"""An eye learns where to look closer, by gradients, and meets the optimum of the theory.

A row of 100 ommatidia looks from 60° below to 60° above. Edges appear at elevations x of a known
density p(x), mostly near 0, as where an animal keeps the horizon. An ommatidium with the axis e and
a Gaussian of the standard deviation σ responds with Φ((e - x)/σ), plus noise of the deviation s.
How well can be told where an edge is? The Fisher information of x in all responses is

    J(x) = Σ (∂r_i/∂x)²/s²,

and the mean squared error is at least 1/J (Cramér and Rao). The loss is the mean of that over p. It
goes down by the gradients of responses that the rays themselves give (`Renderer.jacobian`), by how
far apart neighbours look and how wide each one sees. What a response changes by where an edge moves
is what it is to a thin bar, as responses are linear; so bars are rendered.

What to expect: neighbours Δφ apart with widths Δρ tell an edge by 1/J = c(Δρ/Δφ) s² Δφ², c the mean
over where between them the edge is. c is least, 1.529, at Δρ = 0.861 Δφ. With the density of axes
n = 1/Δφ, ∫ p c s²/n² is then least for ∫ n = N at

    n ∝ p^(1/3),    error² = c s² (∫ p^(1/3) dx)³/N²,

the power with which levels of a quantiser lie (Panter & Dite 1951, by the abstract of
Max 1960, Quantizing for minimum distortion).

python examples/python/acute_zone.py            60 steps, about a minute
python examples/python/acute_zone.py OUT.png    and a figure
"""

import sys

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation
from scipy.stats import norm

import omma

OMMATIDIA = 100
RIM_RAD = np.radians(60)
SPREAD_RAD = np.radians(6)  # of where edges mostly are
ANYWHERE = 0.1  # of edges
NOISE = 0.05  # of each response, where light and dark are 1 and 0
PRIOR = (NOISE / RIM_RAD) ** 2  # J s² of what is known without looking
SIGMA = 1 / np.sqrt(8 * np.log(2))  # of the full width at half maximum
BAR_RAD = np.radians(0.2)
# Bars from the lower to the upper rim, red, green and blue in turn, so that an ommatidium sees one
# of a colour at most: (K, 3), their middles.
LADDER_RAD = np.radians(5 / 3)
BARS_RAD = np.arange(-RIM_RAD + LADDER_RAD / 2, RIM_RAD, LADDER_RAD).reshape(-1, 3)
KNOTS = 9
START = 1.0  # Δρ/Δφ
RATE = 0.1  # of logarithms, a step


def density(x_rad: np.ndarray) -> np.ndarray:
    """p of edges, per rad."""
    mostly = norm(0, SPREAD_RAD)
    inside = 1 - 2 * mostly.cdf(-RIM_RAD)
    return (1 - ANYWHERE) * mostly.pdf(x_rad) / inside + ANYWHERE / (2 * RIM_RAD)


def error_of_a_lattice(ratio: float) -> float:
    """c: the mean of 1/J in s² Δφ² of a long row with Δρ = ratio Δφ."""
    between = (np.arange(200) + 0.5) / 200
    away = (between[:, None] - np.arange(-40, 41)) / (ratio * SIGMA)
    slopes = norm.pdf(away) / (ratio * SIGMA)
    return float(np.mean(1 / np.sum(slopes**2, axis=1)))


def theory(count: int = OMMATIDIA) -> dict:
    """Of the best row: Δρ/Δφ; x, rad; Δφ there, rad; root of the loss, rad."""
    best = minimize_scalar(error_of_a_lattice, bounds=(0.3, 3), method="bounded")
    x = np.linspace(-RIM_RAD, RIM_RAD, 20001)
    root = np.cbrt(density(x))
    whole = np.trapezoid(root, x)
    return {
        "ratio": best.x,
        "x_rad": x,
        "angle_rad": whole / (count * root),
        "error_rad": NOISE * np.sqrt(best.fun * whole**3) / count,
    }


def error_rad(elevation_rad: np.ndarray, width_rad: np.ndarray) -> float:
    """The root of the loss of any row, by the closed form of its responses."""
    x = np.linspace(-RIM_RAD, RIM_RAD, 6001)
    sigma = width_rad * SIGMA
    slopes = norm.pdf((elevation_rad - x[:, None]) / sigma) / sigma
    squared = NOISE**2 / (np.sum(slopes**2, axis=1) + PRIOR)
    return float(np.sqrt(np.trapezoid(density(x) * squared, x)))


class Row:
    """A row of ommatidia: ln Δφ and ln Δρ/Δφ at knots along it, straight in between."""

    def __init__(self, count: int):
        along = (np.arange(count) + 0.5) / count * (KNOTS - 1)
        self.basis = np.maximum(0, 1 - np.abs(along[:, None] - np.arange(KNOTS)))
        self.genes = np.concatenate([np.zeros(KNOTS), np.full(KNOTS, np.log(START))])

    def looks(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Elevations, Δφ and Δρ, rad; Δφ fill the field."""
        angle = np.exp(self.basis @ self.genes[:KNOTS])
        angle *= 2 * RIM_RAD / angle.sum()
        return (
            np.cumsum(angle) - angle / 2 - RIM_RAD,
            angle,
            angle * np.exp(self.basis @ self.genes[KNOTS:]),
        )

    def gradient(self, by_elevation: np.ndarray, by_width: np.ndarray) -> np.ndarray:
        """By genes, of what it is by elevations and Δρ: the chain rule of `looks`."""
        _, angle, width = self.looks()
        # A wider angle moves all that come after it, and half of itself.
        by_angle = np.cumsum(by_elevation[::-1])[::-1] - by_elevation / 2 + by_width * width / angle
        by_log = angle * (by_angle - np.sum(by_angle * angle) / (2 * RIM_RAD))
        return np.concatenate([self.basis.T @ by_log, self.basis.T @ (by_width * width)])

    def eye(self) -> omma.Eye:
        elevation, _, width = self.looks()
        axis = np.stack([0 * elevation, np.sin(elevation), -np.cos(elevation)], axis=1)
        return omma.Eye(np.zeros_like(axis), axis, width)


def ladder() -> omma.World:
    """Thin bright rings around the head, one above the other, on black."""
    rings = []
    for middle, color in zip(BARS_RAD.ravel(), np.tile(np.eye(3), (len(BARS_RAD), 1)), strict=True):
        low, high = 10 * np.tan(middle + BAR_RAD / 2 * np.array([-1, 1]))
        paint = color[None, None]
        rings.append(omma.scene.drum(10.0, high - low, paint, center_m=(0, (low + high) / 2, 0)))
    scene = omma.scene.merge_scenes(rings, background=omma.Background.constant((0, 0, 0)))
    # Of the backends this one gives the same bits on every processor.
    return omma.World(scene, backend="portable")


def loss_and_gradient(
    renderer: omma.Renderer, row: Row, offset_rad: np.ndarray, first_pose: int = 0
) -> tuple[float, np.ndarray]:
    """The loss, rad², where bars are moved up by these (P,), and its gradient by the genes."""
    elevation = row.looks()[0]
    # Twice each, by other rays, so that the product of both is no square of noise.
    down = np.tile(offset_rad, 2)
    poses = np.zeros((len(down), 4, 4))
    poses[:, :3, :3] = Rotation.from_rotvec(np.outer(-down, (1, 0, 0))).as_matrix()
    poses[:, 3, 3] = 1
    found = renderer.with_eye(row.eye()).jacobian(
        poses, by=("axis", "acceptance_angle_rad"), first_pose=first_pose
    )
    slopes = found.responses.reshape(2, len(offset_rad), -1, 3) / BAR_RAD
    # Each ommatidium tells of the bar of each colour that is nearest to it.
    x = BARS_RAD + offset_rad[:, None, None]  # (P, K, 3)
    nearest = np.argmin(np.abs(elevation[:, None, None] - x[:, None]), axis=2)  # (P, N, 3)
    which = np.arange(len(offset_rad))[:, None, None], nearest, np.arange(3)
    information = np.full(x.shape, PRIOR)
    np.add.at(information, which, slopes[0] * slopes[1])
    # Less than what is known without looking is noise of the rays.
    squared = NOISE**2 / np.maximum(information, PRIOR)
    share = density(x) * LADDER_RAD / len(offset_rad)
    by_information = -share * squared**2 / NOISE**2
    by_slope = by_information[which] * slopes[::-1]
    gradient = found.vjp(by_slope.reshape(found.responses.shape) / BAR_RAD)
    up = np.stack([0 * elevation, np.cos(elevation), np.sin(elevation)], axis=1)
    by_elevation = np.sum(gradient["axis"] * up, axis=1)
    by_genes = row.gradient(by_elevation, gradient["acceptance_angle_rad"])
    return float(np.sum(share * squared)), by_genes


def learn(
    count: int = OMMATIDIA, steps: int = 60, offsets: int = 32, rays: int = 128, seed: int = 1
) -> dict:
    """Descent by Adam (Kingma & Ba 2015, arXiv:1412.6980) with a rate that falls to 0: elevations
    and Δρ, rad, (steps + 1, count)."""
    random = np.random.default_rng(seed)
    row = Row(count)
    renderer = omma.Renderer(ladder(), row.eye(), omma.Fixed(rays))
    mean, square = np.zeros((2, 2 * KNOTS))
    history = [row.looks()]
    for step in range(steps):
        even = (np.arange(offsets) + random.random()) / offsets - 0.5
        _, gradient = loss_and_gradient(renderer, row, even * LADDER_RAD, 2 * offsets * step)
        mean += 0.1 * (gradient - mean)
        square += 0.02 * (gradient**2 - square)
        size = np.sqrt(square / (1 - 0.98 ** (step + 1)))
        rate = RATE * (1 - step / steps)
        row.genes = row.genes - rate * mean / (1 - 0.9 ** (step + 1)) / size
        history.append(row.looks())
    elevation, _, width = np.moveaxis(np.array(history), 1, 0)
    return {"elevation_rad": elevation, "width_rad": width}


def exponent(elevation_rad: np.ndarray) -> float:
    """Of the power of p that a row's density is: the slope of ln n by ln p."""
    angle = np.gradient(elevation_rad)
    return float(np.polyfit(np.log(density(elevation_rad)), -np.log(angle), 1)[0])


def draw(found: dict, out: str) -> None:
    import matplotlib.pyplot as plt

    from omma.base.figures import COLOURS, GREY, INK

    best = theory()
    elevation, width = (np.degrees(found[name]) for name in ("elevation_rad", "width_rad"))
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1)  # labels of one panel clear of the next
    left, middle, right = panels
    left.plot(elevation[:, ::3], color=COLOURS[0], lw=0.7)
    left.set(xlabel="step", ylabel="elevation of axes (°), every third", ylim=(-60, 60))
    x, angle = np.degrees(best["x_rad"]), np.degrees(best["angle_rad"])
    middle.plot(x, angle, color=INK, lw=1.2, label="Δφ of the theory, ~ p$^{-1/3}$")
    middle.plot(x, best["ratio"] * angle, color=INK, lw=1.2, ls="--", label="Δρ = 0.861 Δφ")
    last, learned = elevation[-1], np.gradient(elevation[-1])
    middle.plot(last, learned, "o", ms=3, color=COLOURS[0], label="Δφ, learned")
    middle.plot(last, width[-1], "s", ms=3, color=COLOURS[1], label="Δρ, learned")
    middle.set(xlabel="elevation (°)", ylabel="angle (°)", ylim=(0, 2.6))
    narrow = {"handlelength": 1.5, "columnspacing": 1.0}
    middle.legend(frameon=False, fontsize=8, ncols=2, loc="upper center", **narrow)
    rows = zip(found["elevation_rad"], found["width_rad"], strict=True)
    error = [error_rad(*row) for row in rows]
    right.plot(np.degrees(error), color=COLOURS[0], lw=1.6, label="of the eye")
    least = np.degrees(best["error_rad"])
    right.axhline(least, color=GREY, lw=1, ls="--", label="least, of the theory")
    right.set(xlabel="step", ylabel="error of an edge's elevation (°)", ylim=(0, None))
    right.legend(frameon=False, fontsize=8)
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(out, dpi=130)


def main() -> None:
    found = learn()
    best = theory()
    elevation, width = found["elevation_rad"], found["width_rad"]
    print("step   error of an edge's elevation (°)")
    for k in range(0, len(elevation), 10):
        print(f"{k:4} {np.degrees(error_rad(elevation[k], width[k])):12.4f}")
    print(f"least {np.degrees(best['error_rad']):11.4f}")
    angle = np.gradient(elevation[-1])
    print(f"density ~ p^{exponent(elevation[-1]):.3f}, theory p^0.333")
    print(f"Δρ/Δφ {np.median(width[-1] / angle):.3f}, theory {best['ratio']:.3f}")
    print("elevation (°)   Δφ (°)   theory")
    wanted = np.interp(elevation[-1], best["x_rad"], best["angle_rad"])
    for row in np.degrees(np.stack([elevation[-1], angle, wanted], axis=1))[2::5]:
        print(f"{row[0]:13.1f} {row[1]:8.2f} {row[2]:8.2f}")
    if len(sys.argv) > 1:
        draw(found, sys.argv[1])


if __name__ == "__main__":
    main()
