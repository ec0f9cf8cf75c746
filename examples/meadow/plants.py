"""Grass and meadow flowers: each function returns one mesh of a plant that stands at the origin.

Sizes are in metres and close to life (flower heads a fifth larger). Colours are linear and already
hold the light: dark at the roots, bright at the tips. Parts say what a triangle is of: "stem", or
the name of a natural material.
"""

import math
from dataclasses import replace

import numpy as np

from .glb import Mesh, join
from .shapes import SUN, card, dome, frame, linear, ribbon, tube, turn_y, unit

# Seen from above, from x towards z: where a petal lies that faces the sun.
SUN_ANGLE = math.atan2(-SUN[2], -SUN[0])
STEM_LOW, STEM_HIGH = linear(52, 70, 30), linear(112, 142, 62)
LUSH_STRIP = (0.0, 0.498, 1.0, 0.004)  # u0, v bottom, u1, v top in the grass texture
TALL_STRIP = (0.0, 0.998, 1.0, 0.504)


def grass_patch(rng, side, cards, strip, width, height):
    """Upright cards, facing all ways, spread over a square of the given side."""
    pieces = []
    columns = math.ceil(math.sqrt(cards))
    for i in range(cards):
        # One card in each cell of a grid, anywhere in the cell: even, but not regular.
        cell = divmod(i * columns * columns // cards, columns)
        x, z = ((c + rng.random()) / columns * side - side / 2 for c in cell)
        face = rng.uniform(0, math.pi)
        size = rng.uniform(0.8, 1.2)
        right = np.array([math.cos(face), 0, math.sin(face)]) * width / 2 * size
        lean = np.array([rng.normal(0, 0.12), 1, rng.normal(0, 0.12)]) * height / 2 * size
        foot = np.array([x, -0.04, z])
        u0, v0, u1, v1 = strip
        box = (u1, v0, u0, v1) if rng.random() < 0.5 else strip
        light = rng.uniform(0.78, 1.0)
        tint = np.array([rng.uniform(0.9, 1.0), 1.0, rng.uniform(0.85, 1.0)])
        pieces.append(card(foot + lean, right, lean, box, (0.62 * light * tint, light * tint)))
    return join(pieces)


def blade_tuft(rng, blades, radius, height, low, high):
    """A tuft of single blades of grass as geometry."""
    pieces = []
    for _ in range(blades):
        direction = rng.uniform(0, 2 * math.pi)
        out = np.array([math.cos(direction), 0, math.sin(direction)])
        side = np.array([-out[2], 0, out[0]])
        tall = height * rng.uniform(0.55, 1.15)
        reach = tall * rng.uniform(0.1, 0.65)
        fraction = np.array([0, 0.4, 0.75, 1.0])[:, None]
        foot = out * radius * math.sqrt(rng.random()) * 0.8
        rise = fraction - 0.35 * (reach / tall) * fraction**2
        line = foot + out * reach * fraction**2 + np.array([0, tall, 0]) * rise - [0, 0.02, 0]
        width = rng.uniform(0.0022, 0.0042)
        light = rng.uniform(0.75, 1.1) * (1 + 0.22 * float(out @ SUN))
        tint = np.array([rng.uniform(0.88, 1.12), 1, rng.uniform(0.85, 1.1)]) * light
        colours = (low + (high - low) * np.array([0, 0.45, 0.8, 1.0])[:, None]) * tint
        pieces.append(ribbon(line, side, [width, width, 0.7 * width, 0], colours))
    return join(pieces).of("grass blade")


def stem(rng, height, lean=0.08, radius=0.0022, low=STEM_LOW, high=STEM_HIGH):
    """A bent stem; returns its mesh and where and in what direction it ends."""
    sway = rng.normal(0, lean, 2) * height
    fraction = np.array([0, 0.5, 1.0])[:, None]
    bend = np.array([sway[0], 0, sway[1]])
    path = np.array([0, height, 0]) * fraction + bend * fraction**2 - [0, 0.02, 0]
    colours = low + (high - low) * fraction
    mesh = tube(path, [radius * 1.3, radius, radius * 0.8], colours).of("stem")
    return mesh, path[-1], path[-1] - path[-2]


def narrow_leaf(rng, foot, length, width):
    direction = rng.uniform(0, 2 * math.pi)
    out = np.array([math.cos(direction), 0, math.sin(direction)])
    fraction = np.array([0, 0.45, 1.0])[:, None]
    rise = np.array([0, length, 0]) * (0.8 * fraction - 0.5 * fraction**2)
    line = foot + out * length * 0.8 * fraction + rise
    colours = linear(70, 96, 42) + (linear(116, 146, 66) - linear(70, 96, 42)) * fraction
    mesh = ribbon(line, [-out[2], 0, out[0]], [width * 0.5, width, 0], colours)
    return mesh.of("grass blade")


def petal_ring(count, length, width, lift, droop, base, tip, shape=(0.35, 1.0, 0.6), turn=0.0):
    """Petals around y. lift: slope at the base; droop: how far they bend down (negative: up).
    shape: half-widths from base to tip, relative to width / 2, none of them 0."""
    fraction = (np.linspace(0.12, 1.0, len(shape)) ** 0.85)[:, None]
    petals = []
    # A petal on the far side of the head leans towards the sun and catches more of it.
    for i in range(count):
        angle = 2 * math.pi * i / count + turn
        out = np.array([math.cos(angle), 0, math.sin(angle)])
        rise = lift * fraction - droop * fraction**2
        line = out * length * fraction + np.array([0, length, 0]) * rise
        light = 0.88 + 0.12 * math.cos(angle - SUN_ANGLE) + 0.05 * (-1) ** i
        colours = (base + (tip - base) * fraction) * light
        side = [-out[2], 0.06, out[0]]  # a slight twist keeps neighbours from lying in one plane
        petals.append(ribbon(line, side, np.array(shape) * width / 2, colours))
    return join(petals)


def with_foot(petals, count, foot):
    """A ring of so many petals with another part around the middle: the first strip of each."""
    part = petals.part.astype(object).reshape(count, -1)
    part[:, :2] = foot
    return replace(petals, part=part.reshape(-1).astype(str))


def placed(head, end, direction):
    return head.moved(frame(direction), end)


def facing(rng, direction, pull):
    """Where a head looks: along its stem, drawn towards the sun."""
    return unit(unit(direction) + pull * SUN + rng.normal(0, 0.16, 3))


def plant(rng, heads, heights, spread, make_head, pull, leaves=2, leaf=(0.12, 0.006), lean=0.08):
    """Several stems from one root, each with a head made by make_head(rng)."""
    pieces = []
    for _ in range(heads):
        angle = rng.uniform(0, 2 * math.pi)
        root = np.array([math.cos(angle), 0, math.sin(angle)]) * spread * math.sqrt(rng.random())
        height = rng.uniform(*heights)
        mesh, end, direction = stem(rng, height, lean)
        pieces.append(mesh.moved(offset=root))
        pieces.append(placed(make_head(rng), end + root, facing(rng, direction, pull)))
        for _ in range(leaves):
            foot = root + end * rng.uniform(0.02, 0.5)
            pieces.append(narrow_leaf(rng, foot, leaf[0] * rng.uniform(0.6, 1.2), leaf[1]))
    return join(pieces)


def daisy_head(rng):
    size = rng.uniform(0.022, 0.03)
    white, shade = linear(246, 246, 238), linear(204, 208, 200)
    petals = petal_ring(12, size, size * 0.45, 0.10, rng.uniform(0.05, 0.3), shade, white)
    eye = dome(size * 0.34, size * 0.2, 7, 2, linear(206, 140, 16), linear(250, 204, 44))
    petals = petals.moved(turn_y(rng.uniform(0, 1))).of("white petal")
    return join([petals, eye.of("yellow petal")])


def poppy_head(rng):
    size = rng.uniform(0.036, 0.046)
    deep, bright = linear(128, 8, 10), linear(232, 52, 26)
    dark = linear(30, 10, 18)
    cup = rng.uniform(0.1, 0.5)
    shape = (0.35, 0.85, 1.0, 0.9, 0.5)
    pieces = []
    for pair, (lift, light) in enumerate(((cup, 0.82), (cup + 0.12, 1.0))):
        turn = pair * math.pi / 2
        args = (size, size * 1.7, lift, -0.35, deep * light, bright * light, shape, turn)
        petals = petal_ring(2, *args)
        # Crumpled edges, and the black blotch at the base of each petal.
        petals.position[:, 1] += rng.normal(0, 0.05 * size, len(petals.position))
        petals.colour *= rng.uniform(0.86, 1.06, (len(petals.position), 1))
        petals.colour[np.arange(len(petals.position)) % 10 < 2] = dark
        pieces.append(with_foot(petals.of("red petal with ultraviolet"), 2, "dark petal"))
    eye = dome(size * 0.22, size * 0.26, 6, 2, linear(22, 18, 24), linear(84, 96, 58))
    stamens = petal_ring(9, size * 0.36, 0.004, 0.5, 0.0, linear(16, 12, 20), linear(34, 26, 44))
    pieces += [stamens.of("dark petal"), eye.of("dark petal")]
    return join(pieces).moved(turn_y(rng.uniform(0, 3)))


def cornflower_head(rng):
    size = rng.uniform(0.021, 0.027)
    shape = (0.15, 0.5, 1.0)
    violet, blue = linear(46, 40, 150), linear(88, 120, 240)
    outer = petal_ring(9, size, size * 0.6, 0.45, 0.1, violet, blue, shape)
    outer.colour *= np.repeat(rng.uniform(0.7, 1.1, (9, 1)), 6, axis=0)
    dark, light = linear(56, 26, 110), linear(136, 80, 200)
    inner = petal_ring(7, size * 0.55, size * 0.3, 1.0, 0.1, dark, light)
    cup = dome(size * 0.3, -size * 0.55, 5, 2, linear(92, 116, 70), linear(64, 84, 44))
    florets = join([outer, inner.moved(turn_y(0.4))])
    return join([cup.of("stem"), florets.of("blue petal")])


def buttercup_head(rng):
    size = rng.uniform(0.014, 0.018)
    base, tip = linear(222, 172, 0), linear(255, 224, 30)
    petals = petal_ring(5, size, size * 1.25, 0.35, -0.25, base, tip, (0.35, 1.0, 0.75))
    eye = dome(size * 0.3, size * 0.3, 5, 1, linear(196, 170, 20), linear(214, 200, 50))
    petals = with_foot(petals.of("yellow petal with ultraviolet"), 5, "yellow petal")
    return join([petals, eye.of("yellow petal")])


def clover_head(rng):
    size = rng.uniform(0.014, 0.018)
    low, high = linear(150, 66, 122), linear(226, 156, 202)
    pieces = []
    # A ball of narrow florets, pale at the tips, row above row.
    for row, (count, lift) in enumerate(((7, -0.25), (8, 0.35), (7, 1.1), (4, 3.0))):
        length = size / math.hypot(1, lift)
        tip = low + (high - low) * (0.55 + 0.15 * row)
        shape, turn = (0.4, 1.0, 0.35), 0.3 * row
        florets = petal_ring(count, length, size * 0.5, lift, 0.0, low, tip, shape, turn)
        pieces.append(florets.moved(offset=(0, size * 0.45, 0)))
    return join(pieces).of("pink petal")


def clover_leaves(rng, count):
    pieces = []
    for _ in range(count):
        angle, distance = rng.uniform(0, 2 * math.pi), 0.09 * math.sqrt(rng.random())
        root = np.array([math.cos(angle), 0, math.sin(angle)]) * distance
        top = root + [rng.normal(0, 0.02), rng.uniform(0.06, 0.14), rng.normal(0, 0.02)]
        green, pale = linear(70, 112, 46), linear(122, 158, 84)
        leaf = petal_ring(3, 0.022, 0.024, 0.1, 0.1, green, pale, (0.3, 1.0, 0.7), angle)
        pieces.append(placed(leaf, top, [rng.normal(0, 0.2), 1, rng.normal(0, 0.2)]))
    return join(pieces).of("green leaf")


def daisies(rng):
    return plant(rng, 4, (0.30, 0.52), 0.10, daisy_head, 0.75)


def poppies(rng):
    base = plant(rng, 2, (0.42, 0.66), 0.08, poppy_head, 0.5, 3, (0.16, 0.010), 0.06)
    mesh, end, _ = stem(rng, rng.uniform(0.35, 0.5))
    bud = dome(0.009, 0.026, 5, 2, linear(84, 104, 56), linear(120, 134, 76)).of("stem")
    return join([base, mesh, placed(bud, end, [0.5, 0.3, 0.2])])


def cornflowers(rng):
    return plant(rng, 3, (0.38, 0.62), 0.09, cornflower_head, 0.35, 2, (0.13, 0.004))


def buttercups(rng):
    return plant(rng, 5, (0.26, 0.46), 0.12, buttercup_head, 0.3, 1, (0.08, 0.008), 0.15)


def clover(rng):
    heads = plant(rng, 3, (0.12, 0.24), 0.10, clover_head, 0.1, 0)
    return join([heads, clover_leaves(rng, 6)])


def far_flowers(rng, colour, heads, radius, heights, size):
    """A drift of flowers for the distance: each head is a tilted square."""
    pieces = []
    for _ in range(heads):
        angle, distance = rng.uniform(0, 2 * math.pi), radius * math.sqrt(rng.random())
        height = rng.uniform(*heights)
        top = np.array([distance * math.cos(angle), height, distance * math.sin(angle)])
        shades = colour * rng.uniform(0.7, 1.0, (4, 1))
        corner = frame(facing(rng, [0, 1, 0], 0.9)) @ turn_y(angle)
        square = np.array([[1, 0, 0], [0, 0, 1], [-1, 0, 0], [0, 0, -1]]) * size
        pieces.append(Mesh(square @ corner.T + top, shades, np.array([[0, 1, 2], [0, 2, 3]])))
    return join(pieces)
