"""Skins: meshes whose vertices follow bodies, each with a share of several."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats
from omma.mujoco.models import mujoco_module


def skin_triangles(model: Any, skin: int) -> NDArray[np.int64]:
    """(T, 3)."""
    first, count = int(model.skin_faceadr[skin]), int(model.skin_facenum[skin])
    return np.asarray(model.skin_face[first : first + count], np.int64)


def skin_coordinates(model: Any, skin: int) -> Floats | None:
    """Texture coordinates (V, 2), where it has some."""
    first = int(model.skin_texcoordadr[skin])
    if first < 0:
        return None
    count = int(model.skin_vertnum[skin])
    return np.asarray(model.skin_texcoord[first : first + count], float)


def skin_vertices(data: Any, skin: int) -> tuple[Floats, Floats]:
    """Vertices of a skin (V, 3) where its bodies are, in the world's frame, and their normals."""
    model = data.model
    mujoco = mujoco_module()
    first, count = int(model.skin_vertadr[skin]), int(model.skin_vertnum[skin])
    rest = np.asarray(model.skin_vert[first : first + count], float)
    found = np.zeros((count, 3))
    bind, turn = np.empty(9), np.empty(9)
    one = int(model.skin_boneadr[skin])
    for bone in range(one, one + int(model.skin_bonenum[skin])):
        at, number = int(model.skin_bonevertadr[bone]), int(model.skin_bonevertnum[bone])
        vertices = model.skin_bonevertid[at : at + number]
        weights = np.asarray(model.skin_bonevertweight[at : at + number], float)
        body = int(model.skin_bonebodyid[bone])
        mujoco.mju_quat2Mat(bind, np.asarray(model.skin_bonebindquat[bone], float))
        turn[:] = data.xmat[body]
        world_from_rest = turn.reshape(3, 3) @ bind.reshape(3, 3).T
        moved = (rest[vertices] - model.skin_bonebindpos[bone]) @ world_from_rest.T
        # Each vertex comes once to a bone.
        found[vertices] += weights[:, None] * (moved + data.xpos[body])
    normals = _normals(found, skin_triangles(model, skin))
    return found + float(model.skin_inflate[skin]) * normals, normals


def _normals(positions: Floats, triangles: NDArray[np.int64]) -> Floats:
    """Of vertices: the mean of their triangles', weighed by area; up where there is none."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    total = np.zeros_like(positions)
    for k in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(triangles[:, k], across[:, axis], len(positions))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 0, total / np.maximum(length, np.finfo(float).tiny), (0.0, 0, 1))
