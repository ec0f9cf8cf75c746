"""Stimuli: what is rendered is what their formulas say, and these are right."""

import numpy as np
import pytest
from scipy.special import erf

import omma
from omma.base.directions import direction
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
    edge,
    optomotor_drum,
)
from omma.stimuli.shapes import longitude_latitude_deg

TIMES_S = np.array([0.0, 0.37, 0.8])
STIMULI = {
    "drum": DrumGrating(20, 2, direction="left", phase_deg=50, contrast=0.8),
    "square drum": DrumGrating(40, 1, "square", mean=0.3),
    "sphere": SphereGrating(24, 2, direction_deg=30, phase_deg=40),
    "square sphere": SphereGrating(24, 2, "square", direction_deg=-60),
    "screen": PlaneGrating(0.5, 1, background=0.2),
    "ground": PlaneGrating(1.0, 1.5, direction_deg=90, center_m=(0, -1, 0), contrast=0.6),
    "ceiling": PlaneGrating(1.2, 1.5, direction_deg=20, center_m=(0.2, 1, -0.1), size_m=(3, 2)),
    "optomotor drum": optomotor_drum(18, -90.0),
    "bar": Bar(20, 60, 90.0, direction_deg=45),
    "edge": edge(40.0, -20.0),
    "looming disc": LoomingDisc(azimuth_deg=20, elevation_deg=10),
    "target": Target(4, [0, 1], [-40, 60], [0, 10]),
    "dots": RandomDots(300, 10.0, direction_deg=20),
    "stars": Starfield(200, 0.05),
    "panorama": NoisePanorama(pixel_deg=1.0, direction_deg=-30),
    "leds": LedArena(DrumGrating(30, 2), 0.5, refresh_hz=20),
}


def eye_of(axes, acceptance_deg):
    return omma.Eye(np.zeros_like(axes), axes, np.radians(acceptance_deg))


def axes_ahead(count=16):
    """Directions within 60° of straight ahead, of which the last look at what moves."""
    rng = np.random.default_rng(1)
    axes = direction(rng.uniform(-60, 60, count), rng.uniform(-40, 40, count))
    axes[-3:] = direction([20.0, -40.0, 40.0], [10.0, 0.0, 8.0])
    return axes


@pytest.mark.parametrize("name", STIMULI)
def test_what_is_rendered_is_what_is_expected(name):
    stimulus, axes = STIMULI[name], axes_ahead()
    renderer = omma.Renderer(stimulus.world(), eye_of(axes, 6.0), omma.Fixed(2048))
    responses = stimulus.play(renderer, TIMES_S)
    assert responses.shape == (3, 16, 3)
    assert (responses[..., 0] == responses[..., 2]).all()
    expected = stimulus.expected(axes, np.radians(6.0), TIMES_S)
    # 2,048 rays across edges are off by up to about 0.004, the quadrature by 0.0005.
    assert np.abs(responses[..., 1] - expected).max() < 0.006
    # It is seen, and it moves.
    assert expected.std(axis=0).max() > 0.02


@pytest.mark.parametrize("name", STIMULI)
def test_single_rays_see_the_radiance_itself(name):
    stimulus = STIMULI[name]
    rng = np.random.default_rng(2)
    axes = direction(rng.uniform(-180, 180, 2000), rng.uniform(-60, 60, 2000))
    renderer = omma.Renderer(stimulus.world(), eye_of(axes, 0.0), omma.Fixed(1))
    seen = stimulus.play(renderer, [0.3])[0, :, 1]
    off = np.abs(seen - stimulus.radiance(axes, 0.3))
    # Exact to 1e-3 but where a ray passes within the fraction of a degree by which polygons differ
    # from circles and meridians from chords; and on a sine that narrows towards the poles of its
    # sphere, where the mesh's triangles of 1° interpolate it: to 1e-3 up to latitudes of 60°.
    assert np.mean(off > 1e-3) < (0.02 if name == "sphere" else 0.003)
    if name == "sphere":
        _, latitude = longitude_latitude_deg(axes, 0.0, stimulus.direction_deg)
        assert off[np.abs(latitude) < 60].max() < 1e-3
    expected = stimulus.expected(axes[:50], 0.0, [0.3])[0]
    assert expected == pytest.approx(stimulus.radiance(axes[:50], 0.3), abs=1e-9)


@pytest.mark.parametrize("kind", [DrumGrating, SphereGrating])
@pytest.mark.parametrize(
    ("wavelength_deg", "acceptance_deg"), [(60, 5), (20, 2), (20, 5), (15, 6), (10, 5), (6, 4.5)]
)
def test_gratings_answer_with_the_modulation_transfer_of_a_gaussian(
    kind, wavelength_deg, acceptance_deg
):
    grating = kind(wavelength_deg, 2.0, contrast=0.9, mean=0.4)
    times = np.arange(8) / 16  # one period
    axes = direction([0.0, 33.0], [0.0, 0.0])
    renderer = omma.Renderer(grating.world(), eye_of(axes, acceptance_deg), omma.Fixed(1024))
    played = grating.play(renderer, times)[..., 0]
    expected = grating.expected(axes, np.radians(acceptance_deg), times)
    transfer = np.exp(-3.5597 * (acceptance_deg / wavelength_deg) ** 2)
    for responses in (played, expected):
        wave = 2 / len(times) * np.exp(-4j * np.pi * times) @ responses / 0.4
        assert np.abs(wave) == pytest.approx(0.9 * transfer, abs=0.005)
        # sin(2π(a/λ - f t)) has, at f, the complex amplitude i exp(-2πi a/λ).
        phase = 2 * np.pi * np.array([0.0, 33.0]) / wavelength_deg
        if transfer > 0.1:
            assert np.abs(np.angle(wave * np.exp(1j * phase) / 1j)).max() < np.radians(1)
        assert responses.mean(axis=0) == pytest.approx(0.4, abs=0.002)


def test_gratings_drift_where_they_are_told_to():
    ahead = direction([0.0], [0.0])
    # The wave rises to the right; drifting that way what is ahead gets darker at first.
    for grating, sign in (
        (DrumGrating(20, 1), -1),
        (DrumGrating(20, 1, direction="left"), 1),
        (SphereGrating(20, 1), -1),
        (SphereGrating(20, 1, direction_deg=90), -1),
        (PlaneGrating(0.5, 1, direction_deg=180), -1),
    ):
        change = grating.expected(ahead, 0.01, [0.1]) - 0.5
        assert np.sign(change) == sign
    above = SphereGrating(20, 1, direction_deg=90)
    assert above.radiance(direction(0.0, 5.0), 0.0) == pytest.approx(1.0)
    assert above.radiance(direction(0.0, 5.0 + 20 * 0.3), 0.3) == pytest.approx(1.0)
    drum = DrumGrating(20, 1)
    assert drum.radiance(direction(5.0 + 20 * 0.3, 10.0), 0.3) == pytest.approx(1.0)
    # To the left as seen in front of a wall, ahead along the ground.
    wall = PlaneGrating(0.5, 1, direction_deg=180)
    assert wall.transforms([0.1])[0, 0, 0, 3] == pytest.approx(-0.05)
    ground = PlaneGrating(0.5, 1, direction_deg=90, center_m=(0, -1, 0))
    assert ground.transforms([0.1])[0, 0, 2, 3] == pytest.approx(-0.05)


ASKEW = (0, 0.01, -0.01, 0.6, -0.6)


@pytest.mark.parametrize("height_m", [1.5, -1.5])
@pytest.mark.parametrize("direction_deg", [0, 90, 30])
def test_a_ceiling_drifts_as_the_ground_does(height_m, direction_deg):
    """To the right of who looks ahead, or ahead, also where the plane is askew."""
    angle = np.radians(direction_deg)
    for x, z in [(x, z) for x in ASKEW for z in ASKEW]:
        grating = PlaneGrating(
            1.0, 1, direction_deg=direction_deg, center_m=(x, height_m, z), size_m=(9, 9)
        )
        ((linear,), _) = grating.velocities([0.1])["plane"]
        normal = np.array([x, height_m, z]) / np.linalg.norm([x, height_m, z])
        ahead = np.array([0.0, 0, -1]) + normal[2] * normal
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, normal * np.sign(normal[1]))
        assert linear == pytest.approx(np.cos(angle) * right + np.sin(angle) * ahead)
        assert right[0] > 0.9
        assert ahead[2] < -0.9


DRIFTS = [
    ((0, 1.5, 0), 0, (1, 0, 0)),
    ((0, 1.5, 0), 90, (0, 0, -1)),
    ((0, 1.5, -0.01), 90, (0, 0, -1)),
    ((0, 1.5, 0.01), 0, (1, 0, 0)),
    ((0, -1.5, 0), 0, (1, 0, 0)),
    ((0.3, -1.5, 0.3), 90, (0, 0, -1)),
    ((0.9, 1.5, 0), 0, (1, 0, 0)),
    ((0.9, 1.5, 0.2), 90, (0, 0, -1)),
    ((0, 0, -1.5), 0, (1, 0, 0)),
    ((0, 0, -1.5), 90, (0, 1, 0)),
    ((1.5, 0, 0), 0, (0, 0, 1)),
    ((1.5, 0.2, 0), 90, (0, 1, 0)),
    ((0, 1.5, -1.5), 0, (1, 0, 0)),
    ((0, 1.5, -1.5), 90, (0, 1, 1)),
]


@pytest.mark.parametrize(("center_m", "direction_deg", "way"), DRIFTS)
def test_stripes_are_seen_to_go_that_way(center_m, direction_deg, way):
    grating = PlaneGrating(0.6, 1, direction_deg=direction_deg, center_m=center_m, size_m=(9, 9))
    normal = np.array(center_m) / np.linalg.norm(center_m)
    along = way - (normal @ way) * normal  # what of it is along the plane
    along /= np.linalg.norm(along)
    places = center_m + np.linspace(-0.4, 0.4, 9)[:, None] * along

    def seen(points, time_s):
        axes = points / np.linalg.norm(points, axis=1, keepdims=True)
        renderer = omma.Renderer(grating.world(), eye_of(axes, 0.0), omma.Fixed(1))
        responses = grating.play(renderer, [time_s])[0, :, 1]
        assert responses == pytest.approx(grating.radiance(axes, time_s), abs=2e-3)
        return responses

    # A tenth of a second later the same stripes are 6 cm further on.
    on = 0.06 * along
    before = seen(places, 0.0)
    assert seen(places + on, 0.1) == pytest.approx(before, abs=0.01)
    assert np.abs(seen(places - on, 0.1) - before).max() > 0.1


def test_an_optomotor_drum_turns_with_its_speed():
    drum = optomotor_drum(12, -45.0, height_deg=50)
    assert drum.wavelength_deg == 30
    assert drum.radiance(direction([5.0, 10, -5], [0.0, 0, 0]), 0.0).tolist() == [1, 1, 0]
    # After 1 s all of it is 45° further to the left.
    assert drum.radiance(direction([-40.0, -35, -50], [0.0, 0, 0]), 1.0).tolist() == [1, 1, 0]
    assert drum.radiance(direction(5.0, 50.5), 0.0) == drum.background


@pytest.mark.parametrize("away_deg", [-1.5, 0.0, 0.4, 1.0])
def test_an_edge_is_the_integral_of_a_gaussian(away_deg):
    # A field of 2° is flat to 1e-4; the quadrature is right to 5e-4.
    step = edge(10.0, azimuth_deg=0.0, behind=0.0, ahead=1.0)
    sigma = 2 / np.sqrt(8 * np.log(2))
    expected = (1 + erf(away_deg / sigma / np.sqrt(2))) / 2
    found = step.expected(direction([away_deg], [0.0]), np.radians(2), [0.0])[0, 0]
    assert found == pytest.approx(expected, abs=6e-4)
    moved = step.expected(direction([away_deg + 10], [0.0]), np.radians(2), [1.0])[0, 0]
    assert moved == pytest.approx(expected, abs=6e-4)


def test_a_bar_goes_where_it_should():
    bar = Bar(10, 40, 50.0, azimuth_deg=-20, direction_deg=90, bar=1.0, background=0.0)
    # Upwards, from 20° below the horizon, 40° wide.
    at = direction([0.0, 18, 0, 25], [-20.0, -19, -10, -20])
    assert bar.radiance(at, 0.0).tolist() == [1, 1, 0, 0]
    assert bar.radiance(direction(0.0, 30.0), 1.0) == 1
    assert bar.radiance(direction(0.0, -20.0), 360 / 50) == 1


def test_play_takes_a_pose_for_each_time_and_tells_how_far_it_is():
    grating = DrumGrating(20, 1)
    renderer = omma.Renderer(grating.world(), eye_of(axes_ahead(3), 3.0), omma.Fixed(64))
    # A head that turns along with the drum sees the same at all times.
    turning = omma.poses_from_angles((0, 0, 0), np.outer(20 * TIMES_S, [1, 0, 0]))
    shares = []
    played = grating.play(renderer, TIMES_S, poses=turning, progress=shares.append)
    # The rays are the same; the sine's interpolation is right to 2e-5.
    assert np.abs(played - played[0]).max() < 1e-4
    assert shares[-1] == pytest.approx(1)
    one = grating.play(renderer, TIMES_S, poses=turning[0])
    assert np.abs(one[1] - one[0]).max() > 0.01
    assert grating.play(renderer, []).shape == (0, 3, 3)

    def stop(share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        grating.play(renderer, TIMES_S, progress=stop)


def test_stimuli_go_into_other_scenes():
    wall = omma.scene.plane((50, 50), (0.2, 0.2, 0.2), center_m=(0, 0, -5), facing=(0, 0, 1))
    fly = Target(3, [0, 1], [-10, 10], [0, 0], target=0.9, name="fly")
    prey = LoomingDisc(disc=0.7, azimuth_deg=40, name="prey")
    world = omma.World(omma.scene.merge_scenes([wall, fly.scene(), prey.scene()]))
    axes = np.concatenate([fly.directions([0.0, 1.0]), direction([40.0], [0.0])])
    renderer = omma.Renderer(world, eye_of(axes, 0.0), omma.Fixed(1))
    prey.move(world, 0.9)
    seen = fly.play(renderer, [0.0, 1.0])[..., 0]
    assert seen == pytest.approx(np.array([[0.9, 0.2, 0.7], [0.2, 0.9, 0.7]]))
    with pytest.raises(omma.Error, match='nothing called "drum" to move'):
        DrumGrating().play(renderer, [0.0])


@pytest.mark.parametrize("name", STIMULI)
def test_one_time_gives_what_it_has_among_several(name):
    stimulus, time_s = STIMULI[name], TIMES_S[1]
    axes = axes_ahead(4)
    assert np.array_equal(stimulus.transforms(time_s), stimulus.transforms(TIMES_S)[1])
    both = zip(
        stimulus.velocities(time_s).values(), stimulus.velocities(TIMES_S).values(), strict=True
    )
    for alone, several in both:
        assert all(np.array_equal(a, s[1]) for a, s in zip(alone, several, strict=True))
    alone, several = (stimulus.expected(axes, 0.1, times) for times in (time_s, TIMES_S))
    assert alone.shape == (4,)
    assert np.array_equal(alone, several[1])
    with pytest.raises(omma.Error, match=r"times_s: expected shape \(N,\) or a number"):
        stimulus.transforms([[0.0]])


def test_sizes_and_directions_at_one_time():
    disc = LoomingDisc(0.05, 1.0)
    size = disc.size_deg(0.95)
    assert isinstance(size, float)
    assert size == disc.size_deg([0.95])[0] == pytest.approx(90)
    fly = Target(1.0, [0, 1], [-20, 20], [0, 0])
    assert np.array_equal(fly.directions(0.3), fly.directions([0.3])[0])
    assert Target(1.0, [0], [0], [0]).directions(2).shape == (3,)
    assert disc.transforms([]).shape == (0, 1, 4, 4)


def test_transforms_are_those_that_a_renderer_takes():
    for stimulus in STIMULI.values():
        places = stimulus.transforms(TIMES_S)
        assert places.shape == (3, len(stimulus.names), 4, 4)
        world = stimulus.world()
        assert [one.name for one in world.instances] == stimulus.names
        stimulus.move(world, TIMES_S[1])
        found = np.array([one.world_from_node for one in world.instances])
        assert np.allclose(found, places[1])


BAD = [
    (DrumGrating, {"wavelength_deg": 25}, "wavelength_deg: expected 360 over a whole number"),
    (DrumGrating, {"wavelength_deg": -20}, "wavelength_deg: expected 0.2 to 360"),
    (DrumGrating, {"contrast": 1.5}, "contrast: expected 0 to 1"),
    (DrumGrating, {"waveform": "sin"}, "waveform: expected one of sine, square"),
    (DrumGrating, {"direction": "up"}, "direction: expected one of right, left"),
    (DrumGrating, {"mean": -1}, "mean: expected 0 to 1e"),
    (SphereGrating, {"mean": 0}, "mean: expected a radiance above 0, to which the contrast is"),
    (NoisePanorama, {"mean": 0}, "mean: expected a radiance above 0, to which the contrast is"),
    (SphereGrating, {"temporal_frequency_hz": np.nan}, "temporal_frequency_hz: expected"),
    (SphereGrating, {"name": ""}, "name: expected"),
    (PlaneGrating, {"center_m": (0, 0, 0)}, "center_m: expected 0.001 to 1e6 m"),
    (PlaneGrating, {"wavelength_m": 1e-5}, "size_m: expected at most 100,000 periods"),
    (Bar, {"width_deg": 360}, "width_deg: expected 0.01 to 359.9"),
    (LoomingDisc, {"l_over_v_s": 0}, "l_over_v_s: expected"),
    (LoomingDisc, {"largest_deg": 180}, "largest_deg: expected 0.01 to 175"),
    (RandomDots, {"count": 0}, "count: expected 1 to"),
    (Starfield, {"radius_m": 2.0}, "radius_m: expected"),
    (NoisePanorama, {"slope": -1}, "slope: expected 0 to 4"),
]


@pytest.mark.parametrize(("kind", "given", "message"), BAD)
def test_bad_parameters_are_named(kind, given, message):
    with pytest.raises(omma.Error, match=message):
        kind(**given)


def test_black_is_black_where_no_contrast_is_asked():
    assert SphereGrating(mean=0, contrast=0).radiance([[0, 0, -1]], 0.0) == 0


def test_bad_paths_and_arenas_are_named():
    with pytest.raises(omma.Error, match="path_s: expected one or more times that grow"):
        Target(1, [0, 0], [0, 1], [0, 0])
    with pytest.raises(omma.Error, match=r"azimuth_deg: expected shape \(2,\)"):
        Target(1, [0, 1], [0, 1, 2], [0, 0])
    with pytest.raises(omma.Error, match="elevation_deg: expected angles from -90 to 90"):
        Target(1, [0, 1], [0, 1], [0, 91])
    with pytest.raises(omma.Error, match="points 0 and 1 opposite to each other"):
        Target(1, [0, 1], [0, 180], [0, 0])
    with pytest.raises(TypeError, match="shown: expected a stimulus other than an arena"):
        LedArena(LedArena(DrumGrating()))
    with pytest.raises(omma.Error, match="duration_s: expected at most 20,000 frames"):
        LedArena(DrumGrating(), 100.0)
    with pytest.raises(omma.Error, match="panels_up: expected at most 268,435,456 pixels"):
        LedArena(DrumGrating(), panels_around=100, panels_up=100)
    with pytest.raises(omma.Error, match="bits: expected 1 to 8"):
        LedArena(DrumGrating(), bits=9)


def test_bad_questions_are_named():
    drum = DrumGrating()
    with pytest.raises(omma.Error, match=r"axes: expected shape \(N, 3\)"):
        drum.expected([0, 0, 1], 0.1, [0])
    with pytest.raises(omma.Error, match="axes: expected directions"):
        drum.expected([[0, 0, 0]], 0.1, [0])
    with pytest.raises(omma.Error, match="acceptance_rad: expected angles from 0 to π"):
        drum.expected([[0, 0, 1]], -0.1, [0])
    with pytest.raises(omma.Error, match=r"acceptance_rad: expected shape \(1,\)"):
        drum.expected([[0, 0, 1]], [0.1, 0.2], [0])
    with pytest.raises(omma.Error, match="times_s: expected seconds"):
        drum.expected([[0, 0, 1]], 0.1, [np.nan])
    with pytest.raises(omma.Error, match="directions: expected vectors of length 1"):
        drum.radiance([0, 0, 2], 0)
    with pytest.raises(TypeError, match=r"renderer: expected omma\.Renderer"):
        drum.play(drum.world(), [0])
    renderer = omma.Renderer(drum.world(), eye_of(axes_ahead(3), 3.0), omma.Fixed(1))
    with pytest.raises(omma.Error, match="poses: expected shape"):
        drum.play(renderer, TIMES_S, poses=np.zeros((2, 4, 4)))
