"""Responses as a function of tensors of PyTorch, with gradients. Needs PyTorch; it is asked for
when the function is called."""

from __future__ import annotations

from typing import Any

import numpy as np

from omma.base.arguments import checked
from omma.base.optional import needs
from omma.rendering.call import Poses, poses_of
from omma.rendering.differentiable import (
    expect_no_gradient,
    expect_parameters,
    jacobian_at,
    parameters_of,
)
from omma.rendering.gaussian_scores import Parameter
from omma.rendering.renderer import Renderer


@checked
def torch_responses(
    renderer: Renderer,
    poses: Poses,
    *,
    acceptance_angle_rad: Any = None,
    axis: Any = None,
    rotation_rad: Any = None,
    first_pose: int = 0,
    **others: Any,
) -> Any:
    """Responses of an eye that tensors of PyTorch describe, whose gradients by them PyTorch knows:
    a tensor (P, N, C), float64, in the memory of the processor.

    Values are those of `Renderer.jacobian`: eight independent estimates, unbiased, and so are the
    gradients. Only gradients that a tensor asks for are worked out; without any it is a render.
    Gradients of gradients are refused (a RuntimeError of PyTorch), as in gradient penalties, and
    transforms of `torch.func` are: `torch.autograd.functional.jacobian` works.

    Args:
        renderer: whose world, sampling (`omma.Fixed`) and remaining eye are taken.
        poses: as in `Renderer.render`; they are no tensors that ask for gradients.
        acceptance_angle_rad: (N,), full widths at half maximum, above 0. None: those of the eye.
        axis: (N, 3), of any length, in the head's frame. None: those of the eye.
        rotation_rad: (P, 3): a turn of each head, as a rotation vector in the world, before which
            the poses are. None: none.
        first_pose: another number takes other rays.
        others: nothing; by other names there are no gradients.

    Raises:
        omma.Error: PyTorch is not installed, poses that ask for gradients, another parameter, a
            tensor of another shape, values that are no eye's, or what `Renderer.jacobian` raises.
    """
    torch = needs("torch", "torch", "responses as tensors need PyTorch")
    expect_parameters(others)
    expect_no_gradient(getattr(poses, "requires_grad", False))
    given: dict[Parameter, Any] = {
        "acceptance_angle_rad": acceptance_angle_rad,
        "axis": axis,
        "rotation_rad": rotation_rad,
    }
    tensors = parameters_of(
        renderer,
        len(poses_of(renderer, poses)),
        given,
        lambda value: isinstance(value, torch.Tensor),
        "a tensor",
    )
    function = _function_of(torch, renderer, poses, tuple(tensors), first_pose)
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
            context.found = jacobian_at(renderer, poses, values, asked, first_pose)
            context.places = {
                name: (tensor.device, tensor.dtype)
                for name, tensor in zip(names, tensors, strict=True)
            }
            return torch.from_numpy(context.found.responses.astype(np.float64))

        # Gradients of gradients would have to know second derivatives: PyTorch refuses them.
        @staticmethod
        @torch.autograd.function.once_differentiable  # type: ignore[untyped-decorator]
        def backward(context: Any, cotangent: Any) -> tuple[Any, ...]:
            gradients = context.found.vjp(cotangent.detach().cpu().numpy())
            return tuple(
                torch.from_numpy(gradients[name]).to(*context.places[name])
                if name in gradients
                else None
                for name in names
            )

    return Responses
