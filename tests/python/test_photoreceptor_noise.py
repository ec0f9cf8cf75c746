"""Noise: means, variances and whole distributions; seeds; frames in pieces."""

import numpy as np
import pytest
from scipy import stats

import omma
from omma.photoreceptors import ImpulseResponse, filter_frames, intrinsic_noise, photon_noise

# Seeds are fixed, so tests that go by chance give the same every time. p below this fails: of the
# couple of dozen tests here one in a thousand sets of seeds would.
LEAST_P = 1e-4


@pytest.mark.parametrize("mean", [1e-3, 0.1, 0.7, 3.0, 12.0, 90.0])
def test_photons_are_poisson(mean):
    """χ² of how often each number comes, of 400,000."""
    drawn = photon_noise(np.full((40, 10_000), mean), 5).ravel()
    assert np.array_equal(drawn, np.rint(drawn))
    numbers = np.arange(stats.poisson.ppf(1 - 1e-12, mean) + 2)
    expected = stats.poisson.pmf(numbers, mean) * len(drawn)
    found = np.bincount(drawn.astype(int), minlength=len(numbers))
    assert len(found) == len(numbers)
    # Cells of fewer than 10 are one with their neighbour.
    cell = np.cumsum(expected) // 10 * (expected < 10) + (expected >= 10) * (numbers + 1e6)
    _, which = np.unique(cell, return_inverse=True)
    found, expected = np.bincount(which, found), np.bincount(which, expected)
    assert stats.chisquare(found, expected * len(drawn) / expected.sum()).pvalue > LEAST_P


@pytest.mark.parametrize("mean", [1e-6, 1e-3, 1.0, 1e3, 1e9, 2e10, 1e13, 8e15])
def test_mean_and_variance_of_photons(mean):
    count = 400_000
    drawn = photon_noise(np.full((count // 10_000, 10_000), mean), 3)
    # Deviations of the mean and of the variance of Poisson numbers, times 5.
    assert abs(np.mean(drawn) - mean) < 5 * np.sqrt(mean / count)
    of_variance = np.sqrt((mean + 2 * mean**2) / count)
    assert abs(np.var(drawn - mean) - mean) < 5 * of_variance


def test_no_light_no_photons():
    assert np.all(photon_noise(np.zeros((3, 50)), 0) == 0)


def test_frames_in_pieces_get_the_same_numbers():
    catches = np.random.default_rng(0).random((30, 20, 3)) * 50
    whole = photon_noise(catches, 7)
    for first, end in ((0, 11), (11, 12), (12, 30)):
        piece = photon_noise(catches[first:end], 7, first_frame=first)
        np.testing.assert_array_equal(piece, whole[first:end])
    noise = intrinsic_noise(catches, 0.3, 7)
    np.testing.assert_array_equal(noise[9:], intrinsic_noise(catches[9:], 0.3, 7, first_frame=9))
    assert np.mean(photon_noise(catches, 8) == whole) < 0.2
    assert np.array_equal(photon_noise(catches, 7), whole)


def test_frames_seeds_and_kinds_are_independent():
    """Correlations between what should have none: below 5 of their deviations."""
    flat = np.full((2, 100_000), 20.0)
    photons, other = photon_noise(flat, 1), photon_noise(flat, 2)
    normal = intrinsic_noise(np.zeros_like(flat), 1.0, 1)
    pairs = [
        (photons[0], photons[1]), (photons[0], other[0]), (photons[0], normal[0]),
        (normal[0], normal[1]), (photons[0][:-1], photons[0][1:]),
    ]  # fmt: skip
    for one, two in pairs:
        assert abs(np.corrcoef(one, two)[0, 1]) < 5 / np.sqrt(len(one))


def test_relative_units():
    """A response of 0.5 at 20,000 photons a second over 10 ms is 100 photons."""
    responses = np.full((20, 10_000), 0.5)
    noisy = photon_noise(responses, 4, photons_per_s=20_000.0, integration_time_s=0.01)
    counts = photon_noise(200 * responses, 4)
    np.testing.assert_allclose(noisy, counts / 200)
    assert np.std(noisy) == pytest.approx(np.sqrt(100) / 200, rel=0.01)


def test_receptors_have_their_own_photons_and_times():
    """To the bits of each alone; a variance of R over the photons of each."""
    responses = np.full((50, 4000, 3), 0.5)
    per_s, time_s = np.array([500.0, 20_000.0, 4e6]), np.array([0.02, 0.01, 0.005])
    noisy = photon_noise(responses, 4, photons_per_s=per_s, integration_time_s=time_s)
    means = 0.5 * per_s * time_s
    counts = photon_noise(np.broadcast_to(means, responses.shape), 4)
    np.testing.assert_allclose(noisy, counts / (per_s * time_s))
    # 200,000 numbers: their variance is known to 0.3 %.
    np.testing.assert_allclose(noisy.var((0, 1)), 0.5 / (per_s * time_s), rtol=0.015)
    one = photon_noise(responses, 4, photons_per_s=per_s, integration_time_s=0.01)
    same = photon_noise(responses, 4, photons_per_s=per_s, integration_time_s=[0.01] * 3)
    assert np.array_equal(one, same)
    ommatidia = np.linspace(1e3, 1e4, 4000)[:, None]
    assert photon_noise(responses, 4, photons_per_s=ommatidia, integration_time_s=0.01).shape == (
        responses.shape
    )


def test_noise_that_is_filtered_is_that_of_the_integration_time():
    """Photons of each frame, then the filter: the variance is rate × ∫h², as if those of the
    integration time were counted.
    """
    h = ImpulseResponse.howard(0.010, 0.3)
    frame_rate_hz, rate = 1000.0, 5_000.0
    light = np.ones((1200, 400))
    noisy = photon_noise(light, 1, photons_per_s=rate, integration_time_s=1 / frame_rate_hz)
    answer = filter_frames(noisy, frame_rate_hz, h)[200:]
    expected = 1 / (rate * h.integration_time_s)
    # 1000 frames of some 10 ms each are 100 independent ones: 40,000 in all, 0.7 %; straight lines
    # between frames take away some of the noise's highest frequencies, 1 %.
    assert np.var(answer) == pytest.approx(expected, rel=0.04)


def test_intrinsic_noise_is_normal():
    responses = np.full((50, 4000, 2), 2.0)
    noise = intrinsic_noise(responses, [0.1, 0.4], 11) - responses
    for k, deviation in enumerate((0.1, 0.4)):
        sample = noise[..., k].ravel()
        assert stats.kstest(sample / deviation, "norm").pvalue > LEAST_P
    assert np.array_equal(intrinsic_noise(responses, 0, 1), responses)


ONES = np.ones((2, 3))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: photon_noise([[1, 2], [3, -1]], 0), r"catches: .*, found -1 at \[1, 1\]"),
        (lambda: photon_noise([[1, np.nan]], 0), r"catches: .*, found nan at \[0, 1\]"),
        (lambda: photon_noise([[1e16]], 0), r"catches: expected 0 to 9e\+15 photons, found 1e\+16"),
        (lambda: photon_noise(3.0, 0), "catches: expected frames along the first axis"),
        (lambda: photon_noise(ONES, -1), "seed: expected 0 to"),
        (lambda: photon_noise(ONES, 0, first_frame=-1), "first_frame: expected 0 to"),
        (lambda: photon_noise(ONES, 0, photons_per_s=10.0), "photon_noise: expected both of"),
        (
            lambda: photon_noise(ONES, 0, photons_per_s=0.0, integration_time_s=1.0),
            "photons_per_s: expected a number above 0",
        ),
        (
            lambda: photon_noise(ONES, 0, photons_per_s=[1, 2], integration_time_s=1.0),
            r"photons_per_s: expected a shape that goes with \(3,\), found \(2,\)",
        ),
        (
            lambda: photon_noise(ONES, 0, photons_per_s=1.0, integration_time_s=[1, 0, 1]),
            "integration_time_s: expected finite numbers above 0, found 0",
        ),
        (lambda: intrinsic_noise(ONES, -0.1, 0), "deviation: expected finite numbers from 0 on"),
        (lambda: intrinsic_noise(ONES, [1, 2], 0), r"deviation: expected a shape that goes with"),
        (lambda: intrinsic_noise([[np.inf]], 0.1, 0), "responses: expected finite numbers"),
    ],
)
def test_bad_calls(call, message):
    with pytest.raises(omma.Error, match=message):
        call()


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 200.0, 500.0, 2000.0])
@pytest.mark.parametrize("name", ["bumblebee green", "blowfly", "exponential"])
def test_filtered_noise_has_the_variance_of_photons_at_any_frame_rate(name, rate_hz):
    """L photons a second leave L ∫ h² behind h: relative to L, ∫ h² / L."""
    if name == "exponential":
        h = ImpulseResponse.exponential(0.01)
    else:
        h = omma.photoreceptors.published_response(name)
    time_s = omma.photoreceptors.frame_integration_time_s(h, rate_hz)
    assert 0 < time_s * rate_hz < 1.001
    per_s, count = 1e5, 20_000
    some = int(np.ceil(0.2 * rate_hz)) + 2  # frames, of which the last has forgotten the first
    drawn = photon_noise(np.ones((some, count)), 4, photons_per_s=per_s, integration_time_s=time_s)
    found = np.var(filter_frames(drawn, rate_hz, h, before=1.0)[-1])
    # Of 20,000 the variance is known to 1 %.
    assert found == pytest.approx(1 / (h.integration_time_s * per_s), rel=0.05)


def test_time_of_a_frame_at_high_rates_and_of_a_gaussian():
    """(1 − 1/(12 σ² rate²)) / rate to first order, σ the standard deviation."""
    sigma_s, rate_hz = 0.003, 2000.0
    times_s = np.linspace(0, 0.04, 8001)
    h = ImpulseResponse.table(times_s, np.exp(-((times_s - 0.02) ** 2) / (2 * sigma_s**2)))
    expected = 1 - 1 / (12 * sigma_s**2 * rate_hz**2)
    found = omma.photoreceptors.frame_integration_time_s(h, rate_hz) * rate_hz
    # What is left out is of the order of the square of 1 − expected, 5e-6.
    assert found == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(
    ("name", "species", "factor"),
    [("bumblebee green", "bumblebee", 1.58), ("blowfly", "calliphora", 1.56)],
)
def test_times_of_species_are_full_widths_and_those_of_noise_are_longer(name, species, factor):
    """As the pages say: √π σ exp(0.75 σ²)/sinh(σ √(2 ln 2)) of a log-normal, σ 0.3."""
    h = omma.photoreceptors.published_response(name)
    animal = getattr(omma.species, species)()
    # The blowfly's table has steps of 0.01 ms, its published width two digits.
    assert np.min(np.abs(animal.integration_time_s - h.full_width_s)) < 1e-5
    assert h.integration_time_s / h.full_width_s == pytest.approx(factor, abs=0.005)
    if name != "blowfly":
        s = 0.3
        exact = np.sqrt(np.pi) * s * np.exp(0.75 * s**2) / np.sinh(s * np.sqrt(2 * np.log(2)))
        assert h.integration_time_s / h.full_width_s == pytest.approx(exact, rel=1e-12)


def test_conditions_with_seeds_of_their_own_differ_by_poisson_noise():
    """What docs/receptors.md says of 1,000 and 1,020 photons, with one seed and with two."""
    dim, same, other = (
        photon_noise(np.full((2000, 5), mean), seed)
        for mean, seed in ((1000.0, 1), (1020.0, 1), (1020.0, 2))
    )
    # The deviation of a variance from 10,000 numbers is 1.4 % of it.
    assert (other - dim).var() == pytest.approx(2020, rel=0.05)
    assert (same - dim).var() == pytest.approx(78, rel=0.05)
    zeros = np.zeros((20, 5))
    drawn = intrinsic_noise(zeros, 1.0, 3)
    # Rounding of the sum alone.
    assert np.allclose(intrinsic_noise(zeros + 4, 1.0, 3) - 4, drawn, rtol=0, atol=1e-14)
