"""An eye evolves for the finest stripes that it can make out, and meets Snyder's optimum.

On a head with an eye of a given radius R, how wide should facets be, and how far apart? Wide facets
see sharply, but few of them fit. Genes are the facet diameter D and the interommatidial angle Δφ;
facets cannot overlap, D ≤ R Δφ. Each generation is rendered in one call (`omma.Population`) among
vertical stripes of 24 widths. An eye makes stripes of frequency ν out (Snyder 1977, J Comp Physiol
116:161) as far as

- its lattice samples them, ν ≤ 1/(√3 Δφ) for rows of hexagons,
- what an ommatidium sees of them stands out of photon noise: m M(ν) √N ≥ 1, with the contrast m,
  the modulation M that is rendered, and N photons.

A lens that diffraction alone limits catches N = L λ² t photons of the radiance L in a time t
whatever its diameter: its field shrinks as its area grows. So the optimum has D = R Δφ and both
conditions at once, which gives the eye parameter p = D Δφ from M of a lens, with x = ν λ/D:

    M(x) = (2/π) (arccos x - x √(1 - x²)) = 1/(m √N),    p = λ/(√3 x)

In bright light p falls to λ/√3 = 0.58 λ, Snyder's diffraction limit; in dim light it grows.

python examples/python/evolve_eye.py            five lights, 25 generations, half a minute
python examples/python/evolve_eye.py OUT.png    and a figure
"""

import sys

import numpy as np
from scipy.optimize import brentq

import omma

WAVELENGTH_NM = 500.0
WAVELENGTH_M = WAVELENGTH_NM * 1e-9
RADIUS_M = 1e-3  # of the eye
CONTRAST = 0.5
TIME_S = 0.02
PHOTONS = (10.0, 30.0, 100.0, 1e3, 1e4)  # N: of L = N/(λ² t), 2e15 to 2e18 m⁻² s⁻¹ sr⁻¹
STRIPES = np.unique(np.round(np.geomspace(35, 300, 24)).astype(int))  # cycles all around
EYES, PARENTS = 24, 6  # of each light


def striped_drums(columns: int = 16384) -> tuple[omma.World, np.ndarray]:
    """Drums with three patterns of stripes each, one in each of red, green and blue, and poses
    (P, 4, 4) in the middle of each."""
    azimuth = ((np.arange(columns) + 0.5) / columns - 0.5) * 2 * np.pi
    waves = [turn(k * azimuth) for k in STRIPES for turn in (np.cos, np.sin)]
    drums, poses = [], []
    for k, three in enumerate(np.reshape(waves, (-1, 3, columns))):
        middle = (30.0 * k, 0.0, 0.0)
        wall = 0.5 + 0.5 * three.T[None]
        drums.append(omma.scene.drum(10.0, 100.0, wall, center_m=middle))
        poses.append(np.eye(4))
        poses[-1][:3, 3] = middle
    # What is above and below is as bright as stripes are on average.
    grey = omma.Background.constant((0.5, 0.5, 0.5))
    scene = omma.scene.merge_scenes(drums, background=grey)
    # Of the backends this one gives the same bits, and lineages, on every processor.
    return omma.World(scene, backend="portable"), np.array(poses)


def modulation(population: omma.Population, poses: np.ndarray) -> np.ndarray:
    """How much of the stripes' amplitude each eye keeps, by stripes: (E, K)."""
    alike = np.repeat(poses[:, None], len(population.sizes), axis=1)
    seen = 2 * np.array(population.render(alike)) - 1  # (E, P, N, 3)
    # Channels of one drum after those of another: cosine and sine of each pattern.
    waves = np.moveaxis(seen, 2, 1).reshape(len(seen), seen.shape[2], -1, 2)
    # An ommatidium that looks by φ to the right of the middle sees M cos kφ and M sin kφ.
    axis = population.eye.axis.reshape(len(seen), -1, 3)
    phase = STRIPES * np.arctan2(axis[..., 0], -axis[..., 2])[..., None]
    kept = waves[..., 0] * np.cos(phase) + waves[..., 1] * np.sin(phase)
    return kept.mean(axis=1)


def make_eye(facet_m: float, angle_rad: float) -> omma.Eye:
    """An ommatidium that looks ahead and its six neighbours, its lens at the diffraction limit."""
    turn = np.radians(np.arange(0, 360, 60) + 30)
    right = np.append(0, np.sin(turn)) * angle_rad
    up = np.append(0, np.cos(turn)) * angle_rad
    axis = np.stack([np.sin(right) * np.cos(up), np.sin(up), -np.cos(right) * np.cos(up)], axis=1)
    eye = omma.Eye(RADIUS_M * axis, axis, 0.0, facet_diameter_m=np.full(7, facet_m))
    return eye.replace(acceptance=[omma.Acceptance.airy(facet_m, WAVELENGTH_NM)] * 7)


def photons(eye: omma.Eye, radiance: float) -> float:
    """What its first ommatidium catches in `TIME_S`, of photons m⁻² s⁻¹ sr⁻¹."""
    area = np.pi / 4 * float(eye.facet_diameter_m[0]) ** 2
    field = float(omma.receptors.solid_angle_sr(eye.acceptance(0)))
    return radiance * area * field * TIME_S


def finest(modulation: np.ndarray, angle_rad: np.ndarray, caught: np.ndarray) -> np.ndarray:
    """The finest stripes that eyes make out, cycles per rad: (E,) of modulations (E, K)."""
    frequency = STRIPES / (2 * np.pi)
    least = 1 / (CONTRAST * np.sqrt(caught))
    # Near the end of what a lens passes M is a power 3/2, so that M^(2/3) is nearly straight.
    by_contrast = np.empty(len(caught))
    for k, (kept, threshold) in enumerate(zip(modulation, least, strict=True)):
        falling = np.maximum(np.minimum.accumulate(kept), 0)[::-1] ** (2 / 3)
        by_contrast[k] = np.interp(threshold ** (2 / 3), falling, frequency[::-1])
        if threshold > kept.max():
            by_contrast[k] = 0.0
    return np.minimum(by_contrast, 1 / (np.sqrt(3) * angle_rad))


def optimum(caught: float) -> float:
    """p = D Δφ in wavelengths, of the closed form."""

    def excess(x: float) -> float:
        kept = 2 / np.pi * (np.arccos(x) - x * np.sqrt(1 - x * x))
        return float(kept - 1 / (CONTRAST * np.sqrt(caught)))

    return float(1 / (np.sqrt(3) * brentq(excess, 0, 1)))


def evolve(levels=PHOTONS, generations: int = 25, seed: int = 1, rays: int = 512) -> dict:
    """Lineages in each light, apart from each other: D, m, Δφ, rad, and the finest stripes, cycles
    per rad, of the best, (generation, light)."""
    random = np.random.default_rng(seed)
    world, poses = striped_drums()
    population = None
    radiance = np.repeat(levels, EYES) / (WAVELENGTH_M**2 * TIME_S)
    # Genes are logarithms: of Δφ, and of the share of the room R Δφ that a facet takes.
    angle = np.log(random.uniform(np.radians(1.2), np.radians(5), len(radiance)))
    share = np.log(random.uniform(0.3, 1.0, len(radiance)))
    found = {"facet_m": [], "angle_rad": [], "finest": []}
    for generation in range(generations):
        share = np.minimum(share, 0.0)
        facet_m = RADIUS_M * np.exp(angle + share)
        eyes = [make_eye(*one) for one in zip(facet_m, np.exp(angle), strict=True)]
        if population is None:
            population = omma.Population(world, eyes, omma.Fixed(rays), footprints=False)
        population = population.with_eyes(eyes)
        caught = np.array([photons(*one) for one in zip(eyes, radiance, strict=True)])
        fitness = finest(modulation(population, poses), np.exp(angle), caught)
        best = []
        step = 0.25 * 0.85**generation
        for first in range(0, len(radiance), EYES):
            order = first + np.argsort(-fitness[first : first + EYES])[:PARENTS]
            best.append(order[0])
            # Children of two parents each, gene by gene, and what mutates; the best live on.
            children = slice(first + 1, first + EYES)
            parents = random.choice(order, (2, 2, EYES - 1))
            genes = []
            for gene, (mother, father) in zip((angle, share), parents, strict=True):
                mixed = (gene[mother] + gene[father]) / 2
                genes.append(mixed + step * random.standard_normal(EYES - 1))
            champion = angle[order[0]], share[order[0]]
            found["finest"].append(fitness[order[0]])
            angle[children], share[children] = genes
            angle[first], share[first] = champion
        found["facet_m"].append(RADIUS_M * np.exp(angle + share)[::EYES])
        found["angle_rad"].append(np.exp(angle)[::EYES])
    return {
        "photons": np.array(levels),
        "facet_m": np.array(found["facet_m"]),
        "angle_rad": np.array(found["angle_rad"]),
        "finest": np.reshape(found["finest"], (generations, len(levels))),
    }


def draw(found: dict, out: str) -> None:
    import matplotlib.pyplot as plt

    from omma.base.figures import COLOURS, GREY, INK

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
    parameter = found["facet_m"] * found["angle_rad"] / WAVELENGTH_M
    levels = np.geomspace(7, 1e6, 200)
    left.plot(levels, [optimum(n) for n in levels], color=INK, lw=1.2, label="closed form")
    left.plot(found["photons"], parameter[-1], "o", color=COLOURS[1], label="evolved")
    limit = 1 / np.sqrt(3)
    left.axhline(limit, color=GREY, lw=1, ls="--", label="diffraction limit, λ/√3")
    left.set(
        xscale="log", ylim=(0, 2.2), xlabel="photons in 20 ms", ylabel="p = D Δφ (wavelengths)"
    )
    left.legend(frameon=False, fontsize=8.5)
    for k, caught in enumerate(found["photons"]):
        # Of p = R Δφ² and ν = 1/(√3 Δφ).
        best = np.sqrt(RADIUS_M / (3 * optimum(caught) * WAVELENGTH_M))
        label = f"{caught:,.0f}"
        right.plot(found["finest"][:, k] / best, color=COLOURS[k], lw=1.6, label=label)
    right.axhline(1, color=GREY, lw=1, ls="--")
    right.set(xlabel="generation", ylabel="finest stripes, of the finest possible")
    right.legend(frameon=False, fontsize=8.5, title="photons", title_fontsize=8.5)
    for panel in (left, right):
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(out, dpi=130)


def main() -> None:
    found = evolve()
    print("photons     D (µm)   Δφ (°)   D/(R Δφ)   p = D Δφ (λ)   closed form")
    for caught, facet_m, angle in zip(
        found["photons"], found["facet_m"][-1], found["angle_rad"][-1], strict=True
    ):
        print(
            f"{caught:9,.0f} {facet_m * 1e6:8.1f} {np.degrees(angle):8.2f} "
            f"{facet_m / RADIUS_M / angle:10.3f} {facet_m * angle / WAVELENGTH_M:14.3f} "
            f"{optimum(caught):13.3f}"
        )
    if len(sys.argv) > 1:
        draw(found, sys.argv[1])


if __name__ == "__main__":
    main()
