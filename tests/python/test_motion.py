"""Motion detectors on signals whose answers are known in closed form."""

import itertools
import math

import numpy as np
import pytest

import omma

TAU_S = 0.035  # of the delay
SLOW_S = 0.15  # of the high-pass
STEP_RAD = math.radians(4.0)


def row(count, step_rad=STEP_RAD):
    """Ommatidia along the horizon, each a step to the right of the one before."""
    return omma.Eye(
        np.zeros((count, 3)), omma.eye.direction(np.degrees(step_rad) * np.arange(count), 0), 0.01
    )


def detectors_of(frame_rate_hz, high_pass_tau_s=None, tau_s=TAU_S, step_rad=STEP_RAD):
    """One detector between two ommatidia, preferring motion to the right."""
    return omma.motion.detector_array(
        row(2, step_rad), tau_s, frame_rate_hz, pairs=[[0, 1]], high_pass_tau_s=high_pass_tau_s
    )


def mean_output(
    wavelength_rad, frequency_hz, *, contrast=0.8, mean=1.0, high_pass_tau_s=None, frames=64
):
    """The mean over some periods that end in the steady state, of ``frames`` frames each."""
    rate = frames * abs(frequency_hz)
    detectors = detectors_of(rate, high_pass_tau_s)
    # What is left of the beginning falls below exp(-36).
    settling = math.ceil(36 * max(TAU_S, high_pass_tau_s or 0) * rate / frames)
    time_s = np.arange((settling + 2) * frames) / rate
    phase = math.tau * np.array([0.0, STEP_RAD]) / wavelength_rad
    turned = math.tau * frequency_hz * time_s[:, None] - phase
    outputs = detectors.run(mean * (1 + contrast * np.cos(turned)))
    return outputs[-2 * frames :].mean(), rate


WAVELENGTHS_RAD = STEP_RAD * np.array([1.4, 2.7, 4.0, 10.0])
FREQUENCIES_HZ = np.array([0.7, 3.0, 4.5, 12.0])


@pytest.mark.parametrize("high_pass_tau_s", [None, SLOW_S, TAU_S])
def test_gratings_as_in_the_closed_form(high_pass_tau_s):
    for wavelength, frequency in itertools.product(WAVELENGTHS_RAD, FREQUENCIES_HZ):
        found, rate = mean_output(wavelength, frequency, high_pass_tau_s=high_pass_tau_s)
        numbers = (0.8, wavelength, frequency, STEP_RAD, TAU_S)
        sampled = omma.motion.grating_response(
            *numbers, high_pass_tau_s=high_pass_tau_s, frame_rate_hz=rate
        )
        # The same arithmetic in another order: what is left is rounding, of sums of 64 terms.
        assert found == pytest.approx(float(sampled), rel=1e-11, abs=1e-13)
        # Straight lines through a sine of ω take a share x = (ω dt)²/12 from its quarter turn in
        # the delay; with the high-pass x (1 + 1/(ω²ττ_H)), as less of a slow sine is left.
        continuous = omma.motion.grating_response(*numbers, high_pass_tau_s=high_pass_tau_s)
        missed = (math.tau / 64) ** 2 / 12
        if high_pass_tau_s is not None:
            missed *= 1 + 1 / ((math.tau * frequency) ** 2 * TAU_S * high_pass_tau_s)
        # 5 % of it for what comes after the square.
        assert found == pytest.approx(float(continuous), rel=1.05 * missed)


def test_the_formula_by_hand():
    wavelength, frequency = math.radians(20), 3.0
    turned = math.tau * frequency * TAU_S
    by_hand = 2.0**2 * 0.5**2 * math.sin(math.tau * 4 / 20) * turned / (1 + turned**2)
    by_hand *= math.exp(-3.5597 * (math.radians(5) / wavelength) ** 2) ** 2
    found = omma.motion.grating_response(
        0.5, wavelength, frequency, STEP_RAD, TAU_S, mean=2.0,
        acceptance_angle_rad=math.radians(5),
    )  # fmt: skip
    assert found == pytest.approx(by_hand, rel=1e-5)  # 3.5597 has so many digits
    slow = math.tau * frequency * SLOW_S
    also = omma.motion.grating_response(
        0.5, wavelength, frequency, STEP_RAD, TAU_S, mean=2.0,
        acceptance_angle_rad=math.radians(5), high_pass_tau_s=SLOW_S,
    )  # fmt: skip
    assert also == pytest.approx(found * slow**2 / (1 + slow**2), rel=1e-12)


@pytest.mark.parametrize("high_pass_tau_s", [None, SLOW_S])
def test_the_optimum_is_a_temporal_frequency_and_no_velocity(high_pass_tau_s):
    best = omma.motion.best_frequency_hz(TAU_S, high_pass_tau_s)
    if high_pass_tau_s is None:
        assert best == pytest.approx(1 / (math.tau * TAU_S), rel=1e-12)
    found = []
    for wavelength in (3 * STEP_RAD, 6 * STEP_RAD, 15 * STEP_RAD):
        frequencies = best * np.array([0.9, 1.0, 1.1])
        outputs = [
            mean_output(wavelength, f, high_pass_tau_s=high_pass_tau_s)[0] for f in frequencies
        ]
        # The top of the parabola in log f; the curve is even around it to third order.
        a, b, _ = np.polyfit(np.log(frequencies), outputs, 2)
        found.append(math.exp(-b / (2 * a)))
    # The parabola's own error: its fourth order, (0.1)² of the width.
    assert found == pytest.approx([best] * 3, rel=0.01)
    velocities = np.array(found) * np.array([3, 6, 15])
    assert velocities[2] / velocities[0] == pytest.approx(5, rel=0.01)


def test_the_best_frequency_is_the_top_of_the_closed_form():
    for slow in (1e-4, 0.01, TAU_S, 1.0, 5.0):
        best = omma.motion.best_frequency_hz(TAU_S, slow)
        below, top, above = omma.motion.grating_response(
            1.0, 1.0, best * np.array([0.99, 1, 1.01]), 0.25, TAU_S, high_pass_tau_s=slow
        )
        assert top > max(below, above)
        assert below == pytest.approx(above, rel=1e-5)  # even around the top to third order


def test_over_wavelength_a_sine_that_changes_sign_where_it_aliases():
    wavelengths = STEP_RAD * np.array([1.05, 1.3, 1.7, 1.95, 2.05, 2.6, 4.0, 8.0, 40.0])
    outputs = np.array([mean_output(w, 4.0)[0] for w in wavelengths])
    expected = np.sin(math.tau * STEP_RAD / wavelengths)
    # Only the wavelength differs, so that all else goes out, up to rounding.
    assert outputs / outputs[6] == pytest.approx(expected / expected[6], rel=1e-10)
    assert (outputs[:4] < 0).all()
    assert (outputs[4:] > 0).all()
    top = abs(outputs).max()
    for aliased in (1.0, 2.0):
        assert abs(mean_output(aliased * STEP_RAD, 4.0)[0]) < 1e-12 * top  # sin of whole π


def test_contrast_and_light_count_squared_and_direction_as_sign():
    whole = mean_output(10 * STEP_RAD, 4.0, contrast=1.0)[0]
    for contrast in (0.05, 0.3, 0.7):
        assert mean_output(10 * STEP_RAD, 4.0, contrast=contrast)[0] == pytest.approx(
            contrast**2 * whole, rel=1e-10
        )
    assert mean_output(10 * STEP_RAD, 4.0, contrast=1.0, mean=3.0)[0] == pytest.approx(
        9 * whole, rel=1e-10
    )
    assert mean_output(10 * STEP_RAD, -4.0, contrast=1.0)[0] == pytest.approx(-whole, rel=1e-10)


def polyline(time_s, corners_s, heights, ramp):
    """The answer to straight lines between corners, flat before, from that to a ramp from 0 on."""
    rises = np.diff(heights) / np.diff(corners_s)
    changes = np.diff(np.concatenate([[0.0], rises]))
    since = np.maximum(time_s[:, None] - corners_s[:-1], 0)
    return (changes * ramp(since)).sum(axis=1)


@pytest.mark.parametrize("frames_per_tau", [0.3, 1.0, 7.0])
def test_filters_are_exact_for_straight_lines(frames_per_tau):
    random = np.random.default_rng(1)
    rate = frames_per_tau / TAU_S
    heights = random.normal(size=40)
    time_s = np.arange(40) / rate

    def late(high_pass_tau_s):
        detectors = detectors_of(rate, high_pass_tau_s)
        state, found = None, []
        for height in heights:
            state, _ = detectors.step(state, [height, 0.0])
            found.append((state.late[0], state.frame[0] - state.slow[0]))
        return np.array(found).T

    def low(t):
        return t - TAU_S * (1 - np.exp(-t / TAU_S))

    def band(t):
        fall = TAU_S * np.exp(-t / TAU_S) - SLOW_S * np.exp(-t / SLOW_S)
        return SLOW_S * (1 - fall / (TAU_S - SLOW_S))

    def band_of_one(t):
        return TAU_S * (1 - (1 + t / TAU_S) * np.exp(-t / TAU_S))

    def high(t):
        return SLOW_S * (1 - np.exp(-t / SLOW_S))

    # Sums of 40 numbers around 1: rounding.
    found, direct = late(None)
    expected = heights[0] + polyline(time_s, time_s, heights, low)
    assert found == pytest.approx(expected, abs=1e-12)
    assert (direct == heights).all()
    found, direct = late(SLOW_S)
    assert found == pytest.approx(polyline(time_s, time_s, heights, band), abs=1e-12)
    assert direct == pytest.approx(polyline(time_s, time_s, heights, high), abs=1e-12)
    found, _ = late(TAU_S)
    assert found == pytest.approx(polyline(time_s, time_s, heights, band_of_one), abs=1e-12)


@pytest.fixture(scope="module")
def eye():
    return omma.eye.generate_eye(300, radius_m=1e-3)


@pytest.fixture(scope="module")
def signals(eye):
    return np.random.default_rng(2).random((12, len(eye), 3)).astype(np.float32)


@pytest.mark.parametrize("high_pass_tau_s", [None, SLOW_S])
def test_frame_by_frame_and_at_once_are_the_same_bits(eye, signals, high_pass_tau_s):
    detectors = omma.motion.detector_array(eye, TAU_S, 200, high_pass_tau_s=high_pass_tau_s)
    outputs = detectors.run(signals)
    assert outputs.shape == (12, len(detectors), 3)
    vectors = detectors.vectors(outputs, axis=-2)
    assert vectors.shape == (12, len(eye), 3, 2)
    state, kept = None, np.empty_like(signals[0])
    for t, frame in enumerate(signals):
        kept[:] = frame  # as a renderer writes into one array again and again
        state, one = detectors.step(state, kept)
        assert (one == outputs[t]).all()
        assert np.array_equal(detectors.vectors(one, axis=-2), vectors[t], equal_nan=True)
    # And each band is what it is alone.
    alone = detectors.run(signals[:, :, 1])
    assert (alone == outputs[:, :, 1]).all()
    assert np.array_equal(detectors.vectors(alone), vectors[:, :, 1], equal_nan=True)


@pytest.mark.parametrize("high_pass_tau_s", [None, SLOW_S])
def test_what_stands_still_answers_nothing_to_the_bit(eye, signals, high_pass_tau_s):
    detectors = omma.motion.detector_array(eye, TAU_S, 200, high_pass_tau_s=high_pass_tau_s)
    assert not detectors.run(np.repeat(signals[:1], 50, axis=0)).any()


def test_nothing_moves_at_first_and_pairs_turned_round_answer_the_negative(eye, signals):
    pairs = omma.motion.neighbour_pairs(eye)
    there, back = (
        omma.motion.detector_array(eye, TAU_S, 200, pairs=one, high_pass_tau_s=SLOW_S)
        for one in (pairs, pairs[:, ::-1])
    )
    outputs = there.run(signals[:, :, 0])
    assert not outputs[0].any()
    assert outputs[1:].any(axis=1).all()
    assert (back.run(signals[:, :, 0]) == -outputs).all()
    one, other = (array.vectors(array.run(signals[:, :, 0])) for array in (there, back))
    # Turned round twice; the sums run over the same numbers in another order.
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)


def test_pairs_lead_along_rows(eye):
    neighbours = omma.eye.hexagonal_coordinates(eye).neighbours
    for column, row_name in enumerate(omma.eye.hexagonal.DIRECTIONS):
        pairs = omma.motion.neighbour_pairs(eye, [row_name])
        assert (neighbours[pairs[:, 0], column] == pairs[:, 1]).all()
    every = omma.motion.neighbour_pairs(eye)
    assert len(np.unique(np.sort(every, axis=1), axis=0)) == len(every)
    assert len(every) == (neighbours >= 0).sum() / 2


def test_vectors_point_where_gratings_drift(eye):
    """A grating with the wave vector k (3,), seen in the direction a with the phase k·a, drifts at
    a along the part of k that is across a."""
    axis, right, up = (np.asarray(v, float) for v in (eye.axis, eye.right, eye.up))
    spacing = float(np.median(eye.interommatidial_angle_rad()))
    frames, frequency = 64, 4.0
    rate = frames * frequency
    detectors = omma.motion.detector_array(eye, TAU_S, rate)
    six = np.bincount(detectors.pairs.ravel(), minlength=len(eye)) == 6
    settled = 6 * frames  # exp(-1.5 s / 35 ms) is nothing
    time_s = np.arange(settled + frames) / rate
    for wave in np.random.default_rng(3).normal(size=(3, 3)):
        # 40 ommatidia a period where k lies across the axis: sine and angle differ by 0.5 %.
        wave *= math.tau / (40 * spacing) / np.linalg.norm(wave)
        seen = 1 + 0.5 * np.cos(math.tau * frequency * time_s[:, None] - axis @ wave)
        outputs = detectors.run(seen)[-frames:].mean(axis=0)
        found = detectors.vectors(outputs)
        drift = np.stack([right @ wave, up @ wave], axis=1)
        # Those with all six: at a border the phase's bend between neighbours does not cancel.
        known = six & (np.hypot(*drift.T) > 0.5 * np.linalg.norm(wave))
        assert known.sum() > 80
        off = np.angle((found[known] @ [1, 1j]) / (drift[known] @ [1, 1j]), deg=True)
        # What is left of the bend where opposite neighbours are at different distances, which are
        # 0.22 rad: up to a fifth of it.
        assert np.median(np.abs(off)) < 0.5
        assert np.abs(off).max() < 5
        # Its length is the output of a detector along the drift at the mean distance.
        length = np.hypot(*found[known].T)
        pairs = detectors.pairs[np.isin(detectors.pairs[:, 0], np.flatnonzero(known))]
        distance = np.arccos((axis[pairs[:, 0]] * axis[pairs[:, 1]]).sum(axis=1)).mean()
        along = np.hypot(*drift[known].T)
        expected = omma.motion.grating_response(0.5, math.tau / along, frequency, distance, TAU_S)
        # Neighbours' distances differ by a tenth around their mean.
        assert np.median(length / expected) == pytest.approx(1, abs=0.03)


def test_vectors_are_not_known_where_all_pairs_lie_in_a_line():
    ommatidia = row(4)
    detectors = omma.motion.detector_array(ommatidia, TAU_S, 100, pairs=[[0, 1], [1, 2]])
    assert np.isnan(detectors.vectors([1.0, 1.0])).all()
    # Two across each other at the first, in degrees to the right and up.
    corner = omma.Eye(np.zeros((3, 3)), omma.eye.direction([0, 4, 0], [0, 0, 4]), 0.01)
    detectors = omma.motion.detector_array(corner, TAU_S, 100, pairs=[[0, 1], [2, 0]])
    assert detectors.displacement_rad[0, 0] == pytest.approx([STEP_RAD, 0], abs=1e-7)  # float32
    assert detectors.displacement_rad[1, 0] == pytest.approx([0, -STEP_RAD], abs=1e-7)
    found = detectors.vectors([3.0, 5.0])
    assert found[0] == pytest.approx([3, -5], abs=1e-5)
    assert np.isnan(found[1:]).all()


def test_vectors_are_of_what_step_and_run_give():
    """Of one environment or of many, as of each by itself."""
    detectors = omma.motion.detector_array(omma.eye.generate_eye(60), TAU_S, 100)
    frames = np.random.default_rng(5).uniform(size=(7, 60, 3))
    outputs = detectors.run(frames)
    found = detectors.vectors(outputs)
    assert found.shape == (7, 60, 3, 2)
    for k in range(3):
        alone = detectors.vectors(detectors.run(frames[..., k]))
        assert np.array_equal(alone, found[:, :, k], equal_nan=True)
    assert np.array_equal(detectors.vectors(outputs[-1]), found[-1], equal_nan=True)
    square = np.ones((len(detectors), len(detectors)))
    with pytest.raises(omma.Error, match=r"axis: expected -1 or -2.*both are so long, found None"):
        detectors.vectors(square)
    assert detectors.vectors(square, axis=-2).shape == (60, len(detectors), 2)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"tau_s": 0}, "tau_s: expected a number above 0"),
        ({"tau_s": 1e-9}, "tau_s: expected 0.0001 to 1e.06 frames of 1/100 s, found 1e-07"),
        ({"frame_rate_hz": float("nan")}, "frame_rate_hz: expected a number above 0"),
        ({"high_pass_tau_s": -1.0}, "high_pass_tau_s: expected a number above 0"),
        ({"pairs": [[0, 4]]}, r"pairs: expected ommatidia from 0 to 3, found \[0, 4\]"),
        ({"pairs": [[1, 2], [1, 1]]}, r"pairs: expected two ommatidia, found \[1, 1\]"),
        ({"pairs": np.empty((0, 2))}, "pairs: expected at least one, found none"),
        ({"pairs": [0, 1]}, r"pairs: expected shape \(N, 2\), found \(2,\)"),
        ({"pairs": None}, "eye: its lattice by surface has no rows"),
    ],
)
def test_what_is_no_array_of_detectors(changed, message):
    arguments = {"eye": row(4), "tau_s": TAU_S, "frame_rate_hz": 100, "pairs": [[0, 1]]}
    with pytest.raises(omma.Error, match=message):
        omma.motion.detector_array(**(arguments | changed))


def test_what_are_no_frames():
    detectors = omma.motion.detector_array(row(4), TAU_S, 100, pairs=[[0, 1]])
    with pytest.raises(omma.Error, match=r"frame: expected shape \(4,\) or \(4, B\), found \(5,\)"):
        detectors.step(None, np.ones(5))
    with pytest.raises(omma.Error, match="frame: expected finite numbers"):
        detectors.step(None, [1, 2, np.nan, 4])
    state, _ = detectors.step(None, np.ones(4))
    with pytest.raises(omma.Error, match=r"expected shape \(4,\) as before, found \(4, 3\)"):
        detectors.step(state, np.ones((4, 3)))
    with pytest.raises(omma.Error, match=r"responses: expected shape \(T, 4\) or"):
        detectors.run(np.ones(4))
    with pytest.raises(omma.Error, match="outputs: expected 1 along axis -1, found 2"):
        detectors.vectors(np.ones(2), axis=-1)
    with pytest.raises(omma.Error, match=r"expected 1 detectors along the .*shape \(1, 2, 2\)"):
        detectors.vectors(np.ones((1, 2, 2)))
    with pytest.raises(TypeError, match=r"state: expected omma\.motion\.DetectorState"):
        detectors.step("the last one", np.ones(4))
    assert detectors.run(np.ones((0, 4))).shape == (0, 1)


@pytest.mark.parametrize("other", [(0.05, 100, None), (TAU_S, 200, None), (TAU_S, 100, 0.25)])
def test_the_state_of_other_detectors_is_refused(other):
    """Its filters would go on from what others remember."""
    own = omma.motion.detector_array(row(4), TAU_S, 100, pairs=[[0, 1]])
    tau_s, rate_hz, high_s = other
    others = omma.motion.detector_array(
        row(4), tau_s, rate_hz, pairs=[[0, 1]], high_pass_tau_s=high_s
    )
    state, _ = others.step(None, np.ones(4))
    state, _ = others.step(state, np.arange(4.0))
    with pytest.raises(omma.Error, match=rf"state: expected .*{TAU_S}.*100.*found .*{tau_s}"):
        own.step(state, np.ones(4))
    # Of other pairs of the same ommatidia it is what these would remember.
    pairs = omma.motion.detector_array(
        row(4), tau_s, rate_hz, pairs=[[2, 3]], high_pass_tau_s=high_s
    )
    assert pairs.step(state, np.ones(4))[0] == others.step(state, np.ones(4))[0]
    plain = omma.motion.DetectorState(state.frame, state.slow, state.late)
    assert own.step(plain, np.ones(4))[1].shape == (1,)


def test_what_are_no_gratings():
    with pytest.raises(omma.Error, match="wavelength_rad: expected numbers above 0, found 0"):
        omma.motion.grating_response(1, [0.1, 0], 1, 0.1, TAU_S)
    for contrast in (50, [0.5, -0.1]):
        with pytest.raises(omma.Error, match=r"contrast: expected 0 to 1 \(not per cent\), found"):
            omma.motion.grating_response(contrast, 0.1, 1, 0.1, TAU_S)
    with pytest.raises(omma.Error, match="frequency_hz: expected numbers, found nan"):
        omma.motion.grating_response(1, 0.1, [1, np.nan], 0.1, TAU_S)
    with pytest.raises(omma.Error, match="separation_rad: expected numbers, found nan"):
        omma.motion.grating_response(1, 0.1, 1, np.nan, TAU_S)
    with pytest.raises(omma.Error, match="mean: expected a number above 0, to which the contrast"):
        omma.motion.grating_response(1, 0.1, 1, 0.1, TAU_S, mean=0)
    with pytest.raises(omma.Error, match=r"mean: expected 0 to 1e\+150, found -1"):
        omma.motion.grating_response(1, 0.1, 1, 0.1, TAU_S, mean=-1)
    with pytest.raises(omma.Error, match="tau_s: expected a number above 0"):
        omma.motion.best_frequency_hz(0)
    with pytest.raises(omma.Error, match="rows: expected one of v, q, -p, -v, -q, p, found 'h'"):
        omma.motion.neighbour_pairs(omma.eye.generate_eye(100), ["h"])
