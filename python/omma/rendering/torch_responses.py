"""Responses as a function of tensors of PyTorch, with gradients. Needs PyTorch; it is asked for
when the function is called."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np

from omma._core import Error
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

F = TypeVar("F", bound=Callable[..., Any])


def _without_compiling(function: F) -> F:
    """The same function, at which `torch.compile` breaks its graph: it is called, not traced."""

    @functools.wraps(function)
    def outside(*arguments: Any, **named: Any) -> Any:
        # PyTorch loads what compiles, for seconds, where something is compiled.
        torch = sys.modules["torch"] if "torch._dynamo" in sys.modules else None
        call = function if torch is None else torch.compiler.disable(function)
        return call(*arguments, **named)

    return cast(F, outside)


@_without_compiling
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
    Gradients of gradients are refused, as of gradient penalties, Hessians and
    `torch.autograd.functional.jvp`; what goes forwards is by PyTorch, as are transforms of
    `torch.func`. `torch.autograd.functional.jacobian` and `vjp` work. `torch.compile` breaks its
    graph here: what is before and after is compiled, this is called.

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
        omma.Error: PyTorch is not installed, poses that ask for gradients, gradients of gradients,
            another parameter, a tensor of another shape, of complex numbers or without any, values
            that are no eye's, or what `Renderer.jacobian` raises.
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
        lambda value: _is_real(torch, value),
        "a tensor of real numbers",
    )
    for name, tensor in tensors.items():
        if tensor.is_meta or tensor.layout != torch.strided:
            raise Error(
                f"{name}: expected a tensor with all of its numbers in memory, found one of "
                f"{tensor.layout} on the device {tensor.device}"
            )
    function = _function_of(torch, renderer, poses, tuple(tensors), first_pose)
    return function.apply(*tensors.values())


def _is_real(torch: Any, value: Any) -> bool:
    """Whether it is a tensor of real numbers."""
    if not isinstance(value, torch.Tensor):
        return False
    return bool(value.is_floating_point() or value.dtype in (torch.int32, torch.int64))


def _function_of(
    torch: Any, renderer: Renderer, poses: Poses, names: tuple[Parameter, ...], first_pose: int
) -> Any:
    """A function of tensors with these names."""

    class Gradients(torch.autograd.Function):  # type: ignore[misc]
        """By the parameters. A function too, and of all that they depend on, so that whoever asks
        for gradients of gradients comes upon it, whatever the cotangent depends on."""

        @staticmethod
        def forward(_: Any, of: Any, cotangent: Any, *__: Any) -> tuple[Any, ...]:
            gradients = of.found.vjp(cotangent.detach().cpu().numpy())
            return tuple(
                torch.from_numpy(gradients[name]).to(tensor.device, tensor.dtype)
                if name in gradients
                else None
                for name, tensor in zip(names, of.tensors, strict=True)
            )

        @staticmethod
        def backward(*_: Any) -> Any:
            raise Error("responses: they have first derivatives, second ones were asked for")

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
            # Not by save_for_backward: what they hold may change, as it is not read again.
            context.tensors = tensors
            return torch.from_numpy(context.found.responses.astype(np.float64))

        @staticmethod
        def backward(context: Any, cotangent: Any) -> Any:
            return Gradients.apply(context, cotangent, *context.tensors)

    return Responses
