"""Pages of the window in headless Chromium (Debian's package), driven by Playwright; without either
these tests are skipped. With OMMA_VIEW_PICTURES=FOLDER what pages look like is kept there."""

import os
import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

# A machine with much else to do draws WebGL without a graphics card slowly.
SLOW_MS = 120_000
# What viser and Chromium say of themselves; nothing else may be in the console.
EXPECTED = ("THREE.Clock", "GPU stall", "GL Driver Message", "Automatic fallback to software WebGL")


class Browser:
    """Chromium, and what the consoles of its pages say that is wrong, as it comes."""

    def __init__(self):
        playwright = pytest.importorskip(
            "playwright.sync_api", reason="playwright is not installed"
        )
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        if chromium is None:
            pytest.skip("chromium is not installed")
        self.said = []
        self._tools = playwright.sync_playwright()
        self._chromium = self._tools.start().chromium.launch(
            executable_path=chromium,
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._chromium.close()
        self._tools.__exit__()

    def open(self, url, width=1100, height=800, wait=True, **options):
        """The page in a browser of its own, when it shows something."""
        page = self._chromium.new_page(viewport={"width": width, "height": height}, **options)
        page.set_default_timeout(SLOW_MS)
        page.on(
            "console",
            lambda each: self._take(each.text) if each.type in ("error", "warning") else None,
        )
        page.on("pageerror", lambda error: self._take(str(error)))
        page.goto(url)
        if wait:
            page.wait_for_selector("#omma-status", state="attached")
            # viser's note about drawing without a graphics card is in the way of the scene.
            note = page.locator("#webgl-software-rendering button")
            note.wait_for()
            note.click()
        return page

    def close_pages(self):
        """All of them; what they said is forgotten, as is what the end of a page makes them say."""
        for context in self._chromium.contexts:
            context.close()
        self.said.clear()

    def _take(self, text):
        if not any(known in text for known in EXPECTED):
            self.said.append(text)


def until(condition, seconds=120.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.05)


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
    """Where the scene is in the browser, pixels."""
    return page.locator("canvas[data-engine]").last.bounding_box()


def pixel_of(page, image, ids, number):
    """Where an image of the page shows an ommatidium: what is not as wide as its frame stands in
    the middle of it."""
    box = page.locator(f"#{image}").bounding_box()
    (rows, columns), (high, wide) = np.nonzero(ids == number), ids.shape
    scale = min(box["width"] / wide, box["height"] / high)
    return (
        box["x"] + box["width"] / 2 + (np.median(columns) - wide / 2 + 0.5) * scale,
        box["y"] + box["height"] / 2 + (np.median(rows) - high / 2 + 0.5) * scale,
    )


def click_aside(page):
    """Clicks on the scene where there is nothing, so that keys go there."""
    box = canvas_box(page)
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.04 * box["height"])
