"""Numbers that docs/eyes.md gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

import omma

Acceptance = omma.Acceptance
FLY = Acceptance.lens_rhabdom(25e-6, 55e-6, 1.9e-6, 500)


def test_width_of_a_fly() -> None:
    assert math.degrees(FLY.width_rad()) == pytest.approx(2.2, abs=0.05)


def test_snyder_over_geometric() -> None:
    def width(model: str, ratio: float) -> float:
        """In lambda/D, where the rhabdom is seen under `ratio` times that."""
        waves = 500e-9 / 50e-6
        lens = Acceptance.lens_rhabdom(
            50e-6, 2e-6 / (ratio * waves), 2e-6, 500, model=model, allow_unusual=True
        )
        return float(lens.width_rad()) / waves

    # Narrowest where the rhabdom is a point: 1 over the 1.029 of a bare lens.
    ratios = np.concatenate([[0.02], np.linspace(0.1, 4, 79), np.linspace(5, 25, 21)])
    fraction = [width("snyder", ratio) / width("geometric", ratio) for ratio in ratios]
    assert max(fraction) == pytest.approx(1.27, abs=0.005)
    assert min(fraction) == pytest.approx(0.97, abs=0.005)


def test_directions_far_out() -> None:
    def beyond(acceptance: omma.Acceptance, widths: float) -> float:
        directions = np.asarray(acceptance.sample(200_000, 1))
        angle = np.arctan2(np.hypot(directions[:, 0], directions[:, 1]), directions[:, 2])
        return float(np.mean(angle > widths * acceptance.width_rad()))

    airy = Acceptance.airy(25e-6, 500)
    # 200,000 draws: a standard error of 0.0006 at most.
    assert beyond(airy, 3) == pytest.approx(0.06, abs=0.005)
    assert beyond(airy, 10) == pytest.approx(0.02, abs=0.005)
    assert beyond(FLY, 3) == pytest.approx(0.009, abs=0.001)
