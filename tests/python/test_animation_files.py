"""Animations, skins and morph targets in files that are wrong: errors that name file and place; and
what becomes of animations where scenes are put together or written."""

import json

import numpy as np
import pytest
from animated_scenes import Builder, cube, swinging_box, transform
from conftest import make_eye

import omma
from omma.job.info import describe_file


def animated(**node):
    """A cube on a node that an animation moves, to be spoiled."""
    made = Builder()
    index = made.node(mesh=made.mesh(*cube()[::2]), name="box", **node)
    made.animation([(index, "translation", [0, 1, 2], np.eye(3), "LINEAR")], "move")
    return made


def skinned(weights=(0.5, 0.5, 0, 0), joints=(0, 1, 0, 0), sets=1, **more):
    """A cube on two bones."""
    positions, _, triangles = cube()
    made = Builder()
    attributes = dict(more)
    for k in range(sets):
        attributes[f"JOINTS_{k}"] = made.accessor(np.tile(joints, (24, 1)), "u1")
        attributes[f"WEIGHTS_{k}"] = made.accessor(np.tile(np.array(weights) / sets, (24, 1)))
    mesh = made.mesh(positions, triangles, **attributes)
    root = made.node(name="root")
    tip = made.node(root, name="tip", translation=[0, 1, 0])
    made.node(name="body", mesh=mesh, skin=made.skin([root, tip]))
    made.animation([(tip, "translation", [0, 1], [[0, 0, 0], [0, 3, 0]], "LINEAR")])
    return made


def set_in(document, path, value):
    """Put a value where a path such as "animations/0/samplers/0/input" leads."""
    *way, last = [int(step) if step.isdigit() else step for step in path.split("/")]
    for step in way:
        document = document[step]
    document[last] = value


def spoiled(made, path, value):
    set_in(made.document, path, value)
    return made


def with_input(times):
    made = animated()
    return spoiled(made, "animations/0/samplers/0/input", made.accessor(times))


def with_output(values, **sampler):
    made = animated()
    made.document["animations"][0]["samplers"][0] |= sampler
    return spoiled(made, "animations/0/samplers/0/output", made.accessor(values))


def with_path(path, values):
    made = with_output(values)
    return spoiled(made, "animations/0/channels/0/target/path", path)


def twice(made):
    channels = made.document["animations"][0]["channels"]
    channels.append(channels[0])
    return made


def with_bind(matrices):
    made = skinned()
    columns = np.asarray(matrices, float).transpose(0, 2, 1).reshape(-1, 16)
    return spoiled(made, "skins/0/inverseBindMatrices", made.accessor(columns))


BAD = {
    "times that do not grow": (
        lambda: with_input([0, 1, 1]),
        r"animations\[0\]\.samplers\[0\]\.input: expected times that grow, found 1\.0+ s at key 2",
    ),
    "a time that is no number": (
        lambda: with_input([0, np.nan, 2]),
        r"animations\[0\]\.samplers\[0\]\.input: accessor \d+: element 1 is not finite",
    ),
    "no keys": (
        lambda: with_input(np.empty(0)),
        r"animations\[0\]\.samplers\[0\]\.input: expected at least one key",
    ),
    "times of three components": (
        lambda: with_input(np.eye(3)),
        r"animations\[0\]\.samplers\[0\]\.input: expected floats, one a key",
    ),
    "fewer values than keys": (
        lambda: with_output(np.eye(3)[:2]),
        r"animations\[0\]\.samplers\[0\]\.output: expected 3 elements for 3 keys of translation",
    ),
    "a spline without tangents": (
        lambda: with_output(np.eye(3), interpolation="CUBICSPLINE"),
        r"animations\[0\]\.samplers\[0\]\.output: expected 9 elements for 3 keys",
    ),
    "a value that is no number": (
        lambda: with_output(np.diag([1, np.inf, 1])),
        r"animations\[0\]\.samplers\[0\]\.output: accessor \d+: element 1 is not finite",
    ),
    "an unknown interpolation": (
        lambda: with_output(np.eye(3), interpolation="SMOOTH"),
        r"animations\[0\]\.samplers\[0\]\.interpolation: expected LINEAR, STEP or CUBICSPLINE",
    ),
    "a rotation of zeros": (
        lambda: with_path("rotation", np.array([[0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 1]])),
        r"samplers\[0\]\.output: the rotation of key 1 is not a unit quaternion",
    ),
    "a rotation of three components": (
        lambda: with_path("rotation", np.eye(3)),
        r"samplers\[0\]\.output: expected 4 components for rotation, found 3",
    ),
    "weights of no targets": (
        lambda: with_path("weights", np.ones(3)),
        r"animations\[0\]\.channels\[0\]\.target\.node: node 0 has no mesh with morph targets",
    ),
    "a node that is not there": (
        lambda: spoiled(animated(), "animations/0/channels/0/target/node", 7),
        r"animations\[0\]\.channels\[0\]\.target\.node: refers to node 7, there are 1",
    ),
    "a sampler that is not there": (
        lambda: spoiled(animated(), "animations/0/channels/0/sampler", 7),
        r"animations\[0\]\.channels\[0\]\.sampler: refers to sampler 7, there are 1",
    ),
    "an accessor that is not there": (
        lambda: spoiled(animated(), "animations/0/samplers/0/input", 99),
        r"animations\[0\]\.samplers\[0\]\.input: refers to accessor 99",
    ),
    "an input that is text": (
        lambda: spoiled(animated(), "animations/0/samplers/0/input", "x"),
        r"animations\[0\]\.samplers\[0\]\.input: expected an integer",
    ),
    "a node with a matrix": (
        lambda: animated(matrix=np.eye(4).ravel().tolist()),
        r"animations\[0\]\.channels\[0\]\.target\.node: node 0 has a matrix",
    ),
    "the same part twice": (
        lambda: twice(animated()),
        r"animations\[0\]\.channels\[1\]: moves the translation of node 0, as another channel",
    ),
    "a joint that the skin has not": (
        lambda: skinned(joints=(0, 2, 0, 0)),
        r"mesh 0, primitive 0, JOINTS_0: vertex 0 has joint 2, the skin has 2",
    ),
    "weights that do not sum to 1": (
        lambda: skinned(weights=(0.5, 0.4, 0, 0)),
        r"WEIGHTS_0: the weights of vertex 0 sum to 0\.9\d*, expected 1 to within 0\.02",
    ),
    "weights below 0": (
        lambda: skinned(weights=(1.5, -0.5, 0, 0)),
        r"WEIGHTS_0: the weights of vertex 0 sum to 1\.0+ and some are below 0",
    ),
    "twelve bones on a vertex": (
        lambda: skinned(sets=3),
        r"mesh 0, primitive 0: JOINTS_2: expected at most 8 bones on a vertex",
    ),
    "a skin without joints of its vertices": (
        lambda: spoiled(animated(skin=0), "skins", [{"joints": [0]}]),
        r"primitive 0: JOINTS_0: is missing, as its node has a skin",
    ),
    "a skin that is not there": (
        lambda: animated(skin=3),
        r'node 0 "box": refers to skin 3, there are 0',
    ),
    "a bone that is no node": (
        lambda: spoiled(skinned(), "skins/0/joints", [0, 9]),
        r"skins\[0\]\.joints\[1\]: refers to node 9, there are 3",
    ),
    "too few bind matrices": (
        lambda: with_bind([np.eye(4)]),
        r"skins\[0\]\.inverseBindMatrices: expected a 4 x 4 matrix for each of 2 joints, found 1",
    ),
    "a bind matrix that is not affine": (
        lambda: with_bind([np.eye(4), np.ones((4, 4))]),
        r"skins\[0\]\.inverseBindMatrices: the bottom row of matrix 1 is not 0 0 0 1",
    ),
    "weights for another number of targets": (
        lambda: spoiled(blended(), "nodes/0/weights", [1, 0, 0]),
        r"node 0: weights: expected 2, one for each morph target, found 3",
    ),
    "a target of fewer vertices": (
        lambda: blended(count=20),
        r"primitive 0, targets\[0\]: POSITION has 20 elements, POSITION has 24",
    ),
}


def blended(count=24):
    positions, _, triangles = cube()
    made = Builder()
    targets = [{"POSITION": positions[:count]}, {"POSITION": positions[:count]}]
    node = made.node(mesh=made.mesh(positions, triangles, targets=targets))
    made.animation([(node, "weights", [0, 1], [[0, 0], [1, 1]], "LINEAR")])
    return made


@pytest.mark.parametrize("name", BAD)
def test_files_that_are_wrong_say_where(tmp_path, name):
    make, message = BAD[name]
    path = make().write(tmp_path / "bad.gltf")
    with pytest.raises(omma.Error, match=message) as caught:
        omma.load_scene(path)
    assert str(caught.value).startswith(str(path))


def test_weights_are_made_to_sum_to_one(tmp_path):
    off = omma.load_scene(skinned(weights=(0.5, 0.49, 0, 0)).write(tmp_path / "off.gltf"))
    exact = omma.load_scene(skinned(weights=(50 / 99, 49 / 99, 0, 0)).write(tmp_path / "on.gltf"))
    shapes = [omma.World(scene).at(1).vertices(0) for scene in (off, exact)]
    assert np.allclose(shapes[0], shapes[1], atol=1e-6)


def test_what_is_flattened_says_when(tmp_path):
    made = animated()
    made.document["animations"][0]["channels"][0]["target"]["path"] = "scale"
    scene = omma.load_scene(made.write(tmp_path / "flat.gltf"))
    world = omma.World(scene)
    with pytest.raises(omma.Error, match='animation at 0 s, node "box"'):
        world.at(0)  # scale 1, 0, 0
    assert np.array_equal(world.instances[0].world_from_node, np.eye(4))


def test_times_and_names_that_cannot_be(tmp_path):
    world = omma.World(omma.load_scene(animated().write(tmp_path / "one.gltf")))
    still = omma.World(omma.scene.box())
    for call, message in (
        (lambda: world.at(np.nan), "time_s: expected a finite time"),
        (lambda: world.at(0, "walk"), 'animation: there is none called "walk" .*there are "move"'),
        (lambda: world.at(0, 1), "animation: expected an index of the 1 animations"),
        (lambda: still.at(0), "there is no animation in it"),
        (lambda: still.at(0, "walk"), 'none called "walk" in scene, which has none'),
    ):
        with pytest.raises(omma.Error, match=message):
            call()
    with pytest.raises(TypeError, match="time_s: expected a number"):
        world.at("noon")


def test_animations_that_move_the_same_are_asked_for_one_by_one(tmp_path):
    made = animated()
    made.animation([(0, "translation", [0, 1], [[0, 0, 0], [0, 5, 0]], "STEP")], "jump")
    world = omma.World(omma.load_scene(made.write(tmp_path / "two.gltf")))
    with pytest.raises(
        omma.Error, match=r'"move" and .*"jump" .*both move the translation of node'
    ):
        world.at(0.5)
    world.at(1, "jump")
    assert np.array_equal(world.instances[0].world_from_node, transform([0, 5, 0]))
    world.at(1, "move")
    assert np.array_equal(world.instances[0].world_from_node, transform([0, 1, 0]))


def test_scenes_with_animations_are_put_together(tmp_path):
    one = omma.load_scene(skinned().write(tmp_path / "one.gltf"))
    other = omma.load_scene(animated().write(tmp_path / "other.gltf"))
    away = transform([0, 0, -8], [0, 1, 0, 0])
    both = omma.scene.merge_scenes([omma.scene.box(), one, omma.scene.place_scene(other, away)])
    assert len(both.animations) == 2
    world = omma.World(both).at(1)
    alone = omma.World(one).at(1)
    assert np.array_equal(world.vertices(1), alone.vertices(0))
    expected = away @ omma.World(other).at(1).instances[0].world_from_node
    assert np.allclose(world.instances[2].world_from_node, expected)
    placed = omma.World(omma.scene.place_scene(one, away)).at(1)
    node = placed.instances[0].world_from_node
    seen = placed.vertices(0) @ node[:3, :3].T + node[:3, 3]
    at_home = alone.vertices(0) @ away[:3, :3].T + away[:3, 3]
    assert np.allclose(seen, at_home, atol=1e-5)


def test_a_rig_goes_with_its_scene(tmp_path):
    scene = omma.load_scene(skinned().write(tmp_path / "one.gltf"))
    assert scene.replace(materials=[omma.scene.Material(name="red")]).rig == scene.rig
    assert "1 animations" in repr(scene.rig)
    with pytest.raises(omma.Error, match=r"rig: deformations\[0\]: expected 4 vertices"):
        omma.scene.plane().replace(rig=scene.rig)
    with pytest.raises(TypeError, match=r"rig: expected omma.scene.Rig, found str"):
        omma.Scene(rig="walk")


def test_what_is_written_stands_still(tmp_path):
    scene = omma.load_scene(animated().write(tmp_path / "one.gltf"))
    omma.scene.save_scene(tmp_path / "still.glb", scene)
    assert omma.load_scene(tmp_path / "still.glb") == scene.replace(rig=None)


def test_lamps_stand_still_and_say_so(tmp_path):
    made = animated()
    made.document["extensionsUsed"] = ["KHR_lights_punctual"]
    made.document["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    made.node(0, name="lamp", extensions={"KHR_lights_punctual": {"light": 0}})
    path = made.write(tmp_path / "lamp.gltf")
    with pytest.warns(UserWarning, match="stand still"):
        scene = omma.load_scene(path)
    assert any("lamps that an animation moves stand still" in one for one in scene.warnings)
    assert json.loads(path.read_text())["nodes"][0]["children"] == [1]


def test_files_are_rendered_by_the_times_of_a_path(tmp_path):
    """Without times, or where an animation would have to be named, at rest, with a warning."""
    scene = swinging_box(tmp_path / "swing.gltf")
    omma.save_eye(tmp_path / "e.csv", make_eye(400))
    header = "x,y,z,qx,qy,qz,qw"
    (tmp_path / "timed.csv").write_text(f"t_s,{header}\n0.25,0,0,0,0,0,0,1\n1,0,0,0,0,0,0,1\n")
    (tmp_path / "path.csv").write_text(f"{header}\n0,0,0,0,0,0,1\n")

    def rendered(path, scene=scene.path):
        report = omma.render_file(
            scene, tmp_path / "r.npy", omma.Fixed(4), eyes=tmp_path / "e.csv", path=tmp_path / path
        )
        told = [one for one in report.warnings if "at rest" in one]
        return np.load(tmp_path / "r.npy"), told

    renderer = omma.Renderer(scene, omma.load_eye(tmp_path / "e.csv"), omma.Fixed(4))
    at_rest = renderer.render(np.eye(4))
    moved = renderer.render(np.stack([np.eye(4)] * 2), times_s=[0.25, 1])
    assert (moved[0] != moved[1]).any()
    found, told = rendered("timed.csv")
    assert np.array_equal(found, moved)
    assert not told
    omma.job.render_like(tmp_path / "r.npy", tmp_path / "again.npy")
    assert np.array_equal(np.load(tmp_path / "again.npy"), moved)
    found, (told,) = rendered("path.csv")
    assert np.array_equal(found, at_rest)
    assert "swing, 1 s" in told
    assert ("animation", "swing, 1 s") in describe_file(scene.path)
    made = Builder()
    node = made.node(mesh=made.mesh(*cube()[::2]), name="box", translation=[0, 0, -3])
    for name in ("walk", "run"):
        made.animation([(node, "translation", [0, 1], [[0, 0, -3], [1, 0, -3]], "LINEAR")], name)
    two = made.write(tmp_path / "two.gltf")
    found, told = rendered("timed.csv", two)
    assert len(told) == 1
    assert np.array_equal(found[0], found[1])
