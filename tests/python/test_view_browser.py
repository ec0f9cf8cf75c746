"""The window into the eye in a browser: dragged, picked, slid, with a second one beside it; what
the page says is what the renderer gives.

Headless Chromium (Debian's package), driven by Playwright; without either these tests are skipped.
With OMMA_VIEW_PICTURES=FOLDER what the page looks like is kept there.
"""

import os
import re
import shlex
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import write_gltf

import omma
from omma.view.poses import HeadPose

pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")

# A machine with much else to do draws WebGL without a graphics card slowly.
SLOW_MS = 120_000
# What viser and Chromium say of themselves; nothing else may be in the console.
EXPECTED = ("THREE.Clock", "GPU stall", "GL Driver Message", "Automatic fallback to software WebGL")


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
def chromium():
    with playwright.sync_playwright() as found:
        browser = found.chromium.launch(
            executable_path=CHROMIUM,
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def window(files):
    scene = omma.load_scene(files / "ground.gltf")
    with omma.view.show(scene, omma.load_eye(files / "bee.csv"), port=0) as window:
        yield window


@pytest.fixture(scope="module")
def said():
    """What the consoles of all browsers say that is wrong, as it comes."""
    return []


@pytest.fixture(scope="module")
def open_page(chromium, window, said):
    """Opens the page in a browser of its own."""

    def take(text):
        if not any(known in text for known in EXPECTED):
            said.append(text)

    def open_page(width, height):
        page = chromium.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(SLOW_MS)
        page.on(
            "console",
            lambda each: take(each.text) if each.type in ("error", "warning") else None,
        )
        page.on("pageerror", lambda error: take(str(error)))
        page.goto(window.url)
        page.wait_for_selector("#omma-status")
        # viser's note about drawing without a graphics card is in the way of the scene.
        note = page.locator("#webgl-software-rendering button")
        note.wait_for()
        note.click()
        return page

    return open_page


@pytest.fixture(scope="module")
def first_page(open_page):
    return open_page(1100, 800)


@pytest.fixture
def page(first_page, said):
    """The page that all tests go on with; each leaves the console clean."""
    yield first_page
    assert not said


def until(condition, seconds=120.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.05)


def settled(window):
    """The finest frame of what is wanted."""
    until(lambda: window.seen.look == window.look and window.seen.samples == 64)
    return window.seen


def keep(page, name):
    if folder := os.environ.get("OMMA_VIEW_PICTURES"):
        page.screenshot(path=Path(folder) / name)


def tab(page, name):
    page.get_by_role("tab", name=name, exact=True).click()


def set_number(page, label, value):
    """Types into the number beside a slider, or a number's own field."""
    # viser gives widgets ids of their own and no names: by the label in the same row.
    row = page.locator("label", has_text=re.compile(f"^{re.escape(label)}$")).first
    field = row.locator("xpath=ancestor::*[.//input[not(@type='checkbox')]][1]//input").last
    field.fill(str(value))
    field.press("Enter")


def set_choice(page, label, value):
    """Chooses from a list."""
    row = page.locator("label", has_text=re.compile(f"^{re.escape(label)}$")).first
    row.locator("xpath=ancestor::*[.//input][1]//input").first.click()
    page.get_by_role("option", name=value, exact=True).click()


def canvas_box(page):
    """Where the scene is in the browser, pixels: the largest canvas."""
    boxes = [one.bounding_box() for one in page.locator("canvas").all()]
    return max((one for one in boxes if one), key=lambda one: one["width"] * one["height"])


def click_aside(page):
    """Clicks on the scene where there is nothing, so that keys go there."""
    box = canvas_box(page)
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.04 * box["height"])


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
    box = page.locator("#omma-eye").bounding_box()
    ids = window._page._ids()
    rows, columns = np.nonzero(ids == 400)
    height, width = ids.shape
    page.mouse.click(
        box["x"] + (np.median(columns) + 0.5) / width * box["width"],
        box["y"] + (np.median(rows) + 0.5) / height * box["height"],
    )
    until(lambda: window._page.chosen == 400)
    tab(page, "Ommatidium")
    page.wait_for_selector("#omma-chosen[data-number='400']")
    assert "Δρ" in page.inner_text("#omma-chosen")
    # In a picture that is not as wide as its frame.
    set_choice(page, "Projection", "Lambert")
    until(lambda: page.evaluate("document.getElementById('omma-eye').naturalWidth") == 400)
    ids = window._page._ids()
    rows, columns = np.nonzero(ids == 100)
    size = box["height"] / 400
    page.mouse.click(
        box["x"] + box["width"] / 2 + (np.median(columns) - 200 + 0.5) * size,
        box["y"] + (np.median(rows) + 0.5) * size,
    )
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


def test_the_head_flies_by_keys(page, window):
    window.go_to(HeadPose((0, 1.0, 4.0)))
    click_aside(page)
    page.keyboard.press("i")
    until(lambda: window.look.pose.position_m[2] < 4.0)
    page.keyboard.press("n")
    until(lambda: window.look.pose.yaw_deg == -3.0)
    tab(page, "Head")
    fly = page.get_by_text("Fly: the head goes").locator("xpath=ancestor::*[.//input][1]//input")
    fly.check()
    until(lambda: window._page.scene.head.visible is False)
    time.sleep(1)
    start = window.look.pose
    click_aside(page)
    page.keyboard.down("w")
    until(lambda: window.look.pose != start)
    page.keyboard.up("w")
    fly.uncheck()
    until(lambda: window._page.scene.head.visible)


def test_paths_play_and_are_recorded(page, window, files):
    pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg (omma[video]) is not installed")
    tab(page, "Play")
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a path (CSV)").click()
    chooser.value.set_files(files / "path.csv")
    until(lambda: len(window._page.tabs._poses) == 60)
    page.get_by_role("button", name="Record", exact=True).click()
    page.get_by_label("Play", exact=True).or_(
        page.get_by_text("Play", exact=True).locator("xpath=ancestor::*[.//input][1]//input")
    ).last.check()
    until(lambda: len({one.pose for one in window._page.tabs._clock._recorded}) > 5)
    with page.expect_download() as download:
        page.get_by_role("button", name="Stop, and save the video").click()
    video = Path(download.value.path())
    assert video.stat().st_size > 1000
    assert video.read_bytes()[4:8] == b"ftyp"
    page.get_by_text("Play", exact=True).locator(
        "xpath=ancestor::*[.//input][1]//input"
    ).last.uncheck()


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


def test_two_browsers_see_the_same_and_one_may_go(page, open_page, window):
    first, second = page, open_page(1024, 768)
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
