"""Random fields on the sphere with a given spectrum, from spherical harmonics.

Isotropic by construction: no seam, no poles, the same in every direction. After the usual
recurrences of the normalised associated Legendre functions, e.g. Holmes & Featherstone 2002,
J Geodesy 76:279, eqs 11 and 13.
"""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats


def random_field(power: Floats, rows: int, columns: int, seed: int) -> Floats:
    """A Gaussian random field (rows, columns) on an equirectangular picture, row 0 at the top.

    Args:
        power: C_l (L,), the variance of each harmonic of degree l; the field's is the sum of
            (2l + 1) C_l / 4π.
        columns: at least 2 L.
    """
    degrees = len(power)
    drawn = np.random.default_rng(seed).normal(size=(degrees, degrees, 2))
    polar = np.pi * (np.arange(rows) + 0.5) / rows
    x, s = np.cos(polar), np.sin(polar)
    waves = np.zeros((rows, columns // 2 + 1), complex)
    of_order = np.full(rows, np.sqrt(1 / (4 * np.pi)))  # the function of degree m and order m
    for m in range(degrees):
        if m > 0:
            of_order = np.sqrt((2 * m + 1) / (2 * m)) * s * of_order
        before, now = np.zeros(rows), of_order
        for degree in range(m, degrees):
            amplitude = np.sqrt(power[degree]) * (drawn[degree, m, 0] - 1j * drawn[degree, m, 1])
            # Order 0 has one harmonic, the others have a cosine and a sine.
            waves[:, m] += now * (amplitude.real if m == 0 else amplitude / np.sqrt(2))
            l1 = degree + 1
            back = np.sqrt((degree**2 - m**2) / (4 * degree**2 - 1)) if degree > m else 0.0
            before, now = now, np.sqrt((4 * l1**2 - 1) / (l1**2 - m**2)) * (x * now - back * before)
    # The middle of the first column is half a pixel from the left edge, which is behind.
    longitude = 2 * np.pi * 0.5 / columns
    waves *= np.exp(1j * longitude * np.arange(columns // 2 + 1))
    return np.asarray(np.fft.irfft(waves, columns, axis=1) * columns)
