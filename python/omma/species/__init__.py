"""Eyes of animals, from published numbers: what is measured, interpolated and assumed is said.

Each function makes a `Species`: the whole head (both eyes), its facts and their sources. The
numbers are in one table, `facts()`; docs/species.md shows it. Only assumed shapes, such as outlines
of fields of view and where blends begin and end, stand in the code. The models are the same every
time.

    bee = omma.species.honeybee_worker()
    renderer = omma.Renderer(scene, bee.eye)
"""

from __future__ import annotations

from collections.abc import Callable

from omma._core import Error
from omma.base.arguments import checked, one_of
from omma.species.ants import cataglyphis, melophorus
from omma.species.bees import bumblebee, honeybee_drone, honeybee_worker
from omma.species.facts import Fact, Source, Species, facts, facts_text, sources
from omma.species.fiddler import fiddler_crab
from omma.species.flies import calliphora, drosophila
from omma.species.hunters import dragonfly, holcocephala

_MAKERS: dict[str, Callable[..., Species]] = {
    "honeybee_worker": honeybee_worker,
    "honeybee_drone": honeybee_drone,
    "bumblebee": bumblebee,
    "drosophila": drosophila,
    "calliphora": calliphora,
    "holcocephala": holcocephala,
    "cataglyphis": cataglyphis,
    "melophorus": melophorus,
    "dragonfly": dragonfly,
    "fiddler_crab": fiddler_crab,
}


def names() -> list[str]:
    """The animals there are."""
    return list(_MAKERS)


@checked
def make(name: str, progress: Callable[[str, float | None], object] | None = None) -> Species:
    """The animal of this name, as its own function makes it. Raises Error for another name."""
    if name not in _MAKERS and any(fact.animal == name for fact in facts()):
        raise Error(
            f"name: {name} has numbers (facts({name!r})), but too few are known for its eyes; "
            f"expected one of {', '.join(_MAKERS)}"
        )
    return _MAKERS[one_of(name, _MAKERS, "name")](progress)


__all__ = [
    "Fact",
    "Source",
    "Species",
    "facts",
    "facts_text",
    "make",
    "names",
    "sources",
    *_MAKERS,
]
