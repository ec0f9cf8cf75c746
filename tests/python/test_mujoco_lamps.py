"""MuJoCo's lights as lamps: how bright a matt plane is, beside closed forms and MuJoCo's pictures.

What a light of MuJoCo stands for is a rule of ours (docs/mujoco.md). Beyond it all follows: the
radiance of a matt plane is albedo / pi times the light on it, and a lux is so many photons.
"""

import numpy as np
import pytest
from mujoco_models import mujoco, pictures

import omma
import omma.mujoco

ALBEDO, LUX = 0.5, 10_000
PLANE = """<mujoco><visual><map zfar="50"/>
  <headlight ambient="0 0 0" diffuse="{head} {head} {head}" specular="0 0 0"/></visual>
  <statistic center="0 0 0" extent="4"/>
  <asset><material name="matt" rgba="{albedo} {albedo} {albedo} 1" specular="0"/></asset>
  <worldbody>{light}<geom type="plane" size="9 9 1" material="matt"/>
  <camera name="down" pos="{x} 0 3" xyaxes="1 0 0 0 1 0" fovy="2"/></worldbody></mujoco>"""


def photons_per_lux():
    """m^-2 s^-1 nm^-1, of white that is equal photons from 400 to 700 nm: V(lambda) of CIE 1924,
    every 20 nm, as textbooks print it; 683 lm/W."""
    efficiency = np.array(
        [0.0004, 0.004, 0.023, 0.06, 0.139, 0.323, 0.71, 0.954, 0.995, 0.87, 0.631, 0.381, 0.175,
         0.061, 0.017, 0.0041]
    )  # fmt: skip
    joules = 6.62607015e-34 * 299792458 / (np.arange(400, 701, 20) * 1e-9)
    return 1 / (683 * 20 * (efficiency * joules).sum())


def model_of(light, x=0.0, head=0):
    model = mujoco.MjModel.from_xml_string(PLANE.format(light=light, x=x, head=head, albedo=ALBEDO))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def lux_seen(model, data):
    """The illuminance that the plane's radiance tells, below the camera; in all four bands."""
    sky = omma.light.uniform_sky(1e-3, bands=omma.light.Bands.equal(4, 400, 700))
    world = omma.mujoco.world_from_model(
        model, data, light=sky, lighting="path", depth=1, ultraviolet="dark", colors="linear"
    )
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.0)
    pose = omma.mujoco.camera(data, "down").world_from_camera
    seen = omma.Renderer(world, eye, omma.Fixed(4096)).render(pose)[0, 0]
    return seen * np.pi / (ALBEDO * photons_per_lux())


LIGHTS = [
    # light, where it is looked at, lux that the rule and the laws of sines and squares say
    ('<light type="directional" dir="0 0 -1" diffuse="1 1 1"/>', 0.0, LUX),
    ('<light type="directional" dir="0 0 -1" diffuse="0.25 0.25 0.25"/>', 0.0, LUX / 4),
    ('<light type="directional" dir="{s} 0 -{c}" diffuse="1 1 1"/>', 0.0, LUX / 2),
    ('<light type="point" pos="0 0 2" diffuse="1 1 1"/>', 0.0, LUX),
    ('<light type="point" pos="0 0 2" diffuse="1 1 1"/>', 1.5, LUX * (2 / 2.5) ** 3),
    ('<light type="point" pos="0 0 2" diffuse="1 1 1" attenuation="1 0.5 0"/>', 0.0, LUX / 2),
    ('<light type="point" pos="0 0 2" diffuse="1 1 1" intensity="300"/>', 0.0, 300 / 2**2),
    ('<light type="spot" pos="0 0 2" dir="0 0 -1" cutoff="20" exponent="0" diffuse="1 1 1"/>', 0.5,
     LUX * (2 / np.hypot(2, 0.5)) ** 3),
    ('<light type="spot" pos="0 0 2" dir="0 0 -1" cutoff="20" exponent="0" diffuse="1 1 1"/>', 0.9,
     0),
]  # fmt: skip


@pytest.mark.parametrize(("light", "x", "lux"), LIGHTS)
def test_a_matt_plane_is_as_bright_as_the_closed_form(light, x, lux):
    s, c = np.sin(np.radians(60)), np.cos(np.radians(60))
    seen = lux_seen(*model_of(light.format(s=s, c=c), x))
    # 0.5 %: V(lambda) every 20 nm, to three figures.
    assert seen == pytest.approx(lux, rel=5e-3, abs=1e-6)


def test_headlight_and_ambient_light_are_nothing():
    ambient = '<light type="directional" dir="0 0 -1" diffuse="0 0 0" ambient="1 1 1"/>'
    assert lux_seen(*model_of(ambient, head=1)).max() < 1e-6


@pytest.mark.parametrize(
    "light",
    [
        '<light type="directional" dir="0 0 -1" diffuse="1 1 1"/>',
        '<light type="directional" dir="{s} 0 -{c}" diffuse="1 1 1"/>',
        # Its own pictures leave points out, but show spots of 180 degrees.
        '<light type="spot" cutoff="180" pos="0 0 2" dir="0 0 -1" diffuse="0.5 0.5 0.5"/>',
        '<light type="spot" cutoff="180" pos="0 0 2" dir="0 0 -1" diffuse="1 1 1" '
        'attenuation="1 0.5 0"/>',
    ],
)
def test_mujocos_picture_is_as_bright(light):
    """Where the rule says that both agree: MuJoCo's colour over the plane's is the illuminance over
    that of a light of 1 straight ahead."""
    s, c = np.sin(np.radians(60)), np.cos(np.radians(60))
    model, data = model_of(light.format(s=s, c=c))
    theirs = pictures(model, data, "down").astype(float)[110:130, 150:170].mean() / 255
    ours = lux_seen(model, data).mean() / LUX
    # A step of 255, as MuJoCo rounds on its way, and the 0.5 % of above.
    assert theirs == pytest.approx(ALBEDO * ours, abs=1 / 255 + 5e-3 * ALBEDO)
