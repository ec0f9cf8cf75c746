"""Writes docs/browser-desktop.png and docs/browser-phone.png: the page in the browser, in Chromium.

scripts/web                                      # makes the page
.venv/bin/python docs/make_browser_figures.py    # a minute; needs Playwright and Chromium
"""

import io
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[1]
SITE = ROOT / "build" / "web" / "site"
# Name, size, state, and what is waited for.
PAGES = (
    ("browser-desktop.png", (1440, 900), "#picked=7900&rays=16", "#numbers:has-text('8 ×')"),
    ("browser-phone.png", (390, 844), "#rays=16", "body[data-ready]"),
)


def main() -> None:
    command = [sys.executable, str(ROOT / "scripts" / "web_serve"), str(SITE)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    url = server.stdout.readline().strip()
    try:
        with sync_playwright() as tools:
            chromium = tools.chromium.launch(
                executable_path="/usr/bin/chromium",
                args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
            )
            for name, (width, height), state, awaited in PAGES:
                page = chromium.new_page(viewport={"width": width, "height": height})
                page.set_default_timeout(200_000)
                page.goto(url + state)
                page.wait_for_selector(awaited)
                page.wait_for_timeout(3000)  # the scene's own view is drawn
                picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
                picture = picture.quantize(200, dither=Image.Dither.NONE)
                picture.save(ROOT / "docs" / name, optimize=True)
                page.close()
            chromium.close()
    finally:
        server.terminate()


if __name__ == "__main__":
    main()
