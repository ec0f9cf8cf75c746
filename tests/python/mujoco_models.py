"""Models that the tests of MuJoCo make, and its own pictures of them beside ours."""

import os

import numpy as np
import pytest

os.environ.setdefault("MUJOCO_GL", "egl")
os.environ.setdefault("PYOPENGL_PLATFORM", os.environ["MUJOCO_GL"])
mujoco = pytest.importorskip("mujoco", reason="needs pip install 'omma[mujoco]'")

import omma  # noqa: E402
import omma.mujoco  # noqa: E402

# A house with a chimney, so that nothing about it is the same from two sides; a skin of a strip.
HOUSE = """
v -1 -0.6 0
v 1 -0.6 0
v 1 0.6 0
v -1 0.6 0
v -1 -0.6 1
v 1 -0.6 1
v 1 0.6 1
v -1 0.6 1
v -1 0 1.6
v 1 0 1.6
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 6/3
f 1/1 6/3 5/4
f 2/1 3/2 7/3
f 2/1 7/3 6/4
f 3/1 4/2 8/3
f 3/1 8/3 7/4
f 4/1 1/2 5/3
f 4/1 5/3 8/4
f 5/1 6/2 10/3
f 5/1 10/3 9/4
f 7/1 8/2 9/3
f 7/1 9/3 10/4
f 6/1 7/2 10/3
f 8/1 5/2 9/3
f 1/1 4/2 3/3
f 1/1 3/3 2/4
"""

EVERYTHING = """
<mujoco>
  <visual>
    <quality numslices="96" numstacks="96" numquads="4" shadowsize="0" offsamples="0"/>
    <map znear="0.002" zfar="20"/>
  </visual>
  <statistic extent="4" center="0 0 0.5"/>
  <asset>
    <texture name="sky" type="skybox" builtin="gradient" rgb1="0.3 0.5 0.9" rgb2="0.9 0.8 0.6"
      width="64" height="384"/>
    <texture name="checks" type="2d" builtin="checker" rgb1="0.9 0.1 0.1" rgb2="0.1 0.2 0.8"
      width="60" height="60"/>
    <texture name="odd" type="2d" builtin="gradient" rgb1="1 1 0" rgb2="0 0.3 0.3"
      width="37" height="23"/>
    <texture name="dice" type="cube" file="dice.png" gridsize="3 4" gridlayout=".U..LFRB.D.."/>
    <texture name="marble" type="cube" builtin="gradient" rgb1="0.9 0.9 0.9" rgb2="0.2 0.6 0.2"
      width="32" height="192"/>
    <texture name="letter" type="2d" file="letter.png"/>
    <material name="checks" texture="checks" texrepeat="3 2"/>
    <material name="checks uniform" texture="checks" texrepeat="2 2" texuniform="true"/>
    <material name="dice" texture="dice" emission="0"/>
    <material name="dice uniform" texture="dice" texuniform="true"/>
    <material name="marble" texture="marble" rgba="1 0.8 0.8 1"/>
    <material name="letter" texture="letter"/>
    <material name="odd" texture="odd"/>
    <hfield name="hills" file="hills.png" size="0.6 0.5 0.4 0.1"/>
    <mesh name="house" file="house.obj" scale="0.3 0.3 0.3"/>
    <skin name="strip" file="strip.skn" material="odd"/>
  </asset>
  <worldbody>
    <light name="sun" type="directional" dir="-0.3 0.2 -1" diffuse="0.8 0.8 0.7"/>
    <light name="lamp" pos="1 -1 3" dir="-0.3 0.3 -1" cutoff="40"/>
    <geom name="ground" type="plane" size="0 0 1" material="checks uniform"/>
    <geom name="hills" type="hfield" hfield="hills" pos="-1.6 1.8 0.1" rgba="0.5 0.4 0.2 1"/>
    <geom name="house" type="mesh" mesh="house" pos="1.7 1.5 0.0" euler="0 0 30"
      material="letter"/>
    <geom name="board" type="plane" size="0.4 0.3 1" pos="0 2.5 0.5" euler="70 0 0"
      material="checks"/>
    <geom name="glass" type="box" size="0.1 0.1 0.4" pos="2.2 0.2 0.5" rgba="0.2 0.9 0.9 0.4"/>
    <geom name="unseen" type="sphere" size="0.3" pos="0 0 3" group="4"/>
    <body name="ball" pos="-1.2 0 0.6"><freejoint/>
      <geom name="ball" type="sphere" size="0.3" material="dice"/></body>
    <body name="pill" pos="-0.5 -0.2 0.9" euler="30 40 10"><freejoint/>
      <geom name="pill" type="capsule" size="0.15 0.3" material="checks"/></body>
    <body name="egg" pos="0.2 0.1 0.5" euler="0 20 0"><freejoint/>
      <geom name="egg" type="ellipsoid" size="0.2 0.3 0.4" material="marble"/></body>
    <body name="tin" pos="0.9 0.2 0.6" euler="50 0 20"><freejoint/>
      <geom name="tin" type="cylinder" size="0.2 0.3" material="dice"/></body>
    <body name="die" pos="1.5 -0.2 0.5" euler="20 30 40"><freejoint/>
      <geom type="box" size="0.2 0.3 0.15" material="dice uniform"/>
      <geom name="knob" type="sphere" size="0.08" pos="0 0 0.2" rgba="1 0.5 0 1"/></body>
    <body name="lower" pos="-0.2 1.2 0.4">
      <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.3" group="3"/>
      <body name="upper" pos="0 0 0.4"><joint name="bend" type="hinge" axis="1 0 0"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.4" group="3"/></body></body>
    <body name="cart" mocap="true" pos="0 -1 0.1">
      <geom name="cart" type="box" size="0.15 0.1 0.1" rgba="0.1 0.1 0.1 1"/></body>
    <camera name="front" pos="0 -4 1.4" xyaxes="1 0 0 0 0.25 1" fovy="50"/>
    <camera name="above" pos="1.5 1 5" xyaxes="1 0 0 0 1 0.1" fovy="60"/>
    <camera name="side" pos="-4 0.5 1" xyaxes="0 -1 0 0.1 0 1" fovy="45"/>
  </worldbody>
</mujoco>
"""


def strip_skin():
    """A skin file: a strip of three squares on two bodies, seen from both sides."""
    places = np.array([[x, 0, z] for z in (0.0, 0.2, 0.5, 0.8) for x in (-0.25, 0.25)], "<f4")
    front = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4], [4, 5, 7], [4, 7, 6]]
    faces = np.array([*front, *[one[::-1] for one in front]], "<i4")
    coordinates = np.array([[x, z] for z in (1.0, 0.7, 0.3, 0.0) for x in (0.0, 1.0)], "<f4")
    blob = np.array([len(places), len(places), len(faces), 2], "<i4").tobytes()
    blob += places.tobytes() + coordinates.tobytes() + faces.tobytes()
    for name, height, weights in (("lower", 0.0, [1, 1, 1, 1, 0.4, 0.4, 0, 0]),
                                  ("upper", 0.4, [0, 0, 0, 0, 0.6, 0.6, 1, 1])):  # fmt: skip
        vertices = np.flatnonzero(weights).astype("<i4")
        blob += name.encode().ljust(40, b"\0")
        blob += np.array([0, 0, height, 1, 0, 0, 0], "<f4").tobytes()
        blob += np.array([len(vertices)], "<i4").tobytes() + vertices.tobytes()
        blob += np.asarray(weights, "<f4")[vertices].tobytes()
    return blob


def png(pixels, folder):
    path = folder / "picture.png"
    omma.save_png(path, pixels)
    return path.read_bytes()


def letter():
    """An F on white with a red corner: nothing is the same turned or mirrored."""
    pixels = np.full((40, 40, 3), 255, np.uint8)
    pixels[6:34, 8:13] = pixels[6:11, 8:30] = pixels[18:23, 8:24] = 0
    pixels[:6, :6] = 255, 0, 0
    return pixels


def dice():
    """Six faces in a 3 x 4 grid, each of its own colour with an F."""
    colors = {(0, 1): (255, 160, 160), (1, 0): (160, 255, 160), (1, 1): (160, 160, 255),
              (1, 2): (255, 255, 140), (1, 3): (255, 140, 255),
              (2, 1): (140, 255, 255)}  # fmt: skip
    pixels = np.zeros((120, 160, 3), np.uint8)
    for (row, column), color in colors.items():
        pixels[40 * row : 40 * row + 40, 40 * column : 40 * column + 40] = np.minimum(
            letter(), color
        )
    return pixels


def everything(folder):
    """The model of all kinds, and its data with positions computed."""
    x, y = np.meshgrid(np.linspace(-1, 1, 17), np.linspace(-1, 1, 13))
    hills = np.exp(-3 * ((x - 0.3) ** 2 + (y + 0.2) ** 2)) + 0.3 * (x < -0.5)
    gray = np.rint(255 * hills / hills.max()).astype(np.uint8)
    assets = {
        "hills.png": png(np.repeat(gray[..., None], 3, -1), folder),
        "house.obj": HOUSE.encode(), "strip.skn": strip_skin(),
        "letter.png": png(letter(), folder), "dice.png": png(dice(), folder),
    }  # fmt: skip
    model = mujoco.MjModel.from_xml_string(EVERYTHING, assets)
    data = mujoco.MjData(model)
    data.joint("bend").qpos = 0.7
    mujoco.mj_forward(model, data)
    return model, data


def pictures(model, data, camera, width=320, height=240, segmentation=False):
    """MuJoCo's own picture: uint8 (H, W, 3), or geoms and skins (H, W, 2) by index and kind."""
    key = id(model), width, height
    if key not in _renderers:  # making one takes longer than many pictures
        try:
            _renderers[key] = mujoco.Renderer(model, height, width), model
        except Exception as error:  # PyOpenGL and each platform raise what they like
            pytest.skip(f"MuJoCo has no OpenGL here (libegl1 or libosmesa6): {error}")
    renderer, _ = _renderers[key]
    options = mujoco.MjvOption()
    options.flags[:] = 0
    for flag in ("TEXTURE", "STATIC", "SKIN"):
        options.flags[getattr(mujoco.mjtVisFlag, f"mjVIS_{flag}")] = 1
    options.sitegroup[:] = 0
    if segmentation:
        renderer.enable_segmentation_rendering()
    renderer.update_scene(data, camera, options)
    if not segmentation:
        for flag in ("SHADOW", "REFLECTION", "HAZE", "FOG"):
            renderer.scene.flags[getattr(mujoco.mjtRndFlag, f"mjRND_{flag}")] = 0
    found = renderer.render().copy()
    renderer.disable_segmentation_rendering()
    return found


_renderers = {}


def forget(model):
    """Let go of the OpenGL of a model's pictures."""
    for key in [key for key in _renderers if key[0] == id(model)]:
        _renderers.pop(key)[0].close()


def is_even(picture):
    """Pixels whose eight neighbours have about their colour."""
    steps = [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    apart = [np.abs(np.roll(picture, step, (0, 1)) - picture).max(-1) for step in steps]
    return np.max(apart, axis=0) <= 8


def pixel_eye(camera, width, height):
    """An ommatidium for every pixel, one ray through its middle, row by row."""
    half = np.tan(camera.yfov_rad / 2)
    x = half * width / height * (2 * (np.arange(width) + 0.5) / width - 1)
    y = half * (1 - 2 * (np.arange(height) + 0.5) / height)
    axis = np.stack([*np.meshgrid(x, y), np.full((height, width), -1.0)], -1).reshape(-1, 3)
    return omma.Eye(np.zeros_like(axis), axis, 0.0)


def silhouettes(model, data, camera, width=320, height=240, groups=(0, 1, 2)):
    """For each geom and skin that either sees: its name, pixels in MuJoCo's picture, in ours, in
    both. What lies beyond its far plane, where MuJoCo ends planes without end, is nobody's."""
    theirs = pictures(model, data, camera, width, height, segmentation=True)
    world = omma.mujoco.world_from_model(model, data, groups=groups)
    eye = omma.mujoco.camera(data, camera)
    renderer = omma.Renderer(world, pixel_eye(eye, width, height), omma.Fixed(1))
    names = [one.name for one in world.instances]
    truth = renderer.ground_truth(eye.world_from_camera, shares=names)
    away = truth.position_m[0] - eye.world_from_camera[:3, 3]
    depth = -(away @ eye.world_from_camera[:3, 2])
    near = depth < model.vis.map.zfar * model.stat.extent
    ours = ((truth.shares[0] > 0.5) & near[:, None]).reshape(height, width, -1)
    geoms = [model.geom(k).name or f"geom {k}" for k in range(model.ngeom)]
    found = []
    for k, name in enumerate(names):
        if name in geoms:
            there = (theirs[..., 0] == geoms.index(name)) & (
                theirs[..., 1] == mujoco.mjtObj.mjOBJ_GEOM
            )
        else:
            there = theirs[..., 1] == mujoco.mjtObj.mjOBJ_SKIN
        if there.any() or ours[..., k].any():
            both = (there & ours[..., k]).sum()
            found.append((name, int(there.sum()), int(ours[..., k].sum()), int(both)))
    return found
