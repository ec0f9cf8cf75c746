"""Cameras that animations move: where they are at a time, for all who name them."""

import pickle

import numpy as np
import pytest
from animated_scenes import Builder, cube, nested
from conftest import make_eye

import omma


def test_cameras_that_are_named_are_where_animations_have_them(tmp_path):
    """With times one pose for each of them, without where `at` has put them, else at rest."""
    scene = nested(tmp_path)
    rest = scene.camera("eye").world_from_camera
    world = omma.World(scene, backend="portable")
    eye = make_eye(20)
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    times = [0.0, 0.4, 1.5]
    path = np.array([world.camera_at("eye", time) for time in times])
    assert np.ptp(path, axis=0).max() > 1
    given = renderer.render(path, times_s=times)
    assert np.array_equal(renderer.render("eye", times_s=times), given)
    assert np.array_equal(list(renderer.render_iter("eye", times_s=times)), given)
    truth = renderer.ground_truth("eye", times_s=times)
    assert np.array_equal(truth.world_from_head, path)
    assert np.array_equal(renderer.ground_truth(path, times_s=times).flow_rad_s, truth.flow_rad_s)
    assert np.array_equal(renderer.dataset("eye", truth=truth).world_from_head, path)
    lift = [world.camera_at("eye", time, "lift") for time in times]
    assert np.array_equal(
        renderer.render("eye", times_s=times, animation="lift"),
        renderer.render(lift, times_s=times, animation="lift"),
    )
    population = omma.Population(world, [eye], omma.Fixed(4))

    def is_at(world, pose):
        """Of all that take the name."""
        renderer = omma.Renderer(world, eye, omma.Fixed(4))
        camera = scene.camera("eye").replace(world_from_camera=pose)
        picture = omma.render_camera(world, camera, width=8, samples=1)
        return (
            np.array_equal(renderer.ground_truth("eye").world_from_head[0], pose)
            and np.array_equal(omma.render_camera(world, "eye", width=8, samples=1), picture)
            and np.array_equal(omma.render_camera(world, 0, width=8, samples=1), picture)
        )

    assert is_at(world, rest)
    world.at(1.5)
    assert is_at(world, path[2])
    assert np.array_equal(population.render("eye")[0], population.render(path[2])[0])
    assert is_at(pickle.loads(pickle.dumps(world)), path[2])
    assert is_at(world.with_background(omma.Background.constant((1, 0, 0))), path[2])
    with pytest.raises(omma.Error, match="animation"):
        renderer.render("eye", times_s=times, animation=7)
    world.at(0.5, "lift")
    assert is_at(world, world.camera_at("eye", 0.5, "lift"))


def test_cameras_that_nothing_moves_stay(tmp_path):
    made = Builder()
    made.document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    made.node(name="eye", camera=0, translation=[0, 1, 2])
    node = made.node(mesh=made.mesh(*cube()[::2]), name="box", translation=[0, 0, -3])
    made.animation([(node, "translation", [0, 1], [[0, 0, -3], [1, 0, -3]], "LINEAR")])
    world = omma.World(omma.load_scene(made.write(tmp_path / "still.gltf")), backend="portable")
    renderer = omma.Renderer(world, make_eye(20), omma.Fixed(4))
    rest = world.scene.camera("eye").world_from_camera
    found = renderer.ground_truth("eye", times_s=[0.2, 0.5])
    assert np.array_equal(found.world_from_head, [rest, rest])
    world.at(0.7)
    assert np.array_equal(renderer.ground_truth("eye").world_from_head, [rest])


@pytest.mark.parametrize("up", ["y", "z"])
def test_cameras_of_files_in_millimetres_keep_the_size_of_their_eyes(tmp_path, up):
    """At any time as at rest; that of a camera is its nodes' scale, 2, whatever the unit."""
    in_metres = nested(tmp_path)
    scene = omma.load_scene(tmp_path / "nested.gltf", unit="mm", up=up)
    turn = np.eye(3) if up == "y" else np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    world = omma.World(scene, backend="portable")
    assert np.allclose(world.camera_at("eye", 0), scene.camera("eye").world_from_camera, atol=1e-9)
    for time_s in (0.0, 0.5, 1.5):
        pose = world.camera_at("eye", time_s)
        known = omma.World(in_metres, backend="portable").camera_at("eye", time_s)
        assert np.allclose(pose[:3, 3], turn @ known[:3, 3] / 1000, rtol=0, atol=1e-9)
        assert np.allclose(pose[:3, :3], turn @ known[:3, :3], rtol=0, atol=1e-9)
        # What else hangs from the arm is as large as its file says.
        box = world.at(time_s).instances[world.index("box")].world_from_node
        assert np.cbrt(np.linalg.det(box[:3, :3])) == pytest.approx(0.002)
