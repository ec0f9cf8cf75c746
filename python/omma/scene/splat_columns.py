"""The splats of a file that can be used, gathered piece by piece, and what was left out of them."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.mesh_parts import world_from_file
from omma.scene.memory import free_bytes, words_for_bytes
from omma.scene.splat_arrays import SplatArrays

Floats = NDArray[np.float64]

# Of a piece: some 10 MB while it is read, which caches hold.
PIECE = 1 << 14
# Number of coefficients of all three colours above degree 0, by degree.
REST_COUNTS = (0, 9, 24, 45)

# No world is larger, and no standard deviation is smaller or larger.
_MOST_M = 1e18
_SCALES = (1e-15, 1e15)

# What turns a frame whose y points down, and z ahead (COLMAP's), into +Y up: half a turn about x.
_Y_UP_FROM_DOWN = np.diag([1.0, -1.0, -1.0, 1.0])


class SplatColumns:
    """Arrays for at most ``count`` splats of ``terms`` coefficients, filled in the file's order."""

    def __init__(self, path: str, count: int, terms: int) -> None:
        if count == 0:
            raise Error(f"{path}: expected Gaussian splats, found none")
        needed, free = 4.0 * count * (11 + 3 * terms), free_bytes()
        if needed > free:
            raise Error(
                f"{path}: {count:,} splats take {words_for_bytes(needed)}, of which "
                f"{words_for_bytes(free)} are free"
            )
        self.path = path
        self.positions = np.empty((count, 3), np.float32)
        self.scales = np.empty((count, 3), np.float32)
        self.rotations = np.empty((count, 4), np.float32)
        self.opacities = np.empty(count, np.float32)
        self.harmonics = np.empty((count, terms, 3), np.float32)
        self.filled = 0
        self.left_out: dict[str, int] = {}

    def add(
        self,
        positions: NDArray[Any],
        log_scales: NDArray[Any],
        rotations: NDArray[Any],
        opacities: NDArray[Any],
        harmonics: NDArray[Any],
    ) -> None:
        """Some splats more, of which those are left out that make no Gaussian.

        ``rotations`` are quaternions x, y, z, w of any length.
        """
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            scales = np.exp(log_scales.astype(np.float64))
            length = np.linalg.norm(rotations.astype(np.float64), axis=1)
            checks = {
                "position not finite": np.isfinite(positions).all(axis=1),
                "position farther than 1e18 m": (np.abs(positions) <= _MOST_M).all(axis=1),
                "scale not a number": ~np.isnan(scales).any(axis=1),
                "scale too small": (scales >= _SCALES[0]).all(axis=1),
                "scale too large": (scales <= _SCALES[1]).all(axis=1),
                "rotation not finite": np.isfinite(length),
                "rotation of length 0": length > 0,
                "opacity not a number": ~np.isnan(opacities),
                "harmonics not finite": np.isfinite(harmonics).all(axis=(1, 2)),
            }
        taken = np.ones(len(positions), bool)
        for reason, fits in checks.items():
            wrong = int(np.count_nonzero(taken & ~fits))
            if wrong:
                self.left_out[reason] = self.left_out.get(reason, 0) + wrong
                taken &= fits
        chosen: Any = slice(None) if taken.all() else taken
        rows = slice(self.filled, self.filled + int(np.count_nonzero(taken)))
        self.positions[rows] = positions[chosen]
        self.scales[rows] = scales[chosen]
        self.rotations[rows] = rotations[chosen] / length[chosen][:, None]
        self.opacities[rows] = opacities[chosen]
        self.harmonics[rows] = harmonics[chosen]
        self.filled = rows.stop

    def splats(self, world_from_splats: Floats, name: str) -> SplatArrays:
        """What there is.

        Raises:
            omma.Error: nothing was kept.
        """
        if not self.filled:
            why = ", ".join(f"{reason}: {count:,}" for reason, count in self.left_out.items())
            raise Error(
                f"{self.path}: expected Gaussian splats, found none that can be used ({why})"
            )
        kept = slice(self.filled)
        return SplatArrays(
            self.positions[kept],
            self.scales[kept],
            self.rotations[kept],
            self.opacities[kept],
            self.harmonics[kept],
            world_from_splats=world_from_splats,
            name=name,
            left_out=self.left_out,
        )


def world_from_cloud(unit: str | float, up: str) -> Floats:
    """(4, 4), from a file's unit and the axis that points up in it, "-y", "y" or "z", to metres
    with +Y up."""
    if up == "-y":
        return _Y_UP_FROM_DOWN @ world_from_file(unit, "y")
    return world_from_file(unit, up)


def sigmoid(logits: NDArray[Any]) -> Floats:
    """Of infinite ones too, which say 0 and 1."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(1 / (1 + np.exp(-logits.astype(np.float64))))


def expect_file(path: str) -> None:
    """omma.Error where there is no regular file of that name."""
    if not os.path.isfile(path):
        found = "a directory" if os.path.isdir(path) else "none"
        raise Error(f"{path}: expected a file, found {found}")
