"""The worked examples of physical light: their parts against closed forms, and small runs."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import load_script

import omma

pytest.importorskip("matplotlib", reason="the examples draw figures")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples/python"


def load(name):
    return load_script(EXAMPLES / f"{name}.py")


@pytest.mark.parametrize("turn", [0, 77, 200])
def test_the_compass_reads_a_sky_of_single_scattering(turn):
    compass = load("sky_compass")
    eye = compass.dorsal_rim()
    sun = omma.eye.direction(turn, 40.0)
    toward = eye.axis @ sun
    # Opponent signals as the template has them, by another way: Q and U in the eye's own frame.
    vector = np.cross(eye.axis, sun)
    vector /= np.linalg.norm(vector, axis=1, keepdims=True)
    psi = np.arctan2((vector * eye.right).sum(1), (vector * eye.up).sum(1))
    degree = (1 - toward**2) / (1 + toward**2)
    modulation, angle = omma.receptors.polarisation_weights(eye)
    bright = np.repeat(np.exp(toward), 2)  # brighter towards the sun
    seen = bright * (
        1 + modulation * np.repeat(degree, 2) * np.cos(2 * (np.repeat(psi, 2) - angle))
    )
    assert compass.decode(eye, seen[None], 40.0)[0] == turn


def test_what_the_compass_reads_of_a_clear_sky():
    compass = load("sky_compass")
    found = compass.errors(elevations=(45,), headings=4, skies=1, rays=8)
    assert found["clear"].shape == (2, 1, 4)
    # Azimuths are whole degrees, and the sky is not one of single scattering: found to be 1 degree.
    assert np.abs(found["clear"][1]).max() <= 3
    # With the template of a sun on the horizon the line is off by 15 degrees in the median.
    assert np.abs(compass.of_the_line(found["clear"][0])).max() > 5


def test_receptor_noise_limits_contrast():
    flower = load("flower_in_ultraviolet")
    noise = np.array([0.1, 0.2, 0.3])
    grey = np.array([3.0, 1.0, 2.0])
    assert flower.contrast(5 * grey, grey, noise) == pytest.approx(0, abs=1e-12)
    # With the other two at rest, d of the first over its own noise and theirs, in parallel.
    one = np.exp([0.1, 0, 0])
    rest = (noise[1] * noise[2]) ** 2 / (noise[1] ** 2 + noise[2] ** 2)
    expected = 0.1 / np.sqrt(noise[0] ** 2 + rest)
    assert flower.contrast(one * grey, grey, noise) == pytest.approx(expected, rel=1e-9)
    _, of_bee = flower.bee()
    # 1.35, 0.66 and 6 receptors an ommatidium: 0.44 type I, 0.46 type II, 0.10 type III.
    np.testing.assert_allclose(of_bee, 0.13 / np.sqrt([1.36, 0.64, 6]), rtol=0.02)


def test_water_is_polarised_level_and_meadow_is_not():
    water = load("waters_edge")
    eye = water.ventral_eye(200)
    np.testing.assert_allclose(water.from_down_deg(eye).max(), water.WIDEST_DEG, atol=0.5)
    level = water.polarisation(np.array([[1, -0.5, 0.0], [1, 0.5, 0.0], [2, -1, -0.1]]))
    np.testing.assert_allclose(level[0], [0.5, 0.5, np.hypot(0.5, 0.05)])
    np.testing.assert_allclose(level[1][0], 0, atol=1e-12)
    assert abs(level[1][1]) == pytest.approx(90)
    found, is_water = water.look(eye, rays=16)
    near = np.abs(water.from_down_deg(eye) - water.BREWSTER_DEG) < 8
    degree, _ = water.polarisation(found["overcast"])
    # At Brewster's angle what is reflected is wholly polarised; the rest comes from the water.
    assert np.median(degree[near & is_water]) > 0.6
    assert np.median(degree[near & ~is_water]) < 0.1
    assert water.taken_for_water(found["clear"])[near & is_water].mean() > 0.5


def test_a_camera_in_bands_becomes_colours():
    for unit in ("photons", "watts"):
        light = omma.light.uniform_sky(1.0, unit=unit, below=0)
        white = sum(light.irradiance()) / np.pi
        rgb = omma.picture.bands_to_rgb(np.stack([white, 0.5 * white]), light)
        assert rgb.shape == (2, 3)
        np.testing.assert_allclose(rgb @ [0.2126, 0.7152, 0.0722], [1, 0.5], rtol=1e-4)
        # Equal energy is a warm white on screens of D65: 1.205, 0.948, 0.909 of linear sRGB. The
        # fits of the colour matching functions and bands of 25 nm are good to 1 %.
        if unit == "watts":
            np.testing.assert_allclose(rgb[0], [1.205, 0.948, 0.909], rtol=0.01)
    with pytest.raises(omma.Error, match="radiance: expected shape"):
        omma.picture.bands_to_rgb(np.ones((2, 3)), light)
    dark = omma.light.uniform_sky(0.0)
    with pytest.raises(omma.Error, match="light: expected one that lights the ground"):
        omma.picture.bands_to_rgb(np.ones(16), dark)


@pytest.mark.parametrize(
    ("script", "arguments", "says"),
    [
        ("sky_compass", ["--headings", "2", "--rays", "2"], "median error"),
        ("flower_in_ultraviolet", ["--rays", "16", "--samples", "1"], "just noticeable"),
        ("waters_edge", ["--rays", "2"], "Brewster"),
    ],
)
def test_scripts_run(tmp_path, script, arguments, says):
    figure = tmp_path / "figure.png"
    command = [sys.executable, str(EXAMPLES / f"{script}.py"), "-o", str(figure), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert says in done.stdout
    assert figure.is_file()
