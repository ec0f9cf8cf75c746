"""Motion detectors in a closed loop: what they answer moves the world, and the head.

What was seen on the way, rendered again and given to the detectors at once, must be the same bits.
"""

import math

import numpy as np
import pytest

import omma

FRAMES, RATE_HZ, TAU_S = 40, 200.0, 0.02


@pytest.fixture(scope="module")
def fly():
    """A coarse eye, and its detectors between neighbours in a row."""
    eye = omma.eye.generate_eye(400, radius_m=1e-3).replace(acceptance_angle_rad=0.12)
    detectors = omma.motion.detector_array(eye, TAU_S, RATE_HZ, high_pass_tau_s=0.1)
    return eye, detectors


@pytest.fixture(scope="module")
def scene():
    """Blotches all round, and a ball before them."""
    picture = np.random.default_rng(4).random((8, 40, 3)).astype(np.float32)
    ball = omma.scene.sphere(0.2, (0.05, 0.05, 0.05), segments=24, name="ball")
    return omma.scene.merge_scenes([omma.scene.drum(2.0, 4.0, picture), ball])


def ball_at(azimuth_deg):
    place = np.eye(4)
    place[:3, 3] = 1.2 * omma.eye.direction(azimuth_deg, 10.0)
    return place


def heading(azimuth_deg):
    return omma.look_at((0, 0, 0), omma.eye.direction(azimuth_deg, 0.0))


def rightward(detectors, eye, outputs):
    """The mean motion to the right, of those that look ahead: one number."""
    vectors = detectors.vectors(outputs, axis=-2)[:, 1]
    chosen = np.isfinite(vectors[:, 0]) & (eye.axis[:, 2] < -0.5)
    return float(vectors[chosen, 0].mean())


def closed_loop(renderer, fly):
    """The head turns after what moves, and the ball flees from what the head does: the azimuths of
    both in every frame, and all outputs."""
    eye, detectors = fly
    head, ball = 0.0, -20.0
    heads, balls, outputs = [], [], []
    state, frame = None, np.empty((1, len(eye), 3), np.float32)
    for _ in range(FRAMES):
        heads.append(head)
        balls.append(ball)
        renderer.world.set_transforms("ball", ball_at(ball))
        renderer.render(heading(head), out=frame)
        state, answer = detectors.step(state, frame[0])
        outputs.append(answer)
        turn = 2000 * rightward(detectors, eye, answer)
        head += float(np.clip(turn, -3, 3))
        ball += 2.0 + 0.3 * turn
    return heads, balls, np.stack(outputs)


@pytest.mark.parametrize("backend", ["embree", "portable"])
def test_a_loop_is_the_same_bits_as_its_frames_at_once(scene, fly, backend):
    eye, detectors = fly
    world = omma.World(scene, backend=backend)
    heads, balls, outputs = closed_loop(omma.Renderer(world, eye, omma.Fixed(8), threads=1), fly)
    assert np.ptp(heads) > 1  # it did turn
    assert np.unique(balls).size == FRAMES
    # Anew, in a world and with threads of its own, from what was written down.
    world = omma.World(scene, backend=backend)
    renderer = omma.Renderer(world, eye, omma.Fixed(8), threads=2)
    frames = np.empty((FRAMES, len(eye), 3), np.float32)
    for t in range(FRAMES):
        renderer.world.set_transforms("ball", ball_at(balls[t]))
        frames[t] = renderer.render(heading(heads[t]))[0]
    assert (detectors.run(frames) == outputs).all()
    assert (detectors.run(frames[:, :, 1]) == outputs[:, :, 1]).all()


def test_the_same_loop_again_is_the_same_bits(scene, fly):
    renderer = omma.Renderer(scene, fly[0], omma.Fixed(8))
    first = closed_loop(renderer, fly)
    again = closed_loop(renderer, fly)  # from the end of the one before
    assert first[:2] == again[:2]
    assert (first[2] == again[2]).all()


def test_a_turning_head_in_one_batch(scene, fly):
    """Where nothing but the head moves, all poses can be rendered in one call."""
    eye, detectors = fly
    renderer = omma.Renderer(scene, eye, omma.Fixed(8))
    state, head, heads, outputs = None, 0.0, [], []
    for t in range(FRAMES):
        heads.append(head)
        state, answer = detectors.step(state, renderer.render(heading(head))[0])
        outputs.append(answer)
        # Its own wobble, and a reflex against what then moves.
        head += math.sin(0.4 * t) + float(np.clip(500 * rightward(detectors, eye, answer), -1, 1))
    poses = np.stack([heading(azimuth) for azimuth in heads])
    frames = renderer.render(poses)
    assert (detectors.run(frames) == np.stack(outputs)).all()
    # And in pieces, as a long flight is.
    state, pieces = None, []
    for frame in np.concatenate([renderer.render(poses[:11]), renderer.render(poses[11:])]):
        state, answer = detectors.step(state, frame)
        pieces.append(answer)
    assert (np.stack(pieces) == np.stack(outputs)).all()
