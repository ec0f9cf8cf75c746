"""What receptors make of light in bands: matrices, photons, polarisation, and how wrong it is."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.light import Bands
from omma.receptors import ReceptorType

RANGE_NM = np.linspace(300, 700, 400_001)


def bee(count=6):
    eye = make_eye(count).replace(
        facet_diameter_m=20e-6, acceptance_angle_rad=np.full(count, 0.045)
    )
    return omma.receptors.assign_receptors(eye, omma.receptors.honeybee_ommatidia(), seed=1)


def test_bands_side_by_side_weigh_as_their_edges_do():
    eye = bee()
    bands = Bands.equal(16)
    np.testing.assert_array_equal(
        omma.receptors.receptor_matrix(eye, bands=bands),
        omma.receptors.receptor_matrix(eye, edges_nm=bands.edges_nm),
    )


def test_one_band_per_receptor_gives_its_answer_at_once():
    eye = bee()
    nm = np.arange(300, 701.0)
    sensitivities = [omma.receptors.spectral_sensitivity(one, nm) for one in eye.receptor_types]
    bands = Bands.from_sensitivities(nm, sensitivities)
    matrix = omma.receptors.receptor_matrix(eye, bands=bands)
    # Steps of 1 nm, linear between, for sensitivities that are smooth.
    np.testing.assert_allclose(matrix, np.eye(3), atol=1e-4)


def test_a_matrix_of_bands_is_asked_for_one_way():
    with pytest.raises(omma.Error, match="edges_nm: not together with bands"):
        omma.receptors.receptor_matrix(bee(), edges_nm=[300, 700], bands=Bands.equal())
    with pytest.raises(omma.Error, match="ultraviolet: is for RGB; not together with bands"):
        omma.receptors.receptor_matrix(bee(), (0, 0, 1), bands=Bands.equal())


def test_photons_caught_of_a_flat_spectrum():
    eye = bee()
    light = omma.light.uniform_sky(3e17)
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    seen = light.radiance((0, 1, 0))[0]
    responses = (matrix @ seen)[eye.receptor_type]
    found = omma.receptors.photon_catch(eye, responses[None], light, integration_time_s=0.015)
    assert found.shape == (1, len(eye.receptor_type))
    # Land's formula, summed in steps of 1 pm: (π/4)² D² Δρ² ∫ L (1 - exp(-k a l)) dλ t.
    for receptor, one in enumerate(eye.receptor_types):
        absorbance = omma.receptors.govardovskii(one.peak_wavelength_nm, RANGE_NM)
        absorbed = -np.expm1(-one.absorption_per_m * one.length_m * absorbance)
        integral = np.trapezoid(absorbed, RANGE_NM) * 3e17
        angle = float(np.float32(0.045))  # as the eye holds it
        diameter = float(np.float32(20e-6))
        expected = (np.pi / 4) ** 2 * diameter**2 * angle**2 * integral * 0.015
        np.testing.assert_allclose(found[0, eye.receptor_type == receptor], expected, rtol=1e-5)


def test_photons_caught_of_a_table():
    one = ReceptorType(
        "box", wavelength_nm=[399, 400, 500, 501], sensitivity=[0, 2, 2, 0],
        absorption_per_m=5000, length_m=2e-4,
    )  # fmt: skip
    eye = make_eye(2).replace(facet_diameter_m=20e-6, receptor_types=[one], receptors=[[0], [0]])
    light = omma.light.uniform_sky(1e17)
    found = omma.receptors.photon_catch(eye, [1e17, 2e17], light, integration_time_s=1.0)
    # A box of 101 nm that absorbs 1 - e^-1 at its top.
    S = omma.receptors.receptor_optical_sensitivity(eye, monochromatic=True)  # noqa: N806
    np.testing.assert_allclose(found, S * 101 * np.array([1e17, 2e17]), rtol=1e-6)


def test_catches_need_photons_and_what_an_eye_knows():
    eye = bee()
    answers = np.ones(len(eye.receptor_type))
    light = omma.light.uniform_sky()
    with pytest.raises(omma.Error, match="light: expected one in photons"):
        omma.receptors.photon_catch(
            eye, answers, omma.light.uniform_sky(unit="watts"), integration_time_s=1
        )
    with pytest.raises(omma.Error, match="integration_time_s: expected a number above 0"):
        omma.receptors.photon_catch(eye, answers, light, integration_time_s=0)
    with pytest.raises(omma.Error, match="responses: expected shape"):
        omma.receptors.photon_catch(eye, answers[1:], light, integration_time_s=1)
    with pytest.raises(omma.Error, match="eye: expected one with receptors"):
        omma.receptors.photon_catch(make_eye(3), answers, light, integration_time_s=1)
    with pytest.raises(omma.Error, match="eye: expected facet_diameter_m"):
        omma.receptors.photon_catch(
            eye.replace(facet_diameter_m=np.zeros(len(eye))), answers, light, integration_time_s=1
        )


def test_microvilli():
    types = [
        ReceptorType("a", peak_wavelength_nm=350, polarisation_sensitivity=6.3),
        ReceptorType(
            "b", peak_wavelength_nm=350, polarisation_sensitivity=6.3, microvillus_angle_rad=0.4
        ),
        ReceptorType("c", peak_wavelength_nm=540),
    ]
    eye = make_eye(2).replace(receptor_types=types, receptors=[[0, 1], [2]])
    share, angle = omma.receptors.polarisation_weights(eye)
    np.testing.assert_allclose(share, [5.3 / 7.3, 5.3 / 7.3, 0])  # 0.726
    np.testing.assert_allclose(angle, [0, 0.4, 0])
    # Fully polarised light: the best angle gives PS times what the worst gives.
    turn = np.linspace(0, np.pi, 1801)
    seen = 1 + share[1] * (np.cos(2 * turn) * np.cos(0.8) + np.sin(2 * turn) * np.sin(0.8))
    assert seen.max() / seen.min() == pytest.approx(6.3, rel=1e-4)
    assert turn[np.argmax(seen)] == pytest.approx(0.4, abs=2e-3)
    with pytest.raises(omma.Error, match="eye: expected one with receptors"):
        omma.receptors.polarisation_weights(make_eye(2))


def test_no_reflection_and_flat_light_have_no_error():
    eye = bee()
    flat = omma.light.uniform_sky()
    assert omma.receptors.band_error(flat, eye, Bands.equal(4), reflections=0).worst < 1e-4
    grey = ([300, 700], [[0.3, 0.3]])
    assert omma.receptors.band_error(flat, eye, Bands.equal(4), grey).worst < 1e-4


def test_the_error_of_two_bands_by_hand():
    # Sensitivity and reflectance rise together over 400 to 500 nm: the product of means is 1/4,
    # the mean of products is 1/3.
    one = ReceptorType("ramp", wavelength_nm=[400, 500], sensitivity=[0, 1])
    ramp = ([300, 400, 500, 501, 700], [[0, 0, 1, 0, 0]])
    found = omma.receptors.band_error(
        omma.light.uniform_sky(), one, Bands.from_edges([400, 500]), ramp
    )
    assert found.relative_error.shape == (1, 1, 1)
    # Against bands of 5 nm, whose own error is (5/100)²/4 of it.
    assert found.worst == pytest.approx(0.25, abs=1e-3)
    assert found.rms == found.worst


def test_reflectances_out_of_range():
    light, eye = omma.light.uniform_sky(), bee()
    for wrong in (([300, 700], [[0, 1.5]]), ([300, 700], [[-0.1, 1]]), 3, ([300, 700], [[1]])):
        with pytest.raises(omma.Error, match="reflectances"):
            omma.receptors.band_error(light, eye, None, wrong)
    with pytest.raises(omma.Error, match="spectrum: expected values from"):
        omma.receptors.band_error(light, eye, None, ([400, 700], [[1, 1]]))
    with pytest.raises(omma.Error, match="light: expected one that is not dark"):
        omma.receptors.band_error(omma.light.uniform_sky(0), eye)
