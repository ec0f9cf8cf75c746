"""The site's page of all figures, each with the script that draws it. For docs/make_site.py."""

from __future__ import annotations

import re
from pathlib import Path

PICTURE = re.compile(r"!\[([^\]]*)\]\(((?:\.\./)*(?:docs/)?[\w./-]+\.(?:png|svg))\)")


# Pictures whose script does not name them.
OTHERWISE = {
    "acute-zone": "examples/python/acute_zone.py",
    "evolved-eyes": "examples/python/evolve_eye.py",
    "flower-in-ultraviolet": "examples/python/flower_in_ultraviolet.py",
    "materials": "docs/make_material_figures.py",
    "mujoco": "examples/python/mujoco_walk.py",
    "scenes": "docs/make_scenes_figure.py",
    "sky-compass": "examples/python/sky_compass.py",
    "species": "docs/make_species_figures.py",
    "waters-edge": "examples/python/waters_edge.py",
}


def drawn_by(root: Path) -> dict[str, Path]:
    """The script that makes a picture, by the picture's name: one that names it, or its family."""
    scripts = [*(root / "docs").glob("make_*.py"), *(root / "examples" / "python").glob("*.py")]
    texts = {script: script.read_text(encoding="utf-8") for script in sorted(scripts)}
    found = {}
    for picture in [*(root / "docs").glob("*.png"), *(root / "docs").glob("*.svg")]:
        stem, family = picture.stem, picture.stem.split("-")[0]
        for other in (stem, family):
            if other in OTHERWISE:
                found.setdefault(picture.name, root / OTHERWISE[other])
        for sign in (rf"(?<![\w-]){re.escape(picture.name)}", rf'"{stem}"', rf"\b{family}-(\*|{{)"):
            named = [script for script, text in texts.items() if re.search(sign, text)]
            if named:
                found.setdefault(picture.name, named[0])
    return found


def figures_page(root: Path, texts: dict[str, str]) -> str:
    """The page of all figures, by the script that draws them."""
    scripts = drawn_by(root)
    shown: dict[str, tuple[str, str]] = {}
    for place, text in texts.items():
        for alt, path in PICTURE.findall(text):
            name = Path(path).name
            if (root / "docs" / name).is_file() and alt:
                shown.setdefault(name, (alt, place))
    by_script: dict[Path, list[str]] = {}
    for name in sorted(scripts):
        by_script.setdefault(scripts[name], []).append(name)
    lines = [
        "# All figures",
        "",
        "Each below the script that draws it, which runs from a clone; most take half a minute to",
        "some minutes. Short pieces of code, to begin with, are in the [gallery](gallery.md).",
        "",
    ]
    for script, names in sorted(by_script.items()):
        own = script.relative_to(root).as_posix()
        text = script.read_text(encoding="utf-8")
        lines += [f"## {script.stem}", "", f"    python {own}", ""]
        for name in names:
            said = re.match(r'"""[^:]*:\s*([^.]*)\.', text)
            alt, place = shown.get(name, (" ".join(said[1].split()) if said else script.stem, ""))
            where = f" [The page that it is on]({place})." if place else ""
            lines += [f"![{alt}]({name})", "", f"*{alt}.*{where}", ""]
        lines += ["::::{dropdown} The script", "``````python", text.rstrip(), "``````", "::::", ""]
    return "\n".join(lines)
