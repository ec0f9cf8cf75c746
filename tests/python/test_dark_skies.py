"""The Milky Way, zodiacal light and airglow by time and place, beside published numbers."""

import pickle
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest

import omma
from omma.base.directions import direction
from omma.light import dark_skies, night_sky, night_sky_at, star_maps

ephem = pytest.importorskip("ephem")
FEW, GREEN = omma.light.Bands.equal(4), omma.light.Bands.from_edges([545, 555])
WINTER = datetime(2026, 7, 15, 20, tzinfo=timezone.utc)  # of the south
SIDEREAL_DAY = timedelta(seconds=86164.09)


def on_sphere(longitude_deg, latitude_deg):
    a, b = np.radians(longitude_deg), np.radians(latitude_deg)
    return np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b) + 0 * a], axis=-1)


def everywhere(count=200_000):
    """Directions that share the sphere evenly, on a spiral by the golden angle."""
    up = 1 - (2 * np.arange(count) + 1) / count
    around = np.degrees(np.arange(count) * np.pi * (3 - 5**0.5))
    return on_sphere(around, np.degrees(np.arcsin(up)))


def faint_s10(galactic):
    """Pioneer's map alone."""
    nodes = star_maps._table("faint_stars.csv")[:, 1:]
    return sum(share * nodes[row, column] for share, row, column in star_maps.node_shares(galactic))


class TestFrames:
    def test_galactic_directions(self):
        """The matrix of the Hipparcos Catalogue (ESA 1997, volume 1, equation 1.5.11), and Sgr A*,
        at 266.4168, -29.0078 degrees, which is at 359.944, -0.046 (Reid and Brunthaler 2004)."""
        published = [
            [-0.0548755604, -0.8734370902, -0.4838350155],
            [0.4941094279, -0.4448296300, 0.7469822445],
            [-0.8676661490, -0.1980763734, 0.4559837762],
        ]
        np.testing.assert_allclose(star_maps.GALACTIC_FROM_EQUATORIAL, published, atol=1e-8)
        found = star_maps.GALACTIC_FROM_EQUATORIAL @ on_sphere(266.4168, -29.0078)
        np.testing.assert_allclose(found, on_sphere(359.944, -0.046), atol=2e-5)

    def test_ecliptic_directions(self):
        """The equinox stays; the sun's longitude is 90 degrees at the solstice of June 2026, 21
        June 8:24 UTC (almanacs), less 26.5 years' precession of 50.29 seconds a year."""
        np.testing.assert_allclose(
            star_maps.ECLIPTIC_FROM_EQUATORIAL @ [1, 0, 0], [1, 0, 0], atol=1e-12
        )
        eps = np.radians(23.4392911)
        np.testing.assert_allclose(
            star_maps.ECLIPTIC_FROM_EQUATORIAL @ [0, np.cos(eps), np.sin(eps)], [0, 1, 0], atol=1e-9
        )
        solstice = datetime(2026, 6, 21, 8, 24, tzinfo=timezone.utc)
        found = np.degrees(star_maps.sun_longitude_rad(solstice))
        assert found == pytest.approx(90 - 26.47 * 50.29 / 3600, abs=0.01)

    @pytest.mark.parametrize("place", [(-24.0, 28.0), (52.5, 13.4)])
    def test_the_horizon(self, place):
        """Beside sidereal time (Meeus, Astronomical Algorithms, equation 12.4) and precession
        (21.2); aberration and nutation, which are left out here, are 0.008 degrees at most."""
        days = (WINTER - datetime(2000, 1, 1, 12, tzinfo=timezone.utc)) / timedelta(days=1)
        t = days / 36525
        sidereal = 280.46061837 + 360.98564736629 * days + place[1]
        zeta, theta = 2306.2181 * t / 3600, np.radians(2004.3109 * t / 3600)

        def of_2000(ascension_deg, declination_deg):
            a, d = np.radians([ascension_deg - zeta, declination_deg])
            c, s = np.cos(theta), np.sin(theta)
            x, y = c * np.cos(d) * np.cos(a) + s * np.sin(d), np.cos(d) * np.sin(a)
            up = -s * np.cos(d) * np.cos(a) + c * np.sin(d)
            return on_sphere(np.degrees(np.arctan2(y, x)) - zeta, np.degrees(np.arcsin(up)))

        zenith, east = of_2000(sidereal, place[0]), of_2000(sidereal + 90, 0.0)
        expected = np.stack([east, zenith, np.cross(east, zenith)], axis=1)
        found = star_maps.equatorial_from_horizon(WINTER, *place)
        # The columns are +X (east), +Y (up) and +Z (south).
        np.testing.assert_allclose(found, expected, atol=np.radians(0.02))
        np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)


class TestStarlight:
    @pytest.mark.parametrize(
        ("equatorial", "published"),
        [((192.86, 27.13), 29), ((12.86, -27.13), 33), ((0, 90), 56), ((0, -90), 74),
         ((270, 66.56), 66)],
    )  # fmt: skip
    def test_pioneers_map_at_the_poles(self, equatorial, published):
        """Leinert et al. 1998, table 34: galactic, celestial and ecliptic ones, but for that in the
        Magellanic Cloud; read off finer maps than the nodes here."""
        towards = star_maps.GALACTIC_FROM_EQUATORIAL @ on_sphere(*map(float, equatorial))
        assert faint_s10(towards) == pytest.approx(published, rel=0.25)

    def test_the_band(self):
        """Elsasser and Haug's isophotes (as in Leinert et al. 1998, section 10): 260 S10 towards
        the galaxy's middle, 100 at a longitude of 120, 50 at latitudes of 30 degrees, 20 at
        80. They are of faint stars without the dust that they light and without the brighter ones,
        so that this only tells the band from what is beside it; the Milky Way's width at half its
        height is some 25 degrees."""
        for (longitude, latitude), published in (
            ((0, 0), 260), ((120, 0), 100), ((120, 30), 50), ((60, 80), 20),
        ):  # fmt: skip
            around = on_sphere(longitude + np.linspace(-20, 20, 9), float(latitude))
            assert 0.9 < star_maps.starlight_s10(around).mean() / published < 2.3
        latitude = np.arange(-60, 61.0)
        around = np.arange(0, 360, 5.0)[:, None]
        profile = star_maps.starlight_s10(on_sphere(around, latitude)).mean(axis=0)
        above = latitude[profile > (profile.max() + profile[0]) / 2]
        assert 20 < above[-1] - above[0] < 35
        assert abs(latitude[np.argmax(profile)]) < 6

    def test_nothing_is_lost_and_nothing_counted_twice(self):
        """The sum over nodes is that over directions. With the discs of `stars`, 6.6 S10 of 108
        stars, all starlight is 148 S10 in the mean of all directions in the visual: 104 of Gaia's
        stars and 44 of what Pioneer saw besides."""
        nodes = star_maps._star_nodes()[1]
        angles = star_maps.node_solid_angles()
        assert angles.sum() == pytest.approx(4 * np.pi, rel=1e-9)
        mean = float((nodes * angles).sum() / (4 * np.pi))
        # Straight between nodes that are 4 degrees apart: the spiral's are 0.5 degrees apart.
        assert star_maps.starlight_s10(everywhere()).mean() == pytest.approx(mean, rel=1e-3)
        from ephem.stars import stars as named

        names = {ephem.star(name)._ra: name for name in named}
        shown = 0.0
        for name in names.values():
            star = ephem.star(name)
            star.compute("2000")
            shown += 10 ** (-0.4 * (star.mag - 10)) / (4 * np.pi * (180 / np.pi) ** 2)
        assert shown == pytest.approx(6.6, abs=0.1)
        visual = mean * (550 / 437) ** dark_skies._STAR_POWER + shown
        assert visual == pytest.approx(148, rel=0.05)

    def test_stars_between_are_those_of_the_catalogue(self):
        """Hipparcos has 9068 stars to a magnitude of 6.5; without 108 they are 20.86 S10."""
        table = star_maps._table("middling_stars.csv")
        mean = (table[:, 1:] * star_maps.node_solid_angles()).sum() / (4 * np.pi)
        assert mean == pytest.approx(20.86, abs=0.02)
        # Orion's belt and the Pleiades are brighter than what lies opposite to them.
        at = {(b, k): x for b, *row in table for k, x in enumerate(row)}
        assert at[-16, 20] > 2 * at[16, 2]


class TestZodiacalLight:
    def test_its_table(self):
        towards = on_sphere([90.0, 0.0, 270.0, 130.0, 10.0], [0.0, 30.0, -60.0, 90.0, -75.0])
        found = star_maps.zodiacal_s10(towards, np.radians(0.0))
        np.testing.assert_allclose(found, [202, 500, 67, 60, 78], rtol=1e-9)
        turned = star_maps.zodiacal_s10(on_sphere([130.0], [0.0]), np.radians(220.0))
        np.testing.assert_allclose(turned, [202], rtol=1e-9)
        assert 202 < star_maps.zodiacal_s10(on_sphere(80.0, 0.0), 0.0) < 264

    def test_its_radiance(self):
        """1 S10 is 1.28e-8 W m^-2 sr^-1 um^-1 at 500 nm (Leinert et al. 1998, table 2)."""
        bands = omma.light.Bands.from_edges([490, 510])
        photons = bands.mean(lambda nm: dark_skies._spectra(bands, nm)[0])
        watts = omma.light.watts_from_photons(photons, [500.0])
        np.testing.assert_allclose(watts, 1.28e-11, rtol=0.02)


class TestNight:
    def test_airglow(self):
        """2.5 times the zodiacal light of the poles, 145 S10 in the visual (Benn and Ellison 1998):
        what is left of their dark sky is within 15 %; theirs is at 2,300 m, with less air."""
        left = GREEN.mean(lambda nm: dark_skies._airglow_photons(GREEN, nm))
        unit = GREEN.mean(lambda nm: dark_skies._spectra(GREEN, nm)[0])
        assert float(left[0] / unit[0]) == pytest.approx(145, rel=0.15)
        bands = omma.light.Bands.equal(40)
        assert np.all(bands.mean(lambda nm: dark_skies._airglow_photons(bands, nm)) >= 0)

    def test_far_from_milky_way_and_zodiac_it_is_the_dark_sky(self):
        """As `night_sky`, and the light of stars down to 6.5 magnitudes and beyond, which was
        measured between: 30 to 60 S10 of 213 more."""
        moment = datetime(2026, 4, 15, 22, tzinfo=timezone.utc)
        zenith = night_sky_at(moment, 45, 0, bands=GREEN).radiance((0, 1, 0))[0, 0]
        dark = night_sky(bands=GREEN).radiance((0, 1, 0))[0, 0]
        assert 1.05 < zenith / dark < 1.35

    def test_near_the_ecliptic_it_is_brighter(self):
        """By 0.4 magnitudes (Benn and Ellison 1998): zeniths 30 degrees from where the sun is
        not, in the ecliptic and 50 degrees from it, both far from the Milky Way."""
        moment = datetime(2026, 3, 20, 22, tzinfo=timezone.utc)
        low, high = (
            night_sky_at(moment, latitude, 0, bands=GREEN).radiance((0, 1, 0))[0, 0]
            for latitude in (11.7, 65.0)
        )
        assert 2.5 * np.log10(low / high) == pytest.approx(0.4, abs=0.15)

    def test_luminances(self):
        """A dark zenith has some 2.5e-4 cd/m2, 21.6 magnitudes per square second of arc, the Milky
        Way's middle up to thrice that; level ground gets some 1e-3 lux (Seidelmann 1992: 6.5e-4
        without stars and at a dark time; here by V of the CIE 1924 at middles of bands)."""
        bands = omma.light.Bands.equal(12, 400, 700)
        v = np.interp(bands.centers_nm, [400, 450, 500, 520, 555, 580, 610, 650, 700],
                      [0.0004, 0.038, 0.323, 0.71, 1.0, 0.87, 0.503, 0.107, 0.0041])  # fmt: skip
        lumens = 683 * v * bands.widths_nm / omma.light.photons_from_watts(1.0, bands.centers_nm)
        light = night_sky_at(WINTER, -24, 28, bands=bands)
        map_of = light.sky[0, 30:, :, 0] @ lumens
        assert 2.0e-4 < map_of.min() < 3.5e-4
        assert 2 < map_of.max() / map_of.min() < 4
        assert 6.5e-4 < light.irradiance()[0] @ lumens < 1.6e-3

    def test_the_sky_turns(self):
        """At the pole a quarter of a sidereal day turns the stars by 90 degrees to the right; all
        else but the zodiacal light, which moves by a quarter of a degree, is even about it."""
        dark = datetime(2026, 12, 15, tzinfo=timezone.utc)
        now = night_sky_at(dark, 90, 0, bands=GREEN, airglow=0)
        later = night_sky_at(dark + SIDEREAL_DAY / 4, 90, 0, bands=GREEN, airglow=0)
        expected = now.turned(90).sky
        np.testing.assert_allclose(later.sky, expected, rtol=0.02)
        assert np.abs(later.sky / now.sky - 1).max() > 0.3
        # Longitude and time are alike.
        east = night_sky_at(WINTER, 0, 90, bands=GREEN)
        waited = night_sky_at(WINTER + SIDEREAL_DAY / 4, 0, 0, bands=GREEN)
        np.testing.assert_allclose(east.sky, waited.sky, rtol=0.02)

    def test_the_milky_way_is_where_a_star_in_it_is(self):
        """Sgr's starry clouds, 4 degrees below the galaxy's middle: PyEphem's own azimuth and
        elevation of 271.5, -29.9 degrees (longitude 1, latitude -3.9)."""
        observer = ephem.Observer()
        observer.lat, observer.lon, observer.pressure = "-24", "28", 0
        observer.date = WINTER.replace(tzinfo=None)
        cloud = ephem.FixedBody()
        cloud._ra, cloud._dec = np.radians([271.5, -29.9])
        cloud.compute(observer)
        bright = direction(*np.degrees([float(cloud.az), float(cloud.alt)]))
        sky = night_sky_at(WINTER, -24, 28, bands=GREEN)
        elevation, azimuth = np.meshgrid(np.arange(20, 91.0), np.arange(0, 360, 2.0), indexing="ij")
        towards = direction(azimuth, elevation)
        seen = sky.radiance(towards)[..., 0, 0]
        brightest = towards[np.unravel_index(np.argmax(seen), seen.shape)]
        assert np.degrees(np.arccos(brightest @ bright)) < 4

    @pytest.mark.parametrize("depth", [0.05, 0.2, 0.4])
    def test_light_that_air_scatters(self, depth):
        """Under an even sky air that absorbs nothing lets 1 / (1 + 3/4 t) through (Eddington's
        approximation, which is within some percent of it)."""
        from omma.light.star_light import air_mass

        above = np.linspace(0, 90, 91)
        t = np.array([[depth]])
        even = np.ones((1, 91))
        sky = np.exp(-t * air_mass(above)) + dark_skies._scattered(even, above, t, t)
        up = np.radians(above)
        level = np.trapezoid(2 * np.sin(up) * np.cos(up) * sky[0], up)
        assert level == pytest.approx(1 / (1 + 0.75 * depth), abs=0.02)
        assert level < 1

    def test_ground_units_bands_and_pickles(self):
        light = night_sky_at(WINTER, -24, 28, bands=FEW, albedo=0.3)
        ground = light.radiance((0, -1, 0))[0]
        np.testing.assert_allclose(ground, 0.3 / np.pi * light.irradiance()[0], rtol=1e-3)
        assert pickle.loads(pickle.dumps(light)) == light
        assert light.in_bands(GREEN) == night_sky_at(WINTER, -24, 28, bands=GREEN, albedo=0.3)
        watts = night_sky_at(WINTER, -24, 28, bands=GREEN, unit="watts")
        photons = night_sky_at(WINTER, -24, 28, bands=GREEN)
        again = omma.light.photons_from_watts(watts.irradiance()[0], [550.0])
        np.testing.assert_allclose(again, photons.irradiance()[0], rtol=1e-3)
        more = night_sky_at(WINTER, -24, 28, bands=GREEN, airglow=1.7)
        assert np.all(more.sky > photons.sky)

    def test_natural_sky_has_it_at_night(self):
        moment = datetime(2026, 7, 14, 20, tzinfo=timezone.utc)  # a new moon
        light = omma.light.natural_sky_at(moment, -24, 28, bands=FEW)
        assert light.sky.tobytes() == night_sky_at(moment, -24, 28, bands=FEW).sky.tobytes()

    def test_refused(self):
        with pytest.raises(omma.Error, match="airglow: expected 0 to 10, found -1"):
            night_sky_at(WINTER, 0, 0, airglow=-1)
        with pytest.raises(omma.Error, match="latitude_deg: expected -90 to 90, found 91"):
            night_sky_at(WINTER, 91, 0)
        with pytest.raises(omma.Error, match="date_time: expected a time with its time zone"):
            night_sky_at(datetime(2026, 7, 15), 0, 0)
        with pytest.raises(omma.Error, match="bands: expected some within 300 to 700 nm"):
            night_sky_at(WINTER, 0, 0, bands=omma.light.Bands.equal(4, 250, 700))
