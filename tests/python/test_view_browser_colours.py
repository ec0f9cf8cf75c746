"""The scene in the window's page is in the colours of the camera's picture, unlit and lit."""

import io

import numpy as np
import pytest
from view_browser import Browser, canvas_box, until

import omma
from omma.picture.band_colours import colours_of as colours_of_bands
from omma.view.poses import HeadPose

pytest.importorskip("viser", reason="viser (omma[view]) is not installed")

# Saturated and dull, dark and bright: films' curves bend each of them another way.
PAINTS = ((0.2, 0.5, 0.1), (0.02, 0.1, 0.02), (0.8, 0.1, 0.05), (0.9, 0.9, 0.9), (0.1, 0.2, 0.8))


@pytest.fixture(scope="module")
def browser():
    with Browser() as browser:
        yield browser


def stripes():
    """Stripes of level ground, 2 m wide, side by side along x."""
    parts = []
    for k, paint in enumerate(PAINTS):
        matrix = np.eye(4)
        matrix[0, 3] = 2 * k - len(PAINTS) + 1
        parts.append(omma.scene.place_scene(omma.scene.plane((2, 10), paint=paint), matrix))
    return omma.scene.merge_scenes(parts)


def colours_of(browser, window):
    """8-bit colours of the stripes in the browser's scene and in the camera's picture."""
    from PIL import Image

    page = browser.open(window.url, 1200, 700)
    until(lambda: window._page.server.get_clients())
    camera = next(iter(window._page.server.get_clients().values())).camera
    # From above; what is drawn of the head is far below the ground.
    camera.position, camera.look_at = (0.0, 7.0, 0.01), (0.0, 0.0, 0.0)
    until(lambda: np.allclose(camera.position, (0, 7, 0.01), atol=1e-3))
    page.wait_for_timeout(2000)
    box = canvas_box(page)
    shot = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"), float)
    focal = box["height"] / 2 / np.tan(camera.fov / 2)
    # Beside the head's control, which is drawn over everything.
    row = int(box["y"] + box["height"] / 2 + focal * -2.5 / 7)
    drawn = []
    for k in range(len(PAINTS)):
        x = 2 * k - len(PAINTS) + 1
        column = int(box["x"] + box["width"] / 2 + focal * x / 7)
        drawn.append(shot[row - 2 : row + 3, column - 2 : column + 3].mean(axis=(0, 1)))
    pose = omma.look_at((0, 7, 0.01), (0, 0, 0))
    there = omma.scene.Camera(type="perspective", world_from_camera=pose, yfov_rad=1.2)
    picture = omma.render_camera(
        window._page.looker.world, there, width=480, height=270, samples=64
    )
    world = window._page.looker.world
    pixels = omma.picture.display(colours_of_bands(world, picture)).astype(float)
    scale = 135 / np.tan(0.6)
    expected = []
    for k in range(len(PAINTS)):
        column = int(240 + scale * (2 * k - len(PAINTS) + 1) / 7)
        expected.append(pixels[130:141, column - 4 : column + 5].mean(axis=(0, 1)))
    page.close()
    return np.array(drawn), np.array(expected)


def test_unlit_scenes_have_the_picture_s_colours(browser):
    eye = omma.eye.generate_eye(50)
    pose = HeadPose((0, -50.0, 0)).world_from_head
    with omma.view.show(stripes(), eye, pose=pose, port=0) as window:
        drawn, expected = colours_of(browser, window)
    # Half a step of 8 bits in each, and one of the shader's own.
    assert np.abs(drawn - expected).max() <= 2, (drawn, expected)
    assert not browser.said


def test_lit_scenes_have_them_in_the_open(browser):
    eye = omma.eye.generate_eye(50)
    pose = HeadPose((0, -50.0, 0)).world_from_head
    light = omma.light.clear_sky(40, sun_azimuth_deg=135)
    scene = stripes()
    world = omma.World(scene, light=light, lighting="path", ultraviolet="dark")
    with omma.view.show(world, eye, pose=pose, port=0) as window:
        drawn, expected = colours_of(browser, window)
    # Lamps give no mirror image of the sky: a dielectric's 4 % of it, which is up to 15 of 255 in
    # the blue of what is white.
    assert np.abs(drawn - expected).max() <= 16, (drawn, expected)
    assert not browser.said
