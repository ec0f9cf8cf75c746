"""Triangles of the polygons that mesh files have as faces: concave ones, and those whose outline
touches itself to go around a hole. Convex faces are cut into fans, all at once; the others go to
earcut, one by one, in the plane of the face.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from omma.base.arrays import Floats, Ints
from omma.base.optional import needs

# Of an area, what rounding of corners on one line leaves.
_ROUNDING = 1e-9
# How far the area of the triangles may be off that of the outline: faces that are not quite plane
# are cut as seen along their normal.
_SAME_AREA = 1e-3


class Triangles(NamedTuple):
    """What faces were cut into."""

    corners: Ints  # (T, 3), which of all corners of all faces
    face: Ints  # (T,), of which face
    crossed: int  # how many faces cross themselves, so that there is no one way to fill them


def triangulate(positions: Floats, corners: Ints, counts: Ints) -> Triangles:
    """Cut faces into triangles.

    Args:
        positions: (V, 3), of vertices.
        corners: (C,), the vertex of each corner, the corners of a face one after the other.
        counts: (F,), how many corners a face has. Those with fewer than three make no triangle.
    """
    starts = np.cumsum(counts) - counts
    found: list[tuple[Ints, Ints]] = []
    crossed = 0
    for count in np.unique(counts[counts >= 3]).tolist():
        faces = np.flatnonzero(counts == count)
        own = starts[faces, None] + np.arange(count)
        if count == 3:
            found.append((own, faces))
            continue
        points = positions[corners[own]]
        points -= points[:, :1].copy()
        # Newell: the sum of all triangles with one corner. Its length is twice the area.
        across = np.cross(points[:, 1:-1], points[:, 2:])
        normal = across.sum(axis=1)
        waiting = np.arange(len(faces))
        # A quadrangle with one corner that points inwards is a fan about that or the next one.
        for first in (0, 1) if count == 4 else (0,):
            turned = np.roll(points[waiting], -first, axis=1)
            turned -= turned[:, :1].copy()
            fans = np.cross(turned[:, 1:-1], turned[:, 2:])
            signed = np.einsum("ftx,fx->ft", fans, normal[waiting])
            size = np.einsum("fx,fx->f", normal[waiting], normal[waiting])
            is_fan = (signed >= -_ROUNDING * size[:, None]).all(axis=1) & (size > 0)
            fanned = waiting[is_fan]
            found.append(_fans(np.roll(own[fanned], -first, axis=1), faces[fanned]))
            waiting = waiting[~is_fan]
        for i in waiting.tolist():
            cut, is_whole = _cut(points[i], normal[i])
            crossed += not is_whole
            found.append((own[i][cut], np.full(len(cut), faces[i])))
    if not found:
        return Triangles(np.zeros((0, 3), np.int64), np.zeros(0, np.int64), 0)
    triangles = np.concatenate([one for one, _ in found])
    face = np.concatenate([one for _, one in found])
    order = np.argsort(face, kind="stable")
    return Triangles(triangles[order], face[order], crossed)


def _fans(own: Ints, faces: Ints) -> tuple[Ints, Ints]:
    count = own.shape[1]
    triangles = np.stack(
        [np.broadcast_to(own[:, :1], (len(own), count - 2)), own[:, 1:-1], own[:, 2:]], axis=-1
    )
    return triangles.reshape(-1, 3), np.repeat(faces, count - 2)


def _cut(points: Floats, normal: Floats) -> tuple[Ints, bool]:
    """Triangles (T, 3) of the corners of one face, and whether they fill its outline exactly."""
    told = "faces of more than four corners need mapbox_earcut"
    triangulate_float64 = needs("mapbox_earcut", "meshes", told).triangulate_float64
    double_area = float(np.linalg.norm(normal))
    if not 0 < double_area < np.inf:
        # No area: all in one line, or a bow of two equal halves.
        return np.zeros((0, 3), np.int64), not np.cross(points[1:-1], points[2:]).any()
    # Two axes in the plane, so that a turn to the left there goes around the normal.
    axis = normal / double_area
    right = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    right /= np.linalg.norm(right)
    flat = points @ np.stack([right, np.cross(axis, right)], axis=1)
    cut = triangulate_float64(flat, np.array([len(flat)], np.uint32)).astype(np.int64)
    triangles = cut.reshape(-1, 3)
    a, b, c = (flat[triangles[:, i]] for i in range(3))
    signed = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[signed < 0] = triangles[signed < 0][:, ::-1]
    return triangles, abs(np.abs(signed).sum() - double_area) <= _SAME_AREA * double_area
