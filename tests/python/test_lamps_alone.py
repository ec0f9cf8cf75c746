"""Worlds that are lit by nothing but the lamps of their files: by one word, against closed forms,
with shadows, beside surfaces that emit."""

import warnings

import numpy as np
import pytest
from conftest import make_eye
from lit_checks import matter, square
from lit_checks_lights import LUMINOUS_EFFICIENCY
from PIL import Image

import omma
from omma.job.info import describe_file
from omma.scene import Material, PunctualLight
from omma.scene.light_words import parse_light

CANDELAS, HEIGHT_M = 100.0, 2.0
AWAY_M = 3.0  # half of the room's size
# Of the fits to the colour matching functions beside CIE 1924, and of tables 10 nm apart.
PHOTOMETRY = 0.02


def at(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def room(*lamps, emissive=(0, 0, 0), **more):
    """White matt ground of 6 m with lamps 2 m above its middle, a sheet between them and the ground
    at x = 1, and far out at x = -2.5 a small surface that emits."""
    return omma.Scene(
        meshes=[
            square(2 * AWAY_M, (0, 0, 0), (0, 1, 0), 0),
            square(0.5, (0.5, 1.0, 0), (0, 1, 0), 0),
            square(0.2, (-2.5, 0.1, 0), (0, 1, 0), 1),
        ],
        materials=[
            matter(1.0).replace(reflectance=None, base_color=(1, 1, 1, 1), specular=0.0),
            Material("screen", base_color=(0, 0, 0), specular=0.0, emissive=emissive),
        ],
        lights=lamps,
        **more,
    )


LAMP = PunctualLight("bulb", intensity=CANDELAS, world_from_light=at(0, HEIGHT_M, 0))


def nits(world, *places):
    """Luminance of the ground below points, cd/m2, each seen straight down."""
    axes = np.tile([0.0, -1, 0], (len(places), 1))
    eye = omma.Eye(np.array(places, float), axes, 0.0)
    seen = omma.Renderer(world, eye, omma.Fixed(16)).render(np.eye(4))[0].astype(float)
    bands = world.light.bands
    nm = bands.centers_nm
    watts = omma.light.watts_from_photons(seen, nm)
    efficiency = np.interp(nm, 380 + 10.0 * np.arange(33), LUMINOUS_EFFICIENCY)
    return 683 * (watts * efficiency * bands.widths_nm).sum(axis=1)


def test_candelas_over_a_diffuse_plane():
    """E = I cos / d2 of a point lamp, radiance E / pi, and nothing in the shadow of the sheet."""
    light = omma.light.lamps(bands=omma.light.Bands.equal(120, 400, 700))
    world = omma.World(room(LAMP), light=light, depth=1)
    below, beside, shaded = nits(world, (0, 0.5, 0), (-1, 0.5, 0), (1.0, 0.5, 0))
    assert below == pytest.approx(CANDELAS / HEIGHT_M**2 / np.pi, rel=2e-3)
    assert beside == pytest.approx(
        CANDELAS * HEIGHT_M / np.hypot(1, HEIGHT_M) ** 3 / np.pi, rel=2e-3
    )
    assert shaded == 0


def test_one_word(tmp_path, run_omma):
    """On the command line, with RGB materials and no word about ultraviolet; the picture is exposed
    by the lamps, and what they do not reach is black."""
    assert parse_light("lamps") == {"light": omma.light.lamps()}
    omma.scene.save_scene(tmp_path / "room.glb", room(LAMP))
    omma.save_eye(tmp_path / "bug.csv", make_eye(40))
    code, _, err = run_omma(
        "render", tmp_path / "room.glb", "--eye", tmp_path / "bug.csv", "--light", "lamps",
        "--position", 0, 0.5, 0.4, "--look-at", 0, 0, 0.3, "-o", tmp_path / "v.npy",
        "-o", tmp_path / "v.png",
    )  # fmt: skip
    assert code == 0, err
    assert "warning" not in err
    seen = np.load(tmp_path / "v.npy")
    assert seen.shape == (1, 40, 12)
    picture = np.asarray(Image.open(tmp_path / "v.png").convert("RGB"))
    assert picture.max() > 200
    assert picture.min() == 0


def test_bands_below_400_nm_ask_with_a_reason_that_fits_lamps():
    light = omma.light.lamps(bands=omma.light.Bands.equal(16, 300, 700))
    with pytest.raises(omma.Error, match=r"ultraviolet: .*lamps and surfaces shine there") as error:
        omma.World(room(LAMP), light=light)
    assert "%" not in str(error.value)


def test_white_is_a_sheet_half_the_room_away():
    world = omma.World(room(LAMP), light=omma.light.lamps(), depth=1)
    expected = CANDELAS / AWAY_M**2 / np.pi
    eye = omma.Eye([[0, 0.5, 0]], [[0, -1, 0]], 0.0)
    seen = omma.Renderer(world, eye, omma.Fixed(4)).render(np.eye(4))[0]
    rgb = omma.picture.bands_to_rgb(seen, world.light, world.scene)[0]
    below = CANDELAS / HEIGHT_M**2 / np.pi
    assert rgb @ [0.2126, 0.7152, 0.0722] == pytest.approx(below / expected, rel=PHOTOMETRY)
    with pytest.raises(omma.Error, match="light: expected one that lights the ground"):
        omma.picture.bands_to_rgb(seen, world.light)


def test_emission_of_1_is_a_candela_per_square_metre_unless_it_is_said():
    light = omma.light.lamps(bands=omma.light.Bands.equal(120, 400, 700))
    world = omma.World(room(LAMP, emissive=(1, 1, 1)), light=light, depth=1)
    assert nits(world, (-2.5, 0.5, 0))[0] == pytest.approx(1.0, rel=2e-3)
    bright = world.with_light(light, emission_cd_m2=683)
    assert bright.emission_cd_m2 == 683
    assert bright.with_light(light).emission_cd_m2 == 683
    assert nits(bright, (-2.5, 0.5, 0))[0] == pytest.approx(683.0, rel=2e-3)
    words = parse_light("lamps emission_cd_m2=683")
    assert words["emission_cd_m2"] == 683
    for wrong in (-1, float("nan"), 1e16):
        with pytest.raises(omma.Error, match="emission_cd_m2: expected"):
            world.with_light(light, emission_cd_m2=wrong)


def test_it_is_told_where_emission_vanishes():
    strong = LAMP.replace(intensity=54_351.0)  # what exporters make of a lamp of a kilowatt
    scene = room(strong, emissive=(1, 1, 1))
    with pytest.warns(UserWarning, match=r'emission: .*"screen", gives 1 cd/m².*emission_cd_m2'):
        world = omma.World(scene, light=omma.light.lamps())
    with pytest.warns(UserWarning, match="it looks black"):
        omma.World(scene.replace(lights=[]), light=omma.light.clear_sky(40), ultraviolet="dark")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.with_light(omma.light.lamps(), emission_cd_m2=683)
        omma.World(room(LAMP, emissive=(1, 1, 1)), light=omma.light.lamps())
        # By emission alone, and with nothing that emits.
        omma.World(room(emissive=(1, 1, 1)), light=omma.light.lamps())
        omma.World(room(strong), light=omma.light.lamps())


def test_by_emission_alone_the_brightest_is_white():
    world = omma.World(room(emissive=(0.5, 0.5, 0.5)), light=omma.light.lamps())
    eye = omma.Eye([[-2.5, 0.5, 0]], [[0, -1, 0]], 0.0)
    seen = omma.Renderer(world, eye, omma.Fixed(4)).render(np.eye(4))[0]
    rgb = omma.picture.bands_to_rgb(seen, world.light, world.scene)[0]
    assert rgb @ [0.2126, 0.7152, 0.0722] == pytest.approx(1.0, rel=PHOTOMETRY)


def test_files_of_exporters(tmp_path):
    """Lamps that come from a file, KHR_lights_punctual."""
    omma.scene.save_scene(tmp_path / "room.glb", room(LAMP))
    again = omma.load_scene(tmp_path / "room.glb")
    world = omma.World(again, light=omma.light.lamps(), depth=1)
    (below,) = nits(world, (0, 0.5, 0))
    assert below == pytest.approx(CANDELAS / HEIGHT_M**2 / np.pi, rel=PHOTOMETRY)


def test_it_is_told_where_nothing_gives_light():
    ground = omma.scene.plane((2, 2))
    with pytest.warns(UserWarning, match="no sky, and the scene has no lamps .* all is black"):
        omma.World(ground, light=omma.light.lamps())
    lamp = omma.scene.PunctualLight("lamp", intensity=10)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.World(ground.replace(lights=[lamp]), light=omma.light.lamps())
        omma.World(ground, light=omma.light.overcast_sky(40), ultraviolet="dark")


def test_info_counts_lamps(tmp_path):
    lamps = [PunctualLight("a"), PunctualLight("b", type="spot"), PunctualLight("c")]
    omma.scene.save_scene(tmp_path / "room.glb", room(*lamps))
    assert dict(describe_file(tmp_path / "room.glb"))["lamps"] == "2 point, 1 spot"
