"""Where sun and moon stand, by time and place: PyEphem, an optional extra, without a network."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any

from omma._core import Error
from omma.base.arguments import checked, within
from omma.base.optional import needs
from omma.base.values import value_class
from omma.base.warn import warn_caller

# The earth's rotation is known or can be foretold to seconds for these, which is 0.01 degrees.
FIRST_YEAR, LAST_YEAR = 1900, 2100


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class SunPosition:
    """Where the sun's centre stands.

    Azimuth comes first, as everywhere; before 0.1 `sun_position` gave (elevation, azimuth). So what
    takes it apart without names is warned, up to 0.2.

    Attributes:
        azimuth_deg: from 0 to below 360, from north to the east.
        elevation_deg: above the horizon.
    """

    azimuth_deg: float
    elevation_deg: float

    def __iter__(self) -> Iterator[float]:
        """Azimuth, then elevation, with a warning."""
        warn_caller(
            "sun_position: gives (azimuth, elevation), which was (elevation, azimuth) before; say "
            ".azimuth_deg and .elevation_deg",
            FutureWarning,
        )
        return iter((self.azimuth_deg, self.elevation_deg))


@checked
def sun_position(date_time: datetime, latitude_deg: float, longitude_deg: float) -> SunPosition:
    """Azimuth and elevation of the sun's centre, degrees; azimuth from north to the east.

    As it would stand without the air's refraction, which lifts it by 0.5° at the horizon and by
    less than 0.1° above 10°. Within 0.01° from 1900 to 2100.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.

    Returns:
        ``azimuth_deg`` and ``elevation_deg``.

    Raises:
        omma.Error: a time without a time zone or out of range, a latitude or longitude out of
            range, or PyEphem is not installed.
    """
    moment = universal(date_time)
    within(latitude_deg, "latitude_deg", -90, 90)
    within(longitude_deg, "longitude_deg", -180, 180)
    sun = load_ephem().Sun(observer_at(moment, latitude_deg, longitude_deg))
    return SunPosition(_azimuth_deg(sun), math.degrees(sun.alt))


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class MoonPosition:
    """Where the moon's centre stands, and how much of it is lit.

    Attributes:
        azimuth_deg: from 0 to below 360, from north to the east.
        elevation_deg: above the horizon.
        phase_angle_deg: between sun and earth, seen from the moon: 0 is full, 180 new.
        illuminated_fraction: of its disc, (1 + cos(phase angle)) / 2.
    """

    azimuth_deg: float
    elevation_deg: float
    phase_angle_deg: float
    illuminated_fraction: float


@checked
def moon_position(date_time: datetime, latitude_deg: float, longitude_deg: float) -> MoonPosition:
    """Azimuth and elevation of the moon's centre from a place on the earth's surface, without
    refraction, and its phase.

    Args:
        date_time: with its time zone.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.

    Returns:
        ``azimuth_deg``, ``elevation_deg``, ``phase_angle_deg`` and ``illuminated_fraction``.

    Raises:
        omma.Error: a time without a time zone or out of range, a latitude or longitude out of
            range, or PyEphem is not installed.
    """
    moment = universal(date_time)
    within(latitude_deg, "latitude_deg", -90, 90)
    within(longitude_deg, "longitude_deg", -180, 180)
    moon = load_ephem().Moon(observer_at(moment, latitude_deg, longitude_deg))
    lit = moon.phase / 100
    angle = math.degrees(math.acos(max(-1.0, min(1.0, 2 * lit - 1))))
    return MoonPosition(_azimuth_deg(moon), math.degrees(moon.alt), angle, lit)


def _azimuth_deg(body: Any) -> float:
    # PyEphem's is in single precision, in which a whole turn is a little more than one.
    return math.degrees(body.az) % 360.0


def observer_at(moment: datetime, latitude_deg: float, longitude_deg: float) -> Any:
    """PyEphem's observer at a moment in UTC, without refraction."""
    observer = load_ephem().Observer()
    observer.lat, observer.lon = math.radians(latitude_deg), math.radians(longitude_deg)
    observer.pressure = 0
    observer.date = moment.replace(tzinfo=None)
    return observer


def universal(date_time: Any) -> datetime:
    """A time in UTC; omma.Error where it has no zone, is none of its zone, as
    clocks skip an hour in spring, or is out of the years that are known."""
    if not isinstance(date_time, datetime):
        raise TypeError(f"date_time: expected a datetime.datetime, found {date_time!r:.40}")
    if date_time.utcoffset() is None:
        raise Error(
            "date_time: expected a time with its time zone, such as "
            f"datetime(2026, 6, 21, 12, tzinfo=timezone.utc), found {date_time.isoformat()}"
        )
    if not FIRST_YEAR < date_time.year < LAST_YEAR:
        raise Error(
            f"date_time: expected a year from {FIRST_YEAR + 1} to {LAST_YEAR - 1}, found "
            f"{date_time.year}"
        )
    moment = date_time.astimezone(timezone.utc)
    there = moment.astimezone(date_time.tzinfo)
    if there.replace(tzinfo=None) != date_time.replace(tzinfo=None):
        raise Error(
            f"date_time: expected a time that its time zone has, found {date_time.isoformat()}, "
            f"which is {there.isoformat()} there"
        )
    return moment


def load_ephem() -> Any:
    return needs("ephem", "sky", "the sun's position needs PyEphem")
