"""Makes docs/view-*.png: the page of `omma view` in Chromium, on a desktop, all over it, and on
a phone.

    .venv/bin/python docs/make_view_figures.py

Needs chromium and playwright, as tests/python/view_browser.py.
"""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

import omma

_DOCS = Path(__file__).resolve().parent
_WAIT_MS = 120_000


def open_page(browser: Browser, url: str, width: int, height: int, phone: bool) -> Page:
    """The page when it has settled, without viser's note that there is no graphics card."""
    page = browser.new_page(
        viewport={"width": width, "height": height},
        has_touch=phone,
        is_mobile=phone,
        device_scale_factor=2 if phone else 1,
    )
    page.set_default_timeout(_WAIT_MS)
    page.goto(url)
    page.wait_for_selector("#omma-status", state="attached")
    note = page.locator("#webgl-software-rendering button")
    note.wait_for()
    note.click()
    return page


def keep(page: Page, window: omma.view.Window, name: str) -> None:
    """The page as it looks with its finest picture; few colours make a small file."""
    while window.seen is None or window.seen.samples < 64:
        time.sleep(0.1)
    page.wait_for_timeout(4000)
    path = _DOCS / f"view-{name}.png"
    page.screenshot(path=path)
    Image.open(path).convert("RGB").quantize(255).save(path, optimize=True)


def main() -> None:
    scene = omma.load_scene(omma.examples.meadow())
    eye = omma.species.honeybee_worker().eye
    with omma.view.show(scene, eye, port=0) as window, sync_playwright() as tools:
        browser = tools.chromium.launch(
            executable_path=shutil.which("chromium"),
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        )
        page = open_page(browser, window.url, 1280, 800, False)
        keep(page, window, "desktop")
        page.keyboard.press("v")
        keep(page, window, "page")
        page.close()
        page = open_page(browser, window.url, 390, 700, True)
        keep(page, window, "phone")
        browser.close()


if __name__ == "__main__":
    main()
