"""How stimuli move from frame to frame: what frames that last keep of them, and how fast they go
past, beside closed forms. Nothing that jumps by itself may count as motion."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import omma
from omma.base.velocities import poses_between
from omma.photoreceptors import ImpulseResponse, filter_frames
from omma.stimuli import (
    Bar,
    DrumGrating,
    LedArena,
    LoomingDisc,
    NoisePanorama,
    PlaneGrating,
    RandomDots,
    SphereGrating,
    Starfield,
    Target,
)

H = ImpulseResponse.exponential(0.02)
ACCEPTANCE_DEG = 5.0
AXES = np.array([omma.eye.direction(a, 0) for a in np.arange(-40, 41, 10.0)])
STILL = ((0, 0, 0), (0, 0, 0))


def eye_of(axes=AXES, acceptance_deg=ACCEPTANCE_DEG):
    return omma.Eye(np.zeros((len(axes), 3)), axes, np.radians(acceptance_deg))


def lasting(stimulus, samples=1024):
    return omma.Renderer(
        stimulus.world(), eye_of(), omma.Fixed(samples), footprints=False, impulse_response=H
    )


@pytest.mark.parametrize("rate_hz", [50, 120])
@pytest.mark.parametrize(
    "grating",
    [
        DrumGrating(30, 5),
        DrumGrating(24, 5, direction="left"),
        SphereGrating(30, 5),
        PlaneGrating(0.6, 5),
        PlaneGrating(0.6, -5),
    ],
)
def test_a_grating_keeps_what_the_impulse_response_passes(grating, rate_hz):
    """Of its contrast as an instant shows it, |H(f)|; over all periods, those that begin too."""
    times = np.arange(int(0.6 * rate_hz)) / rate_hz
    whole = slice(-int(0.4 * rate_hz), None)  # two periods, after h has forgotten the first frame
    turn = np.exp(-2j * np.pi * 5 * times[whole])[:, None]
    seen = grating.play(lasting(grating), times)[whole, :, 1]
    instants = grating.expected(AXES, np.radians(ACCEPTANCE_DEG), times)[whole]
    kept = (seen * turn).mean(0) / (instants * turn).mean(0)
    # 1,024 rays, of which some 32 share a time: 0.01 of the amplitude.
    # H(f) of the way in which it drifts: `kept` is of the part that turns with 5 Hz.
    assert_allclose(kept, np.full(len(AXES), H.transfer(5)), atol=0.025)
    assert abs(kept.mean() - H.transfer(5)) < 0.008


def test_an_arena_is_light_that_is_held():
    """Each of its frames times h over the time for which it was there."""
    arena = LedArena(DrumGrating(30, 5), 0.2, refresh_hz=72)
    times = np.arange(0.0, 0.3, 0.01) + 0.003
    seen = arena.play(lasting(arena), times)[..., 1]
    shown = np.arange(-20, 24) / 72  # of what was before, h knows 0.18 s
    instants = omma.Renderer(arena.world(), eye_of(), omma.Fixed(4096), footprints=False)
    held = arena.play(instants, shown + 1e-5)[..., 1]
    since = np.clip(times[:, None] - np.append(shown[1:], np.inf), 0, None)
    since_start = np.clip(times[:, None] - shown, 0, None)
    weight = H.cumulative(since_start) - H.cumulative(since)
    weight = weight / weight.sum(axis=1, keepdims=True)
    expected = weight @ held
    # No ray draws a time: they differ by their number alone, 1,024 and 4,096 in the same fields.
    assert np.sqrt(np.mean((seen - expected) ** 2)) < 0.001
    assert np.std(expected) > 0.15


def test_few_rays_see_an_arena_without_bias():
    """An arena of 40 Hz, of which 16 rays that draw their times are off by 0.04."""
    arena = LedArena(DrumGrating(30, 8), 0.5, refresh_hz=40)
    world, done = arena.world(), []
    renderers = [
        omma.Renderer(world, eye_of(), omma.Fixed(16), seed=seed, impulse_response=H)
        for seed in range(20)
    ]
    seen = np.array([arena.play(one, [0.113], progress=done.append)[0, :, 1] for one in renderers])
    error = seen.std(axis=0, ddof=1) / np.sqrt(len(seen))
    # By hand: h, in steps of 0.2 ms, over what the arena's closed form shows at each of them.
    delays = np.arange(0, 0.3, 2e-4) + 1e-4
    weight = np.exp(-delays / 0.02) / np.exp(-delays / 0.02).sum()
    shown, which = np.unique(np.floor((0.113 - delays) * 40), return_inverse=True)
    held = arena.expected(AXES, np.radians(ACCEPTANCE_DEG), (shown + 0.5) / 40)
    # Beside four standard errors, that of `expected` where edges are (docs/scenes.md).
    assert (np.abs(seen.mean(axis=0) - weight @ held[which]) < 4 * error + 5e-4).all()
    assert error.max() < 0.004
    assert max(done) == 1


def test_a_head_that_turns_before_an_arena_sees_it_held():
    """Rays draw their times within each frame of the arena: the mean of instants 1 ms apart, at
    which the head is where it was, weighted with h."""
    arena = LedArena(DrumGrating(30, 8), 0.5, refresh_hz=40)
    times = np.array([0.06, 0.1, 0.113])

    def poses_at(times_s):
        yaw = 300 * np.maximum(times_s, times[0])  # it stood before the first
        return omma.poses_from_angles(
            np.zeros((len(yaw), 3)), np.stack([yaw, 0 * yaw, 0 * yaw], axis=-1)
        )

    seen = arena.play(lasting(arena, 512), times, poses=poses_at(times))[..., 1]
    instants = omma.Renderer(arena.world(), eye_of(), omma.Fixed(512), footprints=False)
    delays = np.arange(0, 0.2, 1e-3) + 5e-4
    weight = np.exp(-delays / 0.02) / np.exp(-delays / 0.02).sum()

    def expected(poses):
        shown = [arena.play(instants, t - delays, poses=poses(t - delays)) for t in times]
        return np.stack([weight @ one[..., 1] for one in shown])

    # 512 rays over a direction and a time: some 0.003.
    assert_allclose(seen, expected(poses_at), atol=0.012)
    assert np.sqrt(np.mean((seen - expected(poses_at)) ** 2)) < 0.004
    # The way counts: a head that was always where it is at the end sees something else.
    ends = expected(lambda before: poses_at(np.full(len(before), before[0])))
    assert np.abs(ends[2] - expected(poses_at)[2]).max() > 0.1


def test_an_arena_played_in_one_go_or_in_pieces_is_the_same():
    """With frozen noise; with new noise frames that come again have rays of their own."""
    arena = LedArena(DrumGrating(30, 5), 0.2, refresh_hz=70)  # comes again after 0.2 s
    times = np.linspace(0.0, 0.5, 40)
    whole = arena.play(lasting(arena, 16), times)
    pieces = [arena.play(lasting(arena, 16), part) for part in (times[:7], times[7:])]
    assert_allclose(np.concatenate(pieces), whole, atol=1e-6)
    assert arena.play(lasting(arena, 16), []).shape == (0, 9, 3)
    changing = omma.Renderer(
        arena.world(), eye_of(), omma.Fixed(16), impulse_response=H, noise="new_every_frame"
    )
    once, again = arena.play(changing, [0.1, 0.3])
    assert np.abs(once - again).max() > 1e-3
    assert_allclose(whole[0], arena.play(lasting(arena, 16), [0.2])[0], atol=1e-6)


@pytest.mark.parametrize("frequency_hz", [2, 8, 20])
def test_a_grating_drifted_before_the_first_frame(frequency_hz):
    """Each of some single frames has the |H(f)| and the delay of a grating that has been drifting
    since ever."""
    grating = DrumGrating(30, frequency_hz)
    renderer = lasting(grating, 2048)
    times = 0.5 + np.arange(6) / 6 / frequency_hz
    turn = np.exp(-2j * np.pi * frequency_hz * times)[:, None]
    seen = np.stack([grating.play(renderer, [one])[0, :, 1] for one in times])
    instants = grating.expected(AXES, np.radians(ACCEPTANCE_DEG), times)
    kept = (seen * turn).mean(0) / (instants * turn).mean(0)
    # As of many frames (above), of twice as many rays.
    assert_allclose(kept, np.full(len(AXES), H.transfer(frequency_hz)), atol=0.02)


THINGS = [
    DrumGrating(30, 8),
    DrumGrating(90, 60),  # 15 turns a second: by more than half a turn in what h sees
    SphereGrating(20, -3, direction_deg=30),
    PlaneGrating(0.6, 5),
    Bar(speed_deg_s=150, azimuth_deg=-90, direction_deg=20),
    LoomingDisc(0.05, 0.52, azimuth_deg=10),  # stands since 0.491 s
    LoomingDisc(0.05, 0.56, azimuth_deg=10),
    Target(20.0, [0, 0.43, 0.47, 1], [-80, 10, 0, -30], [0, 5, -5, 60]),
    RandomDots(400, 20.0, speed_deg_s=150),
    Starfield(60, radius_m=0.2, velocity_m_s=(3, 0, 2), seed=4),
    NoisePanorama(speed_deg_s=150, pixel_deg=5),
    LedArena(DrumGrating(30, 5), 0.2, refresh_hz=72),
]


@pytest.mark.parametrize("stimulus", THINGS, ids=lambda one: type(one).__name__)
def test_a_frame_is_what_it_is_after_many(stimulus):
    """Seen by one frame, by few and at the end of many: the same."""
    renderer, last = lasting(stimulus, 256), 0.5
    many = stimulus.play(renderer, np.linspace(last - 0.25, last, 51))[-1]
    alone = stimulus.play(renderer, [last])[0]
    few = stimulus.play(renderer, [last - 0.02, last])[-1]
    assert np.std(many) > 0.02
    # The same rays at the same 32 times. Between frames 5 ms apart a target goes on other chords,
    # by which one ray of 256 may pass an edge.
    assert_allclose(alone, many, atol=1 / 256)
    assert_allclose(few, many, atol=1 / 256)


def test_what_began_to_move_is_rendered_from_rest():
    """A render of one's own stands still before its first time, as the page says."""
    grating = DrumGrating(30, 8)
    renderer = lasting(grating, 256)
    seen = renderer.render(
        np.eye(4),
        times_s=[0.5],
        instances=grating.names,
        transforms=grating.transforms([0.5]),
    )
    instant = omma.Renderer(grating.world(), eye_of(), omma.Fixed(256), footprints=False)
    assert_allclose(seen, grating.play(instant, [0.5]), atol=1e-6)


def test_stars_come_in_again_without_a_way_between():
    stars = Starfield(60, radius_m=0.2, velocity_m_s=(3, 0, 2), seed=4)
    times = np.arange(0, 0.3, 0.02)
    fine = np.arange(-200, 281) * 1e-3  # of what was before, h knows 0.18 s
    sharp = stars.play(omma.Renderer(stars.world(), eye_of(), omma.Fixed(1024)), fine)[..., 1]
    filtered = filter_frames(sharp, 1000.0, H)[200::20]
    seen = stars.play(lasting(stars), times)[..., 1]
    assert stars._jumps_s(0.0, 0.28).size > 10
    assert np.std(filtered) > 0.1
    assert np.sqrt(np.mean((seen - filtered) ** 2)) < 0.015


def test_told_of_jumps_or_not_what_does_not_jump_is_the_same():
    """Head and drum turn; the moments before and after a jump lie on their way."""

    class Told(DrumGrating):
        def _jumps_s(self, first_s, last_s):
            return np.array([0.013, 0.02, 0.0555])

    times = np.arange(8) * 0.01
    poses = omma.poses_from_angles(
        np.outer(times, [1.0, 0.2, 0.4]), np.outer(times, [200.0, 50.0, 30.0])
    )
    done = []
    told = Told(30, 5).play(
        lasting(Told(30, 5), 64), times, poses=poses, progress=lambda share: done.append(share)
    )
    plain = DrumGrating(30, 5).play(lasting(DrumGrating(30, 5), 64), times, poses=poses)
    # A frame's table of the head's way has a node at each time that is told: other nodes between
    # which it is interpolated. Heads without the moments are off by some hundredths.
    assert_allclose(told, plain, atol=1e-3)
    assert done == sorted(done)
    assert done[-1] == 1


def test_between_poses_turns_are_even_and_ways_straight():
    ends = omma.poses_from_angles([(0, 0, 0), (1, 2, 0)], [(0, 0, 0), (90, 0, 0)])
    ends[1, :3, :3] *= 3
    middle = poses_between(ends, np.array([1.0, 2.0]), np.array([1.0, 1.5]))
    there = omma.poses_from_angles((0.5, 1, 0), (45, 0, 0))[0]
    there[:3, :3] *= 2
    assert_allclose(middle, [ends[0], there], atol=1e-12)


@pytest.mark.parametrize(
    "stimulus",
    [
        DrumGrating(30, 5),
        DrumGrating(30, 5, direction="left"),
        SphereGrating(20, -3, direction_deg=30),
        Bar(speed_deg_s=150, direction_deg=90),
        RandomDots(400, 20.0, speed_deg_s=150),
        NoisePanorama(speed_deg_s=150, pixel_deg=5),
    ],
)
def test_what_turns_goes_past_evenly(stimulus):
    """ω × d at every time, by the path of its transforms as by its velocities."""
    times = np.arange(40) * 0.03
    poses = np.tile(np.eye(4), (40, 1, 1))
    renderer = omma.Renderer(stimulus.world(), eye_of(acceptance_deg=0.0), omma.Fixed(1))
    speed = stimulus._turning_deg_s if hasattr(stimulus, "_turning_deg_s") else 150.0
    if isinstance(stimulus, DrumGrating):
        speed = 150.0 if stimulus.direction == "right" else -150.0
    tilt = np.radians(getattr(stimulus, "direction_deg", 0.0))
    omega = np.radians(speed) * np.array([np.sin(tilt), -np.cos(tilt), 0.0])
    velocity = np.cross(omega, AXES)
    right = np.cross(AXES, [0, 1, 0])
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    expected = np.stack([(velocity * right).sum(1), velocity[:, 1]], -1)
    moves = {"instances": stimulus.names, "transforms": stimulus.transforms(times)}
    for told in ({}, {"velocities": stimulus.velocities(times)}):
        truth = renderer.ground_truth(poses, times_s=times, head_velocity=STILL, **moves, **told)
        flow, met = truth.flow_objects_rad_s, truth.met > 0
        assert met.mean() > 0.02
        assert_allclose(
            flow[met], np.broadcast_to(expected, flow.shape)[met], atol=1e-4 * abs(speed)
        )


def test_a_plane_goes_past_evenly():
    """At its speed over its distance, (v − (v·d) d)/r, where it jumps back too."""
    plane = PlaneGrating(0.3, 4)
    times = np.arange(40) * 0.01
    axes = np.array([[0, 0, -1.0], omma.eye.direction(40, 0)])
    renderer = omma.Renderer(plane.world(), eye_of(axes, 0.0), omma.Fixed(1))
    truth = renderer.ground_truth(
        np.tile(np.eye(4), (40, 1, 1)),
        times_s=times,
        instances=plane.names,
        transforms=plane.transforms(times),
        velocities=plane.velocities(times),
        head_velocity=STILL,
    )
    # At 40° the plane is 1/cos 40° away, and goes across by the cosine.
    expected = 1.2 * np.array([1, np.cos(np.radians(40)) ** 2])
    assert_allclose(truth.flow_objects_rad_s[..., 0], np.tile(expected, (40, 1)), rtol=1e-5)


def test_stars_go_past_as_of_a_head_that_flies():
    stars = Starfield(800, radius_m=0.02, velocity_m_s=(0.5, 0, 2), cube_m=3.0)
    times = np.arange(8) * 0.2
    eye = omma.Eye(np.zeros((2000, 3)), omma.eye.generate_eye(2000).axis, 0.0)
    truth = omma.Renderer(stars.world(), eye, omma.Fixed(1)).ground_truth(
        np.tile(np.eye(4), (8, 1, 1)),
        times_s=times,
        instances=stars.names,
        transforms=stars.transforms(times),
        velocities=stars.velocities(times),
        head_velocity=((-0.5, 0, -2), (0, 0, 0)),
    )
    met = truth.met > 0
    assert met.sum() > 40
    # A star faces the head as it goes by: its rim, 2 cm from its middle, turns a little, 1 m away.
    off = truth.flow_objects_rad_s - truth.flow_translation_rad_s
    assert np.median(np.abs(off[met])) < 0.02 * np.median(np.abs(truth.flow_objects_rad_s[met]))
    assert np.abs(truth.flow_objects_rad_s[met]).max() < 50


def test_what_an_arena_shows_stands_still():
    arena = LedArena(DrumGrating(30, 5), 0.2, refresh_hz=72)
    times = np.arange(10) * 0.01
    truth = omma.Renderer(arena.world(), eye_of(), omma.Fixed(4)).ground_truth(
        np.tile(np.eye(4), (10, 1, 1)),
        times_s=times,
        instances=arena.names,
        transforms=arena.transforms(times),
        velocities=arena.velocities(times),
    )
    assert not truth.flow_objects_rad_s.any()


def test_a_disc_comes_with_its_speed_and_a_target_turns_about_the_head():
    disc = LoomingDisc(0.05, 1.0, half_width_m=0.1, azimuth_deg=90)
    linear, angular = disc.velocities([0.5, 1.5])["disc"]
    assert_allclose(linear, [[-2, 0, 0], [0, 0, 0]], atol=1e-6)
    assert_allclose(angular, 0, atol=1e-9)
    target = Target(2.0, [0, 1], [-20, 20], [0, 0])
    linear, angular = target.velocities([0.5])["target"]
    assert_allclose(linear, [[np.radians(40), 0, 0]], atol=1e-6)
    assert_allclose(angular, [[0, -np.radians(40), 0]], atol=1e-6)


def test_what_begins_or_stops_has_all_of_its_velocity_at_that_time():
    target = Target(2.0, [0, 0.3, 0.7], [-20, 20, 20], [0, 0, 40])
    times = [-0.1, 0, 0.3, 0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1 + 0.1, 0.7, 0.8]
    linear, _ = target.velocities(times)["target"]
    first, last = np.radians(40) / 0.3, np.radians(40) / 0.4
    mean = np.hypot(first, last) / 2  # of before and after, across each other
    assert_allclose(np.linalg.norm(linear, axis=1), [0, first, mean, last, last, 0], atol=1e-4)
    one = omma.velocities_from_poses(target.transforms([0, 1e-3])[:, 0], [0, 1e-3])[0]
    assert_allclose(linear[1], one[0], atol=0.01)
    assert not np.any(Target(2.0, [0.5], [0], [0]).velocities([0.4, 0.5, 0.6])["target"])
    disc = LoomingDisc(0.05, 1.0, largest_deg=90, half_width_m=0.1)
    linear, _ = disc.velocities([0.95 - 1e-5, 0.95, 0.95 + 1e-5])["disc"]
    assert_allclose(linear[:, 2], [2, 2, 0], atol=1e-6)


def test_turns_that_would_seem_to_go_the_other_way_are_refused():
    drum = DrumGrating(90, 20)  # 1,800° a second
    renderer = lasting(drum, 4)
    assert drum.play(renderer, [0, 0.09]).shape == (2, 9, 3)
    with pytest.raises(omma.Error, match=r"times_s: expected steps below 0\.1 s.*found 0\.1 s"):
        drum.play(renderer, [0, 0.1])
    with pytest.raises(omma.Error, match="times_s: expected times that grow"):
        drum.play(renderer, [0, 0.01, 0.01])
    still = dataclasses.replace(drum, temporal_frequency_hz=0.0)
    assert still.play(renderer, [0, 0.9]).shape == (2, 9, 3)


def test_more_jumps_than_can_be_followed_are_refused_with_the_way_out():
    plane = PlaneGrating(0.1, 1e5)
    with pytest.raises(omma.Error, match=r"at most 1,048,576 jumps.*filter_frames"):
        plane.play(lasting(plane, 4), [0, 100])
    stars = Starfield(2000, velocity_m_s=(1000, 0, 0))
    with pytest.raises(omma.Error, match=r"transforms within .*filter_frames"):
        stars.play(lasting(stars, 4), [0, 0.1])
