"""The grids of the sky tables, and what is computed of them in which way."""

import numpy as np

WAVELENGTH_NM = np.array(
    [300, 305, 310, 315, 320, 325, 330, 335, 345, 360, 380, 400, 425, 450, 475, 500]
    + [520, 540, 560, 580, 600, 625, 660, 700],
    float,
)
ELEVATION_DEG = np.array(
    [0, 0.8, 1.8, 3.2, 5, 7.5, 10.5, 14.5, 19.5, 25.5, 32.5, 40.5, 49.5, 59.5, 70, 80, 89.5]
)
AZIMUTH_DEG = np.linspace(0, 180, 25)  # less that of the sun

# By Monte Carlo; high suns besides by discrete ordinates, which have no noise and are too bright by
# less than 1 %. In twilight few paths find light, so there are more of them.
ORDINATES_SUN_DEG = np.array([90, 80, 70, 60, 50, 40, 35, 30, 25, 20, 17, 14], float)
LOW_SUN_DEG = np.array([11, 9, 7, 5, 4, 3, 2, 1, 0, -1, -2], float)
TWILIGHT_SUN_DEG = np.array([-3, -4, -5, -6, -7, -8], float)
SUN_DEG = np.concatenate([ORDINATES_SUN_DEG, LOW_SUN_DEG, TWILIGHT_SUN_DEG])
MONTE_CARLO_AZIMUTH_DEG = AZIMUTH_DEG[::2]

HAZE = np.array([0.0, 0.05, 0.1, 0.2, 0.3])  # optical depth at 550 nm
# Of Monte Carlo a batch: low suns, twilight.
PATHS = {haze: (8_000, 16_000) if haze == 0 else (3_000, 5_000) for haze in HAZE}
# What discrete ordinates of high suns are off by needs more paths and fewer azimuths.
HIGH_AZIMUTH_DEG = AZIMUTH_DEG[::4]
HIGH_PATHS = 20_000

OZONE_DU = np.array([200.0, 300.0, 450.0])
OZONE_ELEVATION_DEG = np.array([1.8, 10.5, 32.5, 89.5])
OZONE_AZIMUTH_DEG = np.array([0.0, 90.0, 180.0])
OZONE_PATHS = 2_000

# Of the ground above the sea, and where skies over it are computed by Monte Carlo.
HEIGHT_M = np.array([0.0, 2500.0, 5000.0])
HEIGHT_SUN_DEG = np.concatenate([LOW_SUN_DEG, TWILIGHT_SUN_DEG])
HEIGHT_ELEVATION_DEG = np.array([0, 2, 5, 10.5, 19.5, 32.5, 55, 89.5])
HEIGHT_AZIMUTH_DEG = np.linspace(0, 180, 5)
HEIGHT_PATHS = 6_000

GROUND_SUN_DEG = 50.0  # under which the ground's share is taken; it is the same for every sun
