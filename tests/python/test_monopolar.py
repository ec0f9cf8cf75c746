"""Large monopolar cells on a lattice that closes on itself, microsaccades, published numbers."""

import numpy as np
import pytest

import omma
from omma.photoreceptors import (
    ImpulseResponse,
    displace_axes,
    large_monopolar,
    microsaccades_rad,
    published_response,
)

SIZE = 12
EXCITATION = ImpulseResponse.howard(10.3e-3, 0.236)
INHIBITION = ImpulseResponse.howard(15.6e-3, 0.269)
# Steps in rows p and q, in the order of omma.eye.hexagonal.DIRECTIONS.
STEPS = [(1, 1), (0, 1), (-1, 0), (-1, -1), (0, -1), (1, 0)]


def torus():
    """Coordinates and neighbours of a hexagonal lattice of 12 × 12 that closes on itself."""
    p, q = np.divmod(np.arange(SIZE * SIZE), SIZE)
    columns = [(p + a) % SIZE * SIZE + (q + b) % SIZE for a, b in STEPS]
    return p, q, np.stack(columns, axis=1)


@pytest.mark.parametrize("waves", [(0, 0), (1, 0), (2, 3), (6, 6)])
@pytest.mark.parametrize("frequency_hz", [4.0, 20.0, 60.0])
def test_gratings_are_filtered_in_space_and_time(waves, frequency_hz):
    """H₁(f) - H₂(f) [1 - Σw + Σ w_k exp(i k·d_k)], with weights that differ by direction."""
    p, q, neighbours = torus()
    weights = np.array([0.05, 0.1, 0.2, 0.05, 0.0, 0.15])
    rate_hz = 2000.0
    t = np.arange(2000) / rate_hz
    phase = 2 * np.pi * (waves[0] * p + waves[1] * q) / SIZE
    seen = np.cos(2 * np.pi * frequency_hz * t[:, None] + phase)
    found = large_monopolar(seen, rate_hz, neighbours, weights)[-1000:]  # whole periods
    turning = np.exp(-1j * (2 * np.pi * frequency_hz * t[-1000:, None] + phase))
    gain = 2 * np.mean(found * turning)
    steps = [2 * np.pi * (waves[0] * a + waves[1] * b) / SIZE for a, b in STEPS]
    around = 1 - weights.sum() + np.sum(weights * np.exp(1j * np.array(steps)))
    expected = EXCITATION.transfer(frequency_hz) - around * INHIBITION.transfer(frequency_hz)
    # sinc² of the straight lines between frames: 0.3 % at 60 Hz.
    assert abs(gain - expected) < 0.005 * (abs(expected) + 0.2)


def test_steady_light_is_taken_away():
    _, _, neighbours = torus()
    steady = np.full((5, SIZE * SIZE), 0.7)
    np.testing.assert_allclose(large_monopolar(steady, 500.0, neighbours), 0, atol=1e-12)
    kept = large_monopolar(steady, 500.0, neighbours, strength=0.8)
    np.testing.assert_allclose(kept, 0.2 * 0.7)


def test_edges_see_an_even_field_like_the_middle():
    _, _, neighbours = torus()
    with_edges = np.where(np.random.default_rng(0).random(neighbours.shape) < 0.3, -1, neighbours)
    flicker = np.random.default_rng(1).random((60, 1)) * np.ones(SIZE * SIZE)
    np.testing.assert_allclose(
        large_monopolar(flicker, 500.0, with_edges), large_monopolar(flicker, 500.0, neighbours)
    )


def test_a_flash_is_answered_in_two_phases():
    """And by neighbours with the second only."""
    _, _, neighbours = torus()
    flash = np.zeros((120, SIZE * SIZE))
    flash[10, 0] = 1
    answer = large_monopolar(flash, 1000.0, neighbours, 0.1)
    assert 18 <= np.argmax(answer[:, 0]) <= 21
    assert 25 <= np.argmin(answer[:, 0]) <= 33
    assert np.min(answer[:, 0]) < -0.15 * np.max(answer[:, 0])
    for near in neighbours[0]:
        assert np.max(answer[:, near]) < 1e-12
        assert np.argmin(answer[:, near]) == pytest.approx(26, abs=1)
    assert np.count_nonzero(np.any(answer != 0, axis=0)) == 7
    # Bands and other axes go along.
    both = large_monopolar(np.stack([flash, 2 * flash], axis=-1), 1000.0, neighbours, 0.1)
    np.testing.assert_allclose(both[..., 1], 2 * answer, atol=1e-15)


def test_neighbours_of_an_eye():
    eye = omma.eye.generate_eye(200)
    lattice = omma.eye.hexagonal_coordinates(eye)
    seen = np.random.default_rng(0).random((20, 200))
    assert large_monopolar(seen, 500.0, lattice.neighbours).shape == (20, 200)


RATE_HZ = 1000.0


def stepped(ratio, frames=1000):
    light = np.full((frames, 1), 99.0)
    light[100:] = 100 * ratio - 1
    return light


def test_a_step_of_light_turns_there_and_back():
    """By a triangle: from 8 ms to 108 ms up, to 608 ms down."""
    angle = microsaccades_rad(stepped(10.0), RATE_HZ, dark=1.0)[:, 0]
    times = (np.arange(1000) - 99.5) / RATE_HZ  # the step is a straight line over an interval
    expected = np.interp(times, [0.008, 0.108, 0.608], [0, 1, 0], left=0, right=0)
    # The step is smeared over a millisecond, which rounds the triangle's corners.
    np.testing.assert_allclose(np.degrees(angle), expected, atol=2e-3)


def test_microsaccades_go_with_the_logarithm_of_light():
    small, large, darker = (
        microsaccades_rad(stepped(ratio), RATE_HZ, dark=1.0)[:, 0] for ratio in (10, 100, 0.1)
    )
    np.testing.assert_allclose(large, 2 * small, atol=1e-12)
    np.testing.assert_allclose(darker, -small, atol=1e-12)
    widest = microsaccades_rad(stepped(1e9), RATE_HZ, dark=1.0)
    assert np.max(widest) == np.radians(4.0)
    assert np.all(microsaccades_rad(stepped(10.0), RATE_HZ, dark=1.0, decade_rad=0.0) == 0)
    steady = microsaccades_rad(np.full((50, 3), 7.0), RATE_HZ, dark=1.0)
    np.testing.assert_allclose(steady, 0, atol=1e-12)


def test_axes_are_turned_towards_where_they_should():
    eye = omma.eye.generate_eye(150)
    angles = np.linspace(-0.1, 0.1, 150)
    for towards, vectors in ((0.0, eye.up), (np.pi / 2, eye.right)):
        turned = displace_axes(eye.axis, eye.up, angles, towards)
        np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1)
        # Axes are in single precision.
        np.testing.assert_allclose(np.sum(turned * vectors, axis=1), np.sin(angles), atol=1e-6)
        np.testing.assert_allclose(np.sum(turned * eye.axis, axis=1), np.cos(angles), atol=1e-6)
    frames = displace_axes(eye.axis, eye.up, np.stack([angles, -angles]), np.full(150, 0.3))
    assert frames.shape == (2, 150, 3)
    moved = eye.replace(axis=frames[0])
    np.testing.assert_allclose(moved.axis, frames[0], atol=1e-6)


def test_published_responses():
    for name, width_ms in (("green", 7.9), ("blue", 9.8), ("ultraviolet", 12.3)):
        found = published_response(f"bumblebee {name}")
        assert found.full_width_s * 1e3 == pytest.approx(width_ms)
    blowfly = published_response("blowfly")
    f = np.array([3.0, 30.0, 90.0])
    w = 2j * np.pi * f * 1e-3
    expected = np.exp(-w) / (1 + 1.69 * w) ** 3 / (1 + 0.535 * w) ** 12
    # Straight lines between knots of 0.1 ms.
    np.testing.assert_allclose(blowfly.transfer(f), expected, atol=2e-4)
    with pytest.raises(omma.Error, match="name: expected one of bumblebee green"):
        published_response("honeybee")


FOUR = np.zeros((3, 4))
ROWS = np.full((4, 6), -1)
ALONG, UPWARDS = np.array([[0, 0, -1.0]]), np.array([[0, 1.0, 0]])
BAD = [
    (lambda: large_monopolar(np.zeros(4), 100.0, ROWS), "signals: expected shape"),
    (lambda: large_monopolar(FOUR, 100.0, ROWS[:3]), "neighbours: expected one row for each of 4"),
    (lambda: large_monopolar(FOUR, 100.0, ROWS + 5), "neighbours: expected -1 to 3, found 4"),
    (lambda: large_monopolar(FOUR, 100.0, ROWS - 1), "neighbours: expected -1 to 3, found -2"),
    (lambda: large_monopolar(FOUR, 100.0, ROWS, [0.1, 0.2]), "weights: expected a number or 6"),
    (lambda: large_monopolar(FOUR, 100.0, ROWS, 0.2), "weights: .* together at most 1"),
    (lambda: large_monopolar(FOUR, 100.0, ROWS, -0.1), "weights: expected numbers from 0 on"),
    (lambda: large_monopolar(FOUR, 100.0, ROWS, strength=-1.0), "strength: expected 0 to"),
    (lambda: large_monopolar(FOUR + np.nan, 100.0, ROWS), "signals: expected finite"),
    (lambda: microsaccades_rad([[-1.0]], 100.0, dark=1.0), "light: expected"),
    (lambda: microsaccades_rad([[1.0]], 100.0, dark=0.0), "dark: expected a number above 0"),
    (lambda: microsaccades_rad([[1.0]], 100.0, dark=1.0, rise_s=0.0), "rise_s: expected a number"),
    (lambda: microsaccades_rad([[1.0]], 100.0, dark=1.0, latency_s=-1.0), "latency_s: expected 0"),
    (lambda: microsaccades_rad([[1.0]], 100.0, dark=1.0, largest_rad=9.0), "largest_rad: expected"),
    (lambda: microsaccades_rad(1.0, 100.0, dark=1.0), "light: expected frames"),
    (lambda: displace_axes(2 * ALONG, UPWARDS, [0.1], 0), "axis: expected vectors of length 1"),
    (lambda: displace_axes(ALONG, ALONG, [0.1], 0), "up: expected vectors across the axes"),
    (lambda: displace_axes(ALONG, UPWARDS[:0], [0.1], 0), "up: expected 1 vectors as axis has"),
    (lambda: displace_axes(ALONG, UPWARDS, [0.1, 0.2], 0), "angle_rad: expected shape"),
    (lambda: displace_axes(ALONG, UPWARDS, [0.1], [0, 1]), "towards_rad: expected a number or"),
    (lambda: displace_axes(ALONG, UPWARDS, [np.nan], 0), "angle_rad: expected finite"),
]


@pytest.mark.parametrize(("call", "message"), BAD)
def test_bad_calls(call, message):
    with pytest.raises(omma.Error, match=message):
        call()
