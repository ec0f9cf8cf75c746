"""Patterns that turn around the head, about the poles that lie across their direction of motion."""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats
from omma.stimuli.jumps import Motion, half_turn_s, turning
from omma.stimuli.shapes import drifted
from omma.stimuli.stimulus import Stimulus


class Turning(Stimulus):
    """One that turns by a speed of its own, or as `_drift_deg` says."""

    speed_deg_s: float
    direction_deg: float

    def _transforms(self, times_s: Floats) -> Floats:
        return drifted(self._drift_deg(times_s), self.direction_deg)[:, None]

    def _velocities(self, times_s: Floats) -> Motion:
        return turning(np.full(len(times_s), self._turning_deg_s), self.direction_deg)

    @property
    def _turning_deg_s(self) -> float:
        return self.speed_deg_s

    @property
    def _longest_step_s(self) -> float:
        return half_turn_s(self._turning_deg_s)

    def _drift_deg(self, time_s: Floats | float) -> Floats:
        """By how much it has turned, degrees."""
        return np.asarray(np.mod(self.speed_deg_s * np.asarray(time_s), 360.0))
