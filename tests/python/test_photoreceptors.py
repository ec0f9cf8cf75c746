"""Impulse responses: closed forms, quadrature of their own values, and what is refused."""

import dataclasses

import numpy as np
import pytest

import omma
from omma.photoreceptors import ImpulseResponse

RESPONSES = {
    "howard": ImpulseResponse.howard(0.010, 0.3),
    "narrow howard": ImpulseResponse.howard(0.030, 0.05),
    "exponential": ImpulseResponse.exponential(0.02),
    "box": ImpulseResponse.box(0.015),
    "table": ImpulseResponse.table([0.002, 0.004, 0.01, 0.03, 0.05], [0, 2, 1.5, 0, 0]),
    "biphasic table": ImpulseResponse.table(
        [0, 0.004, 0.008, 0.015, 0.02, 0.04], [0, 3, 1, -0.7, -0.3, 0]
    ),
}
# So fine that midpoints integrate smooth parts to 1e-8, and jumps to the step.
STEPS = 200_000


def sampled(h):
    """Midpoints of narrow intervals over all of a response, and their width."""
    end = 4 * h.duration_s
    step = end / STEPS
    return (np.arange(STEPS) + 0.5) * step, step


@pytest.mark.parametrize("name", RESPONSES)
def test_integrals_of_its_values(name):
    h = RESPONSES[name]
    times, step = sampled(h)
    values = h.eval(times)
    # 1e-5: a jump of the box or the exponential lies within one of the 200,000 steps.
    assert np.sum(values) * step == pytest.approx(1, abs=1e-5)
    np.testing.assert_allclose(np.cumsum(values) * step, h.cumulative(times + step / 2), atol=1e-5)
    np.testing.assert_allclose(
        np.cumsum(times * values) * step / h.duration_s,
        h.first_moment_s(times + step / 2) / h.duration_s,
        atol=1e-5,
    )
    assert h.cumulative(np.inf) == pytest.approx(1, abs=1e-12)
    assert np.isfinite(h.first_moment_s(np.inf))


@pytest.mark.parametrize("name", RESPONSES)
def test_transfer_is_the_fourier_integral(name):
    h = RESPONSES[name]
    times, step = sampled(h)
    values = h.eval(times)
    frequency = np.array([0.0, 1e-3, 3.0, -20.0, 77.0, 300.0])
    direct = [np.sum(values * np.exp(-2j * np.pi * f * times)) * step for f in frequency]
    np.testing.assert_allclose(h.transfer(frequency), direct, atol=1e-5)
    assert h.transfer(0.0) == pytest.approx(1, abs=1e-12)
    assert h.transfer(np.ones((2, 3))).shape == (2, 3)


@pytest.mark.parametrize("name", RESPONSES)
def test_features_of_the_curve(name):
    h = RESPONSES[name]
    times, step = sampled(h)
    values = h.eval(times)
    peak = int(np.argmax(values))
    assert times[peak] == pytest.approx(h.time_to_peak_s, abs=step)
    above = np.flatnonzero(values >= values[peak] / 2)
    assert above[-1] - above[0] + 1 == pytest.approx(h.full_width_s / step, abs=2)
    assert 1 / (np.sum(values**2) * step) == pytest.approx(h.integration_time_s, rel=1e-4)
    share = np.cumsum(np.abs(values)) / np.sum(np.abs(values))
    assert share[np.searchsorted(times, h.duration_s) - 1] == pytest.approx(1, abs=1.01e-4)


def test_the_published_numbers_of_a_log_normal():
    """t_p 10 ms, σ 0.3: 2 t_p sinh(σ√(2 ln 2)) = 7.212 ms; ∫ = t_p σ √(2π) exp(σ²/2) = 7.866 ms."""
    h = ImpulseResponse.howard(0.010, 0.3)
    assert h.full_width_s == pytest.approx(7.212e-3, abs=5e-7)
    assert 1 / h.eval(0.010) == pytest.approx(7.866e-3, abs=5e-7)
    # An exponential reaches half at τ ln 2, turns 45° at 1/(2πτ).
    low_pass = ImpulseResponse.exponential(0.01)
    assert low_pass.cumulative(0.01 * np.log(2)) == pytest.approx(0.5)
    assert np.angle(low_pass.transfer(1 / (2 * np.pi * 0.01)), deg=True) == pytest.approx(-45)
    assert abs(ImpulseResponse.box(0.01).transfer(100.0)) < 1e-15  # a whole period in the shutter


@pytest.mark.parametrize("name", RESPONSES)
def test_quantiles_turn_the_cumulative_around(name):
    h = RESPONSES[name]
    u = (np.arange(1000) + 0.5) / 1000
    times = h.quantile(u)
    assert np.all(np.diff(times) > 0)
    if "biphasic" not in name:
        np.testing.assert_allclose(h.cumulative(times), u, atol=1e-12)
    fine, step = sampled(h)
    size = np.cumsum(np.abs(h.eval(fine)))
    np.testing.assert_allclose(np.interp(times, fine + step / 2, size / size[-1]), u, atol=1e-5)
    assert h.quantile(0.0) <= times[0]
    assert h.quantile(1.0) >= times[-1]


@pytest.mark.parametrize("name", RESPONSES)
def test_drawn_times_give_the_response(name):
    """The mean over even u of weight × exp(-2πift) is H(f), also with negative lobes."""
    h = RESPONSES[name]
    count = 100_000
    times, weights = h.sample((np.arange(count) + 0.5) / count)
    for frequency in (0.0, 10.0, 45.0):
        drawn = np.mean(weights * np.exp(-2j * np.pi * frequency * times))
        # Midpoints of 100,000 shares; the last share of the exponential and the log-normal reaches
        # to infinity.
        assert drawn == pytest.approx(h.transfer(frequency), abs=3e-5)
    assert np.all(weights == 1) == ("biphasic" not in name)


def test_a_table_where_the_response_pauses():
    h = ImpulseResponse.table([0, 1e-3, 2e-3, 4e-3, 5e-3, 6e-3], [0, 1, 0, 0, 1, 0])
    # Half of it is before the pause, half after; nothing is drawn from the pause itself.
    times = h.quantile([0.0, 0.25, 0.4999999, 0.5, 0.75, 1.0])
    np.testing.assert_allclose(times * 1e3, [0, 1, 2, 4, 5, 6], atol=2e-3)
    assert h.quantile(0.5) in (pytest.approx(2e-3), pytest.approx(4e-3))


def test_a_table_of_a_log_normal_is_that_log_normal():
    howard = ImpulseResponse.howard(0.01, 0.3)
    times = np.linspace(0, 0.08, 4001)
    table = ImpulseResponse.table(times, 55 * howard.eval(times))
    u = np.linspace(0.001, 0.999, 99)
    np.testing.assert_allclose(table.quantile(u), howard.quantile(u), rtol=5e-5)
    np.testing.assert_allclose(table.transfer([1, 90]), howard.transfer([1, 90]), atol=5e-6)
    assert table.full_width_s == pytest.approx(howard.full_width_s, rel=1e-5)


def test_responses_are_values():
    one = ImpulseResponse.table([0, 0.01, 0.02], [0, 1, 0])
    assert one == ImpulseResponse.table([0, 0.01, 0.02], [0, 8, 0])
    assert hash(one) == hash(ImpulseResponse.table([0, 0.01, 0.02], [0, 8, 0]))
    assert one != ImpulseResponse.box(0.02)
    with pytest.raises(dataclasses.FrozenInstanceError):
        one.shape = "box"
    wider = dataclasses.replace(ImpulseResponse.howard(0.01, 0.3), sigma=0.4)
    assert wider == ImpulseResponse.howard(0.01, 0.4)


NAN = float("nan")


@pytest.mark.parametrize(
    ("times_s", "values", "message"),
    [
        ([0, 0.01, 0.01], [0, 1, 0], r"times_s: expected times that grow, found 0\.01 at \[2\]"),
        ([0, 0.02, 0.01], [0, 1, 0], r"times_s: expected times that grow, found 0\.01 at \[2\]"),
        (
            [-1e-3, 0, 0.01],
            [0, 1, 0],
            r"times_s: .* the flash at 0 on, found -0\.001 at \[0\]",
        ),
        ([0, NAN, 0.01], [0, 1, 0], r"times_s: expected finite numbers, found nan at \[1\]"),
        ([0, 0.01, np.inf], [0, 1, 0], r"times_s: expected finite numbers, found inf at \[2\]"),
        ([0, 10, 20], [0, 1, 0], "times_s: expected seconds, at most 5, found 20"),
        ([0, 0.01, 0.02], [0, NAN, 0], r"values: expected finite numbers, found nan at \[1\]"),
        ([0, 0.01, 0.02], [0, -1, 0], "values: expected a response that is somewhere above 0"),
        ([0, 0.01, 0.02], [0, 0, 0], "values: expected a response that is somewhere above 0"),
        ([0, 0.01, 0.02], [0, 2, 1], "values: expected a response that ends, found 0.5 of the"),
        ([0, 0.01, 0.02, 0.03], [0, 1, -1, 0], "values: expected an integral above 0"),
        ([0, 0.01, 0.02], [0, 1], "values: expected one for each of at least 2 times, found 2"),
        ([0], [1], "values: expected one for each of at least 2 times, found 1"),
        ([[0, 1]], [0, 1], r"times_s: expected shape \(N,\)"),
    ],
)
def test_bad_tables(times_s, values, message):
    with pytest.raises(omma.Error, match=message):
        ImpulseResponse.table(times_s, values)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ImpulseResponse.howard(0.0, 0.3), "time_to_peak_s: expected a number above 0"),
        (lambda: ImpulseResponse.howard(10.0, 0.3), "time_to_peak_s: expected seconds, at most 5"),
        (lambda: ImpulseResponse.howard(NAN, 0.3), "time_to_peak_s: expected a number above 0"),
        (lambda: ImpulseResponse.howard(0.01, 0.0), "sigma: expected 0.01 to 1, found 0.0"),
        (lambda: ImpulseResponse.howard(0.01, np.inf), "sigma: expected 0.01 to 1, found inf"),
        (lambda: ImpulseResponse.exponential(np.inf), "time_constant_s: expected a number above 0"),
        (lambda: ImpulseResponse.exponential(-1.0), "time_constant_s: expected a number above 0"),
        (lambda: ImpulseResponse.box(np.inf), "duration_s: expected a number above 0"),
        (lambda: ImpulseResponse("cosine", 0.1), "shape: expected one of howard, exponential, box"),
        (lambda: ImpulseResponse("box", 0.1, 0.0, (0.0, 1.0)), "times_s: expected none"),
        (lambda: RESPONSES["box"].quantile(1.5), "u: expected shares from 0 to 1"),
        (lambda: RESPONSES["box"].quantile([0.5, NAN]), "u: expected shares from 0 to 1"),
        (lambda: RESPONSES["box"].eval([NAN]), "times_s: expected times, found NaN"),
        (lambda: RESPONSES["box"].transfer([np.inf]), "frequency_hz: expected finite numbers"),
    ],
)
def test_bad_responses(make, message):
    with pytest.raises(omma.Error, match=message):
        make()


def test_types_are_named():
    with pytest.raises(TypeError, match="time_to_peak_s: expected a number, found str"):
        ImpulseResponse.howard("10 ms", 0.3)
