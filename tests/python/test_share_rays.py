"""Rays shared by neighbouring ommatidia, from Python and the command line."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import omma
from omma.cli.main import app

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENE, EYE = EXAMPLES / "meadow.glb", EXAMPLES / "honeybee_worker_right.eye"


@pytest.fixture(scope="module")
def scene() -> omma.Scene:
    return omma.load_scene(SCENE)


@pytest.fixture(scope="module")
def eye() -> omma.Eye:
    return omma.load_eye(EYE)


@pytest.fixture(scope="module")
def sharing(scene: omma.Scene, eye: omma.Eye) -> omma.Renderer:
    return omma.Renderer(scene, eye, omma.Shared(4))


def test_properties(sharing: omma.Renderer, eye: omma.Eye) -> None:
    assert sharing.settings.sampling == omma.Shared(4)
    assert f"Shared(samples=4) by {np.count_nonzero(sharing.shared_ommatidia)}" in repr(sharing)
    assert sharing.shared_ommatidia.shape == (len(eye),)
    assert sharing.shared_ommatidia.dtype == bool
    # All but some at the border of the field.
    assert np.mean(sharing.shared_ommatidia) > 0.97
    # Acceptance angles differ over the eye, and densities come in steps of two.
    assert sharing.rays_per_frame == pytest.approx(4 * len(eye), rel=0.1)
    own = sharing.with_eye(eye, omma.Fixed(4))
    assert own.rays_per_frame == 4 * len(eye)
    assert not own.shared_ommatidia.any()
    assert sharing.with_eye(eye).settings == sharing.settings
    own_auto = own.with_eye(eye, omma.ToError(0.01))
    assert own_auto.rays_per_frame == 8 * len(eye)


def test_error_is_far_below_that_of_own_rays(sharing: omma.Renderer, eye: omma.Eye) -> None:
    pose = "bee"
    exact = sharing.with_eye(eye, omma.Fixed(4096)).render(pose)
    shared = sharing.render(pose)
    own = sharing.with_eye(eye, omma.Fixed(4)).render(pose)

    def rms(responses: np.ndarray) -> float:
        return float(np.sqrt(np.mean((responses - exact) ** 2)))

    assert rms(shared) < rms(own) / 1.8


def test_the_same_rays_at_every_pose(sharing: omma.Renderer) -> None:
    poses = np.tile(np.eye(4), (3, 1, 1))
    responses = sharing.render(poses)
    assert np.array_equal(responses[0], responses[1])
    assert np.array_equal(np.stack(list(sharing.render_iter(poses, chunk=2))), responses)
    assert np.array_equal(sharing.render(poses[:1], first_pose=7), responses[:1])


def test_standard_error(sharing: omma.Renderer, eye: omma.Eye) -> None:
    responses, errors = sharing.render("bee", standard_error=True)
    exact = sharing.with_eye(eye, omma.Fixed(4096)).render("bee")
    # Two standard errors of 8 sets hold 91 % of a normal variable; neighbours go together, what
    # is near the head is seen from elsewhere, and 4,096 rays are not exact either.
    within = np.mean(np.abs(responses - exact) <= 2 * errors + 1e-3)
    assert within > 0.85


def test_own_rays_where_nothing_is_gained(sharing: omma.Renderer, eye: omma.Eye) -> None:
    for angle in (math.radians(0.3), 1e-20):
        alone = eye.replace(acceptance_angle_rad=angle)
        renderer = sharing.with_eye(alone)
        assert not renderer.shared_ommatidia.any()
        assert renderer.rays_per_frame == 4 * len(eye)
        assert np.isfinite(renderer.render("bee")).all()


def test_lenses_alone_are_refused(sharing: omma.Renderer, eye: omma.Eye) -> None:
    airy = omma.Acceptance.airy(25e-6, 500)
    with pytest.raises(omma.Error, match="sampling: Shared, not where all ommatidia have"):
        sharing.with_eye(eye.replace(acceptance=airy))
    mixed = sharing.with_eye(eye.replace(acceptance=[airy, *[None] * (len(eye) - 1)]))
    assert not mixed.shared_ommatidia[0]
    assert mixed.shared_ommatidia.any()


def test_refuses_what_takes_too_much(sharing: omma.Renderer, eye: omma.Eye) -> None:
    with pytest.raises(omma.Error, match=r"fields overlap would count about .* fewer samples"):
        sharing.with_eye(eye.replace(acceptance_angle_rad=2 * math.pi), omma.Shared(64))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"angular_sensitivity": "compoundray"},
            "^sampling: Shared, not with the kernel compoundray",
        ),
        ({"points": "random"}, "^points: expected low_discrepancy where rays are shared"),
        ({"noise": "new_every_frame"}, "^noise: expected frozen where rays are shared"),
    ],
)
def test_refused(
    sharing: omma.Renderer, eye: omma.Eye, settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(omma.Error, match=message):
        omma.Renderer(sharing.scene, eye, omma.Shared(4), **settings)


def test_no_single_rays(sharing: omma.Renderer) -> None:
    with pytest.raises(omma.Error, match=r"expected omma\.Fixed for render_rays"):
        sharing.render_rays(np.eye(4))


def test_command_line(sharing: omma.Renderer, tmp_path: Path) -> None:
    out = tmp_path / "out.npy"
    command = ["render", str(SCENE), "--eye", str(EYE), "--camera", "bee", "-o", str(out)]
    result = CliRunner().invoke(app, [*command, "--shared", "4"])
    assert result.exit_code == 0, result.output
    assert np.array_equal(np.load(out), sharing.render("bee"))
    assert f"{sharing.rays_per_frame:,} (4 per ommatidium and pose)" in result.output


def test_command_line_says_where_it_gains_nothing(tmp_path: Path) -> None:
    eye = tmp_path / "narrow.csv"
    omma.save_eye(eye, omma.load_eye(EYE).replace(acceptance_angle_rad=0.001))
    command = ["render", str(SCENE), "--eye", str(eye), "--shared", "1"]
    result = CliRunner().invoke(app, [*command, "-o", str(tmp_path / "out.npy")])
    assert result.exit_code == 0, result.output
    assert "sampling: 0 of 5,380 ommatidia share rays" in result.output
