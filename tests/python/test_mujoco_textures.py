"""How textures lie on every kind of thing of a MuJoCo model, beside MuJoCo's own pictures.

MuJoCo changed its mind on the way: from 3.12 on materials repeat what has texture coordinates of
its own. The tests hold for whichever version is installed; docs/mujoco.md says which were tried.
"""

import struct
import zlib

import numpy as np
import pytest
from mujoco_models import HOUSE, dice, forget, is_even, letter, mujoco, pictures, png, strip_skin

import omma
import omma.mujoco

SIZE = 200
FRAME = """
<mujoco>
  <visual>
    <quality numslices="96" numstacks="96" numquads="4" shadowsize="0" offsamples="0"/>
    <map znear="0.002" zfar="20"/>
    <headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/>
  </visual>
  <statistic extent="4" center="0 0 0"/>
  <asset>
    {asset}
    <material name="m" texture="t" texrepeat="{repeat}" texuniform="{uniform}"/>
    <hfield name="hills" file="hills.png" size="0.9 0.6 0.4 0.1"/>
    <mesh name="own" file="house.obj" scale="0.5 0.9 0.6"/>
    <mesh name="bare" file="bare.obj" scale="0.5 0.9 0.6"/>
    {skin}
  </asset>
  <worldbody>
    {geom}
    <body name="lower" pos="0 0 -0.4"><geom size="0.01" group="3"/>
      <body name="upper" pos="0 0 0.4"><geom size="0.01" group="3"/></body></body>
    <camera name="a" pos="1.5 -2.5 1.9" xyaxes="5 3 0 -1.14 1.9 3.4" fovy="42"/>
    <camera name="c" pos="0.4 -1.1 0.2" xyaxes="1.1 0.4 0 -0.08 0.2 1.3" fovy="42"/>
    <camera name="b" pos="-1.9 1.6 -2.2" xyaxes="-1.6 -1.9 0 -4.18 3.52 6.17" fovy="42"/>
  </worldbody>
</mujoco>
"""
THINGS = {
    "plane": '<geom type="plane" size="0.9 0.6 1" material="m"/>',
    "endless plane": '<geom type="plane" size="0 0 1" material="m"/>',
    "plane with an end": '<geom type="plane" size="0 0.6 1" material="m"/>',
    "sphere": '<geom type="sphere" size="0.7" material="m"/>',
    "capsule": '<geom type="capsule" size="0.4 0.6" material="m"/>',
    "ellipsoid": '<geom type="ellipsoid" size="0.4 0.9 0.6" material="m"/>',
    "cylinder": '<geom type="cylinder" size="0.5 0.7" material="m"/>',
    "box": '<geom type="box" size="0.5 0.8 0.4" material="m"/>',
    "height field": '<geom type="hfield" hfield="hills" material="m"/>',
    "mesh": '<geom type="mesh" mesh="own" material="m"/>',
    "bare mesh": '<geom type="mesh" mesh="bare" material="m"/>',
    "skin": "",
}

TEXTURES = {
    "letter": '<texture name="t" type="2d" file="letter.png"/>',
    "dice": '<texture name="t" type="cube" file="dice.png" gridsize="3 4" '
    'gridlayout=".U..LFRB.D.."/>',
}


def others(folder):
    """The files that the frame names."""
    x, y = np.meshgrid(np.linspace(-1, 1, 17), np.linspace(-1, 1, 13))
    hills = np.rint(255 * np.exp(-3 * ((x - 0.3) ** 2 + (y + 0.2) ** 2))).astype(np.uint8)
    lines = [line for line in HOUSE.splitlines() if not line.startswith("vt")]
    bare = ["".join(one.split("/")[0] + " " for one in line.split()) for line in lines]
    return {
        "hills.png": png(np.repeat(hills[..., None], 3, -1), folder),
        "house.obj": HOUSE.encode(), "bare.obj": "\n".join(bare).encode(),
        "strip.skn": strip_skin(), "letter.png": png(letter(), folder),
        "dice.png": png(dice(), folder),
    }  # fmt: skip


def model_of(folder, thing, texture, repeat="1 1", uniform="false"):
    skin = '<skin name="strip" file="strip.skn" material="m"/>' if thing == "skin" else ""
    xml = FRAME.format(
        asset=TEXTURES[texture], repeat=repeat, uniform=uniform, skin=skin, geom=THINGS[thing]
    )
    return loaded(xml, others(folder))


def loaded(xml, files):
    model = mujoco.MjModel.from_xml_string(xml, files)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def alike(theirs, ours):
    """Of the pixels that both show, and around which both have one colour: how many there are, and
    the share that is alike. Where colours meet MuJoCo has one or the other or a mix of them."""
    there = (theirs.max(-1) > 0) & (ours.max(-1) > 0) & is_even(theirs) & is_even(ours)
    return there.sum(), (np.abs(theirs - ours).max(-1)[there] <= 8).mean()


LAID = (
    ("letter", "3 2", "false"), ("letter", "3 2", "true"),
    ("dice", "3 2", "false"), ("dice", "3 2", "true"),
)  # fmt: skip


@pytest.mark.parametrize(("texture", "repeat", "uniform"), LAID)
@pytest.mark.parametrize("thing", THINGS)
def test_textures_lie_where_mujoco_lays_them(tmp_path, thing, texture, repeat, uniform):
    if (thing, texture, uniform) == ("skin", "letter", "true") and mujoco.__version__ == "3.12.0":
        pytest.skip("MuJoCo 3.12.0 alone lays uniform textures on skins by a length of 0.1")
    model, data = model_of(tmp_path, thing, texture, repeat, uniform)
    world = omma.mujoco.world_from_model(model, data, colors="linear")
    # Of planes from behind MuJoCo shows what lies behind them, at the skin only one camera looks.
    for camera in "c" if thing == "skin" else "a" if "plane" in thing else "ab":
        theirs, ours = both_pictures(model, data, world, camera)
        if "end" in thing and (texture, uniform) == ("dice", "true"):
            assert ours.max() > 0  # times a size of 0 MuJoCo has no direction left to lay it by
        else:
            count, same = alike(theirs, ours)
            assert count > 1000
            assert same > 0.99  # found: 1.000


def both_pictures(model, data, world, camera):
    theirs = pictures(model, data, camera, SIZE, SIZE).astype(float)
    forget(model)
    view = omma.mujoco.camera(data, camera)
    return theirs, 255 * omma.render_camera(world, view, width=SIZE, height=SIZE, samples=16)


def linear(value):
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


# The pixels of a texture (alpha plays no part where materials are opaque), whether its file or the
# model says that it is sRGB, and its kind.
KINDS = {
    "plain": ((128, 128, 128), "", "2d"),
    "marked": ((128, 128, 128), "in the file", "2d"),
    "named": ((128, 128, 128), 'colorspace="sRGB"', "2d"),
    "named linear": ((128, 128, 128), 'colorspace="linear"', "2d"),
    "alpha": ((128, 128, 128, 60), 'nchannel="4"', "2d"),
    "named, alpha": ((128, 128, 128, 60), 'nchannel="4" colorspace="sRGB"', "2d"),
    "cube": ((128, 128, 128), "", "cube"),
    "named cube": ((128, 128, 128), 'colorspace="sRGB"', "cube"),
}


@pytest.mark.parametrize("kind", KINDS)
def test_textures_are_coded_or_light_as_mujoco_shows_them(tmp_path, kind):
    color, said, shape = KINDS[kind]
    picture = np.full((32, 32, len(color)), color, np.uint8)
    blob = png(picture, tmp_path)
    if said == "in the file":
        chunk = b"sRGB\0"
        blob = blob[:33] + struct.pack(">I", 1) + chunk + struct.pack(">I", zlib.crc32(chunk)) \
            + blob[33:]  # fmt: skip
        said = ""
    asset = f'<texture name="t" type="{shape}" file="one.png" {said}/>'
    xml = FRAME.format(asset=asset, repeat="1 1", uniform="false", skin="", geom=THINGS["plane"])
    model, data = loaded(xml, {"one.png": blob, **others(tmp_path)})
    middle = (SIZE // 2,) * 2
    world = omma.mujoco.world_from_model(model, data, colors="linear")
    theirs, ours = both_pictures(model, data, world, "a")
    shown = theirs[middle] / 255
    assert ours[middle] / 255 == pytest.approx(shown, abs=0.005), shown
    world = omma.mujoco.world_from_model(model, data, colors="srgb")
    _, coded = both_pictures(model, data, world, "a")
    assert coded[middle] / 255 == pytest.approx([linear(one) for one in shown], abs=0.005)
