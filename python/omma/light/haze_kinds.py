"""Hazes of other kinds than that of the tables of the sky: urban, maritime, smoke.

Light that haze scatters once is that of its kind, by a quadrature over height. What is scattered by
air, or more often, is that of the tables' own haze, rural, of which there is taken as much as turns
as much light aside: scattering times 1 - g, g the mean cosine (similarity, van de Hulst 1980,
recalled); dimmed by what the kind absorbs more. The optics (data/haze_kinds.npz) are made by
scripts/make_sky_tables.py.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from importlib import resources
from typing import Any, Literal

import numpy as np

from omma.base.arrays import Floats
from omma.base.directions import direction

HazeKind = Literal["rural", "urban", "maritime", "smoke"]

KINDS: tuple[HazeKind, ...] = ("rural", "urban", "maritime", "smoke")
# How much of haze at one depth at 550 nm, or by wavelength, (K,).
Amount = tuple["Haze", "Floats | float"]
# Haze thins out with 2 km, air with some 8.4.
_HAZE_OVER_AIR = 2.0 / 8.4
_DIFFUSE_MASS = 1.66  # of light from everywhere (Elsasser 1942, recalled)
# For quadratures over the share that is above, and their weights.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_SHARES = 0.5 * (_NODES + 1), 0.5 * _WEIGHTS


@dataclass(frozen=True)
class Haze:
    """depth: extinction over that at 550 nm, by the tables' wavelengths.
    scattered: share of it.
    phase, linear: P11 and P12 of its phase matrix, (wavelength, angles even by the sine of their
        half), P11 1 in the mean.
    cosine: g, the mean cosine of the angle of scattering, by wavelength.
    """

    depth: Floats
    scattered: Floats
    phase: Floats
    linear: Floats
    cosine: Floats


@functools.cache
def haze_of(kind: str) -> Haze:
    """By its name, one of `KINDS`."""
    file = resources.files("omma.light") / "data" / "haze_kinds.npz"
    with file.open("rb") as stream, np.load(stream) as stored:
        depth, scattered, phase, linear = (
            stored[f"{kind}_{k}"] for k in ("depth", "scattered", "phase", "linear")
        )
    half = np.linspace(0, 1, phase.shape[1])
    cosine = np.trapezoid(phase * (1 - 2 * half**2) * 2 * half, half, axis=1)
    return Haze(depth, scattered, phase, linear, cosine)


def depth_between(wavelength_nm: Floats, haze: Haze, nm: Floats) -> Floats:
    """Extinction over that at 550 nm, (K,), between the tables' wavelengths: as powers of them."""
    nodes = np.log(wavelength_nm)
    return np.asarray(np.exp(np.interp(np.log(nm), nodes, np.log(haze.depth))))


@dataclass(frozen=True)
class Ways:
    """Through clear air, by wavelength (K,) and directions looked at (E,).

    air: optical depth of air upwards, (K,).
    air_mass, haze_mass: on the way looked along, over the column, (E,).
    sun_masses: on the sun's way through air and haze.
    ozone: share of the sun's light that ozone lets pass, (K,).
    """

    air: Floats
    air_mass: Floats
    haze_mass: Floats
    sun_masses: tuple[float, float]
    ozone: Floats

    def once_by_haze(self, haze: Haze, depth: Floats | float, angles: tuple[Floats, Floats]) -> Any:
        """I, Q, U over the sun's irradiance, (3, K, E, A), of what haze scatters once, so deep at
        550 nm (by wavelength where it is not all alike); angles as of `scattering_angles`.

        On the way g² of what it scatters counts as not scattered, as it goes nearly straight on
        (Joseph, Wiscombe and Weinman, J. Atmos. Sci. 33:2452, 1976, recalled).
        """
        above, weight = _SHARES
        extinction = np.asarray(depth * haze.depth)
        on_way = extinction * (1 - haze.scattered * haze.cosine**2)
        left = self._left(above, above**_HAZE_OVER_AIR, on_way) @ weight
        per_sr = (self.ozone * extinction * haze.scattered / (4 * np.pi))[:, None]
        return (per_sr * self.haze_mass * left)[:, :, None] * _matrix(haze, angles)

    def dimmer(self, ours: Amount, theirs: Amount) -> Floats:
        """What light that air scatters has left in another haze, over that in the first one:
        (K, E, 1)."""
        above, weight = _SHARES
        before, after = (
            self._left(
                above ** (1 / _HAZE_OVER_AIR),
                above,
                np.asarray(depth * haze.depth * (1 - haze.scattered * haze.cosine)),
            )
            @ weight
            for haze, depth in (ours, theirs)
        )
        return np.asarray(after / before)[:, :, None]

    def _left(self, haze_above: Floats, air_above: Floats, extinction: Floats) -> Floats:
        """Of the sun's light, what is left where it is scattered and then at the ground: (K, E,
        heights)."""
        sun_air, sun_haze = self.sun_masses
        air = self.air_mass[:, None] * (1 - air_above) + sun_air * air_above
        haze = self.haze_mass[:, None] * (1 - haze_above) + sun_haze * haze_above
        return np.asarray(np.exp(-self.air[:, None, None] * air - extinction[:, None, None] * haze))


def absorbed_back(ours: Amount, theirs: Amount, haze_mass: Floats) -> tuple[Floats, Floats]:
    """Of the ground's light that comes back through the tables' haze, what another leaves: into
    directions looked at, (K, E), and onto the ground, (K,)."""
    less, more = (
        np.asarray(depth * haze.depth * (1 - haze.scattered)) for haze, depth in (ours, theirs)
    )
    absorbed = more - less
    return (
        np.exp(-absorbed[:, None] * (_DIFFUSE_MASS + haze_mass)),
        np.exp(-2 * _DIFFUSE_MASS * absorbed),
    )


def scattering_angles(
    sun_deg: float, elevation_deg: Floats, azimuth_deg: Floats
) -> tuple[Floats, Floats]:
    """Sine of half the angle of scattering, and the angle from up to the right of what stands
    across its plane, (E, A) each; azimuths are right of the sun's."""
    e, a = np.radians(elevation_deg)[:, None], np.radians(azimuth_deg)
    towards = direction(azimuth_deg, elevation_deg[:, None])
    sun = direction(0.0, sun_deg)
    cosine = towards @ sun
    across = np.cross(towards, sun)
    up = np.stack(np.broadcast_arrays(-np.sin(e) * np.sin(a), np.cos(e), np.sin(e) * np.cos(a)), -1)
    right = np.cross(towards, up)
    angle = np.arctan2(np.sum(across * right, -1), np.sum(across * up, -1))
    return np.sqrt(np.clip(0.5 - 0.5 * cosine, 0, 1)), angle


def _matrix(haze: Haze, angles: tuple[Floats, Floats]) -> Floats:
    """First column of the phase matrix, turned to the vertical: (3, K, E, A)."""
    half, psi = angles
    at = np.linspace(0, 1, haze.phase.shape[1])
    intensity, linear = (
        np.array([np.interp(half, at, one) for one in part]) for part in (haze.phase, haze.linear)
    )
    # P12 is below 0 where light is polarised across the plane.
    return np.stack([intensity, -linear * np.cos(2 * psi), -linear * np.sin(2 * psi)])
