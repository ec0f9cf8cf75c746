"""Closed loops as environments: Gymnasium's own checker, many at once to the same bits, ends by
rays, bounds, and what is refused."""

import gc
import resource
import warnings

import numpy as np
import pytest

import omma

gymnasium = pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'omma[gym]'")
from gymnasium.utils.env_checker import check_env  # noqa: E402

WALL_M = 2.0


@pytest.fixture(scope="module")
def walker():
    """An eye in a room of blotches, in whose middle stands a box: it walks and turns."""
    picture = np.random.default_rng(2).random((8, 40, 3)).astype(np.float32)
    box = omma.scene.box((0.4, 0.4, 0.4), (0.1, 0.2, 0.3), name="crate")
    world = omma.World(omma.scene.merge_scenes([omma.scene.drum(WALL_M, 4.0, picture), box]))
    return omma.Renderer(world, omma.eye.generate_eye(40, radius_m=1e-3), omma.Fixed(4), threads=1)


def start(rng):
    state = (float(rng.uniform(0.9, 1.1)), float(rng.uniform(0, 360)))
    return state, pose_of(state)


def pose_of(state):
    return omma.look_at((0, 0, state[0]), (0, 0, state[0]) + omma.eye.direction(state[1], 0))


def walk(state, action, rng):
    away, azimuth = state
    state = (away + 0.05 * float(action[0]) + 0.001 * rng.normal(), azimuth + 5 * float(action[1]))
    return state, pose_of(state)


def closeness(moment):
    return -abs(moment.state[0] - 1)


def collided(moment):
    return bool(moment.nearest_m.min() < 0.3)


def loop_of(renderer, **changes):
    """A walk between the box and the wall, over after 12 steps or where either is near."""
    parts = {
        "start": start,
        "motion": walk,
        "reward": closeness,
        "action_space": gymnasium.spaces.Box(-1, 1, (2,), np.float32),
        "ended": collided,
        "most_steps": 12,
        "distances": True,
    }
    return omma.gym.Loop(renderer, **(parts | changes))


@pytest.mark.parametrize("frames", [None, 3])
def test_gymnasium_has_nothing_to_say(walker, frames):
    loop = loop_of(walker, frames=frames)
    gymnasium.register("omma-test-v0", entry_point=lambda: omma.gym.eye_env(loop))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            env = gymnasium.make("omma-test-v0", disable_env_checker=True).unwrapped
            check_env(env)
    finally:
        gymnasium.registry.pop("omma-test-v0")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(omma.gym.eye_env(loop))  # as it is made, not registered
    shape = (40, 3) if frames is None else (40, 3, frames)
    assert env.observation_space.shape == shape
    assert env.observation_space.dtype == np.float32


def test_the_spec_makes_another_of_the_same_loop(walker):
    loop = loop_of(walker)
    env = omma.gym.eye_env(loop)
    wrapped = gymnasium.wrappers.TimeLimit(env, 5)  # wrappers copy what the spec holds
    for made in (env.spec.make(), wrapped.spec.make()):
        assert made.unwrapped.loop is loop
        assert (made.reset(seed=2)[0] == env.reset(seed=2)[0]).all()


def test_the_observation_is_what_the_eye_sees(walker):
    env = omma.gym.eye_env(loop_of(walker))
    seen, info = env.reset(seed=4)
    assert (seen == walker.render(info["pose"])[0]).all()
    before = seen.copy()
    after, reward, ended, cut_off, info = env.step(np.array([1.0, 0.5], np.float32))
    assert (after == walker.render(info["pose"])[0]).all()
    assert (after != seen).any()
    assert (seen == before).all()  # it is the caller's
    assert -1 < reward < 0
    assert (ended, cut_off) == (False, False)


def test_frames_follow_each_other(walker):
    env = omma.gym.eye_env(loop_of(walker, frames=3))
    first, _ = env.reset(seed=4)
    assert (first == first[..., :1]).all()
    second = env.step(np.ones(2, np.float32))[0]
    third = env.step(np.ones(2, np.float32))[0]
    assert (second[..., :2] == first[..., 1:]).all()
    assert (third[..., :2] == second[..., 1:]).all()
    assert (third[..., 2] != second[..., 2]).any()


@pytest.mark.parametrize("frames", [None, 2])
def test_many_at_once_are_single_ones_to_the_bit(walker, frames):
    """Over ends, cut-offs and new starts; against Gymnasium's own way of taking turns."""
    loop = loop_of(walker, frames=frames, most_steps=18)
    together = omma.gym.eye_vector_env(loop, 5)
    in_turn = gymnasium.vector.SyncVectorEnv([lambda: omma.gym.eye_env(loop)] * 5)
    assert together.metadata["autoreset_mode"] == in_turn.metadata["autoreset_mode"]
    assert together.observation_space == in_turn.observation_space
    assert together.single_observation_space == in_turn.single_observation_space
    assert together.action_space == in_turn.action_space
    in_turn.action_space.seed(3)
    one, other = together.reset(seed=8), in_turn.reset(seed=8)
    ends = np.zeros(2, int)
    for step in range(120):
        assert (one[0] == other[0]).all()
        assert one[0].dtype == other[0].dtype == np.float32
        for mine, theirs in zip(one[1:-1], other[1:-1], strict=True):
            assert mine.dtype == theirs.dtype
            assert (mine == theirs).all()
        assert one[-1].keys() == other[-1].keys()
        assert all((one[-1][name] == other[-1][name]).all() for name in one[-1])
        if step == 70:  # again, with what their generators are by now
            one, other = together.reset(), in_turn.reset()
            continue
        actions = in_turn.action_space.sample()
        actions[:2, 0] = 1  # run into the wall
        one, other = together.step(actions), in_turn.step(actions)
        ends += one[2].sum(), one[3].sum()
    assert (ends > 3).all()
    in_turn.close()


@pytest.mark.parametrize("frames", [None, 2])
def test_some_start_anew_as_in_gymnasium(walker, frames):
    """``reset_mask``, for those who do so as soon as an episode is over."""
    loop = loop_of(walker, frames=frames)
    together = omma.gym.eye_vector_env(loop, 4)
    in_turn = gymnasium.vector.SyncVectorEnv([lambda: omma.gym.eye_env(loop)] * 4)
    in_turn.action_space.seed(3)
    together.reset(seed=8)
    in_turn.reset(seed=8)
    begun = 0
    for step in range(40):
        actions = in_turn.action_space.sample()
        actions[0, 0] = 1  # run into the wall
        one, other = together.step(actions), in_turn.step(actions)
        for mine, theirs in zip(one[:-1], other[:-1], strict=True):
            assert (mine == theirs).all()
        over = one[2] | one[3]
        if step % 3 == 0:
            over[2] = True  # one that is not over
        if over.any() and step % 5 != 4:
            begun += 1
            one = together.reset(options={"reset_mask": over})
            other = in_turn.reset(options={"reset_mask": over})
            assert (one[0] == other[0]).all()
            assert all((one[1][name] == other[1][name]).all() for name in other[1])
    assert begun > 8
    in_turn.close()
    for mask, message in (
        (np.zeros(4, bool), "reset_mask: expected an array"),
        ([0, 1, 0, 1], "reset_mask: expected an array"),
        (np.ones(3, bool), "reset_mask: expected an array"),
    ):
        with pytest.raises(omma.Error, match=message):
            together.reset(options={"reset_mask": mask})
    with pytest.raises(omma.Error, match="seed: is for a reset of all"):
        together.reset(seed=1, options={"reset_mask": np.ones(4, bool)})
    with pytest.raises(omma.Error, match=r"expected a reset\(\) of all before"):
        omma.gym.eye_vector_env(loop, 4).reset(options={"reset_mask": np.ones(4, bool)})


def test_many_are_rendered_in_one_call(walker, monkeypatch):
    calls = []
    render = omma.Renderer.render

    def counted(self, poses, **options):
        calls.append(len(poses))
        return render(self, poses, **options)

    monkeypatch.setattr(omma.Renderer, "render", counted)
    envs = omma.gym.eye_vector_env(loop_of(walker, distances=False, ended=None), 7)
    envs.reset(seed=0)
    for _ in range(3):
        envs.step(envs.action_space.sample())
    assert calls == [7] * 4


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


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def test_nothing_is_left_of_steps(walker):
    """5,000 steps; bench/gym_steps.py takes 100,000."""
    env = omma.gym.eye_env(loop_of(walker, frames=2))
    env.action_space.seed(0)
    env.reset(seed=0)
    sizes = []
    for step in range(5000):
        _, _, ended, cut_off, _ = env.step(env.action_space.sample())
        if ended or cut_off:
            env.reset()
        if step % 1000 == 999:
            gc.collect()
            sizes.append(resident_bytes())
    # An observation that stayed behind at each step would be 1,000 bytes, 4 MB in the last 4,000;
    # allocators take some hundred kB more or less.
    assert sizes[-1] - sizes[0] < 2e6
