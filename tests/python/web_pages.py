"""The page in the browser: served from build/web/site, which `scripts/web` makes, and asked for its
numbers."""

import base64
import gzip
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from view_browser import SLOW_MS

ROOT = Path(__file__).resolve().parents[2]
SITE = ROOT / "build" / "web" / "site"

# Waits until what is wanted is shown; numbers come as their bytes.
SEEN = """async (changes) => {
  const { app } = omma;
  if (changes.state) app.change(changes.state);
  await app.want({ settings: true, picture: true });
  const bytes = (numbers) => {
    let text = '';
    for (const one of new Uint8Array(numbers.buffer)) text += String.fromCharCode(one);
    return btoa(text);
  };
  const { matrixOf } = await import(new URL('./pose.js', location.href));
  const { responses, labels } = app.seen;
  return { responses: bytes(responses), labels, matrix: [...matrixOf(app.seen.pose)] };
}"""


def need_site():
    if not (SITE / "index.html").is_file():
        pytest.skip("build/web/site is not there: scripts/web makes it")


def built_engines():
    """The builds of the engine in the folder: threads, simd, plain, or some of them."""
    return json.loads((SITE / "data" / "data.json").read_text())["engines"]


class Served:
    """The folder as `scripts/web serve` serves it."""

    def __enter__(self):
        command = [sys.executable, ROOT / "scripts" / "web_serve", SITE]
        self._server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.url = self._server.stdout.readline().strip()
        return self

    def __exit__(self, *_):
        self._server.terminate()
        self._server.wait()
        self._server.stdout.close()


def opened(browser, url, width=1000, height=700, **options):
    """A page that shows its first frame."""
    page = browser.open(url, width, height, wait=False, **options)
    page.wait_for_selector("body[data-ready]", timeout=SLOW_MS)
    return page


def seen(page, **state):
    """What the page shows with these changes of its state: responses (N, bands), their labels, and
    world_from_head."""
    said = page.evaluate(SEEN, {"state": state})
    values = np.frombuffer(base64.b64decode(said["responses"]), np.float32)
    labels = said["labels"]
    return values.reshape(-1, len(labels)), labels, np.reshape(said["matrix"], (4, 4))


def unpacked(name, folder):
    """A file that comes with the page, as it was before it was packed."""
    path = folder / name
    if not path.exists():
        path.write_bytes(gzip.decompress((SITE / "data" / f"{name}.gz").read_bytes()))
    return path


def drop(page, *files):
    """Drops files (name, bytes) on the page and waits until they are taken or refused."""
    given = [[name, base64.b64encode(data).decode()] for name, data in files]
    page.evaluate(
        """async (given) => {
      const transfer = new DataTransfer();
      for (const [name, data] of given) {
        const bytes = Uint8Array.from(atob(data), (one) => one.charCodeAt(0));
        transfer.items.add(new File([bytes], name));
      }
      dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true }));
      await null;
      await omma.app.working;
    }""",
        given,
    )
