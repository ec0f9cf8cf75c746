"""By which weights the rays of a round Gaussian give the derivatives of its response, their scores
∂ ln p / ∂θ (gradients.py).

For a round Gaussian of full width w at half maximum, with the angle ϑ from its axis a, the unit
vector s that points from a to the ray, and Z(w) = ∫ exp(−4 ln 2 ϑ²/w²) sin ϑ dϑ,

    ∂ ln p / ∂w = 8 ln 2 ϑ²/w³ − Z'/Z,    ∂ ln p / ∂a = 8 ln 2 ϑ/w² s.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from omma.base.arrays import Floats
from omma.base.directions import normalized

Parameter = Literal["acceptance_angle_rad", "axis", "rotation_rad"]
PARAMETERS: tuple[Parameter, ...] = get_args(Parameter)

_FOUR_LN2 = 4 * np.log(2)


# Axes (N, 3) in the head's frame, and acceptance angles (N,), rad.
Looking = tuple[NDArray[np.float32], NDArray[np.float32]]


def scores_of(
    looking: Looking, poses: Floats, directions: NDArray[np.float32], names: Collection[Parameter]
) -> dict[Parameter, Floats]:
    """∂ ln p / ∂θ of rays (P, estimate, N, sample, 3), for each parameter.

    Args:
        poses: (P, 4, 4).
    """
    axis = _axes_in_world(looking, poses)
    along = np.sum(directions * axis, axis=-1, keepdims=True)
    across = directions - along * axis
    sine = np.linalg.norm(across, axis=-1)
    angle = np.arctan2(sine, along[..., 0])
    # The angle over its sine is 1 on the axis itself.
    per_sine = np.divide(angle, sine, out=np.ones_like(angle), where=sine > 0)
    moments = Moments(np.ones(1), angle**2, per_sine[..., None] * across)
    return slopes_of(looking, poses, moments, names)


@dataclass(frozen=True)
class Moments:
    """Light about axes, of which derivatives are linear, for what a sensitivity p lets in."""

    light: Floats
    """(P, estimate, N, ..), the mean of L; of what counts for 1, 1."""
    squares: Floats
    """(P, estimate, N, ..), that of L ϑ²."""
    towards: Floats
    """(P, estimate, N, .., 3), that of L ϑ s, in the world."""


def slopes_of(
    looking: Looking, poses: Floats, moments: Moments, names: Collection[Parameter]
) -> dict[Parameter, Floats]:
    """E[L ∂ ln p / ∂θ], (P, estimate, N, ..) and for directions (P, estimate, N, .., 3)."""
    width = looking[1].astype(np.float64)[:, None]
    slopes: dict[Parameter, Floats] = {}
    if "acceptance_angle_rad" in names:
        normal = _log_integral_slope(width[:, 0])[:, None]
        per_square = 2 * _FOUR_LN2 / width**3
        slopes["acceptance_angle_rad"] = per_square * moments.squares - normal * moments.light
    towards = (2 * _FOUR_LN2 / width**2)[..., None] * moments.towards
    if "rotation_rad" in names:
        # A turn by ρ moves the axis by ρ × a.
        axis = np.broadcast_to(_axes_in_world(looking, poses), towards.shape)
        slopes["rotation_rad"] = np.cross(axis, towards)
    if "axis" in names:
        slopes["axis"] = np.einsum("pij,pensi->pensj", _turns(poses), towards)
    return slopes


def _turns(poses: Floats) -> Floats:
    """(P, 3, 3), of poses (P, 4, 4) that may be scaled."""
    turns: Floats = poses[:, :3, :3] / np.linalg.norm(poses[:, :3, :3], axis=1, keepdims=True)
    return turns


def _axes_in_world(looking: Looking, poses: Floats) -> Floats:
    """(P, 1, N, 1, 3)."""
    axes = np.einsum("pij,nj->pni", _turns(poses), looking[0].astype(np.float64))
    return normalized(axes)[:, None, :, None, :]


def _log_integral_slope(width: Floats) -> Floats:
    """d ln Z / d w (N,) of Gaussians of these widths, by Gauss-Legendre quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    widths, back = np.unique(width, return_inverse=True)
    # All of it lies within five widths, 30 standard deviations twice over.
    end = np.minimum(5 * widths, np.pi)[:, None]
    angle = end * (nodes + 1) / 2
    density = np.exp(-_FOUR_LN2 * (angle / widths[:, None]) ** 2) * np.sin(angle) * weights
    slope: Floats = np.sum(2 * _FOUR_LN2 * angle**2 / widths[:, None] ** 3 * density, axis=1)
    of_each: Floats = slope / density.sum(axis=1)
    return of_each[back]
