"""Sunrise, noon, sunset and twilight: published times, and the sun's own elevation then."""

from datetime import date, datetime, timedelta, timezone
from zoneinfo import ZoneInfo

import pytest

import omma
from omma.light import dawn, dusk, moon_position, solar_noon, sun_position, sunrise, sunset

pytest.importorskip("ephem")

UTC = timezone.utc
ATLANTA, BLUFFTON, DEFIANCE = (33.8, -84.4), (40.8939, -83.8917), (41.281944, -84.362778)
NORTH = (69.5, 19.0)


def when(text):
    return datetime.fromisoformat(text).replace(tzinfo=UTC)


def near(found, published):
    """Published times are rounded to a minute, the last digit of a place is some seconds."""
    assert found.utcoffset() is not None
    assert abs(found - when(published)) <= timedelta(minutes=1)


def test_times_of_the_naval_observatory():
    """USNO's "Sun and Moon Data for One Day", as printed in the documentation of PyEphem (6
    September 2009) and in Skyfield's tests (the others), in UTC."""
    day = date(2009, 9, 6)
    near(dawn(day, *ATLANTA), "2009-09-06T10:50")
    near(sunrise(day, *ATLANTA), "2009-09-06T11:15")
    near(solar_noon(day, *ATLANTA), "2009-09-06T17:36")
    near(sunset(day, *ATLANTA), "2009-09-06T23:56")
    near(dusk(day, *ATLANTA), "2009-09-07T00:21")
    day = date(2018, 9, 12)
    near(sunrise(day, *BLUFFTON), "2018-09-12T11:13")
    near(sunset(day, *BLUFFTON), "2018-09-12T23:50")
    day = date(2019, 11, 8)
    for twilight, begins, ends in (
        ("astronomical", "10:42", "23:59"),
        ("nautical", "11:15", "23:27"),
        ("civil", "11:48", "22:54"),
    ):
        near(dawn(day, *DEFIANCE, twilight), f"2019-11-08T{begins}")
        near(dusk(day, *DEFIANCE, twilight), f"2019-11-08T{ends}")


def test_the_edge_of_polar_day():
    """USNO's for 69.5 N, 19 E in 2014, at UTC+1, as quoted on answers.com: it rises on 17 May at
    0:29 and sets at 23:06, rises on the 18th at 0:13 and does not set until July."""
    zone = timezone(timedelta(hours=1))
    last = date(2014, 5, 17)
    near(sunrise(last, *NORTH, time_zone=zone), "2014-05-16T23:29")
    near(solar_noon(last, *NORTH, time_zone=zone), "2014-05-17T10:40")
    near(sunset(last, *NORTH, time_zone=zone), "2014-05-17T22:06")
    near(sunrise(date(2014, 5, 18), *NORTH, time_zone=zone), "2014-05-17T23:13")
    with pytest.raises(
        omma.Error, match=r"sunset: on 2014-05-18 at latitude 69.5 .*set: polar day"
    ):
        sunset(date(2014, 5, 18), *NORTH)
    with pytest.raises(omma.Error, match=r"sunrise: .* does not set: polar day"):
        sunrise(date(2014, 6, 21), *NORTH)
    with pytest.raises(omma.Error, match=r"sunrise: .* does not rise: polar night"):
        sunrise(date(2014, 12, 21), *NORTH)
    # There is twilight then, at noon.
    assert dawn(date(2014, 12, 21), *NORTH) < dusk(date(2014, 12, 21), *NORTH)
    with pytest.raises(omma.Error, match=r"dusk: .* stays above -18 degrees: the night is white"):
        dusk(date(2026, 6, 21), 52.5, 13.4, "astronomical")
    with pytest.raises(omma.Error, match=r"dawn: .* stays below -6 degrees: polar night"):
        dawn(date(2026, 12, 21), 85, 0)


@pytest.mark.parametrize("place", [(0, 0), (-33.9, 151.2), (64.1, -22), (65.7, 24), (52.5, 13.4)])
@pytest.mark.parametrize("day", [date(1950, 3, 1), date(2026, 6, 5), date(2080, 11, 30)])
def test_the_sun_is_where_it_is_said_to_be(place, day):
    """A tenth of a second is 0.0004 degrees at most."""
    noon = solar_noon(day, *place)
    for moment, elevation in (
        (sunrise(day, *place), -50 / 60),
        (sunset(day, *place), -50 / 60),
        *((f(day, *place, "nautical"), -12) for f in (dawn, dusk) if abs(place[0]) < 53),
    ):
        assert sun_position(moment, *place).elevation_deg == pytest.approx(elevation, abs=5e-4)
        assert abs(moment - noon) < timedelta(hours=12)
    # On the meridian, in the south or in the north.
    azimuth = sun_position(noon, *place).azimuth_deg
    assert min(azimuth, abs(azimuth - 180), 360 - azimuth) < 1e-3


def test_azimuths_are_below_a_whole_turn():
    """Times at which single precision makes a little more than a whole turn of north."""
    sydney = (-33.9, 151.2)
    azimuth = sun_position(solar_noon(date(2026, 9, 23), *sydney), *sydney).azimuth_deg
    assert 0 <= azimuth < 1e-3
    moment = datetime(2026, 1, 10, 19, 51, 37, 546726, tzinfo=timezone.utc)
    assert 0 <= moon_position(moment, *sydney).azimuth_deg < 1e-3


def test_a_night_that_only_just_is_not_white():
    """Where the sun dips below the horizon for less than the ten minutes between two looks."""
    day = date(2026, 6, 21)
    noon = solar_noon(day, 65.7, 24)
    lowest = noon + timedelta(hours=12)
    # So that it stands 0.002 degrees below the elevation of sunset at its lowest.
    latitude = 65.7 - 50 / 60 - sun_position(lowest, 65.7, 24).elevation_deg - 0.002
    assert timedelta(hours=11, minutes=50) < sunset(day, latitude, 24) - noon < timedelta(hours=12)
    with pytest.raises(omma.Error, match="polar day"):
        sunset(day, latitude + 0.01, 24)


def test_days_of_other_calendars():
    """Kiritimati's clocks are 24.5 hours before its mean time."""
    zone = timezone(timedelta(hours=14))
    day = date(2026, 1, 1)
    noon = solar_noon(day, 1.87, -157.4, time_zone=zone)
    assert noon.date() == day
    assert noon.utcoffset() == timedelta(hours=14)
    assert solar_noon(day, 1.87, -157.4) - noon == pytest.approx(
        timedelta(days=1), abs=timedelta(minutes=1)
    )
    assert sunset(day, 1.87, -157.4, time_zone=zone).date() == day


def test_what_is_refused():
    day = date(2026, 6, 21)
    told = r"date: expected a datetime\.date, found a datetime .*; its \.date\(\) is the day"
    with pytest.raises(TypeError, match=told):
        sunset(datetime(2026, 6, 21, 12), 0, 0)
    with pytest.raises(omma.Error, match="date: expected a year from 1901 to 2099, found 2100"):
        sunset(date(2100, 1, 1), 0, 0)
    with pytest.raises(omma.Error, match="latitude_deg: expected -90 to 90, found 91"):
        sunrise(day, 91, 0)
    with pytest.raises(omma.Error, match="longitude_deg: expected -180 to 180"):
        solar_noon(day, 0, 181)
    with pytest.raises(omma.Error, match=r"twilight: expected one of civil, .*'naval'"):
        dusk(day, 0, 0, "naval")
    with pytest.raises(TypeError, match="time_zone"):
        dusk(day, 0, 0, time_zone="Europe/Berlin")


def test_a_time_that_clocks_skip_is_refused():
    """On 29 March 2026 it was never 2:30 in Madrid; on 25 October it was twice."""
    madrid = ZoneInfo("Europe/Madrid")
    for look in (omma.light.sun_position, omma.light.moon_position, omma.light.clear_sky_at):
        with pytest.raises(omma.Error, match=r"found 2026-03-29T02:30:00.*is 2026-03-29T03:30"):
            look(datetime(2026, 3, 29, 2, 30, tzinfo=madrid), 37, -6)
    twice = [datetime(2026, 10, 25, 2, 30, tzinfo=madrid, fold=fold) for fold in (0, 1)]
    one, other = (omma.light.sun_position(when, 37, -6).azimuth_deg for when in twice)
    assert one != other
