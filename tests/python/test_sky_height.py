"""Clear skies above the sea: the standard atmosphere, Beer and Lambert's law, skies of the same
optical depth, and an independent Monte Carlo in a round atmosphere over high ground.
"""

import numpy as np
import pytest
from sky_monte_carlo import EARTH_M, RoundSky, air_share, ozone_share

import omma
from omma.light.sky_height import air_above
from omma.light.sky_stored import depths_of_air_and_haze
from omma.light.sky_tables import TableSky, clear_sky_map
from omma.scene.light_words import parse_light

HAZE_SCALE_M = 2000.0  # scripts/sky/atmosphere.py
# Ozone takes less than 4e-4 between these.
FREE_NM = np.array([360.0, 380.0, 400.0, 425.0])
FEW = omma.light.Bands([350.0, 450.0, 650.0], np.eye(3))


@pytest.mark.parametrize(
    ("height_m", "pascal"),
    # Table of the US Standard Atmosphere 1976 as engineersedge.com has it, with 101325.3 at 0.
    [(0.0, 101325.3), (1524.0, 84322.9), (3048.0, 69692.2), (4572.0, 57198.9)],
)
def test_pressure_of_the_standard_atmosphere(height_m, pascal):
    # Its heights are geometric or geopotential, which differ by 7e-4 of themselves at most.
    pressure, warmth = air_above(height_m)
    assert pressure == pytest.approx(pascal / 101325.3, rel=1e-3)
    # What is above goes with pressure, and density at the ground with pressure over temperature.
    # Gravity falls by 3e-4 a km.
    height = np.linspace(0, 100e3, 100_001)
    column = np.trapezoid(air_share(height + height_m), height)
    assert pressure == pytest.approx(column / np.trapezoid(air_share(height), height), rel=2e-3)
    assert pressure / warmth == pytest.approx(float(air_share(height_m)), rel=1e-4)


@pytest.mark.parametrize("sun", [0.0, 0.7, 2.0, 5.0, 20.0, 63.0])
def test_the_sun_is_brighter_by_beer_and_lamberts_law(sun):
    """Depths on the way through round layers, by a quadrature of its own: exp(-sum of depths)."""
    ground = 3000.0
    nm = np.array([320.0, 400.0, 550.0, 600.0, 700.0])
    upwards = np.linspace(0, 1, 20_001) ** 2 * 100e3
    middle = 0.5 * (upwards[1:] + upwards[:-1])

    def passed(ground_m):
        radius = EARTH_M + ground_m
        along = np.sqrt((radius + upwards) ** 2 - (radius * np.cos(np.radians(sun))) ** 2)
        on_way, up = np.diff(along), np.diff(upwards)
        sea_m = np.trapezoid(air_share(upwards), upwards)
        air_m = on_way @ air_share(middle + ground_m)
        ozone = ozone_share(middle + ground_m)
        haze = np.exp(-middle / HAZE_SCALE_M)
        table = TableSky(90.0, 0.0, 300.0).table
        of_ozone = 300 * np.interp(nm, table["fine_nm"], table["ozone_depth_per_du"])
        of_air, of_haze = depths_of_air_and_haze(nm)
        return (
            of_air * air_m / sea_m
            + of_ozone * (on_way @ ozone) / (up @ ozone)
            + 0.1 * of_haze * (on_way @ haze) / (up @ haze)
        )

    found = TableSky(sun, 0.1, 300.0, ground).transmission(nm)
    low = TableSky(sun, 0.1, 300.0).transmission(nm)
    # How much brighter than at the sea, as a share of the depth that is no longer before it: the
    # bell of ozone is not quite the tables', and Chapman's function is of air that thins evenly.
    less = passed(0.0) - passed(ground)
    np.testing.assert_allclose(np.log(found / low)[1:], less[1:], rtol=0.005 if sun > 4 else 0.03)
    assert np.all(found > low)


def test_upright_it_is_that_law_exactly():
    nm = np.array([310.0, 400.0, 550.0])
    high, low = (TableSky(90.0, 0.05, 300.0, h).transmission(nm) for h in (4000.0, 0.0))
    share = air_above(4000.0)[0]
    # In round air the way upwards is the column but for 1e-4.
    np.testing.assert_allclose(
        high, low * np.exp((1 - share) * depths_of_air_and_haze(nm)[0]), rtol=2e-4
    )


@pytest.mark.parametrize("height_m", [1000.0, 3000.0, 5000.0])
@pytest.mark.parametrize("sun", [70.0, 32.0, 14.0])
def test_skies_of_one_optical_depth_are_alike(sun, height_m):
    """Without ozone and haze a sky in flat air depends on how deep the air is: over less air it is
    that at the sea at the longer wavelength where it is as deep."""
    fine = np.arange(300.0, 701.0)
    depth = depths_of_air_and_haze(fine)[0]
    less = air_above(height_m)[0] * np.interp(FREE_NM, fine, depth)
    longer = np.interp(-less, -depth, fine)
    directions = np.array([5.0, 30.0, 88.0]), np.array([0.0, 60.0, 130.0])
    high = TableSky(sun, 0.0, 300.0, height_m)
    # Little ozone, as there is some at the longer wavelengths.
    low = TableSky(sun, 0.0, 200.0)
    log_i, q, u = high.stokes(*directions, FREE_NM)
    at_sea = low.stokes(*directions, longer)
    ozone = np.interp(longer, low.table["fine_nm"], 200 * low.table["ozone_depth_per_du"])
    # It passes ozone once; the fit to the tables leaves 0.2 % to 0.4 %, the air's depolarisation,
    # which changes with wavelength, 0.002.
    above = ozone / np.sin(np.radians(sun))
    np.testing.assert_allclose(log_i, at_sea[0] + above, atol=0.006)
    np.testing.assert_allclose(q, at_sea[1], atol=0.006)
    np.testing.assert_allclose(u, at_sea[2], atol=0.006)
    # And so is what comes back of the ground's light, in flat air altogether.
    shine, back, _ = high.ground(directions[0], FREE_NM, 0.8)
    at_sea = low.ground(directions[0], longer, 0.8)
    np.testing.assert_allclose(shine, at_sea[0], rtol=0.004)
    np.testing.assert_allclose(back, at_sea[1], rtol=0.02)


@pytest.mark.parametrize(
    ("sun", "elevation", "azimuth", "nm", "height_m"),
    [
        (45, 20, 130, 380, 2000),
        (30, 45, 90, 330, 4000),
        (20, 62, 90, 550, 5000),
        (5, 10, 0, 500, 3000),
        (3, 22, 60, 330, 3000),
        (-2.5, 22, 94, 570, 2000),
        (-4, 30, 0, 440, 4000),
    ],
)
def test_against_an_independent_monte_carlo(sun, elevation, azimuth, nm, height_m):
    table = TableSky(90.0, 0.0, 300.0).table
    fine = table["fine_nm"]
    sky = RoundSky(
        depths_of_air_and_haze(nm)[0],
        300 * np.interp(nm, fine, table["ozone_depth_per_du"]),
        np.interp(nm, table["wavelength_nm"], table["anisotropy"]),
        ground_m=height_m,
    )
    mean, error = sky.radiance(sun, elevation, azimuth, 8_000, np.random.default_rng(5))
    at = np.array([elevation]), np.array([azimuth]), np.array([nm])
    log_i, q, u = TableSky(sun, 0.0, 300.0, height_m).stokes(*at)
    radiance, degree = (0.05, 0.02) if sun < 5 else (0.01, 0.006)
    # Three standard errors of Monte Carlo on top of what is promised. At the sea, where the sky is
    # another by a tenth and more, these would not hold.
    assert abs(np.exp(log_i.item()) - mean[0]) < radiance * mean[0] + 3 * error[0]
    assert abs(q.item() - mean[1] / mean[0]) < degree + 3 * error[1] / mean[0]
    assert abs(u.item() - mean[2] / mean[0]) < degree + 3 * error[2] / mean[0]


def test_darker_more_polarised_and_more_ultraviolet():
    low, high = (
        omma.light.clear_sky(40.0, aerosol=0.0, height_m=h, bands=FEW) for h in (0.0, 3000.0)
    )
    (sky, sun), (dark_sky, bright_sun) = low.irradiance(), high.irradiance()
    assert np.all(bright_sun > sun)
    assert np.all(dark_sky < sky)
    assert bright_sun[0] / sun[0] > bright_sun[1] / sun[1] > bright_sun[2] / sun[2]
    zenith = [one.radiance((0, 1, 0)) for one in (low, high)]
    degree = [np.hypot(one[1], one[2]) / one[0] for one in zenith]
    assert np.all(degree[1] > degree[0])
    # The ground is lit by both.
    np.testing.assert_allclose(
        high.radiance((0, -1, 0))[0], 0.1 / np.pi * (dark_sky + bright_sun), rtol=0.01
    )


def test_at_the_sea_it_is_the_sky_of_before():
    near, there = (omma.light.clear_sky(20.0, height_m=h, bands=FEW) for h in (1.0, 0.0))
    far = omma.light.clear_sky(20.0, bands=FEW)
    np.testing.assert_array_equal(there.sky, far.sky)
    np.testing.assert_allclose(near.sky, far.sky, rtol=3e-4, atol=1e-5 * far.sky.max())


def test_all_clear_skies_take_it():
    settings = {"height_m": 2500.0, "bands": FEW}
    sunlit = omma.light.clear_sky(25.0, **settings)
    moonlit = omma.light.moonlit_sky(25.0, **settings)
    low = [make(25.0, bands=FEW) for make in (omma.light.moonlit_sky, omma.light.clear_sky)]
    at_sea = np.divide(*(one.radiance((0, 1, 0))[0] for one in low))
    above = np.divide(*(one.radiance((0, 1, 0))[0] for one in (moonlit, sunlit)))
    np.testing.assert_allclose(above, at_sea, rtol=1e-5)
    natural = omma.light.natural_sky(25.0, **settings)
    np.testing.assert_allclose(natural.irradiance()[0], sunlit.irradiance()[0], rtol=1e-6)
    cloud = omma.light.overcast_sky(25.0, **settings).irradiance()[0]
    np.testing.assert_allclose(cloud, 0.25 * sum(sunlit.irradiance()), rtol=1e-4)
    words = parse_light("clear_sky sun_elevation_deg=25 height_m=2500")
    assert words["light"] == omma.light.clear_sky(25, height_m=2500)
    # Air between surfaces is as thin as it is there.
    thin, thick = (
        omma.light.with_air(omma.light.clear_sky(25.0, aerosol=0.0, height_m=h, bands=FEW))
        for h in (2500.0, 0.0)
    )
    np.testing.assert_allclose(
        thin.extinction_per_m / thick.extinction_per_m, float(air_share(2500.0)), rtol=1e-4
    )


def test_skies_at_a_time_and_place_take_it():
    pytest.importorskip("ephem")
    from datetime import datetime, timezone

    noon = datetime(2026, 6, 21, 11, tzinfo=timezone.utc)
    settings = {"height_m": 2500.0, "bands": FEW}
    light = omma.light.clear_sky_at(noon, 47.0, 11.0, **settings)
    sun = omma.light.sun_position(noon, 47.0, 11.0)
    same = omma.light.clear_sky(sun.elevation_deg, sun_azimuth_deg=sun.azimuth_deg, **settings)
    np.testing.assert_array_equal(light.sky, same.sky)
    natural = omma.light.natural_sky_at(noon, 47.0, 11.0, **settings)
    np.testing.assert_allclose(natural.irradiance()[1], light.irradiance()[1], rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"height_m": -1.0}, "height_m: expected 0 to 5000, found -1"),
        ({"height_m": 5001.0}, "height_m: expected 0 to 5000"),
        ({"height_m": np.nan}, "height_m: expected 0 to 5000"),
        ({"height_m": 2000.0, "aerosol": 0.31}, "aerosol: expected 0 to 0.3"),
    ],
)
def test_nonsense_is_refused(change, message):
    with pytest.raises(omma.Error, match=message):
        clear_sky_map([400.0], [[1.0]], 30.0, 0.0, **change)
    with pytest.raises(omma.Error, match=message):
        omma.light.clear_sky(30.0, **change)
