"""FlyGym's retina by rays: its call and shape, its hexagons' directions, gratings, bad input.

FlyGym itself needs Python 3.12; where it is installed its own readouts are the judge, else a
simulation of its shape stands in for it.
"""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mujoco_models import mujoco

import omma
import omma.mujoco

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))
import fly_retina

TWO_CAMERAS = """<mujoco><worldbody>
  <geom name="left wall" type="plane" size="9 9 1" pos="0 5 0" euler="90 0 0" rgba="0 0.25 0.5 1"/>
  <geom name="right wall" type="plane" size="9 9 1" pos="0 -5 0" euler="-90 0 0" rgba="1 1 0 1"/>
  <body name="head"><freejoint/><geom type="sphere" size="1" group="2"/>
    <camera name="left" euler="90 0 0" fovy="157"/>
    <camera name="right" euler="-90 0 0" fovy="157"/></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def ids():
    return fly_retina.hexagonal_map()


@pytest.fixture
def simulation(ids):
    model = mujoco.MjModel.from_xml_string(TWO_CAMERAS)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    eyes = {name: SimpleNamespace(name=name) for name in ("left", "right")}
    flies = {"fly": SimpleNamespace(eyecameraname_to_mjcfcamera=eyes),
             "blind": SimpleNamespace(eyecameraname_to_mjcfcamera={})}  # fmt: skip
    pale = np.random.default_rng(1).random(721) < 0.3
    retina = SimpleNamespace(
        ommatidia_id_map=ids, pale_type_mask=pale.astype(int), distortion_coefficient=3.8, zoom=2.72
    )
    world = SimpleNamespace(fly_lookup=flies)
    return SimpleNamespace(mj_model=model, mj_data=data, world=world, retina=retina)


def test_the_call_and_the_shape_are_flygyms(simulation):
    retina = omma.mujoco.FlyRetina(simulation, threads=1)
    seen = retina.get_ommatidia_readouts("fly")
    assert seen.shape == (2, 721, 2)
    assert seen.dtype == np.float32
    pale = simulation.retina.pale_type_mask.astype(bool)
    assert (seen[:, pale, 0] == 0).all()
    assert (seen[:, ~pale, 1] == 0).all()
    middle = np.argsort(-retina.eye.axis @ (0, 0, 1.0))[-100:]
    yellow, blue = middle[~pale[middle]], middle[pale[middle]]
    # The middle of each eye sees its wall: green to the yellow ones, blue to the pale ones.
    assert seen[0, yellow, 0] == pytest.approx(0.25, abs=1e-5)
    assert seen[0, blue, 1] == pytest.approx(0.5, abs=1e-5)
    assert seen[1, yellow, 0] == pytest.approx(1.0, abs=1e-5)
    assert seen[1, blue, 1] == pytest.approx(0.0, abs=1e-5)
    # Nobody sees the head that it looks from; a fly that turns round sees the other wall.
    simulation.mj_data.qpos[3:7] = 0, 0, 0, 1
    mujoco.mj_forward(simulation.mj_model, simulation.mj_data)
    turned = retina.get_ommatidia_readouts("fly")
    np.testing.assert_allclose(turned[0, middle], seen[1, middle], atol=1e-5)


def test_one_line_puts_it_in_flygyms_place(simulation):
    """As FlyGym's controllers ask: the simulation, by its method, whatever it is."""

    class Simulation:
        def __init__(self):
            vars(self).update(vars(simulation))

        def get_ommatidia_readouts(self, fly_name):
            return "pictures"

    theirs = Simulation()
    retina = omma.mujoco.FlyRetina(theirs, threads=1).install()
    seen = theirs.get_ommatidia_readouts("fly")
    np.testing.assert_array_equal(seen, retina.get_ommatidia_readouts("fly"))
    # Nothing is kept: what has moved is seen.
    theirs.mj_data.qpos[3:7] = 0, 0, 0, 1
    mujoco.mj_forward(theirs.mj_model, theirs.mj_data)
    assert not np.array_equal(theirs.get_ommatidia_readouts("fly"), seen)
    # Another one takes its place; whoever has no place leaves it alone.
    other = omma.mujoco.FlyRetina(theirs, samples=1, threads=1).install()
    retina.remove()
    assert theirs.get_ommatidia_readouts.__self__ is other
    other.remove()
    other.remove()
    assert theirs.get_ommatidia_readouts("fly") == "pictures"


def test_ommatidia_look_where_their_hexagons_do(ids):
    """Against the lens turned round: each pixel of the camera's picture has a direction, and its
    mean over the bent picture's pixels that show it is where the ommatidium looks."""
    eye = omma.mujoco.fly_eye(ids)
    row, column = np.mgrid[:512, :450]
    half = np.tan(np.radians(157) / 2)
    x = half * 450 / 512 * (2 * (column + 0.5) / 450 - 1)
    y = half * (1 - 2 * (row + 0.5) / 512)
    away = np.sqrt(x**2 + y**2 + 1)
    parts = [fly_retina.pooled(part, ids) for part in (x / away, y / away, -1 / away)]
    mean = np.stack(parts, -1)
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    off_deg = np.degrees(np.arccos(np.clip((mean * eye.axis).sum(axis=1), -1, 1)))
    # Nearest pixels lie half a pixel off on average: in the middle, where pixels are coarsest,
    # 0.6 degrees.
    assert off_deg.max() < 0.8
    width = np.degrees(eye.acceptance_angle_rad)
    assert 3 < width.min() < width.max() < 7
    assert (eye.axis[ids[255, 30] - 1, 0] < -0.8) & (eye.axis[ids[30, 225] - 1, 1] > 0.8)


def test_gratings_come_through_as_through_a_gaussian(ids):
    eye = omma.mujoco.fly_eye(ids, acceptance_angle_deg=5.0)
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)
    field = (np.abs(elevation) < 6) & (np.abs(azimuth) < 60)
    for per_degree in (0.02, 0.08, 0.12):
        transfer = fly_retina.contrast(lambda p, nu=per_degree: fly_retina.seen(nu, p, eye))
        gaussian = np.exp(-((np.pi * per_degree * 5.0) ** 2) / (4 * np.log(2)))
        # 256 rays, and meridians that come closer above and below the horizon.
        assert transfer[field] == pytest.approx(gaussian, abs=0.015)
        hexagons = fly_retina.contrast(
            lambda p, nu=per_degree: fly_retina.pooled(fly_retina.grating_picture(nu, p), ids)
        )
        assert hexagons[field].mean() > transfer[field].mean()  # they blur less, and alias


def pictures_seen(looks, picture):
    """(N,): green of the yellow ommatidia and blue of the pale ones, of a grey picture 0 to 1."""
    return looks(np.repeat(np.rint(255 * picture)[..., None], 3, 2)).sum(axis=1)


def test_pictures_come_through_as_through_a_gaussian(ids):
    """By the closed form of gratings, the camera's picture and that behind the lens."""
    pale = np.random.default_rng(1).random(721) < 0.3
    retina = omma.mujoco.PictureRetina(ids, pale, acceptance_angle_deg=5.0)
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(retina.eye.axis)
    field = (np.abs(elevation) < 6) & (np.abs(azimuth) < 60)
    straight, bent = retina.fisheye_image_to_hex_pxls, retina.raw_image_to_hex_pxls
    for looks, lens, off in (
        # Pixels of the camera are 1.1 degrees wide in the middle, which takes 1.3 % of the contrast
        # of 0.08 cycles per degree; behind the lens nearest pixels lie up to half of that off.
        (straight, lambda picture: picture, 0.015),
        (bent, fly_retina.bent, 0.03),
    ):
        for per_degree in (0.02, 0.05, 0.08):
            transfer = fly_retina.contrast(
                lambda phase, nu=per_degree, looks=looks, lens=lens: pictures_seen(
                    looks, lens(fly_retina.grating_picture(nu, phase))
                )
            )
            gaussian = np.exp(-((np.pi * per_degree * 5.0) ** 2) / (4 * np.log(2)))
            assert transfer[field] == pytest.approx(gaussian, abs=off)


def test_pictures_fill_one_channel_each(ids):
    pale = (np.arange(721) % 3 == 0).astype(int)
    retina = omma.mujoco.PictureRetina(ids, pale)
    picture = np.empty((512, 450, 3), np.uint8)
    picture[:] = 10, 51, 204
    for looks in (retina.raw_image_to_hex_pxls, retina.fisheye_image_to_hex_pxls):
        # Weights sum to 1, at the rim too, where a Gaussian reaches beyond the picture.
        expected = np.where(pale[:, None] != [0, 1], 0, [51 / 255, 204 / 255])
        assert looks(picture) == pytest.approx(expected, abs=1e-12)
    # A spot where a hexagon is, behind the lens, is brightest to its ommatidium.
    for number in (1, 361, 700):
        spot = np.where((ids == number)[..., None], 255, np.zeros(3))
        seen = retina.raw_image_to_hex_pxls(spot).sum(axis=1)
        assert seen.argmax() == number - 1


def test_pictures_beside_flygyms_own(ids):
    own = pytest.importorskip(
        "flygym.vision.retina", reason="needs FlyGym 2 (Python 3.12)"
    ).Retina()
    simulation = fly_retina.flygym_simulation()
    retina = omma.mujoco.PictureRetina()
    for picture in simulation.get_raw_vision("fly"):
        theirs, ours = (one.raw_image_to_hex_pxls(picture) for one in (own, retina))
        assert ours.shape == theirs.shape
        assert ours.dtype == theirs.dtype
        # Gaussians and hexagons are about as wide: found 0.998.
        assert np.corrcoef(ours.max(axis=1), theirs.max(axis=1))[0, 1] > 0.99


def test_bad_input_is_named(ids, simulation):
    retina = omma.mujoco.FlyRetina(simulation, threads=1)
    pictures = omma.mujoco.PictureRetina(ids, retina.pale)
    left_out = np.where(ids == 7, 0, ids)
    blind = SimpleNamespace(**{**vars(simulation), "world": SimpleNamespace(fly_lookup={})})
    for call, said in (
        (lambda: omma.mujoco.FlyRetina(3), "simulation: expected one of FlyGym 2"),
        (lambda: omma.mujoco.FlyRetina(blind), "call fly.add_vision()"),
        (lambda: retina.get_ommatidia_readouts("bee"), r"a fly with vision (fly), found 'bee'"),
        (lambda: retina.get_ommatidia_readouts("blind"), "found 'blind'"),
        (lambda: omma.mujoco.PictureRetina(ids, [1, 0]), "pale_type_mask: expected shape (721,)"),
        (lambda: pictures.raw_image_to_hex_pxls(ids), "raw_img: expected shape (512, 450, 3)"),
        (lambda: pictures.raw_image_to_hex_pxls(np.full((512, 450, 3), 256)), "from 0 to 255"),
        (lambda: omma.mujoco.fly_eye(left_out), "expected each of 1 to N at least once"),
        (lambda: omma.mujoco.fly_eye(ids[0]), "expected shape (N, N)"),
        (lambda: omma.mujoco.fly_eye(ids, zoom=0), "zoom: expected a number above 0"),
        (lambda: omma.mujoco.fly_eye(ids, distortion=9), "distortion: expected one at which"),
    ):
        with pytest.raises(omma.Error) as error:
            call()
        assert said in str(error.value), str(error.value)


def test_beside_flygyms_own(ids):
    pytest.importorskip("flygym", reason="needs pip install flygym (Python 3.12)")
    simulation = fly_retina.flygym_simulation()
    theirs = simulation.get_ommatidia_readouts("fly")
    ours = omma.mujoco.FlyRetina(simulation).get_ommatidia_readouts("fly")
    assert ours.shape == theirs.shape
    assert ours.dtype == theirs.dtype
    assert ((ours == 0) == (theirs == 0)).mean() > 0.99
    for mine, its in zip(ours.max(axis=-1), theirs.max(axis=-1)):
        # MuJoCo shades what it shows.
        assert np.corrcoef(mine, its)[0, 1] > 0.95


def test_the_set_up_on_the_page_runs():
    pytest.importorskip("flygym", reason="needs FlyGym 2, on Python 3.12 or newer")
    page = (Path(__file__).resolve().parents[2] / "docs" / "mujoco.md").read_text()
    code = page.partition("A fly that stands, and what it sees:")[2].split("```")[1]
    there = {}
    exec(code.removeprefix("text"), there)
    ours = there["readouts"]
    theirs = there["simulation"].get_ommatidia_readouts("fly")
    assert ours.shape == theirs.shape == (2, 721, 2)
    # MuJoCo's shades are a gain and an offset: found 0.9955.
    assert np.corrcoef(ours[ours > 0], theirs[ours > 0])[0, 1] > 0.98
