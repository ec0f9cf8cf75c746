"""Skies are smooth at the zenith: what tables of low suns have there by chance is taken out.

What changes about the zenith as cos(m azimuth) or sin goes with the power m of the distance from
it, of Q and U, which turn with the azimuth, with the power |m - 2|. Under a sun of -8 degrees few
paths of the Monte Carlo bring light: as they are stored, violet skies beside the zenith differ by a
factor of 3 between azimuths.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from omma.base.arrays import Floats

_NOISY_BELOW_DEG = -2.5  # suns
_NODES = 4  # of elevation, up to 30.5 degrees from the zenith
_HARMONICS = 7  # of the tables


@functools.cache
def _harmonics(count: int) -> tuple[Floats, Floats]:
    """Of azimuths from 0 to 180 degrees, (2, harmonics, azimuths): shares of cosines (I and Q) and
    of sines (U), and the functions themselves."""
    order = np.arange(_HARMONICS)[:, None]
    angle = order * np.linspace(0, np.pi, count)
    functions = np.stack([np.cos(angle), np.sin(angle)])
    weight = np.full(count, 2.0 / (count - 1))
    weight[[0, -1]] /= 2
    return functions * weight / np.where(order == 0, 2, 1), functions


def _regular(power: int, distance: Floats) -> Floats:
    """(nodes, nodes), to the best c d^power + c' d^(power + 2) through values there."""
    basis = (distance / distance.max())[:, None] ** np.array([power, power + 2])
    return np.asarray(basis @ np.linalg.pinv(basis))


def smooth_at_zenith(stokes: Any, elevation_deg: Floats, sun_deg: float) -> Any:
    """log I, Q/I and U/I, or changes of them, [3, wavelength, elevation, azimuth], of the tables'
    grid and one of their suns."""
    if sun_deg > _NOISY_BELOW_DEG:
        return stokes
    shares, functions = _harmonics(stokes.shape[-1])
    distance = 90 - elevation_deg[-_NODES:]
    smooth = np.array(stokes)
    for k, (kind, turns) in enumerate(((0, 0), (0, 2), (1, 2))):
        near = smooth[k, :, -_NODES:]
        for m in range(_HARMONICS):
            if m == turns:
                continue  # what is left at the zenith itself
            found = near @ shares[kind, m]
            change = found @ _regular(abs(m - turns), distance).T - found
            near += change[..., None] * functions[kind, m]
    return smooth
