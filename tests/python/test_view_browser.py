"""The window into the eye in a browser: dragged, picked, slid, with a second one beside it; what
the page says is what the renderer gives."""

import shlex
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import write_gltf
from view_browser import (
    SLOW_MS,
    Browser,
    canvas_box,
    keep,
    pixel_of,
    set_choice,
    set_number,
    tab,
    until,
)

import omma
from omma.view.poses import HeadPose

pytest.importorskip("viser", reason="viser (omma[view]) is not installed")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("view")
    write_gltf(folder / "ground.gltf", cameras=[("bee", None, {"translation": [0, 1.0, 4]})])
    eye = omma.eye.pair_of_eyes(omma.eye.generate_eye(400))
    omma.save_eye(folder / "bee.csv", eye)
    lines = ["x,y,z,yaw_deg,pitch_deg,roll_deg", *(f"0,1,{4 - k / 50},{k},0,0" for k in range(60))]
    (folder / "path.csv").write_text("\n".join(lines))
    return folder


@pytest.fixture(scope="module")
def window(files):
    scene = omma.load_scene(files / "ground.gltf")
    with omma.view.show(scene, omma.load_eye(files / "bee.csv"), port=0) as window:
        yield window


@pytest.fixture(scope="module")
def browser():
    with Browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def first_page(browser, window):
    return browser.open(window.url, 1100, 800)


@pytest.fixture
def page(first_page, browser):
    """The page that all tests go on with; each leaves the console clean."""
    yield first_page
    assert not browser.said


def settled(window):
    """The finest frame of what is wanted."""
    until(lambda: window.seen.look == window.look and window.seen.samples == 64)
    return window.seen


def screen(page, window, point):
    """Where a point of the scene (3,) is in the browser, pixels."""
    client = next(iter(window._page.server.get_clients().values()))
    camera = client.camera
    w, x, y, z = camera.wxyz
    turn = omma.poses_from_quaternions((0, 0, 0), (x, y, z, w))[0, :3, :3]
    right, down, ahead = (np.asarray(point) - camera.position) @ turn
    box = canvas_box(page)
    focal = box["height"] / 2 / np.tan(camera.fov / 2)
    return (
        box["x"] + box["width"] / 2 + focal * right / ahead,
        box["y"] + box["height"] / 2 + focal * down / ahead,
    )


def shown_numbers(page):
    return np.array([float(text) for text in page.locator(".omma-response").all_inner_texts()])


def test_the_page_shows_what_omma_render_writes(
    page, window, files, run_omma, monkeypatch, tmp_path
):
    window.go_to(HeadPose((0.25, 0.9, 3.5), 20.0, -15.0))
    tab(page, "Ommatidium")
    set_number(page, "Number", 123)
    page.wait_for_selector("#omma-chosen[data-number='123']")
    seen = settled(window)
    until(lambda: "8 × 64 rays" in page.inner_text("#omma-status"))
    until(lambda: page.locator(".omma-error").count() == 3)
    tab(page, "Save")
    until(lambda: "--samples 64 --standard-error" in page.inner_text("#omma-command"))
    command = page.inner_text("#omma-command")
    monkeypatch.chdir(tmp_path)
    assert run_omma(*shlex.split(command)[1:])[0] == 0
    written = np.load("view.npy")[0]
    assert np.array_equal(written, seen.responses)
    tab(page, "Ommatidium")
    # Seven digits are what the page says of each.
    assert np.allclose(shown_numbers(page), written[123], rtol=1e-6, atol=0)
    assert written[123].max() > 0
    keep(page, "numbers.png")


def test_the_head_is_dragged(page, window):
    start = HeadPose((0, 1.0, 4.0))
    window.go_to(start)
    until(lambda: window._page.server.get_clients())
    before = page.locator("#omma-eye").screenshot()
    page_scene = window._page.scene
    # The arrow to the right is as long as the control is large.
    along = np.array([1.0, 0, 0])
    reach = page_scene.head.scale
    dragged = False
    for share in (0.85, 0.95, 0.75, 1.05, 0.6):
        x, y = screen(page, window, np.array(start.position_m) + share * reach * along)
        to_x, to_y = screen(page, window, np.array(start.position_m) + (share + 1) * reach * along)
        page.mouse.move(x, y)
        page.mouse.move(x + 1, y)
        page.mouse.down()
        for step in range(1, 9):
            page.mouse.move(x + (to_x - x) * step / 8, y + (to_y - y) * step / 8)
            time.sleep(0.05)
        page.mouse.up()
        time.sleep(1)
        if window.look.pose != start:
            dragged = True
            break
    assert dragged
    x, y, z = window.look.pose.position_m
    # Along the arrow and nowhere else; how far it goes is the control's own matter.
    assert x > 0.3 * reach
    assert abs(y - 1) < 1e-3
    assert abs(z - 4) < 1e-3
    settled(window)
    tab(page, "Head")
    until(lambda: str(round(x, 2))[:4] in " ".join(
        one.input_value() for one in page.locator("input").all()
    ))  # fmt: skip
    assert page.locator("#omma-eye").screenshot() != before
    keep(page, "dragged.png")


def test_ommatidia_are_picked_by_clicks(page, window):
    window.go_to(HeadPose((0, 1.0, 4.0)))
    settled(window)
    page.mouse.click(*pixel_of(page, "omma-eye", window._page._ids(), 400))
    until(lambda: window._page.chosen == 400)
    tab(page, "Ommatidium")
    page.wait_for_selector("#omma-chosen[data-number='400']")
    assert "Δρ" in page.inner_text("#omma-chosen")
    # In a picture that is not as wide as its frame: the one before is half as high.
    set_choice(page, "Projection", "Lambert")
    until(lambda: page.evaluate("document.getElementById('omma-eye').naturalHeight") > 300)
    page.mouse.click(*pixel_of(page, "omma-eye", window._page._ids(), 100))
    until(lambda: window._page.chosen == 100)
    set_choice(page, "Projection", "facets on the eye")
    # On the ground: who looks there.
    place = np.array([1.5, 0.0, 0.0])  # beside the head and its control
    page.mouse.click(*screen(page, window, place))
    until(lambda: window._page.chosen != 100)
    eye, pose = window._page.looker.eye, window.look.pose.world_from_head
    towards = (place - pose[:3, 3]) @ pose[:3, :3]
    towards /= np.linalg.norm(towards)
    found = eye.axis[window._page.chosen].astype(float) @ towards
    # Within half the angle between two axes, and a pixel.
    assert np.arccos(min(found, 1)) < 1.2 * eye.interommatidial_angle_rad().max()
    until(lambda: page.locator(".omma-error").count() == 3)
    keep(page, "picked.png")


def test_sliders_change_what_is_rendered(page, window):
    tab(page, "Eye")
    set_number(page, "Rays", 16)
    until(lambda: window.look.samples == 16)
    set_number(page, "Δρ", 2)
    until(lambda: window.look.acceptance_factor == 2.0)
    settled(window)
    before = page.locator("#omma-eye").screenshot()
    set_number(page, "Exposure", 2)
    until(lambda: window._page.stops == 2.0)
    until(lambda: page.locator("#omma-eye").screenshot() != before)
    tab(page, "Save")
    until(lambda: "--factor 2.0" in page.inner_text("#omma-command"))
    tab(page, "Eye")
    set_number(page, "Δρ", 1)
    set_number(page, "Exposure", 0)
    set_number(page, "Rays", 4)
    until(lambda: window.look.acceptance_factor == 1.0 and window.look.samples == 4)
    page.get_by_text("Fields of view").locator("xpath=ancestor::*[.//input][1]//input").check()
    until(lambda: window._page.scene.fields[0].visible)
    keep(page, "fields.png")


def test_paths_play_and_are_recorded(page, window, files):
    pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg (omma[video]) is not installed")
    tab(page, "Play")
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a path (CSV)").click()
    chooser.value.set_files(files / "path.csv")
    until(lambda: len(window._page.tabs._poses) == 60)
    label = page.get_by_text("Play", exact=True)
    play = label.locator("xpath=ancestor::*[.//input][1]//input").last
    page.get_by_role("button", name="Record", exact=True).click()
    play.check()
    try:
        until(lambda: len({one.pose for one in window._page.tabs._clock._recorded}) > 5)
        # The video is as long as the clicks are apart: at once, without waiting for a page at rest.
        with page.expect_download(timeout=4 * SLOW_MS) as download:
            page.get_by_role("button", name="Stop, and save the video").dispatch_event("click")
            play.uncheck()
        video = Path(download.value.path())
    finally:
        # A path that goes on would take all other tests' heads with it.
        window._page.tabs._clock.play(False)
    assert video.stat().st_size > 1000
    assert video.read_bytes()[4:8] == b"ftyp"


def test_what_is_wrong_is_said_on_the_page_and_the_work_goes_on(page, window, tmp_path):
    (tmp_path / "broken.csv").write_text("x,y\n1,2\n")
    tab(page, "Play")
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a path (CSV)").click()
    chooser.value.set_files(tmp_path / "broken.csv")
    page.wait_for_selector("text=broken.csv, line 1: expected a header line")
    keep(page, "wrong.png")
    window.go_to(HeadPose((0.1, 1.0, 3.0)))
    until(lambda: window.seen.look.pose == HeadPose((0.1, 1.0, 3.0)))


def test_two_browsers_see_the_same_and_one_may_go(page, browser, window):
    first, second = page, browser.open(window.url, 1024, 768)
    tab(second, "Ommatidium")
    set_number(second, "Number", 77)
    tab(first, "Ommatidium")
    first.wait_for_selector("#omma-chosen[data-number='77']")
    keep(second, "tablet.png")
    second.close()
    window.go_to(HeadPose((0.2, 1.0, 3.0)))
    settled(window)
    until(lambda: first.locator(".omma-error").count() == 3)
    assert np.allclose(shown_numbers(first), window.seen.responses[77], rtol=1e-6, atol=0)
    until(lambda: len(window._page.server.get_clients()) == 1)
