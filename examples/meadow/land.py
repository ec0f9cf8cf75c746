"""The lie of the land: height, path, colour and shade at any point, and the meshes of the ground.

x is to the right, z towards the viewer, both in metres; the meadow proper lies within 32 m of the
origin, beyond it the land rises to a ring of wooded hills, so that its edge is never seen.
"""

import math

import numpy as np

from .glb import Mesh
from .shapes import SUN, grid_index, linear

HALF_WIDTH_M = 215.0
RIDGE_M = 165.0
# Colour of the sky at the horizon (the scene's simple_sky); far things fade into it.
HORIZON = np.array([143, 179, 203]) / 255 * 0.8
# Mean linear colour of the ground texture: vertex colours divide by it to hit a wanted colour.
TEXTURE_MEAN = np.array([0.43, 0.43, 0.33])


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def waves(x, z, scale, seed):
    """Smooth noise in about -1 to 1: a few sines in directions and phases set by the seed."""
    rng = np.random.default_rng([77, seed])
    total = np.zeros(np.broadcast(x, z).shape)
    for _ in range(7):
        angle, phase = rng.uniform(0, 2 * math.pi, 2)
        frequency = 2 * math.pi / scale * rng.uniform(0.55, 1.6)
        total += np.sin(frequency * (x * math.cos(angle) + z * math.sin(angle)) + phase)
    return total / 3.2


def height_m(x, z):
    x, z = np.asarray(x, float), np.asarray(z, float)
    r, theta = np.hypot(x, z), np.arctan2(z, x)
    roll = 0.55 * waves(x, z, 30, 1) + 0.06 * waves(x, z, 9, 2)
    ridge = 17 + 6 * np.sin(2 * theta + 0.6) + 4 * np.sin(3 * theta + 1.9) + 2 * np.sin(7 * theta)
    rise = ridge * smoothstep(34, RIDGE_M, r) ** 1.25
    knolls = 0.0
    for kx, kz, size, tall in ((-46, -74, 24, 5.5), (58, -66, 22, 4.0), (12, -108, 30, 4.5)):
        knolls = knolls + tall * np.exp(-((x - kx) ** 2 + (z - kz) ** 2) / (2 * size**2))
    back = -22 * smoothstep(RIDGE_M + 12, HALF_WIDTH_M, r)
    return roll * smoothstep(200, 30, r) + rise + knolls + back


def normal(x, z, step=0.4):
    dx = (height_m(x + step, z) - height_m(x - step, z)) / (2 * step)
    dz = (height_m(x, z + step) - height_m(x, z - step)) / (2 * step)
    n = np.stack([-dx, np.ones_like(dx), -dz], axis=-1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def path_x(z):
    """Where the path crosses a given z."""
    z = np.asarray(z, float)
    return 1.25 + 1.35 * np.sin(0.16 * (z - 2.6)) * (1 + 0.03 * np.maximum(-z, 0)) - 0.02 * z


def path_distance_m(x, z):
    slope = (path_x(z + 0.1) - path_x(z - 0.1)) / 0.2
    return np.abs(x - path_x(z)) / np.hypot(1, slope)


def shade(x, z, shadows):
    """Light factor 0.45 to 1 from the trees' shadows: rows of (x, z, radius, height)."""
    light = np.ones(np.broadcast(x, z).shape)
    for sx, sz, radius, tall in shadows:
        run = -SUN[[0, 2]] / SUN[1]
        cx, cz = sx + run[0] * tall, sz + run[1] * tall
        along, across = run / np.linalg.norm(run), np.array([-run[1], run[0]]) / np.linalg.norm(run)
        a = ((x - cx) * along[0] + (z - cz) * along[1]) / (radius * 1.45)
        b = ((x - cx) * across[0] + (z - cz) * across[1]) / radius
        dapple = 0.10 * waves(x, z, 1.6, 11)
        light = light * (1 - 0.62 * smoothstep(1.12, 0.72, np.hypot(a, b) + dapple))
        # Contact shade at the foot of the trunk.
        foot = np.hypot(x - sx, z - sz) / (radius / 4)
        light = light * (1 - 0.3 * np.exp(-(foot**2) / 2))
    return light


def blend(a, b, fraction):
    return a + (b - a) * np.asarray(fraction)[..., None]


def ground_colour(x, z, shadows, drifts):
    """Wanted linear colour of the ground (..., 3). drifts: (x, z, radius, colour, strength)."""
    r = np.hypot(x, z)
    lush, dry, dark = linear(98, 118, 46), linear(148, 144, 74), linear(70, 92, 38)
    colour = blend(lush, dry, 0.5 * np.clip(waves(x, z, 19, 4) + 0.25, 0, 1))
    colour = blend(colour, dark, 0.55 * np.clip(waves(x, z, 13, 5), 0, 1))
    # Beyond the meadow: hay fields and pastures of different greens.
    field = np.clip(0.5 + 2.5 * waves(x, z, 70, 6), 0, 1)
    far = blend(linear(116, 140, 56), linear(190, 176, 96), field)
    far = blend(far, linear(84, 110, 46), np.clip(3 * waves(x, z, 52, 7) - 0.6, 0, 1))
    colour = blend(colour, far, smoothstep(26, 60, r))
    colour = blend(colour, linear(52, 74, 36), 0.8 * wooded(x, z))
    for dx, dz, radius, tint, strength in drifts:
        near = np.exp(-((x - dx) ** 2 + (z - dz) ** 2) / (radius**2))
        colour = blend(colour, tint, strength * near)
    soil = np.clip(1 - path_distance_m(x, z) / 0.75, 0, 1) * smoothstep(44, 34, r)
    colour = blend(colour, linear(168, 142, 102), 0.85 * smoothstep(0.1, 0.75, soil))
    sun = np.clip(normal(x, z, 0.4 + 0.03 * r) @ SUN, 0, 1) / SUN[1]
    colour = colour * (0.42 + 0.58 * sun)[..., None] * shade(x, z, shadows)[..., None]
    haze = 1 - np.exp(-np.maximum(r - 40, 0) / 480)
    return blend(colour, HORIZON, haze)


def wooded(x, z):
    """0 in the open to 1 in the wood on the hills."""
    r, theta = np.hypot(x, z), np.arctan2(z, x)
    edge = 112 + 20 * np.sin(3 * theta + 0.4) + 12 * np.sin(5 * theta + 2.2)
    edge = edge + 8 * waves(x, z, 25, 8)
    return smoothstep(edge - 4, edge + 4, r)


def texcoords(x, z):
    """Ground texture coordinates: turned and warped so that rows of tiles do not line up, and ever
    larger with distance, where small tiles would only flicker."""
    r = np.maximum(np.hypot(x, z), 1e-6)
    scale = np.where(r < 30, 1.0, 30 * (1 + np.log(np.maximum(r, 30) / 30)) / r) / 2.3
    u = (0.83 * x + 0.56 * z) * scale + 0.30 * waves(x, z, 9, 9)
    v = (-0.56 * x + 0.83 * z) * scale + 0.30 * waves(x, z, 9, 10)
    return np.stack([u, v], axis=-1)


def terrain(shadows, drifts):
    """One grid: 1 m cells in the meadow, growing outwards."""
    line = list(np.arange(0, 32.5, 1.0))
    while line[-1] < HALF_WIDTH_M:
        line.append(min(line[-1] + 1.15 * (line[-1] - line[-2]), line[-1] + 13.0))
    axis = np.array([-v for v in line[:0:-1]] + line)
    z, x = np.meshgrid(axis, axis, indexing="ij")
    x, z = x.ravel(), z.ravel()
    position = np.stack([x, height_m(x, z), z], axis=1)
    colour = np.clip(ground_colour(x, z, shadows, drifts) / TEXTURE_MEAN, 0, 1)
    # (x right, z towards the viewer): the grid's triangles face down, so turn them.
    index = grid_index(len(axis), len(axis))[:, [0, 2, 1]]
    return Mesh(position, colour, index, texcoords(x, z))


def hedge_strip(start, end):
    """The dark, rank ground along a hedge: a strip that dips below the terrain at its edges."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = np.linalg.norm(end - start)
    across = np.array([end[1] - start[1], start[0] - end[0]]) / length
    along = np.linspace(0, 1, int(length / 3) + 2)[:, None]
    rows = []
    for k, (offset, lift) in enumerate(((-2.2, -0.5), (-1.2, 0.12), (1.2, 0.12), (2.2, -0.5))):
        ragged = offset + 0.4 * waves(along[:, 0] * length, 0 * along[:, 0] + k, 9, 14)
        x, z = (start + (end - start) * along + across * ragged[:, None]).T
        rows.append(np.stack([x, height_m(x, z) + lift, z], axis=1))
    position = np.stack(rows, axis=1).reshape(-1, 3)
    x, z = position[:, 0], position[:, 2]
    tint = blend(np.tile(linear(62, 84, 40), (len(x), 1)), HORIZON, 0.04) / TEXTURE_MEAN
    index = grid_index(len(along), 4)[:, [0, 2, 1]]
    return Mesh(position, np.clip(tint, 0, 1), index, texcoords(x, z))


def path_strip(shadows, drifts):
    """The trodden path, a strip just above the terrain whose edges dip below it."""
    z = np.arange(-34, 31, 0.5)
    centre = path_x(z)
    slope = np.gradient(centre, z)
    across = np.stack([np.ones_like(z), -slope], axis=1) / np.hypot(1, slope)[:, None]
    rows = []
    lifts = (-0.06, 0.012, 0.02, 0.012, 0.02, 0.012, -0.06)
    for offset, lift in zip((-0.55, -0.34, -0.2, 0.0, 0.2, 0.34, 0.55), lifts):
        ragged = offset * (1 + 0.22 * waves(z, 0 * z + offset, 1.7, 12))
        px, pz = centre + across[:, 0] * ragged, z + across[:, 1] * ragged
        rows.append(np.stack([px, height_m(px, pz) + lift, pz], axis=1))
    position = np.stack(rows, axis=1).reshape(-1, 3)
    x, zz = position[:, 0], position[:, 2]
    colour = np.clip(ground_colour(x, zz, shadows, drifts) / TEXTURE_MEAN, 0, 1)
    rut = 1 - 0.12 * np.clip(waves(x, zz, 1.1, 13), -0.5, 1)
    index = grid_index(len(z), len(rows))[:, [0, 2, 1]]
    return Mesh(position, np.clip(colour * rut[:, None], 0, 1), index, texcoords(x, zz))
