"""The window into the eye under long use: two browsers drag, pick and slide for minutes.

    python scripts/view_soak.py [MINUTES]

Needs chromium and playwright, as tests/python/view_browser.py. Of the page of a made scene
with two eyes of 2,000 ommatidia each, a second browser beside the first, it prints each minute: the
memory of this process and of the page's JavaScript, MB; the longest time from what a browser did to
the frame that shows it, s; and what consoles and the page itself said that is wrong. Exit code 1
where anything was said.
"""

from __future__ import annotations

import os
import random
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, sync_playwright

import omma

# What viser and Chromium say of themselves.
_EXPECTED = (
    "THREE.Clock",
    "GPU stall",
    "GL Driver Message",
    "Automatic fallback to software WebGL",
)
_WAIT_S = 30.0


def made_scene() -> omma.Scene:
    """A ground and some boxes on it."""
    rng = np.random.default_rng(1)
    parts = [omma.scene.plane((20, 20), paint=(0.2, 0.5, 0.1))]
    for _ in range(60):
        x, z = rng.uniform(-8, 8, 2)
        matrix = np.eye(4)
        matrix[:3, 3] = (x, 0.3, z)
        box = omma.scene.box((0.3, 0.6, 0.3), paint=rng.uniform(0, 1, 3))
        parts.append(omma.scene.place_scene(box, matrix))
    return omma.scene.merge_scenes(parts)


def memory_mb() -> float:
    """Of this process, resident."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def heap_mb(page: Page) -> float:
    """Of a page's JavaScript, after its garbage is collected."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    used = session.send("Runtime.getHeapUsage")["usedSize"]
    session.detach()
    return float(used) / 1e6


def stall_of(window: omma.view.Window, act: Callable[[], None]) -> float:
    """Seconds from an action that changes the settings to the frame that shows it; 0 where it
    changes nothing."""
    before = window.look
    act()
    start = time.monotonic()
    while window.look == before:
        if time.monotonic() - start > 2:
            return 0.0
        time.sleep(0.002)
    changed = time.monotonic()
    while window.seen is None or window.seen.look == before:
        if time.monotonic() - changed > _WAIT_S:
            return _WAIT_S
        time.sleep(0.002)
    return time.monotonic() - changed


def actions(page: Page, chance: random.Random) -> list[tuple[Callable[[], None], bool]]:
    """What a browser can do, and whether that changes what is rendered."""
    box = page.locator("#omma-eye").bounding_box()
    assert box is not None
    boxes = [one.bounding_box() for one in page.locator("canvas").all()]
    canvas = max((one for one in boxes if one), key=lambda one: one["width"] * one["height"])

    def pick() -> None:
        page.mouse.click(
            box["x"] + chance.uniform(0.1, 0.9) * box["width"],
            box["y"] + chance.uniform(0.1, 0.9) * box["height"],
        )

    def turn_camera() -> None:
        x, y = canvas["x"] + 0.2 * canvas["width"], canvas["y"] + 0.25 * canvas["height"]
        page.mouse.move(x, y)
        page.mouse.down()
        for step in range(5):
            page.mouse.move(x + 6 * step, y + 3 * step)
        page.mouse.up()

    def press(key: str) -> Callable[[], None]:
        def act() -> None:
            page.evaluate("document.activeElement.blur()")
            page.keyboard.press(key)

        return act

    def slide() -> None:
        page.get_by_role("tab", name="Eye", exact=True).click()
        page.get_by_role("slider").nth(chance.randrange(2)).focus()
        page.keyboard.press(chance.choice(["ArrowLeft", "ArrowRight"]))

    keys = [(press(key), True) for key in "ikjlnmuo"]
    return [*keys, (slide, True), (pick, False), (turn_camera, False)]


def main(minutes: float) -> int:
    """Run, and say what came of it."""
    eye = omma.eye.pair_of_eyes(omma.eye.generate_eye(2000))
    said: list[str] = []
    chance = random.Random(1)
    browser_path = shutil.which("chromium")
    pose = omma.look_at((0, 1, 4), (0, 0.5, 0))
    with omma.view.show(made_scene(), eye, pose=pose, port=0) as window, sync_playwright() as tools:
        browser = tools.chromium.launch(
            executable_path=browser_path,
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        )
        pages = []
        for size in ((860, 720), (800, 700)):
            page = browser.new_page(viewport={"width": size[0], "height": size[1]})
            page.set_default_timeout(120_000)
            page.on("pageerror", lambda error: said.append(str(error)))
            page.on(
                "console",
                lambda each: (
                    said.append(each.text)
                    if each.type in ("error", "warning")
                    and not any(known in each.text for known in _EXPECTED)
                    else None
                ),
            )
            page.goto(window.url)
            page.wait_for_selector("#omma-status")
            note = page.locator("#webgl-software-rendering button")
            note.wait_for()
            note.click()
            pages.append(page)
        print("minute,memory_mb,heap_mb,actions,longest_s,median_s,said", flush=True)
        start = time.monotonic()
        for minute in range(1, int(np.ceil(minutes)) + 1):
            stalls, count = [], 0
            while time.monotonic() - start < 60 * min(minute, minutes):
                # The second now and then.
                page = pages[int(chance.random() < 0.25)]
                act, changes = chance.choice(actions(page, chance))
                count += 1
                if changes:
                    stalls.append(stall_of(window, act))
                else:
                    act()
            real = [one for one in stalls if one > 0]
            print(
                f"{minute},{memory_mb():.0f},{sum(map(heap_mb, pages)):.0f},{count},"
                f"{max(real, default=0):.2f},{np.median(real or [0]):.3f},{len(said)}",
                flush=True,
            )
        browser.close()
    for one in said:
        print(one)
    return 1 if said else 0


if __name__ == "__main__":
    raise SystemExit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0))
