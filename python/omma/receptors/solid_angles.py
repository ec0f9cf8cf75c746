"""How much of the surround counts: the solid angle of an acceptance, ∫ S dω, S 1 at its largest.

What a receptor catches of an even surround of radiance L is L times this times the area of its
facet. Land's (π/4) Δρ² is that of a disc as wide as the acceptance is at half its height; a
Gaussian's tails reach beyond, so that its own is π/(4 ln 2) Δρ² where it is narrow, 1.44 times as
much.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Acceptance, Error, Eye
from omma.base.arguments import array_of, checked, one_of
from omma.base.arrays import Floats

# Whose solid angle: the acceptance's own, or Land's disc.
Field = Literal["acceptance", "land"]

# Beyond so many widths a Gaussian is below 1e-11.
_WIDTHS = 3.0
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@checked
def solid_angle_sr(acceptance: Acceptance | ArrayLike) -> Floats:
    """∫ S dω of an angular sensitivity, 1 at its largest, over the sphere; sr.

    Args:
        acceptance: one, of any kind but "compoundray", whose S is infinite on its axis; or full
            widths at half maximum of round Gaussians, an array of any shape, rad.

    Example:
        >>> round(float(omma.receptors.solid_angle_sr(omma.Acceptance.pillbox(1.0))), 4)
        0.7692

    Raises:
        omma.Error: a compoundray, or widths that are not from 0 to 2π.
    """
    if isinstance(acceptance, Acceptance):
        return np.asarray(_of_one(acceptance))
    if isinstance(acceptance, Eye):
        raise Error(
            "acceptance: expected an omma.Acceptance or widths, found an eye; those of its "
            "ommatidia are solid_angle_sr(eye.acceptance_angle_rad)"
        )
    width = array_of(acceptance, "acceptance")
    if not ((width >= 0) & (width <= math.tau)).all():
        raise Error("acceptance: expected widths of 0 to 2π rad")
    # Gauss-Legendre over the polar angle; smooth, so that 48 nodes leave 1e-13.
    half = np.minimum(_WIDTHS * width, math.pi)[..., None] / 2
    theta = half * (1 + _NODES)
    safe = np.where(width > 0, width, 1)[..., None]
    density = np.exp(-4 * math.log(2) * (theta / safe) ** 2) * np.sin(theta)
    return np.asarray(math.tau * (half * density * _WEIGHTS).sum(axis=-1))


@checked
def receptor_solid_angle_sr(eye: Eye, *, field: Field = "acceptance") -> Floats:
    """The solid angle of each receptor of an eye: (R,), sr.

    Args:
        field: "acceptance", ∫ S dω of the receptor's own acceptance or its ommatidium's; "land",
            (π/4) Δρ² of its mean width.

    Raises:
        omma.Error: another word for ``field``; a compoundray, which has no solid angle of its own.
    """
    land = one_of(field, ("acceptance", "land"), "field") == "land"
    width = eye.acceptance_angle_rad.astype(np.float64)
    if not land:
        return _of_receptors(eye, solid_angle_sr(width), _of_one)
    discs = math.pi / 4 * width**2
    return _of_receptors(eye, discs, lambda one: math.pi / 4 * one.mean_width_rad**2, land=True)


def receptor_coupling_efficiency(eye: Eye) -> Floats:
    """`Acceptance.coupling_efficiency` of each receptor of an eye: (R,)."""
    return _of_receptors(eye, np.ones(len(eye)), lambda one: one.coupling_efficiency)


def _of_receptors(
    eye: Eye, of_width: Floats, of_one: Callable[[Acceptance], float], *, land: bool = False
) -> Floats:
    """(R,), of a receptor's own acceptance, or its ommatidium's, or (N,) of its width; `land`: by
    the ommatidium's width in any case."""
    of_ommatidium = of_width
    if not land and len(eye.acceptances):
        known = np.array([of_one(one) for one in eye.acceptances])
        which = eye.acceptance_of
        of_ommatidium = np.where(which >= 0, known[np.maximum(which, 0)], of_width)
    own = np.array([
        np.nan if one.acceptance is None else of_one(one.acceptance) for one in eye.receptor_types
    ])  # fmt: skip
    of_type = own[eye.receptor_type] if len(own) else np.zeros(0)
    of_ommatidium = np.repeat(of_ommatidium, np.diff(eye.first_receptor))
    return np.where(np.isnan(of_type), of_ommatidium, of_type)


def _of_one(acceptance: Acceptance) -> float:
    """S over its density, where it is large: the same everywhere."""
    if acceptance.kernel == "compoundray":
        raise Error(
            "acceptance: expected one with a solid angle, found a compoundray, which is infinite "
            "on its axis; field='land' takes its width alone"
        )
    if acceptance.mean_width_rad == 0:
        return 0.0
    x, y, z = acceptance.sample(32).astype(np.float64).T
    theta, azimuth = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    density = acceptance.pdf(theta, azimuth)
    most = int(np.argmax(density))
    return float(acceptance.eval(theta[most], azimuth[most]) / density[most])
