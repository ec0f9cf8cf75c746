"""Optic flow where animations begin and end."""

import numpy as np
import pytest
from animated_scenes import Builder, cube
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import omma

ENDS = [
    # Keys of what moves to the right at 1 m/s, when, and how fast it is then.
    ([0, 1], [-0.5, -2e-5, 0, 2e-5, 0.5, 1 - 2e-5, 1, 1 + 2e-5, 2], [0, 0, 1, 1, 1, 1, 1, 0, 0]),
    # Of float32: the first is after that time, the last before it.
    ([0.1, 0.7], [0.1, 0.4, 0.7, 0.8], [1, 1, 1, 0]),
    ([3000.1, 3000.7], [3000.0, 3000.1, 3000.7, 3000.8], [0, 1, 1, 0]),
    ([0, 5e-5], [-1e-4, 0, 2e-5, 5e-5, 1e-4], [0, 1, 1, 1, 0]),
    ([0.5], [0.4, 0.5, 0.6], [0, 0, 0]),
]


@pytest.mark.parametrize(("keys", "times", "speeds"), ENDS)
def test_an_animation_has_all_of_its_flow_at_both_ends(tmp_path, keys, times, speeds):
    made = Builder()
    node = made.node(mesh=made.mesh(*cube(1.0)[::2]), name="box")
    aside = made.node(mesh=made.mesh(*cube(1.0)[::2]), name="aside")
    keys = np.float32(keys)
    places = np.stack([keys - keys[0], 0 * keys, -4 + 0 * keys], 1)
    turns = Rotation.from_rotvec(np.outer(keys - keys[0], (0, 0, 2.0))).as_quat()
    made.animation([(node, "translation", keys, places, "LINEAR")], "go")
    made.animation([(aside, "rotation", [-9, 9], [[0, 0, 0, 1], [0, 1, 0, 0]], "LINEAR")], "other")
    made.animation([(node, "rotation", keys, turns, "LINEAR")], "turn")
    scene = omma.load_scene(made.write(tmp_path / "box.gltf"))
    world = omma.World(scene, backend="portable")
    renderer = omma.Renderer(world, omma.Eye([(0, 0, 0)], [(0, 0, -1)], 0.0), omma.Fixed(1))
    poses = np.tile(np.eye(4), (len(times), 1, 1))
    truth = renderer.ground_truth(poses, times_s=times, animation="go")
    assert_allclose(truth.flow_objects_rad_s[:, 0, 0], np.array(speeds) / 3, atol=1e-3)
    # The box does not go, but turns about its middle.
    beside = omma.Eye([(0.2, 0, 0)], [(0, 0, -1)], 0.0)
    up = renderer.with_eye(beside).ground_truth(poses, times_s=times, animation="turn")
    assert_allclose(
        up.flow_objects_rad_s[:, 0, 1], np.multiply(0.4, speeds) / up.distance_m[:, 0], atol=1e-3
    )


def test_what_an_animation_has_at_its_ends_is_what_transforms_have(tmp_path):
    """Along a spline, faster and faster."""
    made = Builder()
    node = made.node(mesh=made.mesh(*cube(1.0)[::2]), name="box")
    keys = [0, 0.5, 1]
    stays = np.array([0, 0, -4.0])
    values = [[[k, 0, 0], [k**2 / 2, 0, 0] + stays, [k, 0, 0]] for k in keys]
    made.animation([(node, "translation", keys, values, "CUBICSPLINE")])
    world = omma.World(omma.load_scene(made.write(tmp_path / "spline.gltf")), backend="portable")
    renderer = omma.Renderer(world, omma.Eye([(0, 0, 0)], [(0, 0, -1)], 0.0), omma.Fixed(1))
    times = np.linspace(0, 1, 101)
    poses = np.tile(np.eye(4), (101, 1, 1))
    transforms = np.tile(np.eye(4), (101, 1, 1, 1))
    transforms[:, 0, :3, 3] = stays
    transforms[:, 0, 0, 3] = times**2 / 2
    found = renderer.ground_truth(poses, times_s=times)
    given = renderer.ground_truth(poses, times_s=times, instances=["box"], transforms=transforms)
    # At the ends that of the first and the last hundredth of a second, whose mean it is.
    assert_allclose(found.flow_objects_rad_s, given.flow_objects_rad_s, atol=0.006 / 3)
    assert_allclose(found.flow_objects_rad_s[:, 0, 0], times / 3, atol=2e-4)


def test_a_jump_at_an_end_has_no_flow(tmp_path):
    """A box that goes upwards, and is 10 cm to the right from one key to the next, or by STEP."""
    for keys, rights, way in [
        ([0, 1e-5, 1], [0, 0.1, 0.1], "LINEAR"),
        ([0, 1 - 1e-5, 1], [0, 0, 0.1], "LINEAR"),
        ([0, 1], [0, 0.1], "STEP"),
    ]:
        made = Builder()
        rail = made.node(name="rail")
        node = made.node(rail, mesh=made.mesh(*cube(1.0)[::2]), name="box")
        places = [[right, 0, -4] for right in rights]
        made.animation(
            [
                (node, "translation", keys, places, way),
                (rail, "translation", [0, 1], [[0, 0, 0], [0, 0.2, 0]], "LINEAR"),
            ]
        )
        world = omma.World(omma.load_scene(made.write(tmp_path / "jump.gltf")), backend="portable")
        renderer = omma.Renderer(world, omma.Eye([(0, 0, 0)], [(0, 0, -1)], 0.0), omma.Fixed(1))
        truth = renderer.ground_truth(np.tile(np.eye(4), (3, 1, 1)), times_s=[0, 0.5, 1])
        assert_allclose(truth.flow_objects_rad_s[:, 0], [[0, 0.2 / 3]] * 3, atol=1e-4)
