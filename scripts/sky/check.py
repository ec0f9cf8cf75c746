"""Compares the stored tables with direct computations between their nodes."""

import monte_carlo
import numpy as np
from atmosphere import clear_atmosphere

NM = np.array([312.0, 332.0, 352.0, 390.0, 440.0, 510.0, 570.0, 650.0])
AZIMUTH_DEG = np.array([3.0, 40.0, 94.0, 131.0, 176.0])
ELEVATION_DEG = np.array([1.3, 4.0, 9.0, 22.0, 45.0, 65.0, 87.0])
HIGH_SUN_DEG = (85.0, 65.0, 45.0, 32.0, 22.0, 15.5)
LOW_SUN_DEG = (12.5, 6.0, 3.5, -2.5, -4.5)
PATHS, BATCHES = 2_000, 8  # more in twilight, and under high suns, whose tables have less noise
OTHERS = (  # haze, ozone
    *((haze, 300.0) for haze in (0.025, 0.075, 0.15, 0.25)),
    *((0.0, ozone) for ozone in (250.0, 400.0)),
)
KINDS = ("urban", "maritime", "smoke")
AIRS = (  # sun, haze, ozone, height of the ground, m, and another kind of haze
    *((sun, 0.0, 300.0, 0.0) for sun in HIGH_SUN_DEG),
    *((45.0, *air, 0.0) for air in OTHERS),
    *((sun, 0.0, 300.0, 0.0) for sun in LOW_SUN_DEG),
    *((6.0, *air, 0.0) for air in OTHERS),
    *((sun, 0.0, 300.0, 2000.0) for sun in (45.0, 20.0, 6.0, 2.0, -2.5, -4.5)),
    *((sun, 0.0, 300.0, 5000.0) for sun in (45.0, 20.0, 6.0, 2.0, -2.5)),
    *((sun, 0.1, 300.0, 2000.0) for sun in (45.0, 20.0, 6.0)),
    (45.0, 0.15, 300.0, 5000.0),
    *((sun, 0.2, 300.0, 0.0, kind) for kind in KINDS for sun in (45.0, 20.0)),
)


def check_tables(suns: list[float]) -> None:
    """Prints, for each sun and for other air, how far the tables are from direct computation: of
    all suns, or of those given.
    """
    print(
        "sun, haze, ozone, height, kind: radiance rms % (worst), polarisation rms (worst)",
        flush=True,
    )
    for sun, *air in AIRS:
        if not suns or sun in suns:
            _compare(sun, *air)


def _compare(sun: float, haze: float, ozone: float, ground_m: float, kind: str = "rural") -> None:
    direct, error = _monte_carlo(sun, haze, ozone, ground_m, kind)
    parts = 100 * error[:, :, 0] / direct[:, :, 0], error[:, :, 1:] / direct[:, :, :1]
    stored = stored_stokes(sun, haze, ozone, ground_m, kind)
    off = 100 * (stored[:, :, 0] / direct[:, :, 0] - 1)
    polarised = np.hypot(
        *np.moveaxis(
            stored[:, :, 1:] / stored[:, :, :1] - direct[:, :, 1:] / direct[:, :, :1], 2, 0
        )
    )
    up, round_, k = np.unravel_index(np.abs(off).argmax(), off.shape)
    worst = f"{ELEVATION_DEG[up]:g}° up, {AZIMUTH_DEG[round_]:g}° round, {NM[k]:g} nm"
    print(
        f"{sun:5.1f} {haze:5.3f} {ozone:4.0f} {ground_m:4.0f} {kind}: "
        f"{_rms(off):5.2f} ({np.abs(off).max():5.2f})  "
        f"{_rms(polarised):.4f} ({polarised.max():.4f})  Monte Carlo's own {_rms(parts[0]):.2f} % "
        f"and {_rms(parts[1]) * 2**0.5:.4f}; worst {worst}",
        flush=True,
    )


def _monte_carlo(
    sun: float, haze: float, ozone: float, ground_m: float, kind: str
) -> tuple[np.ndarray, np.ndarray]:
    """Stokes [elevation, azimuth, 3, wavelength] and standard errors; half the wavelengths a time,
    as those that share paths must be near each other.
    """
    paths = PATHS if -2 < sun < 14 else 4 * PATHS
    halves = []
    for nm in (NM[:4], NM[4:]):
        air = clear_atmosphere(nm, ozone, haze, ground_m, kind)
        each = [
            monte_carlo.sky_stokes(air, np.array([sun]), e, AZIMUTH_DEG, paths, BATCHES, 77)
            for e in ELEVATION_DEG
        ]
        halves.append(np.array(each)[:, :, 0])  # [elevation, mean or error, azimuth, 3, wavelength]
    both = np.concatenate(halves, axis=-1)
    return both[:, 0], both[:, 1]


def stored_stokes(sun: float, haze: float, ozone: float, ground_m: float, kind: str) -> np.ndarray:
    """The tables over black ground and irradiance 1: [elevation, azimuth, 3, wavelength]."""
    from omma.light.sky_tables import TableSky

    log_i, q, u = TableSky(sun, haze, ozone, ground_m, kind).stokes(ELEVATION_DEG, AZIMUTH_DEG, NM)
    i = np.exp(log_i)
    return np.stack([i, i * q, i * u], axis=2)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
