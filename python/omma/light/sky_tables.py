"""Clear skies from tables: radiance and polarisation from 300 to 700 nm, and the sun through air.

docs/light.md says what the tables (sky_stored.py) hold. What a ground adds is the same for every
sun: its radiance times what one unit of it gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of
from omma.base.arrays import Floats
from omma.base.one_thread import product
from omma.light.haze_kinds import (
    KINDS,
    Amount,
    Ways,
    absorbed_back,
    haze_of,
    scattering_angles,
)
from omma.light.sky_height import MOST_HEIGHT_M, air_above, less_air, longer_ways
from omma.light.sky_stored import (
    at_nodes,
    azimuth_matrices,
    depths_of_air_and_haze,
    elevation_matrix,
    first_guess,
    haze_shares,
    neighbours,
    ozone_between,
    polarised_shares,
    scattered_once,
    share_scattered,
    sky_fields,
    spline_matrix,
    stored_tables,
    sun_spectrum,
    with_less_air,
)

LOWEST_SUN_DEG = -8.0
# Below, most light is scattered more often than once, which is not known of other hazes.
LOWEST_SUN_OF_KINDS_DEG = 10.0
MOST_AEROSOL = 0.3
OZONE_RANGE_DU = (200.0, 450.0)
WAVELENGTH_RANGE_NM = (300.0, 700.0)
SUN_DIAMETER_DEG = 0.533
_MOST_ONCE = 0.9  # of a sky's light, what haze scatters once
ROWS, COLUMNS = 91, 360  # of the maps that are made: one degree


def check_range(wavelength_nm: Floats) -> None:
    """omma.Error where bands, by their wavelengths (K,), ascending, reach beyond the tables."""
    low, high = wavelength_nm[[0, -1]]
    if low < WAVELENGTH_RANGE_NM[0] or high > WAVELENGTH_RANGE_NM[1]:
        raise Error(f"bands: expected some within 300 to 700 nm, found {low:g} to {high:g} nm")


@checked
def clear_sky_map(
    wavelength_nm: ArrayLike,
    weight: ArrayLike,
    sun_elevation_deg: float,
    sun_azimuth_deg: float,
    *,
    aerosol: float = 0.0,
    ozone_du: float = 300.0,
    albedo: float = 0.1,
    height_m: float = 0.0,
    haze_kind: str = "rural",
    unit: str = "photons",
    width_nm: Floats | float = 1.0,
) -> tuple[NDArray[np.float32], Floats]:
    """The clear sky over a wide ground, and the sun, in bands.

    Args:
        wavelength_nm: (K,), ascending, from 300 to 700 nm; bands are means over these.
        weight: (B, K), of each wavelength in each band, adding up to 1 in a band.
        sun_elevation_deg: of the sun's centre, without refraction, from -8 to 90 degrees.
        sun_azimuth_deg: 0 is -Z, 90 is +X.
        aerosol: optical depth of haze at 550 nm, from 0 (none) to 0.3, of some kinds to less.
        ozone_du: column of ozone, from 200 to 450 Dobson units.
        albedo: of the ground all round, from 0 to 1.
        height_m: of that ground above the sea, from 0 to 5000 m.
        haze_kind: "rural", "urban", "maritime" or "smoke"; others than rural from 10 degrees of
            sun on.
        unit: "photons", m^-2 s^-1 sr^-1 nm^-1, or "watts", W m^-2 sr^-1 nm^-1.
        width_nm: (K,), about each wavelength, over which the sun's lines are averaged.

    Returns:
        The sky, (2, 91, 360, 3, B), float32, as a light's sky map has it: Stokes I, Q, U above and
        below the horizon, from it to the zenith and the nadir by degrees. Below is the ground, lit
        by this sky and sun. And (B,), the irradiance across the sun's rays on the ground, per m2
        instead of per m2 and sr; at one astronomical unit. It is 0 where the sun's centre is below
        the horizon.

    Raises:
        omma.Error: a number outside of its range, wavelengths that do not ascend, weights of
            another shape or below 0.
    """
    nm, weights = _bands(wavelength_nm, weight)
    _within(sun_elevation_deg, "sun_elevation_deg", LOWEST_SUN_DEG, 90)
    _within(sun_azimuth_deg, "sun_azimuth_deg", -1e6, 1e6)
    _within(height_m, "height_m", 0, MOST_HEIGHT_M)
    one_of(haze_kind, KINDS, "haze_kind")
    if haze_kind != "rural" and sun_elevation_deg < LOWEST_SUN_OF_KINDS_DEG:
        raise Error(
            "haze_kind: expected rural with the sun or the moon below "
            f"{LOWEST_SUN_OF_KINDS_DEG:g} degrees, found {haze_kind}"
        )
    _check_aerosol(aerosol, haze_kind)
    _within(ozone_du, "ozone_du", *OZONE_RANGE_DU)
    _within(albedo, "albedo", 0, 1)
    one_of(unit, ["photons", "watts"], "unit")
    sky = TableSky(
        float(sun_elevation_deg), float(aerosol), float(ozone_du), float(height_m), haze_kind
    )
    elevation = np.linspace(0, 90, ROWS)
    turn = np.arange(COLUMNS) * (360 / COLUMNS) - float(sun_azimuth_deg)
    relative = np.round((turn + 180) % 360 - 180, 9)  # right of the sun
    azimuth, column = np.unique(np.abs(relative), return_inverse=True)
    spectrum = sun_spectrum(nm, unit, width_nm)
    direct = spectrum * sky.transmission(nm)
    solid_angle = _solid_angles(elevation, np.bincount(column))
    bands = weights.T.astype(np.float32)
    above = np.empty((ROWS, len(azimuth), 3, len(weights)), np.float32)
    of_sky = np.zeros(len(nm))
    for row, (log_i, q, u) in enumerate(sky.rows(elevation, azimuth, nm)):
        radiance = np.exp(log_i) * spectrum.astype(np.float32)
        of_sky += np.einsum("d,dk->k", solid_angle[row], radiance)
        for k, one in enumerate((radiance, radiance * q, radiance * u)):
            above[row, :, k] = product(one, bands)
    lit = of_sky + direct * max(0.0, np.sin(np.radians(sun_elevation_deg)))
    ground, back, back_q = sky.ground(elevation, nm, albedo)
    shine = lit * ground  # the ground's radiance
    above[:, :, 0] += product(back * shine, weights.T)[:, None]
    above[:, :, 1] += product(back_q * shine, weights.T)[:, None]
    result = np.zeros((2, ROWS, COLUMNS, 3, len(weights)), np.float32)
    result[0] = above[:, column]
    result[0, :, :, 2] *= np.where(relative < 0, -1, 1)[:, None]
    _join_zenith(result[0, -1], relative)
    result[1, :, :, 0] = weights @ shine
    return result, weights @ direct


def _join_zenith(row: NDArray[np.float32], relative_deg: Floats) -> None:
    """Gives all columns, (columns, 3, B), the one light of the zenith, each by its own axis."""
    turn = np.exp(2j * np.radians(relative_deg))[:, None]
    along = turn * np.mean((row[:, 1] + 1j * row[:, 2]) / turn, axis=0)
    row[:, 0] = row[:, 0].mean(axis=0)
    row[:, 1], row[:, 2] = along.real, along.imag


def _bands(wavelength_nm: ArrayLike, weight: ArrayLike) -> tuple[Floats, Floats]:
    nm = array_of(wavelength_nm, "wavelength_nm", (None,))
    low, high = WAVELENGTH_RANGE_NM
    if not (len(nm) and np.all(np.diff(nm) > 0) and low <= nm[0] and nm[-1] <= high):
        raise Error(
            "wavelength_nm: expected wavelengths that ascend from 300 to 700 nm, found "
            f"{nm.tolist()!s:.60}"
        )
    weights = array_of(weight, "weight", (None, len(nm)))
    if not (np.all(np.isfinite(weights)) and np.all(weights >= 0)):
        raise Error("weight: expected numbers of 0 or more, found others")
    return nm, weights


def _within(value: float, name: str, low: float, high: float) -> None:
    if not low <= value <= high:
        raise Error(f"{name}: expected {low:g} to {high:g}, found {value!r:.40}")


def _check_aerosol(aerosol: float, haze_kind: str) -> None:
    """omma.Error where there is more haze than in the tables, which have 0.3 of their own kind."""
    if haze_kind == "rural":
        _within(aerosol, "aerosol", 0, MOST_AEROSOL)
        return
    most = min(MOST_AEROSOL, MOST_AEROSOL / float(_rural_share(haze_kind).max()))
    if not 0 <= aerosol <= most:
        raise Error(f"aerosol: expected 0 to {most:.3g} of {haze_kind} haze, found {aerosol!r:.40}")


def _rural_share(haze_kind: str) -> Floats:
    """How much of the tables' haze turns as much light aside as one of another kind, by
    wavelength."""
    theirs, ours = (
        one.depth * one.scattered * (1 - one.cosine)
        for one in (haze_of(haze_kind), haze_of("rural"))
    )
    return np.asarray(theirs / ours)


class TableSky:
    """The tables for one sun, haze, ozone column, height of the ground and kind of haze, on their
    grid of directions."""

    def __init__(
        self,
        sun_deg: float,
        haze: float,
        ozone_du: float,
        height_m: float = 0.0,
        haze_kind: str = "rural",
    ) -> None:
        stored = stored_tables()
        self.sun_deg, self.ozone_du, self.height_m = sun_deg, ozone_du, height_m
        self.aerosol, self.haze_kind = haze, haze_kind
        # Of the tables' own haze, by wavelength where it is not all alike.
        self.haze = np.full(1, haze) if haze_kind == "rural" else haze * _rural_share(haze_kind)
        air, _ = air_above(height_m)
        self.table = {**stored, "rayleigh_depth": air * stored["rayleigh_depth"]}
        suns = neighbours(stored["sun_deg"], sun_deg)
        shares = haze_shares(stored, self.haze)
        self.hazes = [(h, share) for h, share in shares.items() if np.any(share != 0)]
        # Light scattered once is as polarised as in a sky with as much more of air and haze.
        polarised = polarised_shares(stored, self.haze / air, sun_deg)
        # [3, wavelength, elevation, azimuth]
        self.fields, self.ozone_mass = sky_fields(suns, shares, polarised, ozone_du)
        if height_m > 0:
            of_air, of_haze = scattered_once(
                self.table, sun_deg, stored["elevation_deg"], stored["azimuth_deg"]
            )
            change = with_less_air(suns, height_m)
            change[1:] *= of_air / (of_air + self.haze[:, None, None] * of_haze)
            self.fields = self.fields + change

    def stokes(self, elevation_deg: Floats, azimuth_deg: Floats, nm: Floats) -> Any:
        """log(I / irradiance), Q/I, U/I, float32: (elevation, azimuth, K) each."""
        rows = [*self.rows(elevation_deg, azimuth_deg, nm)]
        return tuple(np.stack([row[k] for row in rows]) for k in range(3))

    def rows(self, elevation_deg: Floats, azimuth_deg: Floats, nm: Floats) -> Iterator[Any]:
        """The same for one elevation after the other, (azimuth, K) each: little enough to stay
        where the processor has it at hand.

        Where noise of the tables makes a degree of polarisation of more than 1, it is 1.
        """
        table = self.table
        log_i, q, u = self._between(self.fields, elevation_deg, azimuth_deg)
        guess = first_guess(table, self.haze, self.sun_deg, elevation_deg, azimuth_deg)
        log_i = log_i + np.log(guess)
        if self._is_other:
            log_i, q, u = self._of_kind((log_i, q, u), elevation_deg, azimuth_deg)
        passed = self._between(self.ozone_mass[None, None], elevation_deg, azimuth_deg)[0]
        log_i = np.concatenate([log_i, passed * self.ozone_du])
        along = spline_matrix(tuple(table["wavelength_nm"]), tuple(nm))
        with_ozone = np.column_stack([along, -ozone_between(table, nm)])
        fields = [np.moveaxis(one, 0, -1).astype(np.float32, order="C") for one in (log_i, q, u)]
        matrices = [one.T.astype(np.float32) for one in (with_ozone, along, along)]
        for row in zip(*fields, strict=True):
            log_i, q, u = map(product, row, matrices)
            square = q * q + u * u
            if square.max() > 1:
                over = np.sqrt(np.maximum(square, 1))
                q, u = q / over, u / over
            yield log_i, q, u

    def _between(self, fields: Any, elevation_deg: Floats, azimuth_deg: Floats) -> list[Any]:
        """Fields [1 to 3, K, elevation, azimuth] of the tables' directions in others: what is alike
        on both sides of the sun, the third changes its sign there."""
        up = elevation_matrix(tuple(elevation_deg))
        even, odd = azimuth_matrices(tuple(azimuth_deg))
        sign = np.array([1, 1, -1])[: len(fields), None, None, None]
        beyond = sign * fields[:, :, -1:-5:-1, ::-1]  # over the zenith, down the other side
        each = up @ np.concatenate([fields, beyond], axis=2)
        return [product(one, by.T) for one, by in zip(each, (even, even, odd))]

    @property
    def _is_other(self) -> bool:
        return self.haze_kind != "rural" and self.aerosol > 0

    def _amounts(self) -> tuple[Amount, Amount]:
        """Of the tables' own haze, and of this one."""
        return (haze_of("rural"), self.haze), (haze_of(self.haze_kind), self.aerosol)

    def _of_kind(self, stokes: Any, elevation_deg: Floats, azimuth_deg: Floats) -> Any:
        """The same log I, Q/I and U/I at the tables' wavelengths with haze of another kind."""
        table = self.table
        log_i, q, u = stokes
        i = np.exp(log_i)
        mass = np.array([np.interp(elevation_deg, table["mass_deg"], one) for one in table["mass"]])
        sun = self._sun_masses()
        of_ozone = at_nodes(table, "ozone_depth_per_du") * self.ozone_du
        ways = Ways(
            at_nodes(table, "rayleigh_depth"),
            mass[0],
            mass[2],
            (sun[0], sun[2]),
            np.exp(-of_ozone * sun[1]),
        )
        angles = scattering_angles(self.sun_deg, elevation_deg, azimuth_deg)
        ours, theirs = self._amounts()
        once, other = (ways.once_by_haze(*one, angles) for one in (ours, theirs))
        # Low near a low sun the quadrature has more than there is.
        kept = np.minimum(1, _MOST_ONCE * i / np.maximum(once[0], 1e-300))
        rest = np.stack([i, i * q, i * u]) - kept * once
        i, q, u = rest * ways.dimmer(ours, theirs) + kept * other
        return np.log(i), q / i, u / i

    def _sun_masses(self) -> Floats:
        """On the sun's way through air, ozone and haze, over the columns upwards."""
        table = self.table
        # As functions of sin(elevation), bounded away from 0, air masses vary so little that a
        # spline fits.
        over = [np.hypot(np.sin(np.radians(e)), 0.05) for e in (table["mass_deg"], self.sun_deg)]
        along = spline_matrix(tuple(table["mass_deg"]), (self.sun_deg,))[0]
        mass: Floats = (table["mass"] * over[0]) @ along / over[1]
        return mass * longer_ways(self.sun_deg, self.height_m) if self.height_m > 0 else mass

    def transmission(self, nm: Floats) -> Floats:
        """Share of the sun's rays that reach the ground, (K,); 0 for a sun below the horizon."""
        if self.sun_deg < 0:
            return np.zeros(len(nm))
        table = self.table
        fine = table["fine_nm"]
        air, haze = depths_of_air_and_haze(nm, self.haze_kind)
        ozone = np.interp(nm, fine, table["ozone_depth_per_du"])
        depth = [air_above(self.height_m)[0] * air, ozone * self.ozone_du, haze * self.aerosol]
        through: Floats = np.exp(-np.einsum("c,ck->k", self._sun_masses(), depth))
        return through

    def ground(self, elevation_deg: Floats, nm: Floats, albedo: float) -> tuple[Floats, ...]:
        """Radiance of the ground over what falls on it over a black one, (K,), and what one unit of
        that radiance adds to I and Q of the sky, (elevation, K).
        """
        table = self.table
        along = spline_matrix(tuple(table["wavelength_nm"]), tuple(nm))
        up = spline_matrix(tuple(table["elevation_deg"]), tuple(elevation_deg))
        back: Any = sum(share[:, None] * table["ground"][h] for h, share in self.hazes)
        returned: Any = sum(share * table["returned"][h] for h, share in self.hazes)
        if self.height_m > 0:
            of_back, of_returned = self._less_back()
            back, returned = back * of_back, returned * of_returned
        if self._is_other:
            mass = np.interp(table["elevation_deg"], table["mass_deg"], table["mass"][2])
            of_back, of_returned = absorbed_back(*self._amounts(), mass)
            back, returned = back * of_back, returned * of_returned
        shine = albedo / (np.pi * (1 - albedo * (along @ returned)))
        return shine, up @ (along @ back[0]).T, up @ (along @ back[1]).T

    def _less_back(self) -> tuple[Floats, Floats]:
        """Of the ground's light that air sends back at sea level, what less air does: into each
        elevation, (wavelength, elevation), and onto the ground, (wavelength,)."""
        stored = stored_tables()
        # What comes back onto the ground goes with what is scattered 30 degrees up.
        sine = np.append(np.sin(np.radians(stored["elevation_deg"])), 0.5)
        clean = np.column_stack([stored["ground"][0, 0], stored["returned"][0]])
        depth, share = at_nodes(stored, "rayleigh_depth"), air_above(self.height_m)[0]
        less = less_air(stored["wavelength_nm"], depth, share)
        change = np.exp(less @ np.log(clean / share_scattered(stored, 0.0, sine)))
        after, before = (share_scattered(one, self.haze, sine) for one in (self.table, stored))
        change *= after / before
        return change[:, :-1], change[:, -1]


def _solid_angles(elevation_deg: Floats, columns: NDArray[np.intp]) -> Floats:
    """Solid angle times the sine of elevation that nodes stand for, (elevation, azimuth)."""
    edge = np.radians(np.concatenate([[0], (elevation_deg[1:] + elevation_deg[:-1]) / 2, [90]]))
    rings = 0.5 * np.diff(np.sin(edge) ** 2)
    angles: Floats = rings[:, None] * columns * (2 * np.pi / columns.sum())
    return angles
