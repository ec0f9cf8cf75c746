"""The worked example of motion: what a fly's detectors make of a looming disc and of a target."""

from pathlib import Path

import numpy as np
import pytest
from conftest import load_script

import omma

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "python" / "looming_and_target.py"


@pytest.fixture(scope="module")
def example():
    return load_script(SCRIPT)


def test_both_are_seen_to_move_as_they_do(example, tmp_path, monkeypatch):
    monkeypatch.setattr(example, "RATE_HZ", 100.0)
    eye = omma.species.drosophila().eye
    times_s, light, vectors = example.watch(eye, rays=8)
    assert light.shape == (84, len(eye))
    assert vectors.shape == (84, len(eye), 2)
    # Nothing moves but the two: what sees neither in any frame answers exactly nothing.
    ever = np.nanmax(np.hypot(*np.moveaxis(vectors, -1, 0)), axis=0, initial=0.0)
    axis = eye.axis.astype(float)
    elsewhere = (axis[:, 1] > 0.7) & np.isfinite(vectors[0, :, 0])
    assert elsewhere.sum() > 100
    assert not ever[elsewhere].any()
    # The disc spreads, ever faster; the target goes to the right.
    looming = omma.motion.expansion(eye, vectors, example.DISC_AT)
    passing = example.rightward(eye, vectors)
    third = len(times_s) // 3
    assert looming[2 * third :].mean() > 5 * looming[third : 2 * third].mean() > 0
    assert passing.mean() > 0
    example.draw(tmp_path / "one.png", eye, times_s, light, vectors)
    assert (tmp_path / "one.png").stat().st_size > 50_000
