"""Gaussian splats as arrays, as files hold them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.values import value_class

Floats = NDArray[np.float32]


def _identity() -> NDArray[np.float64]:
    return np.eye(4)


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class SplatArrays:
    """N Gaussians in a frame of their own, in which their harmonics are meant too.

    ``positions`` (N, 3); ``scales`` (N, 3), standard deviations along their own axes;
    ``rotations`` (N, 4), unit quaternions x, y, z, w that turn these axes into the cloud's;
    ``opacities`` (N,), 0 to 1; ``harmonics`` (N, K, 3) with K of 1, 4, 9 or 16, for red, green and
    blue: the colour is max(0, 0.5 + sum of Y_k(d) c_k) with the basis of `splat_harmonics.basis`,
    in ``color_space`` ("srgb" or "linear"). d goes from the eye to the Gaussian's centre
    (``direction`` "center") or along the ray ("ray"). ``world_from_splats`` (4, 4) has turns,
    one scale and a translation. ``left_out`` counts splats of a file that could not be used, by
    reason.
    """

    positions: Floats
    scales: Floats
    rotations: Floats
    opacities: Floats
    harmonics: Floats
    color_space: str = "srgb"
    direction: str = "center"
    world_from_splats: NDArray[np.float64] = field(default_factory=_identity)
    name: str = ""
    left_out: dict[str, int] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.positions)

    def chosen(self, rows: Any) -> SplatArrays:
        """Some of them: a slice, a mask or indices."""
        return replace(
            self,
            positions=self.positions[rows],
            scales=self.scales[rows],
            rotations=self.rotations[rows],
            opacities=self.opacities[rows],
            harmonics=self.harmonics[rows],
        )
