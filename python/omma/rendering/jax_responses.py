"""Responses as a function of arrays of JAX, with derivatives. Needs JAX; it is asked for when the
function is called."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from omma._core import Error
from omma.base.arguments import checked
from omma.base.arrays import Floats
from omma.base.optional import needs
from omma.rendering.call import Responses, poses_of
from omma.rendering.differentiable import (
    expect_no_gradient,
    expect_parameters,
    jacobian_at,
    parameters_of,
)
from omma.rendering.gaussian_scores import Parameter
from omma.rendering.gradients import ALONG, expect_differentiable, expect_first_pose
from omma.rendering.renderer import Renderer


@checked
def jax_responses(
    renderer: Renderer,
    poses: Any,
    *,
    acceptance_angle_rad: Any = None,
    axis: Any = None,
    rotation_rad: Any = None,
    first_pose: Any = 0,
    **others: Any,
) -> Any:
    """Responses of an eye that arrays of JAX describe, whose derivatives by them JAX knows: an
    array (P, N, C), float32.

    Values are those of `Renderer.jacobian`: eight independent estimates, unbiased, and so are the
    derivatives. Only those that are asked for are worked out, by the rays of one render, for
    `jax.grad` as for `jax.jvp`, `jax.jacrev` and `jax.jacfwd`; there are no second ones. Under
    `jax.jit` rays are traced whenever the compiled function runs (`jax.pure_callback`). `jax.vmap`
    renders one after another (its method ``sequential``), to the numbers of calls one by one, with
    the same rays for each: many poses at once are better given as P poses.

    Args:
        renderer: whose world, sampling (`omma.Fixed`) and remaining eye are taken.
        poses: as in `Renderer.render`, in double precision; or an array of JAX (4, 4) or (P, 4, 4)
            that a transformed function is given, in its own precision. They have no gradients.
        acceptance_angle_rad: (N,), full widths at half maximum, above 0. None: those of the eye.
        axis: (N, 3), of any length, in the head's frame. None: those of the eye.
        rotation_rad: (P, 3): a turn of each head, as a rotation vector in the world, before which
            the poses are. None: none.
        first_pose: another number takes other rays; may be an array of JAX, so that a compiled
            function takes others each time.
        others: nothing; by other names there are no gradients.

    Raises:
        omma.Error: JAX is not installed, poses that derivatives are asked by, second derivatives,
            another parameter, an array of another shape, a world, rays or an eye that
            `Renderer.jacobian` refuses. Values that are no eye's are found while JAX calls back:
            an error of JAX, which has the message.
    """
    jax = needs("jax", "jax", "responses as arrays of JAX need it")
    expect_parameters(others)
    expect_differentiable(renderer, own_widths=acceptance_angle_rad is None)
    operands: dict[str, Any] = {"poses": _poses_for(jax, renderer, poses)}
    count = len(operands["poses"])
    operands["first_pose"] = _first_pose_for(jax, first_pose, count)
    given: dict[Parameter, Any] = {
        "acceptance_angle_rad": acceptance_angle_rad,
        "axis": axis,
        "rotation_rad": rotation_rad,
    }
    arrays = parameters_of(
        renderer, count, given, lambda value: _is_real(jax, value), "an array of real numbers"
    )
    operands |= {name: jax.numpy.asarray(value) for name, value in arrays.items()}
    return _function_of(jax, renderer)(operands)


def _poses_for(jax: Any, renderer: Renderer, poses: Any) -> Any:
    """(P, 4, 4) of JAX's, where a transformed function is given them; else the bytes of doubles, of
    which JAX has none by default: uint32 (P, 4, 4, 2)."""
    if not isinstance(poses, jax.core.Tracer):
        matrices = np.ascontiguousarray(poses_of(renderer, poses))
        return matrices.view(np.uint32).reshape(-1, 4, 4, 2)
    if poses.shape[-2:] != (4, 4) or poses.ndim not in (2, 3):
        raise Error(f"poses: expected shape (4, 4) or (P, 4, 4), found {tuple(poses.shape)}")
    return poses.reshape(-1, 4, 4)


def _first_pose_for(jax: Any, first_pose: Any, poses: int) -> Any:
    """A whole number of JAX's, where a transformed function is given it; else its bytes, uint32
    (2,)."""
    if not isinstance(first_pose, jax.core.Tracer):
        number = expect_first_pose(first_pose, poses)
        return np.array([number], np.uint64).view(np.uint32)
    if first_pose.shape != () or not jax.numpy.issubdtype(first_pose.dtype, np.integer):
        raise Error(
            "first_pose: expected a whole number, by which there are no derivatives, found "
            f"{first_pose.dtype} of shape {tuple(first_pose.shape)}"
        )
    return first_pose


def _is_real(jax: Any, value: Any) -> bool:
    """Whether it is an array of numbers; JAX's kinds of floats are more than NumPy's."""
    kinds = (jax.numpy.floating, np.integer)
    return hasattr(value, "dtype") and any(jax.numpy.issubdtype(value.dtype, k) for k in kinds)


def _function_of(jax: Any, renderer: Renderer) -> Any:
    """A function of operands by name, which has derivatives by those that are parameters."""
    size = (len(renderer.eye), renderer.bands)

    @partial(jax.custom_jvp, nondiff_argnums=(0,))
    def called(asked: tuple[Parameter, ...], operands: Mapping[str, Any]) -> Any:
        shape = (len(operands["poses"]), *size)
        per_axis = {"acceptance_angle_rad": ()}
        shapes = [shape, *((*shape, *per_axis.get(name, (3,))) for name in asked)]
        return jax.pure_callback(
            _Host(renderer, asked),
            [jax.ShapeDtypeStruct(shape, np.float32) for shape in shapes],
            dict(operands),
            vmap_method="sequential",
        )

    @called.defjvp  # type: ignore[untyped-decorator]
    def again(*_: Any) -> Any:
        raise Error("responses: they have first derivatives, second ones were asked for")

    @jax.custom_jvp  # type: ignore[untyped-decorator]
    def responses(operands: Mapping[str, Any]) -> Any:
        return called((), operands)[0]

    def along(primals: tuple[Any], tangents: tuple[Any]) -> tuple[Any, Any]:
        (operands,), (changes,) = primals, tangents
        zero = jax.custom_derivatives.SymbolicZero
        asked = tuple(name for name in operands if not isinstance(changes[name], zero))
        expect_no_gradient("poses" in asked)
        found, *slopes = called(asked, operands)
        change = jax.numpy.zeros_like(found)
        for name, slope in zip(asked, slopes, strict=True):
            change += jax.numpy.einsum(
                ALONG[name], slope, changes[name].astype(np.float32), precision="highest"
            )
        return found, change

    responses.defjvp(along, symbolic_zeros=True)
    return responses


@dataclass(frozen=True)
class _Host:
    """What JAX calls back: responses, and derivatives that are asked for. Equal ones are compiled
    once."""

    renderer: Renderer
    asked: tuple[Parameter, ...]

    def __call__(self, operands: Mapping[str, Any]) -> list[Responses]:
        arrays = {name: np.asarray(value) for name, value in operands.items()}
        poses, first_pose = arrays.pop("poses"), arrays.pop("first_pose")
        if poses.ndim == 4:
            poses = poses.view(np.float64)[..., 0]
        if first_pose.ndim == 1:
            first_pose = first_pose.view(np.uint64)[0]
        values: dict[Any, Floats] = {
            name: value.astype(np.float64) for name, value in arrays.items()
        }
        found = jacobian_at(self.renderer, poses, values, self.asked, int(first_pose))
        return [
            found.responses,
            *(found.values[name].astype(np.float32) for name in self.asked),
        ]
