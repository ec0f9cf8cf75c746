"""A stimulus plays in worlds that show it, and in no others."""

import copy

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
    Starfield,
    Target,
)

EYE = omma.Eye(np.zeros((1, 3)), [(0, 0, -1.0)], np.radians(5.0))
TIMES_S = np.arange(0, 1, 0.25)


def renderer_of(world, rays=16):
    return omma.Renderer(world, EYE, omma.Fixed(rays))


def arena(contrast):
    return LedArena(DrumGrating(30, 5, contrast=contrast), 0.2, refresh_hz=20, bits=8)


# (of which the world is, another of its kind, what it is another of)
OTHERS = [
    (DrumGrating(20), DrumGrating(20, contrast=0.5), "picture"),
    (DrumGrating(20), DrumGrating(20, waveform="square"), "picture"),
    (DrumGrating(20), DrumGrating(30), "place of the picture"),
    (DrumGrating(20), DrumGrating(20, height_m=1.0), "shape"),
    (DrumGrating(20), DrumGrating(20, background=0.1), "background"),
    (SphereGrating(24), SphereGrating(24, mean=0.4), "picture"),
    (PlaneGrating(0.5), PlaneGrating(0.5, phase_deg=90), "place of the picture"),
    (Bar(10), Bar(20), "shape"),
    (Bar(10), Bar(10, bar=0.2), "color"),
    (LoomingDisc(), LoomingDisc(disc=0.1), "color"),
    (Target(2, [0], [0], [0]), Target(3, [0], [0], [0]), "shape"),
    (RandomDots(50), RandomDots(50, seed=1), "shape"),
    (RandomDots(50), RandomDots(40), "shape"),
    (Starfield(9), Starfield(9, star=0.5), "color"),
    (Starfield(9), Starfield(8), "number of things, as there is star 8"),
    (NoisePanorama(pixel_deg=5), NoisePanorama(pixel_deg=5, seed=1), "picture"),
    (NoisePanorama(pixel_deg=5), NoisePanorama(pixel_deg=10), "picture"),
    (arena(1.0), arena(0.5), "picture"),
]


@pytest.mark.parametrize(("one", "other", "what"), OTHERS)
def test_a_world_of_another_stimulus_is_refused(one, other, what):
    world = one.world()
    for act in (lambda: other.play(renderer_of(world), TIMES_S), lambda: other.move(world, 0.0)):
        with pytest.raises(omma.Error, match=f"world: expected .* found another {what}.*world()"):
            act()
    one.move(world, 0.0)


def test_contrast_is_that_of_the_stimulus_that_is_played():
    """As a loop over contrasts is written."""
    for contrast in (1.0, 0.1):
        grating = DrumGrating(20, contrast=contrast)
        seen = grating.play(renderer_of(grating.world(), 1024), TIMES_S)[:, 0, 1]
        expected = grating.expected(EYE.axis, EYE.acceptance_angle_rad, TIMES_S)[:, 0]
        # Of 1,024 rays, footprints and all.
        assert np.abs(seen - expected).max() < 0.01 * contrast


@pytest.mark.parametrize("one", [first for first, _, _ in OTHERS])
def test_equal_stimuli_are_one(one, tmp_path):
    again = copy.deepcopy(one)
    again.play(renderer_of(one.world()), [0.1])
    omma.scene.save_scene(tmp_path / "one.glb", one.scene())
    again.play(renderer_of(omma.World(omma.load_scene(tmp_path / "one.glb"))), [0.1])


def test_what_moves_otherwise_plays_in_the_same_world():
    """Speeds, paths and times of collision are no part of the world."""
    renderer = renderer_of(LoomingDisc(0.05).world())
    slow = LoomingDisc(0.1, azimuth_deg=5)
    assert np.ptp(slow.play(renderer, [0.0, 0.9])) > 0.1
    Bar(10, speed_deg_s=20).play(renderer_of(Bar(10).world()), TIMES_S)


def test_what_was_changed_in_the_world_on_purpose_is_shown():
    drum = DrumGrating(20)
    world = drum.world()
    world.set_image(0, np.full((1, 512, 3), 0.25))
    assert drum.play(renderer_of(world), [0.0])[0, 0] == pytest.approx([0.25] * 3)
    before = drum.world().with_background(omma.Background.constant([0.1] * 3))
    drum.play(renderer_of(before), [0.0])
    two = omma.scene.merge_scenes(
        [drum.scene(), Bar(10).scene()], background=omma.Background.constant([0.1] * 3)
    )
    drum.play(renderer_of(omma.World(two)), [0.0])
