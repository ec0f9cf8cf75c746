"""Small pieces of geometry that plants and trees are put together from."""

import math

import numpy as np

from .glb import Mesh

# Towards the sun: high, from the left and a little from behind the camera named "bee".
SUN = np.array([-0.62, 0.66, 0.42]) / np.linalg.norm([-0.62, 0.66, 0.42])


def linear(*srgb):
    """Linear light of a display colour given as 0 to 255 in each of r, g, b (sRGB)."""
    return linear_of(np.asarray(srgb, float) / 255)


def linear_of(value):
    """Linear light of sRGB values from 0 to 1."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def unit(vector):
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


def turn_y(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def frame(up):
    """Rotation whose y axis is `up`: it takes a shape that grows along y to grow along `up`."""
    y = unit(up)
    x = unit(np.cross(y, [0, 0, 1]) if abs(y[2]) < 0.9 else np.cross(y, [1, 0, 0]))
    return np.stack([x, y, np.cross(x, y)], axis=1)


def grid_index(rows, columns, closed=False):
    """Triangles over a grid of vertices numbered row by row; closed joins last column to first."""
    r, c = np.meshgrid(np.arange(rows - 1), np.arange(columns if closed else columns - 1))
    r, c = r.ravel(order="F"), c.ravel(order="F")
    n = (c + 1) % columns
    a, b, d, e = r * columns + c, r * columns + n, (r + 1) * columns + c, (r + 1) * columns + n
    return np.stack([np.stack([a, b, e], 1), np.stack([a, e, d], 1)], 1).reshape(-1, 3)


def tube(path, radii, colours, sides=3, texcoord_box=None):
    """A tube along path (P, 3); colours (P, 3); texcoord_box = (u0, u1, metres per tile)."""
    path, radii = np.asarray(path, float), np.asarray(radii, float)
    tangents = np.gradient(path, axis=0)
    # A textured tube needs its seam twice; one that is not closes on itself.
    around = np.arange(sides + (texcoord_box is not None)) * 2 * math.pi / sides
    circle = np.stack([np.cos(around), np.zeros_like(around), np.sin(around)], axis=1)
    position = np.concatenate(
        [p + (circle * r) @ frame(t).T for p, r, t in zip(path, radii, tangents)]
    )
    colour = np.repeat(np.asarray(colours, float), len(around), axis=0)
    index = grid_index(len(path), len(around), closed=texcoord_box is None)
    texcoord = None
    if texcoord_box is not None:
        u0, u1, tile = texcoord_box
        steps = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        u = np.tile(np.linspace(u0, u1, len(around)), len(path))
        texcoord = np.stack([u, np.repeat(-steps / tile, len(around))], axis=1)
    return Mesh(position, colour, index, texcoord)


def ribbon(line, side, half_widths, colours):
    """A flat strip along line (P, 3), half_widths to each side; ends in a point where that is 0."""
    line, side = np.asarray(line, float), np.asarray(side, float)
    widths = np.asarray(half_widths, float)[:, None]
    position = np.stack([line - side * widths, line + side * widths], axis=1).reshape(-1, 3)
    colour = np.repeat(np.asarray(colours, float), 2, axis=0)
    index = grid_index(len(line), 2)
    if half_widths[-1] == 0:
        position, colour, index = position[:-1], colour[:-1], index[:-1]
        index = np.minimum(index, len(position) - 1)
    return Mesh(position, colour, index)


def card(centre, right, up, texcoords, colours):
    """A rectangle from centre - right - up to centre + right + up; texcoords = (u0, v0, u1, v1)
    with v0 at the bottom; colours of the lower and the upper edge."""
    centre, right, up = (np.asarray(v, float) for v in (centre, right, up))
    position = np.stack(
        [centre - right - up, centre + right - up, centre + right + up, centre - right + up]
    )
    u0, v0, u1, v1 = texcoords
    texcoord = np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])
    colour = np.array([colours[0], colours[0], colours[1], colours[1]], float)
    return Mesh(position, colour, np.array([[0, 1, 2], [0, 2, 3]]), texcoord)


def dome(radius, height, sides, rings, rim_colour, top_colour):
    """The upper part of a rounded disc, its rim at y = 0."""
    rows = []
    for i in range(rings):
        tilt = math.pi / 2 * i / rings
        around = np.arange(sides) * 2 * math.pi / sides + i * math.pi / sides
        ring = np.stack([np.cos(around), np.zeros(sides), np.sin(around)], axis=1)
        rows.append(ring * radius * math.cos(tilt) + [0, height * math.sin(tilt), 0])
    position = np.concatenate([*rows, [[0, height, 0]]])
    index = grid_index(rings, sides, closed=True)
    last = (rings - 1) * sides
    cap = [[last + i, last + (i + 1) % sides, len(position) - 1] for i in range(sides)]
    fraction = np.clip(position[:, 1:2] / height, 0, 1)
    colour = np.asarray(rim_colour) * (1 - fraction) + np.asarray(top_colour) * fraction
    return Mesh(position, colour, np.concatenate([index, np.array(cap)]))
