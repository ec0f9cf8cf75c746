"""The site's pages of animals, from omma.species: every number with its source. For
docs/make_site.py."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

from PIL import Image
from site_index import toctree

import omma


def source_lines(keys: set[str] | None = None) -> str:
    """Sources as a list, all or those of these keys, each with what of it was read."""
    return "\n".join(
        f"- `{one.key}`: {one.citation}" + (f" (read: {one.read})" if one.read else "")
        for one in omma.species.sources()
        if keys is None or one.key in keys
    )


def keys_of(table: str) -> set[str]:
    """The sources that a table of facts names."""
    return set(re.findall(r"^\|.*\| (\w+) \| [^|]*\|$", table, re.MULTILINE))


def animal_page(name: str, title: str, alt: str) -> str:
    """What an animal's eye is made of, with its map."""
    about = inspect.cleandoc(getattr(omma.species, name).__doc__)
    table = omma.species.facts_text(name)
    return (
        f"# {title}\n\n{about}\n\n![{alt}](../species-{name}.png)\n\n"
        f"*Above, the angle between neighbours in direction, and the smaller angle of facets that "
        f"touch; below, facets and acceptance angles. Straight ahead is in the middle, the "
        f"animal's right on the right.*\n\n"
        f"    omma eye species {name} -o {name}.csv\n\n"
        f"In Python: `omma.species.{name}().eye`. How eyes are made, and what *measured*, "
        f"*interpolated* and *assumed* mean: [species](../species.md).\n\n{table}\n\n"
        f"## Sources of these numbers\n\n{source_lines(keys_of(table))}\n"
    )


def species_pages(text: str) -> dict[str, str]:
    """docs/species.md with a card for each animal and all sources, and a page for each animal."""
    pages, cards = {}, []
    for name in omma.species.names():
        title = name.replace("_", " ").capitalize()
        alt = f"Maps of the interommatidial angle and the facets of the {title.lower()}"
        pages[f"species/{name}.md"] = animal_page(name, title, alt)
        first = inspect.cleandoc(getattr(omma.species, name).__doc__).split("\n\n")[0]
        cards.append(
            f":::{{grid-item-card}} {title}\n:link: species/{name}\n:link-type: doc\n"
            f":img-top: species-{name}-small.png\n:img-alt: {alt}\n\n{first}\n:::\n"
        )
    grid = "::::{grid} 1 2 2 3\n:gutter: 3\n\n" + "\n".join(cards) + "::::\n\n"
    # The table of animals is what cards show, figures are those of the animals' pages.
    text = re.sub(r"^\| animal .*?\n\n", lambda _: grid, text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^!\[.*\]\(species-.*\)\n", "", text, flags=re.MULTILINE)
    night = omma.species.facts_text("megalopta")
    pages["species.md"] = (
        f"{text}\n## Megalopta\n\nFor an example only; no eye is made.\n\n{night}\n\n"
        f"## Sources\n\n{source_lines()}\n"
        + toctree([place.removesuffix(".md") for place in pages])
    )
    return pages


def small_maps(docs: Path, source: Path) -> None:
    """The upper left map of each animal's figure, without title and scale, for the cards."""
    for picture in docs.glob("species-*.png"):
        whole = Image.open(picture)
        left = whole.crop((0, whole.height * 9 // 200, whole.width // 2, whole.height * 77 // 200))
        left.resize((530, round(530 * left.height / left.width))).save(
            source / f"{picture.stem}-small.png"
        )
