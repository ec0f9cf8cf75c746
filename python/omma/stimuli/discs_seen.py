"""What looks like discs from the middle of the head: which directions meet one, and how much of an
ommatidium's sensitivity does."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from omma.base.arrays import Floats
from omma.stimuli.gaussian import caps_share
from omma.stimuli.stimulus import Stimulus


class Discs(Stimulus):
    """Discs of one radiance before an even background."""

    @property
    def _disc_radiance(self) -> float:
        """Their radiance."""
        raise NotImplementedError

    def _discs(self, times_s: Floats) -> Iterable[tuple[Floats, Floats]]:
        """For each time, s, directions to their middles (K, 3), and half their widths (K,), rad."""
        raise NotImplementedError

    def _radiance(self, directions: Floats, time_s: float) -> Floats:
        ((centres, half_rad),) = self._discs(np.array([time_s]))
        flat = directions.reshape(-1, 3)
        met = np.zeros(len(flat), bool)
        for centre, cosine in zip(centres, np.cos(half_rad), strict=True):
            met |= flat @ centre > cosine
        return np.where(met.reshape(directions.shape[:-1]), self._disc_radiance, self.background)

    def _expected(self, axes: Floats, acceptance_rad: Floats, times_s: Floats) -> Floats:
        covered = [
            [
                caps_share(axis, width, centres, half_rad)
                for axis, width in zip(axes, acceptance_rad, strict=True)
            ]
            for centres, half_rad in self._discs(times_s)
        ]
        shares = np.array(covered, np.float64).reshape(len(times_s), len(axes))
        return np.asarray(self.background + (self._disc_radiance - self.background) * shares)
