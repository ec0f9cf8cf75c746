"""Where the light of stars and of dust between the planets comes from: maps in galactic and in
ecliptic directions, and which way those lie at a time and place.

Brightness is in S10: stars of magnitude 10 like the sun on a square degree.
"""

from __future__ import annotations

import functools
from datetime import datetime
from importlib import resources

import numpy as np

from omma.base.arrays import Floats, Ints
from omma.light.sun_position import load_ephem, observer_at

# Of the zodiacal light at the ecliptic's poles (Leinert et al. 1998, equation 19).
ZODIACAL_POLE_S10 = 60.0


def _rotation(pole: tuple[float, float], node_deg: float) -> Floats:
    """To directions whose third axis is a pole, by its right ascension and declination, degrees;
    node_deg: longitude of the celestial pole."""
    ascension, declination, turn = np.radians([*pole, 180 - node_deg])
    c, s = np.cos(ascension), np.sin(ascension)
    about = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    c, s = np.sin(declination), np.cos(declination)
    tilted = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    c, s = np.cos(turn), np.sin(turn)
    return np.asarray(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ tilted @ about)


# Of J2000: the galactic pole and the longitude of the celestial one (ESA, The Hipparcos Catalogue,
# 1997, volume 1, section 1.5.3); the ecliptic's pole, 23.4393 degrees from it.
GALACTIC_FROM_EQUATORIAL = _rotation((192.85948, 27.12825), 122.93192)
ECLIPTIC_FROM_EQUATORIAL = _rotation((270.0, 90 - 23.4392911), 90.0)


def equatorial_from_horizon(moment: datetime, latitude_deg: float, longitude_deg: float) -> Floats:
    """(3, 3), from directions where -Z is north to those of J2000, by what stands in the north, in
    the east and in the zenith: within 0.02 degrees, as aberration is not the same for all."""
    observer = observer_at(moment, latitude_deg, longitude_deg)
    observer.epoch = "2000"
    columns = []
    for azimuth, elevation in ((np.pi / 2, 0.0), (0.0, np.pi / 2), (np.pi, 0.0)):
        ascension, declination = observer.radec_of(azimuth, elevation)
        flat = np.cos(declination)
        columns.append(
            (flat * np.cos(ascension), flat * np.sin(ascension), float(np.sin(declination)))
        )
    u, _, v = np.linalg.svd(np.transpose(columns))
    return np.asarray(u @ v)


def starlight_s10(galactic: Floats) -> Floats:
    """At 440 nm, above the air, of all stars but those that `stars` shows: (...) of (..., 3)."""
    nodes = _star_nodes()[1]
    return np.asarray(
        sum(share * nodes[row, column] for share, row, column in node_shares(galactic))
    )


def zodiacal_s10(ecliptic: Floats, sun_longitude_rad: float) -> Floats:
    """At 500 nm, above the air, from the earth: (...) of (..., 3); on the logarithm straight
    between the nodes of its table."""
    longitude, latitude, table = _zodiacal_nodes()
    away = np.arctan2(ecliptic[..., 1], ecliptic[..., 0]) - sun_longitude_rad
    away = np.degrees(np.abs((away + np.pi) % (2 * np.pi) - np.pi))
    up = np.degrees(np.abs(np.arcsin(np.clip(ecliptic[..., 2], -1, 1))))
    row, above = _between(latitude, up)
    column, right = _between(longitude, away)
    low = (1 - right) * table[row, column] + right * table[row, column + 1]
    high = (1 - right) * table[row + 1, column] + right * table[row + 1, column + 1]
    return np.asarray(np.exp((1 - above) * low + above * high))


def sun_longitude_rad(moment: datetime) -> float:
    """Of the ecliptic of J2000."""
    ephem = load_ephem()
    sun = ephem.Sun()
    sun.compute(moment.replace(tzinfo=None), epoch="2000")
    return float(ephem.Ecliptic(sun).lon)


def node_shares(galactic: Floats) -> list[tuple[Floats, Ints, Ints]]:
    """The four nodes about directions (..., 3), of the map of starlight: shares, rows, columns.
    Nearer to the poles than its last rows these hold."""
    latitude = _star_nodes()[0]
    b = np.degrees(np.arcsin(np.clip(galactic[..., 2], -1, 1)))
    row, up = _between(latitude, np.clip(b, latitude[0], latitude[-1]))
    turn = np.degrees(np.arctan2(galactic[..., 1], galactic[..., 0])) / 10 % 36
    left = turn.astype(np.int64) % 36
    along = turn - np.floor(turn)
    right = (left + 1) % 36
    return [
        ((1 - up) * (1 - along), row, left),
        ((1 - up) * along, row, right),
        (up * (1 - along), row + 1, left),
        (up * along, row + 1, right),
    ]


@functools.cache
def node_solid_angles() -> Floats:
    """What a node of the map of starlight counts in its sum over all directions, sr, (25, 36)."""
    latitude = _star_nodes()[0]
    b = np.linspace(-90, 90, 18001)
    middle = (b[1:] + b[:-1]) / 2
    each = np.diff(np.sin(np.radians(b))) * 2 * np.pi / 36
    row, up = _between(latitude, np.clip(middle, latitude[0], latitude[-1]))
    sums = np.bincount(row, (1 - up) * each, len(latitude))
    sums += np.bincount(row + 1, up * each, len(latitude))
    return np.repeat(sums[:, None], 36, axis=1)


def _between(nodes: Floats, at: Floats) -> tuple[Ints, Floats]:
    low = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, len(nodes) - 2)
    return low, np.asarray((at - nodes[low]) / (nodes[low + 1] - nodes[low]))


@functools.cache
def _star_nodes() -> tuple[Floats, Floats]:
    """Latitudes, degrees, (25,), and S10, (25, 36)."""
    faint = _table("faint_stars.csv")
    return faint[:, 0], faint[:, 1:] + _table("middling_stars.csv")[:, 1:]


@functools.cache
def _zodiacal_nodes() -> tuple[Floats, Floats, Floats]:
    """Degrees from the sun in longitude, degrees of latitude, logarithms of S10."""
    table = _table("zodiacal_light.csv")
    pole = np.full((1, table.shape[1] - 1), ZODIACAL_POLE_S10)
    return table[0, 1:], np.append(table[1:, 0], 90.0), np.log(np.vstack([table[1:, 1:], pole]))


def _table(name: str) -> Floats:
    file = resources.files("omma.light") / "data" / name
    return np.loadtxt(file.read_text().splitlines(), delimiter=",")
