"""Measured angular sensitivities from CSV files."""

from __future__ import annotations

import math

import numpy as np
import pytest

import omma


def written(tmp_path, text):
    path = tmp_path / "measured.csv"
    path.write_text(text)
    return path


def test_a_profile(tmp_path):
    path = written(tmp_path, "# of a bee\nangle_deg,sensitivity\n2,0\n0,4\n1,3\n")
    profile = omma.eye.load_acceptance(path)
    assert profile.kernel == "table"
    assert profile.is_round
    np.testing.assert_allclose(profile.eval(np.radians([0, 0.5, 1, 1.5, 2.5])),
                               [1, 0.875, 0.75, 0.375, 0])  # fmt: skip
    # Linear from 0.75 at 1 degree to 0 at 2: half at 4/3 of a degree on either side.
    assert profile.width_rad() == pytest.approx(math.radians(8 / 3), rel=1e-6)


def test_a_map(tmp_path):
    lines = [f"{right},{up},{5 * math.exp(-(right**2) - (up / 2) ** 2)}"
             for up in range(-4, 5) for right in range(-2, 3)]  # fmt: skip
    path = written(tmp_path, "right_deg, up_deg, sensitivity\n" + "\n".join(reversed(lines)))
    found = omma.eye.load_acceptance(path)
    assert not found.is_round
    # Azimuth 0 is up, a quarter turn is right.
    assert found.eval(math.radians(2), 0.0) == pytest.approx(math.exp(-1))
    assert found.eval(math.radians(1), math.pi / 2) == pytest.approx(math.exp(-1))
    assert found.width_rad(0.0) == pytest.approx(2 * found.width_rad(math.pi / 2), rel=0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "measured.csv: holds no sensitivity"),
        (
            "angle,sensitivity\n0,1\n",
            "line 1: expected a header line angle_deg,sensitivity or right_deg,up_deg,sensitivity, "
            "found 'angle,sensitivity'",
        ),
        ("angle_deg,sensitivity\n", "measured.csv: holds no sensitivity"),
        (
            "angle_deg,sensitivity\n0,1\n1,x\n",
            r"measured.csv, line 3, column sensitivity: expected a finite number, found 'x'",
        ),
        ("angle_deg,sensitivity\n0,1\n", r"measured.csv: .*at least"),
        ("angle_deg,sensitivity\n0,1\n0,1\n", r"measured.csv: .*more than the entry before"),
        ("angle_deg,sensitivity\n0,1\n1,-1\n", r"measured.csv: .*sensitivit"),
        ("right_deg,up_deg,sensitivity\n0,0,1\n1,0,1\n0,1,1\n", "found 0 for 1, 1"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, message):
    with pytest.raises(omma.Error, match=message):
        omma.eye.load_acceptance(written(tmp_path, text))
    with pytest.raises(omma.Error, match="there is no such file"):
        omma.eye.load_acceptance(tmp_path / "none.csv")
