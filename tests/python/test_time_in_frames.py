"""Frames that last: rays draw their time from an impulse response, and start from where the head
was then.
"""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.photoreceptors import ImpulseResponse, filter_frames

WIDTH_DEG, CONTRAST = 4.0, 0.8
FRAMES_A_PERIOD = 12
HOWARD = ImpulseResponse.howard(0.010, 0.3)


def turning(angles):
    return np.stack([omma.look_at((0, 0, 0), (np.sin(a), 0, -np.cos(a))) for a in angles])


def drum(cycles):
    azimuth = (np.arange(4096) + 0.5) / 4096 * 2 * np.pi
    stripes = np.repeat(1 + CONTRAST * np.cos(cycles * azimuth), 3).reshape(1, -1, 3)
    return omma.Scene(background=omma.Background.image(np.tile(stripes, (8, 1, 1)).astype("f4")))


def answer(cycles, frequency_hz, h):
    """The response's phasor around a mean of 1, of a grating of so many cycles around that passes
    at this frequency: over one period, after the head had turned for longer than a frame lasts."""
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], np.radians(WIDTH_DEG))
    sampling = omma.Fixed(4096)
    renderer = omma.Renderer(drum(cycles), eye, sampling, footprints=False, impulse_response=h)
    # The head turns evenly, so that a pose now and then says all.
    time_s = np.arange(FRAMES_A_PERIOD) / FRAMES_A_PERIOD / frequency_hz
    past_s = np.linspace(-1.01 * h.duration_s, 0, 8)[:-1]
    rate = 2 * np.pi * frequency_hz / cycles
    # Keys a third of a turn apart or less: between two, the head goes the short way.
    assert rate * np.diff(np.append(past_s, 0)).max() < 2
    seen = renderer.render(
        turning(rate * time_s), times_s=time_s, past=(turning(rate * past_s), past_s)
    )[:, 0, 0]
    start = np.exp(1j * np.pi * cycles)  # straight ahead is the middle of the picture
    return 2 * np.mean(seen * np.exp(-2j * np.pi * frequency_hz * time_s)) * start


@pytest.mark.parametrize("frequency_hz", [1.0, 5.0, 15.0, 40.0, 90.0])
@pytest.mark.parametrize("cycles", [9, 20, 40, 60])
def test_drifting_gratings(cycles, frequency_hz):
    found = answer(cycles, frequency_hz, HOWARD)
    seen = CONTRAST * np.exp(-3.5597 * (cycles / 360) ** 2 * WIDTH_DEG**2)
    kept = HOWARD.transfer(frequency_hz)
    assert abs(found) == pytest.approx(seen * abs(kept), abs=0.005)
    # Of 4,096 rays a phasor is off by about a thousandth: 1 degree of 0.06.
    if seen * abs(kept) > 0.06:
        assert abs(np.angle(found / kept, deg=True)) < 1


@pytest.mark.parametrize("h", [ImpulseResponse.exponential(0.02), ImpulseResponse.box(0.03)])
def test_other_impulse_responses(h):
    found, kept = answer(20, 15.0, h), h.transfer(15.0)
    seen = CONTRAST * np.exp(-3.5597 * (20 / 360) ** 2 * WIDTH_DEG**2)
    assert abs(found) == pytest.approx(seen * abs(kept), abs=0.005)
    assert abs(np.angle(found / kept, deg=True)) < 1


def edge_passes(h, turn_rad_s, times_s, samples=4096):
    """A point of view without width, which turns past the edge of a wall at time 0."""
    wall = omma.scene.Mesh(
        np.float32([[0, -9, -5], [90, -9, -5], [90, 9, -5], [0, 9, -5]]),
        [[0, 1, 2], [0, 2, 3]],
        material=0,
    )
    white = omma.scene.Material("white", double_sided=True)
    scene = omma.Scene(
        meshes=[wall],
        materials=[white],
        instances=[omma.scene.Instance(0)],
        background=omma.Background.constant((0, 0, 0)),
    )
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.0)
    renderer = omma.Renderer(scene, eye, omma.Fixed(samples), impulse_response=h)
    past_s = np.linspace(times_s[0] - 0.2, times_s[0], 12)[:-1]
    return renderer.render(
        turning(turn_rad_s * times_s), times_s=times_s, past=(turning(turn_rad_s * past_s), past_s)
    )[:, 0, 0]


@pytest.mark.parametrize("h", [HOWARD, ImpulseResponse.exponential(0.008)])
def test_an_edge_comes_into_view_as_the_step_response(h):
    times_s = np.linspace(-0.01, 0.06, 29)
    found = edge_passes(h, 4.0, times_s)
    # 4,096 times on steps of the golden ratio are even to some 3 of them.
    assert np.abs(found - h.cumulative(times_s)).max() < 1.5e-3


def test_a_target_that_crosses_in_2_ms():
    # 0.02 rad wide at 10 rad/s: so it is there for 2 ms, and dimmed to h's share of these.
    h, turn = HOWARD, 10.0
    times_s = np.linspace(-0.005, 0.05, 45)
    first = edge_passes(h, turn, times_s)
    second = h.cumulative(times_s - 0.002)
    dimmed = first - second
    must_be = h.cumulative(times_s) - second
    assert dimmed.max() == pytest.approx(must_be.max(), abs=2e-3)
    assert must_be.max() < 0.27
    assert np.abs(dimmed - must_be).max() < 2e-3


def test_frames_that_last_and_frames_that_are_filtered_agree(scene):
    eye = make_eye(60, acceptance_deg=8)
    times_s = np.arange(120) * 0.001
    poses = np.stack([omma.look_at((2 * t, 1, 2), (3 + 8 * t, 1, -2)) for t in times_s])
    lasting = omma.Renderer(scene, eye, omma.Fixed(1024), impulse_response=HOWARD)
    instants = omma.Renderer(scene, eye, omma.Fixed(1024))
    seen = lasting.render(poses, times_s=times_s)[-20:]
    filtered = filter_frames(instants.render(poses), 1000.0, HOWARD)[-20:]
    spread = instants.render(poses).std(axis=0).mean()
    assert np.sqrt(np.mean((seen - filtered) ** 2)) < 0.05 * spread
    assert abs(np.mean(seen - filtered)) < 0.01 * spread


def test_in_pieces_as_at_once(scene, eye, flight):
    times_s = np.arange(len(flight)) * 0.01
    renderer = omma.Renderer(scene, eye, omma.Fixed(16), impulse_response=HOWARD)
    whole = renderer.render(flight, times_s=times_s)
    half = len(flight) // 2
    last = renderer.render(
        flight[half:], times_s=times_s[half:], past=(flight[:half], times_s[:half])
    )
    assert (last == whole[half:]).all()
    for threads in (1, 2, 3):
        other = omma.Renderer(scene, eye, omma.Fixed(16), impulse_response=HOWARD, threads=threads)
        assert (other.render(flight, times_s=times_s) == whole).all()


def test_data_sets_keep_what_was_before(scene, eye, flight):
    """From them alone the same bits are rendered again."""
    pytest.importorskip("xarray")
    times_s = np.arange(6) * 0.01
    still = omma.Renderer(omma.World(scene), eye, omma.Fixed(16), impulse_response=HOWARD)
    thing = np.tile(np.eye(4), (6, 1, 1, 1))
    thing[:, 0, 0, 3] = np.linspace(0, 3, 6)
    moves = {
        "times_s": times_s[3:],
        "instances": [0],
        "transforms": thing[3:],
        "past": (flight[:3], times_s[:3], thing[:3]),
    }
    data = still.dataset(flight[3:6], **moves)
    kept = {
        "times_s": data.time.values,
        "instances": data.instance_index.values,
        "transforms": data.world_from_thing.values,
        "past": (
            data.past_world_from_head.values,
            data.past_time_s.values,
            data.past_world_from_thing.values,
        ),
    }
    again = still.render(flight[3:6], **kept)
    assert (again == data.response.values).all()
    alone = still.render(flight[3:6], **kept | {"past": None})
    assert (alone != again).any()
    short = still.dataset(flight[3:6], times_s=times_s[3:], past=(flight[:3], times_s[:3]))
    assert "past_world_from_thing" not in short
    assert "past_time_s" not in still.dataset(flight[3:6], times_s=times_s[3:])

    instants = omma.Renderer(still.world, eye, omma.Fixed(16))
    truth = instants.ground_truth(flight[3:6])
    with pytest.raises(omma.Error, match="past: is for renderers with an impulse response"):
        instants.dataset(flight[3:6], truth=truth, past=(flight[:3], times_s[:3]))


def test_a_head_that_stands_still_sees_instants(scene, eye, flight):
    poses = np.repeat(flight[:1], 5, axis=0)
    lasting = omma.Renderer(scene, eye, omma.Fixed(16), impulse_response=HOWARD)
    instants = omma.Renderer(scene, eye, omma.Fixed(16))
    assert (lasting.render(poses, times_s=np.arange(5) * 0.01) == instants.render(poses)).all()


@pytest.mark.parametrize("backend", ["", "portable"])
def test_things_that_move_from_pose_to_pose(scene, eye, flight, backend):
    """The head is where it was, things are where they are at the frame."""
    world = omma.World(scene, backend=backend)
    renderer = omma.Renderer(world, eye, omma.Fixed(16), impulse_response=HOWARD)
    times_s = np.arange(len(flight)) * 0.01
    still = renderer.render(flight, times_s=times_s)
    place = np.repeat(np.eye(4)[None, None], len(flight), axis=0)
    moved = renderer.render(flight, times_s=times_s, instances=["ground"], transforms=place)
    # Moved, the ground lies in a part of the scene that is searched apart.
    assert np.abs(moved - still).max() < 1e-3


def test_to_an_error_and_with_errors(scene, eye, flight):
    times_s = np.arange(len(flight)) * 0.01
    renderer = omma.Renderer(scene, eye, omma.ToError(0.02), impulse_response=HOWARD)
    seen, report = renderer.render(flight, times_s=times_s, report=True)
    many = renderer.with_eye(eye, omma.Fixed(2048)).render(flight, times_s=times_s)
    assert np.sqrt(np.mean((seen - many) ** 2)) < 0.02
    assert report.rays.mean() > 8
    few, error = renderer.with_eye(eye, omma.Fixed(16)).render(
        flight, times_s=times_s, standard_error=True
    )
    assert np.sqrt(np.mean((few - many) ** 2)) < 2 * np.sqrt(np.mean(error**2))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "times_s: expected when each pose is"),
        ({"times_s": [0, 0.01]}, "times_s"),
        ({"times_s": [0, 0.02, 0.01]}, r"times_s\[2\]: expected more than 0.02"),
        ({"times_s": [0, 0.01, np.nan]}, "times_s"),
        ({"times_s": [0, 0.01, 0.02], "past": 3}, r"past: expected \(poses, times_s\)"),
        ({"times_s": [0, 0.01, 0.02], "past": (np.eye(4), [0.0])}, "expected all before the first"),
        ({"times_s": [0, 0.01, 0.02], "past": (np.eye(4), [-1.0, -0.5])}, "past"),
    ],
)
def test_bad_times(scene, eye, flight, arguments, message):
    renderer = omma.Renderer(scene, eye, omma.Fixed(4), impulse_response=HOWARD)
    with pytest.raises(omma.Error, match=message):
        renderer.render(flight[:3], **arguments)


def test_what_has_no_frames_that_last(scene, eye, flight):
    measured = ImpulseResponse.table([0, 0.004, 0.008, 0.015, 0.02, 0.04], [0, 3, 1, -0.7, -0.3, 0])
    with pytest.raises(omma.Error, match="impulse_response: expected one that is nowhere negative"):
        omma.Renderer(scene, eye, impulse_response=measured)
    with pytest.raises(omma.Error, match="impulse_response: expected None where rays are shared"):
        omma.Renderer(scene, eye, omma.Shared(4), impulse_response=HOWARD)
    with pytest.raises(TypeError, match="impulse_response"):
        omma.Renderer(scene, eye, impulse_response=0.01)
    lasting = omma.Renderer(scene, eye, omma.Fixed(4), impulse_response=HOWARD)
    with pytest.raises(omma.Error, match="ground_truth: expected a renderer without an impulse"):
        lasting.ground_truth(flight)
    with pytest.raises(omma.Error, match="times_s: expected when each pose is"):
        list(lasting.render_iter(flight))
    with pytest.raises(omma.Error, match="past: is for renderers with an impulse response"):
        omma.Renderer(scene, eye).render(flight, past=(np.eye(4), [-1.0]))


def test_nothing_lies_between_a_pose_and_a_mirrored_one(scene, eye, flight):
    renderer = omma.Renderer(scene, eye, omma.Fixed(4), impulse_response=HOWARD)
    poses = flight[:2].copy()
    poses[1, :3, 0] *= -1
    with pytest.raises(omma.Error, match="expected all of them mirrored or none"):
        renderer.render(poses, times_s=[0, 0.01])


def test_heads_that_grow_between_poses(scene):
    """Scaled poses scale the eye: rays go where they did, from where the head is."""
    axes = make_eye(60).axis
    at_origin = omma.Eye(np.zeros_like(axes), axes, np.radians(5))
    renderer = omma.Renderer(scene, at_origin, omma.Fixed(64), impulse_response=HOWARD)
    times_s = np.arange(30) * 0.005
    path = np.stack([omma.look_at((t, 1, 3), (2 + 5 * t, 1, -3)) for t in times_s])
    growing = path.copy()
    growing[:, :3, :3] *= np.linspace(1, 3, len(path))[:, None, None]
    plain = renderer.render(path, times_s=times_s)
    # Ommatidia sit at the origin here, so that a scale changes nothing but rounding, which a ray in
    # 64 may see at an edge.
    np.testing.assert_allclose(renderer.render(growing, times_s=times_s), plain, atol=0.02)


def test_a_target_that_moves_within_frames_errs_by_nothing_but_its_noise():
    """Each ray's time is as likely as any: means over seeds are those of the exact convolution,
    and standard errors hold. Rays tied to times by their number are off by 12 %, errors by 3.9."""
    h = omma.photoreceptors.published_response("blowfly")
    width = np.radians(5.0)
    axis = np.array([omma.eye.direction(azimuth, 0) for azimuth in np.linspace(-8, 8, 9)])
    eye = omma.Eye(np.zeros_like(axis), axis, width)
    speed_deg_s, half_s = 200, 0.1
    target = omma.stimuli.Target(
        3.0, [0, 2 * half_s], [-speed_deg_s * half_s, speed_deg_s * half_s], [0, 0],
        target=1.0, background=0.0,
    )  # fmt: skip
    times_s = np.linspace(0, 2 * half_s, 41)
    delay_s = np.linspace(0, h.duration_s, 2001)
    weight = h.eval(delay_s)
    weight[[0, -1]] /= 2
    weight /= weight.sum()
    fine_s = np.arange(-h.duration_s - 1e-3, 2 * half_s + 1e-4, 1e-4)
    instants = target.expected(axis, np.full(len(axis), width), fine_s)
    exact = np.array(
        [[np.interp(t - delay_s, fine_s, of) @ weight for of in instants.T] for t in times_s]
    )
    bright = exact > 0.25 * exact.max()
    world, poses = target.world(), np.stack([np.eye(4)] * len(times_s))
    for samples, most in ((100, 0.035), (128, 0.03)):
        seen, errors = zip(
            *(
                omma.Renderer(
                    world, eye, omma.Fixed(samples), impulse_response=h, seed=seed
                ).render(
                    poses, times_s=times_s, instances=target.names,
                    transforms=target.transforms(times_s), standard_error=True,
                )
                for seed in range(8)
            )
        )  # fmt: skip
        off = (np.stack(seen)[..., 1] - exact)[:, bright]
        claimed = np.sqrt(np.mean(np.square(errors)[..., 1][:, bright]))
        # Twice what was seen: means of 8 seeds have noise of their own.
        assert np.sqrt(np.mean((off.mean(0) / exact[bright]) ** 2)) < most
        assert np.sqrt(np.mean(off**2)) < 1.1 * claimed
