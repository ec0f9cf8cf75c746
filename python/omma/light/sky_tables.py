"""Clear skies from tables: radiance and polarisation from 300 to 700 nm, and the sun through air.

The tables (data/clear_sky.npz, sun.npz) are made by scripts/make_sky_tables.py; docs/light.md says
what they hold. Stored is the logarithm of radiance over the sun's irradiance and over a first
guess, so that it is smooth even near the sun, and Q/I and U/I; all over a black ground. What a
ground adds is the same for every sun: its radiance times what one unit of it gives.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import array_of, checked, one_of
from omma.base.one_thread import product
from omma.light.units import PHOTONS_PER_JOULE_NM

Floats = NDArray[np.float64]

LOWEST_SUN_DEG = -8.0
MOST_AEROSOL = 0.3
OZONE_RANGE_DU = (200.0, 450.0)
WAVELENGTH_RANGE_NM = (300.0, 700.0)
SUN_DIAMETER_DEG = 0.533
_LEAST_SUN_NM = 0.1  # between the edges of what is stored of the sun
ROWS, COLUMNS = 91, 360  # of the maps that are made: one degree


def check_range(wavelength_nm: Floats) -> None:
    """omma.Error where bands, by their wavelengths (K,), ascending, reach beyond the tables."""
    low, high = wavelength_nm[[0, -1]]
    if low < WAVELENGTH_RANGE_NM[0] or high > WAVELENGTH_RANGE_NM[1]:
        raise Error(f"bands: expected some within 300 to 700 nm, found {low:g} to {high:g} nm")


# Offset of optical depth, with which log I is nearly a parabola over haze's share.
_PART_BEND = 0.2

# Ozone's bands in the visible: where they begin, at a node of the tables, and are deepest.
_VISIBLE_OZONE_NM, _MOST_OZONE_NM = 450.0, 600.0

# Allen's Astrophysical Quantities (4th ed., 2000, section 14.7): wavelength, nm, and the two
# numbers u2, v2 of 1 - u2 - v2 + u2 mu + v2 mu^2.
_LIMB = np.array(
    [
        (320, 0.88, 0.03),
        (350, 0.98, -0.10),
        (370, 1.03, -0.16),
        (380, 0.92, -0.05),
        (400, 0.91, -0.05),
        (450, 0.99, -0.17),
        (500, 0.97, -0.22),
        (550, 0.93, -0.23),
        (600, 0.88, -0.23),
        (800, 0.73, -0.22),
    ]
)


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
    unit: str = "photons",
    width_nm: Floats | float = 1.0,
) -> tuple[NDArray[np.float32], Floats]:
    """The clear sky over a wide ground, and the sun, in bands.

    Args:
        wavelength_nm: (K,), ascending, from 300 to 700 nm; bands are means over these.
        weight: (B, K), of each wavelength in each band, adding up to 1 in a band.
        sun_elevation_deg: of the sun's centre, without refraction, from -8 to 90 degrees.
        sun_azimuth_deg: 0 is -Z, 90 is +X.
        aerosol: optical depth of haze at 550 nm, from 0 (none) to 0.3.
        ozone_du: column of ozone, from 200 to 450 Dobson units.
        albedo: of the ground all round, from 0 to 1.
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
    if -90 <= sun_elevation_deg < LOWEST_SUN_DEG:
        raise Error(
            f"sun_elevation_deg: expected {LOWEST_SUN_DEG:g} to 90, found "
            f"{sun_elevation_deg!r:.40}; omma.light.natural_sky goes on into the night"
        )
    _within(sun_elevation_deg, "sun_elevation_deg", LOWEST_SUN_DEG, 90)
    _within(sun_azimuth_deg, "sun_azimuth_deg", -1e6, 1e6)
    _within(aerosol, "aerosol", 0, MOST_AEROSOL)
    _within(ozone_du, "ozone_du", *OZONE_RANGE_DU)
    _within(albedo, "albedo", 0, 1)
    one_of(unit, ["photons", "watts"], "unit")
    sky = TableSky(float(sun_elevation_deg), float(aerosol), float(ozone_du))
    elevation = np.linspace(0, 90, ROWS)
    turn = np.arange(COLUMNS) * (360 / COLUMNS) - float(sun_azimuth_deg)
    relative = np.round((turn + 180) % 360 - 180, 9)  # right of the sun
    azimuth, column = np.unique(np.abs(relative), return_inverse=True)
    log_i, q, u = sky.stokes(elevation, azimuth, nm)
    spectrum = sun_spectrum(nm, unit, width_nm)
    radiance = np.exp(log_i) * spectrum.astype(np.float32)
    direct = spectrum * sky.transmission(nm)
    solid_angle = _solid_angles(elevation, np.bincount(column))
    of_sky = np.einsum("d,dk->k", solid_angle.ravel(), radiance.reshape(-1, len(nm)))
    lit = of_sky + direct * max(0.0, np.sin(np.radians(sun_elevation_deg)))
    ground, back, back_q = sky.ground(elevation, nm, albedo)
    shine = lit * ground  # the ground's radiance
    bands = weights.T.astype(np.float32)
    above = np.empty((ROWS, len(azimuth), 3, len(weights)), np.float32)
    above[:, :, 0] = product(radiance, bands) + product(back * shine, weights.T)[:, None]
    above[:, :, 1] = product(radiance * q, bands) + product(back_q * shine, weights.T)[:, None]
    above[:, :, 2] = product(radiance * u, bands)
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


def sun_spectrum(wavelength_nm: Floats, unit: str, width_nm: Floats | float = 1.0) -> Floats:
    """Irradiance of the sun above the air, (K,), per m2 and nm, at one astronomical unit: means
    over widths about the wavelengths, of which none is below a tenth of a nanometre."""
    table = _sun()
    edges, power = table["edges_nm"], table["watts"].astype(np.float64)
    if unit == "photons":
        power = power * PHOTONS_PER_JOULE_NM * 0.5 * (edges[1:] + edges[:-1])
    up_to = np.concatenate([[0], np.cumsum(power * np.diff(edges))])
    half = np.maximum(width_nm, _LEAST_SUN_NM) / 2
    low = np.interp(wavelength_nm - half, edges, up_to)
    return np.asarray((np.interp(wavelength_nm + half, edges, up_to) - low) / (2 * half))


def sun_limb_darkening(wavelength_nm: Floats) -> Floats:
    """u in L = L(1) (1 - u (1 - mu)), (K,): the linear law whose mean over the disc is right."""
    linear = _LIMB[:, 1] + 1.5 * _LIMB[:, 2]
    return np.interp(wavelength_nm, _LIMB[:, 0], linear)


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


@functools.cache
def _tables() -> dict[str, Any]:
    """The tables as they are stored, read once."""
    return _stored("clear_sky.npz")


@functools.cache
def _sun() -> dict[str, Any]:
    return _stored("sun.npz")


def _stored(name: str) -> dict[str, Any]:
    file = resources.files("omma.light") / "data" / name
    with file.open("rb") as stream, np.load(stream) as stored:
        return {name: stored[name] for name in stored.files}


class TableSky:
    """The tables for one sun, haze and ozone column, on their grid of directions."""

    def __init__(self, sun_deg: float, haze: float, ozone_du: float) -> None:
        table = self.table = _tables()
        self.sun_deg, self.haze, self.ozone_du = sun_deg, haze, ozone_du
        suns = _neighbours(table["sun_deg"], sun_deg)
        shares = _haze_shares(table, haze)
        self.hazes = [(h, share) for h, share in shares.items() if np.any(share != 0)]
        of_polarised = _polarised_shares(table, haze, sun_deg)
        log_i: Any = 0.0
        stokes: Any = 0.0
        for h, of_haze in self.hazes:
            share = np.stack(np.broadcast_arrays(of_haze[:, None, None], *[of_polarised[h]] * 2))
            for s, of_sun in suns:
                steps = np.cumsum(table["steps"][h, s], axis=-1, dtype=np.int32)
                stokes = stokes + of_sun * share * (steps * table["step"][:, None, None, None])
                log_i = log_i + of_sun * of_haze * table["log_mean"][h, s]
        ozone: Any = 0.0
        for s, of_sun in suns:
            ozone = ozone + of_sun * table["ozone"][:, s]
        x = (ozone_du - 300) / 300
        few = x * ozone[0] + x**2 * ozone[1]
        to_azimuths = table["ozone_azimuth"].transpose(0, 2, 1)
        # [3, wavelength, elevation, azimuth]
        self.fields = stokes + table["ozone_elevation"] @ few @ to_azimuths[:, None]
        self.fields[0] += log_i[:, None, None]
        # How much ozone light has passed, over the column upwards, [elevation, azimuth]: by what
        # more of it takes away where it absorbs most in the visible, which is little.
        k = int(np.argmin(np.abs(table["wavelength_nm"] - _MOST_OZONE_NM)))
        taken = table["ozone_elevation"] @ (ozone[0, 0, k] + 2 * x * ozone[1, 0, k])
        per_du = np.interp(_MOST_OZONE_NM, table["fine_nm"], table["ozone_depth_per_du"])
        self.ozone_mass = -(taken @ to_azimuths[0]) / (300 * per_du)

    def stokes(self, elevation_deg: Floats, azimuth_deg: Floats, nm: Floats) -> Any:
        """log(I / irradiance), Q/I, U/I, float32: (elevation, azimuth, K) each.

        Where noise of the tables makes a degree of polarisation of more than 1, it is 1.
        """
        table = self.table
        up = _elevation_matrix(tuple(elevation_deg))
        even, odd = _azimuth_matrices(tuple(azimuth_deg))
        sign = np.array([1, 1, -1])[:, None, None, None]
        beyond = sign * self.fields[:, :, -1:-5:-1, ::-1]  # over the zenith, down the other side
        fields = up @ np.concatenate([self.fields, beyond], axis=2)
        log_i, q, u = fields[0] @ even.T, fields[1] @ even.T, fields[2] @ odd.T
        guess = first_guess(table, self.haze, self.sun_deg, elevation_deg, azimuth_deg)
        mass = np.concatenate([self.ozone_mass, self.ozone_mass[-1:-5:-1, ::-1]])
        passed = (up @ mass @ even.T) * self.ozone_du
        log_i = np.concatenate([log_i + np.log(guess), passed[None]])
        along = _spline_matrix(tuple(table["wavelength_nm"]), tuple(nm))
        with_ozone = np.column_stack([along, -_ozone_between(table, nm)])
        log_i, q, u = (
            product(np.moveaxis(one, 0, -1).astype(np.float32, order="C"), by.T.astype(np.float32))
            for one, by in ((log_i, with_ozone), (q, along), (u, along))
        )
        over = np.maximum(np.hypot(q, u), 1)
        return log_i, q / over, u / over

    def transmission(self, nm: Floats) -> Floats:
        """Share of the sun's rays that reach the ground, (K,); 0 for a sun below the horizon."""
        if self.sun_deg < 0:
            return np.zeros(len(nm))
        table = self.table
        # As functions of sin(elevation), bounded away from 0, air masses vary so little that a
        # spline fits.
        over = [np.hypot(np.sin(np.radians(e)), 0.05) for e in (table["mass_deg"], self.sun_deg)]
        along = _spline_matrix(tuple(table["mass_deg"]), (self.sun_deg,))[0]
        mass = (table["mass"] * over[0]) @ along / over[1]
        fine = table["fine_nm"]
        depth = [
            np.interp(nm, fine, table["rayleigh_depth"]),
            np.interp(nm, fine, table["ozone_depth_per_du"]) * self.ozone_du,
            np.interp(nm, fine, table["haze_depth"]) * self.haze,
        ]
        through: Floats = np.exp(-np.einsum("c,ck->k", mass, depth))
        return through

    def ground(self, elevation_deg: Floats, nm: Floats, albedo: float) -> tuple[Floats, ...]:
        """Radiance of the ground over what falls on it over a black one, (K,), and what one unit of
        that radiance adds to I and Q of the sky, (elevation, K).
        """
        table = self.table
        along = _spline_matrix(tuple(table["wavelength_nm"]), tuple(nm))
        up = _spline_matrix(tuple(table["elevation_deg"]), tuple(elevation_deg))
        back: Any = sum(share[:, None] * table["ground"][h] for h, share in self.hazes)
        returned: Any = sum(share * table["returned"][h] for h, share in self.hazes)
        shine = albedo / (np.pi * (1 - albedo * (along @ returned)))
        return shine, up @ (along @ back[0]).T, up @ (along @ back[1]).T


def _ozone_between(table: dict[str, Any], nm: Floats) -> Floats:
    """What a spline through the tables' wavelengths misses of ozone's depth, per DU, (K,).

    Of its bands in the visible, from a node on; below, light scattered above ozone counts for more
    than what ozone lets pass. Means over 5 nm, as in the tables.
    """
    padded = np.pad(table["ozone_depth_per_du"], 2, "edge")
    depth = np.convolve(padded, np.full(5, 0.2), "valid")
    nodes, fine = table["wavelength_nm"], table["fine_nm"]
    of_spline = _spline_matrix(tuple(nodes), tuple(nm)) @ np.interp(nodes, fine, depth)
    return np.where(nm < _VISIBLE_OZONE_NM, 0.0, np.interp(nm, fine, depth) - of_spline)


def first_guess(
    table: dict[str, Any],
    haze: float,
    sun_deg: float,
    elevation_deg: Floats,
    azimuth_deg: Floats,
) -> Any:
    """What stored radiances are over: (wavelength, elevation, azimuth).

    The phase function of air with its haze, times the share of light that is scattered on a way
    through all of it: so that what is stored changes little with haze and around the sun.
    """
    air, of_haze = _scattered_once(table, sun_deg, elevation_deg, azimuth_deg)
    depth = _at_nodes(table, "rayleigh_depth")[:, None, None]
    if haze > 0:
        more = haze * (_at_nodes(table, "haze_depth") * table["haze_scattered"])[:, None, None]
        depth, air = depth + more, (air + haze * of_haze) / (depth + more)
    else:
        air = air / depth
    sine = np.sin(np.radians(elevation_deg))[:, None]
    return air * -np.expm1(-depth / (sine + 0.025))


def _scattered_once(
    table: dict[str, Any], sun_deg: float, elevation_deg: Floats, azimuth_deg: Floats
) -> tuple[Floats, Floats]:
    """Depth of scattering times phase function of air and of a haze of depth 1 at 550 nm:
    (wavelength, elevation, azimuth) each.
    """
    e, a = np.radians(elevation_deg)[:, None], np.radians(azimuth_deg)
    sun = np.radians(sun_deg)
    cosine = np.sin(e) * np.sin(sun) + np.cos(e) * np.cos(sun) * np.cos(a)
    delta = table["anisotropy"][:, None, None]
    air = 0.75 * delta * (1 + cosine**2) + 1 - delta
    half = np.sqrt(np.clip(0.5 - 0.5 * cosine, 0, 1))
    at = np.linspace(0, 1, table["haze_phase"].shape[1])
    haze = np.array([np.interp(half, at, one) for one in table["haze_phase"]])
    of_haze = _at_nodes(table, "haze_depth") * table["haze_scattered"]
    return _at_nodes(table, "rayleigh_depth")[:, None, None] * air, of_haze[:, None, None] * haze


def depths_of_air_and_haze(wavelength_nm: Floats) -> tuple[Floats, Floats]:
    """Optical depths upwards, (K,): of air without haze and ozone, and of haze that has 1 at
    550 nm."""
    table = _tables()
    fine = table["fine_nm"]
    air, haze = (np.interp(wavelength_nm, fine, table[f"{k}_depth"]) for k in ("rayleigh", "haze"))
    return air, haze


def _at_nodes(table: dict[str, Any], depth: str) -> Floats:
    return np.asarray(np.interp(table["wavelength_nm"], table["fine_nm"], table[depth]))


def _haze_shares(table: dict[str, Any], haze: float) -> dict[int, Floats]:
    """Interpolation weights of the tables' hazes for log I, by index: (wavelength,). The coordinate
    is haze's share in scattering, in which log I is less curved than in optical depth."""
    air, each = _at_nodes(table, "rayleigh_depth"), _at_nodes(table, "haze_depth")
    return _between_hazes(
        table, haze, lambda depth: depth * each / (air + _PART_BEND + depth * each)
    )


def _polarised_shares(table: dict[str, Any], haze: float, sun_deg: float) -> dict[int, Floats]:
    """Interpolation weights of the tables' hazes for Q/I and U/I, by index: (wavelength, elevation,
    azimuth). The coordinate is the share of singly scattered light that haze sends into a
    direction, in which Q/I and U/I of that light are linear."""
    air, each = _scattered_once(table, sun_deg, table["elevation_deg"], table["azimuth_deg"])
    return _between_hazes(table, haze, lambda depth: depth * each / (air + depth * each))


def _between_hazes(
    table: dict[str, Any], haze: float, coordinate: Callable[[float], Floats]
) -> dict[int, Floats]:
    """Shares of the tables' hazes, where each is at its coordinate, by index.

    By the two parabolas through three neighbours that reach over the haze, of which the one with
    its middle nearer counts for more; they are the same at either end.
    """
    nodes, last = table["haze"], len(table["haze"]) - 3
    coordinates, at = [coordinate(one) for one in nodes], coordinate(haze)
    k = int(np.clip(np.searchsorted(nodes, haze, side="right") - 1, 0, last + 1))
    along = (haze - nodes[k]) / (nodes[k + 1] - nodes[k])
    shares: dict[int, Any] = {}
    for first, weight in ((max(k - 1, 0), 1 - along), (min(k, last), along)):
        near = range(first, first + 3)
        for i in near:
            others = [coordinates[j] for j in near if j != i]
            share = np.prod([(at - one) / (coordinates[i] - one) for one in others], axis=0)
            shares[i] = shares.get(i, 0.0) + weight * share
    return shares


def _neighbours(nodes: Floats, at: float) -> list[tuple[int, float]]:
    """Up to four nodes and their shares in the cubic through them; (index, share)."""
    count = min(4, len(nodes))
    order = np.argsort(nodes)
    index = int(np.searchsorted(nodes[order], at))
    first = int(np.clip(index - 2, 0, len(nodes) - count))
    near = order[first : first + count]
    shares = []
    for one in near:
        others = nodes[near[near != one]]
        shares.append(float(np.prod((at - others) / (nodes[one] - others))))
    return [(int(i), share) for i, share in zip(near, shares) if share != 0]


@functools.lru_cache(maxsize=64)
def _spline_matrix(nodes: tuple[float, ...], at: tuple[float, ...]) -> Floats:
    """(points, nodes), which takes values at nodes to those of their cubic spline."""
    from scipy.interpolate import CubicSpline

    matrix: Floats = CubicSpline(np.array(nodes), np.eye(len(nodes)))(np.array(at))
    return matrix


def _elevation_matrix(elevation_deg: tuple[float, ...]) -> Floats:
    """For nodes of the table and the last four once more, beyond the zenith."""
    nodes = _tables()["elevation_deg"]
    return _spline_matrix((*nodes, *(180 - nodes[-1:-5:-1])), elevation_deg)


@functools.lru_cache(maxsize=64)
def _azimuth_matrices(azimuth_deg: tuple[float, ...]) -> tuple[Floats, Floats]:
    """For what is the same on both sides of the sun, and for what changes its sign."""
    from scipy.interpolate import CubicSpline

    nodes = _tables()["azimuth_deg"]  # from 0 to 180
    round_ = np.concatenate([nodes, 360 - nodes[-2::-1]])
    matrices = []
    for sign in (1.0, -1.0):
        eye = np.eye(len(nodes))
        if sign < 0:
            eye[0] = eye[-1] = 0
        values = np.concatenate([eye, sign * eye[-2::-1]])
        matrices.append(CubicSpline(round_, values, bc_type="periodic")(np.array(azimuth_deg)))
    return matrices[0], matrices[1]


def _solid_angles(elevation_deg: Floats, columns: NDArray[np.intp]) -> Floats:
    """Solid angle times the sine of elevation that nodes stand for, (elevation, azimuth)."""
    edge = np.radians(np.concatenate([[0], (elevation_deg[1:] + elevation_deg[:-1]) / 2, [90]]))
    rings = 0.5 * np.diff(np.sin(edge) ** 2)
    angles: Floats = rings[:, None] * columns * (2 * np.pi / columns.sum())
    return angles
