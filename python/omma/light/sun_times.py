"""When the sun rises, is highest and sets, and when twilight begins and ends, by date and place."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import date, datetime, timedelta, timezone, tzinfo
from typing import Any, Literal

from omma._core import Error
from omma.base.arguments import checked, one_of, within
from omma.light.sun_position import FIRST_YEAR, LAST_YEAR, load_ephem, observer_at, sun_position

Twilight = Literal["civil", "nautical", "astronomical"]

# As the U.S. Naval Observatory has it ("Rise, Set, and Twilight Definitions"): the upper limb on
# the horizon, with 34 minutes of arc of refraction and 16 of the sun's radius; and the centre so
# far below it, geometrically.
_LIMB_DEG = -50 / 60
_TWILIGHT_DEG = {"civil": -6.0, "nautical": -12.0, "astronomical": -18.0}

_HALF_DAY = timedelta(hours=12)
_STEP = timedelta(minutes=10)
# The sun passes a quarter of a minute of arc in a second at most.
_CLOSE = timedelta(milliseconds=100)


@checked
def solar_noon(
    date: date, latitude_deg: float, longitude_deg: float, *, time_zone: tzinfo | None = None
) -> datetime:
    """When the sun crosses the meridian, which is when it is highest but for seconds.

    Args:
        date: the day, from 1901 to 2099.
        latitude_deg: -90 to 90, north is positive.
        longitude_deg: -180 to 180, east is positive.
        time_zone: the zone of whose calendar the date is, and of the result; a
            ``zoneinfo.ZoneInfo`` or a ``datetime.timezone``. None: the date is by local mean time
            (noon is within 17 minutes of 12 hours and 4 minutes for each degree west of Greenwich),
            the result in UTC.

    Example:
        >>> from datetime import date
        >>> omma.light.solar_noon(date(2026, 6, 21), 52.5, 13.4).strftime("%H:%M")
        '11:08'

    Raises:
        omma.Error: a date, latitude or longitude out of range, or PyEphem is not installed.
    """
    day = _checked_day(date)
    within(latitude_deg, "latitude_deg", -90, 90)
    within(longitude_deg, "longitude_deg", -180, 180)
    middle = datetime(day.year, day.month, day.day, 12, tzinfo=timezone.utc)
    mean_noon = middle - timedelta(hours=longitude_deg / 15)
    if time_zone is None:
        return _transit(mean_noon, longitude_deg)
    if not isinstance(time_zone, tzinfo):
        raise TypeError(
            "time_zone: expected a zoneinfo.ZoneInfo or a datetime.timezone, found "
            f"{time_zone!r:.40}"
        )
    for days in (0, -1, 1):
        noon = _transit(mean_noon + timedelta(days=days), longitude_deg).astimezone(time_zone)
        if noon.date() == day:
            return noon
    raise Error(f"date: expected a day with a noon in {time_zone}, found {day}")


@checked
def sunrise(
    date: date, latitude_deg: float, longitude_deg: float, *, time_zone: tzinfo | None = None
) -> datetime:
    """When the sun's upper limb comes over the horizon, before the day's `solar_noon`.

    As almanacs have it: level ground, and air that lifts the sun by 34 minutes of arc, so that its
    centre is at -50 minutes of arc of `sun_position`. Within a minute where the sun crosses the
    horizon steeply; near the polar circles a tenth of a degree of refraction is minutes.

    Args:
        date, latitude_deg, longitude_deg, time_zone: as of `solar_noon`.

    Example:
        >>> from datetime import date, timedelta
        >>> begin = omma.light.sunrise(date(2026, 6, 21), 52.5, 13.4)
        >>> sun = omma.light.sun_position(begin + timedelta(minutes=20), 52.5, 13.4)
        >>> round(sun.azimuth_deg), round(sun.elevation_deg, 1)
        (52, 1.5)

    Raises:
        omma.Error: the sun does not rise that day, which says whether it is polar day or night; a
            date, latitude or longitude out of range, or PyEphem is not installed.
    """
    return _crossing("sunrise", _LIMB_DEG, date, latitude_deg, longitude_deg, time_zone)


@checked
def sunset(
    date: date, latitude_deg: float, longitude_deg: float, *, time_zone: tzinfo | None = None
) -> datetime:
    """When the sun's upper limb goes below the horizon, after the day's `solar_noon`, by the same
    words as `sunrise`. In northern summers that may be after midnight.

    Args:
        date, latitude_deg, longitude_deg, time_zone: as of `solar_noon`.

    Example:
        >>> from datetime import date, timedelta, timezone
        >>> summer = timezone(timedelta(hours=2))
        >>> end = omma.light.sunset(date(2026, 6, 21), 52.5, 13.4, time_zone=summer)
        >>> end.strftime("%H:%M")
        '21:33'
        >>> light = omma.light.clear_sky_at(end + timedelta(minutes=20), 52.5, 13.4)

    Raises:
        omma.Error: as of `sunrise`.
    """
    return _crossing("sunset", _LIMB_DEG, date, latitude_deg, longitude_deg, time_zone)


@checked
def dawn(
    date: date,
    latitude_deg: float,
    longitude_deg: float,
    twilight: Twilight = "civil",
    *,
    time_zone: tzinfo | None = None,
) -> datetime:
    """When twilight begins before the day's `solar_noon`: the sun's centre is at -6 ("civil"), -12
    ("nautical") or -18 degrees ("astronomical").

    Args:
        date, latitude_deg, longitude_deg, time_zone: as of `solar_noon`.
        twilight: which.

    Example:
        >>> from datetime import date
        >>> omma.light.dawn(date(2026, 3, 20), 52.5, 13.4, "nautical").strftime("%H:%M")
        '03:55'

    Raises:
        omma.Error: the sun does not pass that elevation that day, which says on which side of it it
            stays; a date, latitude or longitude out of range, or PyEphem is not installed.
    """
    return _crossing("dawn", _depth(twilight), date, latitude_deg, longitude_deg, time_zone)


@checked
def dusk(
    date: date,
    latitude_deg: float,
    longitude_deg: float,
    twilight: Twilight = "civil",
    *,
    time_zone: tzinfo | None = None,
) -> datetime:
    """When twilight ends after the day's `solar_noon`, by the same elevations as `dawn`.

    Args:
        date, latitude_deg, longitude_deg, time_zone: as of `solar_noon`.
        twilight: which.

    Example:
        >>> from datetime import date
        >>> omma.light.dusk(date(2026, 3, 20), 52.5, 13.4, "astronomical").strftime("%H:%M")
        '19:16'

    Raises:
        omma.Error: as of `dawn`.
    """
    return _crossing("dusk", _depth(twilight), date, latitude_deg, longitude_deg, time_zone)


def _crossing(
    name: str,
    elevation_deg: float,
    date: date,
    latitude_deg: float,
    longitude_deg: float,
    time_zone: tzinfo | None,
) -> datetime:
    """When the sun passes an elevation: the last time before noon, or the first after it."""
    noon = solar_noon(date, latitude_deg, longitude_deg, time_zone=time_zone)
    start = noon.astimezone(timezone.utc)
    step = -_STEP if name in ("sunrise", "dawn") else _STEP

    def above(moment: datetime) -> float:
        return sun_position(moment, latitude_deg, longitude_deg).elevation_deg - elevation_deg

    moments = [start + k * step for k in range(_HALF_DAY // _STEP + 1)]
    if above(start) > 0:
        # Where it is lowest may lie between two steps.
        lowest = _lowest(above, moments)
        for near, far in zip(moments, moments[1:]):
            for end in (far, lowest):
                if abs(end - start) <= abs(far - start) and above(end) <= 0 < above(near):
                    return _halved(above, near, end).astimezone(noon.tzinfo)
    raise Error(_why_not(name, elevation_deg, _checked_day(date), latitude_deg, above(start) > 0))


def _lowest(above: Callable[[datetime], float], moments: list[datetime]) -> datetime:
    """When the sun is lowest, by a parabola through three moments."""
    heights = [above(one) for one in moments]
    k = min(max(heights.index(min(heights)), 1), len(moments) - 2)
    before, here, after = heights[k - 1 : k + 2]
    bend = before - 2 * here + after
    along = 0.5 * (before - after) / bend if bend > 0 else 0.0
    return moments[k] + max(-1.0, min(1.0, along)) * (moments[1] - moments[0])


def _halved(above: Callable[[datetime], float], near: datetime, far: datetime) -> datetime:
    """Between a moment when the sun is above and one when it is not, to a tenth of a second."""
    while abs(far - near) > _CLOSE:
        middle = near + (far - near) / 2
        if above(middle) > 0:
            near = middle
        else:
            far = middle
    return far


def _why_not(name: str, elevation_deg: float, day: date, latitude_deg: float, is_up: bool) -> str:
    if elevation_deg == _LIMB_DEG:
        what = "does not set: polar day" if is_up else "does not rise: polar night"
    else:
        what = f"stays {'above' if is_up else 'below'} {elevation_deg:g} degrees"
        what += ": the night is white" if is_up else ": polar night"
    return f"{name}: on {day} at latitude {latitude_deg:g} the sun {what}"


def _transit(near: datetime, longitude_deg: float) -> datetime:
    """When the sun's hour angle is 0, near a moment."""
    moment = near
    for _ in range(3):
        observer = observer_at(moment, 0.0, longitude_deg)
        sun = load_ephem().Sun(observer)
        behind = math.remainder(observer.sidereal_time() - sun.g_ra, 2 * math.pi)
        moment -= timedelta(days=behind / (2 * math.pi))
    return moment


def _depth(twilight: str) -> float:
    return _TWILIGHT_DEG[one_of(twilight, _TWILIGHT_DEG, "twilight")]


def _checked_day(day: Any) -> date:
    if isinstance(day, datetime):
        raise TypeError(
            f"date: expected a datetime.date, found a datetime {day.isoformat(' ', 'minutes')}; "
            "its .date() is the day"
        )
    if not isinstance(day, date):
        raise TypeError(f"date: expected a datetime.date, found {day!r:.40}")
    if not FIRST_YEAR < day.year < LAST_YEAR:
        raise Error(
            f"date: expected a year from {FIRST_YEAR + 1} to {LAST_YEAR - 1}, found {day.year}"
        )
    return day
