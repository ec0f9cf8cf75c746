"""Builds the documentation site: `scripts/docs` installs what this needs and calls it.

    .venv/bin/python docs/make_site.py [FOLDER]    into build/site, or FOLDER

Pages are read where they lie, under docs/ and beside the code, and brought together in
build/site-source: docs/PAGE.md becomes PAGE.md there, all else keeps its place, and links are
turned accordingly. Pages that are made, not written, are put beside them: sections of the first
page (site_index.py), the reference (site_reference.py), one for each species (site_species.py),
all figures with the scripts that draw them (site_figures.py). Sphinx then reads that folder. Old
addresses lead to where their pages have gone (site_moved.py). The page in the browser, where
scripts/web has made it, opens the first page. Tutorials are run, and what came out
is kept in build/site-notebooks; with OMMA_DOCS_NOTEBOOKS=off they are shown without outputs.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

from site_figures import figures_page
from site_index import section_pages, toctree
from site_moved import write_moved
from site_reference import reference_pages
from site_species import small_maps, species_pages

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
# What is no page of docs/, but is shown.
BESIDES = (
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "CONVENTIONS.md",
    "bench/RESULTS.md",
    *sorted(f"bench/notes/{path.name}" for path in (ROOT / "bench" / "notes").glob("*.md")),
    "examples/README.md",
    "examples/from_compoundray.md",
    "examples/localisation/README.md",
)
TUTORIALS = "docs/tutorials/index.md"
# The page in the browser, where scripts/web has made it.
LIVE = BUILD / "web" / "site"
LINK = re.compile(r"\]\(([^)\s#:]+)(#[^)\s]*)?\)")


def pages() -> list[str]:
    """All pages that are written, by their path in the repository."""
    docs = [path.relative_to(ROOT).as_posix() for path in sorted((ROOT / "docs").rglob("*.md"))]
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


def contents(text: str) -> str:
    """A page with those below it in the navigation that it links to first in lines of its lists
    and tables."""
    linked = re.findall(r"^[-|] .*?\[[^\]]*\]\(([^)\s#:]+\.md)\)", text, re.MULTILINE)
    return text + (toctree(list(dict.fromkeys(linked))) if linked else "")


def with_live_picture(text: str) -> str:
    """The first page with the page in the browser in place of its picture and the words below."""
    frame = (
        "```{raw} html\n"
        '<iframe class="live" src="live/index.html?embed" loading="lazy" '
        'title="What a honeybee sees, live: drag the picture"></iframe>\n```\n\n'
        "*Live, in your browser: what the 10,760 ommatidia of a honeybee see of a meadow. Drag "
        "the picture to turn the head, drag the yellow head to move it, or fly with W A S D and "
        "the arrows. [In a browser](browser.md) says more.*\n"
    )
    picture = re.compile(r"^!\[[^\]]*\]\([^)]*\)\n\n\*[^\n]*\*\n", re.MULTILINE)
    return picture.sub(lambda _: frame, text, count=1)


def put_together(source: Path) -> None:
    """All pages and what they show, in the folder that Sphinx reads."""
    shutil.rmtree(source, ignore_errors=True)
    texts: dict[str, str] = {}
    for page in pages():
        text = (ROOT / page).read_text(encoding="utf-8")
        texts[place_of(page)] = turned_links(page, text, source)
    if LIVE.is_dir():
        texts["index.md"] = with_live_picture(texts["index.md"])
    texts |= section_pages(texts["index.md"])
    texts["tutorials.md"] = contents(texts["tutorials.md"])
    texts |= species_pages(texts["species.md"])
    readme = {"": (ROOT / "README.md").read_text(encoding="utf-8")}
    texts["figures.md"] = figures_page(ROOT, texts | readme)
    texts["gallery.md"] += "\n[All figures](figures.md).\n" + toctree(["figures"])
    texts |= reference_pages(ROOT)
    for place, text in texts.items():
        (source / place).parent.mkdir(parents=True, exist_ok=True)
        (source / place).write_text(text, encoding="utf-8")
    for picture in (ROOT / "docs").glob("*.*g"):
        if picture.suffix in (".png", ".svg"):
            shutil.copyfile(picture, source / picture.name)
    small_maps(ROOT / "docs", source)


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
        write_moved(site)
        if LIVE.is_dir():
            shutil.copytree(LIVE, site / "live", dirs_exist_ok=True)
        print(f"the site is in {site}: open {site / 'index.html'}")
    return failed


if __name__ == "__main__":
    sys.exit(main())
