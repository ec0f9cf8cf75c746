"""What walks meet: ends by rays, things that move, distances, bounds of observations, and what is
no loop."""

import numpy as np
import pytest
from gym_walks import WALL_M, loop_of, make_walker, start

import omma


@pytest.fixture(scope="module")
def walker():
    return make_walker()


def test_a_wall_ends_it(walker):
    env = omma.gym.eye_env(loop_of(walker, most_steps=None))
    env.reset(seed=1)
    for _ in range(100):
        _, _, ended, cut_off, info = env.step(np.array([1, 0], np.float32))
        assert not cut_off
        nearest = walker.ground_truth(info["pose"]).nearest_m[0].min()
        assert ended == (nearest < 0.3)
        if ended:
            break
    # Of 40 ommatidia the nearest that looks at the wall is close to straight ahead of it, but the
    # wall is a drum of flat sides, and the step 5 cm long.
    assert 0.2 < WALL_M - info["pose"][2, 3] < 0.3


def test_things_that_flee(walker):
    """Each environment has its own, though they share a world."""

    def begin(rng):
        place = np.eye(4)
        place[:3, 3] = rng.uniform(-0.3, 0.3, 3)
        return place, np.eye(4) + [[0] * 4, [0] * 4, [0, 0, 0, 1.2], [0] * 4], place[None]

    def flee(place, action, rng):
        return begin(rng)

    loop = loop_of(
        walker, start=begin, motion=flee, reward=lambda moment: 0.0, distances=False, ended=None,
        things=["crate"],
    )  # fmt: skip
    together = omma.gym.eye_vector_env(loop, 3)
    singles = [omma.gym.eye_env(loop) for _ in range(3)]
    seen = together.reset(seed=5)[0]
    assert (seen == np.stack([env.reset(seed=5 + k)[0] for k, env in enumerate(singles)])).all()
    assert (seen[0] != seen[1]).any()
    actions = together.action_space.sample()
    seen = together.step(actions)[0]
    assert (seen == np.stack([one.step(a)[0] for one, a in zip(singles, actions)])).all()
    crate = walker.world.instances[walker.world.index("crate")]
    assert (crate.world_from_node == np.eye(4)).all()


def test_distances_are_those_of_things_where_they_are(walker):
    """A box that comes nearer by a decimetre a step, along the way ahead: rays get shorter by as
    much, in one environment and in several at once."""
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.0)
    renderer = walker.with_eye(eye)

    def at(step):
        place = np.eye(4)
        place[2, 3] = -0.5 + 0.1 * step
        return step, np.eye(4) + [[0] * 4, [0] * 4, [0, 0, 0, 1.2], [0] * 4], place[None]

    seen = []
    loop = loop_of(
        renderer, start=lambda rng: at(0), motion=lambda step, action, rng: at(step + 1),
        reward=lambda moment: seen.append(float(moment.nearest_m[0])) or 0.0, ended=None,
        things=["crate"],
    )  # fmt: skip
    env = omma.gym.eye_env(loop)
    env.reset(seed=1)
    for _ in range(4):
        env.step(env.action_space.sample())
    np.testing.assert_allclose(np.diff(seen), -0.1, atol=1e-5)
    single = list(seen)
    envs = omma.gym.eye_vector_env(loop, 2)
    envs.reset(seed=1)
    seen.clear()
    for _ in range(4):
        envs.step(envs.action_space.sample())
    assert seen == [one for one in single for _ in range(2)]


def test_bounds_of_worlds(walker):
    bounds = omma.gym.response_bounds
    assert bounds(walker.world) == pytest.approx((0, 1), abs=0.02)
    grey = omma.scene.box((9, 9, 9), (0.5, 0.25, 0.5))
    dark = omma.Background.constant((0, 0, 0))
    assert bounds(omma.World(grey, background=dark)) == pytest.approx((0, 0.5), rel=1e-4)
    bright = omma.Background.constant((3, 0, 0))
    assert bounds(omma.World(grey, background=bright)) == pytest.approx((0, 3), rel=1e-4)
    shining = omma.scene.Material(base_color=(0.5, 0.5, 0.5, 1), emissive=(0, 2, 0))
    world = omma.World(grey.replace(materials=[shining]), background=dark)
    assert bounds(world) == pytest.approx((0, 2.5), rel=1e-4)
    # What a world was given since counts: colours, emission, pictures.
    world.set_color(0, (0.9, 0.1, 0.1), emissive=(0, 0, 4))
    assert bounds(world) == pytest.approx((0, 4.9), rel=1e-4)
    drum = omma.World(omma.scene.drum(1.0, 4.0, np.full((4, 8, 3), 0.5)), background=dark)
    assert bounds(drum) == pytest.approx((0, 0.5), rel=1e-4)
    drum.set_image(0, np.full((4, 8, 3), 2.0))
    assert bounds(drum) == pytest.approx((0, 2), rel=1e-4)
    # Layers cover each other, with what they give off.
    layer = shining.replace(base_color=(0.5, 0.5, 0.5, 0.3), alpha_mode="blend", double_sided=True)
    corners = [(-9, -9, -1), (9, -9, -1), (0, 9, -1)]
    sheets = [
        omma.scene.Mesh(np.array(corners) - (0, 0, k), [(0, 1, 2)], material=0) for k in range(9)
    ]
    layers = omma.World(omma.Scene(meshes=sheets, materials=[layer]), background=dark)
    seen = omma.Renderer(layers, walker.eye, omma.Fixed(16)).render(np.eye(4)).max()
    assert 2.2 < seen <= bounds(layers)[1] == pytest.approx(2.5, rel=1e-4)
    lit = omma.World(grey, light=omma.light.uniform_sky(), ultraviolet="dark")
    assert bounds(lit) == (0, np.inf)
    opponent = omma.World(grey, background=dark, band_from_rgb=np.array([[1.0, -1, 0], [0, 0, 2]]))
    assert bounds(opponent) == pytest.approx((-0.5, 1), rel=1e-4)


def test_a_surround_of_the_largest_is_within(walker):
    world = omma.World(omma.Scene(), background=omma.Background.constant((0.7, 0.7, 0.7)))
    loop = loop_of(omma.Renderer(world, walker.eye, omma.Fixed(16)), distances=False, ended=None)
    env = omma.gym.eye_env(loop)
    assert env.reset(seed=1)[0] in env.observation_space
    assert env.observation_space.high.max() < 0.7001


def test_bounds_that_are_none(walker):
    env = omma.gym.eye_env(loop_of(walker, bounds=(0, 0.2)))
    with pytest.raises(omma.Error, match=r"bounds: expected responses from 0 to 0\.2, found"):
        env.reset(seed=0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"start": lambda rng: np.eye(4)}, r"start: expected it to return \(state, pose\)"),
        ({"start": lambda rng: (0, np.eye(3))}, "start: poses: expected"),
        ({"start": lambda rng: (0, np.stack([np.eye(4)] * 2))}, r"start: expected one pose \(4, 4"),
        ({"motion": lambda *given: 1}, r"motion: expected it to return \(state, pose\), found 1"),
        ({"motion": lambda *given: (0, np.eye(4), [])}, r"\(state, pose\), found a tuple of 3"),
        ({"reward": lambda moment: np.nan}, "reward: expected a finite number, found nan"),
        ({"reward": lambda moment: None}, "reward: expected a finite number, found None"),
        ({"ended": lambda moment: moment.nearest_m < 1}, r"ended: expected .* of shape \(40,\)"),
        ({"ended": lambda moment: None}, "ended: expected True or False, found None"),
    ],
)
def test_functions_that_do_not_do(walker, changes, message):
    env = omma.gym.eye_env(loop_of(walker, **changes))
    with pytest.raises(omma.Error, match=message):
        for _ in range(2):
            env.reset(seed=0)
            env.step(np.zeros(2, np.float32))


def test_loops_that_cannot_be(walker):
    noisy = walker.with_eye(walker.eye, noise="new_every_frame")
    with pytest.raises(omma.Error, match="renderer: expected noise='frozen'"):
        loop_of(noisy)
    slow = omma.photoreceptors.ImpulseResponse.box(0.01)
    with pytest.raises(omma.Error, match="renderer: expected one without an impulse response"):
        loop_of(walker.with_eye(walker.eye, impulse_response=slow))
    for changes, kind, message in (
        ({"renderer": 3}, TypeError, "renderer: expected omma.Renderer"),
        ({"reward": 3}, TypeError, "reward: expected a function"),
        ({"frames": 0}, omma.Error, "frames: expected 1 to"),
        ({"most_steps": 0}, omma.Error, "most_steps: expected 1 to"),
        ({"bounds": (1, 0)}, omma.Error, "bounds: expected a least and a largest"),
        ({"things": "crates"}, omma.Error, 'nothing called "crates" to move'),
    ):
        with pytest.raises(kind, match=message):
            loop_of(**({"renderer": walker} | changes))
    with pytest.raises(TypeError, match=r"action_space: expected a gymnasium\.spaces\.Space"):
        omma.gym.eye_env(loop_of(walker, action_space=(-1, 1)))
    with pytest.raises(TypeError, match=r"loop: expected omma\.gym\.Loop"):
        omma.gym.eye_env(walker)
    with pytest.raises(omma.Error, match="count: expected 1 to"):
        omma.gym.eye_vector_env(loop_of(walker), 0)


@pytest.mark.parametrize("things", ["crate", ["crate"], 1])
def test_one_thing_is_one(walker, things):
    """By its name or its index alone, or as a list of one."""

    def begin(rng):
        state, pose = start(rng)
        return state, pose, [np.eye(4)]

    env = omma.gym.eye_env(loop_of(walker, things=things, start=begin))
    assert walker.world.instances[1].name == "crate"
    assert env.reset(seed=0)[0].shape == (40, 3)
