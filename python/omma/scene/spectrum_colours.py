"""What colour people see a reflectance in: linear sRGB under daylight (D65).

Colour matching functions: the multi-lobe fit of Wyman, Sloan and Shirley (JCGT 2(2), 2013).
"""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats
from omma.light import primary_spectra

# CIE standard illuminant D65, relative power at 400, 410, ... 700 nm (CIE 15:2004, table T.1).
_D65 = np.array(
    [82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811]
    + [109.354, 107.802, 104.790, 107.689, 104.405, 104.046, 100.000, 96.3342, 95.7880, 88.6856]
    + [90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213]
    + [71.6091]
)
# Of each lobe: height, peak (nm), inverse widths below and above it (per nm).
_LOBES = (
    (
        (0.362, 442.0, 0.0624, 0.0374),
        (1.056, 599.8, 0.0264, 0.0323),
        (-0.065, 501.1, 0.0490, 0.0382),
    ),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB (IEC 61966-2-1)


def luminance(rgb: Floats) -> float:
    """Relative luminance of linear sRGB (3,)."""
    return float(_LUMINANCE @ rgb)


def linear_srgb(wavelength_nm: Floats, reflectance: Floats) -> Floats:
    """Linear sRGB (3,), 0 to 1, of a reflectance (W,) at wavelengths (W,), nm, that ascend.

    Exact for spectra that are made of RGB (`omma.light.primary_spectra`).
    """
    nm = np.arange(400.0, 701.0)
    seen = colour_matching(nm) * np.interp(nm, np.arange(400.0, 701.0, 10.0), _D65)
    primaries = seen @ primary_spectra(nm)
    rgb = np.linalg.solve(primaries, seen @ np.interp(nm, wavelength_nm, reflectance))
    return np.clip(rgb, 0, 1)


def colour_matching(nm: Floats) -> Floats:
    """x, y and z of the CIE 1931 observer, (3, W)."""
    rows = []
    for lobes in _LOBES:
        row = np.zeros_like(nm)
        for height, peak, below, above in lobes:
            row += height * np.exp(-0.5 * ((nm - peak) * np.where(nm < peak, below, above)) ** 2)
        rows.append(row)
    return np.array(rows)
