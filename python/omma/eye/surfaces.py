"""Surfaces that carry ommatidia: ellipsoids, spheres among them, and meshes from files.

A surface is asked for the nearest point on it, its outward normal there, the point of which a
direction is the normal, and samples all over it. Where it ends, as an open mesh does, it says how
far the end is.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from omma import _core
from omma._core import Error
from omma.base.arguments import array_of, checked, positive, whole
from omma.base.arrays import Floats, Ints
from omma.base.directions import normalized
from omma.base.files import PathLike, metres_per_unit
from omma.base.mesh_triangles import triangles_of_file
from omma.base.renamed import renamed_arguments, renamed_fields
from omma.base.spirals import fibonacci_lattice, golden_angles_back
from omma.base.values import value_class
from omma.base.warn import warn_caller

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["ellipsoid", "load_surface", "mesh_surface", "sphere"]


_MESH_SAMPLES = 200_000
# Of an ellipsoid: far more than anything asks for, in some gigabytes.
_MOST_SAMPLES = 1 << 24


@runtime_checkable
class Surface(Protocol):
    """What an eye's lenses may sit on; lengths in metres, in the head's frame."""

    def onto(self, points: Floats) -> Floats:
        """The nearest points (K, 3) on it (of an ellipsoid, along the radius)."""

    def normals(self, points: Floats) -> Floats:
        """Outward normals (K, 3), of length 1, at points on it."""

    def near(self, points: Floats) -> tuple[Floats, Floats]:
        """Points on it and their normals, both (K, 3), within a thousandth; quick."""

    def point_of_normal(self, directions: Floats) -> Floats:
        """Points (K, 3) where the outward normal is that of ``directions``, or nearest to it."""

    def samples(self, count: int) -> tuple[Floats, Floats]:
        """About ``count`` points (S, 3) spread over it, and the area (S,) that each stands for."""

    def to_edge(self, points: Floats) -> Floats | None:
        """Distance (K,) to where it ends; None where it is closed."""


@renamed_fields(centre_m="center_m")
@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Ellipsoid:
    """An ellipsoid by its centre and semi-axes to the right, up and forward, metres."""

    semi_axes_m: tuple[float, float, float]
    center_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for length in self.semi_axes_m:
            positive(length, "semi_axes_m")
        if len(self.semi_axes_m) != 3 or not np.isfinite(self.center_m).all():
            raise Error(
                f"ellipsoid: expected three semi-axes and a centre, found {self.semi_axes_m}, "
                f"{self.center_m}"
            )

    def onto(self, points: Floats) -> Floats:
        points = array_of(points, "points", (None, 3))
        from_centre = points - self.center_m
        sphere = from_centre / self.semi_axes_m
        return np.asarray(
            self.center_m + from_centre / np.linalg.norm(sphere, axis=1, keepdims=True)
        )

    def normals(self, points: Floats) -> Floats:
        points = array_of(points, "points", (None, 3))
        return normalized((points - self.center_m) / np.square(self.semi_axes_m))

    def near(self, points: Floats) -> tuple[Floats, Floats]:
        on_surface = self.onto(points)
        return on_surface, self.normals(on_surface)

    def point_of_normal(self, directions: Floats) -> Floats:
        directions = array_of(directions, "directions", (None, 3))
        stretched = directions * np.square(self.semi_axes_m)
        size = np.linalg.norm(directions * np.asarray(self.semi_axes_m), axis=1, keepdims=True)
        return np.asarray(self.center_m + stretched / size)

    def samples(self, count: int) -> tuple[Floats, Floats]:
        count = whole(count, "count", 1, _MOST_SAMPLES)
        points, stretch = stretched(even_directions(count), np.asarray(self.semi_axes_m))
        return np.asarray(self.center_m + points), stretch * (4 * math.pi / count)

    def to_edge(self, points: Floats) -> Floats | None:
        return None


def even_directions(count: int) -> Floats:
    """Directions (count, 3), each for the same solid angle, for `stretched`."""
    return fibonacci_lattice(golden_angles_back(count))


def stretched(directions: Floats, semi_axes_m: Floats) -> tuple[Floats, Floats]:
    """The unit sphere stretched to an ellipsoid about the origin: where its points (K, 3) come to
    be, and how many times as large areas become there (K,)."""
    # Of a sphere that is stretched by A, the area at u becomes det(A) |A⁻¹u| times as large.
    stretch = np.prod(semi_axes_m) * np.linalg.norm(directions / semi_axes_m, axis=1)
    return directions * semi_axes_m, np.asarray(stretch)


@renamed_arguments(centre_m="center_m")
@checked
def sphere(radius_m: float, center_m: Sequence[float] = (0.0, 0.0, 0.0)) -> Ellipsoid:
    """A sphere as a surface for `eye_on_surface` and `lay_on_surface`.

    Raises:
        omma.Error: a radius that is not above 0, a centre that is none.

    Warns:
        UserWarning: a radius that no animal's eye has.
    """
    return ellipsoid((radius_m, radius_m, radius_m), center_m)


@renamed_arguments(centre_m="center_m")
@checked
def ellipsoid(
    semi_axes_m: Sequence[float], center_m: Sequence[float] = (0.0, 0.0, 0.0)
) -> Ellipsoid:
    """An ellipsoid as a surface; semi-axes to the right, up and forward.

    Raises:
        omma.Error: lengths that are not above 0, a centre that is none.

    Warns:
        UserWarning: a semi-axis that no animal's eye has.
    """
    lengths = array_of(semi_axes_m, "semi_axes_m", (3,)).tolist()
    centre = array_of(center_m, "center_m", (3,)).tolist()
    made = Ellipsoid((lengths[0], lengths[1], lengths[2]), (centre[0], centre[1], centre[2]))
    for length in sorted({length for length in lengths if not _is_of_an_eye(length)}):
        warn_caller(
            f"a semi-axis of {length:.3g} m is no animal's eye; eyes have radii of 1 µm to 10 cm",
            UserWarning,
        )
    return made


@checked
def mesh_surface(vertices_m: ArrayLike, triangles: ArrayLike) -> Mesh:
    """A triangle mesh as a surface: vertices (V, 3) and indices of them (T, 3).

    Vertices at one position are one. Normals are smooth, interpolated between those of the
    vertices. The outside is where most of it faces away from its middle, whichever way triangles
    are turned as long as they are all turned alike.

    Raises:
        omma.Error: no triangles, shapes or indices that are wrong, no area.
    """
    return Mesh(vertices_m, triangles)


@checked
def load_surface(path: PathLike, unit: str | float = "mm") -> Mesh:
    """A mesh from a file, glTF, OBJ, PLY or STL, as a surface; lengths in ``unit``.

    Coordinates are taken as they are: x right, y up, z backwards. glTF and STL need
    ``omma[meshes]``, an optional extra.

    Raises:
        omma.Error: the file cannot be read or holds no triangles; the extra is not installed.

    Warns:
        UserWarning: a radius, half the longest side, that no animal's eye has.
    """
    name = os.fsdecode(path)
    scale = metres_per_unit(unit)
    vertices, triangles = triangles_of_file(name)
    try:
        mesh = Mesh(vertices * scale, triangles)
    except Error as error:
        raise Error(f"{name}: {error}") from None
    used = mesh.vertices[mesh.triangles].reshape(-1, 3)
    radius_m = float(np.ptp(used, axis=0).max()) / 2
    if not _is_of_an_eye(radius_m):
        warn_caller(
            f"{name}: {2 * radius_m:.3g} m along its longest side is no animal's eye, with unit "
            f"{unit!r}; eyes have radii of 1 µm to 10 cm",
            UserWarning,
        )
    return mesh


def _is_of_an_eye(radius_m: float) -> bool:
    try:
        _core.expect_eye_radius("radius", radius_m, False)
    except Error:
        return False
    return True


class Mesh:
    """A triangle mesh as a surface; made by `mesh_surface` or `load_surface`."""

    def __init__(self, vertices_m: ArrayLike, triangles: ArrayLike) -> None:
        from scipy.spatial import cKDTree

        vertices = array_of(vertices_m, "vertices")
        faces = array_of(triangles, "triangles", dtype=np.int64)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
            raise Error(f"vertices: expected finite (V, 3), found shape {vertices.shape}")
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) == 0:
            raise Error(f"triangles: expected (T, 3), found shape {faces.shape}")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise Error(f"triangles: expected indices of {len(vertices)} vertices")
        vertices, same = np.unique(vertices, axis=0, return_inverse=True)
        faces = same.ravel()[faces]
        across = _double_area(vertices, faces)
        area = np.linalg.norm(across, axis=1) / 2
        faces, across, area = faces[area > 0], across[area > 0], area[area > 0]
        if len(faces) == 0:
            raise Error("triangles: expected some with an area, found none")
        middle = np.average(vertices[faces].mean(axis=1), axis=0, weights=area)
        if np.sum(across * (vertices[faces].mean(axis=1) - middle)) < 0:
            faces, across = faces[:, ::-1], -across
        # Weighted with the area, as the cross products are.
        normals = np.zeros_like(vertices)
        for corner in range(3):
            np.add.at(normals, faces[:, corner], across)
        size = np.linalg.norm(normals, axis=1, keepdims=True)
        self.vertices = vertices
        self.triangles = faces
        self._vertex_normals = normals / np.maximum(size, 1e-300)
        self._area = area
        self._points, self._of, weight = self._spread(max(_MESH_SAMPLES, 2 * len(faces)))
        corners = self._vertex_normals[self.triangles[self._of]]
        self._normals = normalized(np.einsum("kc,kcx->kx", weight, corners))
        # Twice the distance between samples.
        self._reach = 2 * math.sqrt(float(area.sum()) / len(self._of))
        self._tree = cKDTree(self._points)
        self._edge_tree = self._make_edge_tree()
        self._normal_tree: cKDTree | None = None

    def __reduce__(self) -> tuple[type[Mesh], tuple[Floats, Ints]]:
        return Mesh, (self.vertices, self.triangles)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Mesh)
            and np.array_equal(self.vertices, other.vertices)
            and np.array_equal(self.triangles, other.triangles)
        )

    __hash__ = None  # type: ignore[assignment]  # what holds arrays has none

    def __repr__(self) -> str:
        return f"<surface of {len(self.triangles):,} triangles>"

    def onto(self, points: Floats) -> Floats:
        return self._nearest(points)[0]

    def normals(self, points: Floats) -> Floats:
        _, triangle, weight = self._nearest(points)
        corners = self._vertex_normals[self.triangles[triangle]]
        return normalized(np.einsum("kc,kcx->kx", weight, corners))

    def near(self, points: Floats) -> tuple[Floats, Floats]:
        # Onto the plane that touches at the nearest sample, but not past the end of the surface.
        found = self._tree.query(points)[1]
        start, normals = self._points[found], self._normals[found]
        apart = points - start
        apart -= np.sum(apart * normals, axis=1, keepdims=True) * normals
        size = np.linalg.norm(apart, axis=1, keepdims=True)
        return start + apart * np.minimum(1, self._reach / np.maximum(size, 1e-300)), normals

    def point_of_normal(self, directions: Floats) -> Floats:
        from scipy.spatial import cKDTree

        if self._normal_tree is None:
            self._normal_tree = cKDTree(self._normals)
        near = self._normal_tree.query(directions, 8)[1]
        points = self._points[near[:, 0]].copy()
        # Between vertices the normal is a weighted sum: of the triangles near, the one where the
        # direction is such a sum of all three.
        for rank in range(7, -1, -1):
            faces = self.triangles[self._of[near[:, rank]]]
            corners = self._vertex_normals[faces].transpose(0, 2, 1)
            solvable = np.abs(np.linalg.det(corners)) > 1e-12
            weight = np.full((len(directions), 3), -1.0)
            weight[solvable] = np.linalg.solve(corners[solvable], directions[solvable, :, None])[
                ..., 0
            ]
            holds = np.all(weight >= -1e-9, axis=1)
            fraction = weight[holds] / weight[holds].sum(axis=1, keepdims=True)
            points[holds] = np.einsum("kc,kcx->kx", fraction, self.vertices[faces[holds]])
        return np.asarray(points)

    def samples(self, count: int) -> tuple[Floats, Floats]:
        points, of = self._points, self._of
        if count > len(of):
            points, of, _ = self._spread(count)
        number = np.bincount(of, minlength=len(self._area))
        return points, self._area[of] / number[of]

    def to_edge(self, points: Floats) -> Floats | None:
        if self._edge_tree is None:
            return None
        return np.asarray(self._edge_tree.query(points)[0])

    def _spread(self, count: int) -> tuple[Floats, Ints, Floats]:
        # Points in triangles, by area, at least one in each: (S, 3), their triangles (S,) and the
        # weights of the corners (S, 3).
        fraction = self._area / self._area.sum() * count
        number = np.maximum(1, np.round(fraction)).astype(np.int64)
        of = np.repeat(np.arange(len(number)), number)
        rank = np.arange(len(of)) - np.repeat(np.cumsum(number) - number, number)
        # Two of the generalised golden ratios (Roberts 2018) spread points evenly in the square,
        # which is folded onto the triangle.
        u = (0.5 + rank * 0.7548776662466927) % 1
        v = (0.5 + rank * 0.5698402909980532) % 1
        fold = u + v > 1
        u, v = np.where(fold, 1 - u, u), np.where(fold, 1 - v, v)
        # The middle for one alone.
        alone = number[of] == 1
        u, v = np.where(alone, 1 / 3, u), np.where(alone, 1 / 3, v)
        weight = np.stack([1 - u - v, u, v], axis=1)
        return np.einsum("kc,kcx->kx", weight, self.vertices[self.triangles[of]]), of, weight

    def _make_edge_tree(self) -> cKDTree | None:
        from scipy.spatial import cKDTree

        sides = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, count = np.unique(sides, axis=0, return_counts=True)
        edges = edges[count == 1]
        if len(edges) == 0:
            return None
        start, end = self.vertices[edges[:, 0]], self.vertices[edges[:, 1]]
        # As close along the edge as samples are on the surface.
        step = math.sqrt(self._area.sum() / len(self._of))
        pieces = np.ceil(np.linalg.norm(end - start, axis=1) / step).astype(np.int64) + 1
        of = np.repeat(np.arange(len(edges)), pieces)
        rank = np.arange(len(of)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        along = (rank / (pieces[of] - 1))[:, None]
        return cKDTree(start[of] + along * (end - start)[of])

    def _nearest(self, points: Floats) -> tuple[Floats, Ints, Floats]:
        # Nearest points (K, 3), their triangles (K,) and weights of the corners (K, 3), looked for
        # in the triangles of the nearest samples.
        triangles = self._of[self._tree.query(points, 6)[1]]
        best = np.full(len(points), np.inf)
        chosen = np.zeros(len(points), np.int64)
        weight = np.zeros((len(points), 3))
        for rank in range(triangles.shape[1]):
            corners = self.vertices[self.triangles[triangles[:, rank]]]
            fraction = _closest(points, corners)
            apart = np.sum((np.einsum("kc,kcx->kx", fraction, corners) - points) ** 2, axis=1)
            better = apart < best
            best[better], chosen[better] = apart[better], triangles[better, rank]
            weight[better] = fraction[better]
        corners = self.vertices[self.triangles[chosen]]
        return np.einsum("kc,kcx->kx", weight, corners), chosen, weight


def _double_area(vertices: Floats, faces: Ints) -> Floats:
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return np.asarray(np.cross(b - a, c - a))


def _closest(points: Floats, corners: Floats) -> Floats:
    # Weights (K, 3) of the corners (K, 3, 3) of triangles at their points nearest to others (K, 3):
    # that of the plane where it is inside, else the best on the three sides.
    a, b, c = corners.transpose(1, 0, 2)
    ab, ac, ap = b - a, c - a, points - a
    d00, d01, d11 = (np.sum(x * y, axis=1) for x, y in ((ab, ab), (ab, ac), (ac, ac)))
    d20, d21 = np.sum(ap * ab, axis=1), np.sum(ap * ac, axis=1)
    denominator = np.maximum(d00 * d11 - d01 * d01, 1e-300)
    v = (d11 * d20 - d01 * d21) / denominator
    w = (d00 * d21 - d01 * d20) / denominator
    weight = np.stack([1 - v - w, v, w], axis=1)
    out = np.flatnonzero((weight < 0).any(axis=1))
    if len(out):
        best = np.full(len(out), np.inf)
        for i, j in ((0, 1), (1, 2), (2, 0)):
            start, side = corners[out, i], corners[out, j] - corners[out, i]
            along = np.sum((points[out] - start) * side, axis=1) / np.sum(side * side, axis=1)
            along = np.clip(along, 0, 1)
            apart = np.sum((start + along[:, None] * side - points[out]) ** 2, axis=1)
            better = apart < best
            best[better] = apart[better]
            rows = out[better]
            weight[rows] = 0
            weight[rows, i], weight[rows, j] = 1 - along[better], along[better]
    return weight
