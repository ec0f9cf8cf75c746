"""Animations: where things are at a time, against SciPy; skins and morph targets, against NumPy."""

import copy
import pickle

import numpy as np
import pytest
from animated_scenes import Builder, cube, nested, transform, tube
from conftest import make_eye
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation, Slerp

import omma

# Keys are stored in single precision: an interval of 2 to 4 has floats 2.4e-7 apart.
FILE_ATOL = 1e-6

TIMES = np.array([0.5, 1.0, 1.75, 3.0])
ASKED = [-1.0, 0.5, 0.6, 0.99, 1.0, 1.3, 1.75, 2.2, 2.999, 3.0, 50.0]


def quaternions(count, seed=3):
    """Unit quaternions as a file has them, (count, 4) float32, half of them turned to their
    negatives, which stand for the same rotations."""
    found = Rotation.random(count, random_state=seed).as_quat()
    found[::2] *= -1
    return found.astype(np.float32).astype(float)


def vectors(count, seed, low=-2.0, high=2.0):
    rng = np.random.default_rng(seed)
    return rng.uniform(low, high, (count, 3)).astype(np.float32).astype(float)


def stepped(values, time_s):
    return values[max(np.searchsorted(TIMES, time_s, side="right") - 1, 0)]


def spline(triples, time_s):
    """Of [key][tangent in, value, tangent out]: each interval leaves by the one, arrives by the
    other."""
    time_s = np.clip(time_s, TIMES[0], TIMES[-1])
    k = min(max(np.searchsorted(TIMES, time_s, side="right") - 1, 0), len(TIMES) - 2)
    return CubicHermiteSpline(
        TIMES[k : k + 2], triples[k : k + 2, 1], [triples[k, 2], triples[k + 1, 0]]
    )(time_s)


def one_node(tmp_path, path, values, interpolation, **properties):
    """A world with a cube whose node is animated in one way."""
    made = Builder()
    mesh = made.mesh(*cube()[::2])
    node = made.node(mesh=mesh, name="box", **properties)
    made.animation([(node, path, TIMES, values, interpolation)], "move")
    return omma.World(omma.load_scene(made.write(tmp_path / "one.gltf")), backend="portable")


def place(world, time_s, name="box"):
    return world.at(time_s).instances[world.index(name)].world_from_node


@pytest.mark.parametrize("path", ["translation", "scale"])
def test_vectors_are_interpolated(tmp_path, path):
    values = vectors(4, 1, 0.5, 2.0)
    triples = vectors(12, 2, 0.5, 0.9).reshape(4, 3, 3)
    worlds = {
        "LINEAR": one_node(tmp_path, path, values, "LINEAR"),
        "STEP": one_node(tmp_path, path, values, "STEP"),
        "CUBICSPLINE": one_node(tmp_path, path, triples, "CUBICSPLINE"),
    }
    for time_s in ASKED:
        inside = np.clip(time_s, TIMES[0], TIMES[-1])
        linear = [np.interp(inside, TIMES, values[:, axis]) for axis in range(3)]
        expected = {
            "LINEAR": np.array(linear),
            "STEP": stepped(values, time_s),
            "CUBICSPLINE": spline(triples, time_s),
        }
        for way, world in worlds.items():
            matrix = transform(**{path: expected[way]})
            assert np.allclose(place(world, time_s), matrix, rtol=0, atol=FILE_ATOL), (way, time_s)


def test_rotations_take_the_shorter_way(tmp_path):
    keys = quaternions(4)
    linear = one_node(tmp_path, "rotation", keys, "LINEAR")
    step = one_node(tmp_path, "rotation", keys, "STEP")
    slerp = Slerp(TIMES, Rotation.from_quat(keys))
    for time_s in ASKED:
        between = slerp(np.clip(time_s, TIMES[0], TIMES[-1])).as_quat()
        assert np.allclose(
            place(linear, time_s), transform(rotation=between), rtol=0, atol=FILE_ATOL
        )
        held = stepped(keys, time_s)
        assert np.allclose(place(step, time_s), transform(rotation=held), rtol=0, atol=FILE_ATOL)


def test_rotations_along_splines_are_normalised(tmp_path):
    triples = np.random.default_rng(5).normal(size=(4, 3, 4))
    triples[:, 1] = quaternions(4)
    triples = triples.astype(np.float32).astype(float)
    world = one_node(tmp_path, "rotation", triples, "CUBICSPLINE")
    for time_s in ASKED:
        expected = transform(rotation=spline(triples, time_s))  # which SciPy normalises
        assert np.allclose(place(world, time_s), expected, rtol=0, atol=FILE_ATOL)


def test_keys_may_be_bytes_and_shorts(tmp_path):
    made = Builder()
    node = made.node(mesh=made.mesh(*cube()[::2]), name="box")
    half = np.sqrt(0.5)
    turned = np.array([[0, 0, 0, 1], [0, half, 0, half]])
    made.animation([(node, "rotation", [0, 1], turned, "LINEAR")])
    for dtype, most in (("i1", 127), ("i2", 32767)):
        output = made.accessor(np.round(turned * most), dtype, normalized=True)
        made.document["animations"][0]["samplers"][0]["output"] = output
        world = omma.World(omma.load_scene(made.write(tmp_path / "integers.gltf")))
        expected = transform(rotation=[0, np.sin(np.pi / 8), 0, np.cos(np.pi / 8)])
        # Half a step of a byte, before the quaternion is normalised.
        assert np.allclose(place(world, 0.5), expected, rtol=0, atol=1 / most)


def test_children_move_with_their_parents(tmp_path):
    scene = nested(tmp_path)
    assert [(one.name, one.duration_s) for one in scene.animations] == [("turn", 2), ("lift", 1)]
    assert not any("animation" in sentence for sentence in scene.warnings)
    world = omma.World(scene)
    tower = transform([10, 0, 0], scale=[2, 2, 2])
    stone = world.instances[world.index("stone")].world_from_node

    def expected(turn_s, lift_s):
        angle = np.pi / 2 * np.clip(turn_s, 0, 2) / 2
        base = tower @ transform(rotation=[0, np.sin(angle), 0, np.cos(angle)])
        arm = base @ transform([0, 1 + 2 * np.clip(lift_s, 0, 1), 0])
        return base, arm @ transform([0, 0, -3]), arm @ transform([0, 0.5, 0])

    def check(turn_s, lift_s, camera):
        base, box, eye = expected(turn_s, lift_s)
        assert np.allclose(world.instances[world.index("base")].world_from_node, base, atol=1e-6)
        assert np.allclose(world.instances[world.index("box")].world_from_node, box, atol=1e-6)
        assert np.allclose(camera, eye, atol=1e-6)
        assert np.array_equal(world.instances[world.index("stone")].world_from_node, stone)

    assert world.at(0.7) is world
    check(0.7, 0.7, world.camera_at("eye", 0.7))
    world.at(1.9, "turn")
    check(1.9, 0, world.camera_at(0, 1.9, "turn"))
    world.at(0.4, 1)
    check(0, 0.4, world.camera_at("eye", 0.4, "lift"))
    world.at(-1)
    check(0, 0, scene.camera("eye").world_from_camera)


def test_what_a_world_at_a_time_looks_like(tmp_path, backend):
    scene = nested(tmp_path)
    world = omma.World(scene, backend=backend).at(1.25)
    places = {one.name: one.world_from_node for one in world.instances}
    moved = [one.replace(world_from_mesh=places[one.name]) for one in scene.instances]
    built = omma.World(scene.replace(instances=moved, rig=None), backend=backend)
    eye = make_eye(300, acceptance_deg=6)
    seen = omma.Renderer(world, eye, omma.Fixed(8)).render(np.eye(4))
    expected = omma.Renderer(built, eye, omma.Fixed(8)).render(np.eye(4))
    assert np.ptp(expected) > 0
    # Rays that pass an edge within 1e-7 of their length may meet what is beside it.
    assert np.quantile(np.abs(seen - expected), 0.99) < 1e-5


@pytest.fixture(params=["embree", "portable"])
def backend(request):
    return request.param


def bent_tube(tmp_path, influences=4, normals=True, weights=None):
    """A tube on two bones, the upper of which bends; and what bends it, for NumPy."""
    positions, normal, triangles = tube()
    made = Builder()
    lower = np.clip(1.5 - positions[:, 1], 0, 1)
    weight = np.zeros((len(positions), influences))
    weight[:, 0], weight[:, influences - 1] = lower, 1 - lower
    joint = np.zeros_like(weight)
    joint[:, influences - 1] = 1
    if weights is not None:
        weight = weights(weight)
    attributes = {}
    for k in range(influences // 4):
        part = slice(4 * k, 4 * k + 4)
        attributes[f"JOINTS_{k}"] = made.accessor(joint[:, part], "u2")
        attributes[f"WEIGHTS_{k}"] = made.accessor(weight[:, part])
    mesh = made.mesh(positions, triangles, normals=normal if normals else None, **attributes)
    armature = made.node(name="armature", translation=[0, 0, -4], scale=[1.5, 1, 1])
    root = made.node(armature, name="root")
    upper = made.node(root, name="upper", translation=[0, 1, 0])
    inverse_bind = np.stack([np.eye(4), transform([0, -1, 0])])
    skin = made.skin([root, upper], inverse_bind)
    made.node(armature, name="tube", mesh=mesh, skin=skin, translation=[7, 7, 7])
    angle = 0.6
    keys = [[0, 0, 0, 1], [0, 0, np.sin(angle), np.cos(angle)]]
    made.animation([(upper, "rotation", [0, 1], keys, "LINEAR")], "bend")
    made.animation([(root, "translation", [0, 1], [[0, 0, 0], [1, 0, 0]], "LINEAR")], "walk")

    def world_from_bones(time_s):
        turned = angle * np.clip(time_s, 0, 1)
        bones = transform([0, 0, -4], scale=[1.5, 1, 1]) @ transform([np.clip(time_s, 0, 1), 0, 0])
        upper_bone = bones @ transform([0, 1, 0], [0, 0, np.sin(turned), np.cos(turned)])
        return np.stack([bones @ inverse_bind[0], upper_bone @ inverse_bind[1]])

    def expected(time_s):
        blended = np.einsum("vi,vijk->vjk", weight, world_from_bones(time_s)[joint.astype(int)])
        bent = np.einsum("vjk,vk->vj", blended[:, :3, :3], positions) + blended[:, :3, 3]
        across = np.einsum("vjk,vk->vj", np.linalg.inv(blended[:, :3, :3]).swapaxes(1, 2), normal)
        return bent, across / np.linalg.norm(across, axis=1, keepdims=True)

    return omma.load_scene(made.write(tmp_path / "tube.gltf")), expected


@pytest.mark.parametrize("influences", [4, 8])
def test_skins_bend_as_in_numpy(tmp_path, backend, influences):
    scene, expected = bent_tube(tmp_path, influences)
    world = omma.World(scene, backend=backend)
    node = world.instances[world.index("tube")].world_from_node
    at_first = [mesh.positions_m.copy() for mesh in scene.meshes]
    for time_s in (0.0, 0.3, 1.0, 0.3, 9.0):
        world.at(time_s)
        bent, across = expected(time_s)
        placed = world.vertices(0) @ node[:3, :3].T + node[:3, 3]
        # Bones are blended in single precision, about a point 10 m away.
        assert np.allclose(placed, bent, rtol=0, atol=1e-5)
        normals = world._engine.normals(0) @ np.linalg.inv(node[:3, :3])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        assert np.allclose(normals, across, rtol=0, atol=1e-5)
    # Its own node's place does not count, as glTF says; and a scene is never changed.
    assert np.array_equal(world.instances[world.index("tube")].world_from_node, node)
    assert all(np.array_equal(a, b.positions_m) for a, b in zip(at_first, scene.meshes))
    rest, _ = expected(0)
    assert np.allclose(scene.meshes[0].positions_m @ node[:3, :3].T + node[:3, 3], rest, atol=1e-5)


def test_the_node_of_a_skin_alone_moves_nothing(tmp_path, backend):
    made = Builder()
    positions, _, triangles = cube()
    joints = made.accessor(np.zeros((24, 4)), "u1")
    weights = made.accessor(np.tile([1.0, 0, 0, 0], (24, 1)))
    mesh = made.mesh(positions, triangles, JOINTS_0=joints, WEIGHTS_0=weights)
    bone = made.node(name="bone", translation=[0, 0, -3])
    node = made.node(name="cube", mesh=mesh, skin=made.skin([bone]))
    made.animation([(node, "translation", [0, 1], [[0, 0, 0], [1, 0, 0]], "LINEAR")])
    world = omma.World(omma.load_scene(made.write(tmp_path / "still.gltf")), backend=backend)
    world.at(0.5)
    place = world.instances[0].world_from_node
    seen = world.vertices(0) @ place[:3, :3].T + place[:3, 3]
    assert np.allclose(seen, positions + [0, 0, -3], atol=1e-6)


def test_an_animation_that_flattens_says_what_and_when(tmp_path):
    made = Builder()
    node = made.node(name="leaf", mesh=made.mesh(*cube()[::2]))
    made.animation([(node, "scale", [0, 1], [[1, 1, 1], [0, 0, 0]], "LINEAR")])
    world = omma.World(omma.load_scene(made.write(tmp_path / "flat.gltf")))
    world.at(0.5)
    with pytest.raises(omma.Error, match=r'animation at 1 s, node "leaf": .* found a scale of 0'):
        world.at(1.0)


def built_with(scene, world):
    """A world that was made with the meshes as they are in another one."""
    meshes = [mesh.replace(positions_m=world.vertices(k)) for k, mesh in enumerate(scene.meshes)]
    places = [one.world_from_node for one in world.instances]
    instances = [one.replace(world_from_mesh=places[k]) for k, one in enumerate(scene.instances)]
    return omma.World(
        scene.replace(meshes=meshes, instances=instances, rig=None),
        backend=world.backend.split()[0],
    )


def test_bent_meshes_are_seen_as_if_built_so(tmp_path, backend):
    scene, _ = bent_tube(tmp_path)
    world = omma.World(scene, backend=backend)
    eye = make_eye(2000, acceptance_deg=3)
    seen_at = []
    for time_s in (0.2, 1.0, 0.0, 0.7):
        world.at(time_s)
        seen = omma.Renderer(world, eye, omma.Fixed(8)).render(np.eye(4))
        built = omma.Renderer(built_with(scene, world), eye, omma.Fixed(8)).render(np.eye(4))
        assert np.count_nonzero(built) > 20
        # Rays that pass an edge within 1e-7 of their length may meet what is beside it.
        assert np.count_nonzero(np.abs(seen - built) > 1e-5) <= 4
        seen_at.append(seen)
    assert not np.array_equal(seen_at[0], seen_at[1])


def blended_cube(tmp_path, **node):
    """A cube with two morph targets, as of Khronos' AnimatedMorphCube."""
    positions, normals, triangles = cube()
    rng = np.random.default_rng(8)
    shapes = [rng.normal(0, 0.2, positions.shape) for _ in range(2)]
    turned = [rng.normal(0, 0.2, positions.shape) for _ in range(2)]
    made = Builder()
    targets = [{"POSITION": p, "NORMAL": n} for p, n in zip(shapes, turned)]
    mesh = made.mesh(positions, triangles, normals=normals, targets=targets)
    made.document["meshes"][mesh]["weights"] = [0.25, 0]
    index = made.node(mesh=mesh, name="cube", translation=[0, 0, -3], **node)
    keys = np.array([[0, 0], [1, 0], [0, 1], [-0.5, 2]])
    made.animation([(index, "weights", TIMES, keys, "LINEAR")], "Square")

    def expected(weights):
        across = normals + sum(w * n for w, n in zip(weights, turned))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        return positions + sum(w * p for w, p in zip(weights, shapes)), across

    return made, omma.load_scene(made.write(tmp_path / "cube.gltf")), keys, expected


def test_morph_targets_blend(tmp_path, backend):
    _, scene, keys, expected = blended_cube(tmp_path)
    assert np.allclose(scene.meshes[0].positions_m, expected([0.25, 0])[0], atol=FILE_ATOL)
    world = omma.World(scene, backend=backend)
    for time_s in ASKED:
        world.at(time_s)
        weights = [np.interp(time_s, TIMES, keys[:, k]) for k in range(2)]
        positions, normals = expected(weights)
        assert np.allclose(world.vertices(0), positions, rtol=0, atol=2 * FILE_ATOL)
        assert np.allclose(world._engine.normals(0), normals, rtol=0, atol=4 * FILE_ATOL)


def test_a_mesh_on_two_nodes_blends_for_each_alone(tmp_path):
    made, _, keys, expected = blended_cube(tmp_path)
    made.node(mesh=0, name="still", weights=[0, 0.5])
    made.node(mesh=0, name="also still", weights=[0, 0])
    scene = omma.load_scene(made.write(tmp_path / "three.gltf"))
    world = omma.World(scene).at(TIMES[2])
    shape = {one.name: world.vertices(one.mesh) for one in scene.instances}
    for name, weights in (("cube", keys[2]), ("still", [0, 0.5]), ("also still", [0, 0])):
        assert np.allclose(shape[name], expected(weights)[0], rtol=0, atol=2 * FILE_ATOL), name


def test_vertices_can_be_set(tmp_path, backend):
    positions, normals, triangles = tube()
    mesh = omma.scene.Mesh(positions - [0, 1, 3], triangles, normals=normals)
    scene = omma.Scene(meshes=[mesh])
    world = omma.World(scene, backend=backend)
    eye = make_eye(2000, acceptance_deg=3)
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    before = renderer.render(np.eye(4))
    for shift in ([0.5, 0, 0], [-1.0, 2, 0.5], [0, 0, 0]):
        bent = mesh.positions_m + shift + 0.1 * np.sin(3 * mesh.positions_m[:, ::-1])
        world.set_vertices(0, bent)
        assert np.array_equal(world.vertices(0), bent.astype(np.float32))
        built = omma.Renderer(built_with(scene, world), eye, omma.Fixed(8)).render(np.eye(4))
        seen = renderer.render(np.eye(4))
        assert np.count_nonzero(np.abs(seen - built) > 1e-5) <= 4
        assert not np.array_equal(seen, before)
    assert np.array_equal(scene.meshes[0].positions_m, mesh.positions_m)
    world.set_vertices(0, mesh.positions_m, mesh.normals)
    back = renderer.render(np.eye(4))
    assert np.count_nonzero(np.abs(back - before) > 1e-5) <= 4
    # A mesh that was flat when it was built, and of which nothing could be seen.
    world.set_vertices(0, 0 * mesh.positions_m)
    assert np.count_nonzero(renderer.render(np.eye(4))) == 0
    world.set_vertices(0, mesh.positions_m)
    assert np.count_nonzero(renderer.render(np.eye(4))) == np.count_nonzero(before)


def test_vertices_that_cannot_be(tmp_path):
    scene = omma.Scene(meshes=[omma.scene.Mesh(*cube()[::2])])
    world = omma.World(scene)
    good = scene.meshes[0].positions_m
    bad = good.copy()
    bad[5, 1] = np.nan
    for arguments, message in (
        ((1, good), "mesh: expected an index into the 1 meshes"),
        ((0, good[:-1]), "positions_m: expected one for each of 24 vertices of the mesh, found 23"),
        ((0, bad), r"positions_m\[5\]: is not finite"),
        ((0, good, good), "normals: expected none, as the mesh has no normals"),
        ((0, 1e13 + good), "expected all of it within 1e12 m"),
        ((0, good[:, :2]), r"positions_m: expected shape \(N, 3\)"),
    ):
        with pytest.raises(omma.Error, match=message):
            world.set_vertices(*arguments)
        assert np.array_equal(world.vertices(0), good)


# Beside the tower.
NEAR = transform([10, 3, 5])


def moving_world(tmp_path, backend="embree"):
    scene = nested(tmp_path)
    return omma.World(scene, backend=backend)


def test_transforms_per_pose_are_those_of_single_frames(tmp_path, backend):
    rng = np.random.default_rng(4)
    poses = np.stack([transform(rng.normal(0, 0.3, 3)) for _ in range(5)])
    transforms = np.stack(
        [[transform(rng.uniform(-4, 4, 3) + [0, 0, -6]) for _ in range(2)] for _ in range(5)]
    )
    eye = make_eye(400, acceptance_deg=6)
    names = ["stone", "box"]
    for options in ({}, {"noise": "new_every_frame"}):
        one = moving_world(tmp_path, backend)
        single = omma.Renderer(one, eye, omma.Fixed(8), threads=1, **options)
        expected = []
        for pose, places in zip(poses, transforms):
            one.set_transforms(names, places)
            expected.append(single.render(pose, standard_error=True))
        expected = [np.concatenate(parts) for parts in zip(*expected)]
        for threads in (1, 2, 5):
            world = moving_world(tmp_path, backend)
            before = [instance.world_from_node for instance in world.instances]
            renderer = omma.Renderer(world, eye, omma.Fixed(8), threads=threads, **options)
            given = {"instances": names, "transforms": transforms}
            found = renderer.render(poses, standard_error=True, **given)
            assert np.array_equal(found, expected)
            after = [instance.world_from_node for instance in world.instances]
            assert np.array_equal(before, after)
            assert set(world._moved) == {world.index(name) for name in names}
    one.set_transforms(names, transforms[3])
    fourth = single.render(poses[3], first_pose=17 + 3)
    assert np.array_equal(renderer.render(poses, first_pose=17, **given)[3:4], fourth)


def test_all_outputs_move(tmp_path):
    world = moving_world(tmp_path)
    eye = make_eye(100, acceptance_deg=6)
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    poses = np.stack([NEAR] * 3)
    times = [0.0, 0.5, 1.0]
    expected = []
    for time_s in times:
        world.at(time_s)
        expected.append(renderer.render(NEAR)[0])
    assert not np.array_equal(expected[0], expected[2])
    world.at(0)
    assert np.array_equal(renderer.render(poses, times_s=times), expected)
    rays = renderer.render_rays(poses, times_s=times)
    assert np.allclose(rays.mean(axis=2), expected, atol=1e-6)
    shared = renderer.with_eye(eye, omma.Shared(8))
    batch = shared.render(poses, times_s=times)
    for k, time_s in enumerate(times):
        assert np.array_equal(batch[k : k + 1], shared.render(NEAR, times_s=[time_s]))
    to_error = renderer.with_eye(eye, omma.ToError(0.05))
    responses, report = to_error.render(poses, report=True, times_s=times)
    assert report.rays.shape == (3, 100)
    assert not np.array_equal(responses[0], responses[2])
    done = []
    renderer.render(poses, times_s=times, progress=done.append)
    assert done == sorted(done)
    assert done[-1] == 1


def test_animations_and_transforms_together(tmp_path):
    world = moving_world(tmp_path)
    renderer = omma.Renderer(world, make_eye(100, acceptance_deg=8), omma.Fixed(4))
    poses = np.stack([np.eye(4)] * 2)
    places = np.stack([[transform([0, 0, -2])], [transform([0, 1, -2])]])
    found = renderer.render(
        poses, instances="box", transforms=places, times_s=[0.5, 1.5], animation="turn"
    )
    for k, time_s in enumerate((0.5, 1.5)):
        world.at(time_s, "turn")
        world.set_transforms("box", places[k])
        assert np.array_equal(found[k : k + 1], renderer.render(np.eye(4)))


def test_datasets_say_when(tmp_path):
    pytest.importorskip("xarray")
    world = moving_world(tmp_path)
    renderer = omma.Renderer(world, make_eye(50, acceptance_deg=8), omma.Fixed(4))
    poses = np.stack([np.eye(4)] * 3)
    data = renderer.dataset(poses, times_s=[0.0, 0.5, 1.0])
    assert data["response"].dims[0] == "time"
    assert np.array_equal(data["time"], [0.0, 0.5, 1.0])
    assert np.array_equal(data["response"], renderer.render(poses, times_s=[0.0, 0.5, 1.0]))


def test_moves_that_cannot_be(tmp_path):
    world = moving_world(tmp_path)
    renderer = omma.Renderer(world, make_eye(20), omma.Fixed(4))
    poses = np.stack([np.eye(4)] * 2)
    places = np.stack([[np.eye(4)]] * 2)
    flat = places.copy()
    flat[1, 0, 2, 2] = 0
    for options, message in (
        ({"instances": "box"}, "transforms: expected with instances, found None"),
        ({"transforms": places}, "instances: expected with transforms, found None"),
        (
            {"instances": "box", "transforms": places[:1]},
            r"transforms: expected shape \(2, 1, 4, 4\), one for each pose and thing",
        ),
        ({"instances": "boxx", "transforms": places}, 'nothing called "boxx"'),
        ({"instances": [99], "transforms": places}, r"instances\[0\]: expected an index"),
        ({"instances": "box", "transforms": flat}, r'poses\[1\]: transforms\[0\], of "box"'),
        ({"times_s": [0.0]}, r"times_s: expected shape \(2,\), found \(1,\)"),
        ({"times_s": [0.0, np.nan]}, r"poses\[1\]: time_s: expected a finite time"),
        ({"times_s": [0.0, 1.0], "animation": "fly"}, 'none called "fly"'),
        ({"animation": "turn"}, "animation: is for times_s"),
    ):
        before = [one.world_from_node for one in world.instances]
        with pytest.raises(omma.Error, match=message):
            renderer.render(poses, **options)
        assert np.array_equal(before, [one.world_from_node for one in world.instances])
    with pytest.raises(TypeError, match="speed"):
        renderer.render(poses, speed=2)


def test_worlds_at_a_time_are_pickled(tmp_path):
    scene, _ = bent_tube(tmp_path)
    world = omma.World(scene).at(0.8)
    eye = make_eye(500, acceptance_deg=4)
    for other in (pickle.loads(pickle.dumps(world)), copy.deepcopy(world)):
        assert other.scene == scene
        assert np.array_equal(other.vertices(0), world.vertices(0))
        assert np.array_equal(
            omma.Renderer(other, eye, omma.Fixed(8)).render(np.eye(4)),
            omma.Renderer(world, eye, omma.Fixed(8)).render(np.eye(4)),
        )
        other.at(0)
        assert not np.array_equal(other.vertices(0), world.vertices(0))
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene
    assert again.rig == scene.rig
    assert scene.replace(rig=None) != scene


def test_lit_worlds_see_what_bends(tmp_path, backend):
    scene, _ = bent_tube(tmp_path)
    light = omma.light.uniform_sky(below=0.2)
    world = omma.World(scene, backend=backend).with_light(light, ultraviolet="dark")
    other = world.with_light(light, ultraviolet="dark")
    world.at(1.0)
    eye = make_eye(500, acceptance_deg=4)
    seen = omma.Renderer(world, eye, omma.Fixed(16)).render(np.eye(4))
    assert np.array_equal(omma.Renderer(other, eye, omma.Fixed(16)).render(np.eye(4)), seen)
    built = omma.World(scene, backend=backend).at(1.0).with_light(light, ultraviolet="dark")
    expected = omma.Renderer(built, eye, omma.Fixed(16)).render(np.eye(4))
    assert np.array_equal(seen, expected)
