"""A disc far away, such as the sun: what it sends, and which way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of
from omma.base.arrays import Floats
from omma.base.directions import normalized
from omma.base.values import value_class

# In single precision directions within a smaller disc are not told from those beside it.
SMALLEST_DISC_RAD, _LARGEST_DISC_RAD = 1e-6, 0.1


@value_class
@dataclass(frozen=True, eq=False)
class Disc:
    """A disc far away, unpolarised, such as the sun or the moon.

    direction: (3,), towards its centre.
    angular_radius_rad: 1e-6 or more, less than a tenth.
    radiance: (B,), the mean over the disc by band.
    limb_darkening: (B,), u in L(mu) = L(1) (1 - u (1 - mu)), 0 to 1, mu the cosine at the disc's
        own surface. None: it is even.

    Raises:
        omma.Error: a direction that is zero or not finite, a radius out of range, radiances that
            are negative or not finite.
    """

    direction: Floats
    angular_radius_rad: float
    radiance: Floats
    limb_darkening: Floats | None = None

    def __post_init__(self) -> None:
        direction = array_of(self.direction, "direction", (3,))
        if not np.all(np.isfinite(direction)) or not direction.any():
            raise Error(f"direction: expected three numbers, not all 0, found {direction.tolist()}")
        radius = array_of(self.angular_radius_rad, "angular_radius_rad", ())
        if not SMALLEST_DISC_RAD <= radius < _LARGEST_DISC_RAD:
            raise Error(
                f"angular_radius_rad: expected {SMALLEST_DISC_RAD:g} or more, less than "
                f"{_LARGEST_DISC_RAD}, found {radius:g}"
            )
        radiance = strengths(self.radiance, "radiance", (None,))
        limb = None
        if self.limb_darkening is not None:
            limb = strengths(self.limb_darkening, "limb_darkening", radiance.shape)
            if np.any(limb > 1):
                raise Error("limb_darkening: expected 0 to 1")
        object.__setattr__(self, "direction", normalized(direction))
        object.__setattr__(self, "angular_radius_rad", float(radius))
        object.__setattr__(self, "radiance", radiance)
        object.__setattr__(self, "limb_darkening", limb)

    def irradiance(self) -> Floats:
        """What falls on a surface that faces it: (B,)."""
        return np.asarray(self.radiance * np.pi * np.sin(self.angular_radius_rad) ** 2)

    def radiance_at(self, direction: ArrayLike) -> Floats:
        """Radiance in directions (..., 3): (..., B), 0 beside the disc.

        Raises:
            omma.Error: directions that are zero or not finite.
        """
        towards = directions_of(direction)
        sine = np.linalg.norm(np.cross(towards, self.direction), axis=-1)
        out = sine / np.sin(self.angular_radius_rad)
        inside = (out <= 1) & (towards @ self.direction > 0)
        found = np.ones((*inside.shape, len(self.radiance)))
        if self.limb_darkening is not None:
            mu = np.sqrt(np.maximum(1 - out**2, 0))[..., None]
            u = self.limb_darkening
            found = (1 - u * (1 - mu)) / (1 - u / 3)
        return np.where(inside[..., None], found * self.radiance, 0.0)


def directions_of(direction: ArrayLike, name: str = "direction") -> Floats:
    """Unit vectors (..., 3) along those that are given; omma.Error where some are zero."""
    towards = array_of(direction, name)
    if towards.shape[-1:] != (3,):
        raise Error(f"{name}: expected shape (..., 3), found {towards.shape}")
    if not np.all(np.isfinite(towards)) or not np.all(towards.any(axis=-1)):
        raise Error(f"{name}: expected vectors that are finite and not zero")
    return normalized(towards)


def strengths(value: Any, name: str, shape: tuple[int | None, ...]) -> Floats:
    """Finite numbers of at least 0, of a shape, read-only; omma.Error names the argument."""
    numbers = array_of(value, name, shape).copy()
    if not np.all(np.isfinite(numbers)) or np.any(numbers < 0):
        raise Error(f"{name}: expected finite numbers of at least 0")
    numbers.flags.writeable = False
    return np.asarray(numbers)
