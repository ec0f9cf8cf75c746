"""Shadows that a level layer of clouds casts on what lies below it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, positive
from omma.base.arrays import Floats
from omma.base.values import value_class
from omma.light.discs import directions_of


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class CloudShadow:
    """A level layer of clouds as it shades what lies below it from the sun and other discs.

    Of a disc at an elevation e a place gets exp(-t / sin e), t the optical depth where the way to
    the disc's centre crosses the layer: linear between nodes, and the map repeats without end. What
    lies above the layer is not shaded. `clouded` makes one that goes with its sky.

    optical_depth: (rows, columns), upwards, 0 or more; columns along +X, rows along +Z.
    spacing_m: between nodes.
    height_m: of the layer, in the world.
    first_m: X and Z of the node of row 0 and column 0.

    Example:
        >>> stripes = omma.light.CloudShadow([[0.0, 1.0], [0.0, 1.0]], spacing_m=50, height_m=800)
        >>> stripes.transmittance([(0, 0, 0), (50, 0, 0), (50, 900, 0)], (0, 1, 0)).round(3)
        array([1.   , 0.368, 1.   ])

    Raises:
        omma.Error: fewer than two rows or columns, or a number out of range.
    """

    optical_depth: NDArray[np.float32]
    spacing_m: float
    height_m: float
    first_m: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        depth = array_of(self.optical_depth, "optical_depth", (None, None), np.float32).copy()
        if min(depth.shape) < 2:
            raise Error(f"optical_depth: expected 2 or more rows and columns, found {depth.shape}")
        if not np.all((depth >= 0) & (depth <= 1e6)):
            raise Error("optical_depth: expected numbers of 0 to 1e6")
        depth.flags.writeable = False
        x, z = array_of(self.first_m, "first_m", (2,))
        height = array_of(self.height_m, "height_m", ())
        if not (np.isfinite(height) and np.isfinite(x) and np.isfinite(z)):
            raise Error("height_m, first_m: expected finite numbers")
        object.__setattr__(self, "optical_depth", depth)
        object.__setattr__(self, "spacing_m", positive(self.spacing_m, "spacing_m"))
        object.__setattr__(self, "height_m", float(height))
        object.__setattr__(self, "first_m", (float(x), float(z)))

    def transmittance(self, place_m: ArrayLike, direction: ArrayLike) -> Floats:
        """How much of a disc's light comes to places.

        Args:
            place_m: (..., 3), in the world.
            direction: (3,), towards the disc's centre. At and below the horizon nothing is shaded.

        Returns:
            (...), 0 to 1.

        Raises:
            omma.Error: a direction of zero, or numbers that are not finite.
        """
        from scipy.ndimage import map_coordinates

        place = array_of(place_m, "place_m")
        towards = directions_of(array_of(direction, "direction", (3,)))
        if place.shape[-1:] != (3,) or not np.all(np.isfinite(place)):
            raise Error(f"place_m: expected finite places (..., 3), found {place.shape}")
        if not towards[1] > 0:
            return np.ones(place.shape[:-1])
        way = (self.height_m - place[..., 1]) / towards[1]
        crossing = place + way[..., None] * towards
        at = [
            np.atleast_1d((crossing[..., axis] - first) / self.spacing_m)
            for axis, first in ((2, self.first_m[1]), (0, self.first_m[0]))
        ]
        depth = map_coordinates(
            self.optical_depth.astype(np.float64), at, order=1, mode="grid-wrap"
        )
        left = np.exp(-depth.reshape(way.shape) / towards[1])
        return np.where(way > 0, left, 1.0)

    def _for_engine(self) -> tuple[NDArray[np.float32], float, float, tuple[float, float]]:
        return self.optical_depth, self.spacing_m, self.height_m, self.first_m
