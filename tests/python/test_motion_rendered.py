"""Motion detectors behind a renderer: a fly's row of ommatidia in the middle of a turning drum."""

import math

import numpy as np
import pytest

import omma

STEP_DEG, WIDTH_DEG = 4.0, 3.0  # between ommatidia; Δρ
TAU_S = 0.035
FRAMES = 64  # a period
CONTRAST, MEAN = 0.8, 0.5


@pytest.fixture(scope="module")
def row():
    """Twelve Gaussian ommatidia along the horizon, to the right."""
    azimuth = STEP_DEG * (np.arange(12) - 5.5)
    return omma.Eye(np.zeros((12, 3)), omma.eye.direction(azimuth, 0), np.radians(WIDTH_DEG))


def turned(azimuth_deg):
    """``world_from_node`` of things turned to the right about the vertical through the origin."""
    angle = math.radians(azimuth_deg)
    matrix = np.eye(4)
    matrix[0, [0, 2]] = math.cos(angle), -math.sin(angle)
    matrix[2, [0, 2]] = math.sin(angle), math.cos(angle)
    return matrix


def grating_drum(periods, contrast=CONTRAST):
    sine = np.sin(math.tau * (np.arange(512) + 0.5) / 512)
    picture = np.repeat(MEAN * (1 + contrast * sine)[None, :, None], 3, axis=2)
    return omma.scene.drum(1.0, 4.0, picture.astype(np.float32), repeats=periods)


@pytest.fixture(scope="module")
def one_period(row):
    """Renders, once each, a period of a drum with so many periods of a sine: (FRAMES, 12)."""
    made = {}

    def render(periods, contrast=CONTRAST):
        if (periods, contrast) not in made:
            renderer = omma.Renderer(grating_drum(periods, contrast), row, omma.Fixed(256))
            frames = np.empty((FRAMES, 12), np.float32)
            for t in range(FRAMES):
                renderer.world.set_transforms("drum", turned(360 / periods * t / FRAMES))
                frames[t] = renderer.render(np.eye(4))[0, :, 1]
            made[periods, contrast] = frames
        return made[periods, contrast]

    return render


def mean_output(row, frames, frequency_hz):
    """The mean over a period, in the steady state, of the eleven detectors along the row."""
    rate = FRAMES * frequency_hz
    pairs = np.stack([np.arange(11), np.arange(1, 12)], axis=1)
    detectors = omma.motion.detector_array(row, TAU_S, rate, pairs=pairs)
    # Frames come again each period; what is left of the beginning falls below exp(-12).
    periods = math.ceil(12 * TAU_S * frequency_hz) + 1
    return detectors.run(np.tile(frames, (periods, 1)))[-FRAMES:].mean()


def closed_form(periods, frequency_hz, contrast=CONTRAST):
    return float(
        omma.motion.grating_response(
            contrast, math.tau / periods, frequency_hz, math.radians(STEP_DEG), TAU_S, mean=MEAN,
            acceptance_angle_rad=math.radians(WIDTH_DEG), frame_rate_hz=FRAMES * frequency_hz,
        )
    )  # fmt: skip


# 256 rays estimate a response, and so the modulation transfer, to 0.003; its square to twice that,
# times the rest of the formula at its largest, 1/2 where ωτ is 1.
TOLERANCE = 2 * 0.003 * (CONTRAST * MEAN) ** 2 / 2


@pytest.mark.parametrize("periods", [9, 18, 30, 45, 60, 72, 90])
def test_a_drifting_grating_as_in_the_closed_form(row, one_period, periods):
    frequency = omma.motion.best_frequency_hz(TAU_S)
    found = mean_output(row, one_period(periods), frequency)
    assert found == pytest.approx(closed_form(periods, frequency), abs=TOLERANCE)
    wavelength_deg = 360 / periods
    if wavelength_deg in (STEP_DEG, 2 * STEP_DEG):
        assert abs(found) < TOLERANCE
    else:
        assert (found > TOLERANCE) == (wavelength_deg > 2 * STEP_DEG)
        assert (found < -TOLERANCE) == (wavelength_deg < 2 * STEP_DEG)


def test_the_optimum_is_a_temporal_frequency(row, one_period):
    best = omma.motion.best_frequency_hz(TAU_S)
    for periods in (9, 18, 30):
        frequencies = best * np.array([0.25, 0.5, 1, 2, 4])
        found = [mean_output(row, one_period(periods), f) for f in frequencies]
        expected = [closed_form(periods, f) for f in frequencies]
        # All of one curve share what the grating's modulation is off by.
        assert np.array(found) / found[2] == pytest.approx(np.array(expected) / expected[2], 0.002)
        assert np.argmax(found) == 2


def test_contrast_counts_squared(row, one_period):
    high, low = (mean_output(row, one_period(18, contrast), 4.0) for contrast in (0.8, 0.2))
    assert high / low == pytest.approx(16, rel=0.002)  # rays are the same, but for rounding


def test_it_drifts_the_other_way(row, one_period):
    there = mean_output(row, one_period(18), 4.0)
    back = mean_output(row, one_period(18)[::-1], 4.0)
    assert back == pytest.approx(-there, rel=1e-6)
