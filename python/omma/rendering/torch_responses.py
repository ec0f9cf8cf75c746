"""Responses as a function of tensors of PyTorch, with gradients. Needs PyTorch; it is asked for
when the function is called."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arguments import checked
from omma.base.optional import needs
from omma.rendering.call import Poses, poses_of
from omma.rendering.gradients import Jacobian, Parameter
from omma.rendering.renderer import Renderer

Floats = NDArray[np.float64]


@checked
def torch_responses(
    renderer: Renderer,
    poses: Poses,
    *,
    acceptance_angle_rad: Any = None,
    axis: Any = None,
    rotation_rad: Any = None,
    first_pose: int = 0,
) -> Any:
    """Responses of an eye that tensors of PyTorch describe, whose gradients by them PyTorch knows:
    a tensor (P, N, C), float64, in the memory of the processor.

    Values are those of `Renderer.jacobian`: eight independent estimates, unbiased, and so are the
    gradients. Only gradients that a tensor asks for are worked out; without any it is a render.

    Args:
        renderer: whose world, sampling (`omma.Fixed`) and remaining eye are taken.
        poses: as in `Renderer.render`; they are no tensors that ask for gradients.
        acceptance_angle_rad: (N,), full widths at half maximum, above 0. None: those of the eye.
        axis: (N, 3), of any length, in the head's frame. None: those of the eye.
        rotation_rad: (P, 3): a turn of each head, as a rotation vector in the world, before which
            the poses are. None: none.
        first_pose: another number takes other rays.

    Raises:
        omma.Error: PyTorch is not installed, poses that ask for gradients, a tensor of another
            shape, values that are no eye's, or what `Renderer.jacobian` raises.
    """
    torch = needs("torch", "", "responses as tensors need PyTorch")
    if getattr(poses, "requires_grad", False):
        raise Error(
            "poses: expected poses without gradients: where a head is has none here; rotation_rad "
            "turns it"
        )
    given: dict[Parameter, Any] = {
        "acceptance_angle_rad": acceptance_angle_rad,
        "axis": axis,
        "rotation_rad": rotation_rad,
    }
    size: dict[Parameter, tuple[int, ...]] = {
        "acceptance_angle_rad": (len(renderer.eye),),
        "axis": (len(renderer.eye), 3),
        "rotation_rad": (len(poses_of(renderer, poses)), 3),
    }
    tensors = {name: value for name, value in given.items() if value is not None}
    for name, tensor in tensors.items():
        if not isinstance(tensor, torch.Tensor) or tuple(tensor.shape) != size[name]:
            found = tuple(tensor.shape) if hasattr(tensor, "shape") else type(tensor).__name__
            raise Error(f"{name}: expected a tensor of shape {size[name]}, found {found}")
    names = tuple(tensors)
    function = _function_of(torch, renderer, poses, names, first_pose)
    return function.apply(*tensors.values())


def _function_of(
    torch: Any, renderer: Renderer, poses: Poses, names: tuple[Parameter, ...], first_pose: int
) -> Any:
    """A function of tensors with these names."""

    class Responses(torch.autograd.Function):  # type: ignore[misc]
        @staticmethod
        def forward(context: Any, *tensors: Any) -> Any:
            values = {
                name: tensor.detach().cpu().double().numpy()
                for name, tensor in zip(names, tensors, strict=True)
            }
            asked = [
                name for name, needed in zip(names, context.needs_input_grad, strict=True) if needed
            ]
            found = _jacobian_at(renderer, poses, values, asked, first_pose)
            context.found, context.values = found, values
            context.places = {
                name: (tensor.device, tensor.dtype)
                for name, tensor in zip(names, tensors, strict=True)
            }
            return torch.from_numpy(found.responses.astype(np.float64))

        @staticmethod
        def backward(context: Any, cotangent: Any) -> tuple[Any, ...]:
            gradients = context.found.vjp(cotangent.detach().cpu().numpy())
            return tuple(
                torch.from_numpy(_by_value(name, gradients[name], context.values[name])).to(
                    *context.places[name]
                )
                if name in gradients
                else None
                for name in names
            )

    return Responses


def _jacobian_at(
    renderer: Renderer,
    poses: Poses,
    values: dict[Parameter, Floats],
    asked: list[Parameter],
    first_pose: int,
) -> Jacobian:
    changes = {name: value for name, value in values.items() if name != "rotation_rad"}
    matrices = poses_of(renderer, poses).copy()
    if "rotation_rad" in values:
        from scipy.spatial.transform import Rotation

        turns = Rotation.from_rotvec(values["rotation_rad"]).as_matrix()
        matrices[:, :3, :3] = turns @ matrices[:, :3, :3]
    if changes:
        renderer = renderer.with_eye(renderer.eye.replace(**changes))
    return renderer.jacobian(matrices, by=asked, first_pose=first_pose)


def _by_value(name: Parameter, gradient: Floats, value: Floats) -> Floats:
    """Gradients by a tensor, of those by what it makes of an eye."""
    by_value = gradient
    if name == "axis":  # whose length does not matter
        by_value = gradient / np.linalg.norm(value, axis=1, keepdims=True)
    elif name == "rotation_rad":
        by_value = np.einsum("pij,pi->pj", _turn_per_vector(value), gradient)
    return by_value


def _turn_per_vector(vectors: Floats) -> Floats:
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
