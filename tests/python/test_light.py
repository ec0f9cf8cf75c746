"""Lights as values: radiance, irradiance, skies, discs, panoramas and how they are kept."""

import copy
import pickle
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest

import omma
from omma.base.directions import direction
from omma.light import Bands, Disc, Light

FEW = Bands.equal(4)


def test_uniform_light_is_the_same_from_everywhere():
    light = omma.light.uniform_sky(2.0)
    seen = light.radiance(direction([0, 77, 200, -120], [90, 0, 31, -60]))
    assert seen.shape == (4, 3, 16)
    np.testing.assert_array_equal(seen[:, 0], 2)
    np.testing.assert_array_equal(seen[:, 1:], 0)


@pytest.mark.parametrize("by_channels", [False, True])
def test_some_bands_are_those_of_all(by_channels):
    light = omma.light.clear_sky(30)
    if by_channels:
        picture = np.random.default_rng(0).random((6, 12, 3)).astype(np.float32)
        light = omma.light.panorama(picture, ultraviolet="as_blue")
    towards = direction(np.linspace(0, 360, 50), np.linspace(-90, 90, 50))
    chosen = light._radiance_of(towards, [3, 9])
    of_all = light.radiance(towards)[..., [3, 9]]
    np.testing.assert_allclose(chosen, of_all, rtol=1e-6, atol=1e-6 * of_all.max())


@pytest.mark.parametrize("tilt", [0, 30, 60, 90, 150])
def test_a_tilted_facet_under_a_uniform_sky(tilt):
    # π L (1 + cos β) / 2. Where the facet's horizon cuts through the sky the sum is to 1e-4.
    light = omma.light.uniform_sky([1.0, 2.0, 3.0, 4.0], below=0, bands=FEW)
    sky, discs = light.irradiance(direction(40, 90 - tilt))
    expected = np.pi * (1 + np.cos(np.radians(tilt))) / 2
    np.testing.assert_allclose(sky, expected * np.arange(1, 5), rtol=1e-5 if tilt == 0 else 2e-4)
    np.testing.assert_array_equal(discs, 0)


def test_an_overcast_sky_has_the_shape_and_the_level_it_says():
    light = omma.light.overcast_sky(40, bands=FEW, albedo=0.0)
    zenith, horizon = light.radiance(direction(0, [90, 0]))[:, 0]
    np.testing.assert_allclose(horizon, zenith / 3, rtol=1e-6)
    np.testing.assert_allclose(
        light.radiance(direction(123, 30))[0], zenith * 2 / 3, rtol=1e-4
    )  # between rows of 1 degree
    level = light.irradiance()[0]
    # The closed forms 7 π / 9 L_z and, of a wall, 0.3962 of that; sums over rows of 1 degree.
    np.testing.assert_allclose(level, 7 * np.pi / 9 * zenith, rtol=1e-4)
    np.testing.assert_allclose(light.irradiance((1, 0, 0))[0], 0.3962 * level, rtol=5e-4)
    clear = sum(omma.light.clear_sky(40, bands=FEW, albedo=0.0).irradiance())
    np.testing.assert_allclose(level, 0.25 * clear, rtol=1e-4)


def test_a_disc_gives_what_it_is_said_to():
    radius = np.radians(0.25)
    disc = Disc((0, 2, 0), radius, [3.0], [0.6])
    np.testing.assert_array_equal(disc.direction, [0, 1, 0])
    rings = (np.arange(20000) + 0.5) / 20000 * radius
    seen = disc.radiance_at(direction(0, 90 - np.degrees(rings)))[:, 0]
    solid = np.sin(rings) * 2 * np.pi * radius / 20000
    # The mean is 3 and the limb 1 - u of the middle; the rings are 20,000 steps.
    assert (seen * solid).sum() / solid.sum() == pytest.approx(3, rel=1e-5)
    assert seen[-1] / seen[0] == pytest.approx(
        1 - 0.6 * (1 - np.sqrt(1 - (1 - 2.5e-5) ** 2)), abs=1e-3
    )
    assert disc.radiance_at(direction(0, 90 - 0.26))[0] == 0
    assert disc.radiance_at(np.array([0.0, -1.0, 0.0]))[0] == 0
    assert disc.irradiance()[0] == pytest.approx(3 * np.pi * radius**2, rel=1e-4)


def test_a_clear_sky_and_its_sun():
    light = omma.light.clear_sky(30, sun_azimuth_deg=135)
    (sun,) = light.discs
    np.testing.assert_allclose(sun.direction, direction(135, 30))
    assert np.degrees(sun.angular_radius_rad) * 2 == pytest.approx(0.533)
    # The mean over the disc is 0.7260 of its centre at 350 nm and 0.8002 at 542 nm (Neckel and
    # Labs, Solar Physics 153:91, 1994, table 1), so u = 0.82 and 0.60; other tables differ by 0.02.
    u = np.interp([350, 542], light.bands.centers_nm, sun.limb_darkening)
    np.testing.assert_allclose(u, [0.82, 0.60], atol=0.03)
    sky, discs = light.irradiance()
    np.testing.assert_allclose(discs, sun.irradiance() / 2)  # sin 30°
    stokes = light.radiance(direction(np.arange(0, 360, 10), 20))
    assert np.all(np.hypot(stokes[:, 1], stokes[:, 2]) <= stokes[:, 0])
    assert np.all(sky > 0)


def test_photons_and_watts_of_one_sky():
    fine = Bands.equal(100)
    photons = sum(omma.light.clear_sky(30, bands=fine).irradiance())
    watts = sum(omma.light.clear_sky(30, bands=fine, unit="watts").irradiance())
    # In bands of 4 nm the spectrum hardly changes inside of one, but for its lines.
    np.testing.assert_allclose(
        omma.light.photons_from_watts(watts, fine.centers_nm), photons, rtol=5e-3
    )


def test_moonlight_is_weak_sunlight():
    sun = omma.light.clear_sky(40, sun_azimuth_deg=10, bands=FEW)
    moon = omma.light.moonlit_sky(40, moon_azimuth_deg=10, bands=FEW)
    # As strong at 550 nm, and redder.
    share = 2.49e-6 * (FEW.centers_nm / 550) ** 0.95
    # The mean of a power over a band is that of its middle to 1e-3.
    np.testing.assert_allclose(
        moon.discs[0].irradiance(), share * sun.discs[0].irradiance(), rtol=3e-3
    )
    np.testing.assert_allclose(moon.sky, share * sun.sky, rtol=3e-3, atol=1e-30)
    # Beside another table, of a disc that is a mean of highlands and maria: 0.0988, 0.1275 and
    # 0.1531 at 443, 560 and 700 nm.
    red = [(nm / 560) ** 0.95 for nm in (443, 700)]
    np.testing.assert_allclose(red, [0.0988 / 0.1275, 0.1531 / 0.1275], rtol=0.05)
    half = omma.light.moonlit_sky(40, moon_azimuth_deg=10, phase_angle_deg=90, bands=FEW)
    # Allen: 2.60 magnitudes less at the half moon.
    less = 10 ** (-0.4 * 2.6024) * (FEW.centers_nm / 550) ** 0.35
    for part, full in zip(half.irradiance(), moon.irradiance(), strict=True):
        np.testing.assert_allclose(part, less * full, rtol=3e-3)
    with pytest.raises(omma.Error, match="phase_angle_deg: expected -150 to 150, found 170"):
        omma.light.moonlit_sky(40, phase_angle_deg=170)


@pytest.mark.parametrize("sky", [omma.light.clear_sky, omma.light.moonlit_sky])
def test_azimuths_of_suns_are_named(sky):
    """Elevation comes first here and azimuth everywhere else, so (135, 30) must not pass for it."""
    with pytest.raises(TypeError, match=f"{sky.__name__}: expected at most 1 .*_azimuth_deg"):
        sky(30, 60)


def test_turning_goes_to_the_right():
    picture = np.random.default_rng(1).random((18, 36, 4)) + 1
    light = omma.light.panorama_bands(picture, bands=FEW)
    at, there = direction([0, 40, 100], [25, -40, 70]), direction([90, 130, 190], [25, -40, 70])
    # By whole columns of 10 degrees: the same numbers.
    np.testing.assert_allclose(light.turned(90).radiance(there), light.radiance(at), rtol=1e-6)


def test_one_polarisation_about_the_zenith_is_as_strong_between_columns():
    # Electric vectors from north to south: in column 0 along its reference axis; a column at an
    # azimuth a has an axis that has turned by a.
    azimuth = np.radians(np.arange(8) * 45)
    sky = np.zeros((2, 3, 8, 3, 1))
    sky[:, :, :, 0] = 1
    sky[0, 2, :, 1, 0], sky[0, 2, :, 2, 0] = np.cos(2 * azimuth), np.sin(2 * azimuth)
    light = Light(Bands.equal(1), sky=sky)
    for at in (0.0, 20.0, 100.0, 250.0):
        _, q, u = light.radiance(direction(at, 89.9999))[:, 0]
        np.testing.assert_allclose(
            [q, u], [np.cos(2 * np.radians(at)), np.sin(2 * np.radians(at))], atol=1e-5
        )


def test_a_turned_sky_is_that_of_a_sun_elsewhere():
    turned = omma.light.clear_sky(30, sun_azimuth_deg=0, bands=FEW).turned(90)
    made = omma.light.clear_sky(30, sun_azimuth_deg=90, bands=FEW)
    np.testing.assert_allclose(turned.discs[0].direction, direction(90, 30), atol=1e-12)
    at = direction(np.arange(0, 360, 30), 45)
    # Within what interpolation between columns makes of it.
    intensity = made.radiance(at)[:, :1]
    np.testing.assert_allclose(
        turned.radiance(at) / intensity, made.radiance(at) / intensity, atol=0.01
    )


def test_scaling():
    light = omma.light.clear_sky(30, bands=FEW).scaled(3)
    one = omma.light.clear_sky(30, bands=FEW)
    for found, expected in zip(light.irradiance(), one.irradiance(), strict=True):
        np.testing.assert_allclose(found, 3 * expected, rtol=1e-6)
    with pytest.raises(omma.Error, match="factor: expected 0, or 1e-30 to 1e30, found -1"):
        one.scaled(-1)


def test_pickles_hold_how_it_was_made():
    light = omma.light.clear_sky(30, sun_azimuth_deg=135, bands=FEW).turned(10).scaled(0.5)
    text = pickle.dumps(light)
    assert len(text) < 20_000
    assert pickle.loads(text) == light
    assert copy.deepcopy(light) == light
    assert light != omma.light.clear_sky(30, sun_azimuth_deg=135, bands=FEW)
    of_numbers = omma.light.panorama_bands(np.ones((4, 8, 4)), bands=FEW)
    assert pickle.loads(pickle.dumps(of_numbers)) == of_numbers


def test_other_bands():
    light = omma.light.clear_sky(30, sun_azimuth_deg=135).turned(10)
    other = light.in_bands(FEW)
    assert other.bands == FEW
    assert other == omma.light.clear_sky(30, sun_azimuth_deg=135, bands=FEW).turned(10)
    with pytest.raises(omma.Error, match="light: expected one with a recipe"):
        omma.light.panorama_bands(np.ones((4, 8, 4)), bands=FEW).in_bands(Bands.equal())


def test_a_panorama_in_rgb():
    picture = np.zeros((8, 16, 3), np.float32)
    picture[:4, 8:, 0] = 1  # red at the upper right
    picture[:4, :8] = 1  # white at the upper left
    picture[4:] = (0, 0, 1)  # blue below
    bands = Bands.from_edges([400, 500, 600, 700])
    light = omma.light.panorama(picture, bands=bands, radiance_per_unit=5.0)
    red, white, blue = light.radiance(direction([90, -90, 20], [30, 30, -40]))[:, 0]
    np.testing.assert_allclose(white, 5, rtol=1e-6)
    spectra = omma.light.band_from_rgb([400, 500, 600, 700])
    np.testing.assert_allclose(red, 5 * spectra[:, 0], rtol=1e-4)
    np.testing.assert_allclose(blue, 5 * spectra[:, 2], rtol=1e-4)
    # Half of the sky is white; irradiance of one half is that of a uniform sky by half.
    sky, _ = light.irradiance()
    np.testing.assert_allclose(sky, 5 * np.pi / 2 * (1 + spectra[:, 0]), rtol=0.01)


def test_ultraviolet_of_a_picture_is_what_the_caller_says():
    picture = np.ones((4, 8, 3), np.float32)
    with pytest.raises(omma.Error, match=r"ultraviolet: bands reach down to 300 nm"):
        omma.light.panorama(picture)
    up = direction(0, 60)
    for said, share in (("dark", 0.0), ("as_blue", 1.0), (0.3, 0.3)):
        found = omma.light.panorama(picture, ultraviolet=said, bands=FEW).radiance(up)[0]
        np.testing.assert_allclose(found, [share, 1, 1, 1], rtol=1e-6)
    for wrong in ("blue", -1.0, float("nan")):
        with pytest.raises(omma.Error, match="ultraviolet"):
            omma.light.panorama(picture, ultraviolet=wrong)


def test_a_panorama_in_watts_has_the_photons_of_that_in_photons():
    picture = np.full((4, 8, 3), 0.5, np.float32)
    bands = Bands.equal(12, 400, 700)
    watts = omma.light.panorama(picture, bands=bands, unit="watts").radiance((0, 1, 0))[0]
    photons = omma.light.photons_from_watts(watts, bands.centers_nm)
    # White: equal photons, in bands of 25 nm to (25/λ)²/12.
    np.testing.assert_allclose(photons, omma.light.photons_from_watts(0.5, 550), rtol=5e-4)


def test_a_panorama_of_a_file(tmp_path):
    from omma import save_png

    codes = np.zeros((6, 12, 3), np.uint8)
    codes[..., 1] = 188  # sRGB: 0.503 linear
    save_png(tmp_path / "sky.png", codes)
    light = omma.light.panorama(tmp_path / "sky.png", bands=Bands.from_edges([520, 560]))
    green = omma.light.band_from_rgb([520, 560])[0, 1]
    np.testing.assert_allclose(light.radiance((0, 0, -1))[0], 0.5029 * green, rtol=1e-3)


def test_a_picture_keeps_its_place():
    picture = np.zeros((90, 180, 1))
    picture[20, 130] = 1.0  # elevation 90 - 41 = 49°, azimuth 261 - 180 = 81°
    light = omma.light.panorama_bands(picture, bands=Bands.equal(1))
    azimuth, elevation = np.meshgrid(np.arange(0, 360, 0.5), np.arange(-89.5, 90, 0.5))
    seen = light.radiance(direction(azimuth, elevation))[:, :, 0, 0]
    weight = seen * np.cos(np.radians(elevation))
    assert (weight * azimuth).sum() / weight.sum() == pytest.approx(81, abs=0.1)
    assert (weight * elevation).sum() / weight.sum() == pytest.approx(49, abs=0.1)
    # Its light is all there: a pixel of 2° by 2° at 49°.
    solid = np.radians(0.5) ** 2
    assert weight.sum() * solid == pytest.approx(
        np.radians(2) ** 2 * np.cos(np.radians(49)), rel=0.01
    )


def test_polarised_bands_of_a_panorama():
    picture = np.zeros((4, 8, 3, 2))
    picture[:, :, 0], picture[:, :, 1], picture[:, :, 2] = 1.0, 0.3, -0.4
    light = omma.light.panorama_bands(picture, bands=Bands.equal(2))
    np.testing.assert_allclose(light.radiance(direction(45, 21))[:, 0], [1, 0.3, -0.4], rtol=1e-6)
    with pytest.raises(omma.Error, match="sky: expected a polarised radiance"):
        omma.light.panorama_bands(picture * [[1], [3], [3]], bands=Bands.equal(2))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: omma.light.uniform_sky(-1), "radiance: expected finite numbers of at least 0"),
        (lambda: omma.light.uniform_sky(np.inf), "radiance"),
        (lambda: omma.light.uniform_sky([1.0, 2.0]), "radiance: expected one number or 16"),
        (lambda: omma.light.uniform_sky(1, unit="lux"), "unit: expected one of photons, watts"),
        (lambda: omma.light.uniform_sky(1, below=-1), "below"),
        (lambda: omma.light.overcast_sky(30, cloud_transmittance=2), "cloud_transmittance"),
        (lambda: omma.light.clear_sky(30, sun_azimuth_deg=np.nan), "sun_azimuth_deg"),
        (lambda: omma.light.clear_sky(-9), "sun_elevation_deg: expected -8 to 90, found -9"),
        (lambda: omma.light.clear_sky(30, aerosol=2), "aerosol: expected 0 to 0.3"),
        (lambda: omma.light.clear_sky(30, ozone_du=50), "ozone_du: expected 200 to 450"),
        (lambda: omma.light.clear_sky(30, albedo=1.1), "albedo: expected 0 to 1"),
        (lambda: omma.light.clear_sky(30, bands=Bands.equal(4, 250, 700)), "bands: expected some"),
        (lambda: omma.light.moonlit_sky(99), "moon_elevation_deg: expected -8 to 90"),
        (lambda: omma.light.panorama(np.full((2, 4, 3), -1.0)), "ultraviolet"),
        (lambda: omma.light.panorama(np.full((2, 4, 3), -1.0), ultraviolet="dark"), "image"),
        (lambda: omma.light.panorama("nowhere.hdr", ultraviolet="dark"), "nowhere.hdr"),
        (lambda: omma.light.panorama_bands(np.ones((2, 4, 3))), "radiance: expected 16 bands"),
        (lambda: omma.light.panorama_bands(np.ones(3)), "radiance: expected shape"),
        (lambda: Disc((0, 0, 0), 0.01, [1.0]), "direction: expected three numbers, not all 0"),
        (lambda: Disc((0, 1, 0), 0.2, [1.0]), "angular_radius_rad"),
        (lambda: Disc((0, 1, 0), 0.01, [-1.0]), "radiance"),
        (lambda: Disc((0, 1, 0), 0.01, [1.0], [1.5]), "limb_darkening"),
        (lambda: Light(FEW, discs=(Disc((0, 1, 0), 0.01, [1.0]),)), r"discs\[0\]: expected"),
        (lambda: Light(FEW, sky=np.ones((2, 2, 4, 1, 3))), "sky: expected 2 halves"),
        (lambda: Light(FEW, sky=np.ones((2, 2, 4, 2, 4))), "sky: expected 2 halves"),
        (lambda: Light(FEW, sky=np.full((2, 2, 4, 1, 4), np.nan)), "sky: expected finite"),
        (lambda: Light(FEW, band_from_channel=np.ones((4, 3))), "band_from_channel: goes with"),
        (lambda: omma.light.uniform_sky().radiance((0, 0, 0)), "direction: expected vectors"),
        (lambda: omma.light.uniform_sky().irradiance((0, 0, 0)), "normal: expected vectors"),
        (lambda: omma.light.uniform_sky().turned(np.inf), "azimuth_deg"),
    ],
)
def test_nonsense_is_named(call, message):
    with pytest.raises(omma.Error, match=message):
        call()


def test_what_the_engine_is_given():
    light = omma.light.clear_sky(30, sun_azimuth_deg=135, bands=FEW)
    given = light._for_engine()
    assert given["unit"] == "photons"
    assert given["sky"].dtype == np.float32
    assert given["sky"].flags.c_contiguous
    assert given["sky"].shape[0] == 2
    assert given["sky"].shape[3:] == (3, 4)
    assert given["weight"].shape == (4, len(given["wavelength_nm"]))
    ((towards, radius, radiance, limb),) = given["discs"]
    assert towards.shape == (3,)
    assert radius == light.discs[0].angular_radius_rad
    assert radiance.shape == limb.shape == (4,)


class TestSunPosition:
    pytest.importorskip("ephem")

    def test_a_published_example(self):
        # Reda and Andreas 2004 (NREL/TP-560-34302), table A5.1: geometric elevation 39.872046°,
        # azimuth 194.34024°, on 17 October 2003, 12:30:30 at UTC-7; theirs is within 0.0003°.
        noon = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
        sun = omma.light.sun_position(noon, 39.742476, -105.1786)
        assert sun.elevation_deg == pytest.approx(39.872046, abs=0.001)
        assert sun.azimuth_deg == pytest.approx(194.34024, abs=0.001)
        with pytest.warns(FutureWarning, match=r"gives \(azimuth, elevation\), which was"):
            assert tuple(sun) == (sun.azimuth_deg, sun.elevation_deg)
        with pytest.raises(TypeError):
            sun[0]

    def test_the_sky_there_and_then(self):
        noon = datetime(2026, 6, 21, 12, tzinfo=timezone.utc)
        light = omma.light.clear_sky_at(noon, 52.5, 13.4, bands=FEW)
        sun = omma.light.sun_position(noon, 52.5, 13.4)
        azimuth, elevation = sun.azimuth_deg, sun.elevation_deg
        np.testing.assert_allclose(light.discs[0].direction, direction(azimuth, elevation))
        # The highest sun of the year in Berlin is 90 - 52.5 + 23.44 degrees, near 11 h UTC.
        assert 50 < elevation < 61
        assert 180 < azimuth < 230

    def test_times_and_places_out_of_range(self):
        noon = datetime(2026, 6, 21, 12, tzinfo=timezone.utc)
        with pytest.raises(omma.Error, match="date_time: expected a time with its time zone"):
            omma.light.clear_sky_at(datetime(2026, 6, 21, 12), 0, 0)
        with pytest.raises(omma.Error, match="date_time: expected a year from 1901 to 2099, foun"):
            omma.light.sun_position(noon.replace(year=2200), 0, 0)
        with pytest.raises(omma.Error, match="latitude_deg: expected -90 to 90, found 91"):
            omma.light.sun_position(noon, 91, 0)
        with pytest.raises(omma.Error, match="longitude_deg: expected -180 to 180, found nan"):
            omma.light.sun_position(noon, 0, float("nan"))
        with pytest.raises(TypeError, match=r"date_time: expected a datetime\.datetime"):
            omma.light.sun_position("noon", 0, 0)
