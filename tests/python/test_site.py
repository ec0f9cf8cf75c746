"""The documentation site: built without a warning, whole, searchable, and without a network.

Tutorials are not run here, they have a test of their own.
"""

import importlib
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
from public_names import public_things, subpackages

ROOT = Path(__file__).resolve().parents[2]
for needed in ("sphinx", "pydata_sphinx_theme", "myst_nb", "sphinx_design", "sphinx_copybutton"):
    pytest.importorskip(needed, reason="pip install 'omma[docs]'")


class Page(HTMLParser):
    """What a page refers to: places in it, links, and what a browser loads by itself."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.loaded, self.pictures = set(), [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        had = dict(attrs)
        self.ids.update(had[key] for key in ("id", "name") if had.get(key))
        if tag == "a" and had.get("href"):
            self.links.append(had["href"])
        if tag == "img":
            self.pictures.append((had.get("src"), had.get("alt")))
        if tag == "link" and had.get("rel") not in ("next", "prev", "index", "search", "author"):
            self.loaded.append(had.get("href"))
        self.loaded += [had[key] for key in ("src", "srcset", "data", "poster") if had.get(key)]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The folder of a site that was built, and what building said."""
    site = tmp_path_factory.mktemp("docs") / "site"
    command = [sys.executable, ROOT / "docs" / "make_site.py", site]
    environment = os.environ | {"OMMA_DOCS_NOTEBOOKS": "off", "MPLBACKEND": "Agg"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return site, done.stderr


@pytest.fixture(scope="module")
def site(built):
    return built[0]


@pytest.fixture(scope="module")
def moved():
    """Old pages and where they are now."""
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        return importlib.import_module("site_moved")
    finally:
        sys.path.remove(str(ROOT / "docs"))


@pytest.fixture(scope="module")
def html(site):
    """All pages of the site, read."""
    return {
        path.relative_to(site).as_posix(): Page(path.read_text(encoding="utf-8"))
        for path in site.rglob("*.html")
    }


def test_it_builds_without_a_warning(built):
    assert "WARNING" not in built[1]
    assert "ERROR" not in built[1]


def test_each_kind_of_page_is_there(html):
    pages = ["start", "tutorials", "reference", "gallery", "figures", "species", "validation"]
    pages += ["limits", "glossary", "search", "CONVENTIONS", "CONTRIBUTING", "bench/RESULTS"]
    pages += ["begin", "scenes-and-light", "eyes-and-receptors", "responses", "inside"]
    pages += [f"species/{name}" for name in subpackages()["species"].names()]
    assert not {f"{page}.html" for page in pages} - set(html)


def test_every_public_name_has_an_entry(html):
    """One with what it takes and gives, not only a link to it."""
    missing = []
    for subpackage, name, _ in public_things():
        full = ".".join(part for part in ("omma", subpackage, name) if part)
        page = ".".join(part for part in ("omma", subpackage) if part)
        if full not in html[f"reference/{page}.html"].ids:
            missing.append(full)
    assert not missing


def test_every_command_has_its_help(site):
    text = (site / "reference" / "command-line.html").read_text(encoding="utf-8")
    for command in ("omma render", "omma eye make", "omma dataset run", "omma measure speed"):
        assert f">{command}<" in text
    for option in ("--standard-error", "--acute-zone", "--slurm"):
        assert option in text


def test_search_knows_the_main_terms(site):
    text = (site / "searchindex.js").read_text(encoding="utf-8")
    index = json.loads(text.removeprefix("Search.setIndex(").removesuffix(")"))
    terms = set(index["terms"]) | set(index["titleterms"])
    for term in ("ommatid", "rhabdom", "polaris", "acceptance", "compoundray", "looming", "zarr"):
        stem = term[:7]
        assert any(one.startswith(stem) for one in terms), term
    assert "eye" in index["docnames"] or "reference/omma.eye" in index["docnames"]


def test_nothing_is_loaded_from_a_network(site, html):
    for place, page in html.items():
        far = [one for one in page.loaded if re.match(r"(https?:)?//", one)]
        assert not far, f"{place} loads {far}"
        assert not any("mathjax" in one.lower() for one in page.loaded), place
    for style in site.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.search(r"(url\(|@import)\s*['\"]?(https?:)?//", text), style


def test_links_lead_somewhere(html, site):
    wrong = []
    for place, page in html.items():
        for link in page.links:
            if re.match(r"[a-z]+:", link) or link.startswith("//"):
                continue
            path, _, anchor = unquote(link).partition("#")
            target = os.path.normpath(os.path.join(os.path.dirname(place), path)) if path else place
            if not (site / target).is_file():
                wrong.append(f"{place}: {link}: no such page")
            elif anchor and target in html and anchor not in html[target].ids:
                wrong.append(f"{place}: {link}: no such place")
    assert not wrong, "\n".join(wrong)


def test_old_addresses_lead_on(html, moved):
    """To a page, and to where in it; links of the site itself go there at once."""
    assert len(moved.MOVED) > 20
    for name in moved.MOVED:
        assert html[f"{name}.html"].links == [moved.address_of(name)]
    for place, page in html.items():
        within = {os.path.normpath(os.path.join(os.path.dirname(place), one)) for one in page.links}
        assert not {f"{name}.html" for name in moved.MOVED} & within, place


def test_pictures_say_what_they_show(html):
    silent = [
        f"{place}: {source}"
        for place, page in html.items()
        for source, text in page.pictures
        if not (text or "").strip() or (text or "").endswith((".png", ".svg"))
    ]
    assert not silent, "\n".join(silent)


def test_validation_names_tests_that_are_there():
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(tests/[\w/]+\.(?:py|cpp))`", page))
    assert len(named) > 15
    assert not [name for name in named if not (ROOT / name).is_file()]
