"""Clear skies above the sea: what less air makes of tables that are of sea level.

In flat air what comes from a direction depends on the optical depth of the air, wherever it is, and
air's depth falls with wavelength. So what a sky is over less air is read off along the tables' own
wavelengths, without ozone, whose depth goes another way.
"""

from __future__ import annotations

import numpy as np

from omma.base.arrays import Floats

MOST_HEIGHT_M = 5000.0
# US Standard Atmosphere 1976, which has these up to 11 km (with a gas constant 2e-5 lower).
_EARTH_M, _KELVIN, _KELVIN_PER_M = 6356766.0, 288.15, 0.0065
_GRAVITY, _KG_PER_MOL, _GAS = 9.80665, 0.0289644, 8.314462618
# Air at sea level would reach up to here, were it as dense all the way; and the middle of ozone.
AIR_HEIGHT_M = _GAS * _KELVIN / (_GRAVITY * _KG_PER_MOL)
_OZONE_HEIGHT_M = 22e3
# Below, ozone takes too much to be taken out of the tables.
_OZONE_FREE_NM = 320.0
# Optical depth with which a sky over its first guess is nearly a polynomial, and its degree.
_BEND, _DEGREE = 0.3, 4


def air_above(height_m: float) -> tuple[float, float]:
    """Pressure over that at sea level, and temperature likewise, with which goes how far up the air
    thins by e."""
    geopotential_m = _EARTH_M * height_m / (_EARTH_M + height_m)
    warmth = 1 - _KELVIN_PER_M * geopotential_m / _KELVIN
    power = _GRAVITY * _KG_PER_MOL / (_GAS * _KELVIN_PER_M)
    return float(warmth**power), float(warmth)


def less_air(wavelength_nm: Floats, depth: Floats, share: float) -> Floats:
    """A matrix (K, K) that takes what clean air without ozone has at wavelengths where it is
    ``depth`` deep, (K,), to what changes with ``share`` of that air.

    By the polynomial that fits best, so that noise of the tables is not read as change.
    """
    used = wavelength_nm >= _OZONE_FREE_NM

    def powers(of: Floats) -> Floats:
        return np.vander(of / (of + _BEND), _DEGREE + 1)

    change = np.zeros((len(depth), len(depth)))
    change[:, used] = (powers(share * depth) - powers(depth)) @ np.linalg.pinv(powers(depth[used]))
    return change


def longer_ways(sun_deg: float, height_m: float) -> Floats:
    """Ways of the sun's rays through air, ozone and haze over those at sea level, each over the
    column upwards, (3,).

    Of air by Chapman's function for low suns, sqrt(pi X / 2) erfcx(sin e sqrt(X / 2)), X the
    earth's radius over the height in which air thins by e; ozone as a thin layer. Haze thins alike
    everywhere.
    """
    from scipy.special import erfcx

    sine, cosine = np.sin(np.radians(sun_deg)), np.cos(np.radians(sun_deg))
    thinner = air_above(height_m)[1] ** -0.5
    along = sine * np.sqrt(_EARTH_M / (2 * AIR_HEIGHT_M))
    air = thinner * erfcx(thinner * along) / erfcx(along)
    near, far = (
        1 - (cosine * _EARTH_M / (_EARTH_M + _OZONE_HEIGHT_M - h)) ** 2 for h in (height_m, 0.0)
    )
    return np.array([air, np.sqrt(far / near), 1.0])
