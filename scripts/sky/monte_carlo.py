"""The sky from Monte Carlo: compiles monte_carlo.cpp with g++ and calls it."""

import ctypes
import functools
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from atmosphere import EARTH_RADIUS_M, HAZE_SCALE_HEIGHT_M, Atmosphere, air_density, ozone_profile

LANES = 8  # wavelengths that share paths, as in monte_carlo.cpp
SOURCE = Path(__file__).with_name("monte_carlo.cpp")


def sky_stokes(
    atmosphere: Atmosphere,
    sun_elevation_deg: np.ndarray,
    elevation_deg: float,
    relative_azimuth_deg: np.ndarray,
    paths: int,
    batches: int = 8,
    seed: int = 1,
    most_scatterings: int = 100,
) -> tuple[np.ndarray, np.ndarray]:
    """I, Q, U over irradiance 1 of the sun, and standard errors, of one elevation of the sky.

    Both are [sun, azimuth, 3, wavelength]; ``paths`` are those of a batch. What is random is the
    same for all suns and azimuths, so that errors are smooth over them.
    """
    suns = np.radians(np.asarray(sun_elevation_deg))[:, None]
    azimuths = -np.radians(np.asarray(relative_azimuth_deg))[None]
    directions = np.stack(
        [
            np.cos(suns) * np.sin(azimuths),
            np.sin(suns) + 0 * azimuths,
            -np.cos(suns) * np.cos(azimuths),
        ],
        axis=-1,
    )
    elevation = np.radians(np.clip(elevation_deg, 0.05, 89.95))
    way = np.array([0.0, np.sin(elevation), -np.cos(elevation)])
    radius, density = _shells(len(atmosphere.scatterers) > 1, atmosphere.ground_m)
    count = len(atmosphere.wavelength_nm)
    means = np.zeros((directions.shape[0], directions.shape[1], 3, count))
    errors = np.zeros_like(means)
    for first in range(0, count, LANES):
        lanes = np.minimum(first + np.arange(LANES), count - 1)
        depth, scattered, phase = _optics(atmosphere, lanes)
        result = np.zeros((batches, directions.shape[0] * directions.shape[1], 3, LANES))
        _library().omma_sky_monte_carlo(
            len(radius) - 1,
            *(_pointer(a) for a in (radius, density, depth, scattered, phase, way)),
            result.shape[1],
            _pointer(directions.reshape(-1, 3).copy()),
            batches,
            paths,
            most_scatterings,
            ctypes.c_uint64(seed + 1000 * first),
            _pointer(result),
        )
        shaped = result.reshape(batches, *directions.shape[:2], 3, LANES)
        kept = slice(first, min(first + LANES, count))
        means[..., kept] = shaped.mean(axis=0)[..., : kept.stop - first]
        spread = shaped.std(axis=0, ddof=1) / np.sqrt(batches)
        errors[..., kept] = spread[..., : kept.stop - first]
    return means, errors


@functools.cache
def _library() -> ctypes.CDLL:
    folder = Path(tempfile.mkdtemp(prefix="omma_sky_"))
    built = folder / "monte_carlo.so"
    command = ["g++", "-O3", "-march=native", "-ffast-math", "-std=c++20", "-shared", "-fPIC"]
    subprocess.run([*command, str(SOURCE), "-o", str(built)], check=True)
    library = ctypes.CDLL(str(built))
    library.omma_sky_monte_carlo.restype = None
    return library


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    assert array.dtype == np.float64
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.c_void_p)


def _shells(haze: bool, ground_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Borders' distances from the earth's centre, m, and share of each column per m in a shell."""
    border = 1000.0 * np.concatenate(
        [np.arange(0, 15, 0.25), np.arange(15, 50, 0.5), np.arange(50, 101, 2.0)]
    )
    shares = []
    for profile in (
        lambda altitude: air_density(altitude + ground_m),
        lambda altitude: ozone_profile(altitude + ground_m),
        lambda altitude: np.exp(-altitude / HAZE_SCALE_HEIGHT_M),
    ):
        fine = np.linspace(0, border[-1], 50_001)
        values = profile(fine)
        steps = 0.5 * (values[1:] + values[:-1]) * np.diff(fine)
        sums = np.concatenate([[0], np.cumsum(steps)])
        shares.append(np.diff(np.interp(border, fine, sums)) / sums[-1] / np.diff(border))
    if not haze:
        shares[2][:] = 0
    return EARTH_RADIUS_M + border, np.ascontiguousarray(shares)


def _optics(atmosphere: Atmosphere, lanes: np.ndarray) -> tuple[np.ndarray, ...]:
    """Depth, share scattered and phase matrix of air, ozone and haze, in the lanes and for paths.

    Paths go as the wavelength in the middle of the lanes does.
    """
    altitude = atmosphere.altitude_m
    every = np.concatenate([lanes, lanes[[len(lanes) // 2]]])
    depth, scattered = np.zeros((3, LANES + 1)), np.zeros((3, LANES + 1))
    angles = atmosphere.scatterers[0].phase.shape[1]
    phase = np.zeros((3, angles, LANES + 1, 4))
    depth[1] = _column(atmosphere.absorption, altitude)[every]
    for row, one in zip((0, 2), atmosphere.scatterers):
        depth[row] = _column(one.extinction, altitude)[every]
        scattered[row] = one.scattered[every]
        phase[row] = one.phase[every].transpose(1, 0, 2)
    return depth, scattered, phase


def _column(extinction: np.ndarray, altitude_m: np.ndarray) -> np.ndarray:
    return np.trapezoid(extinction, altitude_m, axis=0)
