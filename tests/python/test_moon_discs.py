"""The moon's lit part as discs: total, centroid and spread beside closed forms, which way it lies
beside Meeus, and how far what an ommatidium sees is from a moon of many points."""

from datetime import datetime, timezone

import numpy as np
import pytest

import omma
from omma.base.directions import direction
from omma.light import moonlit_sky
from omma.light.moon_discs import MOON_RADIUS_RAD, bright_limb_deg, lit_strips, moon_discs

GREEN = omma.light.Bands.from_edges([545, 555])


@pytest.mark.parametrize("phase", [0.0, 60.0, 90.0, 120.0, 150.0])
def test_light_centroid_and_spread(phase):
    """Beside another quadrature, by ellipses from terminator to limb."""
    share, radius, x, y = np.transpose(lit_strips(phase))
    # Means over 503,000 points: edges are off by a part of a point.
    assert share.sum() == pytest.approx(1, abs=1e-12)
    assert share @ y == pytest.approx(0, abs=1e-3)
    across = np.sin((np.arange(2000) + 0.5) / 2000 * np.pi - np.pi / 2)[:, None]
    cos, sin = np.cos(np.radians(phase)), np.sin(np.radians(phase))
    along = (np.arange(2000) + 0.5) / 2000
    half = np.sqrt(1 - across**2)
    at = half * (-cos + (1 + cos) * along)
    z = np.sqrt(np.maximum(half**2 - at**2, 0))
    to_sun = np.maximum(z * cos + at * sin, 0)
    light = to_sun / (to_sun + z) * half * half * (1 + cos)
    light = light / light.sum()
    assert share @ x == pytest.approx((light * at).sum(), abs=3e-3)
    spread = (light * (at**2 + across**2)).sum()
    assert share @ (radius**2 / 2 + x**2 + y**2) == pytest.approx(spread, abs=3e-3)
    if phase == 0:
        # A full moon is even and whole.
        np.testing.assert_allclose([*share, *radius, *x, *y], [1, 1, 0, 0], atol=3e-3)


def test_half_moons_centroid():
    """Of Lommel and Seeliger's law at 90 degrees of phase, x / (x + z) on the right half of the
    disc, by another quadrature (polar)."""
    r = (np.arange(2000) + 0.5)[:, None] / 2000
    a = (np.arange(2000) + 0.5) / 2000 * np.pi - np.pi / 2
    x, z = r * np.cos(a), np.sqrt(1 - r**2)
    light = x / (x + z) * r
    share, _, found, _ = np.transpose(lit_strips(90.0))
    assert share @ found == pytest.approx((light * x).sum() / light.sum(), abs=2e-3)


def test_what_falls_on_the_ground_is_as_before():
    whole = moonlit_sky(40, moon_azimuth_deg=20, phase_angle_deg=100, bands=GREEN)
    parts = moonlit_sky(
        40, moon_azimuth_deg=20, phase_angle_deg=100, bright_limb_deg=70, bands=GREEN
    )
    assert len(whole.discs) == 1
    assert len(parts.discs) == 2
    facing = direction(20, 40)
    # Cosines of at most a quarter of a degree.
    np.testing.assert_allclose(parts.irradiance(facing)[1], whole.irradiance(facing)[1], rtol=2e-5)
    np.testing.assert_array_equal(parts.sky, whole.sky)
    narrow = moonlit_sky(40, phase_angle_deg=150, bright_limb_deg=70, bands=GREEN)
    assert len(narrow.discs) == 5


def test_which_way_it_lies():
    """To the right of a moon on the meridian is 90; the lit side is there."""
    moon = direction(0, 30)
    assert bright_limb_deg(moon, direction(60, 0)) == pytest.approx(
        np.degrees(np.arctan2(np.sin(np.pi / 3), -np.sin(np.pi / 6) * np.cos(np.pi / 3)))
    )
    assert bright_limb_deg(moon, direction(0, 80)) == pytest.approx(0, abs=1e-9)
    assert bright_limb_deg(moon, direction(0, -40)) == pytest.approx(180)
    for limb, beside in ((90.0, direction(0.3, 30)), (0.0, direction(0, 30.3))):
        discs = moon_discs(0, 30, 90.0, limb, np.ones(1))
        middle = sum(one.irradiance()[0] * one.direction for one in discs)
        middle /= np.linalg.norm(middle)
        assert (middle - moon) @ (beside - moon) > 0
        off = np.degrees(np.linalg.norm(middle - moon))
        assert off == pytest.approx(0.259 * 0.5, abs=0.03)


@pytest.mark.parametrize("day", [3, 10, 21, 25])
def test_the_bright_limb_beside_meeus(day):
    """Astronomical Algorithms, equations 48.5 and 14.1: the limb's angle from the celestial north,
    less the parallactic angle; there it turns to the left."""
    ephem = pytest.importorskip("ephem")
    moment, place = datetime(2026, 4, day, 19, tzinfo=timezone.utc), (52.5, 13.4)
    observer = ephem.Observer()
    observer.lat, observer.lon, observer.pressure = "52.5", "13.4", 0
    observer.date = moment.replace(tzinfo=None)
    observer.epoch = observer.date
    sun, moon = ephem.Sun(observer), ephem.Moon(observer)
    a0, d0, a, d = float(sun.ra), float(sun.dec), float(moon.ra), float(moon.dec)
    chi = np.arctan2(
        np.cos(d0) * np.sin(a0 - a),
        np.sin(d0) * np.cos(d) - np.cos(d0) * np.sin(d) * np.cos(a0 - a),
    )
    hour, phi = float(observer.sidereal_time()) - a, np.radians(place[0])
    parallactic = np.arctan2(np.sin(hour), np.tan(phi) * np.cos(d) - np.sin(d) * np.cos(hour))
    found = bright_limb_deg(
        *(
            direction(one.azimuth_deg, one.elevation_deg)
            for one in (
                omma.light.moon_position(moment, *place),
                omma.light.sun_position(moment, *place),
            )
        )
    )
    # The moon's parallax: its direction as seen from the place is a degree from `ra`, `dec`'s.
    off = (found + np.degrees(chi - parallactic) + 180) % 360 - 180
    assert abs(off) < 3


@pytest.mark.parametrize(
    ("phase", "most"), [(30.0, 0.01), (60.0, 0.02), (100.0, 0.01), (150.0, 0.005)]
)
def test_what_a_narrow_ommatidium_sees(phase, most):
    """An ommatidium of 1 degree that looks at the moon's middle or beside it: the discs beside
    each point of the lit part; the whole disc would be off by some percent."""
    side = np.linspace(-1, 1, 801)
    x, y = np.meshgrid(side, side)
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    to_sun = z * np.cos(np.radians(phase)) + x * np.sin(np.radians(phase))
    light = np.where((z > 0) & (to_sun > 0), to_sun / np.maximum(to_sun + z, 1e-9), 0)
    radius_deg = np.degrees(MOON_RADIUS_RAD)
    for at_x, at_y in ((0, 0), (0.5, 0), (0, 0.5), (-0.5, 0.3)):
        beam = np.exp(
            -4 * np.log(2) * ((radius_deg * x - at_x) ** 2 + (radius_deg * y - at_y) ** 2)
        )
        exact = (light * beam).sum() / light.sum()
        found = 0.0
        for share, radius, mx, my in lit_strips(phase):
            # A disc's own width adds r^2 / 4 to each variance, to the first order.
            width = 1 + 4 * np.log(2) * 2 * (radius_deg * radius) ** 2 / 4
            away = (radius_deg * mx - at_x) ** 2 + (radius_deg * my - at_y) ** 2
            found += share * np.exp(-4 * np.log(2) * away / width) / width
        assert found == pytest.approx(exact, rel=most)


def test_at_a_time_and_place():
    pytest.importorskip("ephem")
    # Six days after new, in the evening: the right side is lit, in the north.
    moment = datetime(2026, 4, 23, 20, tzinfo=timezone.utc)
    light = omma.light.natural_sky_at(moment, 52.5, 13.4, bands=GREEN)
    moon = omma.light.moon_position(moment, 52.5, 13.4)
    assert 0.3 < moon.illuminated_fraction < 0.7
    assert len(light.discs) == 2
    lit = sum(one.irradiance()[0] * one.direction for one in light.discs)
    right = direction(moon.azimuth_deg + 90, 0)
    assert (lit / np.linalg.norm(lit)) @ right > 1e-3
    with pytest.raises(omma.Error, match="bright_limb_deg: expected -360 to 360, found 400"):
        moonlit_sky(40, bright_limb_deg=400)
