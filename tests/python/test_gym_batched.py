"""Loops whose functions are of many environments at once: to the bit what they are one after
another, through ends, cut-offs and new starts; and what is refused."""

import warnings

import numpy as np
import pytest

import omma
from omma.gym.states import choose, merge

gymnasium = pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'omma[gym]'")
from gymnasium.utils.env_checker import check_env  # noqa: E402

SPACE = gymnasium.spaces.Box(-1, 1, (2,), np.float32)


@pytest.fixture(scope="module")
def walker():
    picture = np.random.default_rng(2).random((8, 40, 3)).astype(np.float32)
    box = omma.scene.box((0.4, 0.4, 0.4), (0.1, 0.2, 0.3), name="crate")
    world = omma.World(omma.scene.merge_scenes([omma.scene.drum(2.0, 4.0, picture), box]))
    return omma.Renderer(world, omma.eye.generate_eye(40, radius_m=1e-3), omma.Fixed(4), threads=1)


def poses_of(places):
    """Only sums and products, so that one place has the bits that it has among others."""
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, [0, 2], 3] = places
    return poses


def start(count, rng):
    places = np.tile([0.1, 0.9], (count, 1))
    return {"place": places, "far": (np.zeros(count),)}, poses_of(places)


def move(states, actions, rng):
    places = states["place"] + 0.07 * actions.astype(float)
    far = states["far"][0] + np.abs(actions[:, 0]).astype(float)
    return {"place": places, "far": (far,)}, poses_of(places)


def reward(moment):
    gone = moment.state["far"][0] - moment.before["far"][0]
    return gone - np.abs(moment.state["place"][:, 1] - 1) * moment.step


def collided(moment):
    return moment.nearest_m.min(axis=-1) < 0.3


BATCHED = {"start": start, "motion": move, "reward": reward, "ended": collided}


def first(states):
    return {"place": states["place"][0], "far": (states["far"][0][0],)}


def all_of(state):
    return {"place": state["place"][None], "far": (np.array([state["far"][0]]),)}


def in_turn_start(rng):
    states, poses = start(1, rng)
    return first(states), poses[0]


def in_turn_move(state, action, rng):
    states, poses = move(all_of(state), action[None], rng)
    return first(states), poses[0]


def in_turn_reward(moment):
    gone = moment.state["far"][0] - moment.before["far"][0]
    return gone - np.abs(moment.state["place"][1] - 1) * moment.step


IN_TURN = {
    "start": in_turn_start, "motion": in_turn_move, "reward": in_turn_reward,
    "ended": lambda moment: bool(collided(moment)),
}  # fmt: skip


def loop_of(renderer, **changes):
    parts = {"action_space": SPACE, "most_steps": 9, "distances": True, "batched": True}
    return omma.gym.Loop(renderer, **(BATCHED | parts | changes))


@pytest.mark.parametrize("frames", [None, 3])
def test_all_at_once_are_single_ones_to_the_bit(walker, frames):
    together = omma.gym.eye_vector_env(loop_of(walker, frames=frames), 6)
    plain = loop_of(walker, frames=frames, batched=False, **IN_TURN)
    in_turn = gymnasium.vector.SyncVectorEnv([lambda: omma.gym.eye_env(plain)] * 6)
    assert together.observation_space == in_turn.observation_space
    assert together.action_space == in_turn.action_space
    in_turn.action_space.seed(3)
    one, other = together.reset(seed=8), in_turn.reset(seed=8)
    ends, starts = np.zeros(2, int), 0
    for step in range(80):
        for mine, theirs in zip(one[:-1], other[:-1], strict=True):
            assert mine.dtype == theirs.dtype
            assert (mine == theirs).all()
        assert one[-1].keys() == other[-1].keys()
        assert all((one[-1][name] == other[-1][name]).all() for name in one[-1])
        if step in (40, 60):
            one, other = together.reset(), in_turn.reset()
            continue
        if step % 7 == 3 and step < 60:
            mask = np.arange(6) < 1 + step % 6
            one = together.reset(options={"reset_mask": mask})
            other = in_turn.reset(options={"reset_mask": mask})
            continue
        actions = in_turn.action_space.sample()
        actions[:2, 1] = -1  # run into the box
        if step > 60:
            actions[:] = -1  # all of them
        one, other = together.step(actions), in_turn.step(actions)
        ends += one[2].sum(), one[3].sum()
        starts += together._over.all()
    assert (ends > 3).all()
    assert starts > 0  # all of them were over at once
    in_turn.close()


def test_things_move_in_each(walker):
    def begin(count, rng):
        things = np.tile(np.eye(4), (count, 1, 1, 1))
        things[:, 0, :3, 3] = rng.uniform(-0.3, 0.3, (count, 3))
        return things, poses_of(np.tile([0.0, 1.2], (count, 1))), things

    def flee(things, actions, rng):
        assert len(things) == len(actions)
        return begin(len(things), rng)

    loop = loop_of(
        walker, start=begin, motion=flee, reward=lambda moment: moment.state[:, 0, 0, 3],
        distances=False, ended=None, things=["crate"], most_steps=2,
    )  # fmt: skip
    envs = omma.gym.eye_vector_env(loop, 3)
    seen, infos = envs.reset(seed=4)
    assert (seen[0] != seen[1]).any()
    for step in range(5):
        seen, rewards, _, cut_off, infos = envs.step(envs.action_space.sample())
        assert (rewards != 0).all() == (step % 3 != 2)
        assert cut_off.all() == (step % 3 == 1)
        places = envs._episodes._states
        again = walker.render(infos["pose"], instances=["crate"], transforms=places)
        assert (seen == again).all()


def test_gymnasium_has_nothing_to_say(walker):
    def begin(count, rng):
        places = np.stack([np.zeros(count), rng.uniform(0.9, 1.1, count)], axis=1)
        return {"place": places, "far": (np.zeros(count),)}, poses_of(places)

    loop = loop_of(walker, start=begin)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(omma.gym.eye_env(loop))
    # One environment is many of them, one in number.
    single, alone = omma.gym.eye_env(loop), omma.gym.eye_vector_env(loop, 1)
    seen, many = single.reset(seed=5)[0], alone.reset(seed=5)[0]
    assert (seen == many[0]).all()
    action = np.array([0.5, 0.25], np.float32)
    one, many = single.step(action), alone.step(action[None])
    assert (one[0] == many[0][0]).all()
    assert one[1:4] == tuple(values[0] for values in many[1:4])
    assert isinstance(one[1], float)
    assert isinstance(one[2], bool)
    # And the same seed says all.
    again = omma.gym.eye_vector_env(loop, 4)
    first_time = again.reset(seed=1)[0]
    assert (again.reset()[0] != first_time).any()
    assert (again.reset(seed=1)[0] == first_time).all()
    assert (again.reset(seed=[1])[0] == first_time).all()
    with pytest.raises(omma.Error, match="seed: expected 1 of them, as a batched loop has one"):
        again.reset(seed=[1, 2, 3, 4])


def test_observations_are_the_callers(walker):
    envs = omma.gym.eye_vector_env(loop_of(walker, frames=2), 2)
    seen, _ = envs.reset(seed=0)
    kept = seen.copy()
    seen[:] = -1
    after = envs.step(np.zeros((2, 2), np.float32))[0]
    assert (after[..., 0] == kept[..., 1]).all()


def test_states_are_chosen_and_put_together():
    states = {"a": np.arange(5.0), "b": (np.arange(10).reshape(5, 2), np.ones(5, bool))}
    which, others = np.array([1, 3]), np.array([0, 2, 4])
    back = merge(choose(states, which), which, choose(states, others), others)
    assert (back["a"] == states["a"]).all()
    assert (back["b"][0] == states["b"][0]).all()
    assert back["b"][1].dtype == bool
    wide = merge(np.zeros(2, np.float32), which, np.full(3, 0.1), others)
    assert wide[0] == 0.1  # no digits are lost


BAD = [
    ({"start": lambda count, rng: (np.zeros(count), np.eye(4)[None])}, "start: expected poses"),
    ({"start": lambda count, rng: (np.zeros(1), poses_of(np.zeros((count, 2))))}, "start: .* 3 en"),
    ({"start": lambda count, rng: ([0] * count, poses_of(np.zeros((count, 2))))}, "start: .* list"),
    ({"start": lambda count, rng: (np.zeros(count), np.eye(3))}, "start: poses: expected"),
    ({"start": lambda count, rng: 0}, r"start: expected it to return \(state, pose\)"),
    ({"motion": lambda states, actions, rng: (states, np.eye(4)[None])}, "motion: expected poses"),
    ({"reward": lambda moment: 0.0}, "reward: expected shape"),
    ({"reward": lambda moment: np.full(3, np.nan)}, "reward: expected finite numbers, found nan"),
    ({"ended": lambda moment: False}, r"ended: expected an array \(3,\) of bool"),
    ({"ended": lambda moment: np.zeros(3)}, r"ended: expected an array \(3,\) of bool"),
]


@pytest.mark.parametrize(("changes", "message"), BAD)
def test_functions_that_do_not_do(walker, changes, message):
    envs = omma.gym.eye_vector_env(loop_of(walker, **changes), 3)
    with pytest.raises(omma.Error, match=message):
        envs.reset(seed=0)
        envs.step(np.zeros((3, 2), np.float32))


def test_states_that_change_their_structure(walker):
    def other(states, actions, rng):
        return np.zeros((len(actions), 2)), poses_of(np.tile([0.25, 1.0], (len(actions), 1)))

    def ended(moment):
        return np.arange(3) == 0

    loop = loop_of(walker, motion=other, reward=lambda moment: np.zeros(3), ended=ended)
    envs = omma.gym.eye_vector_env(loop, 3)
    envs.reset(seed=0)
    envs.step(np.zeros((3, 2), np.float32))
    with pytest.raises(omma.Error, match=r"expected states of one structure .* dict of place, far"):
        envs.step(np.zeros((3, 2), np.float32))


@pytest.mark.parametrize(("actions", "found"), [(np.zeros((2, 1)), "2"), (0.5, "0.5")])
def test_actions_of_other_numbers_of_environments(actions, found):
    from omma.gym.environments import _one_each

    space = gymnasium.vector.utils.batch_space(SPACE, 3)
    with pytest.raises(omma.Error, match=f"^actions: expected 3, found {found}$"):
        _one_each(space, actions, 3)


def test_loops_that_cannot_be(walker):
    with pytest.raises(TypeError, match="batched: expected True or False"):
        loop_of(walker, batched=3)
    either = gymnasium.spaces.Tuple([SPACE, SPACE])
    envs = omma.gym.eye_vector_env(loop_of(walker, action_space=either), 2)
    envs.reset(seed=0)
    with pytest.raises(omma.Error, match="actions: expected one array of 2 actions"):
        envs.step(envs.action_space.sample())
    with pytest.raises(omma.Error, match=r"expected a reset\(\) of all before"):
        omma.gym.eye_vector_env(loop_of(walker), 2).reset(options={"reset_mask": np.ones(2, bool)})
    with pytest.raises(omma.Error, match=r"step: expected reset\(\) before it"):
        omma.gym.eye_env(loop_of(walker)).step(np.zeros(2, np.float32))
