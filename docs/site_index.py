"""The first page of the site and its sections, from the lists of docs/index.md. For
docs/make_site.py."""

from __future__ import annotations

import re

ENTRY = re.compile(r"^- \[([^\]]*)\]\(([^)\s#:]+)\.md\): ([^\n]*)$", re.MULTILINE)
LINKED = re.compile(r"\]\(([^)\s#:]+)\.md\)")


def toctree(entries: list[str]) -> str:
    """A list of pages for the navigation only."""
    return "\n```{toctree}\n:hidden:\n\n" + "\n".join(entries) + "\n```\n"


def cards(text: str) -> str:
    """Entries of a list, each a link with what it is for, as cards."""
    shown = [
        f":::{{grid-item-card}} {title}\n:link: {page}\n:link-type: doc\n\n"
        f"{about[0].upper()}{about[1:]}\n:::\n"
        for title, page, about in ENTRY.findall(text)
    ]
    return "::::{grid} 1 2 2 3\n:gutter: 3\n\n" + "\n".join(shown) + "::::\n"


def section_pages(index: str) -> dict[str, str]:
    """The first page, and one for each of its sections with the pages below it in the navigation;
    the reference comes last."""
    head, *sections = re.split(r"^## ", index, flags=re.MULTILINE)
    pages, first, slugs = {}, [head], []
    for section in sections:
        title, body = section.split("\n", 1)
        entries = [line for line in body.split("\n") if line.startswith("- ")]
        rest = "\n".join(line for line in body.split("\n") if not line.startswith("- ")).strip()
        listed = "\n".join(entries)
        linked = list(dict.fromkeys(LINKED.findall(listed)))
        slug = title.lower().replace(" ", "-")
        slugs.append(slug)
        pages[f"{slug}.md"] = f"# {title}\n\n{cards(listed)}" + toctree(linked)
        first.append(f"## {title}\n\n{cards(listed)}\n{rest}\n\n")
    pages["index.md"] = "".join(first) + toctree([*slugs, "reference"])
    return pages
