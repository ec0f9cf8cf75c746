"""The window's page under hands, in a browser: flying, keys, drags, and what the animal sees as
large as the page."""

import io
import time

import numpy as np
import pytest
from conftest import write_gltf
from view_browser import Browser, canvas_box, click_aside, keep, pixel_of, until

import omma
from omma.view.painting import PROJECTIONS
from omma.view.poses import HeadPose

pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
START = HeadPose((0, 1.0, 4.0))


@pytest.fixture(scope="module")
def window(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys")
    cameras = [(name, None, {"translation": [x, 1.0, 4]}) for x, name in enumerate(("one", "two"))]
    write_gltf(folder / "ground.gltf", cameras=cameras)
    eye = omma.eye.pair_of_eyes(omma.eye.generate_eye(400))
    with omma.view.show(omma.load_scene(folder / "ground.gltf"), eye, port=0) as window:
        yield window


@pytest.fixture(scope="module")
def browser():
    with Browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def first_page(browser, window):
    return browser.open(window.url, 1280, 800)


@pytest.fixture
def page(first_page, browser, window):
    window.go_to(START)
    click_aside(first_page)
    yield first_page
    assert not browser.said


def box_of(page, name):
    return page.locator(f"#{name}").bounding_box()


def test_the_head_steps_and_flies_by_keys(page, window):
    page.keyboard.press("i")
    until(lambda: window.look.pose.position_m[2] < 4.0)
    page.keyboard.press("n")
    until(lambda: window.look.pose.yaw_deg == -3.0)
    window.go_to(START)
    page.keyboard.press("f")
    until(lambda: window._page.scene.head.visible is False)
    # The camera of this browser is where the head is, and goes with it.
    client = next(iter(window._page.server.get_clients().values()))
    until(lambda: np.allclose(client.camera.position, window.look.pose.position_m, atol=1e-3))
    page.keyboard.down("w")
    until(lambda: window.look.pose.position_m[2] < 3.9)
    page.keyboard.up("w")

    def is_still():
        before = window.look.pose
        time.sleep(0.3)
        return window.look.pose == before

    until(is_still)  # a busy browser hears of the key some time later
    rests = window.look.pose
    until(lambda: np.allclose(client.camera.position, rests.position_m, atol=1e-3))
    page.keyboard.down("ArrowRight")
    until(lambda: window.look.pose.yaw_deg > 5)
    page.keyboard.up("ArrowRight")
    # The mouse looks round where the browser gives it away, and the wheel sets the speed.
    before = window.look.pose
    if page.evaluate("document.pointerLockElement !== null"):
        page.mouse.move(400, 300)
        page.mouse.move(500, 250)
        until(lambda: window.look.pose.yaw_deg != before.yaw_deg)
    head = window._page.tabs.head
    speed = head.speed_m_s
    page.mouse.wheel(0, -100)
    until(lambda: head.speed_m_s > 1.2 * speed)
    page.keyboard.press(",")
    until(lambda: abs(head.speed_m_s - speed) < 0.01 * speed)
    page.keyboard.press("f")
    until(lambda: window._page.scene.head.visible)
    # The keys are the scene's camera's again.
    time.sleep(0.3)
    rests = window.look.pose
    page.keyboard.down("w")
    time.sleep(0.5)
    page.keyboard.up("w")
    assert window.look.pose == rests


def test_keys_for_cameras_and_rays(page, window):
    window._page.hands._camera = -1
    page.keyboard.press("c")
    page.keyboard.press("c")
    until(lambda: window.look.pose.position_m[0] == 1.0)
    page.keyboard.press("Shift+C")
    until(lambda: window.look.pose.position_m[0] == 0.0)
    page.keyboard.press("+")
    until(lambda: window.look.samples == 8)
    page.keyboard.press("PageDown")
    until(lambda: window.look.samples == 4)
    until(lambda: "rays" in page.inner_text("#omma-note"))  # by web socket, a moment later
    # Not while somebody types.
    page.get_by_role("textbox").first.focus()
    page.keyboard.press("+")
    time.sleep(0.5)
    assert window.look.samples == 4


def test_a_key_saves_the_picture(page, window):
    from PIL import Image

    with page.expect_download() as download:
        page.keyboard.press("p")
    assert download.value.suggested_filename == "view.png"
    with open(download.value.path(), "rb") as file:
        pixels = np.asarray(Image.open(io.BytesIO(file.read())))
    assert pixels.shape[:2] == window._page._ids().shape


def test_keys_are_listed(page):
    page.keyboard.press("h")
    help_text = page.locator("#omma-help")
    help_text.wait_for()
    for words in ("fly faster", "next camera", "twice as many rays", "save the picture", "wheel"):
        assert words in help_text.inner_text()
    keep(page, "help.png")
    page.keyboard.press("Escape")
    help_text.wait_for(state="hidden")


def test_the_picture_is_dragged_to_turn_the_head(page, window):
    chosen = window._page.chosen
    box = box_of(page, "omma-eye")
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 50, y + 25, steps=5)
    page.mouse.up()
    until(lambda: window.look.pose.yaw_deg == pytest.approx(6.0, abs=0.01))
    assert window.look.pose.pitch_deg == pytest.approx(3.0, abs=0.01)
    assert window._page.chosen == chosen


def test_what_the_animal_sees_fills_the_page(page, window):
    before = box_of(page, "omma-eye")
    assert before["width"] * before["height"] > 0
    page.keyboard.press("v")
    image = page.locator("#omma-big-eye")
    image.wait_for()
    frame = box_of(page, "omma-frame")

    def is_sharp():
        # As many pixels as there are on the screen.
        wide, high = page.evaluate(
            "(i => [i.naturalWidth, i.naturalHeight])(document.getElementById('omma-big-eye'))"
        )
        share = max(wide / frame["width"], high / frame["height"])
        return 0.95 < share < 1.05 and (high, wide) == window._page._ids().shape

    for projection in PROJECTIONS:
        window._page.projection = projection
        window._page.repaint()
        until(is_sharp)
        keep(page, f"page-{projection.split()[0]}.png")
    box = box_of(page, "omma-big")
    assert (box["width"], box["height"]) == (1280, 800)
    # It is picked from there too.
    page.mouse.click(*pixel_of(page, "omma-big-eye", window._page._ids(), 200))
    until(lambda: window._page.chosen == 200)
    # And beside the scene: neither covers the other.
    page.keyboard.press("v")
    until(lambda: min(canvas_box(page)["height"], canvas_box(page)["width"]) < 500)
    picture, scene = box_of(page, "omma-big"), canvas_box(page)
    apart = (
        picture["x"] + picture["width"] <= scene["x"] + 1
        or picture["y"] + picture["height"] <= scene["y"] + 1
    )
    assert apart
    assert not page.locator("#omma-eye").is_visible()
    keep(page, "beside.png")
    page.keyboard.press("v")
    image.wait_for(state="hidden")
    until(lambda: canvas_box(page)["height"] > 700)
    window._page.projection = next(iter(PROJECTIONS))
    window._page.repaint()


def test_on_a_phone_it_is_what_is_there_first(browser, window):
    browser.close_pages()  # or the first goes on drawing
    page = browser.open(window.url, 390, 844, device_scale_factor=2, has_touch=True, is_mobile=True)
    image = page.locator("#omma-big-eye")
    image.wait_for()
    until(lambda: page.evaluate("document.getElementById('omma-big-eye').naturalWidth") > 600)
    box = box_of(page, "omma-big")
    assert box["width"] == 390
    assert box["height"] > 700
    # viser's panel is folded.
    until(lambda: not page.get_by_text("Exposure").is_visible())
    keep(page, "phone.png")
    window.go_to(START)
    page.locator("[data-hold='1']").dispatch_event("pointerdown", {"bubbles": True})
    until(lambda: window.look.pose.position_m[2] < 3.9)
    page.evaluate("window.dispatchEvent(new PointerEvent('pointerup'))")
    page.close()
    assert not browser.said
