"""Computes the sky piece by piece; each is stored as it is done, so that a run can go on."""

from collections.abc import Callable
from pathlib import Path

import discrete_ordinates
import grid
import monte_carlo
import numpy as np
from atmosphere import clear_atmosphere


def compute(folder: Path, haze: float) -> None:
    """All pieces of one haze that ``folder`` does not have."""
    folder.mkdir(parents=True, exist_ok=True)
    atmosphere = clear_atmosphere(grid.WAVELENGTH_NM, haze=haze)
    for sun in grid.ORDINATES_SUN_DEG:
        _piece(
            folder / f"ordinates_{haze:g}_{sun:g}.npz",
            lambda sun=sun: {
                "stokes": discrete_ordinates.sky_stokes(
                    atmosphere, sun, grid.ELEVATION_DEG, grid.AZIMUTH_DEG
                )
            },
        )
    for albedo in (0.0, 0.5, 1.0):
        _piece(
            folder / f"ground_{haze:g}_{albedo:g}.npz",
            lambda albedo=albedo: {
                "stokes": discrete_ordinates.sky_stokes(
                    atmosphere,
                    grid.GROUND_SUN_DEG,
                    grid.ELEVATION_DEG,
                    grid.AZIMUTH_DEG[::8],
                    albedo,
                )
            },
        )
    low, twilight = grid.PATHS[haze]
    kinds = [
        ("low", grid.LOW_SUN_DEG, grid.MONTE_CARLO_AZIMUTH_DEG, low),
        ("twilight", grid.TWILIGHT_SUN_DEG, grid.MONTE_CARLO_AZIMUTH_DEG, twilight),
    ]
    if haze == 0:
        kinds.append(("high", grid.ORDINATES_SUN_DEG, grid.HIGH_AZIMUTH_DEG, grid.HIGH_PATHS))
    for elevation in grid.ELEVATION_DEG:
        for name, suns, azimuths, paths in kinds:
            _piece(
                folder / f"{name}_{haze:g}_{elevation:g}.npz",
                lambda suns=suns, azimuths=azimuths, paths=paths, elevation=elevation: (
                    _means_and_errors(atmosphere, suns, elevation, azimuths, paths)
                ),
            )


def compute_ozone(folder: Path) -> None:
    """Skies of other ozone columns, on few directions; the paths are the same for all columns."""
    suns = np.concatenate([grid.LOW_SUN_DEG, grid.TWILIGHT_SUN_DEG])
    for ozone in grid.OZONE_DU:
        atmosphere = clear_atmosphere(grid.WAVELENGTH_NM, ozone_du=ozone)
        for sun in grid.ORDINATES_SUN_DEG:
            _piece(
                folder / f"ozone_{ozone:g}_{sun:g}.npz",
                lambda sun=sun, atmosphere=atmosphere: {
                    "stokes": discrete_ordinates.sky_stokes(
                        atmosphere, sun, grid.OZONE_ELEVATION_DEG, grid.OZONE_AZIMUTH_DEG
                    )
                },
            )
        for elevation in grid.OZONE_ELEVATION_DEG:
            _piece(
                folder / f"ozone_{ozone:g}_low_{elevation:g}.npz",
                lambda elevation=elevation, atmosphere=atmosphere: _means_and_errors(
                    atmosphere, suns, elevation, grid.OZONE_AZIMUTH_DEG, grid.OZONE_PATHS
                ),
            )


def compute_heights(folder: Path) -> None:
    """Skies over high ground under low suns, on few directions; the paths are the same for all
    heights."""
    folder.mkdir(parents=True, exist_ok=True)
    for elevation in grid.HEIGHT_ELEVATION_DEG:
        for height in grid.HEIGHT_M:
            atmosphere = clear_atmosphere(grid.WAVELENGTH_NM, ground_m=height)
            _piece(
                folder / f"height_{height:g}_{elevation:g}.npz",
                lambda elevation=elevation, atmosphere=atmosphere: _means_and_errors(
                    atmosphere,
                    grid.HEIGHT_SUN_DEG,
                    elevation,
                    grid.HEIGHT_AZIMUTH_DEG,
                    grid.HEIGHT_PATHS,
                ),
            )


def _means_and_errors(*arguments: object) -> dict[str, np.ndarray]:
    stokes, error = monte_carlo.sky_stokes(*arguments)
    return {"stokes": stokes, "error": error}


def _piece(path: Path, make: Callable[[], dict[str, np.ndarray]]) -> None:
    if path.exists():
        return
    part = path.with_suffix(".part.npz")
    np.savez(part, **make())
    part.rename(path)
    print(path.name, flush=True)
