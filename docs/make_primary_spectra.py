"""Makes src/receptor/primary_spectra.h: three spectra that stand for the linear sRGB primaries.

    .venv/bin/python docs/make_primary_spectra.py

They are what Mallett and Yuksel (Spectral primary decomposition for rendering with sRGB
reflectance, EGSR 2019) ask for: the shares of white's light that red, green and blue take, between
0 and 1 and together 1 at every wavelength, as smooth as can be, each with the chromaticity of its
sRGB primary. White is CIE D65, as in sRGB. Here they reach from 400 to 700 nm, because below that
RGB says nothing of what a bee sees.

Colour matching functions: the multi-lobe fit of Wyman, Sloan and Shirley (JCGT 2(2), 2013). Under
it, and within 400 to 700 nm, D65 has a white of its own, within 0.001 of sRGB's in x and y; the
primaries are scaled to add up to that one, their chromaticities are sRGB's.
"""

from pathlib import Path

import numpy as np
from scipy.optimize import minimize

TABLE = Path(__file__).resolve().parent.parent / "src" / "receptor" / "primary_spectra.h"

WAVELENGTH_NM = np.arange(400.0, 701.0, 10.0)

# CIE standard illuminant D65, relative power at 400, 410, ... 700 nm (CIE 15:2004, table T.1).
D65 = np.array(
    [82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811]
    + [109.354, 107.802, 104.790, 107.689, 104.405, 104.046, 100.000, 96.3342, 95.7880, 88.6856]
    + [90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213]
    + [71.6091]
)

# Chromaticities x, y of the primaries of sRGB (IEC 61966-2-1), red, green, blue.
PRIMARIES_XY = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])


def lobe(nm: np.ndarray, height: float, peak_nm: float, below: float, above: float) -> np.ndarray:
    """A Gaussian with an inverse width below its peak and another above."""
    t = (nm - peak_nm) * np.where(nm < peak_nm, below, above)
    return height * np.exp(-0.5 * t**2)


def colour_matching(nm: np.ndarray) -> np.ndarray:
    """x, y and z of the CIE 1931 observer, (3, wavelengths)."""
    x = lobe(nm, 0.362, 442.0, 0.0624, 0.0374) + lobe(nm, 1.056, 599.8, 0.0264, 0.0323)
    x += lobe(nm, -0.065, 501.1, 0.0490, 0.0382)
    y = lobe(nm, 0.821, 568.8, 0.0213, 0.0247) + lobe(nm, 0.286, 530.9, 0.0613, 0.0322)
    z = lobe(nm, 1.217, 437.0, 0.0845, 0.0278) + lobe(nm, 0.681, 459.0, 0.0385, 0.0725)
    return np.array([x, y, z])


def weights() -> np.ndarray:
    """XYZ of a spectrum given at WAVELENGTH_NM, lit by D65, as weights of its values, (3, knots).

    Between its knots a spectrum is linear, so the integral is one of hats, done at 1 nm.
    """
    fine = np.arange(400.0, 700.5, 1.0)
    hats = np.array([np.interp(fine, WAVELENGTH_NM, row) for row in np.eye(len(WAVELENGTH_NM))])
    seen = colour_matching(fine) * np.interp(fine, WAVELENGTH_NM, D65)
    seen[:, [0, -1]] *= 0.5
    return seen @ hats.T / seen[1].sum()


def primary_spectra() -> np.ndarray:
    """The three spectra, (3, wavelengths)."""
    to_xyz = weights()
    white = to_xyz.sum(axis=1)
    x, y = PRIMARIES_XY.T
    directions = np.array([x / y, np.ones(3), (1 - x - y) / y])
    xyz = directions * np.linalg.solve(directions, white)  # [X Y Z, primary], adding up to white
    count = len(WAVELENGTH_NM)
    # Unknown are red and green; blue is what is left of white, so that its colour follows.
    bend = np.diff(np.eye(count), axis=0)
    zero = np.zeros_like(bend)
    slopes = np.block([[bend, zero], [zero, bend], [bend, bend]])
    quadratic = slopes.T @ slopes
    colours = np.block([[to_xyz, np.zeros_like(to_xyz)], [np.zeros_like(to_xyz), to_xyz]])
    wanted = xyz[:, :2].T.ravel()
    both = np.hstack([np.eye(count), np.eye(count)])
    found = minimize(
        lambda v: 0.5 * v @ quadratic @ v,
        np.full(2 * count, 1 / 3),
        jac=lambda v: quadratic @ v,
        bounds=[(0.0, 1.0)] * (2 * count),
        constraints=[
            {"type": "eq", "fun": lambda v: colours @ v - wanted, "jac": lambda v: colours},
            {"type": "ineq", "fun": lambda v: 1 - both @ v, "jac": lambda v: -both},
        ],
        method="SLSQP",
        options={"maxiter": 2000, "ftol": 1e-14},
    )
    assert found.success, found.message
    red, green = np.clip(found.x, 0, 1).reshape(2, count)
    spectra = np.round([red, green, 1 - red - green], 6)
    assert spectra.min() >= -2e-6
    spectra[2] = np.maximum(1 - spectra[0] - spectra[1], 0)
    error = np.abs(to_xyz @ spectra.T - xyz).max()
    assert error < 2e-6, error
    return spectra


def main() -> None:
    knots = [f"{{{r:.6f}, {g:.6f}, {b:.6f}}}," for r, g, b in primary_spectra().T]
    rows = ["    " + " ".join(knots[i : i + 3]) for i in range(0, len(knots), 3)]
    TABLE.write_text(
        "// Made by docs/make_primary_spectra.py, which says what they are: the shares of white's\n"
        "// light that the linear sRGB primaries take at 400, 410, ... 700 nm, linear between.\n"
        "#pragma once\n\n"
        "namespace omma {\n\n"
        f"inline constexpr int primary_knots = {len(knots)};\n"
        "inline constexpr double first_primary_nm = 400, primary_step_nm = 10;\n\n"
        "// [knot][red, green, blue]\n"
        "inline constexpr double primary_table[primary_knots][3] = {\n"
        + "\n".join(rows)
        + "\n};\n\n}  // namespace omma\n"
    )
    print(f"wrote {TABLE}")


if __name__ == "__main__":
    main()
