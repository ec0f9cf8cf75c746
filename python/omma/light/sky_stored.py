"""What is stored of clear skies, and what lies between: directions, suns, hazes, wavelengths.

data/clear_sky.npz, clear_sky_heights.npz and sun.npz are made by scripts/make_sky_tables.py. Stored
is the logarithm of radiance over the sun's irradiance and over a first guess, so that it is smooth
even near the sun, and Q/I and U/I; all over a black ground.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from importlib import resources
from typing import Any

import numpy as np

from omma.base.arrays import Floats
from omma.light.haze_kinds import depth_between, haze_of
from omma.light.sky_height import MOST_HEIGHT_M, air_above, less_air
from omma.light.sky_zenith import smooth_at_zenith
from omma.light.splines import spline_through
from omma.light.units import PHOTONS_PER_JOULE_NM

_LEAST_SUN_NM = 0.1  # between the edges of what is stored of the sun

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


@functools.cache
def stored_tables() -> dict[str, Any]:
    """The tables as they are stored, read once."""
    return _stored("clear_sky.npz")


@functools.cache
def _heights() -> dict[str, Any]:
    return _stored("clear_sky_heights.npz")


@functools.cache
def _sun() -> dict[str, Any]:
    return _stored("sun.npz")


def _stored(name: str) -> dict[str, Any]:
    file = resources.files("omma.light") / "data" / name
    with file.open("rb") as stream, np.load(stream) as stored:
        return {name: stored[name] for name in stored.files}


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


def _no_haze() -> tuple[dict[int, Floats], dict[int, Floats]]:
    """As of `sky_fields`."""
    return {0: np.ones(len(stored_tables()["wavelength_nm"]))}, {0: np.ones((1, 1, 1))}


def _whole(steps: Any) -> Any:
    """Whole numbers of which the differences are stored: along wavelengths and elevations, both
    modulo 2^16, of those along azimuths."""
    along_azimuths = steps.cumsum(-3, dtype=np.int16).cumsum(-2, dtype=np.int16)
    return along_azimuths.cumsum(-1, dtype=np.int32)


def with_less_air(suns: list[tuple[int, float]], height_m: float) -> Any:
    """What high ground changes of a clean sky: log I over its first guess, Q/I and U/I,
    [3, wavelength, elevation, azimuth] of the tables' grid. Under high suns it is a sky that is as
    deep; under low ones, whose light has another way through ozone, what Monte Carlo found
    (clear_sky_heights.npz).
    """
    table, low = stored_tables(), _heights()
    share, _ = air_above(height_m)
    first_low = int(np.flatnonzero(table["sun_deg"] == low["sun_deg"][0])[0])
    depth = at_nodes(table, "rayleigh_depth")
    change: Any = np.zeros((3, len(depth), len(table["elevation_deg"]), len(table["azimuth_deg"])))
    high = [one for one in suns if one[0] < first_low]
    if high:
        clean, _ = sky_fields(high, *_no_haze(), 0.0)
        change = np.einsum("nm,kmea->knea", less_air(table["wavelength_nm"], depth, share), clean)
    thin = {**table, "rayleigh_depth": share * table["rayleigh_depth"]}
    sine = np.sin(np.radians(table["elevation_deg"]))
    after, before = (share_scattered(one, 0.0, sine) for one in (thin, table))
    of_guess = np.log(after / before)[:, :, None]
    x = height_m / MOST_HEIGHT_M
    to_azimuths = low["azimuth"].transpose(0, 2, 1)[:, None]
    for s, of_sun in suns:
        if s >= first_low:
            few = x * low["change"][0, s - first_low] + x**2 * low["change"][1, s - first_low]
            whole = low["elevation"] @ few @ to_azimuths
            whole[0] -= of_guess
            whole = smooth_at_zenith(whole, table["elevation_deg"], table["sun_deg"][s])
            change = change + of_sun * whole
    return change


def sky_fields(
    suns: list[tuple[int, float]],
    shares: dict[int, Floats],
    polarised: dict[int, Floats],
    ozone_du: float,
) -> tuple[Any, Any]:
    """log I over its first guess, Q/I and U/I, [3, wavelength, elevation, azimuth], and how much
    ozone light has passed, over the column upwards, [elevation, azimuth]; of the tables' air.

    Args:
        suns: indices of the tables' suns and their shares.
        shares, polarised: of the tables' hazes by index, for log I, (wavelength,), and for Q/I and
            U/I, (wavelength, elevation, azimuth).
    """
    table = stored_tables()
    log_i: Any = 0.0
    stokes: Any = 0.0
    none = np.zeros(len(table["wavelength_nm"]))
    for h in {**shares, **polarised}:
        of_haze, of_angle = shares.get(h, none), polarised.get(h, none[:, None, None])
        if not np.any(of_haze) and not np.any(of_angle):
            continue
        share = np.stack(np.broadcast_arrays(of_haze[:, None, None], of_angle, of_angle))
        for s, of_sun in suns:
            one = _whole(table["steps"][h, s]) * table["step"][:, None, None, None]
            one = smooth_at_zenith(one, table["elevation_deg"], table["sun_deg"][s])
            stokes = stokes + of_sun * share * one
            log_i = log_i + of_sun * of_haze * table["log_mean"][h, s]
    ozone: Any = 0.0
    for s, of_sun in suns:
        ozone = ozone + of_sun * table["ozone"][:, s]
    x = (ozone_du - 300) / 300
    few = x * ozone[0] + x**2 * ozone[1]
    to_azimuths = table["ozone_azimuth"].transpose(0, 2, 1)
    fields = stokes + table["ozone_elevation"] @ few @ to_azimuths[:, None]
    fields[0] += log_i[:, None, None]
    # By what more of it takes away where it absorbs most in the visible, which is little.
    k = int(np.argmin(np.abs(table["wavelength_nm"] - _MOST_OZONE_NM)))
    taken = table["ozone_elevation"] @ (ozone[0, 0, k] + 2 * x * ozone[1, 0, k])
    per_du = np.interp(_MOST_OZONE_NM, table["fine_nm"], table["ozone_depth_per_du"])
    return fields, -(taken @ to_azimuths[0]) / (300 * per_du)


def ozone_between(table: dict[str, Any], nm: Floats) -> Floats:
    """What a spline through the tables' wavelengths misses of ozone's depth, per DU, (K,).

    Of its bands in the visible, from a node on; below, light scattered above ozone counts for more
    than what ozone lets pass. Means over 5 nm, as in the tables.
    """
    padded = np.pad(table["ozone_depth_per_du"], 2, "edge")
    depth = np.convolve(padded, np.full(5, 0.2), "valid")
    nodes, fine = table["wavelength_nm"], table["fine_nm"]
    of_spline = spline_matrix(tuple(nodes), tuple(nm)) @ np.interp(nodes, fine, depth)
    return np.where(nm < _VISIBLE_OZONE_NM, 0.0, np.interp(nm, fine, depth) - of_spline)


def first_guess(
    table: dict[str, Any],
    haze: Floats | float,
    sun_deg: float,
    elevation_deg: Floats,
    azimuth_deg: Floats,
) -> Any:
    """What stored radiances are over: (wavelength, elevation, azimuth).

    The phase function of air with its haze, times the share of light that is scattered on a way
    through all of it: so that what is stored changes little with haze and around the sun.
    """
    air, of_haze = scattered_once(table, sun_deg, elevation_deg, azimuth_deg)
    sine = np.sin(np.radians(elevation_deg))
    depth = _scattering_depth(table, haze)[:, None, None]
    scattered = (air + np.reshape(haze, (-1, 1, 1)) * of_haze) / depth
    return scattered * share_scattered(table, haze, sine)[:, :, None]


def _scattering_depth(table: dict[str, Any], haze: Floats | float) -> Floats:
    of_haze = haze * (at_nodes(table, "haze_depth") * table["haze_scattered"])
    return np.asarray(at_nodes(table, "rayleigh_depth") + of_haze)


def share_scattered(table: dict[str, Any], haze: Floats | float, sine: Floats) -> Floats:
    """Of light on a way through all of the air, by the sine of its elevation, about:
    (wavelength, elevations)."""
    return np.asarray(-np.expm1(-_scattering_depth(table, haze)[:, None] / (sine + 0.025)))


def scattered_once(
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
    of_haze = at_nodes(table, "haze_depth") * table["haze_scattered"]
    return at_nodes(table, "rayleigh_depth")[:, None, None] * air, of_haze[:, None, None] * haze


def depths_of_air_and_haze(
    wavelength_nm: Floats, haze_kind: str = "rural"
) -> tuple[Floats, Floats]:
    """Optical depths upwards, (K,): of air without haze and ozone, and of haze that has 1 at
    550 nm."""
    table = stored_tables()
    fine = table["fine_nm"]
    air, haze = (np.interp(wavelength_nm, fine, table[f"{k}_depth"]) for k in ("rayleigh", "haze"))
    if haze_kind != "rural":
        haze = depth_between(table["wavelength_nm"], haze_of(haze_kind), wavelength_nm)
    return air, haze


def at_nodes(table: dict[str, Any], depth: str) -> Floats:
    return np.asarray(np.interp(table["wavelength_nm"], table["fine_nm"], table[depth]))


def haze_shares(table: dict[str, Any], haze: Floats) -> dict[int, Floats]:
    """Interpolation weights of the tables' hazes for log I, by index: (wavelength,). The coordinate
    is haze's share in scattering, in which log I is less curved than in optical depth."""
    air, each = at_nodes(table, "rayleigh_depth"), at_nodes(table, "haze_depth")
    return _between_hazes(
        table, haze, lambda depth: depth * each / (air + _PART_BEND + depth * each)
    )


def polarised_shares(table: dict[str, Any], haze: Floats, sun_deg: float) -> dict[int, Floats]:
    """Interpolation weights of the tables' hazes for Q/I and U/I, by index: (wavelength, elevation,
    azimuth). The coordinate is the share of singly scattered light that haze sends into a
    direction, in which Q/I and U/I of that light are linear."""
    air, each = scattered_once(table, sun_deg, table["elevation_deg"], table["azimuth_deg"])
    return _between_hazes(
        table, haze[:, None, None], lambda depth: depth * each / (air + depth * each)
    )


def _between_hazes(
    table: dict[str, Any], haze: Floats, coordinate: Callable[[Any], Floats]
) -> dict[int, Floats]:
    """Shares of the tables' hazes, where each is at its coordinate, by index.

    By the two parabolas through three neighbours that reach over the haze, of which the one with
    its middle nearer counts for more; they are the same at either end.
    """
    nodes, last = table["haze"], len(table["haze"]) - 3
    coordinates, at = [coordinate(one) for one in nodes], coordinate(haze)
    below = np.clip(np.searchsorted(nodes, haze, side="right") - 1, 0, last + 1)
    shares: dict[int, Any] = {}
    for k in np.unique(below).tolist():
        along = (haze - nodes[k]) / (nodes[k + 1] - nodes[k])
        for first, weight in ((max(k - 1, 0), 1 - along), (min(k, last), along)):
            near = range(first, first + 3)
            for i in near:
                others = [coordinates[j] for j in near if j != i]
                share = np.prod([(at - one) / (coordinates[i] - one) for one in others], axis=0)
                shares[i] = shares.get(i, 0.0) + np.where(below == k, weight * share, 0.0)
    return shares


def neighbours(nodes: Floats, at: float) -> list[tuple[int, float]]:
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
def spline_matrix(nodes: tuple[float, ...], at: tuple[float, ...]) -> Floats:
    """(points, nodes), which takes values at nodes to those of their cubic spline."""
    return spline_through(np.array(nodes), np.eye(len(nodes)), np.array(at))


def elevation_matrix(elevation_deg: tuple[float, ...]) -> Floats:
    """For nodes of the table and the last four once more, beyond the zenith."""
    nodes = stored_tables()["elevation_deg"]
    return spline_matrix((*nodes, *(180 - nodes[-1:-5:-1])), elevation_deg)


@functools.lru_cache(maxsize=64)
def azimuth_matrices(azimuth_deg: tuple[float, ...]) -> tuple[Floats, Floats]:
    """For what is the same on both sides of the sun, and for what changes its sign."""
    nodes = stored_tables()["azimuth_deg"]  # from 0 to 180
    round_ = np.concatenate([nodes, 360 - nodes[-2::-1]])
    matrices = []
    for sign in (1.0, -1.0):
        eye = np.eye(len(nodes))
        if sign < 0:
            eye[0] = eye[-1] = 0
        values = np.concatenate([eye, sign * eye[-2::-1]])
        matrices.append(spline_through(round_, values, np.array(azimuth_deg), is_periodic=True))
    return matrices[0], matrices[1]
