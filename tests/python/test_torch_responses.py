"""Responses as functions of PyTorch's tensors, whose gradients are those of `Renderer.vjp`."""

from __future__ import annotations

import numpy as np
import pytest

import omma

torch = pytest.importorskip("torch")

POSES = omma.poses_from_angles(np.zeros((2, 3)), [(0, 0, 0), (25, 10, 0)])


def renderer_of(samples=64):
    eye = omma.eye.generate_eye(30)
    return omma.Renderer(omma.load_scene(omma.examples.meadow()), eye, omma.Fixed(samples))


def test_gradients_are_those_of_vjp():
    renderer = renderer_of()
    width = torch.tensor(renderer.eye.acceptance_angle_rad.astype(float), requires_grad=True)
    axis = torch.tensor(2.0 * renderer.eye.axis.astype(float), requires_grad=True)
    turn = torch.zeros((2, 3), dtype=torch.float64, requires_grad=True)
    found = omma.rendering.torch_responses(
        renderer, POSES, acceptance_angle_rad=width, axis=axis, rotation_rad=turn
    )
    weights = torch.tensor(np.random.default_rng(1).normal(size=(2, 30, 3)))
    (found * weights).sum().backward()
    responses, gradient = renderer.vjp(POSES, weights.numpy())
    assert found.detach().numpy() == pytest.approx(responses, rel=1e-4, abs=1e-4)
    assert width.grad.numpy() == pytest.approx(gradient["acceptance_angle_rad"], rel=1e-3, abs=1e-2)
    assert axis.grad.numpy() == pytest.approx(gradient["axis"] / 2, rel=1e-3, abs=1e-2)
    assert turn.grad.numpy() == pytest.approx(gradient["rotation_rad"], rel=1e-3, abs=1e-2)


def test_only_what_asks_for_gradients_has_them():
    renderer = renderer_of(16)
    width = torch.full((30,), 0.05, dtype=torch.float32, requires_grad=True)
    axis = torch.tensor(renderer.eye.axis)
    found = omma.rendering.torch_responses(
        renderer, POSES[:1], acceptance_angle_rad=width, axis=axis
    )
    found.mean().backward()
    assert axis.grad is None
    assert width.grad.dtype == torch.float32
    assert np.isfinite(width.grad.numpy()).all()
    plain = omma.rendering.torch_responses(renderer, POSES[:1])
    assert plain.dtype == torch.float64
    assert not plain.requires_grad


def test_an_eye_finds_back_how_it_was_turned():
    """Gradient descent on the difference between two frames finds the turn between them."""
    renderer = renderer_of(256)
    true = np.array([[0.0, 0.03, 0.0]])
    with torch.no_grad():
        seen = omma.rendering.torch_responses(
            renderer, POSES[:1], rotation_rad=torch.tensor(true), first_pose=7
        )
    turn = torch.zeros((1, 3), dtype=torch.float64, requires_grad=True)
    optimizer = torch.optim.Adam([turn], lr=0.005)
    for step in range(40):
        optimizer.zero_grad()
        now = omma.rendering.torch_responses(
            renderer, POSES[:1], rotation_rad=turn, first_pose=100 + step
        )
        ((now - seen) ** 2).sum().backward()
        optimizer.step()
    assert np.abs(turn.detach().numpy() - true).max() < 0.01


def test_gradients_of_gradients_are_refused():
    """They were silently zero, also where the gradient of the responses depends on nothing."""
    renderer = renderer_of(16)
    width = torch.full((30,), 0.05, dtype=torch.float64, requires_grad=True)
    weights = torch.ones((30, 3), dtype=torch.float64, requires_grad=True)

    def seen(width):
        return omma.rendering.torch_responses(renderer, POSES[:1], acceptance_angle_rad=width)

    def penalty(number):
        (gradient,) = torch.autograd.grad(number, width, create_graph=True)
        (gradient**2).sum().backward()

    functional, along = torch.autograd.functional, torch.ones_like(width)
    for call in (
        lambda: penalty((weights * seen(width)[0]).sum()),
        lambda: penalty(seen(width).sum()),
        lambda: functional.hessian(lambda width: (seen(width) ** 2).sum(), width),
        lambda: functional.hessian(lambda width: seen(width).sum(), width),
        lambda: functional.hvp(lambda width: seen(width).sum(), width, along),
        lambda: functional.vhp(lambda width: seen(width).sum(), width, along),
        lambda: functional.jvp(seen, width, along),
    ):
        with pytest.raises(omma.Error, match="second ones"):
            call()
    # First ones are there, with a graph that nobody uses as well.
    (gradient,) = torch.autograd.grad(seen(width).sum(), width, create_graph=True)
    (plain,) = torch.autograd.grad(seen(width).sum(), width)
    assert torch.equal(gradient, plain)
    assert torch.equal(functional.vjp(lambda width: seen(width).sum(), width)[1], plain)
    assert torch.equal(functional.jacobian(lambda width: seen(width).sum(), width), plain)


def test_a_function_that_is_compiled_has_the_same_bits():
    """The graph breaks there; what compiles had taken poses for tensors."""
    renderer = renderer_of(16)

    def loss(width):
        return (
            omma.rendering.torch_responses(renderer, POSES, acceptance_angle_rad=2 * width) ** 2
        ).sum()

    found = []
    for function in (loss, torch.compile(loss, backend="eager")):
        width = torch.full((30,), 0.05, dtype=torch.float64, requires_grad=True)
        value = function(width)
        value.backward()
        found.append((value.detach(), width.grad))
    assert torch.equal(found[0][0], found[1][0])
    assert torch.equal(found[0][1], found[1][1])


def test_what_is_no_tensor_of_an_eye_is_refused():
    renderer = renderer_of(16)
    for wrong, message in (
        ({"axis": torch.zeros((3, 3))}, "axis: expected a tensor of real numbers of shape"),
        ({"rotation_rad": np.zeros((2, 3))}, "rotation_rad: expected a tensor"),
        ({"acceptance_angle_rad": torch.full((30,), -1.0)}, "acceptance"),
        ({"rotation_rad": torch.zeros((2, 3), dtype=torch.complex64)}, "found .* torch.complex64"),
        ({"rotation_rad": torch.zeros((2, 3), dtype=torch.bool)}, "found .* torch.bool"),
        (
            {"rotation_rad": torch.zeros((2, 3), device="meta")},
            "found one of torch.strided on the device meta",
        ),
        ({"rotation_rad": torch.zeros((2, 3)).to_sparse()}, "found one of torch.sparse_coo"),
    ):
        with pytest.raises(omma.Error, match=message):
            omma.rendering.torch_responses(renderer, POSES, **wrong)
    with pytest.raises(omma.Error, match="position_m: responses have no gradients by it"):
        omma.rendering.torch_responses(renderer, POSES, position_m=torch.zeros((30, 3)))
    with pytest.raises(omma.Error, match="rotation_rad"):
        omma.rendering.torch_responses(renderer, torch.tensor(POSES, requires_grad=True))
