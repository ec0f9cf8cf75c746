"""ON and OFF events of responses over time: against the closed forms of ramps and sines in the
logarithm of light, against a slow reference, and what is refused."""

import warnings

import numpy as np
import pytest

import omma
from omma.photoreceptors import EVENT, EventSensor, event_counts

# Logarithms of exponentials of numbers around 1 are off by some 1e-16; times of ramps below are a
# few of them over slopes of about 1, added up over at most a hundred events.
ROUNDING = 1e-12


def exp_frames(signal):
    """Light whose logarithm is ``signal`` (T,), of one ommatidium."""
    return np.exp(np.asarray(signal, dtype=float))[:, None]


@pytest.mark.parametrize("slope", [0.7, 3.1, -0.7, -3.1])
@pytest.mark.parametrize("frames", [2, 7, 400])
def test_a_ramp_is_told_at_even_times(slope, frames):
    """L = s t: an event at every k C/|s|, whatever the frames are."""
    times = np.sort(np.random.default_rng(3).uniform(0, 4, frames))
    times[[0, -1]] = 0, 4
    sensor = EventSensor(0.13, 0.21)
    events = sensor.run(exp_frames(slope * times), times)
    threshold = 0.13 if slope > 0 else 0.21
    number = int(4 * abs(slope) / threshold)
    expected = threshold / abs(slope) * np.arange(1, number + 1)
    assert len(events) == number
    np.testing.assert_allclose(events["time_s"], expected, atol=ROUNDING)
    assert (events["polarity"] == np.sign(slope)).all()


@pytest.mark.parametrize("refractory", [1e-4, 0.03, 0.5])
@pytest.mark.parametrize("frames", [2, 9, 1000])
def test_a_receptor_in_reset_forgets_what_passes(refractory, frames):
    """Then what it compares with is the signal at the end of the reset: a ramp has an event every
    C/s + refractory time; over resets within a frame, and over many frames."""
    slope, threshold = 2.0, 0.3
    times = np.linspace(0, 5, frames)
    sensor = EventSensor(threshold, refractory_s=refractory)
    events = sensor.run(exp_frames(slope * times), times)
    period = threshold / slope + refractory
    expected = threshold / slope + period * np.arange(100)
    expected = expected[expected <= 5]
    np.testing.assert_allclose(events["time_s"], expected, atol=ROUNDING)


def sine_events(amplitude, frequency_hz, threshold, periods):
    """Times and polarities of events of A sin(2πft), from 0 on: closed form."""
    top = int(amplitude / threshold)  # the last level on the way up
    levels = threshold * np.arange(1, top + 1)
    rise = np.arcsin(levels / amplitude)
    # Down from the top level, where the last event was, to the lowest; up again from there.
    down = np.pi - np.arcsin(threshold * np.arange(top - 1, -top - 1, -1) / amplitude)
    up = 2 * np.pi + np.arcsin(threshold * np.arange(-top + 1, top + 1) / amplitude)
    phases, signs = [rise], [np.ones(top)]
    for k in range(periods):
        phases += [down + 2 * np.pi * k, up + 2 * np.pi * k]
        signs += [-np.ones(2 * top), np.ones(2 * top)]
    phase, sign = np.concatenate(phases), np.concatenate(signs)
    # Not the very end, where the last event of a period lies.
    kept = phase < 2 * np.pi * (periods - 0.01)
    return phase[kept] / (2 * np.pi * frequency_hz), sign[kept]


@pytest.mark.parametrize(("amplitude", "threshold"), [(1.0, 0.23), (0.5, 0.06), (2.3, 0.4)])
@pytest.mark.parametrize("frames", [97, 1000])
def test_a_sine_in_log_light(amplitude, threshold, frames):
    """As many events as the closed form has, at its times within what straight lines between
    frames are off."""
    frequency, periods = 3.0, 4
    times = np.arange(int(frames * (periods - 0.01)) + 1) / (frames * frequency)
    phase = 2 * np.pi * frequency * times
    events = EventSensor(threshold).run(exp_frames(amplitude * np.sin(phase)), times)
    expected, sign = sine_events(amplitude, frequency, threshold, periods)
    assert len(events) == len(expected)
    assert (events["polarity"] == sign).all()
    # A straight line is off by A (ω dt)²/8 at most, and crosses a level earlier or later by that
    # over the slope, which within an interval of the crossing is at least this.
    omega, interval = 2 * np.pi * frequency, 1 / (frames * frequency)
    slope = amplitude * omega * np.abs(np.cos(omega * expected)) - amplitude * omega**2 * interval
    assert (slope > 0).all()
    allowed = amplitude * (omega * interval) ** 2 / 8 / slope + ROUNDING
    assert (np.abs(events["time_s"] - expected) <= allowed).all()


def test_a_sine_in_reset():
    """On the first rise of A sin(ωt) each event follows from the one before: it is where the sine
    is a threshold above what it was when the reset ended."""
    amplitude, omega, threshold, refractory = 2.0, 4.0, 0.15, 0.01
    expected, reference = [], 0.0
    while reference + threshold < amplitude:
        expected.append(np.arcsin((reference + threshold) / amplitude) / omega)
        reference = amplitude * np.sin(omega * (expected[-1] + refractory))
    times = np.linspace(0, np.pi / 2 / omega, 4_001)
    sensor = EventSensor(threshold, refractory_s=refractory)
    events = sensor.run(exp_frames(amplitude * np.sin(omega * times)), times)
    assert len(events) == len(expected) > 8
    # Each straight line is off by A (ω dt)²/8, 4e-8; a level is met with the error of the one
    # before besides, over slopes from A ω, 8 a second, down to a third of that: for each of the 12
    # events 3e-8 s at most, and the same for the reference.
    np.testing.assert_allclose(events["time_s"], expected, atol=12 * 3e-8)


def slow_events(signal, times, on, off, refractory):
    """One receptor's events, one after another: (time, polarity)."""
    found, reference, ready = [], signal[0], -np.inf
    for t0, t1, a, b in zip(times[:-1], times[1:], signal[:-1], signal[1:]):
        at = t0
        while True:
            if ready >= t1:
                break
            if ready >= at:
                at, reference = ready, a + (b - a) * (ready - t0) / (t1 - t0)
            level = reference + on if b > a else reference - off
            if b == a or (level > b if b > a else level < b):
                break
            crossed = max(at, t0 + (level - a) / (b - a) * (t1 - t0))
            found.append((crossed, 1 if b > a else -1))
            if refractory == 0:
                reference = level
                at = crossed
            else:
                ready = crossed + refractory
                at = min(ready, t1)
                if ready < t1:
                    reference = a + (b - a) * (ready - t0) / (t1 - t0)
                    ready = np.nextafter(ready, -np.inf)  # it has been woken
    return found


@pytest.mark.parametrize("refractory", [0.0, 0.004, 0.07])
def test_as_a_slow_reference_finds_them(refractory):
    """Random walks of several receptors, with thresholds of their own."""
    random = np.random.default_rng(7)
    times = np.cumsum(random.uniform(0.001, 0.02, 200))
    signal = np.cumsum(random.normal(0, 0.3, (200, 5, 2)), axis=0)
    on, off = random.uniform(0.05, 0.3, (2, 5, 2))
    sensor = EventSensor(on, off, refractory_s=refractory, signal="linear")
    events = sensor.run(signal, times)
    assert (np.diff(events["time_s"]) >= 0).all()
    total = 0
    for i in range(5):
        for r in range(2):
            own = events[(events["ommatidium"] == i) & (events["receptor"] == r)]
            slow = slow_events(signal[:, i, r], times, on[i, r], off[i, r], refractory)
            total += len(slow)
            assert len(own) == len(slow)
            np.testing.assert_allclose(own["time_s"], [t for t, _ in slow], atol=1e-10)
            assert own["polarity"].tolist() == [p for _, p in slow]
            if refractory > 0:
                assert np.diff(own["time_s"]).min() >= refractory - ROUNDING
    assert total == len(events) > 200


def test_frame_by_frame_gives_the_same_bits():
    random = np.random.default_rng(1)
    light = np.exp(np.cumsum(random.normal(0, 0.2, (50, 6, 3)), axis=0)).astype(np.float32)
    times = 0.01 * np.arange(50)
    sensor = EventSensor(0.1, refractory_s=0.003, dark=0.01)
    state, found = None, []
    frame = np.empty((6, 3), np.float32)
    for one, at in zip(light, times):
        frame[...] = one  # a renderer's own buffer
        state, events = sensor.step(state, frame, at)
        found.append(events)
    assert (np.concatenate(found) == sensor.run(light, times)).all()
    assert len(found[0]) == 0


def test_what_is_kept_is_what_was_told():
    """Without a reset the signal is the first one and a threshold for each event, within one."""
    random = np.random.default_rng(2)
    signal = np.cumsum(random.normal(0, 0.5, (80, 40)), axis=0)
    sensor = EventSensor(0.25, 0.4, signal="linear")
    state = None
    told = signal[0].copy()
    for k, frame in enumerate(signal):
        state, events = sensor.step(state, frame, float(k))
        counts = event_counts(events, [k - 1, k], (40,))[0]
        told += 0.25 * counts[:, 0] - 0.4 * counts[:, 1]
        assert (told - frame < 0.4 + ROUNDING).all()
        assert (frame - told < 0.25 + ROUNDING).all()
    np.testing.assert_allclose(state.reference, told, atol=ROUNDING)


def test_darkness_is_told_down_to_dark():
    """ln(1 + c/dark) up to a constant, as `logarithmic` has it: light that goes out takes
    ln(1 + c/dark) / C events."""
    light = np.array([[1.0], [0.0]])
    for dark in (0.5, 0.01, 1e-6):
        sensor = EventSensor(0.1, dark=dark)
        number = int(omma.photoreceptors.logarithmic(1.0, dark) / 0.1)
        assert len(sensor.run(light, [0, 1])) == number


def test_counts_between_times():
    events = np.array([(0.5, 1, 0, 1), (1.0, 1, 0, 1), (1.5, 0, 0, -1), (9, 0, 0, 1)], EVENT)
    counts = event_counts(events, [0.0, 1.0, 2.0], (3,))
    assert counts.shape == (2, 3, 2)
    assert counts[0].tolist() == [[0, 0], [2, 0], [0, 0]]
    assert counts[1].tolist() == [[0, 1], [0, 0], [0, 0]]
    assert event_counts(events, [0.0, 1.0], (3, 2)).shape == (1, 3, 2, 2)
    assert event_counts(events[:0], [0.0, 1.0], (3,)).sum() == 0


def test_an_edge_that_passes_is_told_by_those_it_passes():
    """Behind a renderer: a drum that is bright on the right turns to the left, so that all that it
    newly shows is brighter."""
    half = np.repeat(np.array([[[0.1] * 3, [0.9] * 3]]), 180, axis=1).astype(np.float32)
    world = omma.World(omma.scene.drum(1.0, 9.0, half))
    eye = omma.Eye(np.zeros((9, 3)), omma.eye.direction(np.arange(-40, 50, 10), 0), 0.05)
    renderer = omma.Renderer(world, eye, omma.Fixed(64))
    times = np.linspace(0, 1, 41)
    turned = [omma.look_at((0, 0, 0), omma.eye.direction(a, 0)) for a in 70 * (times - 0.5)]
    data = renderer.dataset(np.stack(turned), time_s=times)
    sensor = EventSensor(0.5)
    events = sensor.run(data["response"][..., :1], data["time"])
    assert len(np.unique(events["ommatidium"])) >= 6
    one_sign = [np.unique(events[events["ommatidium"] == i]["polarity"]) for i in range(9)]
    assert len({tuple(s) for s in one_sign if len(s)}) == 1
    # ln 9 = 2.197 is four thresholds; the middle of them when the edge is at the axis.
    for i in range(2, 7):
        own = events[events["ommatidium"] == i]
        assert len(own) == 4
    middle = [events[events["ommatidium"] == i]["time_s"].mean() for i in range(2, 7)]
    # The axes are 10° apart, the head turns by 70° a second in frames of 1.75°.
    np.testing.assert_allclose(np.abs(np.diff(middle)), 10 / 70, atol=1.75 / 70)


def test_events_say_what_they_are(tmp_path):
    xarray = pytest.importorskip("xarray")
    eye = omma.eye.generate_eye(6)
    sensor = EventSensor(0.2, 0.3, refractory_s=0.001)
    light = np.exp(np.cumsum(np.random.default_rng(0).normal(0, 0.5, (9, 6, 2)), axis=0))
    events = sensor.run(light, np.arange(9.0))
    data = sensor.dataset(events, eye)
    assert data.sizes == {"event": len(events)}
    assert (data["time"].values == events["time_s"]).all()
    assert data["time"].attrs["units"] == "s"
    assert (data["polarity"].values == events["polarity"]).all()
    azimuth = omma.eye.azimuth_elevation_deg_of(eye.axis)[0]
    assert (data["azimuth"].values == azimuth[events["ommatidium"]]).all()
    assert data.attrs["refractory_s"] == 0.001
    assert data.attrs["off_threshold"].tolist() == [0.3]
    data.to_netcdf(tmp_path / "events.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "events.nc", engine="h5netcdf") as read:
        assert (read["receptor"].values == events["receptor"]).all()
    assert "azimuth" not in sensor.dataset(events).coords
    with pytest.raises(omma.Error, match="eye: expected at least"):
        sensor.dataset(events, omma.eye.generate_eye(4))


ONE = EventSensor(0.2)
LINEAR = EventSensor(0.2, signal="linear")
TWO = np.ones((2, 3))
EVENTS = np.zeros(1, EVENT)
BAD = [
    (lambda: EventSensor(0.0), "on_threshold: expected numbers above 0, found 0"),
    (lambda: EventSensor(0.2, -0.1), "off_threshold: expected numbers above 0, found -0.1"),
    (lambda: EventSensor(np.nan), "on_threshold: expected numbers above 0, found nan"),
    (lambda: EventSensor([0.1, 0.0]), "on_threshold: expected numbers above 0"),
    (lambda: EventSensor([[[0.1]]]), "on_threshold: expected a number, "),
    (lambda: EventSensor(refractory_s=-1.0), "refractory_s: expected 0 to"),
    (lambda: EventSensor(refractory_s=np.inf), "refractory_s: expected 0 to"),
    (lambda: EventSensor(dark=-1.0), "dark: expected 0 to"),
    (lambda: EventSensor(signal="root"), "signal: expected one of log, linear"),
    (lambda: ONE.run(TWO, [0, 0]), "time_s: expected a time after 0 s, found 0 s"),
    (lambda: ONE.run(TWO, [1, 0.5]), "time_s: expected a time after 1 s, found 0.5 s"),
    (lambda: ONE.run(TWO, [0, np.nan]), "time_s: expected"),
    (lambda: ONE.run(TWO, [0, 1, 2]), "times_s: expected shape"),
    (lambda: ONE.run(TWO[0], [0, 1]), "responses: expected shape"),
    (lambda: ONE.run(-TWO, [0, 1]), "frame: expected numbers from 0 on, found -1 at"),
    (lambda: ONE.run(TWO * np.nan, [0, 1]), "frame: expected numbers from 0 on, found nan at"),
    (lambda: ONE.run(0 * TWO, [0, 1]), "frame: .* found 0 at .*`dark` is added"),
    (lambda: LINEAR.run(TWO * np.inf, [0, 1]), "frame: expected finite numbers"),
    (lambda: EventSensor([0.1, 0.2]).run(TWO, [0, 1]), "on_threshold: expected a number or the"),
    (lambda: EventSensor(0.1, [0.2]).run(TWO, [0, 1]), "off_threshold: expected a number or the"),
    (lambda: ONE.step(ONE.step(None, TWO, 0)[0], TWO[0], 1), r"frame: expected shape \(2, 3\)"),
    (lambda: ONE.step(None, 1.0, 0), r"frame: expected shape \(N,\) or \(N, R\)"),
    (lambda: EventSensor(1e-12).run([[1.0], [9.0]], [0, 1]), "expected at most .* events"),
    (lambda: ONE.dataset(TWO), "events: expected an array"),
    (lambda: event_counts(EVENTS, [0, 0], (1,)), "edges_s: expected two or more"),
    (lambda: event_counts(EVENTS, [0, 1], (0,)), "shape: expected"),
    (lambda: event_counts(EVENTS, [0, 1], 5), r"shape: expected \(N,\) or \(N, R\), found 5"),
    (lambda: event_counts(np.array([(0, 3, 0, 1)], EVENT), [0, 1], (2,)), "expected ommatidium 0"),
]


@pytest.mark.parametrize(("call", "message"), BAD)
def test_bad_input(call, message):
    with pytest.raises(omma.Error, match=message):
        call()


@pytest.mark.parametrize("other", [{"signal": "linear"}, {"dark": 0.1}])
def test_the_state_of_a_sensor_in_another_unit_is_refused(other):
    """Its numbers are logarithms, or not, and of more light or less."""
    state, _ = EventSensor(0.2, **other).step(None, np.ones(3), 0.0)
    with pytest.raises(omma.Error, match="state: expected that of a sensor with signal 'log', da"):
        EventSensor(0.2).step(state, np.ones(3), 1.0)
    # Thresholds may change on the way: what is kept is the signal.
    state, _ = EventSensor(0.2).step(None, np.ones(3), 0.0)
    _, events = EventSensor(0.6).step(state, np.full(3, np.e), 1.0)
    assert len(events) == 3
    kept = omma.photoreceptors.EventState(0.0, state.signal, state.reference, state.ready_s)
    assert len(EventSensor(0.6).step(kept, np.full(3, np.e), 1.0)[1]) == 3


def test_times_in_milliseconds_are_told():
    sensor, light = EventSensor(0.5), np.ones((3, 2))
    with pytest.warns(UserWarning, match=r"times_s: 1000 s is unusual .*; 1000 ms would be 1 s"):
        sensor.run(light, [0, 1000, 2000])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sensor.run(light, [0, 0.5, 1000])  # a rest between sequences
        sensor.run(light[:1], [0])
