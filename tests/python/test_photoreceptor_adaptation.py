"""Adaptation: closed forms, and the model of van Hateren and Snippe against its equations, written
down once more as slow scalars.
"""

import math

import numpy as np
import pytest
from scipy.special import lambertw

import omma
from omma.photoreceptors import VanHaterenSnippe, logarithmic, naka_rushton, van_hateren_snippe

# The model's numbers once more, ms.
TAU_1, TAU_2, K1, K2 = 1.69, 71.8, 0.689, 9.07
TAU_3, POWER, MILLIVOLTS = 0.535, 11, 0.01284 / 4096
SLOW = 4.0 ** np.arange(-2, 11)


def test_naka_rushton():
    assert naka_rushton(30.0, 30.0) == 0.5
    assert naka_rushton(30.0, 30.0, 0.7, 60.0) == pytest.approx(30)
    catches = np.array([[0, 1e-3, 0.4], [7, 1e5, 1e300]])
    direct = 2 * catches[:, :2] ** 1.3 / (catches[:, :2] ** 1.3 + 5**1.3)
    np.testing.assert_allclose(naka_rushton(catches, 5, 1.3, 2)[:, :2], direct, rtol=1e-12)
    assert naka_rushton(catches, 5, 1.3, 2)[1, 2] == 2
    assert naka_rushton(0.0, 1.0) == 0


def test_logarithmic():
    # Dim light linear, bright light by equal steps for equal ratios.
    assert logarithmic(1e-9, 2.0, 3.0) == pytest.approx(3e-9 / 2)
    steps = np.diff(logarithmic([1e6, 1e7, 1e8], 2.0, 3.0))
    np.testing.assert_allclose(steps, 3 * math.log(10), rtol=1e-5)


def published(light):
    """The potential of one receptor, in steps of 1 ms, with the lags of the published program."""
    n = len(light)
    keep_1, keep_2, keeps = math.exp(-1 / TAU_1), math.exp(-1 / TAU_2), np.exp(-1 / SLOW)
    # The power law that the slow filter is to be, (1 - 1/z)^(-1/2), and what of it the low-pass
    # filters lack in its first 12 ms.
    law = np.cumprod(np.concatenate([[1.0], (np.arange(1, 25_000) - 0.5) / np.arange(1, 25_000)]))
    times = np.arange(25_000)[:, None]
    filters = ((1 - keeps) * keeps**times) @ np.sqrt(SLOW)
    scale = np.mean(law[49:12_500] / filters[49:12_500])
    lacking = (law - scale * filters)[:12]
    total = scale * np.sum(np.sqrt(SLOW)) + np.sum(lacking)

    root = math.sqrt(light[0])
    x = lambertw(K2 * root / K1).real / K2
    a = np.full(4, float(light[0]))
    before_a, before_b, c, slow = light[0], root, root, np.full(len(SLOW), x)
    recent = np.full(12, x)
    saturated = np.full(n, x / (1 + x))
    for i in range(1, n):
        a[0] = light[i]
        for j in range(1, 4):
            a[j] = (1 - keep_1) * a[j - 1] + keep_1 * a[j]
        c = (1 - keep_2) * before_b + keep_2 * c
        slow = (1 - keeps) * recent[0] + keeps * slow
        e = (scale * np.sum(np.sqrt(SLOW) * slow) + lacking @ recent) / total
        d = before_b / (K1 * math.exp(min(K2 * e, 18)))
        before_b, before_a = before_a / c, a[3]
        recent = np.concatenate([[d], recent[:-1]])
        saturated[i] = d / (d + 1)
    lag = np.arange(1, 60)
    membrane = MILLIVOLTS * (lag / TAU_3) ** POWER * np.exp(-lag / TAU_3)
    padded = np.concatenate([np.full(58, saturated[0]), saturated])
    return np.convolve(padded, membrane, "valid")


def natural(n, seed):
    """Light with a spectrum of about 1/f and a mean of 600, log-normal."""
    random = np.random.default_rng(seed)
    spectrum = np.fft.rfft(random.standard_normal(n))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0
    drive = np.fft.irfft(spectrum, n)
    light = np.exp(drive / np.std(drive))
    return 600 * light / np.mean(light)


@pytest.mark.parametrize("kind", ["natural", "step up", "step down", "flash"])
def test_it_is_the_published_model(kind):
    n = 1500
    light = natural(n, 3) if kind == "natural" else np.full(n, 500.0)
    light[500:] *= {"step up": 4.2, "step down": 0.2}.get(kind, 1.0)
    light[500:502] *= 20 if kind == "flash" else 1
    expected = published(light)
    found = van_hateren_snippe(light[:, None], 1000.0)[:, 0]
    assert np.ptp(expected) > 5
    # The fast part that is left out of the slow filter holds 1e-3 of it; the membrane is an
    # integral here, a sum there.
    assert np.max(np.abs(found - expected)) < 0.01 * np.ptp(expected)
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.003 * np.ptp(expected)


@pytest.mark.parametrize("light", [0.0, 0.05, 3.0, 600.0, 1e6])
def test_steady_states(light):
    """Adapted, K1 x exp(K2 x) = √I, and the potential is that of x/(1 + x)."""
    found = van_hateren_snippe(np.full((200, 2), light), 500.0)
    x = lambertw(K2 * np.sqrt(max(light, 0.01)) / K1).real / K2
    assert K1 * x * math.exp(K2 * x) == pytest.approx(math.sqrt(max(light, 0.01)))
    largest = MILLIVOLTS * math.factorial(POWER) * TAU_3
    np.testing.assert_allclose(found, largest * x / (1 + x), rtol=1e-4)


def test_small_contrasts_are_filtered_linearly():
    """Around a steady state each loop with output y and filter L, of gain s in it, is 1/(1 + sL):
    s is 1 in the first, K2 x in the second.
    """
    rate_hz, contrast, frames = 1000.0, 0.01, 4000
    mean = np.array([1.0, 100.0, 1e4])[:, None]
    frequency_hz = np.array([1.0, 5.0, 20.0, 50.0])
    t = np.arange(frames)[:, None, None] / rate_hz
    light = mean * (1 + contrast * np.sin(2 * np.pi * frequency_hz * t))
    before = np.broadcast_to(mean, light.shape[1:])
    found = van_hateren_snippe(light, rate_hz, before=before)[-1000:]
    turning = np.exp(-2j * np.pi * frequency_hz * t[-1000:])
    gain = 2j * np.mean(found * turning, axis=0) / contrast

    z = np.exp(-2j * np.pi * frequency_hz / rate_hz)

    def low_pass(tau):
        keep = np.exp(-1 / tau)
        return (1 - keep) / (1 - keep * z)

    x = lambertw(K2 * np.sqrt(mean) / K1).real / K2
    slow = sum(np.sqrt(tau) * low_pass(tau) for tau in SLOW) / np.sum(np.sqrt(SLOW))
    loops = 1 / (1 + z * low_pass(TAU_2)) / (1 + K2 * x * z * slow)
    # The membrane is τ^(n+1) n! / (1 + iωτ)^(n+1), a millisecond late.
    turn = 2j * np.pi * frequency_hz * 1e-3
    membrane = math.factorial(POWER) * TAU_3 * MILLIVOLTS / (1 + turn * TAU_3) ** (POWER + 1)
    expected = low_pass(TAU_1) ** 3 * loops * x / (1 + x) ** 2 * membrane * np.exp(-turn)
    # 1 % contrast makes a harmonic of 1 %; sinc² of the membrane's straight lines 1 % at 50 Hz.
    np.testing.assert_array_less(abs(gain - expected), 0.02 * abs(expected))


def test_small_contrasts_fast_enough_for_the_second_loop():
    """As the page has it: the first loop (1 + iωT)/(2 + iωT), filters and membrane."""
    rate_hz, contrast, frames = 2000.0, 0.01, 3000
    mean = np.array([10.0, 600.0, 1e5])[:, None]
    frequency_hz = np.array([5.0, 10, 15, 20, 30, 50, 80])
    t = np.arange(frames)[:, None, None] / rate_hz
    light = mean * (1 + contrast * np.sin(2 * np.pi * frequency_hz * t))
    before = np.broadcast_to(mean, light.shape[1:])
    found = van_hateren_snippe(light, rate_hz, before=before)[-2000:]
    turning = np.exp(-2j * np.pi * frequency_hz * t[-2000:])
    amplitude = 2 * abs(np.mean(found * turning, axis=0)) / contrast

    x = lambertw(K2 * np.sqrt(mean) / K1).real / K2
    turn = 2j * np.pi * frequency_hz * 1e-3
    factors = abs((1 + turn * TAU_2) / (2 + turn * TAU_2))
    factors /= abs(1 + turn * TAU_1) ** 3 * abs(1 + turn * TAU_3) ** (POWER + 1)
    np.testing.assert_allclose(factors[[0, 2, 4, 5, 6]], [0.81, 0.92, 0.81, 0.58, 0.29], atol=0.005)
    # What the slow loop takes of the fast, 2.5 % at 5 Hz in bright light, and steps of 0.5 ms.
    np.testing.assert_allclose(amplitude, 66.94 * x / (1 + x) ** 2 * factors, rtol=0.03)


def test_bright_light_obeys_weber():
    """The same contrast step gives nearly the same response over three decades of bright light,
    where one without adaptation would give a thousand times as much.
    """
    light = np.tile([1e2, 1e3, 1e4, 1e5], (300, 1))
    light[100:] *= 1.2
    found = van_hateren_snippe(light, 1000.0)
    peaks = np.max(found, axis=0) - found[0]
    assert max(peaks) / min(peaks) < 1.5
    # In dim light it does not: potentials go with √I there, and so do steps of them.
    dim = van_hateren_snippe(np.where(np.arange(300)[:, None] < 100, 0.02, 0.024), 1000.0)
    assert np.max(dim) - dim[0, 0] < 0.4 * min(peaks)


def test_steps_adapt():
    """A step gives a transient that decays towards a steady state between before and the peak."""
    light = np.full((2000, 1), 300.0)
    light[500:] = 1500.0
    both = van_hateren_snippe(np.hstack([light, 1800.0 - light]), 1000.0)
    found = both[:, 0]
    peak, end, before = np.max(found), found[-1], found[0]
    assert 500 + 8 <= np.argmax(found) <= 500 + 25
    assert before < end < before + 0.6 * (peak - before)
    assert np.all(np.diff(found[700:]) <= 1e-9)  # it goes on sinking, slower and slower
    down = both[:, 1]
    assert np.min(down[500:]) < down[-1] - 1  # and undershoots the other way round


def test_frame_rates_agree():
    """Steps of other lengths than the published millisecond, between frames that are the same."""
    times = np.arange(0, 1, 0.01)
    drive = 600 * np.exp(np.sin(2 * np.pi * 2 * times)[:, None])
    fine_times = np.arange(0, 0.9901, 1 / 3000)
    fine = 600 * np.exp(np.sin(2 * np.pi * 2 * fine_times)[:, None])
    coarse = van_hateren_snippe(drive, 100.0)
    exact = van_hateren_snippe(fine, 3000.0)[::30]
    # Low-pass filters that hold within a step are late by half of it, four of them by 2 × 1 ms; at
    # 2 Hz and this modulation that is 1.4 % of the range.
    assert np.max(np.abs(coarse[: len(exact)] - exact)) < 0.03 * np.ptp(exact)


def test_one_frame_at_a_time():
    light = natural(400, 5).reshape(50, 4, 2)
    receptors = VanHaterenSnippe(200.0, before=10.0)
    one_by_one = [receptors.filter(frame) for frame in light]
    np.testing.assert_array_equal(one_by_one, van_hateren_snippe(light, 200.0, before=10.0))
    # Each receptor by itself.
    np.testing.assert_allclose(
        van_hateren_snippe(light[:, 1], 200.0, before=10.0), np.array(one_by_one)[:, 1]
    )


NAN = float("nan")
ONES = np.ones((3, 2))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: naka_rushton([1, -2], 1.0), r"catches: .* from 0 on, found -2 at \[1\]"),
        (lambda: naka_rushton([[NAN]], 1.0), r"catches: .* from 0 on, found nan at \[0, 0\]"),
        (lambda: naka_rushton(1.0, 0.0), "half: expected a number above 0"),
        (lambda: naka_rushton(1.0, 1.0, -1.0), "exponent: expected a number above 0"),
        (lambda: logarithmic(1.0, 0.0), "dark: expected a number above 0"),
        (lambda: logarithmic(-1.0, 1.0), r"catches: .* found -1 at \[\]"),
        (lambda: van_hateren_snippe(ONES, 0.0), "frame_rate_hz: expected a number above 0"),
        (lambda: van_hateren_snippe(5.0, 100.0), "intensities: expected frames"),
        (lambda: van_hateren_snippe([1, NAN], 100.0), r"intensities: .* found nan at \[1\]"),
        (lambda: VanHaterenSnippe(90.0).filter([1, -1]), r"frame: .* found -1 at \[1\]"),
        (lambda: van_hateren_snippe(ONES, 100.0, [1, 2, 3]), "before: expected a number or the"),
        (lambda: van_hateren_snippe(ONES, 100.0, -1), "before: expected numbers from 0 on"),
        (lambda: VanHaterenSnippe(0.01), r"frame_rate_hz: expected 1 or more, found 0\.01"),
        (lambda: VanHaterenSnippe(NAN), "frame_rate_hz: expected a number above 0"),
    ],
)
def test_bad_calls(call, message):
    with pytest.raises(omma.Error, match=message):
        call()
