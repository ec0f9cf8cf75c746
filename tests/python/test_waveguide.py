"""Waveguide modes that have just begun, against SciPy: modes found over the logarithm of w, and
overlaps summed over that of the spatial frequency, so that a field of any reach is resolved."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize, special

import omma

WAVELENGTH_NM, RHABDOM_INDEX, SURROUND_INDEX = 500.0, 1.363, 1.340
# Where modes begin: zeros of J1 (LP_0m and LP_2m), J0 (LP_1m) and J2 (LP_3m).
CUT_OFFS = (3.8317059702, 7.0155866698, 10.1734681351, 13.3236919363, 2.4048255577, 5.1356223018)


def k_ratio(order: int, w: float) -> float:
    """K_{order+1}(w) / K_order(w), which does not overflow where they do."""
    ratio = special.kve(1, w) / special.kve(0, w)
    for i in range(1, order + 1):
        ratio = 1 / ratio + 2 * i / w
    return float(ratio)


def mode_w(order: int, v: float, begins: float, ends: float) -> float | None:
    """w of the mode LP that begins at a V; None where it reaches out 1e140 radii and more."""

    def equation(log_w: float) -> float:
        w = np.exp(log_w)
        u = np.sqrt((v - w) * (v + w))
        outside = w * k_ratio(order, w) * special.jv(order, u)
        return float(u * special.jv(order + 1, u) - outside)

    low = max(-322.0, 0.5 * np.log(max((v - ends) * (v + ends), 1e-300)) + 1e-12)
    high = 0.5 * np.log((v - begins) * (v + begins)) - 1e-12
    if equation(low) * equation(high) > 0:
        return None
    return float(np.exp(optimize.brentq(equation, low, high, xtol=1e-14)))


def sensitivity(v: float, radius: float, x: np.ndarray) -> np.ndarray:
    """S over x, not normalised: what all modes take of an Airy pattern around x, `radius` the
    rhabdom's, both over (lambda f)/(pi D)."""
    total = np.zeros(len(x))
    nodes, weights = np.polynomial.legendre.leggauss(12)
    for order in range(20):
        zeros = special.jn_zeros(1 if order == 0 else order - 1, 20)
        begin = [0.0, *zeros] if order == 0 else list(zeros)
        for begins, ends in zip(begin, special.jn_zeros(order, 21), strict=False):
            w = mode_w(order, v, begins, min(ends, v)) if begins < v else None
            if w is None:
                continue
            u = np.sqrt((v - w) * (v + w))
            ratio = k_ratio(order, w)
            below = ratio if order == 0 else 1 / k_ratio(order - 1, w)
            around = special.jv(order - 1, u) * special.jv(order + 1, u)
            inside = 0.5 * (1 - around / special.jv(order, u) ** 2)
            norm = inside + 0.5 * (below * ratio - 1)
            edges = np.linspace(np.log(max(min(w / radius, 1.0) * 1e-4, 1e-60)), 0, 401)
            half = np.diff(edges)[:, None] / 2
            at = np.exp((edges[1:] + edges[:-1])[:, None] / 2 + half * nodes)
            q = radius * at
            spectrum = w * ratio * special.jv(order, q) - q * special.jv(order + 1, q)
            spectrum *= v * v / ((u * u - q * q) * (w * w + q * q))
            fraction = at * at * half * weights * spectrum
            overlap = [float(np.sum(fraction * special.jv(order, one * at))) for one in x]
            total += (1 if order == 0 else 2) * inside / norm / norm * np.square(overlap)
    return total


@pytest.mark.parametrize("cut_off", CUT_OFFS)
@pytest.mark.parametrize("radius", [1.0, 20.0])
def test_modes_that_have_just_begun(cut_off: float, radius: float) -> None:
    facet_m = 500e-6
    wavelength_m = WAVELENGTH_NM * 1e-9
    # At knots of the profile, so that nothing is interpolated.
    x = np.unique(np.round(np.array([0, 0.3, 0.7, 1, 1.3]) * radius * 16 / np.pi)) * np.pi / 16
    for above in (-1e-6, 1e-6, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2):
        v = cut_off + above
        aperture = np.sqrt(RHABDOM_INDEX**2 - SURROUND_INDEX**2)
        rhabdom_m = v * wavelength_m / np.pi / aperture
        lens = omma.Acceptance.lens_rhabdom(
            facet_m,
            np.pi * facet_m * rhabdom_m / (2 * radius * wavelength_m),
            rhabdom_m,
            WAVELENGTH_NM,
            RHABDOM_INDEX,
            SURROUND_INDEX,
            allow_unusual=True,
        )
        found = lens.eval(np.arcsin(x * wavelength_m / (np.pi * facet_m)))
        expected = sensitivity(v, radius, x)
        largest = int(np.argmax(expected))
        # V comes back from the diameter within 1e-15, so that a mode's w that is as its root is
        # off by up to 1e-9; sums of 192 nodes add some 1e-8 where the rhabdom is seen widest.
        np.testing.assert_allclose(
            found / found[largest], expected / expected[largest], rtol=0, atol=1e-7
        )
