"""Directions by azimuth and elevation."""

import numpy as np
import pytest

import omma


def test_elevations_are_of_a_sphere():
    up = omma.eye.direction([0, 90], [90, -90])
    assert up == pytest.approx(np.array([[0, 1, 0], [0, -1, 0]]), abs=1e-15)
    for elevation in (90.01, [0, -100]):
        with pytest.raises(omma.Error, match="elevation_deg: expected -90 to 90, found"):
            omma.eye.direction(0, elevation)
