"""Things that move while a frame lasts: rays see them where they were when the rays look."""

import numpy as np
import pytest
from animated_scenes import swinging_box
from conftest import make_eye

import omma
from omma.photoreceptors import ImpulseResponse, filter_frames

HOWARD = ImpulseResponse.howard(0.010, 0.3)
CONTRAST, WIDTH_DEG = 0.8, 4.0


@pytest.fixture(params=["embree", "portable"])
def backend(request):
    return request.param


def turned(angles):
    """About the vertical, to the right."""
    matrices = np.tile(np.eye(4), (len(angles), 1, 1))
    matrices[:, 0, 0] = matrices[:, 2, 2] = np.cos(angles)
    matrices[:, 2, 0] = np.sin(angles)
    matrices[:, 0, 2] = -np.sin(angles)
    return matrices


def striped_drum(cycles):
    azimuth = (np.arange(2048) + 0.5) / 2048 * 2 * np.pi
    stripes = np.repeat(0.5 * (1 + CONTRAST * np.cos(cycles * azimuth)), 3).reshape(1, -1, 3)
    return omma.scene.drum(1.0, 4.0, np.tile(stripes, (8, 1, 1)).astype("f4"))


@pytest.mark.parametrize("frequency_hz", [5.0, 15.0, 40.0])
@pytest.mark.parametrize("cycles", [9, 40])
def test_a_drum_that_turns_keeps_what_the_impulse_response_passes(cycles, frequency_hz, backend):
    """The contrast of its grating: the acceptance's transfer times that of h."""
    world = omma.World(striped_drum(cycles), backend=backend)
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], np.radians(WIDTH_DEG))
    renderer = omma.Renderer(
        world, eye, omma.Fixed(2048), footprints=False, impulse_response=HOWARD
    )
    frames = 6
    times = np.arange(frames) / frames / frequency_hz
    past = np.linspace(-1.01 * HOWARD.duration_s, 0, 12)[:-1]
    rate = 2 * np.pi * frequency_hz / cycles
    still = np.tile(np.eye(4), (frames, 1, 1))
    seen = renderer.render(
        still,
        times_s=times,
        instances=["drum"],
        transforms=turned(rate * times)[:, None],
        past=(np.tile(np.eye(4), (11, 1, 1)), past, turned(rate * past)[:, None]),
    )[:, 0, 0]
    found = 2 * np.mean(seen * np.exp(-2j * np.pi * frequency_hz * times)) / 0.5
    expected = CONTRAST * np.exp(-3.5597 * (cycles / 360) ** 2 * WIDTH_DEG**2)
    # Of 32 times for things: the phases that one of them stands for are up to 1/32 of h apart.
    assert abs(found) == pytest.approx(expected * abs(HOWARD.transfer(frequency_hz)), abs=0.006)


def test_a_drum_that_turns_is_a_head_that_turns_the_other_way(backend):
    world = omma.World(striped_drum(20), backend=backend)
    eye = make_eye(200, acceptance_deg=4)
    renderer = omma.Renderer(world, eye, omma.Fixed(512), impulse_response=HOWARD)
    times = np.arange(12) * 0.004
    angles = 6 * times
    still = np.tile(np.eye(4), (12, 1, 1))
    things = renderer.render(
        still, times_s=times, instances=["drum"], transforms=turned(angles)[:, None]
    )
    heads = renderer.render(turned(-angles), times_s=times)
    instants = omma.Renderer(world, eye, omma.Fixed(512)).render(turned(-angles))
    spread = np.sqrt(np.mean((instants - heads) ** 2))
    assert np.sqrt(np.mean((things - heads) ** 2)) < 0.06 * spread


def test_frames_that_last_and_frames_that_are_filtered_agree(tmp_path, backend):
    """Of a scene whose animation plays."""
    scene = swinging_box(tmp_path / "box.gltf")
    world = omma.World(scene, backend=backend)
    eye = make_eye(100, acceptance_deg=8)
    lasting = omma.Renderer(world, eye, omma.Fixed(4096), impulse_response=HOWARD)
    instants = omma.Renderer(world, eye, omma.Fixed(4096))
    times = np.arange(80) * 0.002
    poses = np.tile(np.eye(4), (80, 1, 1))
    sharp = instants.render(poses, times_s=times)
    seen = lasting.render(poses, times_s=times)[-20:]
    filtered = filter_frames(sharp, 500.0, HOWARD)[-20:]
    spread = np.sqrt(np.mean((sharp[-20:] - filtered) ** 2))
    assert spread > 1e-3
    assert np.sqrt(np.mean((seen - filtered) ** 2)) < 0.2 * spread


def test_in_pieces_as_at_once(backend):
    world = omma.World(striped_drum(20), backend=backend)
    eye = make_eye(50, acceptance_deg=4)
    renderer = omma.Renderer(world, eye, omma.Fixed(16), impulse_response=HOWARD)
    times = np.arange(20) * 0.005
    still = np.tile(np.eye(4), (20, 1, 1))
    turns = turned(3 * times)[:, None]
    whole = renderer.render(still, times_s=times, instances=["drum"], transforms=turns)
    last = renderer.render(
        still[12:],
        times_s=times[12:],
        instances=["drum"],
        transforms=turns[12:],
        past=(still[:12], times[:12], turns[:12]),
    )
    assert np.array_equal(last, whole[12:])
    for threads in (1, 3):
        other = omma.Renderer(world, eye, omma.Fixed(16), impulse_response=HOWARD, threads=threads)
        again = other.render(still, times_s=times, instances=["drum"], transforms=turns)
        assert np.array_equal(again, whole)


@pytest.mark.parametrize("samples", [1, 3, 7, 16, 100])
def test_any_number_of_rays(samples):
    """A drum of one colour is seen as that, whatever parts its rays are put into."""
    grey = omma.World(omma.scene.drum(1.0, 80.0, (0.4, 0.5, 0.6)))
    renderer = omma.Renderer(
        grey,
        omma.Eye([[0, 0, 0]] * 3, [[0, 0, -1], [1, 0, 0], [0.6, 0.1, 0.8]], np.radians(3)),
        omma.Fixed(samples),
        impulse_response=HOWARD,
    )
    times = np.arange(4) * 0.01
    seen, error = renderer.render(
        np.tile(np.eye(4), (4, 1, 1)),
        times_s=times,
        instances=["drum"],
        transforms=turned(9 * times)[:, None],
        standard_error=True,
    )
    assert np.allclose(seen, (0.4, 0.5, 0.6), atol=1e-6)
    assert np.allclose(error, 0, atol=1e-6)


def test_errors_are_not_too_small():
    """Those of parts add up as if they were independent; together they lie more evenly."""
    world = omma.World(striped_drum(20))
    eye = make_eye(200, acceptance_deg=4)
    renderer = omma.Renderer(world, eye, omma.Fixed(128), impulse_response=HOWARD)
    times = np.arange(6) * 0.01
    moves = {"times_s": times, "instances": ["drum"], "transforms": turned(6 * times)[:, None]}
    poses = np.tile(np.eye(4), (6, 1, 1))
    seen, error = renderer.render(poses, standard_error=True, **moves)
    truth = renderer.with_eye(eye, omma.Fixed(8192)).render(poses, **moves)
    off = np.sqrt(np.mean((seen - truth)[2:] ** 2))
    told = np.sqrt(np.mean(error[2:] ** 2))
    assert 0.2 * told < off < told


def test_what_cannot_be_said_why():
    world = omma.World(striped_drum(20))
    times = np.arange(3) * 0.01
    moves = {"times_s": times, "instances": ["drum"], "transforms": turned(6 * times)[:, None]}
    poses = np.tile(np.eye(4), (3, 1, 1))
    to_error = omma.Renderer(world, make_eye(5), omma.ToError(0.1), impulse_response=HOWARD)
    with pytest.raises(omma.Error, match="sampling: expected Fixed where things move while frames"):
        to_error.render(poses, **moves)
    fixed = omma.Renderer(world, make_eye(5), omma.Fixed(4), impulse_response=HOWARD)
    with pytest.raises(omma.Error, match="past: expected shape"):
        fixed.render(poses, past=(np.eye(4)[None], [-1.0], np.eye(4)), **moves)
    # Things that stand need no parts.
    still = turned(np.zeros(3))[:, None]
    seen = to_error.render(poses, times_s=times, instances=["drum"], transforms=still)
    assert np.isfinite(seen).all()
