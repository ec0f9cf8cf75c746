"""Trees, bushes and stones. Light is baked in: crowns are bright on the sun's side, dark inside."""

import math

import numpy as np

from .glb import Mesh, join
from .shapes import SUN, card, dome, linear, tube, unit

OAK_LEAF, BIRCH_LEAF = (0.01, 0.49, 0.49, 0.01), (0.51, 0.49, 0.99, 0.01)
BUSH_LEAF, FAR_LEAF = (0.01, 0.99, 0.49, 0.51), (0.51, 0.99, 0.99, 0.51)
OAK_BARK, BIRCH_BARK = (0.02, 0.48, 1.2), (0.52, 0.98, 1.2)


def crown_light(position, centre, radii):
    """Linear light factor at a point of a crown: outside over inside, sun side over lee side."""
    offset = (position - centre) / radii
    outside = min(1.0, float(np.linalg.norm(offset)))
    sunny = float(unit(offset + 1e-9) @ SUN) * outside
    return float(np.clip(0.38 + 0.26 * outside**2 + 0.48 * sunny, 0.12, 1.0))


def leaf_cards(rng, places, centre, radii, box, size, per_place, tint):
    """Cards with leaves on them, facing outwards more or less; steep rather than flat, as a flat
    one is a mere line from the side."""
    pieces = []
    for place in places:
        for _ in range(per_place):
            where = place + rng.normal(0, 0.22 * size, 3)
            outward = (where - centre) / radii + rng.normal(0, 0.5, 3)
            outward = unit(outward * [1, 0.45, 1])
            right = unit(np.cross(outward, rng.normal(0, 1, 3)))
            up = np.cross(outward, right)
            half = size / 2 * rng.uniform(0.8, 1.25)
            shades = [
                crown_light(where + up * half * s, centre, radii) * rng.uniform(0.86, 1.1)
                for s in (-1, 1)
            ]
            colours = [np.clip(np.asarray(tint) * s, 0, 1) for s in shades]
            pieces.append(card(where, right * half, up * half, box, colours))
    return join(pieces)


def branch(rng, start, direction, length, radius, sag, points=4):
    """Path and radii of a branch that bends upwards (sag > 0: downwards) on its way."""
    fraction = np.linspace(0, 1, points)[:, None]
    bend = np.array([0, -sag * length, 0]) * fraction**2
    wobble = rng.normal(0, min(0.05 * length, 0.10), (points, 3)) * np.sin(math.pi * fraction)
    path = start + unit(direction) * length * fraction + bend + wobble
    return path, radius * (1 - 0.75 * fraction[:, 0])


def wood_colours(path, light):
    height = path[:, 1:2]
    # Darker up in the crown, where the leaves shade it, and at the foot in the grass.
    shade = 0.55 + 0.35 * np.exp(-((height - 1.5) ** 2) / 4)
    return np.clip(shade * np.full((1, 3), light), 0, 1)


def tree(rng, kind):
    """(wood, leaves) of one tree. kind: "oak" (broad, heavy) or "birch" (slender, hanging)."""
    oak = kind == "oak"
    height = rng.uniform(8.5, 10.0) if oak else rng.uniform(9.0, 11.0)
    reach = height * (0.46 if oak else 0.23)
    bark, light = (OAK_BARK, 0.8) if oak else (BIRCH_BARK, 0.95)
    trunk, radii = branch(
        rng, np.array([0, -0.15, 0]), [0, 1, 0], height * 0.86, 0.34 if oak else 0.13, 0, 8
    )
    radii[0] *= 1.35
    wood = [tube(trunk, radii, wood_colours(trunk, light), 7, bark)]
    places = []
    first = 0.36 if oak else 0.22
    limbs = 17 if oak else 22
    for i in range(limbs):
        fraction = first + (1 - first) * (i + rng.random()) / limbs
        start = np.array([np.interp(fraction, np.linspace(0, 1, 8), trunk[:, k]) for k in range(3)])
        angle = i * 2.39996 + rng.normal(0, 0.3)
        steep = (0.25 + 0.9 * fraction) if oak else (0.75 + 0.5 * fraction)
        direction = np.array([math.cos(angle), steep, math.sin(angle)])
        along = (fraction - first) / (1 - first)
        profile = math.sin(math.pi * (0.2 + 0.72 * along)) ** 0.7 if oak else 1.05 - 0.75 * along
        length = reach * profile * rng.uniform(0.85, 1.1)
        path, thin = branch(
            rng, start, direction, length, 0.085 if oak else 0.03, 0.0 if oak else 0.25
        )
        wood.append(tube(path, thin, wood_colours(path, light * 0.8), 4, bark))
        places += [path[-1], path[-2] + rng.normal(0, 0.25, 3)]
        for k in range(5 if oak else 3):
            origin = path[1 + k % 3]
            side = unit(unit(direction) + rng.normal(0, 0.75, 3) * [1, 0.6, 1])
            twig, thin = branch(
                rng,
                origin,
                side,
                length * rng.uniform(0.25, 0.44),
                0.03 if oak else 0.012,
                0.05 if oak else 0.55,
                3,
            )
            wood.append(tube(twig, thin, wood_colours(twig, light * 0.7), 3, bark))
            places += [twig[-1], twig[-1] + [0, -0.5 * (not oak), 0] + rng.normal(0, 0.2, 3)]
    places = np.array(places)
    centre = (places.min(axis=0) + places.max(axis=0)) / 2
    crown = (places.max(axis=0) - places.min(axis=0)) / 2
    if oak:
        leaves = leaf_cards(rng, places, centre, crown, OAK_LEAF, 1.25, 3, (0.92, 0.95, 0.9))
    else:
        leaves = leaf_cards(rng, places, centre, crown, BIRCH_LEAF, 0.85, 3, (1.0, 1.0, 0.9))
    return join(wood), leaves


def far_tree(rng, conifer):
    """Leaf cards only, for the wood at the edge; about 6 m (conifer: 8 m) high, foot at y = 0."""
    places = []
    for _ in range(54):
        fraction = rng.random()
        if conifer:
            spread, y = 1.6 * (1 - fraction) + 0.1, -0.1 + 7.9 * fraction
        else:
            y = -0.2 + 6.0 * fraction
            spread = 2.4 * math.sin(math.pi * (0.22 + 0.76 * fraction)) ** 0.6
        angle = rng.uniform(0, 2 * math.pi)
        places.append([spread * math.cos(angle), y, spread * math.sin(angle)])
    places = np.array(places)
    centre = np.array([0, places[:, 1].mean(), 0])
    radii = (places.max(axis=0) - places.min(axis=0)) / 2 + 0.3
    tint = (0.62, 0.78, 0.78) if conifer else (0.88, 0.9, 0.88)
    return leaf_cards(rng, places, centre, radii, FAR_LEAF, 1.5 if conifer else 2.0, 1, tint)


def bush(rng):
    places = []
    for _ in range(58):
        direction = unit(rng.normal(0, 1, 3) * [1, 0.9, 1])
        where = direction * rng.uniform(0.55, 1.0) * [1.15, 0.8, 1.15] + [0, 0.75, 0]
        places.append([where[0], max(where[1], 0.1), where[2]])
    centre, radii = np.array([0, 0.6, 0]), np.array([1.3, 1.0, 1.3])
    return leaf_cards(rng, np.array(places), centre, radii, BUSH_LEAF, 0.75, 2, (0.9, 0.95, 0.85))


def stone(rng):
    """A boulder half sunk in the ground, about 1 m across; texture coordinates for the ground."""
    blob = dome(0.5, 0.42, 14, 6, (1, 1, 1), (1, 1, 1))
    knobs = rng.normal(0, 1, (9, 3))
    position = blob.position.copy()
    for knob in knobs:
        # Flattening along random planes gives facets, which read as stone.
        axis = unit(knob * [1, 0.7, 1])
        beyond = position @ axis - rng.uniform(0.30, 0.42)
        position -= np.maximum(beyond, 0)[:, None] * axis * 0.85
    position += rng.normal(0, 0.006, position.shape)
    index = blob.index
    a, b, c = (position[index[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    normal = np.zeros_like(position)
    for k in range(3):
        np.add.at(normal, index[:, k], face)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-12
    normal *= np.sign(normal[:, 1:2].sum())
    outward = np.sign((normal * position).sum(axis=1, keepdims=True))
    light = 0.30 + 0.55 * np.clip((normal * outward) @ SUN, 0, 1) + 0.15 * position[:, 1] / 0.42
    light *= np.clip(0.45 + position[:, 1] / 0.15, 0.45, 1)
    speckle = rng.normal(1, 0.04, (len(light), 1))
    colour = np.clip(light[:, None] * linear(226, 220, 210) * speckle, 0, 1)
    texcoord = np.stack([position[:, 0] + 0.6 * position[:, 1], position[:, 2]], axis=1) * 0.8
    position[:, 1] -= 0.08
    return Mesh(position, colour, index, texcoord)
