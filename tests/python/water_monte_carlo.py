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


def _mirrored(cos_water, index):
    """The share of light from below that a level surface throws back."""
    sine = index * np.sqrt(1 - cos_water**2)
    cos_air = np.sqrt(np.maximum(1 - sine**2, 0))
    across = ((cos_air - index * cos_water) / (cos_air + index * cos_water)) ** 2
    along = ((index * cos_air - cos_water) / (index * cos_air + cos_water)) ** 2
    return np.where(sine < 1, (across + along) / 2, 1.0)


def light_leaving(
    absorption, scatterings, phases, index, photons, *, sun_deg=None, depth_m=np.inf, albedo=0.0
):
    """Of water below a level surface that the sun at an elevation lights, or without one a sky that
    is the same all over: what goes up over what goes down just below the surface; what comes out
    over what falls on it; and pi times the radiance within 15° of the zenith over that. Three
    means, and their standard errors.

    albedo: of a matt bottom at the depth. The rest as of `light_at`.
    """
    random = np.random.default_rng(0)
    total, scattering = absorption + sum(scatterings), sum(scatterings)
    shares = [_angles_of(phase) for phase in phases]
    batch = np.arange(photons) * 16 // photons
    cos_air = np.sqrt(random.uniform(size=photons))
    if sun_deg is not None:
        cos_air[:] = np.sin(np.radians(sun_deg))
    sine = np.sqrt(1 - cos_air**2) / index
    along = np.stack([sine, -np.sqrt(1 - sine**2), np.zeros(photons)], axis=1)
    weight = 1 - _mirrored(-along[:, 1], index)
    depth = np.zeros(photons)
    near = np.sqrt(1 - (np.sin(np.radians(15)) / index) ** 2)
    tally = np.zeros((4, 16))  # down, up, out, out about the zenith
    tally[0] += np.bincount(batch, weight, 16)
    while len(depth):
        end = depth - random.exponential(1 / total, len(depth)) * along[:, 1]
        out, ground = end < 0, end > depth_m
        hit = ~out & ~ground
        depth = np.clip(end, 0, depth_m)
        back = np.where(out, _mirrored(np.abs(along[:, 1]), index), 0.0)
        tally[0] += np.bincount(batch, weight * back, 16)
        tally[1] += np.bincount(batch, weight * out, 16)
        tally[2] += np.bincount(batch, weight * out * (1 - back), 16)
        tally[3] += np.bincount(batch, weight * out * (along[:, 1] > near) * (1 - back), 16)
        weight = weight * np.where(out, back, np.where(ground, albedo, scattering / total))
        which = random.uniform(0, scattering, len(depth)) < scatterings[0]
        drawn = random.uniform(size=len(depth))
        by = np.where(which, *(np.interp(drawn, one, ANGLES) for one in shares))
        up, about = np.sqrt(drawn), random.uniform(0, 2 * np.pi, len(depth))
        matt = np.stack(
            [np.sqrt(1 - drawn) * np.cos(about), up, np.sqrt(1 - drawn) * np.sin(about)]
        )
        turned = _turn(along, by, random)
        along = np.where(out[:, None], along * (1, -1, 1), along)
        along = np.where(hit[:, None], turned, np.where(ground[:, None], matt.T, along))
        keep = random.uniform(size=len(depth)) < np.minimum(weight / 0.05, 1)
        weight = np.maximum(weight, 0.05)
        along, depth, weight, batch = along[keep], depth[keep], weight[keep], batch[keep]
    each = photons / 16
    found = np.array(
        [tally[1] / tally[0], tally[2] / each, tally[3] / each / np.sin(np.radians(15)) ** 2]
    )
    return found.mean(axis=1), found.std(axis=1, ddof=1) / 4
