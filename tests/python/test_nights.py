"""Night, moon and the twilight between day and night, beside published numbers."""

import pickle
from datetime import datetime, timezone

import numpy as np
import pytest

import omma
from omma.base.directions import azimuth_elevation_deg_of, direction
from omma.light import clear_sky, natural_sky, night_sky
from omma.light.nights import twilight_share
from omma.light.sky_tables import TableSky
from omma.light.star_light import RADIUS_RAD, air_mass, black_body_colour, temperature_k

FEW, TWO = omma.light.Bands.equal(4), omma.light.Bands.from_edges([440, 460, 540, 560])


def magnitude(radiance, jansky, nm):
    """Per square second of arc, of photons m^-2 s^-1 sr^-1 nm^-1; 1 Jy is 1.51e7 photons m^-2 s^-1
    for each interval of 1 of the wavelength's logarithm (Huchra's table of magnitudes)."""
    flux = radiance / ((180 * 3600 / np.pi) ** 2) * nm / 1.51e7
    return -2.5 * np.log10(flux / jansky)


def test_the_zenith_of_a_night_without_moon():
    """Within the published spread of dark sites: V 21.9 at sunspot minimum on La Palma, 21.6 at
    maximum on Paranal (Benn and Ellison 1998, Patat 2003); B 22.7 and 22.6, R 21.0 and 20.9."""
    for nm, jansky, dark, bright in (
        (440, 4260, 22.7, 22.6),
        (550, 3640, 21.9, 21.6),
        (640, 3080, 21.0, 20.9),
    ):
        bands = omma.light.Bands.from_edges([nm - 5.0, nm + 5.0])
        zenith = night_sky(bands=bands).radiance((0, 1, 0))[0, 0]
        assert magnitude(zenith, jansky, nm) == pytest.approx(dark, abs=0.03)
        assert magnitude(1.4 * zenith, jansky, nm) == pytest.approx(bright, abs=0.36)


def test_lower_down_the_night_is_brighter():
    """At an air mass of 1.5 by 0.25 magnitudes (Benn and Ellison 1998); the model has a layer's 0.4
    less the air's, of which haze and what the air scatters into the line are not their site's."""
    light = night_sky(bands=omma.light.Bands.from_edges([540, 560]))
    high, low = light.radiance(direction([0, 0], [90, np.degrees(np.arcsin(1 / 1.5))]))[:, 0, 0]
    assert 2.5 * np.log10(low / high) == pytest.approx(0.25, abs=0.1)
    assert night_sky(bands=FEW).irradiance()[1].max() == 0
    # The ground is lit by all of it.
    found = night_sky(bands=FEW, albedo=0.3)
    ground = found.radiance((0, -1, 0))[0]
    np.testing.assert_allclose(ground, 0.3 / np.pi * found.irradiance()[0], rtol=1e-4)
    watts = night_sky(bands=omma.light.Bands.equal(80), unit="watts")
    photons = night_sky(bands=omma.light.Bands.equal(80))
    again = omma.light.photons_from_watts(watts.irradiance()[0], watts.bands.centers_nm)
    # In bands of 5 nm, of which the first is steep.
    np.testing.assert_allclose(again[4:], photons.irradiance()[0][4:], rtol=1e-3)


def test_from_day_to_night_without_a_step():
    """From 6 degrees above the horizon to 18 below: two degrees take at most 1.03 of a decade,
    which is the steepest that twilight is, and differ by less than 0.3 from the two before (those
    of the almanac's illuminances differ by up to 0.27)."""
    level = np.array(
        [sum(natural_sky(float(sun), bands=TWO).irradiance()) for sun in range(6, -19, -2)]
    )
    steps = np.diff(np.log10(level), axis=0)
    assert np.all(steps <= 0)
    assert steps.min() > -1.03
    assert np.abs(np.diff(steps, axis=0)).max() < 0.3
    # Where the tables end there is none at all.
    above, below = (sum(natural_sky(-8 + d, bands=TWO).irradiance()) for d in (1e-6, -1e-6))
    np.testing.assert_allclose(above, below, rtol=1e-5)
    night = night_sky(bands=TWO)
    assert natural_sky(-18, bands=TWO).sky.tobytes() == night.sky.tobytes()
    assert natural_sky(-60, bands=TWO).sky.tobytes() == night.sky.tobytes()
    fine = np.array([twilight_share(sun) for sun in np.arange(-8, -18.01, -0.01)])
    assert np.all(np.diff(fine) <= 0)
    # Twice as fast as the 0.24 of a decade for half a degree at -8 degrees.
    assert np.abs(np.diff(fine)).max() < 0.02


def test_twilight_as_the_almanac_has_it():
    """The Explanatory Supplement's illuminances, lux: 3.4 at -6, 0.0081 at -12 and 0.00065 at -18
    degrees. From -8 on twilight falls as they do; above, the tables are by themselves: within a
    third of it at -6 degrees."""
    assert twilight_share(-8) == 1
    assert twilight_share(-12) == pytest.approx((0.0081 - 0.00065) / (0.348 - 0.00065), rel=0.01)
    assert twilight_share(-18) == 0
    # V(λ) by its values at the middles of 16 bands (CIE 1924), photons of each in joules.
    light = natural_sky(-6)
    v = np.interp(light.bands.centers_nm, [400, 450, 500, 520, 555, 580, 610, 650, 700],
                  [0.0004, 0.038, 0.323, 0.71, 1.0, 0.87, 0.503, 0.107, 0.0041])  # fmt: skip
    watts = omma.light.watts_from_photons(sum(light.irradiance()), light.bands.centers_nm)
    lux = 683 * (v * watts * light.bands.widths_nm)[4:].sum()
    assert lux == pytest.approx(3.4, rel=0.33)


def test_by_day_the_night_is_nothing():
    day = clear_sky(20, bands=FEW)
    np.testing.assert_allclose(natural_sky(20, bands=FEW).sky, day.sky, rtol=1e-6, atol=1e-30)
    light = natural_sky(-10, sun_azimuth_deg=90, bands=FEW)
    assert pickle.loads(pickle.dumps(light)) == light
    with pytest.raises(omma.Error, match="sun_elevation_deg: expected -90 to 90, found -91"):
        natural_sky(-91)
    with pytest.raises(omma.Error, match="bands: expected some within 300 to 700 nm"):
        night_sky(bands=omma.light.Bands.equal(4, 250, 700))


def nearest(light, azimuth_deg, elevation_deg):
    """The disc that stands nearest to a place, and how far off it is, degrees."""
    towards = direction(azimuth_deg, elevation_deg)
    disc = max(light.discs, key=lambda one: float(one.direction @ towards))
    off = np.linalg.norm(np.cross(disc.direction, towards))
    return disc, float(np.degrees(np.arcsin(off)))


class TestStars:
    pytest.importorskip("ephem")
    # Jupiter stands above Berlin too.
    WINTER = datetime(2026, 1, 15, 22, tzinfo=timezone.utc)
    GREEN = omma.light.Bands.from_edges([549, 551])

    def test_where_they_stand(self):
        starry = omma.light.stars(self.WINTER, 52.5, 13.4, bands=self.GREEN)
        assert all(one.direction[1] > 0 for one in starry.discs)
        # Sirius, of -1.44 magnitudes, is at a declination of -16.72 degrees (2000), and 20.8 high
        # in Berlin's south; Polaris, of 1.97, is within 0.75 degrees of the pole.
        azimuth, elevation = azimuth_elevation_deg_of(starry.discs[1].direction)
        assert elevation == pytest.approx(90 - 52.5 - 16.72, abs=0.2)
        assert abs(azimuth) > 170
        assert nearest(starry, 0, 52.5)[1] < 0.75

    def test_how_bright_they_are(self):
        """Sirius: 3640 Jy times 10^(0.4 1.44), through the air that dims a sun as high."""
        sirius = omma.light.stars(self.WINTER, 52.5, 13.4, bands=self.GREEN).discs[1]
        above = 3640 * 10 ** (0.4 * 1.44) * 1.51e7 / 550
        elevation = float(azimuth_elevation_deg_of(sirius.direction)[1])
        air = TableSky(elevation, 0.1, 300.0).transmission(np.array([550.0]))
        # 1.51e7 has three digits.
        np.testing.assert_allclose(sirius.irradiance(), above * air, rtol=2e-3)

    def test_the_air_before_them_is_that_before_the_sun(self):
        nm = np.array([350.0, 450.0, 550.0, 650.0])
        zenith = TableSky(90.0, 0.1, 300.0).transmission(nm)
        for elevation, off in ((5.0, 0.08), (20.0, 2e-3), (45.0, 2e-3)):
            through = TableSky(elevation, 0.1, 300.0).transmission(nm)
            np.testing.assert_allclose(zenith ** air_mass(elevation), through, rtol=off)

    @pytest.mark.parametrize(
        ("spectral_class", "colour"),
        [("B8", -0.03), ("A0", 0.0), ("F5", 0.43), ("G2", 0.65), ("K2", 1.24), ("K5", 1.54)],
    )
    def test_their_colours(self, spectral_class, colour):
        """B - V of Rigel, Vega, Procyon, the sun's like, Arcturus and Aldebaran (recalled), each
        within 0.1 of its class."""
        found = black_body_colour(temperature_k(spectral_class))
        assert found == pytest.approx(colour, abs=0.1)
        assert black_body_colour(5800.0) == pytest.approx(0.65, abs=0.1)

    def test_which_are_there(self):
        all_of_them = [
            omma.light.stars(self.WINTER, latitude, 13.4, faintest_magnitude=5, bands=self.GREEN)
            for latitude in (90, -90)
        ]
        assert sum(len(one.discs) for one in all_of_them) == 108 + 5  # planets
        two = omma.light.Bands.equal(2)
        anew = all_of_them[0].in_bands(two)
        assert anew == omma.light.stars(self.WINTER, 90, 13.4, faintest_magnitude=5, bands=two)
        first = omma.light.stars(self.WINTER, 52.5, 13.4, faintest_magnitude=0.5, bands=self.GREEN)
        # Jupiter, Sirius, Arcturus, Vega, Capella, Rigel, Procyon and Betelgeuse.
        assert len(first.discs) == 8
        watts = omma.light.stars(self.WINTER, 52.5, 13.4, bands=self.GREEN, unit="watts")
        again = omma.light.photons_from_watts(watts.discs[0].radiance, [550.0])
        np.testing.assert_allclose(again, first.discs[0].radiance, rtol=1e-3)
        with pytest.raises(omma.Error, match="faintest_magnitude: expected -2 to 5, found 9"):
            omma.light.stars(self.WINTER, 0, 0, faintest_magnitude=9)

    def test_they_are_seen(self):
        """An ommatidium that looks at a star catches its irradiance over the solid angle of its
        acceptance, without a ray that meets it."""
        star = omma.light.Disc((0, 0, -1), 1e-5, [1e9, 2e9])
        bands = omma.light.Bands.equal(2, 400, 700)
        world = omma.World(omma.scene.plane((1, 1)), light=omma.light.Light(bands, discs=(star,)))
        eye = omma.eye.generate_eye(100)
        seen = omma.Renderer(world, eye, omma.Fixed(1)).render(omma.look_at((0, 1, 0), (0, 1, -1)))
        away = np.arccos(np.clip(eye.axis @ [0, 0, -1], -1, 1))
        width = np.broadcast_to(eye.acceptance_angle_rad, away.shape)
        best = int(np.argmin(away / width))
        theta = np.linspace(0, 4 * width[best], 20001)
        beam = np.exp(-4 * np.log(2) * (theta / width[best]) ** 2) * np.sin(theta)
        whole = 2 * np.pi * np.trapezoid(beam, theta)
        expected = star.irradiance() * np.exp(-4 * np.log(2) * (away / width)[best] ** 2) / whole
        np.testing.assert_allclose(seen[0, best], expected, rtol=2e-3)


class TestPlanets:
    """Beside what PyEphem says when it is asked for each of them directly."""

    ephem = pytest.importorskip("ephem")
    PLACE = -24.6, 27.9
    NAMES = ("Mercury", "Venus", "Mars", "Jupiter", "Saturn")
    # All five together.
    EVENING = datetime(2016, 8, 20, 17, tzinfo=timezone.utc)
    NARROW = omma.light.Bands.from_edges([439.5, 440.5, 549.5, 550.5])

    def asked(self, name, moment):
        """The planet, its azimuth and elevation, degrees."""
        observer = self.ephem.Observer()
        observer.lat, observer.lon = (str(one) for one in self.PLACE)
        observer.pressure, observer.date = 0, moment.strftime("%Y/%m/%d %H:%M:%S")
        planet = getattr(self.ephem, name)(observer)
        return planet, np.degrees(float(planet.az)), np.degrees(float(planet.alt))

    def found(self, name, moment, **arguments):
        _, azimuth, elevation = self.asked(name, moment)
        return nearest(omma.light.stars(moment, *self.PLACE, **arguments), azimuth, elevation)

    @pytest.mark.parametrize("name", NAMES)
    def test_where_and_how_large_and_bright(self, name):
        planet, _, elevation = self.asked(name, self.EVENING)
        disc, off_deg = self.found(name, self.EVENING, bands=self.NARROW)
        assert elevation > 0
        assert off_deg < 1e-3
        assert disc.angular_radius_rad == pytest.approx(max(RADIUS_RAD, float(planet.radius)))
        # The magnitude of zero as for Sirius above, in the second of three bands.
        above = 3640 * 10 ** (-0.4 * planet.mag) * 1.51e7 / 550
        air = TableSky(90.0, 0.1, 300.0).transmission(np.array([550.0])) ** air_mass(elevation)
        np.testing.assert_allclose(disc.irradiance()[2], above * air, rtol=2e-3)

    @pytest.mark.parametrize(
        ("name", "colour"), list(zip(NAMES, (0.93, 0.82, 1.36, 0.83, 1.04), strict=True))
    )
    def test_their_colours(self, name, colour):
        """B - V of Allen's Astrophysical Quantities (recalled), which is another source than that
        of the light: within 0.1."""
        elevation = self.asked(name, self.EVENING)[2]
        disc, _ = self.found(name, self.EVENING, bands=self.NARROW)
        air = TableSky(90.0, 0.1, 300.0).transmission(np.array([440.0, 550.0]))
        blue, visual = disc.irradiance()[[0, 2]] / air ** air_mass(elevation) * (440, 550)
        assert -2.5 * np.log10(blue / 4260 / (visual / 3640)) == pytest.approx(colour, abs=0.1)

    def test_the_night_of_the_dung_beetle(self):
        """1 February 2025, 22:00 in Limpopo: Jupiter and Mars are up, Venus and Saturn have set."""
        moment = datetime(2025, 2, 1, 20, tzinfo=timezone.utc)
        starry = omma.light.stars(moment, *self.PLACE, bands=self.NARROW)
        # Jupiter, of -2.4 magnitudes, comes before Sirius, of -1.4, Mars, of -1.0, before Canopus.
        for name, at in (("Jupiter", 0), ("Mars", 2)):
            disc, off_deg = nearest(starry, *self.asked(name, moment)[1:])
            assert off_deg < 1e-3
            assert disc == starry.discs[at]
        for name in ("Venus", "Saturn", "Mercury"):
            assert self.asked(name, moment)[2] < 0
            assert self.found(name, moment, bands=self.NARROW)[1] > 1
        bright = omma.light.stars(moment, *self.PLACE, faintest_magnitude=-2, bands=self.NARROW)
        assert bright.discs == starry.discs[:1]

    def test_faint_ones_are_left_out(self):
        """Saturn, of 0.4 magnitudes that evening."""
        assert self.asked("Saturn", self.EVENING)[0].mag == pytest.approx(0.4, abs=0.1)
        for faintest, there in ((0.6, True), (0.2, False)):
            few = {"faintest_magnitude": faintest, "bands": self.NARROW}
            assert (self.found("Saturn", self.EVENING, **few)[1] < 1e-3) is there


class TestMoon:
    pytest.importorskip("ephem")

    def test_its_lit_fraction(self):
        """USNO's of 9 to 18 September 2018 at 5 h UTC, to two digits, as in Skyfield's tests."""
        published = [0, 0, 0.03, 0.08, 0.15, 0.24, 0.33, 0.43, 0.52, 0.62]
        for day, fraction in enumerate(published, 9):
            moment = datetime(2018, 9, day, 5, tzinfo=timezone.utc)
            moon = omma.light.moon_position(moment, 0, 0)
            # From the earth's middle to its surface that changes by some thousandths.
            assert moon.illuminated_fraction == pytest.approx(fraction, abs=0.012)
            assert (1 + np.cos(np.radians(moon.phase_angle_deg))) / 2 == pytest.approx(
                moon.illuminated_fraction, abs=1e-9
            )

    def test_it_rises_where_the_almanac_says(self):
        """USNO's for Atlanta on 6 September 2009 (documentation of PyEphem): it sets at 9:05 EDT
        and rises at 20:44, its upper limb and 34 minutes of arc of refraction at the horizon."""
        for hour, minute in ((13, 5), (24, 44)):
            moment = datetime(2009, 9, 6 + hour // 24, hour % 24, minute, tzinfo=timezone.utc)
            moon = omma.light.moon_position(moment, 33.8, -84.4)
            # It climbs a quarter of a degree a minute.
            assert moon.elevation_deg == pytest.approx(-0.83, abs=0.2)

    def test_the_air_of_a_sky_at_a_time_is_said_as_of_the_clear_sky(self):
        """By day, under a new moon: the clear sky of that air, to which the night adds 1e-8."""
        noon = datetime(2026, 8, 12, 11, tzinfo=timezone.utc)
        place, air = (52.5, 13.4), {"aerosol": 0.3, "ozone_du": 400.0, "bands": FEW}
        found = omma.light.natural_sky_at(noon, *place, **air)
        clear = omma.light.clear_sky_at(noon, *place, **air)
        np.testing.assert_allclose(found.irradiance(), clear.irradiance(), rtol=1e-6)

    def test_the_sky_at_a_time_has_moon_and_night(self):
        place = 52.5, 13.4
        night = datetime(2026, 8, 27, 22, tzinfo=timezone.utc)
        moon = omma.light.moon_position(night, *place)
        light = omma.light.natural_sky_at(night, *place, bands=FEW)
        # The middle of its lit part is less than a tenth of its radius beside its own.
        np.testing.assert_allclose(
            light.discs[0].direction, direction(moon.azimuth_deg, moon.elevation_deg), atol=4e-4
        )
        assert moon.illuminated_fraction > 0.97
        dark = datetime(2026, 8, 12, 23, tzinfo=timezone.utc)  # a new moon
        assert not omma.light.natural_sky_at(dark, *place, bands=FEW).discs
