"""An eye whose acceptances change from frame to frame: only the directions that it is asked for are
made, which are those that all of them would be."""

import numpy as np
import pytest

import omma

POSE = omma.look_at((0, 1, 0), (0, 1, -5))


@pytest.fixture(scope="module")
def world():
    return omma.World(omma.load_scene(omma.examples.meadow()))


@pytest.fixture(scope="module")
def eyes():
    rng = np.random.default_rng(4)
    grown = omma.eye.generate_eye(200)
    return [
        # All widths different, and few of them.
        grown.replace(acceptance_angle_rad=np.radians(rng.uniform(2, 6, 200))),
        grown.replace(acceptance_angle_rad=np.radians(rng.integers(2, 6, 200))),
    ]


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("samples", [1, 16, 100])
def test_frame_0_is_the_same_whatever_is_made(world, eyes, which, samples):
    eye = eyes[which]
    some = omma.Renderer(world, eye, omma.Fixed(samples))
    every = omma.Renderer(world, eye, omma.Fixed(samples), noise="new_every_frame")
    for standard_error in (False, True):
        found = some.render(POSE, standard_error=standard_error)
        expected = every.render(POSE, standard_error=standard_error, first_pose=0)
        for one, other in zip(np.atleast_2d(found), np.atleast_2d(expected)):
            assert one.tobytes() == other.tobytes()
    assert some.render_rays(POSE).tobytes() == every.render_rays(POSE, first_pose=0).tobytes()
    # Frozen: later frames have the noise of the first.
    later = some.render(np.stack([POSE, POSE]), first_pose=7)
    assert later[0].tobytes() == later[1].tobytes() == some.render(POSE)[0].tobytes()


def test_a_changed_eye_is_as_a_new_one(world, eyes):
    first, second = eyes
    for sampling in (omma.Fixed(16), omma.ToError(0.05)):
        new = omma.Renderer(world, second, sampling)
        changed = omma.Renderer(world, first, sampling).with_eye(second)
        assert changed.render(POSE).tobytes() == new.render(POSE).tobytes()
        # Made before, and kept by the renderers that came of one.
        again = changed.with_eye(first).with_eye(second)
        assert again.render(POSE).tobytes() == new.render(POSE).tobytes()
        back = changed.with_eye(first)
        expected = omma.Renderer(world, first, sampling).render(POSE)
        assert back.render(POSE).tobytes() == expected.tobytes()
