"""Light of a sun in water of endless depth, photon by photon: a slow reference for
`omma.light.under_water`, which follows one scattering. All scatterings, no polarisation."""

import numpy as np

ANGLES = np.concatenate([[0], np.geomspace(1e-5, np.pi, 4000)])


def _angles_of(phase):
    """Angles by the share of light that is turned by less."""
    value = phase(ANGLES) * np.sin(ANGLES)
    below = np.concatenate([[0], np.cumsum((value[1:] + value[:-1]) / 2 * np.diff(ANGLES))])
    return below / below[-1]


def _turn(along, by, random):
    """Directions (N, 3) turned by angles (N,) to any side."""
    helper = np.where(np.abs(along[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    one = np.cross(along, helper)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    other = np.cross(along, one)
    about = random.uniform(0, 2 * np.pi, len(along))[:, None]
    side = np.cos(about) * one + np.sin(about) * other
    return np.cos(by)[:, None] * along + np.sin(by)[:, None] * side


def light_at(depth_m, sine_water, absorption, scatterings, phases, index, photons, seed=0):
    """Of a sun whose light goes towards +X under the surface, with irradiance 1 on level just below
    it: downward irradiance at the depth, and level radiance there, within 5° of level and 45° of
    facing the sun and of facing away: three means, and their standard errors.

    scatterings, phases: coefficients, m⁻¹, and phase functions of what there is.
    """
    random = np.random.default_rng(seed)
    total = absorption + sum(scatterings)
    shares = [_angles_of(phase) for phase in phases]
    half = 0.05 * depth_m
    bin_sr = 2 * np.sin(np.radians(5)) * np.pi / 2
    tally = np.zeros((16, 3))
    start = np.array([sine_water, -np.sqrt(1 - sine_water**2), 0.0])
    along = np.tile(start, (photons, 1))
    depth, weight = np.zeros(photons), np.ones(photons)
    batch = np.arange(photons) * 16 // photons
    while len(depth):
        step = random.exponential(1 / total, len(depth))
        end = depth - step * along[:, 1]
        # Those that come to the surface are reflected there in part, by weight.
        out = end < 0
        step = np.where(out, depth / np.maximum(along[:, 1], 1e-12), step)
        end = np.maximum(end, 0)
        down = (depth < depth_m) & (end >= depth_m)
        tally[:, 0] += np.bincount(batch, weight * down, 16)
        low, high = np.minimum(depth, end), np.maximum(depth, end)
        inside = np.clip(
            np.minimum(high, depth_m + half) - np.maximum(low, depth_m - half), 0, None
        )
        within = np.where(high > low, step * inside / np.maximum(high - low, 1e-12), 0.0)
        level = np.abs(along[:, 1]) < np.sin(np.radians(5))
        for k, side in ((1, along[:, 0]), (2, -along[:, 0])):
            ahead = level & (side > np.sqrt(0.5) * np.hypot(along[:, 0], along[:, 2]))
            tally[:, k] += np.bincount(batch, weight * within * ahead, 16) / (bin_sr * 2 * half)
        cos = np.abs(along[:, 1])
        sine = index * np.sqrt(1 - cos**2)
        cos_air = np.sqrt(np.maximum(1 - sine**2, 0))
        across = ((cos_air - index * cos) / (cos_air + index * cos)) ** 2
        flat = ((index * cos_air - cos) / (index * cos_air + cos)) ** 2
        weight = weight * np.where(out, np.where(sine < 1, (across + flat) / 2, 1.0), 1.0)
        along = np.where(out[:, None], along * (1, -1, 1), along)
        hit = ~out
        weight = np.where(hit, weight * sum(scatterings) / total, weight)
        which = random.uniform(0, sum(scatterings), len(depth)) < scatterings[0]
        drawn = random.uniform(size=len(depth))
        by = np.where(which, *(np.interp(drawn, one, ANGLES) for one in shares))
        along = np.where(hit[:, None], _turn(along, by, random), along)
        depth = end
        # Russian roulette.
        survives = random.uniform(size=len(depth)) < np.minimum(weight / 0.05, 1)
        weight = np.maximum(weight, 0.05)
        keep = survives & (depth < 4 * depth_m + 5 / absorption)
        along, depth, weight, batch = along[keep], depth[keep], weight[keep], batch[keep]
    found = tally * 16 / photons
    return found.mean(axis=0), found.std(axis=0, ddof=1) / 4
