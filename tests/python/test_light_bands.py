"""Bands of wavelengths, and photons and watts."""

import numpy as np
import pytest

import omma
from omma.light import Bands


def test_equal_bands_are_sixteen_of_25_nm():
    bands = Bands.equal()
    assert len(bands) == 16
    np.testing.assert_allclose(bands.edges_nm, np.arange(300, 701, 25))
    np.testing.assert_allclose(bands.widths_nm, 25)
    np.testing.assert_allclose(bands.centers_nm, np.arange(312.5, 700, 25))
    assert repr(bands) == "Bands(16 bands from 300 to 700 nm, 25 nm each)"


def test_means_over_bands():
    bands = Bands.from_edges([300, 310, 400.5])
    # Of a straight line, the value in the middle; by samples at the middles of equal steps, exact.
    np.testing.assert_allclose(bands.mean(lambda nm: nm), [305, 355.25])
    np.testing.assert_allclose(bands.mean([3.0, 7.0], [300, 700]), [3.05, 3.5525])
    both = bands.mean(np.array([[1.0, 2.0], [1.0, 2.0]]), [200, 800])
    np.testing.assert_allclose(both, [[1, 2], [1, 2]])


@pytest.mark.parametrize("step_nm", [512.3, 519.95, 524.5])
def test_means_of_steps_are_exact(step_nm):
    """By samples a nanometre apart they were off by up to 2.8 %."""
    step = ([300, step_nm, step_nm + 1e-6, 700], [0.0, 0, 1, 1])
    means = Bands.equal().mean(step[1], step[0])
    np.testing.assert_allclose(means[7:10], [0, (525 - step_nm) / 25, 1], atol=1e-7)
    # Between two samples, and weighed by a receptor that is linear between its knots.
    tent = np.array([0.0, 0, 1, 0, 0])
    assert Bands.from_edges([500, 525]).mean(tent, [300, 510.2, 510.4, 510.6, 700]) == (
        pytest.approx(0.2 / 25, rel=1e-9)
    )
    bands = Bands.from_sensitivities([500, 525], [[1.0, 1.0]])
    assert bands.mean(step[1], step[0]) == pytest.approx((525 - step_nm) / 25, abs=1e-7)
    # Of wavelengths alone, what is there.
    assert Bands([510.4, 600], [[1, 0]]).mean(tent, [300, 510.2, 510.4, 510.6, 700]) == 1


@pytest.mark.parametrize("step_nm", [512.3, 519.95])
def test_surfaces_have_exact_means(step_nm):
    from lit_checks import look, matter, square

    spectrum = omma.light.Spectrum([300, step_nm, step_nm + 1e-6, 700], [0, 0, 0.8, 0.8])
    scene = omma.Scene(
        meshes=[square(100, (0, 0, 0), (0, 1, 0))],
        materials=[matter().replace(reflectance=spectrum)],
    )
    sky = omma.light.uniform_sky(1.0, bands=Bands.equal(8, 500, 700))
    seen, _ = look(omma.World(scene, light=sky, depth=1), (0, 0.5, 0), (0, -1, 0), samples=16)
    # All bands have the same rays, and so the same noise.
    assert seen[0] / seen[1] == pytest.approx((525 - step_nm) / 25, rel=1e-5)
    assert seen[1] == pytest.approx(0.8, rel=0.01)


def test_bands_of_sensitivities_weigh_as_these_do():
    nm = np.array([400.0, 500.0, 600.0])
    bands = Bands.from_sensitivities(nm, [[0, 1, 0], [1, 1, 1]])
    # A triangle: its mean is in the middle; 1 / ∫ w² dλ of one 200 nm wide is 150 nm.
    np.testing.assert_allclose(bands.centers_nm, [500, 500])
    np.testing.assert_allclose(bands.widths_nm, [150, 200], rtol=1e-4)  # of 1 nm steps
    assert bands.edges_nm is None


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Bands.from_edges([400, 300]), "edges_nm: expected 2 to 129 wavelengths that asc"),
        (lambda: Bands.from_edges([300, np.nan]), "edges_nm"),
        (lambda: Bands.equal(0), "count: expected 1 to 128, found 0"),
        (lambda: Bands.equal(129), "count: expected 1 to 128"),
        (lambda: Bands.equal(4, 500, 400), "low_nm, high_nm"),
        (lambda: Bands.from_sensitivities([300, 400], [[0, 0]]), "sensitivity: expected some abo"),
        (lambda: Bands.from_sensitivities([300, 400], [[-1, 1]]), "sensitivity: expected numbers"),
        (lambda: Bands.from_sensitivities([400, 300], [[1, 1]]), "wavelength_nm"),
        (lambda: Bands([300, 300], [[1, 1]]), "wavelength_nm: expected wavelengths that asc"),
        (lambda: Bands([300, 400], [[0, 0]]), "weight"),
        (lambda: Bands([300, 400], [[1, np.inf]]), "weight"),
        (lambda: Bands([300, 400], [[1, 1]], [300, 350, 400]), "edges_nm: expected 2, found 3"),
        (
            lambda: Bands.equal().mean([1.0, 2.0], [350, 700]),
            "spectrum: expected values from 300 to 700 nm",
        ),
        (lambda: Bands.equal().mean([1.0, 2.0]), "wavelength_nm: expected those of the spectrum"),
        (lambda: Bands.equal().mean(lambda nm: nm * np.nan), "spectrum: expected finite"),
    ],
)
def test_what_is_no_band_is_refused(make, message):
    with pytest.raises(omma.Error, match=message):
        make()


def test_photons_and_watts():
    # LED light of 1 W at 500 nm: λ / (h c), with the SI's exact h and c.
    photons = omma.light.photons_from_watts(1.0, 500)
    assert photons == pytest.approx(500e-9 / (6.62607015e-34 * 299792458), rel=1e-15)
    assert photons / 500 == pytest.approx(5.0341e15, rel=1e-5)  # as it is quoted
    nm = np.array([300.0, 700.0])
    np.testing.assert_allclose(
        omma.light.watts_from_photons(omma.light.photons_from_watts([2.0, 3.0], nm), nm), [2, 3]
    )
    with pytest.raises(omma.Error, match="wavelength_nm"):
        omma.light.photons_from_watts(1.0, 0)
    with pytest.raises(omma.Error, match="photons, wavelength_nm: expected shapes that go"):
        omma.light.watts_from_photons([1, 2, 3], [300, 400])


def test_sixteen_bands_are_enough_for_a_bee_under_a_clear_sky():
    """Of a sun at 30 degrees 2.6 % rms, 9.4 % with half the bands (docs/light.md). A tenth of that
    is what other tables of the sky may change."""
    light = omma.light.clear_sky(30.0)
    bee = omma.receptors.honeybee_ommatidia()[0].receptors
    found = [omma.receptors.band_error(light, bee, omma.light.Bands.equal(n)).rms for n in (8, 16)]
    assert found == pytest.approx([0.094, 0.026], rel=0.1)


@pytest.mark.parametrize("source", ["sky", "sun"])
def test_the_reported_error_holds_against_eighty_bands(source):
    """Receptors over ground of each reflectance, rendered in a few bands and in 80: they differ by
    what `band_error` reports. The ground is matt and open, so that nothing in a frame is random."""
    nm, reflectances = omma.receptors.natural_reflectances()
    types = omma.receptors.honeybee_ommatidia()[0].receptors
    eye = omma.Eye([[0, 1, 0]] * len(types), [[0, -1, 0]] * len(types), 0.0)
    eye = eye.replace(receptor_types=types, receptors=[[k] for k in range(len(types))])
    day = omma.light.clear_sky(30.0)

    def light(count):
        """That of a day's sky from everywhere above, or of its sun, in so many bands."""
        whole = day.in_bands(omma.light.Bands.equal(count))
        if source == "sun":
            return omma.light.Light(whole.bands, discs=whole.discs)
        return omma.light.uniform_sky(whole.irradiance()[0] / np.pi, below=0, bands=whole.bands)

    def responses(count):
        """(reflectances, receptors)."""
        found, lit = [], light(count)
        for row in reflectances:
            ground = omma.scene.Material(reflectance=omma.light.Spectrum(nm, row), specular=0)
            plane = omma.scene.plane((40, 40)).replace(materials=[ground])
            world = omma.World(plane, light=lit, lighting="path", depth=1)
            renderer = omma.Renderer(world, eye, omma.Fixed(32))
            found.append(renderer.render_receptors(np.eye(4))[0])
        return np.array(found)

    fine = responses(80)
    which = 0 if source == "sky" else -1
    for count in (4, 8, 16):
        bands = omma.light.Bands.equal(count)
        reported = omma.receptors.band_error(day, types, bands).relative_error[which]
        rendered = responses(count) / fine - 1
        told = np.isfinite(reported)
        assert told.mean() > 0.9
        np.testing.assert_allclose(rendered[told], reported[told], atol=2e-4)
