"""Discs, targets, dots, stars, noise and LEDs are what they are said to be."""

import numpy as np
import pytest
from scipy.special import gammaln, lpmv

import omma
from omma.base.directions import direction
from omma.stimuli import (
    Bar,
    DrumGrating,
    LedArena,
    LoomingDisc,
    NoisePanorama,
    RandomDots,
    Starfield,
    Target,
)
from omma.stimuli.panoramas import clipped_noise


def share_by_counting(stimulus, axis, acceptance_rad, time_s, value):
    """The share of a Gaussian field that a stimulus' discs cover, from a fine grid of directions:
    slow, and with nothing of the package's quadrature."""
    theta = (np.arange(1500) + 0.5) / 1500 * 2.5 * acceptance_rad
    phi = (np.arange(1500) + 0.5) / 1500 * 2 * np.pi
    weight = np.exp(-4 * np.log(2) * (theta / acceptance_rad) ** 2) * np.sin(theta)
    right = np.cross(axis, [0.3, 0.5, 0.9])
    right /= np.linalg.norm(right)
    up = np.cross(right, axis)
    total = 0.0
    for one, heavy in zip(theta, weight):
        around = np.cos(phi)[:, None] * right + np.sin(phi)[:, None] * up
        radiance = stimulus.radiance(np.cos(one) * axis + np.sin(one) * around, time_s)
        total += heavy * np.mean(radiance == value)
    return total / weight.sum()


def test_a_looming_disc_grows_as_it_should():
    disc = LoomingDisc(l_over_v_s=0.04, collision_s=2.0, largest_deg=90)
    # Half a metre of half width at 12.5 m/s is 25 m away after 0 s, 12.5 m after 1 s.
    assert disc.size_deg([0.0, 1.0]) == pytest.approx(
        2 * np.degrees(np.arctan([0.5 / 25, 0.5 / 12.5]))
    )
    assert disc.size_deg([1.96, 1.99, 3.0]) == pytest.approx([90, 90, 90])
    # It comes with a constant speed, l over l/v: 0.1 m / 0.04 s.
    places = disc.transforms([0.5, 0.7])[:, 0]
    assert places[:, :3, 3] == pytest.approx(np.array([[0, 0, -3.75], [0, 0, -3.25]]))
    # Its front looks back at the head.
    assert places[0, :3, 2] == pytest.approx([0, 0, 1])


@pytest.mark.parametrize("acceptance_deg", [1.0, 6.0, 40.0])
@pytest.mark.parametrize("away_deg", [0.0, 4.0, 11.0])
def test_a_disc_s_solid_angle_is_weighed_by_the_sensitivity(acceptance_deg, away_deg):
    disc = LoomingDisc(0.1, 1.0, disc=1.0, background=0.0)  # 11.4° at time 0
    axis, width = direction(away_deg, 0.0), np.radians(acceptance_deg)
    found = disc.expected(axis[None], width, [0.0])[0, 0]
    # The grid's own error: of its 1,500 rings one, which holds up to 5e-4, goes along the rim.
    assert found == pytest.approx(share_by_counting(disc, axis, width, 0.0, 1.0), abs=5e-4)
    if away_deg == 0:
        # A ring is inside or outside: ∫S sinθ from 0 to the rim over that to the end.
        theta = np.linspace(0, np.pi, 400_001)
        weight = np.exp(-4 * np.log(2) * (theta / width) ** 2) * np.sin(theta)
        inside = theta <= np.arctan(0.1)
        assert found == pytest.approx(weight[inside].sum() / weight.sum(), abs=1e-4)


def test_a_looming_disc_rendered_is_the_formula():
    disc = LoomingDisc(0.05, 1.0, disc=0.0, background=1.0)
    times = np.linspace(0, 1, 21)
    axes = direction([0.0, 8.0, 25.0], [0.0, 3.0, 0.0])
    eye = omma.Eye(np.zeros((3, 3)), axes, np.radians(8))
    played = disc.play(omma.Renderer(disc.world(), eye, omma.Fixed(4096)), times)[..., 0]
    # 4,096 rays on a rim are right to about 0.002.
    assert np.abs(played - disc.expected(axes, np.radians(8), times)).max() < 0.004
    assert played[0, 0] > 0.5
    assert played[-1].max() < 1e-3


def test_a_target_flies_on_great_circles():
    fly = Target(2, [0, 1, 3], [0, 90, 90], [0, 0, 60])
    at = fly.directions([-1, 0, 0.5, 1, 2, 3, 9])
    assert at == pytest.approx(
        direction([0, 0, 45, 90, 90, 90, 90], [0, 0, 0, 0, 30, 60, 60]), abs=1e-12
    )
    # With a constant speed, also across the pole of azimuths.
    over = Target(2, [0, 1], [0, 180], [80, 80]).directions(np.linspace(0, 1, 5))
    steps = np.degrees(np.arccos(np.sum(over[1:] * over[:-1], axis=1)))
    assert steps == pytest.approx([5, 5, 5, 5])
    assert over[2] == pytest.approx([0, 1, 0], abs=1e-12)
    assert Target(2, [1.0], [10], [0]).directions([0, 2]) == pytest.approx(
        np.repeat(direction([10.0], [0.0]), 2, axis=0)
    )


def test_a_target_of_two_degrees_dims_as_its_solid_angle():
    fly = Target(2, [0.0], [0.0], [0.0], target=0.0, background=1.0)
    width = np.radians(5)
    seen = fly.expected(direction([0.0], [0.0]), width, [0])[0, 0]
    # 1 - exp(-4 ln2 (r/Δρ)²): flat, exact to the square of a degree.
    assert 1 - seen == pytest.approx(1 - np.exp(-4 * np.log(2) * (1 / 5) ** 2), rel=1e-3)


def test_overlapping_dots_count_once():
    dots = RandomDots(150, 25.0, dot=1.0, background=0.0)
    axes, width = direction([0.0, 50.0], [0.0, -30.0]), np.radians(15)
    found = dots.expected(axes, width, [0.4])[0]
    for axis, share in zip(axes, found):
        assert share == pytest.approx(share_by_counting(dots, axis, width, 0.4, 1.0), abs=5e-4)
    whole = RandomDots(4000, 60.0, dot=1.0, background=0.0)
    assert whole.expected(axes, width, [0.0]) == pytest.approx(1, abs=1e-12)


def test_random_dots_cover_what_their_number_says():
    rng = np.random.default_rng(0)
    at = rng.normal(size=(4000, 3))
    at /= np.linalg.norm(at, axis=1, keepdims=True)
    covered = [
        np.mean(RandomDots(300, 8.0, seed=seed, dot=1.0, background=0.0).radiance(at, 0.2))
        for seed in range(20)
    ]
    # 20 x 300 dots of 0.12 % each cover 31 %; 80,000 directions, about 25 of them to a dot.
    assert np.mean(covered) == pytest.approx(RandomDots(300, 8.0).coverage, abs=0.01)
    assert RandomDots(300, 8.0).coverage == pytest.approx(0.30623, abs=1e-5)
    # As many to each side.
    centres = np.concatenate([RandomDots(1000, seed=seed)._centres for seed in range(10)])
    assert np.abs(centres.mean(axis=0)).max() < 0.02
    assert np.abs((centres**2).mean(axis=0) - 1 / 3).max() < 0.01


def test_dots_drift_and_come_back():
    dots = RandomDots(100, speed_deg_s=90.0, direction_deg=90)
    at = direction(np.linspace(-180, 180, 400), np.linspace(-80, 80, 400))
    assert (dots.radiance(at, 0.0) == dots.radiance(at, 4.0)).all()
    # Upwards: a quarter of a turn about +X brings what is ahead overhead.
    ahead = dots.radiance(np.array([[0.0, 0.1, -np.sqrt(0.99)]]), 0.0)
    above = dots.radiance(np.array([[0.0, np.sqrt(0.99), 0.1]]), 1.0)
    assert ahead == above


def test_stars_go_past_and_come_again():
    stars = Starfield(50, 0.01, (0.0, 0.0, 2.0), cube_m=4.0, seed=3)
    before, after = stars.positions_m(0.0), stars.positions_m(0.25)
    moved = after - before
    assert np.allclose(moved[:, :2], 0)
    wrapped = moved[:, 2] < 0
    assert moved[~wrapped, 2] == pytest.approx(0.5)
    assert moved[wrapped, 2] == pytest.approx(-3.5)
    assert 0 < wrapped.sum() < 20
    assert np.abs(after).max() <= 2
    assert stars.positions_m(2.0) == pytest.approx(before)
    # Nearer ones are larger: atan(r / distance).
    nearest = np.argmin(np.linalg.norm(before, axis=1))
    towards, distance = before[nearest], np.linalg.norm(before[nearest])
    right = np.cross(towards, [0, 1, 0])
    right /= np.linalg.norm(right)
    for share, seen in ((0.98, 1.0), (1.02, 0.0)):
        aside = towards + share * stars.radius_m * right
        aside /= np.linalg.norm(aside)
        assert stars.radiance(aside, 0.0) == seen, distance


@pytest.mark.parametrize("slope", [0.6, 1.0, 1.5])
def test_noise_has_the_slope_that_it_is_given(slope):
    """C_l ~ l^(-2 slope), from the picture by SciPy's Legendre functions."""
    degrees = np.arange(2, 31)
    power = np.zeros(len(degrees))
    for seed in range(4):
        panorama = NoisePanorama(slope, 0.1, pixel_deg=1.5, seed=seed)
        picture = panorama.picture / 0.5 - 1
        rows, columns = picture.shape
        polar = np.pi * (np.arange(rows) + 0.5) / rows
        area = np.sin(polar) * np.pi / rows * 2 * np.pi
        waves = np.fft.rfft(picture, axis=1) / columns
        for k, degree in enumerate(degrees):
            for m in range(degree + 1):
                norm = np.log((2 * degree + 1) / (4 * np.pi))
                norm += gammaln(degree - m + 1) - gammaln(degree + m + 1)
                legendre = np.exp(norm / 2) * lpmv(m, degree, np.cos(polar))
                amplitude = (area * legendre) @ waves[:, m]
                power[k] += (1 if m == 0 else 2) * np.abs(amplitude) ** 2 / (2 * degree + 1)
    fitted = np.polyfit(np.log(degrees), np.log(power), 1, w=np.sqrt(2 * degrees + 1))[0]
    # Four fields of 957 harmonics: the fit scatters by about 0.03.
    assert fitted == pytest.approx(-2 * slope, abs=0.12)


def test_noise_is_the_same_all_around():
    pictures = [NoisePanorama(1.0, 0.1, pixel_deg=3.0, seed=s).picture for s in range(60)]
    deviation = np.std(pictures, axis=0)
    # At the poles as at the horizon, and behind, where the picture's edges meet, as ahead.
    assert deviation[:5].mean() == pytest.approx(deviation[28:32].mean(), rel=0.2)
    steps = np.abs(np.diff(np.concatenate([pictures, np.array(pictures)[..., :1]], -1), axis=-1))
    steps = steps[:, 20:40].mean(axis=(0, 1))
    assert steps[-1] == pytest.approx(steps.mean(), rel=0.2)
    assert (NoisePanorama(contrast=0.4, pixel_deg=3.0).picture >= 0).all()
    assert (NoisePanorama(pixel_deg=3.0, seed=1).picture != pictures[0]).any()


def in_all_directions(count):
    directions = np.random.default_rng(0).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.mark.parametrize("pixel_deg", [1.0, 3.0, 10.0])
@pytest.mark.parametrize("slope", [0.0, 0.5, 1.0, 2.0])
def test_noise_shows_the_contrast_that_is_asked_for(slope, pixel_deg):
    """Wherever one looks, not in the middles of pixels alone, where there is more of it."""
    seen = NoisePanorama(slope, 0.2, 0.5, pixel_deg, seed=3).radiance(in_all_directions(400_000), 0)
    # Five standard errors of a mean, and of a deviation, of so many directions.
    assert seen.mean() == pytest.approx(0.5, abs=5 * 0.1 / np.sqrt(400_000))
    assert seen.std() / seen.mean() == pytest.approx(0.2, rel=5 / np.sqrt(2 * 400_000))


@pytest.mark.parametrize("slope", [0.0, 0.5, 1.0])
def test_most_contrast_is_nearly_shown(slope):
    """And more than that is refused, with what it would have."""
    for seed in range(3):
        noise = NoisePanorama(slope, 0.4, pixel_deg=1.0, seed=seed)
        seen = noise.radiance(in_all_directions(100_000), 0)
        assert seen.mean() == pytest.approx(0.5, rel=5 * 0.4 / np.sqrt(100_000))
        shown = seen.std() / seen.mean() / 0.4
        assert 0.98 < shown < 1 + 5 / np.sqrt(2 * 100_000)
    for contrast, reached, times in ((0.6, "0.568", "1.01"), (1.0, "0.8", "1.08")):
        with pytest.raises(omma.Error, match=f"contrast: expected 0 to 0.4.*{reached}.*{times}"):
            NoisePanorama(contrast=contrast)


def test_clipped_noise_is_as_by_drawing_it():
    drawn = np.random.default_rng(0).normal(size=1_000_000)
    for contrast in (0.0, 0.4, 0.6, 2.0):
        clipped = np.maximum(1 + contrast * drawn, 0)
        # Of a million: five standard errors of a mean and of a deviation.
        assert clipped_noise(contrast) == pytest.approx(
            (clipped.mean(), clipped.std() / clipped.mean()), rel=0.01
        )


def test_leds_have_pixels_and_levels():
    grating = DrumGrating(120, 1)
    for bits in (1, 2, 4):
        arena = LedArena(grating, bits=bits, refresh_hz=50, brightest=0.9)
        seen = np.unique(np.concatenate([arena.pixels(t).ravel() for t in np.arange(0, 1, 0.02)]))
        levels = np.arange(2**bits) * 0.9 / (2**bits - 1)
        assert seen == pytest.approx(levels)
    arena = LedArena(DrumGrating(30, 1), bits=8, refresh_hz=50)
    assert arena.pixels(0).shape == (32, 96)
    # 96 around, 3.75° each, nearly: they are on flat panels.
    row = arena.pixels(0)[16]
    azimuth = -180 + 3.75 * (np.arange(96) + 0.5)
    ideal = 0.5 + 0.5 * np.sin(2 * np.pi * azimuth / 30)
    assert np.abs(row - ideal).max() < 0.5 / 255 + 0.5 * 2 * np.pi / 30 * 0.2
    # Panels of 32 mm, 12 of them: 16 mm / tan 15° away.
    assert arena.distance_m == pytest.approx(0.0597, abs=1e-4)
    assert LedArena(grating, 0.1).refresh_hz == pytest.approx(4000 / 7)
    assert LedArena(grating, 0.1, bits=1).refresh_hz == 4000


def test_leds_hold_what_they_show():
    arena = LedArena(Bar(30, 180, 360.0, bar=0.2), 1.0, bits=1, refresh_hz=20)
    assert arena.frame_count == 20
    shown = [arena.pixels(t) for t in np.arange(0, 1.2, 0.01)]
    changes = [k for k in range(1, len(shown)) if (shown[k] != shown[k - 1]).any()]
    # From one refresh to the next; after 1 s they come again.
    assert changes == list(range(5, 120, 5))
    assert (arena.pixels(0.31) == arena.pixels(1.31)).all()
    assert (arena.pixels(-0.96) == arena.pixels(0.04)).all()
    # Times that are refreshes but for rounding count as such.
    assert all((arena.pixels(k / 20) == arena.pixels(k / 20 + 1e-6)).all() for k in range(20))
    # Each frame that differs is a drum; one of them is there.
    places = arena.transforms([0.0, 0.12])
    assert places.shape == (2, 20, 4, 4)
    assert ((places[:, :, 0, 0] == 1).sum(axis=1) == 1).all()
    still = LedArena(Bar(30, speed_deg_s=0.0), refresh_hz=50)
    assert still.names == ["leds 0"]


def test_an_eye_sees_the_leds_hold():
    arena = LedArena(DrumGrating(30, 2, "square"), 0.5, bits=1, refresh_hz=10)
    axes = direction([2.0, 40.0], [0.0, 5.0])
    eye = omma.Eye(np.zeros((2, 3)), axes, np.radians(5))
    renderer = omma.Renderer(arena.world(), eye, omma.Fixed(1024))
    played = arena.play(renderer, [0.0, 0.05, 0.099, 0.1, 0.2])[..., 0]
    assert (played[0] == played[1]).all()
    assert (played[0] == played[2]).all()
    assert np.abs(played[3] - played[0]).max() > 0.05
    expected = arena.expected(axes, np.radians(5), [0.0, 0.05, 0.099, 0.1, 0.2])
    # Edges of many pixels, by 1,024 rays.
    assert np.abs(played - expected).max() < 0.006
