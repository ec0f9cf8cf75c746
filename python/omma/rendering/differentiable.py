"""Responses as functions of arrays of other libraries that know gradients: what PyTorch's tensors
and JAX's arrays have in common. Which parameters there are and of what shape, and the Jacobian by
them: by axes of any length, and by rotation vectors that are not 0."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from omma._core import Error
from omma.base.arrays import Floats
from omma.rendering.call import Poses, poses_of
from omma.rendering.gaussian_scores import PARAMETERS, Parameter
from omma.rendering.gradients import Jacobian
from omma.rendering.renderer import Renderer


def expect_no_gradient(asked: bool) -> None:
    """Error where poses ask for gradients."""
    if asked:
        raise Error(
            "poses: expected poses without gradients: where a head is has none here; rotation_rad "
            "turns it"
        )


def expect_parameters(others: Mapping[str, Any]) -> None:
    """Error where a function is given something by a name that responses have no gradients by."""
    for name in others:
        raise Error(
            f"{name}: responses have no gradients by it; expected one of {', '.join(PARAMETERS)} "
            "(positions, numbers of rays and colours have none here)"
        )


def parameters_of(
    renderer: Renderer,
    pose_count: int,
    given: Mapping[Parameter, Any],
    is_array: Callable[[Any], bool],
    called: str,
) -> dict[Parameter, Any]:
    """Those that are given.

    Args:
        pose_count: P of ``rotation_rad``.
        given: by name; None: not given.
        is_array: whether a value is of the library.
        called: what messages call such a value: "a tensor of real numbers".

    Raises:
        omma.Error: another thing, another shape.
    """
    size: dict[Parameter, tuple[int, ...]] = {
        "acceptance_angle_rad": (len(renderer.eye),),
        "axis": (len(renderer.eye), 3),
        "rotation_rad": (pose_count, 3),
    }
    arrays = {name: value for name, value in given.items() if value is not None}
    for name, array in arrays.items():
        if not is_array(array) or tuple(array.shape) != size[name]:
            found = type(array).__name__
            if hasattr(array, "shape") and hasattr(array, "dtype"):
                found = f"{found} of shape {tuple(array.shape)}, {array.dtype}"
            raise Error(f"{name}: expected {called} of shape {size[name]}, found {found}")
    return arrays


def jacobian_at(
    renderer: Renderer,
    poses: Poses,
    values: Mapping[Parameter, Floats],
    asked: Sequence[Parameter],
    first_pose: int,
) -> Jacobian:
    """Responses of the eye and the heads that these values make, and their derivatives by those
    values that are asked for; without errors.

    Args:
        values: by parameter: acceptance angles (N,), axes (N, 3) of any length, rotation vectors
            (P, 3), by which the heads are turned.
        asked: some of the values' names.
    """
    changes = {name: value for name, value in values.items() if name != "rotation_rad"}
    matrices = poses_of(renderer, poses).copy()
    if "rotation_rad" in values:
        from scipy.spatial.transform import Rotation

        turns = Rotation.from_rotvec(values["rotation_rad"]).as_matrix()
        matrices[:, :3, :3] = turns @ matrices[:, :3, :3]
    if changes:
        renderer = renderer.with_eye(renderer.eye.replace(**changes))
    found = renderer.jacobian(matrices, by=tuple(asked), first_pose=first_pose)
    by_values = {name: _by_value(name, found.values[name], values[name]) for name in asked}
    return Jacobian(found.responses, by_values, {})


def _by_value(name: Parameter, slope: Floats, value: Floats) -> Floats:
    """Derivatives by a value, of those by what it makes of an eye."""
    by_value = slope
    if name == "axis":  # whose length does not matter
        by_value = slope / np.linalg.norm(value, axis=1)[:, None, None]
    elif name == "rotation_rad":
        by_value = np.einsum("pncj,pji->pnci", slope, turn_per_vector(value))
    return by_value


def turn_per_vector(vectors: Floats) -> Floats:
    """(P, 3, 3): by how much a rotation turns, in the world, as its rotation vector changes: the
    left Jacobian of SO(3) (Solà et al. 2018, arXiv:1812.01537, eq. 145)."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    cross = np.zeros((len(vectors), 3, 3))
    for (i, j), k, sign in (((0, 1), 2, -1), ((0, 2), 1, 1), ((1, 2), 0, -1)):
        cross[:, i, j], cross[:, j, i] = sign * vectors[:, k], -sign * vectors[:, k]
    # (1 − cos x)/x² and (x − sin x)/x³, which near 0 are 1/2 and 1/6.
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 0.5, (1 - np.cos(safe)) / safe**2)
    second = np.where(small, 1 / 6, (safe - np.sin(safe)) / safe**3)
    return np.eye(3) + first * cross + second * cross @ cross
