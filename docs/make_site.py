"""Builds the documentation site: `scripts/docs` installs what this needs and calls it.

    .venv/bin/python docs/make_site.py [FOLDER]    into build/site, or FOLDER

Pages are read where they lie, under docs/ and beside the code, and brought together in
build/site-source: docs/PAGE.md becomes PAGE.md there, all else keeps its place, and links are
turned accordingly. Pages that are made, not written, are put beside them: the reference
(site_reference.py), one for each species, all figures with the scripts that draw them
(site_figures.py). Sphinx then reads that folder. Tutorials are run, and what
came out is kept in build/site-notebooks; with OMMA_DOCS_NOTEBOOKS=off they are shown without
outputs.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

from PIL import Image
from site_figures import figures_text
from site_reference import reference_pages

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
# What is no page of docs/, but is shown.
BESIDES = (
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONVENTIONS.md",
    "bench/RESULTS.md",
    "examples/README.md",
    "examples/from_compoundray.md",
    "examples/localisation/README.md",
)
# Pages that list others: what they link to is below them in the navigation.
SECTIONS = ("how-to.md", "explanation.md", "gallery.md", "inside.md", "tutorials.md")
TUTORIALS = "docs/tutorials/index.md"
LINK = re.compile(r"\]\(([^)\s#:]+)(#[^)\s]*)?\)")


def pages() -> list[str]:
    """All pages that are written, by their path in the repository."""
    docs = [path.relative_to(ROOT).as_posix() for path in sorted((ROOT / "docs").rglob("*.md"))]
    if TUTORIALS in docs:  # what stands in its place until there are any
        docs.remove("docs/tutorials.md")
    return [*docs, *BESIDES]


def place_of(path: str) -> str:
    """Where a file of the repository lies in the site."""
    return "tutorials.md" if path == TUTORIALS else path.removeprefix("docs/")


def turned_links(page: str, text: str, source: Path) -> str:
    """The text with its links as they are from the page's place in the site. Files that are no
    pages are copied; a folder is its README.md, or else its name alone."""
    known = set(pages())

    def turn(match: re.Match[str]) -> str:
        path = os.path.normpath(os.path.join(os.path.dirname(page), match[1]))
        path = {"README.md": "docs/index.md"}.get(path, path)
        if path == "docs/tutorials.md" and TUTORIALS in known:
            path = TUTORIALS
        found = ROOT / path
        if found.is_dir() and (found / "README.md").is_file():
            path, found = f"{path}/README.md", found / "README.md"
        if not found.is_file():
            return match[0]
        if path not in known:
            target = source / place_of(path)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(found, target)
        relative = os.path.relpath(place_of(path), os.path.dirname(place_of(page)) or ".")
        return f"]({relative}{match[2] or ''})"

    turned = LINK.sub(turn, text)

    def without_folder(match: re.Match[str]) -> str:
        found = ROOT / os.path.dirname(page) / match[2]
        is_page = (found / "README.md").is_file()
        return match[1] if found.is_dir() and not is_page else match[0]

    return re.sub(r"\[([^\]]*)\]\(([^)\s#:]+)\)", without_folder, turned)


def toctree(entries: list[str]) -> str:
    """A list of pages for the navigation only."""
    return "\n```{toctree}\n:hidden:\n\n" + "\n".join(entries) + "\n```\n"


def contents(text: str) -> str:
    """A page with those below it in the navigation that it links to first in lines of its lists
    and tables."""
    linked = re.findall(r"^[-|] .*?\[[^\]]*\]\(([^)\s#:]+\.md)\)", text, re.MULTILINE)
    return text + (toctree(list(dict.fromkeys(linked))) if linked else "")


def species_pages(text: str) -> dict[str, str]:
    """docs/species.md as a page for all and one for each animal, with its map."""
    head, *sections = re.split(r"^## ", text, flags=re.MULTILINE)
    pages, rest, cards = {}, [], []
    sources = next(one for one in sections if one.startswith("Sources\n"))
    for section in sections:
        title, body = section.split("\n", 1)
        name = title.lower().replace(" ", "_")
        if not (ROOT / "docs" / f"species-{name}.png").is_file():
            rest.append(f"## {section}")
            continue
        about, table = body.strip().split("\n\n", 1)
        keys = dict.fromkeys(re.findall(r"^\|.*\| (\w+) \| [^|]*\|$", table, re.MULTILINE))
        own = [line for line in sources.splitlines() if line[3:].split("`")[0] in keys]
        alt = f"Maps of the interommatidial angle and the facets of the {title.lower()}"
        pages[f"species/{name}.md"] = (
            f"# {title}\n\n{about}\n\n![{alt}](../species-{name}.png)\n\n"
            f"*Left, the angle between neighbouring ommatidia; right, the facets. Straight ahead "
            f"is in the middle, the animal's right on the right.*\n\n"
            f"    omma eye species {name} -o {name}.csv\n\n"
            f"In Python: `omma.species.{name}().eye`. How eyes are made, and what *measured*, "
            f"*interpolated* and *assumed* mean: [species](../species.md).\n\n{table}\n\n"
            f"## Sources of these numbers\n\n" + "\n".join(own) + "\n"
        )
        first = about.split("\n\n")[0].strip()
        cards.append(
            f":::{{grid-item-card}} {title}\n:link: species/{name}\n:link-type: doc\n"
            f":img-top: species-{name}-small.png\n:img-alt: {alt}\n\n{first}\n:::\n"
        )
    head = re.sub(r"^!\[.*\]\(species-.*\)\n", "", head, flags=re.MULTILINE)
    grid = "::::{grid} 1 2 2 3\n:gutter: 3\n\n" + "\n".join(cards) + "::::\n\n"
    tree = toctree([place.removesuffix(".md") for place in pages]) + "\n"
    pages["species.md"] = head + grid + tree + "".join(rest)
    return pages


def put_together(source: Path) -> None:
    """All pages and what they show, in the folder that Sphinx reads."""
    shutil.rmtree(source, ignore_errors=True)
    texts: dict[str, str] = {}
    for page in pages():
        text = (ROOT / page).read_text(encoding="utf-8")
        texts[place_of(page)] = turned_links(page, text, source)
    for section in SECTIONS:
        texts[section] = contents(texts[section])
    texts["validation.md"] += toctree(["light-validation"])
    texts |= species_pages(texts["species.md"])
    readme = {"": (ROOT / "README.md").read_text(encoding="utf-8")}
    texts["figures.md"] += figures_text(ROOT, texts | readme)
    reference = reference_pages(ROOT)
    texts["reference.md"] += reference.pop("reference.md")
    texts |= reference
    for place, text in texts.items():
        (source / place).parent.mkdir(parents=True, exist_ok=True)
        (source / place).write_text(text, encoding="utf-8")
    for picture in (ROOT / "docs").glob("*.*g"):
        if picture.suffix in (".png", ".svg"):
            shutil.copyfile(picture, source / picture.name)
    for picture in (ROOT / "docs").glob("species-*.png"):
        whole = Image.open(picture)
        # The left map, without its title and its scale.
        left = whole.crop((0, whole.height // 15, whole.width // 2, whole.height * 4 // 5))
        left.resize((530, round(530 * left.height / left.width))).save(
            source / f"{picture.stem}-small.png"
        )


def main() -> int:
    from sphinx.cmd.build import build_main

    site = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else BUILD / "site"
    source = site.with_name(site.name + "-source")
    os.environ.setdefault("OMMA_DOCS_CACHE", str(BUILD / "site-notebooks"))
    put_together(source)
    strict = ["-W", "--keep-going", "-q", "-j", "auto"]
    failed = build_main(
        [*strict, "-c", str(ROOT / "docs"), "-d", f"{site}-doctrees", str(source), str(site)]
    )
    if not failed:
        print(f"the site is in {site}: open {site / 'index.html'}")
    return failed


if __name__ == "__main__":
    sys.exit(main())
