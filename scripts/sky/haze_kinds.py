"""Hazes of other kinds than the tables': how much of them there is at each wavelength, what of it
is scattered and where to, from Mie's theory by sasktran2.

Urban and maritime haze are mixtures of OPAC (Hess, Koepke and Schult, Bull. Am. Meteorol. Soc. 79,
831, 1998) at 80 % humidity: "urban" and "maritime clean". Dry radii and widths are those of its
table 1c as geisa.aeris-data.fr/opac has it; numbers of particles as transcribed from its table of
types in the package pymopsmap; radii of wet sea salt those of GADS (Koepke et al. 1997) in the
source of ECHAM4; that of wet water-soluble particles by their volume in OPAC's own output of
"continental polluted". Refractive indices are those of Shettle and Fenn (1979), recalled, not read
again; with them that output is met at 550 nm within 1e-4 (tests/python/test_haze_kinds.py).

Smoke is that of Amazonian forest (Dubovik et al., J. Atmos. Sci. 59, 590, 2002, table 1), small
particles alone, recalled, not read again.
"""

from dataclasses import dataclass

import numpy as np
from atmosphere import ANGLE_DEG, HAZE_REFERENCE_NM

# Refractive indices by wavelength, nm: of what is dry, and of water.
_NM = np.array([300.0, 337.1, 400.0, 488.0, 514.5, 550.0, 632.8, 694.3])
_WATER = 1.333 + np.array([0.016, 0.0115, 0.006, 0.0025, 0.001, 0.0, -0.0015, -0.002])
_SOLUBLE = 1.53 - 1j * np.array([8, 5, 5, 5, 5, 6, 6, 7]) * 1e-3
_SOOT = np.array([1.74, 1.75, 1.75, 1.75, 1.75, 1.75, 1.75, 1.75]) - 1j * np.array(
    [0.47, 0.47, 0.46, 0.45, 0.45, 0.44, 0.43, 0.43]
)
_SALT = np.array([1.51, 1.51, 1.50, 1.50, 1.50, 1.50, 1.49, 1.49]) + 0j
_DUST = np.full(len(_NM), 1.53 - 0.008j)


@dataclass(frozen=True)
class Mode:
    """Particles, lognormal by number.

    index: by _NM, when dry.
    dry_um, wet_um: median radius.
    width: geometric.
    """

    index: np.ndarray
    dry_um: float
    wet_um: float
    width: float


_COMPONENTS = {
    "soluble": Mode(_SOLUBLE, 0.0212, 0.0306, 2.24),
    "insoluble": Mode(_DUST, 0.471, 0.471, 2.51),
    "soot": Mode(_SOOT, 0.0118, 0.0118, 2.00),
    "fine salt": Mode(_SALT, 0.209, 0.416, 2.03),
    "coarse salt": Mode(_SALT, 1.75, 3.49, 2.03),
    # Volume median 0.14 um, standard deviation of the logarithm 0.40.
    "smoke": Mode(
        np.full(len(_NM), 1.47 - 0.0093j), *[0.14 * np.exp(-3 * 0.4**2)] * 2, np.exp(0.4)
    ),
}
_MOST_UM, _MOST_COARSE_UM = 20.0, 60.0
# How many of each.
KINDS = {
    "urban": {"soluble": 28000, "insoluble": 1.5, "soot": 130000},
    "maritime": {"soluble": 1500, "fine salt": 20, "coarse salt": 3.2e-3},
    "smoke": {"smoke": 1},
    "continental polluted": {"soluble": 15700, "insoluble": 0.6, "soot": 34300},
}
STORED = ("urban", "maritime", "smoke")


def optics(kind: str, wavelength_nm: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Extinction over that at 550 nm, share scattered, and phase matrix [wavelength, ANGLE_DEG, 4]
    as in `atmosphere.Scatterer`."""
    total, scattered, phase = cross_sections(kind, np.append(wavelength_nm, HAZE_REFERENCE_NM))
    share = scattered / total
    return total[:-1] / total[-1], share[:-1], phase[:-1]


def cross_sections(kind: str, wavelength_nm: np.ndarray) -> tuple[np.ndarray, ...]:
    """Extinction and scattering, um2 for all particles, and the phase matrix."""
    sums = [0.0, 0.0, 0.0]
    for name, count in KINDS[kind].items():
        for k, part in enumerate(_of_mode(_COMPONENTS[name], wavelength_nm)):
            sums[k] = sums[k] + count * part
    total, scattered, intensity = sums
    return total, scattered, intensity / scattered[:, None, None]


def _of_mode(mode: Mode, wavelength_nm: np.ndarray) -> tuple[np.ndarray, ...]:
    """Cross-sections of extinction and scattering, um2, and scattering times phase matrix."""
    from sasktran2.mie.wrappers import LinearizedMie

    water = 1 - (mode.dry_um / mode.wet_um) ** 3  # by volume
    index = water * _WATER + (1 - water) * mode.index
    most = _MOST_COARSE_UM if mode.wet_um > 1 else _MOST_UM
    # Beyond five widths of the median there is nothing that counts, weighted by the square.
    ln_width = np.log(mode.width)
    reach = np.minimum(np.log(mode.wet_um) + ln_width * np.array([-4.0, 2 + 6.0]), np.log(most))
    ln_radius = np.linspace(*reach, 160)
    radius = np.exp(ln_radius)
    share = np.exp(-0.5 * ((ln_radius - np.log(mode.wet_um)) / ln_width) ** 2)
    share *= (ln_radius[1] - ln_radius[0]) / (ln_width * np.sqrt(2 * np.pi))
    cosine = np.cos(np.radians(ANGLE_DEG))
    total, scattered, intensity = [], [], []
    for nm in wavelength_nm:
        k = 2 * np.pi / (nm / 1000)
        each = LinearizedMie().calculate(k * radius, np.interp(nm, _NM, index), cosine)
        area = share * np.pi * radius**2
        total.append(area @ each.Qext)
        scattered.append(area @ each.Qsca)
        s1, s2 = each.S1, each.S2
        across, along = share @ np.abs(s1) ** 2, share @ np.abs(s2) ** 2
        both = share @ np.real(s1 * np.conj(s2))
        matrix = [0.5 * (along + across), 0.5 * (along - across), 0.5 * (along + across), both]
        intensity.append(4 * np.pi / k**2 * np.stack(matrix, axis=-1))
    return np.array(total), np.array(scattered), np.array(intensity)
