"""A head that turns in a drum of stripes, rendered frame by frame and filtered: amplitude and phase
are those of the acceptance and of the impulse response.
"""

import numpy as np
import pytest

import omma
from omma.photoreceptors import ImpulseResponse, filter_frames, published_response

WIDTH_DEG, CONTRAST = 4.0, 0.8
# So many that straight lines between frames take away 0.2 % (π²/3n²).
FRAMES_A_PERIOD = 40


def answer(cycles, frequency_hz, h):
    """The response's phasor around a mean of 1, of a grating of so many cycles around that passes
    at this frequency.
    """
    azimuth = (np.arange(4096) + 0.5) / 4096 * 2 * np.pi
    stripes = np.repeat(1 + CONTRAST * np.cos(cycles * azimuth), 3).reshape(1, -1, 3)
    drum = omma.Scene(background=omma.Background.image(np.tile(stripes, (8, 1, 1)).astype("f4")))
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], np.radians(WIDTH_DEG))
    renderer = omma.Renderer(drum, eye, omma.Fixed(4096), footprints=False)
    rate_hz = FRAMES_A_PERIOD * frequency_hz
    count = int(np.ceil(1.5 * h.duration_s * rate_hz)) + FRAMES_A_PERIOD
    phase = 2 * np.pi * frequency_hz * np.arange(count) / rate_hz
    turned = phase / cycles
    poses = [omma.look_at((0, 0, 0), (np.sin(a), 0, -np.cos(a))) for a in turned]
    light = renderer.render(np.stack(poses))[:, 0, 0]
    filtered = filter_frames(light, rate_hz, h)[-FRAMES_A_PERIOD:]
    assert np.mean(filtered) == pytest.approx(1, abs=1e-3)
    start = np.exp(1j * np.pi * cycles)  # straight ahead is the middle of the picture
    return 2 * np.mean(filtered * np.exp(-1j * phase[-FRAMES_A_PERIOD:])) * start


@pytest.mark.parametrize("frequency_hz", [1.0, 5.0, 15.0, 40.0, 90.0])
@pytest.mark.parametrize("cycles", [9, 20, 40, 60])
def test_drifting_gratings(cycles, frequency_hz):
    h = ImpulseResponse.howard(0.010, 0.3)
    found = answer(cycles, frequency_hz, h)
    seen = CONTRAST * np.exp(-3.5597 * (cycles / 360) ** 2 * WIDTH_DEG**2)
    kept = h.transfer(frequency_hz)
    assert abs(found) == pytest.approx(seen * abs(kept), abs=0.005)
    # Where a thousandth of the mean is left, the phase is that of noise.
    if seen * abs(kept) > 0.02:
        assert abs(np.angle(found / kept, deg=True)) < 1


def test_a_blowfly_and_a_measured_response():
    measured = ImpulseResponse.table([0, 0.004, 0.008, 0.015, 0.02, 0.04], [0, 3, 1, -0.7, -0.3, 0])
    for h in (published_response("blowfly"), measured):
        found, kept = answer(20, 25.0, h), h.transfer(25.0)
        seen = CONTRAST * np.exp(-3.5597 * (20 / 360) ** 2 * WIDTH_DEG**2)
        assert abs(found) == pytest.approx(seen * abs(kept), abs=0.005)
        assert abs(np.angle(found / kept, deg=True)) < 1
