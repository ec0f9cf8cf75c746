"""Several animals in one world: each sees the others' bodies and not its own."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.rendering import render_agents


def shifted(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


@pytest.fixture(params=["embree", "portable"])
def backend(request):
    return request.param


@pytest.fixture
def swarm():
    """Three coloured balls, the bodies of three bees, over a ground."""
    colors = [(0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.9)]
    balls = [omma.scene.sphere(0.05, color, name=f"bee {k}") for k, color in enumerate(colors)]
    ground = omma.scene.plane((4, 4), (0.5, 0.5, 0.5), name="ground")
    return omma.scene.merge_scenes([ground, *balls])


@pytest.fixture
def path():
    """(frames, bees, 4, 4): two that fly beside each other and one that overtakes them."""
    return np.stack(
        [
            [shifted(0, 1, -0.1 * t), shifted(0.4, 1, -0.1 * t), shifted(0.2, 1.1, 1 - 0.3 * t)]
            for t in range(5)
        ]
    )


BODIES = [{f"bee {k}": shifted(z=0.02)} for k in range(3)]


def seen_alone(scene, backend, path, bee, eye, sampling):
    """What one bee sees of a scene without its own body, frame by frame, moved by hand."""
    parts = [k for k, one in enumerate(scene.instances) if one.name != f"bee {bee}"]
    alone = scene.replace(instances=[scene.instances[k] for k in parts])
    world = omma.World(alone, backend=backend)
    renderer = omma.Renderer(world, eye, sampling)
    frames = []
    for frame in path:
        others = [k for k in range(3) if k != bee]
        world.set_transforms(
            [f"bee {k}" for k in others], np.stack([frame[k] @ shifted(z=0.02) for k in others])
        )
        frames.append(renderer.render(frame[bee])[0])
    return np.stack(frames)


@pytest.mark.parametrize("sampling", [omma.Fixed(16), omma.Shared(16), omma.ToError(0.02)])
def test_bees_see_each_other_and_not_themselves(swarm, path, backend, sampling):
    world = omma.World(swarm, backend=backend)
    eye = make_eye(300, acceptance_deg=6)
    renderer = omma.Renderer(world, eye, sampling)
    seen = render_agents([renderer] * 3, path, bodies=BODIES)
    for bee in range(3):
        expected = seen_alone(swarm, backend, path, bee, eye, sampling)
        assert seen[bee].shape == expected.shape
        assert np.array_equal(seen[bee], expected)
    # Each of them would be blind in its own body.
    world.set_transforms("bee 0", path[0, 0] @ shifted(z=0.02))
    blind = renderer.render(path[0, 0])[0]
    assert np.abs(blind - seen[0][0]).max() > 0.3


def test_each_has_an_eye_of_its_own_and_all_is_back_afterwards(swarm, path):
    world = omma.World(swarm)
    small, large = make_eye(40, acceptance_deg=8), make_eye(200, acceptance_deg=4)
    renderers = [
        omma.Renderer(world, small, omma.Fixed(8)),
        omma.Renderer(world, large, omma.Fixed(8)),
        omma.Renderer(world, small, omma.ToError(0.05)),
    ]
    before = [one.world_from_node for one in world.instances]
    told = []
    seen = render_agents(renderers, path, bodies=BODIES, progress=told.append)
    assert [one.shape for one in seen] == [(5, 40, 3), (5, 200, 3), (5, 40, 3)]
    for bee, renderer in enumerate(renderers):
        expected = seen_alone(swarm, "", path, bee, renderer.eye, renderer.settings.sampling)
        assert np.array_equal(seen[bee], expected)
    assert told == sorted(told)
    assert told[-1] == 1
    after = [one.world_from_node for one in world.instances]
    assert np.array_equal(before, after)


def test_many_take_several_calls(backend):
    count = 40  # more than one call can tell apart
    rng = np.random.default_rng(2)
    balls = [omma.scene.sphere(0.2, name=f"fly {k}", segments=8) for k in range(count)]
    dark = omma.Background.constant((0, 0, 0))
    world = omma.World(omma.scene.merge_scenes(balls), background=dark, backend=backend)
    renderer = omma.Renderer(world, make_eye(100, acceptance_deg=5), omma.Fixed(8))
    poses = np.stack([[shifted(*rng.uniform(-2, 2, 3)) for _ in range(count)] for _ in range(2)])
    bodies = [{f"fly {k}": np.eye(4)} for k in range(count)]
    seen = render_agents([renderer] * count, poses, bodies=bodies)
    for fly in (0, 30, 31, 39):
        world.set_transforms([f"fly {k}" for k in range(count)], poses[1])
        expected = renderer.render(poses[1, fly], unseen=[f"fly {fly}"])
        assert np.array_equal(seen[fly][1], expected[0])
    assert max(one.max() for one in seen) > 0.5


def test_frames_that_last_see_past_their_own_body(swarm, path, backend):
    world = omma.World(swarm, backend=backend)
    response = omma.photoreceptors.ImpulseResponse.box(0.02)
    eye = make_eye(100, acceptance_deg=6)
    renderer = omma.Renderer(world, eye, omma.Fixed(16), impulse_response=response)
    times = 0.01 * np.arange(5)
    seen = render_agents([renderer] * 3, path, bodies=BODIES, times_s=times)
    bees = path @ shifted(z=0.02)
    last = renderer.render(
        path[4:, 1],
        times_s=times[4:],
        instances=[f"bee {k}" for k in range(3)],
        transforms=bees[4:],
        past=(path[:4, 1], times[:4], bees[:4]),
        unseen=["bee 1"],
    )
    assert np.array_equal(seen[1][4], last[0])
    assert np.abs(last[0]).max() > 0


def test_what_is_not_seen_has_a_shadow(swarm):
    """A bee above the ground sees its shadow straight below, and not what throws it."""
    light = omma.light.clear_sky(60, sun_azimuth_deg=0)
    world = omma.World(swarm, light=light, lighting="path", ultraviolet="dark")
    eye = omma.Eye([(0, 0, 0)], [(0, -1, 0)], np.radians(1))
    renderer = omma.Renderer(world, eye, omma.Fixed(256))
    # The sun stands 60° high in the north (-Z): the shadow falls southwards.
    below = shifted(0, 0.5, 0)
    height = 0.5
    held = shifted(z=-height / np.tan(np.radians(60)))
    lit = render_agents([renderer], below[None, None], bodies=[{"bee 0": shifted(x=1.5)}])[0]
    dim = render_agents([renderer], below[None, None], bodies=[{"bee 0": held}])[0]
    assert dim.sum() < 0.5 * lit.sum()
    without = render_agents(
        [renderer], below[None, None], bodies=[{"bee 0": held}], unseen_by_light=True
    )[0]
    assert without.sum() == pytest.approx(lit.sum(), rel=0.02)  # noise of 256 paths


def test_groups_of_each_pose_in_any_render(swarm, path):
    world = omma.World(swarm)
    eye = make_eye(60, acceptance_deg=6)
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    poses = path[:, 0]
    unseen = ["bee 0", None, ["bee 0", "bee 1"], (2,), []]
    together = renderer.render(poses, unseen=unseen)
    for k, things in enumerate(unseen):
        assert np.array_equal(together[k], renderer.render(poses[k], unseen=[things])[0])
    found = renderer.dataset(poses, unseen=unseen)
    assert np.array_equal(found["response"].values, together)


def test_what_is_wrong_is_said(swarm, path):
    world = omma.World(swarm)
    renderer = omma.Renderer(world, make_eye(10), omma.Fixed(4))
    with pytest.raises(omma.Error, match=r"unseen: expected None, or the things .* 5 poses"):
        renderer.render(path[:, 0], unseen="bee 0")
    with pytest.raises(omma.Error, match=r"unseen: expected None, or the things .* 5 poses"):
        renderer.render(path[:, 0], unseen=["bee 0"])
    with pytest.raises(omma.Error, match='nothing called "wasp" to move'):
        renderer.render(path[:1, 0], unseen=["wasp"])
    with pytest.raises(omma.Error, match="unseen_by_light: goes with unseen"):
        renderer.render(path[:1, 0], unseen_by_light=True)
    with pytest.raises(TypeError, match="unseen_by_light: expected True or False, found str 'no'"):
        renderer.render(path[:1, 0], unseen=["bee 0"], unseen_by_light="no")
    with pytest.raises(omma.Error, match="unseen: expected indices of the world's 4 things"):
        renderer.render(path[:1, 0], unseen=[4])
    with pytest.raises(omma.Error, match="renderers: expected one or more, found none"):
        render_agents([], path)
    other = omma.Renderer(omma.World(swarm), make_eye(10), omma.Fixed(4))
    with pytest.raises(omma.Error, match=r"renderers\[1\]: expected one of the world of"):
        render_agents([renderer, other], path[:, :2])
    with pytest.raises(omma.Error, match=r"poses: expected shape \(frames, 2, 4, 4\), found"):
        render_agents([renderer] * 2, path)
    with pytest.raises(omma.Error, match="bodies: expected one for each of 3 animals, found 1"):
        render_agents([renderer] * 3, path, bodies=BODIES[:1])
    with pytest.raises(omma.Error, match=r"bodies\[1\]: expected things of its own, found 'bee 0'"):
        render_agents([renderer] * 2, path[:, :2], bodies=[BODIES[0], BODIES[0]])
    with pytest.raises(omma.Error, match=r"bodies\[0\]\['bee 0'\]: expected"):
        render_agents([renderer], path[:, :1], bodies=[{"bee 0": np.eye(3)}])
    lost = path.copy()
    lost[3, 1, 0, 3] = np.nan
    with pytest.raises(omma.Error, match=r"poses\[3, 1\]: expected finite numbers"):
        render_agents([renderer] * 3, lost)
    response = omma.photoreceptors.ImpulseResponse.box(0.02)
    lasting = omma.Renderer(world, make_eye(10), omma.Fixed(4), impulse_response=response)
    with pytest.raises(omma.Error, match="times_s: expected times that grow, as frames last"):
        render_agents([lasting] * 3, path, times_s=np.zeros(5))
    assert render_agents([renderer], path[:0, :1])[0].shape == (0, 10, 3)
