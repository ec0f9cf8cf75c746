"""Numbers of optics that are nearly always slips of units are refused, and said to be."""

import math

import pytest

import omma
from omma import Acceptance
from omma.receptors import ReceptorType

# (call, how the message begins, what it guesses)
SLIPS = [
    (lambda **k: Acceptance.gaussian(2.6, **k), "width_rad", "2.6 degrees would be 0.04538 rad"),
    (lambda **k: Acceptance.gaussian(0.04, 1.2, **k), "minor_width_rad", "1.2 degrees"),
    (lambda **k: Acceptance.gaussian(0.04, 0.02, 45, **k), "major_angle_rad", "45 degrees"),
    (lambda **k: Acceptance.pillbox(3, **k), "width_rad", "3 degrees"),
    (lambda **k: Acceptance.compoundray(3, **k), "width_rad", "3 degrees"),
    (lambda **k: Acceptance.airy(25e-6, 500e-9, **k), "wavelength_nm", "5e-07 m would be 500 nm"),
    (lambda **k: Acceptance.airy(25e-6, 0.5, **k), "wavelength_nm", "0.5 µm would be 500 nm"),
    (lambda **k: Acceptance.airy(25, 500, **k), "facet_diameter_m", "25 µm would be 2.5e-05 m"),
    (
        lambda **k: Acceptance.lens_rhabdom(25e-6, 0.055, 2e-6, 500, **k),
        "focal_length_m",
        "0.055 mm would be 5.5e-05 m",
    ),
    (
        lambda **k: Acceptance.lens_rhabdom(25e-6, 55e-6, 2, 500, **k),
        "rhabdom_diameter_m",
        "2 µm would be 2e-06 m",
    ),
    (
        lambda **k: ReceptorType("x", peak_wavelength_nm=500, absorption_per_m=0.0067, **k),
        "absorption_per_m",
        "0.0067 per µm would be 6700 per m",
    ),
    (
        lambda **k: ReceptorType("x", peak_wavelength_nm=500, length_m=320, **k),
        "length_m",
        "320 µm",
    ),
    (
        lambda **k: ReceptorType("x", peak_wavelength_nm=500, right_rad=-2, **k),
        "right_rad",
        "-2 degrees would be -0.03491 rad",
    ),
    (
        lambda **k: ReceptorType("x", peak_wavelength_nm=500, microvillus_angle_rad=90, **k),
        "microvillus_angle_rad",
        "90 degrees would be 1.571 rad",
    ),
    (lambda **k: omma.eye.generate_eye(10, radius_m=500, **k), "radius_m", "500 µm"),
]


@pytest.mark.parametrize(("call", "argument", "guess"), SLIPS)
def test_a_slip_is_refused_and_guessed(call, argument, guess):
    with pytest.raises(omma.Error) as found:
        call()
    message = str(found.value)
    assert message.startswith(f"{argument}: expected "), message
    assert guess in message
    assert message.endswith("say allow_unusual=True")


@pytest.mark.parametrize(
    "call",
    [
        SLIPS[0][0],
        SLIPS[3][0],
        lambda **k: ReceptorType("x", peak_wavelength_nm=500, length_m=0.5, **k),
        lambda **k: Acceptance.airy(5e-3, 500, **k),
        lambda **k: omma.eye.generate_eye(10, radius_m=0.5, **k),
    ],
)
def test_what_is_meant_can_be_said(call):
    with pytest.raises(omma.Error, match="allow_unusual=True"):
        call()
    call(allow_unusual=True)


def test_eyes_pass_it_on():
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1, facet_diameter_m=5e-3)
    with pytest.raises(omma.Error, match=r"^facet_diameter_m: expected 1e-06 to 0\.001 m"):
        omma.eye.acceptance_from_facets(eye)
    far = omma.eye.acceptance_from_facets(eye, allow_unusual=True)
    assert far.acceptance(0).facet_diameter_m == pytest.approx(5e-3, rel=1e-6)


def test_what_is_impossible_stays_so():
    for call in (
        lambda: Acceptance.gaussian(-1, allow_unusual=True),
        lambda: Acceptance.gaussian(7, allow_unusual=True),
        lambda: Acceptance.gaussian(math.nan),
        lambda: Acceptance.airy(25e-6, 500e-9, allow_unusual=True),
    ):
        with pytest.raises(omma.Error) as found:
            call()
        assert "allow_unusual" not in str(found.value)


def test_files_are_data(tmp_path):
    """What was meant once and written is read again, in whatever range."""
    wide = Acceptance.gaussian(2.0, 1.5, allow_unusual=True)
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], acceptance=wide)
    omma.save_eye(tmp_path / "wide.csv", eye)
    assert omma.load_eye(tmp_path / "wide.csv").acceptance(0) == wide


def test_what_animals_have_is_plausible():
    for width_deg in (0.24, 60):
        Acceptance.gaussian(math.radians(width_deg))
    Acceptance.gaussian(0)  # one ray
    Acceptance.lens_rhabdom(5e-6, 10e-6, 1e-6, 350)  # the smallest flies
    ReceptorType("ultraviolet", peak_wavelength_nm=300, length_m=1.1e-3, absorption_per_m=10e3)
