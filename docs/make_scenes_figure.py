"""The figure of docs/scenes.md: the arena of its first example, all around from its middle.

python docs/make_scenes_figure.py [OUT.png]
"""

import re
import sys
from pathlib import Path

import omma

DOCS = Path(__file__).resolve().parent


def arena():
    """The scene of the page's first snippet, up to where eyes come in."""
    snippet = re.search(r"```python\n(.*?)\neye = ", (DOCS / "scenes.md").read_text(), re.S)
    names: dict = {}
    exec(snippet[1], names)
    return names["arena"]


def main():
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS / "scenes.png"
    panorama = omma.scene.Camera("panorama", type="panoramic")
    picture = omma.render_camera(arena(), panorama, width=1000, samples=16)
    omma.save_png(out, omma.picture.display(picture))


if __name__ == "__main__":
    main()
