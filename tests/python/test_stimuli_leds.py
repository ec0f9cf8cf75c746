"""Arenas of LEDs say where pixels, frames and levels are too few for what they show."""

import warnings

import numpy as np
import pytest

import omma
from omma.stimuli import (
    Bar,
    DrumGrating,
    LedArena,
    LoomingDisc,
    NoisePanorama,
    PlaneGrating,
    RandomDots,
    SphereGrating,
    Target,
)


def period(contrast=1.0, bits=3, brightest=1.0, **more):
    """An arena that shows a period of a grating, and nothing wrong but levels."""
    grating = DrumGrating(30, 2, contrast=contrast, **more)
    return LedArena(grating, 0.5, bits, refresh_hz=20, brightest=brightest)


# (an arena, what is said of it)
TOLD = [
    (lambda: LedArena(DrumGrating(30, 30), 1, refresh_hz=40), r"refresh_hz: 30 .* like -10 \("),
    (lambda: LedArena(DrumGrating(30, -30), 1, refresh_hz=40), r"refresh_hz: .* above 60"),
    (lambda: LedArena(SphereGrating(30, 20), 1, refresh_hz=40), "refresh_hz: 20 periods"),
    (
        lambda: LedArena(DrumGrating(4, 1), 1, 8, refresh_hz=48),
        r"wavelength_deg: 4° on pixels of 3\.75° .* 60°.* panels_around=23",
    ),
    (lambda: LedArena(DrumGrating(3.75, 1), 1, refresh_hz=48), "wavelength_deg: .* an even light"),
    (
        lambda: LedArena(PlaneGrating(0.1, 1), 1, refresh_hz=48),
        r"wavelength_m: 5\.73° on pixels",
    ),
    (
        lambda: LedArena(DrumGrating(30, 1.5), refresh_hz=40),
        r"duration_s: .* jumps by 0\.5 periods.*duration_s=2 ",
    ),
    (
        lambda: LedArena(DrumGrating(30, 2), 0.51, refresh_hz=72),
        r"duration_s: 0\.51 s are 36\.72 frames .* 37 .* refresh_hz=72\.549, or duration_s=0\.5138",
    ),
    (
        lambda: LedArena(NoisePanorama(pixel_deg=5), 72, refresh_hz=0.0139),
        r"refresh_hz: .*0\.0139 s between frames would be 71\.9",
    ),
    (lambda: LedArena(Target(1, [0], [0], [0]), refresh_hz=40), "diameter_deg: 1° is less than"),
    (lambda: LedArena(RandomDots(50, 2.0), refresh_hz=40), "diameter_deg: 2° is less than"),
    (lambda: LedArena(Bar(3), refresh_hz=40), "width_deg: 3° is less than"),
]
SHOWN = [
    *((period(contrast), r"bits: .* 0\.429 and 0\.571 alone.*bits=8") for contrast in (0.02, 0.2)),
    (period(0), r"bits: radiances from 0\.5 to 0\.5 are shown as 0\.571 alone.*brightest=0\.5"),
    (period(0.1, waveform="square"), r"bits: .* 0\.429 and 0\.571 alone"),
    (period(brightest=0.3), r"brightest: .* up to 0\.999, of which all above 0\.3 .*brightest=1 "),
    (period(0.002, bits=8), "bits: .* of more contrast"),
    (LedArena(Bar(30), bits=1, refresh_hz=20), r"bits: .* 0 and 1 alone.*brightest=0\.5"),
]


def sentences(act):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        act()
    return [str(one.message) for one in told if one.filename == __file__]


@pytest.mark.parametrize(("make", "said"), TOLD)
def test_what_pixels_and_frames_cannot_show_is_told(make, said):
    with pytest.warns(UserWarning, match=f"^{said}") as told:
        make()
    assert len(told) == 1
    assert told[0].filename == __file__


@pytest.mark.parametrize(("arena", "said"), SHOWN)
def test_what_levels_cannot_show_is_told(arena, said):
    with pytest.warns(UserWarning, match=f"^{said}") as told:
        arena.world()
    assert len(told) == 1
    assert told[0].filename == __file__


def test_what_is_told_is_so():
    """That a grating looks coarser and goes backwards, in pixels."""
    with pytest.warns(UserWarning, match="wavelength_deg"):
        fine = LedArena(DrumGrating(4, 1), 1, 8, refresh_hz=48)
    spectrum = np.abs(np.fft.fft(fine.pixels(0)[16]))
    assert 1 + np.argmax(spectrum[1:48]) == 360 / 60
    with pytest.warns(UserWarning, match="refresh_hz"):
        fast = LedArena(DrumGrating(30, 30), 1, 8, refresh_hz=40)
    waves = [np.fft.fft(fast.pixels((k + 0.5) / 40)[16])[12] for k in range(4)]
    # By -10 Hz in 1/40 s; of 8 bits and flat panels it is right to a degree.
    turned = np.degrees(np.angle(np.divide(waves[1:], waves[:-1])))
    assert turned == pytest.approx(90, abs=1)  # to the right is -360° f t


GRATING = DrumGrating(wavelength_deg=20, temporal_frequency_hz=2)
QUIET = [
    # Of the pages.
    lambda: LedArena(GRATING, duration_s=0.5, refresh_hz=72),
    lambda: LedArena(DrumGrating(30, 2), 0.5),
    lambda: LedArena(DrumGrating(30, 2), 0.5, bits=2, refresh_hz=24),
    lambda: LedArena(DrumGrating(30, 2), duration_s=0.5, refresh_hz=100),
    lambda: LedArena(RandomDots(100, 12.0), 0.5, bits=1, brightest=0.5, refresh_hz=40),
    # With the default refresh, of 571 and three sevenths of a frame in a second.
    lambda: LedArena(DrumGrating()),
    # Black and white are what one bit is for.
    lambda: LedArena(DrumGrating(30, 2, "square"), 0.5, bits=1, refresh_hz=20),
    lambda: LedArena(DrumGrating(30, 2), 0.5, bits=1, refresh_hz=20),
    lambda: LedArena(LoomingDisc(), duration_s=2, refresh_hz=40),
    lambda: LedArena(Target(6, [0, 1], [-40, 40], [0, 0]), refresh_hz=40),
    lambda: LedArena(NoisePanorama(pixel_deg=5), refresh_hz=20),
    lambda: LedArena(DrumGrating(contrast=0, mean=0), refresh_hz=20),
    lambda: LedArena(DrumGrating(30, 0), refresh_hz=20),
    lambda: LedArena(DrumGrating(30, 2, contrast=0.2), 0.5, 8, refresh_hz=20),
]


@pytest.mark.parametrize("make", QUIET)
def test_nothing_is_said_where_nothing_is_wrong(make):
    assert sentences(lambda: make().world(threads=1)) == []


def test_a_jump_back_is_told_where_it_is_played():
    disc = LedArena(LoomingDisc(collision_s=0.5), duration_s=0.6, refresh_hz=20)
    turn = LedArena(Bar(30, speed_deg_s=360), 1.0, refresh_hz=20)
    eye = omma.Eye(np.zeros((1, 3)), [(0, 0, -1.0)], 0.1)
    seen = {arena: omma.Renderer(arena.world(), eye, omma.Fixed(1)) for arena in (disc, turn)}
    once = np.arange(0, 0.6, 0.1)
    assert sentences(lambda: disc.play(seen[disc], once)) == []
    assert sentences(lambda: turn.play(seen[turn], np.arange(0, 3, 0.1))) == []
    assert sentences(lambda: disc.play(seen[disc], [])) == []
    with pytest.warns(UserWarning, match="^duration_s: what is played goes beyond the 12 frames"):
        disc.play(seen[disc], [0.1, 0.7])
    h = omma.photoreceptors.ImpulseResponse.exponential(0.02)
    lasting = omma.Renderer(disc.world(), eye, omma.Fixed(1), impulse_response=h)
    with pytest.warns(UserWarning, match="^duration_s: what is played .* what was shown before"):
        disc.play(lasting, [0.0, 0.1])
