"""Cubic splines against SciPy's, and one that a cubic is."""

import numpy as np
import pytest

from omma.light.splines import spline_through

# Both solve the same well-conditioned equations in double precision.
ROUNDING = 1e-12


@pytest.mark.parametrize("count", [4, 5, 25, 73])
@pytest.mark.parametrize("is_periodic", [False, True])
def test_splines_are_those_of_scipy(count, is_periodic):
    from scipy.interpolate import CubicSpline

    rng = np.random.default_rng(count)
    nodes = np.cumsum(rng.uniform(0.5, 2.0, count))
    values = rng.normal(size=(count, 3))
    if is_periodic:
        values[-1] = values[0]
    at = np.concatenate([nodes, rng.uniform(nodes[0], nodes[-1], 50)])
    kind = "periodic" if is_periodic else "not-a-knot"
    found = spline_through(nodes, values, at, is_periodic=is_periodic)
    expected = CubicSpline(nodes, values, bc_type=kind)(at)
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING * np.abs(expected).max())


def test_a_cubic_is_its_own_spline_beyond_the_nodes_too():
    nodes = np.array([0.0, 1.0, 2.5, 3.0, 5.0])
    at = np.array([-1.0, 0.3, 2.7, 6.0])
    found = spline_through(nodes, (nodes**3 - 2 * nodes)[:, None], at)[:, 0]
    # Numbers of 200 lose three digits of sixteen.
    np.testing.assert_allclose(found, at**3 - 2 * at, rtol=0, atol=1e-11)
