"""Numbers of optics that are nearly always slips of units are refused, and said to be."""

import math
import warnings

import numpy as np
import pytest
from conftest import write_gltf

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


def _with_an_impulse_response(times_s):
    h = omma.photoreceptors.ImpulseResponse.exponential(0.02)
    renderer = omma.Renderer(
        omma.scene.sphere(1.0), omma.eye.generate_eye(10), omma.Fixed(1), impulse_response=h
    )
    renderer.render(np.tile(np.eye(4), (len(times_s), 1, 1)), times_s=times_s)


def _detectors(tau_s, frame_rate_hz, high_pass_tau_s=None):
    eye = omma.eye.generate_eye(20)
    omma.motion.detector_array(
        eye, tau_s, frame_rate_hz, pairs=[[0, 1]], high_pass_tau_s=high_pass_tau_s
    )


def _catch(integration_time_s):
    cell = ReceptorType("x", peak_wavelength_nm=500, absorption_per_m=6700, length_m=1e-4)
    eye = omma.Eye(np.zeros((2, 3)), [(0, 0, -1.0)] * 2, 0.03).replace(
        facet_diameter_m=np.full(2, 20e-6)
    )
    eye = omma.receptors.assign_receptors(eye, [omma.receptors.OmmatidiumType("x", (cell,))])
    light = omma.light.uniform_sky(1e17)
    omma.receptors.photon_catch(eye, [1.0, 1.0], light, integration_time_s=integration_time_s)


H = omma.photoreceptors.ImpulseResponse.exponential(0.02)
# (call, how the warning begins, what it guesses)
TIMES = [
    (lambda: _detectors(35, 250), "tau_s", "35 ms would be 0.035 s"),
    (lambda: _detectors(0.035, 250, 250), "high_pass_tau_s", "250 ms would be 0.25 s"),
    (lambda: _detectors(0.035, 0.004), "frame_rate_hz", "0.004 s between frames would be 250 Hz"),
    (lambda: omma.stimuli.LoomingDisc(50), "l_over_v_s", "50 ms would be 0.05 s"),
    (lambda: omma.stimuli.LoomingDisc(0.05, 1000), "collision_s", "1000 ms would be 1 s"),
    (lambda: omma.stimuli.LoomingDisc(0.05, 500), "collision_s", "500 ms would be 0.5 s"),
    (lambda: omma.motion.best_frequency_hz(35), "tau_s", "35 ms would be 0.035 s"),
    (
        lambda: omma.motion.best_frequency_hz(0.035, 250),
        "high_pass_tau_s",
        "250 ms would be 0.25 s",
    ),
    (
        lambda: omma.motion.grating_response(1, 0.4, 3, 0.1, 35),
        "tau_s",
        "35 ms would be 0.035 s",
    ),
    (
        lambda: omma.motion.grating_response(1, 0.4, 3, 0.1, 0.035, high_pass_tau_s=250),
        "high_pass_tau_s",
        "250 ms would be 0.25 s",
    ),
    (
        lambda: omma.photoreceptors.EventSensor(0.2, refractory_s=50),
        "refractory_s",
        "50 ms would be 0.05 s",
    ),
    (
        lambda: omma.photoreceptors.photon_noise(
            np.ones(3), 0, photons_per_s=100.0, integration_time_s=20
        ),
        "integration_time_s",
        "20 ms would be 0.02 s",
    ),
    (lambda: _catch(20), "integration_time_s", "20 ms would be 0.02 s"),
    (lambda: _catch([0.02, 20]), "integration_time_s", "20 ms would be 0.02 s"),
    (
        lambda: omma.colour_vision.Observer(integration_time_s=30),
        "integration_time_s",
        "30 ms would be 0.03 s",
    ),
    (lambda: _with_an_impulse_response([0, 10, 20]), "times_s", "10 ms would be 0.01 s"),
    (
        lambda: omma.photoreceptors.filter_frames(np.ones(3), 0.01, H),
        "frame_rate_hz",
        "0.01 s between frames would be 100 Hz",
    ),
    (
        lambda: omma.photoreceptors.FrameFilter(H, 0.01),
        "frame_rate_hz",
        "0.01 s between frames would be 100 Hz",
    ),
]


THREE_AHEAD, THREE_UP = [[0, 0, -1.0]] * 3, [[0, 1.0, 0]] * 3
ANGLES = [
    (
        lambda: omma.motion.grating_response(1, 20, 3, 0.1, 0.035),
        "wavelength_rad",
        "20° would be 0.3491 rad",
    ),
    (
        lambda: omma.motion.grating_response(1, 0.4, 3, [0.1, 5], 0.035),
        "separation_rad",
        "5° would be 0.08727 rad",
    ),
    (
        lambda: omma.motion.grating_response(1, 0.4, 3, 0.1, 0.035, acceptance_angle_rad=5),
        "acceptance_angle_rad",
        "5° would be 0.08727 rad",
    ),
    (
        lambda: omma.stimuli.DrumGrating().expected(THREE_AHEAD, 2.6, [0.125]),
        "acceptance_rad",
        "2.6° would be 0.04538 rad",
    ),
    (
        lambda: omma.stimuli.Bar().expected(THREE_AHEAD, [0, 0.1, 3.0], 0.125),
        "acceptance_rad",
        "3° would be 0.05236 rad",
    ),
    (
        lambda: omma.photoreceptors.microsaccades_rad(np.ones(9), 500, dark=0.1, decade_rad=1.0),
        "decade_rad",
        "1° would be 0.01745 rad",
    ),
    (
        lambda: omma.photoreceptors.microsaccades_rad(np.ones(9), 500, dark=0.1, largest_rad=1.5),
        "largest_rad",
        "1.5° would be 0.02618 rad",
    ),
    (
        lambda: omma.photoreceptors.displace_axes(THREE_AHEAD, THREE_UP, [0.01, -2.0, 0], 0.0),
        "angle_rad",
        "-2° would be -0.03491 rad",
    ),
    (
        lambda: omma.photoreceptors.displace_axes(THREE_AHEAD, THREE_UP, [0.01] * 3, 90.0),
        "towards_rad",
        "90° would be 1.571 rad",
    ),
    (lambda: omma.eye.lay_directions(2.6), "horizontal_rad", "2.6° would be 0.04538 rad"),
    (
        lambda: omma.eye.lattice.check_lattice(_eye().axis, 0.1, 2.6),
        "vertical_rad",
        "2.6° would be 0.04538 rad",
    ),
    (
        lambda: omma.eye.hexagonal_coordinates(_eye()).towards(90),
        "angle_rad",
        "90° would be 1.571 rad",
    ),
    (
        lambda: omma.columns.resampling_matrix(
            omma.eye.generate_eye(200), omma.columns.fly_columns(), width_rad=5, reach_rad=0.2
        ),
        "width_rad",
        "5° would be 0.08727 rad",
    ),
]


def _eye():
    return omma.eye.generate_eye(100)


@pytest.mark.parametrize(("call", "argument", "guess"), ANGLES)
def test_degrees_for_radians_are_warned_of(call, argument, guess):
    with pytest.warns(UserWarning, match=f"^{argument}: .* is unusual .*; {guess}$") as told:
        call()
    assert len(told) == 1
    assert told[0].filename == __file__


def test_angles_that_are_usual_are_not_warned_of():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.motion.grating_response(1, 2 * np.pi, 3, 0.0, 0.035)
        omma.stimuli.DrumGrating().expected(THREE_AHEAD, [0, 0.02, 1.0], [0.125])
        omma.photoreceptors.displace_axes(
            THREE_AHEAD, THREE_UP, [0.1] * 3, [0, -np.pi / 2, 2 * np.pi]
        )
        # Angles are relative where there is a count.
        omma.eye.lay_directions(1.2, count=20)


@pytest.mark.parametrize(("call", "argument", "guess"), TIMES)
def test_times_and_rates_in_another_unit_are_warned_of(call, argument, guess):
    with pytest.warns(UserWarning, match=f"^{argument}: .* is unusual .*; {guess}$") as told:
        call()
    assert len(told) == 1
    assert told[0].filename == __file__


@pytest.mark.parametrize(
    ("call", "argument", "guess"),
    [
        (
            lambda: omma.photoreceptors.ImpulseResponse.exponential(20),
            "time_constant_s",
            "20 ms would be 0.02 s",
        ),
        (
            lambda: omma.photoreceptors.microsaccades_rad(np.ones(3), 100.0, dark=1.0, rise_s=100),
            "rise_s",
            "100 ms would be 0.1 s",
        ),
        (
            lambda: omma.photoreceptors.microsaccades_rad(
                np.ones(3), 100.0, dark=1.0, return_s=500
            ),
            "return_s",
            "500 ms would be 0.5 s",
        ),
    ],
)
def test_impulse_responses_in_milliseconds_are_refused(call, argument, guess):
    words = f"^{argument}: expected seconds, at most 5, found .*; {guess}$"
    with pytest.raises(omma.Error, match=words):
        call()


def test_times_and_rates_that_are_meant_are_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _detectors(0.035, 250, 0.25)
        omma.stimuli.LoomingDisc(0.005, -3.0)
        omma.motion.best_frequency_hz(0.035, 0.25)
        omma.photoreceptors.EventSensor(0.2, refractory_s=0.05)
        _with_an_impulse_response([0, 0.01, 30])
        _with_an_impulse_response([0.0])


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


def test_no_lens_has_an_f_number_below_that_of_the_sine_condition():
    """F = 1/(2n): 25 µm / (2 × 1.363) is 9.171 µm."""
    words = r"focal_length_m: expected at least 9\.171e-06 m, .*F-number of 0\.2; .*allow_unusual"
    with pytest.raises(omma.Error, match=words):
        Acceptance.lens_rhabdom(25e-6, 5e-6, 1.9e-6, 500)
    least = 25e-6 / (2 * 1.363)
    for model in ("waveguide", "geometric", "snyder"):
        with pytest.raises(omma.Error, match="focal_length_m"):
            Acceptance.lens_rhabdom(25e-6, 0.999 * least, 1.9e-6, 500, model=model)
        Acceptance.lens_rhabdom(25e-6, 1.001 * least, 1.9e-6, 500, model=model)
    Acceptance.lens_rhabdom(25e-6, 5e-6, 1.9e-6, 500, allow_unusual=True)


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


def told_of(make):
    """What a call warns of, and what it gives."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        made = make()
    return [str(one.message) for one in told if one.category is UserWarning], made


AHEAD = [[0, 0, -1], [0.1, 0, -1]]
FLOOR = omma.scene.plane((20, 20), name="floor")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"acceptance_angle_rad": 2.6}, "2.6 rad is no animal's"),
        ({"acceptance_angle_rad": 5.0}, "5 degrees would be 0.08727 rad"),
        ({"acceptance_angle_rad": [0.05, 2.6]}, "acceptance_angle_rad of 1 of 2 ommatidia"),
        ({"facet_diameter_m": 25}, "25 µm would be 2.5e-05 m"),
        ({"focal_offset_m": 0.5}, "0.5 mm would be 0.0005 m"),
        ({"aperture_diameter_m": 1}, "1 mm would be 0.001 m"),
        ({"position_m": [[0, 0, 0], [1.2, 0, 0]]}, "position_m of 1 of 1 eyes: 0.6 m"),
    ],
)
def test_arrays_of_eyes_are_told_of(arguments, words):
    given = {"position_m": [[0, 0, 0]] * 2, "axis": AHEAD, "acceptance_angle_rad": 0.05}
    told, eye = told_of(lambda: omma.Eye(**(given | arguments)))
    assert len(told) == 1
    assert words in told[0]
    plain, fine = told_of(lambda: omma.Eye(**given))
    assert plain == []
    # A changed copy too, but not once more of what was there before.
    changed = {k: v for k, v in arguments.items() if k != "axis"}
    assert words in told_of(lambda: fine.replace(**changed))[0][0]
    assert told_of(lambda: eye.replace(eye_id=0))[0] == []


def test_the_warning_is_of_the_line_that_made_the_eye():
    with pytest.warns(UserWarning, match="is no animal's") as told:
        omma.Eye([[0, 0, 0]], [[0, 0, -1]], 2.6)
    assert told[0].filename == __file__


def test_files_of_eyes_are_told_of(tmp_path):
    (tmp_path / "deg.eye").write_text("0 0 1 0 0 1 2.6 0\n0 0 1 0.1 0 1 2.6 0\n")
    (tmp_path / "deg.csv").write_text(
        "azimuth_deg,elevation_deg,acceptance_angle_rad\n0,0,2.6\n5,0,2.6\n"
    )
    for name in ("deg.eye", "deg.csv"):
        told, eye = told_of(lambda name=name: omma.load_eye(tmp_path / name))
        assert len(told) == 1
        assert told[0].startswith(str(tmp_path / name))
        assert "2.6 degrees would be 0.04538 rad" in told[0]
        assert eye.acceptance_angle_rad == pytest.approx(2.6)
    # Millimetres read as metres.
    grown = omma.eye.generate_eye(50, radius_m=1e-3)
    omma.save_eye(tmp_path / "mm.eye", grown)
    told, _ = told_of(lambda: omma.load_eye(tmp_path / "mm.eye", unit="m"))
    assert any("position_m of 1 of 1 eyes: 0.98" in one for one in told)
    assert told_of(lambda: omma.load_eye(tmp_path / "mm.eye"))[0] == []
    told, _ = told_of(lambda: omma.columns.eye_of_columns(columns_of(grown), 5.0))
    assert "5 degrees would be" in told[0]


def columns_of(eye):
    columns, _ = omma.columns.columns_of_eye(eye)
    return columns


def test_the_command_line_tells_too(tmp_path, run_omma):
    (tmp_path / "deg.eye").write_text("0 0 1 0 0 1 2.6 0\n0 0 1 0.1 0 1 2.6 0\n")
    with pytest.warns(UserWarning, match=r"2\.6 degrees would be 0\.04538 rad"):
        code, _, _ = run_omma("info", tmp_path / "deg.eye")
    assert code == 0


@pytest.mark.parametrize("elevation", ["135", "-90.1", "170"])
def test_a_colatitude_is_no_elevation(tmp_path, elevation):
    text = f"azimuth_deg,elevation_deg,acceptance_angle_deg\n0,0,2\n0,{elevation},2\n"
    (tmp_path / "eye.csv").write_text(text)
    with pytest.raises(omma.Error, match=r"line 3, .*elevation of -90 to 90 degrees") as error:
        omma.load_eye(tmp_path / "eye.csv")
    assert elevation in str(error.value)
    for pole in ("90", "-90"):
        (tmp_path / "eye.csv").write_text(text.replace(elevation, pole))
        assert len(omma.load_eye(tmp_path / "eye.csv")) == 2


def pose_at(position, turn=None):
    pose = np.eye(4)
    pose[:3, 3] = position
    if turn is not None:
        pose[:3, :3] = turn
    return pose


@pytest.fixture(scope="module")
def seen():
    ground = omma.scene.plane((10, 10))
    return omma.Renderer(ground, omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1), omma.Fixed(1))


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (pose_at((0, 1200, -2000)), "in millimetres it would be inside"),
        (pose_at((0, 1, 0), np.diag([-1, 1, 1])), "poses[1] mirrors the head"),
        (pose_at((0, 1, 0), 1000 * np.eye(3)), "poses[1] stretches the head by 1e+03"),
        (pose_at((0, 1, 0), [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]), "poses[1] stretches the head"),
    ],
)
def test_poses_that_nobody_means_are_told(seen, pose, words):
    fine = pose_at((0, 1, 0))
    for call in (seen.render, seen.ground_truth, seen.render_rays):
        told, _ = told_of(lambda call=call: call(np.stack([fine, pose])))
        assert len(told) == 1
        assert words in told[0]
        assert told_of(lambda call=call: call(np.stack([fine, fine])))[0] == []


def test_turns_are_never_told_of(seen):
    rng = np.random.default_rng(1)
    quaternions = rng.normal(size=(200, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    poses = omma.poses_from_quaternions(rng.uniform(-200, 200, (200, 3)), quaternions)
    # Rounded, as files have them.
    poses[:, :3, :3] = poses[:, :3, :3].round(3)
    assert told_of(lambda: seen.render(poses))[0] == []


def test_a_cameras_own_scale_is_meant(tmp_path):
    place = {"translation": [0, 1, 0], "scale": [5, 5, 5]}
    scene = omma.load_scene(write_gltf(tmp_path / "s.gltf", cameras=[("big", None, place)]))
    renderer = omma.Renderer(scene, omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1), omma.Fixed(1))
    matrix = scene.camera("big").world_from_camera
    moved = matrix.copy()
    moved[:3, 3] += 1
    for pose in ("big", matrix, moved):
        assert told_of(lambda pose=pose: renderer.render(pose))[0] == []


@pytest.mark.parametrize(
    ("scale", "words"),
    [
        ([-1, 1, 1], "of a camera of the scene, mirrors"),
        ([1, 3, 1], "stretches the head by 1 to 3"),
    ],
)
def test_cameras_that_mirror_or_stretch_are_told(tmp_path, scale, words):
    place = {"translation": [0, 1, 0], "scale": scale}
    scene = omma.load_scene(write_gltf(tmp_path / "s.gltf", cameras=[("odd", None, place)]))
    renderer = omma.Renderer(scene, omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1), omma.Fixed(1))
    told, _ = told_of(lambda: renderer.render("odd"))
    assert len(told) == 1
    assert words in told[0]


@pytest.mark.parametrize(
    ("angles", "seen_deg"),
    [
        ([[math.pi / 2, 0, 0]], "90"),
        ([[0, -math.pi / 4, 0], [3, 0, 0]], "-45"),
        ([[1.57, 0, 0]], "89.95"),
        ([[0, 0, 0], [-1.571, 0, 0], [3.14, 0.785, 0]], "-90.01"),
        (np.float32([[0, 1.57, 0]]), "89.95"),
        (np.c_[np.linspace(-3.1, 3.1, 20), np.zeros((20, 2))], "177.6"),
        (np.c_[np.linspace(0, 6.2, 20), np.zeros((20, 2))], "355.2"),
    ],
)
def test_angles_in_radians_are_told(angles, seen_deg):
    told, _ = told_of(lambda: omma.poses_from_angles((0, 1, 0), angles))
    assert len(told) == 1
    assert "expected degrees" in told[0]
    assert f"radians would be {seen_deg}" in told[0]


@pytest.mark.parametrize(
    "angles",
    [
        [[0, 0, 0]],
        [[1.5, 0, 0]],
        [[0.79, -2.36, 0]],
        [[1.57, 0.4, 0]],  # of a head that is measured to hundredths of a degree
        np.random.default_rng(1).uniform(-2.5, 2.5, (2000, 3)).round(2),
    ],
)
def test_small_angles_in_degrees_are_not(angles):
    assert told_of(lambda: omma.poses_from_angles((0, 1, 0), angles))[0] == []


@pytest.mark.parametrize(
    "call",
    [
        lambda: omma.motion.place_on(FLOOR, (0, 0), height_m=0.01, heading_deg=np.pi / 2),
        lambda: omma.motion.walk_on(
            FLOOR,
            omma.motion.Track([(0, 0), (0, 1), (1, 1)], [0, np.pi, np.pi / 2], [0, 1, 2]).every(
                0.5
            ),
            height_m=0.01,
        ),
        lambda: omma.motion.Track(np.zeros((20, 2)), np.linspace(-3.1, 3.1, 20)),
    ],
)
def test_headings_in_radians_are_told_once(call):
    told, _ = told_of(call)
    assert len(told) == 1
    assert told[0].startswith("heading_deg: expected degrees, found")


def test_headings_in_degrees_are_not():
    almost_straight = np.column_stack([0.01 * np.sin(np.arange(20)), -0.2 * np.arange(20)])
    calls = (
        lambda: omma.motion.place_on(FLOOR, (0, 0), height_m=0.01, heading_deg=[90]),
        lambda: omma.motion.place_on(FLOOR, np.empty((0, 2)), height_m=0.01),
        lambda: omma.motion.walk_on(FLOOR, almost_straight, height_m=0.01),
    )
    for call in calls:
        assert told_of(call)[0] == []


def test_a_head_that_turns_as_in_degrees_is_told():
    renderer = omma.Renderer(FLOOR, _eye(), omma.Fixed(1))
    there = omma.look_at((0, 1, 0), (0, 0, -1))

    def truth(turn):
        return told_of(lambda: renderer.ground_truth(there, head_velocity=((0, 0, 0), turn)))[0]

    assert truth((0, 5, 0)) == []
    (told,) = truth((0, 300, 0))
    assert told.startswith("head_velocity, angular_rad_s: 300 rad/s is unusual")
    assert told.endswith("300°/s would be 5.236 rad/s")


@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_numbers_of_less_precision_are_taken_without_a_word(kind):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.photoreceptors.EventSensor(kind(0.5), refractory_s=kind(0.5), dark=kind(0.5))
    with pytest.raises(omma.Error, match="dark: expected 0 to"):
        omma.photoreceptors.EventSensor(dark=10**400)


@pytest.mark.parametrize(
    "angles",
    [
        [[0, 0, 0]],
        [[90, 0, 0]],
        [[1, 2, 3]],
        [[-5.5, 0, 0.25]],
        np.c_[np.linspace(-3, 3, 7), np.zeros((7, 2))],  # a few degrees to and fro
        np.c_[np.linspace(0, 360, 20), np.zeros((20, 2))],
        np.random.default_rng(2).normal(0, 0.5, (100, 3)),  # a head that trembles
    ],
)
def test_angles_in_degrees_are_not(angles):
    assert told_of(lambda: omma.poses_from_angles((0, 1, 0), angles))[0] == []
