"""The clear atmosphere that the sky tables are computed for: what scatters and absorbs, where.

Air as in the US Standard Atmosphere 1976, with Rayleigh scattering after Bodhaine et al. (J. Atmos.
Oceanic Technol. 16, 1854, 1999: cross-section eq. 29, King factor eqs. 5, 6 and 23). Ozone with the
profile of that atmosphere, scaled to a column, and the cross-sections of Malicet et al. (J. Atmos.
Chem. 21, 263, 1995; 228 K, near ozone's mean temperature) and above 345 nm of Brion et al. (J.
Atmos. Chem. 30, 291, 1998). Haze, where there is some: the small particles of the rural model of
Shettle and Fenn (AFGL-TR-79-0214, 1979) at 70 % humidity, thinning out exponentially with 2 km.
Profiles, cross-sections and the sun's spectrum (Chance and Kurucz, J. Quant. Spectrosc. Radiat.
Transfer 111, 1289, 2010) are read from the package musica, which ships them.
"""

import functools
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np

EARTH_RADIUS_M = 6.371e6
DOBSON_PER_M2 = 2.6867e20  # molecules in a column of one Dobson unit
HAZE_SCALE_HEIGHT_M = 2000.0
HAZE_REFERENCE_NM = 550.0
# Lognormal by number: median radius, geometric width, refractive index (dry 0.027 um, 2.24 and
# 1.53 - 0.0066i, grown by water at 70 % humidity to 0.02846 um).
HAZE_RADIUS_NM, HAZE_WIDTH, HAZE_INDEX = 28.46, 2.2387, 1.501 - 0.0056j
# Angles of scattering where phase functions are tabulated: even by the sine of their half.
ANGLE_DEG = np.degrees(2 * np.arcsin(np.linspace(0, 1, 721)))
MOMENTS = 128  # Legendre moments of phase functions


@dataclass(frozen=True)
class Scatterer:
    """What scatters like one: extinction and its phase matrix, normalised to a mean of 1."""

    extinction: np.ndarray  # [altitude, wavelength], per m
    scattered: np.ndarray  # [wavelength], the share of extinction that is scattered
    # [wavelength, ANGLE_DEG, 4]: P11, P12, P22, P33
    phase: np.ndarray
    # [moment, 4, wavelength]: the Greek coefficients a1, a2, a3, b1 of that matrix
    moments: np.ndarray


@dataclass(frozen=True)
class Atmosphere:
    """An atmosphere over a black ground, on a grid of altitudes and wavelengths."""

    altitude_m: np.ndarray  # [altitude], above the ground
    wavelength_nm: np.ndarray  # [wavelength]
    absorption: np.ndarray  # [altitude, wavelength], per m: ozone
    scatterers: tuple[Scatterer, ...]  # air, and haze where there is some
    ground_m: float = 0.0  # above the sea


def standard_altitudes_m() -> np.ndarray:
    return (
        np.concatenate(
            [
                np.arange(0, 6, 0.2),
                np.arange(6, 16, 0.5),
                np.arange(16, 36, 1.0),
                np.arange(36, 50, 2.0),
                np.arange(50, 101, 10.0),
            ]
        )
        * 1000.0
    )


def clear_atmosphere(
    wavelength_nm: np.ndarray,
    ozone_du: float = 300.0,
    haze: float = 0.0,
    ground_m: float = 0.0,
    haze_kind: str = "rural",
) -> Atmosphere:
    """The atmosphere with that column of ozone and that optical depth of haze at 550 nm, both above
    the ground. Haze of other kinds is for Monte Carlo, and has no moments."""
    altitude = standard_altitudes_m()
    ozone = ozone_profile(altitude + ground_m)
    absorption = ozone[:, None] * ozone_du * ozone_per_du(wavelength_nm)
    scatterers = (air(altitude + ground_m, wavelength_nm),)
    if haze > 0:
        scatterers += (haze_layer(altitude, wavelength_nm, haze, haze_kind),)
    return Atmosphere(altitude, wavelength_nm, absorption, scatterers, ground_m)


def air_density(altitude_m: np.ndarray) -> np.ndarray:
    """Molecules per m3, US Standard Atmosphere 1976."""
    km, density = _columns("profiles/atmosphere/ussa.dens")
    return 1e6 * np.exp(_interpolate(altitude_m / 1000, km, np.log(density)))


def ozone_profile(altitude_m: np.ndarray) -> np.ndarray:
    """Share of the ozone column per m; its integral over a fine grid is 1."""
    km, density = _columns("profiles/atmosphere/ussa.ozone")
    values = np.exp(_interpolate(altitude_m / 1000, km, np.log(density)))
    return values / np.trapezoid(values, altitude_m)


def ozone_per_du(wavelength_nm: np.ndarray, width_nm: float = 5.0) -> np.ndarray:
    """Optical depth per Dobson unit, the mean over ``width_nm``."""
    nm, xs_m2 = _ozone_cross_section()
    return DOBSON_PER_M2 * np.array(
        [np.mean(xs_m2[np.abs(nm - at) <= width_nm / 2]) for at in wavelength_nm]
    )


def rayleigh_cross_section_m2(wavelength_nm: np.ndarray) -> np.ndarray:
    um2 = (wavelength_nm / 1000) ** 2
    above = 1.0455996 - 341.29061 / um2 - 0.90230850 * um2
    return 1e-32 * above / (1 + 0.0027059889 / um2 - 85.968563 * um2)


def king_factor(wavelength_nm: np.ndarray) -> np.ndarray:
    um2 = (wavelength_nm / 1000) ** 2
    nitrogen = 1.034 + 3.17e-4 / um2
    oxygen = 1.096 + 1.385e-3 / um2 + 1.448e-4 / um2**2
    share = np.array([78.084, 20.946, 0.934, 0.036])
    factors = [nitrogen, oxygen, np.ones_like(um2), np.full_like(um2, 1.15)]
    return share @ np.array(factors) / share.sum()


def rayleigh_anisotropy(wavelength_nm: np.ndarray) -> np.ndarray:
    """Delta: 1 for scatterers that do not depolarise."""
    factor = king_factor(wavelength_nm)
    depolarisation = 6 * (factor - 1) / (3 + 7 * factor)
    return (1 - depolarisation) / (1 + depolarisation / 2)


def rayleigh_phase(delta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Phase matrix and Greek coefficients of air; Hansen and Travis (1974), eq. 2.15."""
    cosine = np.cos(np.radians(ANGLE_DEG))
    d = delta[:, None]
    phase = np.stack(
        [
            0.75 * d * (1 + cosine**2) + (1 - d),
            -0.75 * d * (1 - cosine**2),
            0.75 * d * (1 + cosine**2),
            1.5 * d * cosine,
        ],
        axis=-1,
    )
    moments = np.zeros((MOMENTS, 4, len(delta)))
    moments[0, 0] = 1
    moments[2, 0] = delta / 2
    moments[2, 1] = 3 * delta
    moments[2, 3] = np.sqrt(1.5) * delta
    moments[1, 2] = 1.5 * delta
    return phase, moments


def air(altitude_m: np.ndarray, wavelength_nm: np.ndarray) -> Scatterer:
    extinction = air_density(altitude_m)[:, None] * rayleigh_cross_section_m2(wavelength_nm)
    phase, moments = rayleigh_phase(rayleigh_anisotropy(wavelength_nm))
    return Scatterer(extinction, np.ones(len(wavelength_nm)), phase, moments)


def haze_layer(
    altitude_m: np.ndarray, wavelength_nm: np.ndarray, depth: float, kind: str
) -> Scatterer:
    """Haze of that optical depth at 550 nm, from Mie's theory by sasktran2."""
    profile = np.exp(-altitude_m / HAZE_SCALE_HEIGHT_M)
    profile /= np.trapezoid(profile, altitude_m)
    if kind == "rural":
        total, scattered, phase, moments = haze_optics(tuple(wavelength_nm))
    else:
        from haze_kinds import optics

        total, scattered, phase = optics(kind, wavelength_nm)
        moments = np.zeros((0, 4, len(wavelength_nm)))
    return Scatterer(profile[:, None] * depth * total, scattered, phase, moments)


@functools.lru_cache(maxsize=8)
def haze_optics(
    wavelength_nm: tuple[float, ...],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Extinction over that at 550 nm, share scattered, phase matrix and moments."""
    from sasktran2.mie.distribution import LogNormalDistribution, integrate_mie_cpp

    sizes = LogNormalDistribution().distribution(
        median_radius=HAZE_RADIUS_NM, mode_width=HAZE_WIDTH
    )
    nm = np.array([*wavelength_nm, HAZE_REFERENCE_NM])
    optics = integrate_mie_cpp([sizes], lambda _: HAZE_INDEX, nm, num_coeffs=MOMENTS)
    optics = optics.isel(distribution=0)
    total = optics["xs_total"].to_numpy()
    scattered = optics["xs_scattering"].to_numpy() / total
    moments = np.stack(
        [optics[name].to_numpy()[:-1].T for name in ("lm_a1", "lm_a2", "lm_a3", "lm_b1")], axis=1
    )
    return total[:-1] / total[-1], scattered[:-1], phase_of(moments), moments


def phase_of(moments: np.ndarray) -> np.ndarray:
    """The phase matrix [wavelength, ANGLE_DEG, 4] of Greek coefficients [moment, 4, wavelength].

    In generalised spherical functions, de Haan et al. (Astron. Astrophys. 183, 371, 1987).
    """
    x = np.cos(np.radians(ANGLE_DEG))
    a1, a2, a3, b1 = np.moveaxis(moments, 1, 0)
    zero = np.zeros((len(moments), len(x)))
    p00, p02, p22, p2m = zero.copy(), zero.copy(), zero.copy(), zero.copy()
    p00[0], p00[1] = 1, x
    p02[2] = -np.sqrt(6) / 4 * (1 - x**2)
    p22[2], p2m[2] = (1 + x) ** 2 / 4, (1 - x) ** 2 / 4
    for n in range(1, len(moments) - 1):
        p00[n + 1] = ((2 * n + 1) * x * p00[n] - n * p00[n - 1]) / (n + 1)
    for n in range(2, len(moments) - 1):
        low, high = np.sqrt(n**2 - 4), np.sqrt((n + 1) ** 2 - 4)
        p02[n + 1] = ((2 * n + 1) * x * p02[n] - low * p02[n - 1]) / high
        for table, m in ((p22, 2), (p2m, -2)):
            ahead = (2 * n + 1) * (n * (n + 1) * x - 2 * m) * table[n]
            table[n + 1] = (ahead - (n + 1) * (n**2 - 4) * table[n - 1]) / (n * ((n + 1) ** 2 - 4))
    sum_23 = (a2 + a3).T @ p22
    difference_23 = (a2 - a3).T @ p2m
    return np.stack(
        [
            a1.T @ p00,
            b1.T @ p02,
            (sum_23 + difference_23) / 2,
            (sum_23 - difference_23) / 2,
        ],
        axis=-1,
    )


@functools.cache
def sun_spectrum() -> tuple[np.ndarray, np.ndarray]:
    """Irradiance above the air at one astronomical unit: nm (0.01 apart), W m-2 nm-1."""
    return _columns("profiles/solar/sao2010.solref.converted")


def _columns(name: str) -> tuple[np.ndarray, np.ndarray]:
    table = np.loadtxt(_data() / name, comments="#")
    return table[:, 0], table[:, 1]


def _data() -> Path:
    return Path(str(resources.files("musica"))) / "configs" / "tuvx" / "data"


def _interpolate(x: np.ndarray, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Linear, and on along the last two knots beyond them."""
    slope = (values[-1] - values[-2]) / (knots[-1] - knots[-2])
    inside = np.interp(x, knots, values)
    return np.where(x > knots[-1], values[-1] + slope * (x - knots[-1]), inside)


@functools.cache
def _ozone_cross_section() -> tuple[np.ndarray, np.ndarray]:
    import xarray as xr

    parts = []
    for name, row, low, high in (("O3_2", 2, 290, 345), ("O3_1", 0, 345.005, 720)):
        with xr.open_dataset(_data() / "cross_sections" / f"{name}.nc") as table:
            nm = table["wavelength"].to_numpy()
            inside = (nm >= low) & (nm <= high)
            values = table["cross_section_parameters"].to_numpy()[row, inside]
        parts.append((nm[inside], np.maximum(values, 0) * 1e-4))
    return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
