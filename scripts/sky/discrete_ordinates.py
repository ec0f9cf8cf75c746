"""The sky from sasktran2: discrete ordinates for light scattered often, exact for the first time.

The package sasktran2 solves polarised
radiative transfer. What its settings must be for an observer on the ground that looks up, and what
does not work, was found out against the tables of Natraj, Li and Yung (2009): Q and U are wrong
exactly at the zenith, so rays stay half a degree away.
"""

import numpy as np
from atmosphere import EARTH_RADIUS_M, MOMENTS, Atmosphere

HIGHEST_DEG = 89.5
LOWEST_DEG = 0.05


def sky_stokes(
    atmosphere: Atmosphere,
    sun_elevation_deg: float,
    elevation_deg: np.ndarray,
    relative_azimuth_deg: np.ndarray,
    albedo: float = 0.0,
    streams: int = 16,
    earth_radius_m: float = EARTH_RADIUS_M,
) -> np.ndarray:
    """I, Q, U of the sky over irradiance 1 of the sun: [elevation, azimuth, 3, wavelength].

    Relative azimuth 0 is the sun's. Q and U are Omma's: from the vertical, turning to the right as
    one looks along the ray, which is ``relative_azimuth_deg`` to the right of the sun.
    """
    import sasktran2 as sk

    config = sk.Config()
    config.num_stokes = 3
    config.single_scatter_source = sk.SingleScatterSource.Exact
    config.multiple_scatter_source = sk.MultipleScatterSource.DiscreteOrdinates
    config.num_streams = streams
    config.num_singlescatter_moments = MOMENTS if len(atmosphere.scatterers) > 1 else streams
    config.delta_m_scaling = len(atmosphere.scatterers) > 1
    config.num_sza = 1 if sun_elevation_deg > 15 else 9
    sun_cosine = np.sin(np.radians(sun_elevation_deg))
    geometry = sk.Geometry1D(
        sun_cosine,
        0.0,
        earth_radius_m,
        atmosphere.altitude_m,
        sk.InterpolationMethod.LinearInterpolation,
        sk.GeometryType.Spherical,
    )
    rays = sk.ViewingGeometry()
    for elevation in np.clip(elevation_deg, LOWEST_DEG, HIGHEST_DEG):
        for azimuth in relative_azimuth_deg:
            rays.add_ray(
                sk.SolarAnglesObserverLocation(
                    sun_cosine, np.radians(azimuth), np.sin(np.radians(elevation)), 0.0
                )
            )
    table = sk.Atmosphere(
        geometry, config, numwavel=len(atmosphere.wavelength_nm), calculate_derivatives=False
    )
    _fill(table, atmosphere, config.num_singlescatter_moments, albedo)
    radiance = sk.Engine(config, geometry, rays).calculate_radiance(table)["radiance"]
    values = radiance.transpose("los", "stokes", "wavelength").to_numpy()
    # sasktran2's azimuths turn the other way.
    values *= np.array([1.0, 1.0, -1.0])[:, None]
    return values.reshape(len(elevation_deg), len(relative_azimuth_deg), 3, -1)


def _fill(table: object, atmosphere: Atmosphere, moments: int, albedo: float) -> None:
    """Hands the atmosphere to sasktran2's."""
    extinction = atmosphere.absorption.copy()
    scattering = np.zeros_like(extinction)
    weighted = 0.0
    for one in atmosphere.scatterers:
        extinction += one.extinction
        part = one.extinction * one.scattered
        scattering += part
        weighted = weighted + part * one.moments[:moments, :, None]
    table.storage.total_extinction[:] = extinction
    table.storage.ssa[:] = scattering / extinction
    mixed = weighted / scattering
    table.leg_coeff.a1[:] = mixed[:, 0]
    table.leg_coeff.a2[:] = mixed[:, 1]
    table.leg_coeff.a3[:] = mixed[:, 2]
    table.leg_coeff.b1[:] = mixed[:, 3]
    table.surface.albedo[:] = albedo
