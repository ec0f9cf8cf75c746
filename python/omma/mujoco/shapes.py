"""The shapes of geoms as triangles, in the frame of the geom.

Beside positions and normals a shape has coordinates by which MuJoCo lays textures on geoms: those
of the solid of half size 1 for cubes, and once over each surface for pictures.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from omma.base.arrays import Floats, Ints
from omma.base.directions import normalized
from omma.mujoco.models import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HEIGHT_FIELD,
    MESH,
    PLANE,
    SDF,
    SPHERE,
)

# Sides of what is round: its outline lies within by at most 1 - cos(pi / 96), 0.05 % of the radius.
_SLICES = 96
# MuJoCo draws planes without end to a bit more than where its pictures end.
_BEYOND_FAR = 1.05


@dataclass(frozen=True)
class Shape:
    """Triangles of a geom.

    Attributes:
        positions: (V, 3), in the geom's frame.
        triangles: (T, 3), counter-clockwise as seen from in front.
        normals: (V, 3), or None: flat.
        local: (V, 3), what textures on cubes go by: of solids in half sizes, else the positions.
        once: (V, 2), texture coordinates that show a picture once; NaN along a plane's side that
            has no end. None: pictures are laid along z by `local`.
        own: whether these are a mesh's own.
    """

    positions: Floats
    triangles: Ints
    normals: Floats | None
    local: Floats
    once: Floats | None = None
    own: bool = False


def shape_of(model: Any, geom: int) -> Shape:
    """The triangles of a geom of a kind that is known."""
    kind = int(model.geom_type[geom])
    size = np.asarray(model.geom_size[geom], float)
    if kind == PLANE:
        return _plane(model, size)
    if kind == HEIGHT_FIELD:
        return _height_field(model, int(model.geom_dataid[geom]))
    if kind in (MESH, SDF):
        return _mesh(model, int(model.geom_dataid[geom]))
    if kind == BOX:
        return _scaled(_unit_box(), size)
    if kind == CYLINDER:
        return _scaled(_unit_cylinder(), size[[0, 0, 1]])
    if kind == SPHERE:
        return _scaled(_sphere(), size[[0, 0, 0]])
    if kind == ELLIPSOID:
        return _scaled(_sphere(), size)
    assert kind == CAPSULE
    return _capsule(size[0], size[1])


def drawn_size(model: Any, geom: int) -> Floats:
    """Half sizes (3,) along x, y and z, by which textures that are uniform go."""
    size = np.asarray(model.geom_size[geom], float)
    kind = int(model.geom_type[geom])
    if kind == SPHERE:
        return size[[0, 0, 0]]
    if kind in (CAPSULE, CYLINDER):
        return size[[0, 0, 1]]
    return size


def _plane(model: Any, size: Floats) -> Shape:
    """A rectangle; where a size is 0, to where MuJoCo's pictures end."""
    far = _BEYOND_FAR * float(model.vis.map.zfar) * float(model.stat.extent)
    half = np.where(size[:2] > 0, size[:2], far)
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    once = np.where(size[:2] > 0, 0.5 + 0.5 * square[:, :2] * (1, -1), np.nan)
    corners = square * (*half, 0)
    return Shape(corners, np.array([[0, 1, 2], [0, 2, 3]]), None, corners, once)


def _height_field(model: Any, field: int) -> Shape:
    """Its surface with walls and a floor; squares are halved from left front to right back."""
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    first = int(model.hfield_adr[field])
    heights = np.asarray(model.hfield_data[first : first + rows * columns], float)
    width, depth, rise, base = np.asarray(model.hfield_size[field], float)
    x, y = np.meshgrid(np.linspace(-width, width, columns), np.linspace(-depth, depth, rows))
    top = np.stack([x, y, rise * heights.reshape(rows, columns)], -1)
    here = np.arange(rows * columns).reshape(rows, columns)
    front_left, front_right = here[:-1, :-1], here[:-1, 1:]
    back_left, back_right = here[1:, :-1], here[1:, 1:]
    surface = np.concatenate([
        np.stack([back_left, front_left, back_right], -1).reshape(-1, 3),
        np.stack([front_left, front_right, back_right], -1).reshape(-1, 3),
    ])  # fmt: skip
    positions, triangles, normals = [top.reshape(-1, 3)], [surface], [_field_normals(top)]
    edges = (
        (top[0], (0.0, -1, 0)), (top[::-1, 0], (-1.0, 0, 0)),
        (top[-1, ::-1], (0.0, 1, 0)), (top[:, -1], (1.0, 0, 0)),
    )  # fmt: skip
    count = rows * columns
    for edge, outward in edges:
        n = len(edge)
        along = np.arange(n - 1)
        wall = np.stack(
            [along, along + n, along + 1, along + 1, along + n, along + n + 1], -1
        ).reshape(-1, 3)
        positions.append(np.concatenate([edge, edge * (1, 1, 0) - (0, 0, base)]))
        triangles.append(wall + count)
        normals.append(np.tile(outward, (2 * n, 1)))
        count += 2 * n
    floor = np.array([[-1.0, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0]]) * (width, depth, 0)
    positions.append(floor - (0, 0, base))
    triangles.append(np.array([[0, 1, 2], [0, 2, 3]]) + count)
    normals.append(np.tile((0.0, 0, -1), (4, 1)))
    vertices = np.concatenate(positions)
    return Shape(vertices, np.concatenate(triangles), np.concatenate(normals), vertices)


def _field_normals(top: Floats) -> Floats:
    """Normals (V, 3) of a grid (rows, columns, 3), by differences of neighbours."""
    across = np.gradient(top, axis=1)
    along = np.gradient(top, axis=0)
    normals = np.cross(across, along).reshape(-1, 3)
    return normalized(normals)


def _mesh(model: Any, mesh: int) -> Shape:
    """A vertex for each of a mesh's (position, normal, texture coordinate) that are used
    together."""
    faces = slice(int(model.mesh_faceadr[mesh]), None)
    faces = slice(faces.start, faces.start + int(model.mesh_facenum[mesh]))
    corners = [np.asarray(model.mesh_face[faces], np.int64).ravel()]
    corners.append(np.asarray(model.mesh_facenormal[faces], np.int64).ravel())
    first_coordinate = int(model.mesh_texcoordadr[mesh])
    if first_coordinate >= 0:
        corners.append(np.asarray(model.mesh_facetexcoord[faces], np.int64).ravel())
    used, triangles = np.unique(np.stack(corners, 1), axis=0, return_inverse=True)
    vertices = np.asarray(model.mesh_vert[int(model.mesh_vertadr[mesh]) + used[:, 0]], float)
    normals = np.asarray(model.mesh_normal[int(model.mesh_normaladr[mesh]) + used[:, 1]], float)
    normals[~np.abs(normals).max(axis=1).astype(bool)] = 0, 0, 1
    coordinates = None
    if first_coordinate >= 0:
        coordinates = np.asarray(model.mesh_texcoord[first_coordinate + used[:, 2]], float)
    own = coordinates is not None
    return Shape(vertices, triangles.reshape(-1, 3), normals, vertices, coordinates, own)


def _scaled(shape: Shape, half: Floats) -> Shape:
    normals = None if shape.normals is None else shape.normals / half
    if normals is not None:
        normals = normalized(normals)
    return Shape(shape.positions * half, shape.triangles, normals, shape.local, shape.once)


def _unit_box() -> Shape:
    """Pictures are seen along the axes, upright on the sides: so they are mirrored at the back."""
    positions, normals, once = [], [], []
    for axis in range(3):
        across, upwards = ((1, 2), (0, 2), (0, 1))[axis]
        for sign in (-1.0, 1.0):
            outward, right = np.zeros(3), np.zeros(3)
            outward[axis], right[(axis + 1) % 3] = sign, 1
            up = np.cross(outward, right)
            corners = np.array([outward - right - up, outward + right - up, outward + right + up,
                                outward - right + up])  # fmt: skip
            positions.append(corners)
            normals.append(np.tile(outward, (4, 1)))
            once.append(0.5 + 0.5 * corners[:, [across, upwards]] * (1, -1))
    first = 4 * np.arange(6)[:, None, None]
    triangles = (first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    vertices = np.concatenate(positions)
    return Shape(vertices, triangles, np.concatenate(normals), vertices, np.concatenate(once))


def _unit_cylinder() -> Shape:
    """Closed, along z from -1 to 1."""
    shapes, ring = [_tube()], _ring()
    here = 1 + np.arange(_SLICES)
    fan = np.stack([np.zeros(_SLICES, int), here, here + 1], -1)
    for sign in (1.0, -1.0):
        vertices = np.concatenate([np.zeros((1, 3)), ring]) + (0, 0, sign)
        normals = np.tile((0.0, 0, sign), (_SLICES + 2, 1))
        triangles = fan if sign > 0 else fan[:, ::-1]
        shapes.append(Shape(vertices, triangles, normals, vertices, 0.5 + 0.5 * vertices[:, :2]))
    return _joined(shapes)


def _tube() -> Shape:
    """The side of a cylinder of radius 1, along z from -1 to 1."""
    ring, around = _ring(), np.linspace(0, 1, _SLICES + 1)
    positions = np.concatenate([ring - (0, 0, 1), ring + (0, 0, 1)])
    once = np.stack([np.tile(around, 2), np.repeat([1.0, 0.0], _SLICES + 1)], -1)
    return Shape(positions, _grid(1), np.concatenate([ring, ring]), positions, once)


def _sphere() -> Shape:
    return _dome(-np.pi / 2, np.pi / 2)


def _dome(lowest_rad: float, highest_rad: float) -> Shape:
    """A sphere of radius 1 between two elevations about z."""
    steps = round(_SLICES / 2 * (highest_rad - lowest_rad) / np.pi)
    elevation = np.linspace(lowest_rad, highest_rad, steps + 1)
    level = np.cos(elevation)
    level[np.abs(elevation) == np.pi / 2] = 0  # a pole is one point
    positions = np.concatenate([c * _ring() + (0, 0, np.sin(e)) for c, e in zip(level, elevation)])
    u, v = np.meshgrid(np.linspace(0, 1, _SLICES + 1), np.linspace(1, 0, steps + 1))
    once = np.stack([u, v], -1).reshape(-1, 2)
    triangles = _grid(steps)
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    there = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12
    return Shape(positions, triangles[there], positions, positions, once)


def _capsule(radius: float, half_length: float) -> Shape:
    """A tube and two half spheres, each with a picture of its own about its own middle. For cubes
    they stand on the ends of the tube of half size 1, so that they show what is above or below."""
    shapes = [_scaled(_tube(), np.array([radius, radius, half_length]))]
    for sign, low, high in ((1, 0.0, np.pi / 2), (-1, -np.pi / 2, 0.0)):
        cap = _dome(low, high)
        vertices = radius * cap.positions + (0, 0, sign * half_length)
        shapes.append(replace(cap, positions=vertices, local=cap.local + (0, 0, sign)))
    return _joined(shapes)


def _ring() -> Floats:
    """Directions around z; the first comes again as the last, to the same bits."""
    angle = 2 * np.pi * (np.arange(_SLICES + 1) % _SLICES) / _SLICES
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(_SLICES + 1)], -1)


def _grid(rows: int) -> Ints:
    """Triangles between ``rows + 1`` rings, listed from the lowest."""
    row, column = np.divmod(np.arange(rows * _SLICES), _SLICES)
    lower = row * (_SLICES + 1) + column
    upper = lower + _SLICES + 1
    first = np.stack([lower, lower + 1, upper + 1], -1)
    second = np.stack([lower, upper + 1, upper], -1)
    return np.concatenate([first, second])


def _joined(shapes: list[Shape]) -> Shape:
    """All as one; each has normals and coordinates."""
    firsts = np.cumsum([0] + [len(one.positions) for one in shapes])
    return Shape(
        np.concatenate([one.positions for one in shapes]),
        np.concatenate([one.triangles + first for one, first in zip(shapes, firsts)]),
        np.concatenate([one.normals for one in shapes if one.normals is not None]),
        np.concatenate([one.local for one in shapes]),
        np.concatenate([one.once for one in shapes if one.once is not None]),
    )
