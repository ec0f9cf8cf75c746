"""Makes docs/gallery-*.png: runs the lines of docs/gallery.md and keeps what they write; and
docs/start-view.png, by the first picture's commands of docs/start.md.

.venv/bin/python docs/make_gallery.py
"""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent
WIDTH = 1500  # but with all their colours: a palette turns scales into steps and poppies brown


def main() -> None:
    """Run the page, make its pictures small, and put them beside it."""
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    names: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
            exec(compile(block, "gallery.md", "exec"), names)
        start = (DOCS / "start.md").read_text(encoding="utf-8").split("## A first picture")[1]
        for command in re.findall(r"^    (.+)$", start, re.MULTILINE)[:3]:
            subprocess.run(command, shell=True, check=True)
        os.rename("view.png", "start-view.png")
        for path in sorted(Path(folder).glob("*-*.png")):
            picture = Image.open(path).convert("RGB")
            if picture.width > WIDTH:
                height = round(picture.height * WIDTH / picture.width)
                picture = picture.resize((WIDTH, height), Image.Resampling.LANCZOS)
            picture.save(path, optimize=True)
            shutil.copyfile(path, DOCS / path.name)
            print(f"wrote {path.name}, {path.stat().st_size // 1024} KB")


if __name__ == "__main__":
    main()
