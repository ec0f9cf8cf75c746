"""The splats of a file that can be used, gathered piece by piece, and what was left out of them."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, SplatCloud
from omma.scene.memory import free_bytes, words_for_bytes

Floats = NDArray[np.float64]

# Of a piece: some 10 MB while it is read, which caches hold.
PIECE = 1 << 14
# Number of coefficients of all three colours above degree 0, by degree.
REST_COUNTS = (0, 9, 24, 45)

# What the engine takes (src/model/splat_check.cpp), in single precision.
_MOST_POSITION = 1e6
_LEAST_SCALE, _MOST_SCALE = np.float32(1e-12), np.float32(1e6)
_MOST_HARMONIC = 1e4
# Of a quaternion, whose square is then no number.
_LEAST_LENGTH = 1e-100


class SplatColumns:
    """Arrays for at most ``count`` splats of ``terms`` coefficients, filled in the file's order."""

    def __init__(self, path: str, count: int, terms: int) -> None:
        if count == 0:
            raise Error(f"{path}: expected Gaussian splats, found none")
        # Here and in the cloud that is made of them.
        needed, free = 2 * 4.0 * count * (11 + 3 * terms), free_bytes()
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
            scales = np.exp(log_scales.astype(np.float64)).astype(np.float32)
            length = np.linalg.norm(rotations.astype(np.float64), axis=1)
            checks = {
                "position not finite": np.isfinite(positions).all(axis=1),
                "position beyond 1e6": _are_near(positions),
                "scale not a number": ~np.isnan(scales).any(axis=1),
                "scale below 1e-12": (scales >= _LEAST_SCALE).all(axis=1),
                "scale above 1e6": (scales <= _MOST_SCALE).all(axis=1),
                "rotation not finite": np.isfinite(length),
                "rotation of length 0": length > _LEAST_LENGTH,
                "opacity not a number": ~np.isnan(opacities),
                "harmonics not finite": np.isfinite(harmonics).all(axis=(1, 2)),
                "harmonics beyond 1e4": (np.abs(harmonics) <= _MOST_HARMONIC).all(axis=(1, 2)),
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

    def leave_out_far(self) -> None:
        """Where arrays were filled otherwise than by `add`: without those beyond reach."""
        near = _are_near(self.positions[: self.filled])
        if near.all():
            return
        self.left_out["position beyond 1e6"] = int(np.count_nonzero(~near))
        for one in (self.positions, self.scales, self.rotations, self.opacities, self.harmonics):
            one[: np.count_nonzero(near)] = one[: self.filled][near]
        self.filled = int(np.count_nonzero(near))

    def splats(self, world_from_splats: Floats, name: str) -> tuple[SplatCloud, dict[str, int]]:
        """What there is, and how many were left out, by reason.

        Raises:
            omma.Error: nothing was kept, or the engine refuses where it is placed.
        """
        if not self.filled:
            why = ", ".join(f"{reason}: {count:,}" for reason, count in self.left_out.items())
            raise Error(
                f"{self.path}: expected Gaussian splats, found none that can be used ({why})"
            )
        kept = slice(self.filled)
        try:
            cloud = SplatCloud(
                self.positions[kept],
                self.scales[kept],
                self.rotations[kept],
                self.opacities[kept],
                self.harmonics[kept],
                world_from_splats=world_from_splats,
                name=name,
            )
        except Error as error:
            raise Error(f"{self.path}: {error}") from None
        return cloud, self.left_out


def _are_near(positions: NDArray[Any]) -> NDArray[np.bool_]:
    near: NDArray[np.bool_] = (np.abs(positions) <= _MOST_POSITION).all(axis=1)
    return near


def chosen(splats: SplatCloud, rows: Any) -> SplatCloud:
    """Some of them: a slice, a mask or indices."""
    return splats.replace(
        positions_m=splats.positions_m[rows],
        scales_m=splats.scales_m[rows],
        rotations=splats.rotations[rows],
        opacities=splats.opacities[rows],
        harmonics=splats.harmonics[rows],
    )


def sigmoid(logits: NDArray[Any]) -> Floats:
    """Of infinite ones too, which say 0 and 1."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(1 / (1 + np.exp(-logits.astype(np.float64))))


def expect_file(path: str) -> None:
    """omma.Error where there is no regular file of that name."""
    if not os.path.isfile(path):
        found = "a directory" if os.path.isdir(path) else "none"
        raise Error(f"{path}: expected a file, found {found}")
