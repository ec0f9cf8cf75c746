"""Many environments share one world: what their functions move in it is told, and things of MuJoCo
go where each environment has its own."""

import numpy as np
import pytest

import omma

gymnasium = pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install 'omma[gym]'")

AHEAD = omma.look_at((0, 0, 0), (0, 0, -1))
SPACE = gymnasium.spaces.Box(-1, 1, (1,), np.float32)


def renderer_of_box():
    world = omma.World(omma.scene.box((1, 1, 1), center_m=(0, 0, -3), name="box"))
    return omma.Renderer(world, omma.eye.generate_eye(50), omma.Fixed(4), threads=1)


def moving(world, what):
    """Functions of a loop, of which the one of that name moves the world."""

    def move(name):
        if name == what:
            place = np.eye(4)
            place[0, 3] = 0.1
            world.set_transforms("box", place)

    def start(rng):
        move("start")
        return 0, AHEAD

    def motion(state, action, rng):
        move("motion")
        return state + 1, AHEAD

    def reward(moment):
        move("reward")
        return 0.0

    def ended(moment):
        move("ended")
        return False

    return {"start": start, "motion": motion, "reward": reward, "ended": ended}


@pytest.mark.parametrize("what", ["start", "motion", "reward", "ended"])
def test_a_function_that_moves_the_world_of_several_is_named(what):
    renderer = renderer_of_box()
    loop = omma.gym.Loop(renderer, **moving(renderer.world, what), action_space=SPACE)
    envs = omma.gym.eye_vector_env(loop, 2)
    with pytest.raises(omma.Error, match=f"^{what}: expected it to leave the world as it is"):
        envs.reset(seed=1)
        envs.step(np.zeros((2, 1), np.float32))
    for alone in (omma.gym.eye_env(loop), omma.gym.eye_vector_env(loop, 1)):
        alone.reset(seed=1)
        alone.step(alone.action_space.sample())


@pytest.mark.parametrize(
    "change",
    [
        lambda world: world.set_vertices(0, world.vertices(0)),
        lambda world: world.set_color(0, (1, 0, 0)),
        lambda world: world.with_background(omma.Background.constant((0, 0, 0))).set_transforms(
            "box", np.eye(4)
        ),
    ],
    ids=["vertices", "colour", "the same before another background"],
)
def test_other_changes_of_a_shared_world_are_told_too(change):
    renderer = renderer_of_box()

    def motion(states, actions, rng):
        change(renderer.world)
        return states, np.tile(AHEAD, (len(states), 1, 1))

    loop = omma.gym.Loop(
        renderer,
        lambda count, rng: (np.zeros(count), np.tile(AHEAD, (count, 1, 1))),
        motion,
        reward=lambda moment: np.zeros(len(moment.state)),
        action_space=SPACE,
        batched=True,
        bounds=(0, 1),
    )
    envs = omma.gym.eye_vector_env(loop, 3)
    envs.reset(seed=1)
    with pytest.raises(omma.Error, match=r"^motion: expected it to leave the world as it is"):
        envs.step(np.zeros((3, 1), np.float32))


def test_mujoco_goes_into_many_environments_by_its_moving_things():
    mujoco = pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'omma[mujoco]'")
    model = mujoco.MjModel.from_xml_string("""
<mujoco><worldbody>
  <geom name="ground" type="plane" size="0 0 1" rgba="0.4 0.5 0.3 1"/>
  <body name="ball" pos="2 0 1"><freejoint/>
    <geom name="ball" type="sphere" size="0.3" rgba="1 0 0 1"/></body>
</worldbody></mujoco>""")
    at_start = mujoco.MjData(model)
    mujoco.mj_forward(model, at_start)
    world = omma.mujoco.world_from_model(model, at_start)
    things, _ = omma.mujoco.moving_things(world, at_start)
    pose = omma.look_at((0, 0, 1), (2, 0, 1), up=(0, 0, 1))

    def placed(data):
        mujoco.mj_kinematics(model, data)
        return data, pose, omma.mujoco.moving_things(world, data)[1]

    def start(rng):
        data = mujoco.MjData(model)
        data.qpos[:3] = 2, rng.uniform(-1, 1), 1
        return placed(data)

    def motion(data, action, rng):
        data.qvel[1] = action[0]
        for _ in range(20):
            mujoco.mj_step(model, data)
        return placed(data)

    loop = omma.gym.Loop(
        omma.Renderer(world, omma.eye.generate_eye(200), omma.Fixed(4), threads=1),
        start,
        motion,
        reward=lambda moment: float(moment.state.qpos[2]),
        action_space=SPACE,
        things=things,
    )
    together = omma.gym.eye_vector_env(loop, 3)
    alone = gymnasium.vector.SyncVectorEnv([lambda: omma.gym.eye_env(loop)] * 3)
    seen = [envs.reset(seed=4)[0] for envs in (together, alone)]
    assert (seen[0] == seen[1]).all()
    assert (seen[0][0] != seen[0][1]).any()
    for step in range(3):
        actions = np.array([[1], [-1], [step]], np.float32) / 3
        seen = [envs.step(actions)[:2] for envs in (together, alone)]
        assert (seen[0][0] == seen[1][0]).all()
        assert (seen[0][1] == seen[1][1]).all()
