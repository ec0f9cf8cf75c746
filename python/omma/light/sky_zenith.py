"""Skies are smooth at the zenith: what tables of low suns have there by chance is taken out.

What changes about the zenith as cos(n azimuth) goes with the power |n| of the distance from it. So
do the parts of Q + iU by an axis that does not turn with the azimuth a: with the axis that does,
Q + iU = e^2ia Σ p_n e^ina, so that Q = Σ Q_m cos ma and U = Σ U_m sin ma have the sum
Q_m + U_m = 2 p_(m - 2), which goes with the power |m - 2|, and the difference
Q_m - U_m = 2 p_(-m - 2), which goes with m + 2. Under a sun of -8 degrees few paths of the Monte
Carlo bring light: as they are stored, violet skies beside the zenith differ by a factor of 3
between azimuths.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from omma.base.arrays import Floats

_NOISY_BELOW_DEG = -2.5  # suns
_NODES = 4  # of elevation, up to 30.5 degrees from the zenith
# Of high powers two next to each other are nearly the same at the nodes: one is left then.
_SAME_POWERS = 0.05


@functools.cache
def _harmonics(count: int) -> tuple[Floats, Floats]:
    """Of azimuths from 0 to 180 degrees, (2, harmonics, azimuths): shares of cosines (I and Q) and
    of sines (U), and the functions themselves."""
    order = np.arange(count)[:, None]
    angle = order * np.linspace(0, np.pi, count)
    functions = np.stack([np.cos(angle), np.sin(angle)])
    weight = np.full(count, 2.0 / (count - 1))
    weight[[0, -1]] /= 2
    return functions * weight / np.where(order % (count - 1) == 0, 2, 1), functions


@functools.cache
def _regular(power: int, distances: tuple[float, ...]) -> Floats:
    """(nodes, nodes), to the best c d^power + c' d^(power + 2) through values there."""
    distance = np.array(distances)
    basis = (distance / distance.max())[:, None] ** np.array([power, power + 2])
    return np.asarray(basis @ np.linalg.pinv(basis, rcond=_SAME_POWERS))


def smooth_at_zenith(stokes: Any, elevation_deg: Floats, sun_deg: float) -> Any:
    """log I, Q/I and U/I, or changes of them, [3, wavelength, elevation, azimuth], of the tables'
    grid and one of their suns."""
    if sun_deg > _NOISY_BELOW_DEG:
        return stokes
    shares, functions = _harmonics(stokes.shape[-1])
    distance = tuple((90 - elevation_deg[-_NODES:]).tolist())
    smooth = np.array(stokes)
    log_i, q, u = smooth[:, :, -_NODES:]
    cosines, sines = functions
    for m in range(stokes.shape[-1]):
        if m > 0:  # the mean is what is left at the zenith itself
            log_i += _changed(log_i @ shares[0, m], m, distance)[..., None] * cosines[m]
        of_q, of_u = q @ shares[0, m], u @ shares[1, m]
        half_sum = _changed((of_q + of_u) / 2, abs(m - 2), distance) if m != 2 else 0.0
        half_difference = _changed((of_q - of_u) / 2, m + 2, distance)
        q += np.multiply.outer(half_sum + half_difference, cosines[m])
        u += np.multiply.outer(half_sum - half_difference, sines[m])
    return smooth


def _changed(found: Floats, power: int, distance: tuple[float, ...]) -> Floats:
    """(wavelength, nodes), what is to be added so that they go with that power."""
    return np.asarray(found @ _regular(power, distance).T - found)
