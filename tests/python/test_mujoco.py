"""Worlds of MuJoCo models: geometry and looks beside MuJoCo's own pictures, moving, bad input.

Skipped visibly without mujoco; what needs its pictures also without OpenGL.
"""

import warnings

import numpy as np
import pytest
from mujoco_models import everything, is_even, mujoco, pictures, silhouettes

import omma
import omma.mujoco

BOX = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="1 1 1"/>
  <body name="a" pos="0 0 1"><freejoint/><geom name="a" type="box" size="0.1 0.2 0.3"/></body>
  <body name="b" pos="1 0 1"><freejoint/><geom type="sphere" size="0.1" rgba="1 0 0 1"/></body>
  <body name="c" mocap="true" pos="0 1 1"><geom name="c" type="sphere" size="0.1"/></body>
  <camera name="eye" pos="0 -3 1" xyaxes="1 0 0 0 0 1"/>
</worldbody></mujoco>"""


def of(xml):
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.fixture(scope="module")
def all_kinds(tmp_path_factory):
    return everything(tmp_path_factory.mktemp("model"))


@pytest.mark.parametrize("camera", ["front", "above", "side"])
def test_silhouettes_are_those_of_mujocos_pictures(all_kinds, camera):
    model, data = all_kinds
    found = silhouettes(model, data, camera)
    assert len(found) >= 10
    both = sum(shared for *_, shared in found)
    either = sum(theirs + ours - shared for _, theirs, ours, shared in found)
    assert both / either > 0.999
    for name, theirs, ours, shared in found:
        # Of what is small a single pixel at the edge, which single precision decides, is more.
        assert theirs + ours - 2 * shared <= max(0.005 * (theirs + ours - shared), 2), name


def coded(linear):
    """8-bit sRGB, not rounded, of linear light."""
    light = np.clip(linear, 0, 1)
    low = light <= 0.0031308
    return 255 * np.where(low, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("camera", ["front", "above", "side"])
def test_textures_and_colours_lie_where_mujoco_lays_them(all_kinds, camera):
    """Every geom by itself, lit by nothing but ambient light of 1, as an unlit world is."""
    model, data = all_kinds
    head = model.vis.headlight
    head.ambient[:], head.diffuse[:], head.specular[:] = 1, 0, 0
    model.light_diffuse[:] = model.light_specular[:] = model.light_ambient[:] = 0
    theirs = pictures(model, data, camera).astype(float)
    world = omma.mujoco.world_from_model(model, data)
    view = omma.mujoco.camera(data, camera)
    ours = coded(omma.render_camera(world, view, width=320, height=240, samples=16))
    geoms = pictures(model, data, camera, segmentation=True)
    for geom in np.unique(geoms[geoms[..., 1] == mujoco.mjtObj.mjOBJ_GEOM][:, 0]):
        mine = (geoms[..., 0] == geom) & (geoms[..., 1] == mujoco.mjtObj.mjOBJ_GEOM)
        check_alike(model.geom(geom).name, theirs, ours, mine)
    check_alike("sky", theirs, ours, geoms[..., 0] < 0)


def check_alike(name, theirs, ours, mine):
    """Within the squares of a texture colours are the same, but for rounding and how the one that
    is smooth, the egg's, is read between texels. Where squares meet MuJoCo has one or the other, or
    a mix of coded colours, we a mix of light: less alike, but far from what lies elsewhere."""
    if mine.sum() < 100 or name == "glass":  # what it lets through is mixed otherwise
        return
    inside = mine & is_even(theirs) & is_even(ours)
    if inside.sum() >= 20:
        apart = np.abs(theirs[inside] - ours[inside]).max(-1)
        assert np.quantile(apart, 0.97) < 4, name
    if theirs[mine].std(axis=0).max() >= 10:
        alike = np.corrcoef(theirs[mine].ravel(), ours[mine].ravel())[0, 1]
        assert alike > 0.85, (name, alike)


def test_a_face_turned_or_mirrored_would_be_seen(all_kinds):
    """The same measure finds a ball whose faces lie elsewhere."""
    model, data = all_kinds
    world = omma.mujoco.world_from_model(model, data)
    view = omma.mujoco.camera(data, "side")
    before = coded(omma.render_camera(world, view, width=320, height=240, samples=4))
    place = np.eye(4)
    place[:3, :3] = data.geom("ball").xmat.reshape(3, 3) @ np.diag([-1.0, -1, 1])
    place[:3, 3] = data.geom("ball").xpos
    world.set_transforms("ball", place)
    after = coded(omma.render_camera(world, view, width=320, height=240, samples=4))
    ball = pictures(model, data, "side", segmentation=True)[..., 0] == model.geom("ball").id
    check_alike("ball", before, before, ball)
    with pytest.raises(AssertionError):
        check_alike("ball", before, after, ball)


def test_things_have_the_names_of_geoms():
    model, data = of(BOX)
    world = omma.mujoco.world_from_model(model, data)
    assert [one.name for one in world.instances] == ["floor", "a", "geom 2", "c"]
    place = world.instances[world.index("a")].world_from_node
    np.testing.assert_allclose(place[:3, 3], data.geom("a").xpos)
    assert [camera.name for camera in world.scene.cameras] == ["eye"]


def test_update_moves_what_moved_and_nothing_else():
    model, data = of(BOX)
    world = omma.mujoco.world_from_model(model, data)
    data.qpos[:3] = 0.3, 0.2, 2.0
    data.mocap_pos[0] = 0.5, 0.5, 0.5
    mujoco.mj_forward(model, data)
    omma.mujoco.update(world, data)
    for index, instance in enumerate(world.instances):
        np.testing.assert_allclose(instance.world_from_node[:3, 3], data.geom_xpos[index])
        np.testing.assert_allclose(instance.world_from_node[:3, :3].ravel(), data.geom_xmat[index])
    assert set(world._moved) == {1, 2, 3}  # the floor stays where rays find it fastest
    data.geom_xpos[0] = 0, 0, -0.5  # unless it is somewhere else after all
    omma.mujoco.update(world, data)
    assert world.instances[0].world_from_node[2, 3] == -0.5


def test_sizes_that_change_are_told_once_and_not_followed():
    model, data = of(BOX)
    world = omma.mujoco.world_from_model(model, data)
    omma.mujoco.update(world, data)
    model.geom("a").size[0] *= 2
    with pytest.warns(UserWarning, match="the size of geom 'a' has changed") as told:
        [omma.mujoco.update(world, data) for _ in range(2)]
    assert len(told) == 1
    assert told[0].filename == __file__
    model.geom("a").size[0] /= 2  # as the world shows it
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.mujoco.update(world, data)


@pytest.mark.parametrize("merged", [False, True])
def test_sizes_that_change_before_the_first_update_are_told_too(merged):
    model, data = of(BOX)
    scene = omma.mujoco.scene_from_model(model, data)
    scenes = [scene, omma.scene.sphere(0.1, center_m=(5, 5, 5), name="sun")]
    world = omma.World(omma.scene.merge_scenes(scenes) if merged else scene)
    model.geom("a").size[0] *= 2
    with pytest.warns(UserWarning, match="the size of geom 'a' has changed") as told:
        [omma.mujoco.update(world, data) for _ in range(2)]
    assert len(told) == 1


def test_a_thing_that_another_model_calls_otherwise_is_named():
    model, data = of(BOX)
    _, other = of(BOX.replace('geom name="c"', 'geom name="d"'))
    world = omma.mujoco.world_from_model(model, data)
    for one in (world, world.with_background(omma.Background.constant((1, 1, 1)))):
        with pytest.raises(omma.Error, match="none of its geoms is called 'c'"):
            omma.mujoco.update(one, other)
    # A world that may hold more than a model does not say whose its things are.
    scene = omma.mujoco.scene_from_model(model, data)
    omma.mujoco.update(omma.World(scene), other)


def test_moving_things_are_what_update_sets(all_kinds):
    model, data = of(BOX)
    world = omma.mujoco.world_from_model(model, data)
    data.qpos[:3] = 0.3, 0.2, 2.0
    mujoco.mj_forward(model, data)
    names, transforms = omma.mujoco.moving_things(world, data)
    assert names == ["a", "geom 2", "c"]
    eye = omma.eye.generate_eye(300)
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    pose = omma.look_at((1, -3, 2), (0, 0, 1), up=(0, 0, 1))
    before = renderer.render(pose)
    given = renderer.render(pose, instances=names, transforms=transforms[None])
    assert (renderer.render(pose) == before).all()  # the world stays as it is
    omma.mujoco.update(world, data)
    assert (renderer.render(pose) == given).all()
    assert (given != before).any()
    data.geom_xpos[0] = 0, 0, -0.5  # welded to the world, and elsewhere
    with pytest.raises(omma.Error, match="found geom 'floor' elsewhere"):
        omma.mujoco.moving_things(world, data)
    omma.mujoco.update(world, data)
    omma.mujoco.moving_things(world, data)
    kinds, there = all_kinds
    with pytest.raises(omma.Error, match="without skins, which bend, found 'skin strip'"):
        omma.mujoco.moving_things(omma.mujoco.world_from_model(kinds, there), there)


def test_an_updated_world_is_one_made_there(all_kinds):
    model, _ = all_kinds
    data, later = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    later.qpos[:3] = -1.0, -0.4, 0.8
    later.joint("bend").qpos = 1.1
    mujoco.mj_forward(model, later)
    world = omma.mujoco.world_from_model(model, data)
    eye = omma.eye.generate_eye(500)
    pose = omma.mujoco.camera(data, "side").world_from_camera
    before = omma.Renderer(world, eye, omma.Fixed(16)).render(pose)
    omma.mujoco.update(world, later)
    moved = omma.Renderer(world, eye, omma.Fixed(16)).render(pose)
    made = omma.mujoco.world_from_model(model, later)
    there = omma.Renderer(made, eye, omma.Fixed(16)).render(pose)
    assert np.abs(before - there).max() > 0.05
    # A ray in ten thousand may pass an edge that it met: a sixteenth of a response.
    assert np.quantile(np.abs(moved - there), 0.999) < 1e-3
    skin = [mesh.name for mesh in world.scene.meshes].index("skin strip")
    np.testing.assert_allclose(world.vertices(skin), made.vertices(skin), atol=1e-6)


def test_geoms_that_look_the_same_share_a_mesh():
    geoms = "".join(f'<geom type="box" size="1 1 1" pos="{3 * k} 0 0"/>' for k in range(20))
    model, data = of(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    scene = omma.mujoco.scene_from_model(model, data)
    assert (scene.mesh_count, scene.instance_count) == (1, 20)


def test_hidden_geoms_and_groups_are_not_there(all_kinds):
    model, data = all_kinds
    names = {one.name for one in omma.mujoco.scene_from_model(model, data).instances}
    assert "unseen" not in names
    assert "unseen" in {
        one.name for one in omma.mujoco.scene_from_model(model, data, groups=[4]).instances
    }
    hidden = omma.mujoco.scene_from_model(model, data, hidden=["ball"])
    assert names - {one.name for one in hidden.instances} == {"ball"}


def test_colours_are_coded_or_light():
    model, data = of('<mujoco><worldbody><geom type="sphere" size="1" rgba="0.5 0.5 0.5 1"/>'
                     "</worldbody></mujoco>")  # fmt: skip
    for colors, light in (("srgb", 0.21404), ("linear", 0.5)):
        scene = omma.mujoco.scene_from_model(model, data, colors=colors)
        assert scene.materials[0].base_color[0] == pytest.approx(light, rel=1e-4)


def test_a_lamp_makes_the_light_that_the_rule_says():
    """A directional light of diffuse colour 1 is 10,000 lx: a white floor of albedo 0.5 in it."""
    model, data = of("""<mujoco><worldbody>
      <light name="sun" type="directional" dir="0 0 -1" diffuse="1 1 1"/>
      <light name="near" pos="0 0 2" dir="0 0 -1" cutoff="180" diffuse="1 1 1"/>
      <geom type="plane" size="9 9 1" rgba="0.7 0.7 0.7 1"/></worldbody></mujoco>""")
    model.stat.center[:] = 0
    scene = omma.mujoco.scene_from_model(model, data)
    sun, near = scene.lights
    assert (sun.type, sun.intensity, near.type) == ("directional", 10_000, "point")
    assert near.intensity == pytest.approx(10_000 * 2**2)  # the same at the model's middle
    np.testing.assert_allclose(sun.world_from_light[:3, 2], (0, 0, 1), atol=1e-12)
    light = omma.light.uniform_sky(1e-3, bands=omma.light.Bands.equal(4, 400, 700))
    world = omma.mujoco.world_from_model(model, data, light=light, lighting="path", depth=1)
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1)
    down = np.eye(4)
    down[:3, 3] = 3.0, 0, 5.0
    assert omma.Renderer(world, eye, omma.Fixed(64)).render(down).min() > 1e15


def test_cameras_and_bodies_are_poses(all_kinds):
    _, data = all_kinds
    view = omma.mujoco.camera(data, "front")
    np.testing.assert_allclose(view.world_from_camera[:3, 3], data.cam("front").xpos)
    assert np.degrees(view.yfov_rad) == pytest.approx(50)
    pose = omma.mujoco.head_pose(data, "die")
    body = data.body("die").xmat.reshape(3, 3)
    np.testing.assert_allclose(-pose[:3, 2], body[:, 0], atol=1e-12)  # ahead is +X
    np.testing.assert_allclose(pose[:3, 1], body[:, 2], atol=1e-12)  # up is +Z
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1)


def bad(model, **changes):
    for name, (index, value) in changes.items():
        getattr(model, name)[index] = value
    return model


def test_bad_input_is_named():
    model, data = of(BOX)
    _, other = of(BOX.replace('"0.1 0.2 0.3"', '"0.2 0.2 0.3"'))
    world = omma.mujoco.world_from_model(model, data)
    ball = of('<mujoco><worldbody><geom name="x" type="sphere" size="1"/></worldbody></mujoco>')
    diverged = mujoco.MjData(model)
    mujoco.mj_forward(model, diverged)
    diverged.geom_xpos[1] = np.nan
    make, update = omma.mujoco.scene_from_model, omma.mujoco.update
    for call, said in (
        (lambda: make(3), "model: expected a mujoco.MjModel, found int"),
        (lambda: make(model, 3), "data: expected a mujoco.MjData, found int"),
        (lambda: make(model, ball[1]), "data: expected those of the model"),
        (lambda: make(model, mujoco.MjData(model)), "call mujoco.mj_forward first"),
        (lambda: make(model, data, hidden=["nose"]), "hidden: expected one of floor"),
        (lambda: make(model, data, hidden="a"), "hidden: expected a list of names"),
        (lambda: make(model, data, groups=0), "groups: expected numbers such as (0, 1, 2), found"),
        (lambda: make(model, data, groups="0"), "groups: expected numbers such as (0, 1, 2)"),
        (lambda: make(model, data, colors="rgb"), "colors: expected one of srgb, linear"),
        (lambda: make(model, data, lux=0), "lux: expected a number above 0"),
        (lambda: update(world, 3), "data: expected a mujoco.MjData, found int"),
        (lambda: update(world, diverged), "data: expected finite positions"),
        (lambda: update(world, ball[1]), "none of its geoms and skins is in the world"),
        (lambda: update(world, other), "geom 'a' is a box 0.2 x 0.2 x 0.3"),
        (lambda: omma.mujoco.camera(data, "ey"), "did you mean 'eye'"),
        (lambda: omma.mujoco.head_pose(data, 9), "body: expected 0 to 3, found 9"),
        (lambda: make(bad(of(BOX)[0], geom_type=(1, 42))), "found type 42"),
        (lambda: make(of(BOX.replace('name="c"', 'name="geom 2"'))[0]), "'geom 2' twice"),
    ):
        with pytest.raises(omma.Error) as error:
            call()
        assert said in str(error.value), str(error.value)
    with pytest.raises(TypeError, match=r"world: expected omma\.World"):
        update(model, data)


def test_an_older_mujoco_is_named(monkeypatch):
    monkeypatch.setattr(mujoco, "mj_version", lambda: 330)
    with pytest.raises(omma.Error, match=r"need mujoco 3\.3\.3 or newer, found"):
        omma.mujoco.scene_from_model(of(BOX)[0])


def test_textures_of_odd_sizes_are_errors(all_kinds):
    model, _ = everything_copy(all_kinds[0])
    dice = next(k for k in range(model.ntex) if model.texture(k).name == "dice")
    for change, said in (
        ({"tex_height": (dice, 99)}, "texture 'dice': expected one or six squares"),
        ({"tex_type": (dice, 7)}, "texture 'dice': expected a 2d, cube or skybox texture"),
        ({"tex_nchannel": (dice, 5)}, "texture 'dice': expected a picture, found"),
    ):
        changed, data = everything_copy(all_kinds[0])
        with pytest.raises(omma.Error, match=said):
            omma.mujoco.scene_from_model(bad(changed, **change), data)


def everything_copy(model):
    import copy

    other = copy.copy(model)
    data = mujoco.MjData(other)
    mujoco.mj_forward(other, data)
    return other, data
