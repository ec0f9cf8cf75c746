"""Skew: ommatidia that do not look along the normal of the surface they sit on.

Real eyes are skewed, so that an eye sees more, or less, than its curvature spans.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, positive
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.renamed import renamed_arguments
from omma.eye.surfaces import Surface

__all__ = ["skew_rad", "squeeze_for_skew", "squeezed"]

NormalOf = Callable[[Floats], Floats]


@checked
def squeezed(towards: ArrayLike, factor: float) -> NormalOf:
    """A skew for `eye_on_surface`: the surface's normal is ``factor`` times as far from the
    direction ``towards`` as the axis. With 0.6, an eye that sees 180° spans 108° on its surface.

    Raises:
        omma.Error: a direction that is none, a factor that is not above 0.
    """
    centre = vectors_of(np.atleast_2d(array_of(towards, "towards")), "towards", 1)[0]
    positive(factor, "factor")

    def normal(directions: Floats) -> Floats:
        along = directions @ centre
        across = directions - along[:, None] * centre
        size = np.linalg.norm(across, axis=1)
        angle = factor * np.arctan2(size, along)
        # Towards and away there is no way across; the angle's sine is 0 towards.
        across /= np.maximum(size, 1e-300)[:, None]
        return np.asarray(np.cos(angle)[:, None] * centre + np.sin(angle)[:, None] * across)

    return normal


@renamed_arguments(centre_m="center_m")
@checked
def squeeze_for_skew(
    directions: ArrayLike,
    surface: Surface,
    towards: ArrayLike,
    median_rad: float,
    *,
    center_m: ArrayLike | None = None,
) -> float:
    """The factor with which `squeezed` gives a median skew: of the angle between axis and surface
    normal or, with ``center_m``, between axis and position from there.

    Raises:
        omma.Error: no factor from 0.02 to 1 gives it; the message says what they give.
    """
    axes = vectors_of(directions, "directions")
    positive(median_rad, "median_rad")

    def median(factor: float) -> float:
        normals = squeezed(towards, factor)(axes)
        positions = normals
        if center_m is not None:
            positions = normalized(
                surface.point_of_normal(normals) - array_of(center_m, "center_m", (3,))
            )
        return float(np.median(angle_between(axes, positions)))

    factors = np.linspace(1.0, 0.02, 50)
    medians = np.array([median(factor) for factor in factors])
    above = medians >= median_rad
    change = np.flatnonzero(above[1:] != above[:-1])
    if len(change) == 0:
        raise Error(
            f"median_rad: expected {math.degrees(medians.min()):.3g} to "
            f"{math.degrees(medians.max()):.3g}°, which is what squeezing gives here, found "
            f"{math.degrees(median_rad):.4g}°"
        )
    # The one that squeezes least.
    low, high = factors[change[0]], factors[change[0] + 1]
    low_is_above = bool(above[change[0]])
    for _ in range(40):
        middle = (low + high) / 2
        if (median(middle) >= median_rad) == low_is_above:
            low = middle
        else:
            high = middle
    return float((low + high) / 2)


@renamed_arguments(centre_m="center_m")
@checked
def skew_rad(
    eye: Eye, *, center_m: ArrayLike = (0.0, 0.0, 0.0), surface: Surface | None = None
) -> Floats:
    """The angle (N,) between each axis and the position seen from ``center_m`` (by default the
    origin, an eye's or a head's middle), or the normal of ``surface`` where it is given.

    Raises:
        omma.Error: an ommatidium at the centre.
    """
    position = eye.position_m.astype(np.float64)
    if surface is not None:
        across = surface.normals(surface.onto(position))
    else:
        across = position - array_of(center_m, "center_m", (3,))
        if not np.linalg.norm(across, axis=1).all():
            raise Error("skew_rad: an ommatidium sits at the centre, so it has no direction")
    return angle_between(eye.axis.astype(np.float64), across)


def angle_between(first: Floats, second: Floats) -> Floats:
    """Angles (K,) between vectors (K, 3), rad."""
    # Near 0 the cosine alone would lose half the digits.
    across = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(across, np.sum(first * second, axis=1)))


def vectors_of(values: ArrayLike, name: str, count: int | None = None) -> Floats:
    """Vectors (N, 3) of length 1; omma.Error names the argument where they are none."""
    vectors = array_of(values, name, (count, 3))
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    if not np.all(np.isfinite(size) & (size > 0)):
        raise Error(f"{name}: expected finite vectors that are not 0")
    return np.asarray(vectors / size)
