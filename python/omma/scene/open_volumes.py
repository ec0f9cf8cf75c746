"""Glass with a thickness on a mesh that bounds no volume, such as a single pane: told where it is
lit.

What the triangles of a closed surface are as vectors, area times normal, adds up to nothing. What
is left of an open one is the area of the lid that it lacks. The surface of water is open below: its
sum points up, and what lies in the water is the scene's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Scene
from omma.base.arrays import Floats
from omma.base.warn import warn_caller
from omma.scene.lighting import Lighting

# The sum of the vectors as a share of the area: above single precision and seams that do not meet.
_OPEN = 0.1
# Cosine of the sum to straight up: waters lie within 60 degrees, with the walls of a basin too.
_LIES = 0.5


def tell_of_open_volumes(scene: Scene, lighting: Lighting | None) -> None:
    """Warns of materials whose light goes into a volume and never comes out of it."""
    if lighting is None:
        return
    for number, material in enumerate(scene.materials):
        if material.thickness_m > 0 and material.transmission > 0 and _is_open(scene, number):
            warn_caller(
                f'material "{material.name}": thickness_m above 0 says that its surface bounds a '
                "volume, but it is open at the back, so that all behind it counts as within: "
                "expected a closed mesh, such as a block, or thickness_m=0, a thin pane "
                "(docs/materials.md)",
                UserWarning,
            )


def _is_open(scene: Scene, material: int) -> bool:
    """Whether what has the material lacks a side, and is no water; its meshes may be the sides of
    one block."""
    lacking = []
    for one in scene.instances:
        mesh = scene.meshes[one.mesh]
        if mesh.material != material:
            continue
        areas = _areas(mesh.positions_m, mesh.triangles, one.world_from_mesh)
        total = areas.sum(axis=0)
        if np.linalg.norm(total) > _OPEN * np.linalg.norm(areas, axis=1).sum():
            lacking.append(total)
    if not lacking:
        return False
    total = np.sum(lacking, axis=0)
    size = np.linalg.norm(total)
    lacks = size > _OPEN * np.linalg.norm(lacking, axis=1).sum()
    return bool(lacks and total[1] < _LIES * size)


def _areas(positions_m: ArrayLike, triangles: ArrayLike, world_from_mesh: ArrayLike) -> Floats:
    """Twice the area times the normal of the front of each triangle, (T, 3)."""
    matrix = np.asarray(world_from_mesh, np.float64)[:3, :3]
    corners = (np.asarray(positions_m, np.float64) @ matrix.T)[np.asarray(triangles)]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # glTF: a mirrored mesh turns its triangles round.
    return np.asarray(across * np.sign(np.linalg.det(matrix)))
