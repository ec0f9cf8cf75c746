"""Filters over frames: sinusoids, steps, weights by quadrature, and one frame at a time."""

import numpy as np
import pytest

import omma
from omma.photoreceptors import FrameFilter, ImpulseResponse, filter_frames
from omma.photoreceptors.filters import frame_weights

RESPONSES = {
    "howard": ImpulseResponse.howard(0.010, 0.3),
    "exponential": ImpulseResponse.exponential(0.02),
    "slow exponential": ImpulseResponse.exponential(1.0),
    "box": ImpulseResponse.box(0.0153),
    "short box": ImpulseResponse.box(0.0003),
    "biphasic table": ImpulseResponse.table(
        [0, 0.004, 0.008, 0.015, 0.02, 0.04], [0, 3, 1, -0.7, -0.3, 0]
    ),
}


@pytest.mark.parametrize("name", RESPONSES)
@pytest.mark.parametrize("frequency_hz", [2.0, 11.0, 40.0])
def test_a_sinusoid_gives_the_transfer_function(name, frequency_hz):
    """Straight lines between frames hold sinc² of a sinusoid, and of what beats with the frames:
    f + m × the frame rate, filtered at those frequencies, comes back from the frames as f.
    """
    h, rate_hz = RESPONSES[name], 1000.0
    t = np.arange(6000) / rate_hz
    seen = 3 + np.sin(2 * np.pi * frequency_hz * t)
    answer = filter_frames(seen, rate_hz, h, before=3.0)[-1000:]  # whole periods, long settled
    found = 2 * np.mean((answer - 3) * np.exp(-2j * np.pi * frequency_hz * t[-1000:])) * 1j
    images = frequency_hz + rate_hz * np.arange(-40, 41)
    exact = np.sum(h.transfer(images) * np.sinc(images / rate_hz) ** 2)
    # The slow exponential has exp(-5) of its beginning left. Images beyond 40: below 1e-5.
    slow = name == "slow exponential"
    assert abs(found - exact) < (0.01 * abs(exact) if slow else 2e-5)
    expected = h.transfer(frequency_hz)
    # π²/3 (f / frame rate)² = 0.53 % at 40 Hz.
    assert abs(found - expected) < 0.006 * abs(expected) + 1e-4 + 0.01 * abs(expected) * slow
    if abs(expected) > 0.01 and not slow:
        assert abs(np.angle(found / expected, deg=True)) < 0.1


@pytest.mark.parametrize("name", RESPONSES)
def test_weights_are_integrals_over_triangles(name):
    h, rate_hz = RESPONSES[name], 250.0
    weights = frame_weights(h, rate_hz)
    step = 1e-6
    times = np.arange(step / 2, min(len(weights), 60) / rate_hz, step)
    lag = np.arange(min(len(weights), 60))
    values = h.eval(times) * step
    near = np.clip(times * rate_hz, 0, None)
    direct = [np.sum(values * np.maximum(1 - np.abs(near - k), 0)) for k in lag[:-1]]
    # The step within which the box ends; 1e-7 for what is left out of those that do not end.
    np.testing.assert_allclose(weights[: len(direct)], direct, atol=2e-3 * step / 3e-6)
    assert np.sum(weights) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("name", RESPONSES)
@pytest.mark.parametrize("before", [None, 0.0, "frame"])
def test_one_frame_at_a_time_is_the_same(name, before):
    h = RESPONSES[name]
    random = np.random.default_rng(1)
    seen = random.random((300, 7, 3))
    given = random.random((7, 3)) if before == "frame" else before
    at_once = filter_frames(seen, 400.0, h, before=given)
    loop = FrameFilter(h, 400.0, before=given)
    one_by_one = np.array([loop.filter(frame) for frame in seen])
    # Sums in another order.
    np.testing.assert_allclose(one_by_one, at_once, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", RESPONSES)
def test_a_ramp_is_followed_exactly(name):
    """Straight lines are what light is taken to be: a ramp is late by the mean delay, exactly."""
    h, rate_hz = RESPONSES[name], 300.0
    seen = np.arange(6000) / rate_hz
    answer = filter_frames(seen, rate_hz, h)[-1]
    # What of h lies beyond the last weight: 1e-7 of the log-normal; e^-20 of the slow exponential.
    assert seen[-1] - answer == pytest.approx(h.first_moment_s(np.inf), abs=1e-7)


def test_a_step_gives_the_cumulative():
    h, rate_hz = RESPONSES["howard"], 20_000.0
    seen = np.ones(2000)
    answer = filter_frames(seen, rate_hz, h, before=0.0)
    times = np.arange(2000) / rate_hz
    # The straight line from darkness begins an interval earlier: half of it in the mean.
    np.testing.assert_allclose(answer, h.cumulative(times + 0.5 / rate_hz), atol=1e-5)


def test_axes_kinds_and_what_was_before():
    h = ImpulseResponse.howard(0.01, 0.3)
    seen = np.random.default_rng(0).random((5, 40, 2)).astype(np.float32)
    answer = filter_frames(seen, 200.0, h, axis=1)
    assert answer.dtype == np.float32
    assert answer.shape == seen.shape
    moved = filter_frames(np.moveaxis(seen, 1, 0), 200.0, h)
    np.testing.assert_array_equal(answer, np.moveaxis(moved, 0, 1))
    # Steady light stays what it is, darkness before it does not.
    steady = np.full((40, 2), 0.7)
    np.testing.assert_allclose(filter_frames(steady, 200.0, h), 0.7, rtol=1e-12)
    assert filter_frames(steady, 200.0, h, before=0)[0, 0] < 0.1
    assert FrameFilter(h, 200.0).filter(seen[0]).dtype == np.float32
    assert FrameFilter(h, 200.0, before=0.0).filter(np.empty((0, 3))).shape == (0, 3)
    assert filter_frames(np.empty((4, 0)), 200.0, h).shape == (4, 0)
    assert filter_frames(np.arange(4), 200.0, h).dtype == np.float64


def test_pieces_of_any_length_are_one_filter():
    """More frames than are convolved at a time."""
    h = RESPONSES["biphasic table"]
    seen = np.random.default_rng(2).random((700, 3))
    weights = frame_weights(h, 500.0)
    slow = [np.convolve(column, weights)[:700] for column in seen.T]
    np.testing.assert_allclose(
        filter_frames(seen, 500.0, h, before=0), np.transpose(slow), atol=1e-12
    )


H = RESPONSES["howard"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: filter_frames([1.0], 0.0, H), "frame_rate_hz: expected a number above 0"),
        (lambda: filter_frames([1.0], 1e9, H), "frame_rate_hz: expected at most .* found 1e"),
        (lambda: filter_frames([], 100.0, H), "responses: expected frames, found none"),
        (lambda: filter_frames(1.0, 100.0, H), "axis: expected one of 0 axes"),
        (lambda: filter_frames([1.0], 100.0, H, axis=1), "axis: expected one of 1 axes"),
        (lambda: filter_frames([1.0, np.nan], 100.0, H), "responses: expected finite numbers"),
        (
            lambda: filter_frames(np.ones((3, 2)), 100.0, H, before=[1, 2, 3]),
            r"before: expected a number or the shape of a frame, \(2,\), found \(3,\)",
        ),
        (lambda: filter_frames([1.0], 100.0, H, before=np.nan), "before: expected finite numbers"),
        (lambda: FrameFilter(H, -1.0), "frame_rate_hz: expected a number above 0"),
        (lambda: FrameFilter(H, 100.0).filter([np.inf]), "frame: expected finite numbers"),
    ],
)
def test_bad_calls(call, message):
    with pytest.raises(omma.Error, match=message):
        call()


def test_frames_of_another_shape_are_refused():
    loop = FrameFilter(H, 100.0)
    loop.filter(np.ones(3))
    with pytest.raises(omma.Error, match=r"frame: expected shape \(3,\), found \(4,\)"):
        loop.filter(np.ones(4))
    with pytest.raises(TypeError, match="h: expected omma"):
        filter_frames([1.0], 100.0, "howard")
    with pytest.raises(TypeError, match="h: expected omma"):
        FrameFilter(0.01, 100.0)
