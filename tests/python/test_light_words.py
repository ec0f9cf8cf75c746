"""Light that is said in words: `omma render --light`, `render_file(light=...)`, and again from the
files that they wrote."""

import json
from datetime import datetime, timezone

import numpy as np
import pytest
from conftest import make_eye, write_gltf
from PIL import Image

import omma
from omma import render_file
from omma.job import render_like
from omma.scene.light_words import parse_light

WORDS = "clear_sky sun_elevation_deg=30 sun_azimuth_deg=135 bands=4 ultraviolet=dark lighting=path"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """scene.gltf with a ground and a camera, and bug.csv with 40 ommatidia."""
    folder = tmp_path_factory.mktemp("words")
    write_gltf(folder / "scene.gltf", cameras=[("plain", {}, {"translation": [0, 1, 0]})])
    omma.save_eye(folder / "bug.csv", make_eye(40))
    return folder


def test_they_are_the_arguments_of_a_world():
    given = parse_light(WORDS)
    assert given.pop("light") == omma.light.clear_sky(
        30, sun_azimuth_deg=135, bands=omma.light.Bands.equal(4)
    )
    assert given == {"ultraviolet": "dark", "lighting": "path"}
    assert parse_light("overcast_sky sun_elevation_deg=-2.5 ultraviolet=0.02 depth=3") == {
        "light": omma.light.overcast_sky(-2.5),
        "ultraviolet": 0.02,
        "depth": 3,
    }
    fog = "overcast_sky sun_elevation_deg=35 visibility_m=150 layer_height_m=80 ultraviolet=dark"
    assert parse_light(fog)["light"] == omma.light.with_air(
        omma.light.overcast_sky(35), 150, layer_height_m=80
    )
    at = parse_light(
        "clear_sky_at date_time=2026-06-21T12:00:00Z latitude_deg=52.5 longitude_deg=13.4"
    )["light"]
    noon = datetime(2026, 6, 21, 12, tzinfo=timezone.utc)
    assert at == omma.light.clear_sky_at(noon, 52.5, 13.4)
    assert parse_light("uniform_sky radiance=2 unit=watts")["light"].unit == "watts"
    clouds = parse_light("cloudy_sky sun_elevation_deg=30 cloud_fraction=0.3 kind=cirrus bands=4")
    few = omma.light.Bands.equal(4)
    assert clouds == {"light": omma.light.cloudy_sky(30, 0.3, "cirrus", bands=few)}
    for said in ("True", "true", "False"):
        given = parse_light(f"uniform_sky polarized={said}")
        assert given == {"light": omma.light.uniform_sky(), "polarized": said != "False"}
    visible = parse_light("uniform_sky bands=visible")
    assert visible == {"light": omma.light.uniform_sky(bands=omma.light.Bands.equal(12, 400, 700))}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected one of clear_sky, .*found ''"),
        ("sun", "expected one of clear_sky, .*found 'sun'"),
        ("measured_sky", "measured_sky is for Python alone, .*; expected one of clear_sky, "),
        ("clear_sky 30", "expected name=value, .*sun_elevation_deg.*found '30'"),
        ("clearsky sun_elevation_deg=30", "found 'clearsky'; did you mean 'clear_sky'"),
        ("clear_sky sun=30 up=1", "light: clear_sky: expected one of sun_elev.*, found 'up'$"),
        (
            "clear_sky sun_elevation=30",
            "expected one of .*, found 'sun_elevation'; did you mean 'sun_elevation_deg'",
        ),
        ("clear_sky sun_elevation_deg=1 sun_elevation_deg=2", "sun_elevation_deg: is said twice"),
        ("clear_sky", "light: .*sun_elevation_deg"),
        ("clear_sky sun_elevation_deg=high", "light: sun_elevation_deg"),
        ("clear_sky sun_elevation_deg=300", "light: sun_elevation_deg"),
        ("clear_sky sun_elevation_deg=30 bands=0", "light: .*expected"),
        ("clear_sky sun_elevation_deg=30 bands=all", "light: count: expected a whole number"),
        ("clear_sky sun_elevation_deg=30 depth=1e30", "light: depth: expected a whole number"),
        ("clear_sky sun_elevation_deg=30 ultraviolet=inf", "light: ultraviolet: expected"),
        ("clear_sky sun_elevation_deg=30 sun=high", "light: sun: expected"),
        ("clear_sky sun_elevation_deg=30 polarized=1", "light: polarized: expected True or False"),
        ("clear_sky_at date_time=noon latitude_deg=0 longitude_deg=0", "date_time: expected one"),
    ],
)
def test_what_is_none_is_refused(text, message):
    with pytest.raises(omma.Error, match=message):
        parse_light(text)


def test_a_file_is_what_the_world_gives(files, tmp_path):
    pytest.importorskip("xarray")
    report = render_file(
        files / "scene.gltf",
        [tmp_path / "view.npy", tmp_path / "view.png"],
        eyes=files / "bug.csv",
        light=WORDS,
        position=(0, 1, 0),
    )
    assert report.ommatidia == 40
    world = omma.World(omma.load_scene(files / "scene.gltf"), **parse_light(WORDS))
    renderer = omma.Renderer(world, omma.load_eye(files / "bug.csv"))
    pose = omma.poses_from_angles((0, 1, 0), (0, 0, 0))
    expected = renderer.render(pose)
    found = np.load(tmp_path / "view.npy")
    assert found.shape == (1, 40, 4)
    assert np.array_equal(found, expected)
    # The picture has the colours that people see, a white sheet on level ground as white.
    shown = omma.picture.bands_to_rgb(expected[0], world.light)
    picture = np.asarray(Image.open(tmp_path / "view.png"))
    assert np.array_equal(picture[..., :3], omma.picture.framed(renderer.eye, shown))

    data = omma.rendering.load_responses(tmp_path / "view.npy")
    assert data.attrs["light_words"] == WORDS
    assert data.response.attrs["units"] == "photons m-2 s-1 sr-1 nm-1"
    render_like(tmp_path / "view.npy", tmp_path / "again.npy")
    assert np.array_equal(np.load(tmp_path / "again.npy"), found)


def test_the_loader_says_what_light_would_show_where_there_is_none(tmp_path, files):
    plane = write_gltf(tmp_path / "plane.gltf", materials=[{"name": "lit"}])
    document = json.loads(plane.read_text())
    document["meshes"][0]["primitives"][0]["material"] = 0
    plane.write_text(json.dumps(document))
    common = (plane, tmp_path / "x.npy", omma.Fixed(1))
    dark = render_file(*common, eyes=files / "bug.csv")
    assert [one.startswith("without a light") for one in dark.warnings] == [True]
    assert render_file(*common, eyes=files / "bug.csv", light=WORDS).warnings == ()


def test_a_camera_has_colours(files, tmp_path):
    outputs = [tmp_path / "camera.npy", tmp_path / "camera.png"]
    render_file(files / "scene.gltf", outputs, camera="plain", light=WORDS, width=40, height=30)
    bands = np.load(outputs[0])
    assert bands.shape == (30, 40, 4)
    rgb = omma.picture.bands_to_rgb(bands, parse_light(WORDS)["light"])
    assert np.array_equal(np.asarray(Image.open(outputs[1])), omma.picture.display(rgb))
    omma.job.render_all_cameras(
        files / "scene.gltf", tmp_path / "all", light=WORDS, width=40, height=30
    )
    every = np.asarray(Image.open(tmp_path / "all" / "plain.png"))
    assert every.shape == (30, 40, 3)
    assert (every[0, :, 2] > every[0, :, 0]).all()  # the sky is blue


def test_receptors_see_polarisation_where_it_is_said(files, tmp_path, run_omma):
    """Of crossed receptors under a clear sky, on the command line as in Python, and again."""
    pytest.importorskip("xarray")
    along, across = (
        omma.receptors.ReceptorType(
            name,
            peak_wavelength_nm=345,
            microvillus_angle_rad=np.radians(angle),
            polarisation_sensitivity=6.3,
        )
        for name, angle in (("along", 0), ("across", 90))
    )
    kind = omma.receptors.OmmatidiumType("rim", (along, across))
    omma.save_eye(tmp_path / "rim.csv", omma.receptors.assign_receptors(make_eye(40), kind))
    written, again = tmp_path / "rim.npy", tmp_path / "again.npy"
    code, _, err = run_omma(
        "render", files / "scene.gltf", "--eye", tmp_path / "rim.csv", "--receptors",
        "--light", f"{WORDS} polarized=True", "--position", 0, 1, 0, "-o", written,
    )  # fmt: skip
    assert code == 0, err
    world = omma.World(omma.load_scene(files / "scene.gltf"), **parse_light(WORDS), polarized=True)
    renderer = omma.Renderer(world, omma.load_eye(tmp_path / "rim.csv"))
    expected = renderer.render_receptors(omma.poses_from_angles((0, 1, 0), (0, 0, 0)))
    found = np.load(written)
    assert np.array_equal(found, expected)
    # Far more than the error of 16 rays, which the two of an ommatidium share.
    crossed = found.reshape(40, 2)
    assert np.max(np.abs(crossed[:, 0] / crossed[:, 1] - 1)) > 0.5
    assert omma.rendering.load_responses(written).attrs["polarized"] == 1
    render_like(written, again)
    assert np.array_equal(np.load(again), found)


def test_the_command(files, tmp_path, run_omma):
    output = tmp_path / "view.npy"
    command = ["render", files / "scene.gltf", "--eye", files / "bug.csv", "-o", output]
    code, _, err = run_omma(*command, "--light", WORDS)
    assert code == 0, err
    assert np.load(output).shape == (1, 40, 4)
    code, _, err = run_omma(*command, "--light", "sunny")
    assert code != 0
    assert "light: expected one of clear_sky" in err


def test_what_a_sky_needs_is_told_beside_what_was_said():
    with pytest.raises(omma.Error, match=r"sun_elevation_deg=\.\.\., found sun=3$"):
        parse_light("clear_sky sun=3")
    with pytest.raises(omma.Error, match=r"clear_sky: expected sun_elevation_deg=.*found none"):
        parse_light("clear_sky")
