"""How fast the page in the browser is, and whether its memory stays: in Chromium, without a card.

    .venv/bin/python bench/web.py [--engine threads|simd|plain] [--site FOLDER]
    .venv/bin/python bench/web.py --soak 600

The head flies over the meadow's cut with an eye of 1,500 ommatidia and with species, five seconds
each: frames/s that are rendered and painted; then, at once after it and two seconds long, what the
engine makes when nothing is painted. Then a scene of a million triangles is dropped on the page:
how long it takes to be there, how fast it is. Chromium runs as where there is no graphics card: it
puts the page together on the processor, and WebGL runs there, too. With --soak
the head flies for so many seconds, every ten with other eyes, scenes and settings: memory of the
engine, of the page's JavaScript and of all Chromium's processes, every half minute. Prints CSV.
`scripts/web` makes the page first.
"""

from __future__ import annotations

import argparse
import base64
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Page, sync_playwright

import omma

ROOT = Path(__file__).resolve().parents[1]
SITE = ROOT / "build" / "web" / "site"
# With --use-angle=swiftshader Chromium would put the page itself together by WebGL, too.
ARGUMENTS = ("--no-sandbox", "--enable-unsafe-swiftshader", "--enable-precise-memory-info")

DROP = """async ([name, data]) => {
  const bytes = Uint8Array.from(atob(data), (one) => one.charCodeAt(0));
  const transfer = new DataTransfer();
  transfer.items.add(new File([bytes], name));
  const before = performance.now();
  dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true }));
  await null;
  await omma.app.working;
  return performance.now() - before;
}"""
# Flies in a circle as a held key does: a pose with each frame of the browser.
FLY = """async (seconds) => {
  const { app } = omma;
  const { moved, turned } = await import(new URL('./pose.js', location.href));
  const [begin, first] = [performance.now(), app.frames];
  while (performance.now() - begin < 1000 * seconds) {
    app.go(moved(turned(app.state.pose, 0.5, 0), 0.004, 0, 0));
    await new Promise(requestAnimationFrame);
  }
  return (1000 * (app.frames - first)) / (performance.now() - begin);
}"""
# The same by the engine alone.
ALONE = """async (seconds) => {
  const { app } = omma;
  await app.working;
  const { matrixOf, moved, turned } = await import(new URL('./pose.js', location.href));
  const begin = performance.now();
  let { pose } = app.state;
  let frames = 0;
  for (; performance.now() - begin < 1000 * seconds; frames += 1) {
    pose = moved(turned(pose, 0.5, 0), 0.004, 0, 0);
    await app.engine.ask('render', { pose: matrixOf(pose), frame: 0 });
  }
  return (1000 * frames) / (performance.now() - begin);
}"""
CHANGE = """async (changes) => {
  const { app } = omma;
  app.change(changes);
  await app.want({ settings: true, picture: true });
}"""


def drop(page: Page, name: str, data: bytes) -> float:
    """Milliseconds until a file that is dropped on the page is shown."""
    taken: float = page.evaluate(DROP, [name, base64.b64encode(data).decode()])
    trouble = page.locator("#trouble")
    if trouble.is_visible():
        raise SystemExit(trouble.inner_text())
    return taken


def chosen(page: Page, list_id: str, name: str) -> None:
    """Another scene or eye of those that come with the page, when it is shown."""
    page.select_option(list_id, name)
    page.evaluate("omma.app.working")


def eye_file(number: int) -> bytes:
    """An eye of so many ommatidia over a sphere, as .csv."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "eye.csv"
        omma.save_eye(path, omma.eye.generate_eye(number))
        return path.read_bytes()


def million_triangles() -> bytes:
    """Land of 708 x 708 squares of two triangles, wavy, as .glb."""
    side = 709
    x, z = np.meshgrid(np.linspace(-10, 10, side), np.linspace(-10, 10, side))
    positions = np.stack([x, 0.3 * np.sin(2 * x) * np.cos(3 * z) - 0.5, z], axis=-1).reshape(-1, 3)
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    triangles = np.concatenate(
        [np.stack([first, first + side, first + 1], 1),
         np.stack([first + 1, first + side, first + side + 1], 1)]
    )  # fmt: skip
    colors = np.random.default_rng(1).uniform(0.1, 0.6, (len(positions), 3))
    mesh = omma.scene.Mesh(positions, triangles, colors=colors)
    scene = omma.Scene(meshes=[mesh], instances=[omma.scene.Instance(0)])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "million.glb"
        omma.scene.save_scene(path, scene)
        return path.read_bytes()


def speeds(page: Page) -> None:
    """Frames/s of some eyes, and of a million triangles."""
    print("scene,eye,ommatidia,rays,frames_per_s,engine_alone_per_s,share")

    def row(scene: str, eye: str) -> None:
        number = page.evaluate("omma.app.eye.ommatidia")
        for rays in (4, 16):
            page.evaluate(CHANGE, {"rays": rays})
            frames, alone = page.evaluate(FLY, 5), page.evaluate(ALONE, 2)
            print(
                f"{scene},{eye},{number},{rays},{frames:.1f},{alone:.1f},{frames / alone:.2f}",
                flush=True,
            )

    drop(page, "eye-1500.csv", eye_file(1500))
    row("meadow", "eye-1500.csv")
    for eye in ("drosophila", "honeybee_worker"):
        chosen(page, "#eye-name", eye)
        row("meadow", eye)
    drop(page, "eye-1500.csv", eye_file(1500))
    data = million_triangles()
    taken = drop(page, "million.glb", data)
    row("a million triangles", "eye-1500.csv")
    memory = page.evaluate("omma.app.seen.memory") / 2**20
    print(f"# a million triangles: {len(data) / 1e6:.0f} MB, there after {taken / 1e3:.1f} s, "
          f"memory of the engine {memory:.0f} MiB")  # fmt: skip


def resident_mib(pid: int) -> float:
    """Memory of a process and of all that it has started."""
    parents = subprocess.run(
        ["ps", "-eo", "pid=,ppid=,rss="], capture_output=True, text=True, check=True
    )
    rows = [tuple(map(int, line.split())) for line in parents.stdout.splitlines()]
    family, size = {pid}, 0
    while size != len(family):
        size = len(family)
        family |= {child for child, parent, _ in rows if parent in family}
    return sum(kib for child, _, kib in rows if child in family) / 1024


def soak(page: Page, seconds: float, pid: int) -> None:
    """Flies so long, with changes, and says the memory."""
    print("minutes,engine_mib,javascript_mib,all_processes_mib,frames")
    eyes = ("honeybee_worker", "drosophila", "cataglyphis", "bumblebee")
    scenes = ("meadow", "arena")
    start, rounds, told = time.monotonic(), 0, 0.0
    while (gone := time.monotonic() - start) < seconds:
        chosen(page, "#eye-name", eyes[rounds % len(eyes)])
        if rounds % 2 == 0:
            chosen(page, "#scene-name", scenes[rounds // 2 % len(scenes)])
        changes: dict[str, Any] = {
            "rays": (4, 8, 2)[rounds % 3], "widths": (1, 1.5)[rounds % 2],
            "projection": ("facets", "mollweide", "lambert")[rounds % 3],
        }  # fmt: skip
        page.evaluate(CHANGE, changes)
        page.evaluate(FLY, 8)
        rounds += 1
        if gone >= told:
            told += 30
            numbers = page.evaluate(
                "[omma.app.seen.memory, performance.memory.usedJSHeapSize, omma.app.frames]"
            )
            print(f"{gone / 60:.1f},{numbers[0] / 2**20:.0f},{numbers[1] / 2**20:.0f},"
                  f"{resident_mib(pid):.0f},{numbers[2]}", flush=True)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--engine", choices=("threads", "simd", "plain"), default="")
    parser.add_argument("--soak", type=float, default=0.0, help="seconds")
    parser.add_argument("--site", type=Path, default=SITE, help="another page than this one")
    given = parser.parse_args()
    if not (given.site / "index.html").is_file():
        raise SystemExit(f"{given.site} is not there: scripts/web makes it")
    command = [sys.executable, str(ROOT / "scripts" / "web_serve"), str(given.site)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    url = server.stdout.readline().strip()
    try:
        with sync_playwright() as tools:
            chromium = tools.chromium.launch(
                executable_path="/usr/bin/chromium", args=list(ARGUMENTS)
            )
            page = chromium.new_page(viewport={"width": 1280, "height": 800})
            page.set_default_timeout(120_000)
            page.goto(f"{url}?engine={given.engine}")
            page.wait_for_selector("body[data-whole]")
            kind = page.get_attribute("body", "data-ready")
            load = os.getloadavg()[0]
            print(f"# engine {kind}, {os.cpu_count()} threads of hardware, load before: {load:.1f}")
            if given.soak:
                soak(page, given.soak, os.getpid())
            else:
                speeds(page)
            chromium.close()
    finally:
        server.terminate()


if __name__ == "__main__":
    main()
