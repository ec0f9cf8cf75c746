"""The splats of a file that can be used, gathered piece by piece, and what was left out of them."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error, SplatCloud
from omma.base.arrays import Floats
from omma.base.mesh_parts import far_middle, is_single
from omma.scene.memory import free_bytes, words_for_bytes

# Of a piece: some 10 MB while it is read, which caches hold.
PIECE = 1 << 14
# Number of coefficients of all three colours above degree 0, by degree.
REST_COUNTS = (0, 9, 24, 45)

# What the engine takes (src/model/splat_check.cpp), in single precision.
_MOST_POSITION = 1e6
_LEAST_SCALE, _MOST_SCALE = np.float32(1e-12), np.float32(1e6)
_MOST_HARMONIC = 1e4
_FAR = "position beyond 1e6"
# Of a quaternion, whose square is then no number.
_LEAST_LENGTH = 1e-100

# Of positions that say where a cloud is: so many, without this share at each end of each axis, as
# optimisers leave some splats far from all others.
_SAMPLE = 1 << 12
_OUTERMOST = 0.01
# Half a step of 24 bits, relative to a number; what of a cloud's half size is told.
_ROUNDING, _NOTABLE = 2.0**-24, 1e-6


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
        self.offset: Floats = np.zeros(3)
        """(3,), what was taken off all positions."""
        self.filled = 0
        self.left_out: dict[str, int] = {}
        self._of_place: list[str] = []

    def find_offset(self, some: NDArray[Any], are_ends: bool = False) -> None:
        """Of some positions (n, 3) of a file, from all over it: find what is best taken off all,
        as of meshes (`omma.base.mesh_parts.offset_of`), and what there is to warn of. With
        ``are_ends`` splats are between these, where single precision does not have them."""
        usable = some[np.isfinite(some).all(axis=1)].astype(np.float64)
        if not len(usable):
            return
        self.offset = offset_of_splats(usable, are_ends)
        low, high = _most_of(usable)
        nearest = np.where(low * high <= 0, 0, np.minimum(np.abs(low), np.abs(high))).max()
        size = (high - low).max()
        if size > 0 and is_single(usable) and _ROUNDING * nearest > _NOTABLE * size / 2:
            self._of_place.append(
                "its splats lie so far from the origin of its coordinates that 24 bits a number, "
                f"as the file has, may have moved them by up to {_ROUNDING * nearest:.2g}, in a "
                f"cloud of {size:.3g} (in its unit); coordinates near zero would not be"
            )

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
                _FAR: _are_near(positions),
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
        self.left_out[_FAR] = int(np.count_nonzero(~near))
        for one in (self.positions, self.scales, self.rotations, self.opacities, self.harmonics):
            one[: np.count_nonzero(near)] = one[: self.filled][near]
        self.filled = int(np.count_nonzero(near))

    def splats(
        self,
        world_from_splats: Floats,
        name: str,
        *,
        color_space: str = "srgb",
        direction: str = "center",
        white: ArrayLike = (1, 1, 1),
    ) -> SplatCloud:
        """What there is, where a file's own coordinates are placed by a matrix (4, 4).

        Raises:
            omma.Error: nothing was kept, or the engine refuses where it is placed.
        """
        if not self.filled:
            why = ", ".join(f"{reason}: {count:,}" for reason, count in self.left_out.items())
            raise Error(
                f"{self.path}: expected Gaussian splats, found none that can be used ({why})"
            )
        kept = slice(self.filled)
        placed = np.array(world_from_splats, np.float64)
        placed[:3, 3] += placed[:3, :3] @ self.offset
        try:
            return SplatCloud(
                self.positions[kept],
                self.scales[kept],
                self.rotations[kept],
                self.opacities[kept],
                self.harmonics[kept],
                color_space=color_space,
                direction=direction,
                white=white,
                world_from_splats=placed,
                name=name,
            )
        except Error as error:
            raise Error(f"{self.path}: {error}") from None

    def told(self) -> list[str]:
        """What there is to warn of."""
        counts = self.left_out.items()
        left = [f"{count:,} splats are left out: {reason}" for reason, count in counts]
        return [*left, *self._of_place]


def offset_of_splats(some: Floats, are_ends: bool = False) -> Floats:
    """What is best taken off the positions of a cloud, of which these (n, 3) are some: (3,), 0
    where most lie about zero, or single precision has them as they are and the engine takes them.
    """
    low, high = _most_of(some)
    is_taken = max(np.abs(low).max(), np.abs(high).max()) <= _MOST_POSITION
    return np.zeros(3) if is_taken and is_single(some) and not are_ends else far_middle(low, high)


def _most_of(some: Floats) -> tuple[Floats, Floats]:
    """The box (3,), (3,) around most of them."""
    low, high = np.quantile(some, (_OUTERMOST, 1 - _OUTERMOST), axis=0, method="nearest")
    return low, high


def sample_of(rows: Any, count: int) -> Any:
    """Some of so many rows, from all over them, for `SplatColumns.find_offset`."""
    return rows[:: max(1, count // _SAMPLE)]


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
