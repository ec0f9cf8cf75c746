"""The animals' eyes grown anew from their numbers: what scripts/make_species.py stores."""

from __future__ import annotations

from collections.abc import Callable

from omma._core import Eye
from omma.base.arguments import checked
from omma.base.progress import Stage
from omma.eye.change import join_eyes, pair_of_eyes
from omma.species.animals import known
from omma.species.ants import build_cataglyphis, build_melophorus
from omma.species.bees import build_bumblebee, build_honeybee_drone, build_honeybee_worker
from omma.species.facts import LATIN, facts
from omma.species.fiddler import build_fiddler_crab
from omma.species.flies import build_calliphora, build_drosophila
from omma.species.hunters import build_dragonfly, build_holcocephala
from omma.species.species import Species

# A right eye, whose mirror image is the left one, or a left and a right eye.
_BUILDERS: dict[str, Callable[[Stage | None], list[Eye]]] = {
    "honeybee_worker": build_honeybee_worker,
    "honeybee_drone": build_honeybee_drone,
    "bumblebee": build_bumblebee,
    "drosophila": build_drosophila,
    "calliphora": build_calliphora,
    "holcocephala": build_holcocephala,
    "cataglyphis": build_cataglyphis,
    "melophorus": build_melophorus,
    "dragonfly": build_dragonfly,
    "fiddler_crab": build_fiddler_crab,
}


@checked
def build(name: str, progress: Stage | None = None) -> Species:
    """The animal of this name, its eyes grown anew from the table of numbers: up to a minute.

    Who changes a number in `facts.csv` sees here what comes of it; `make` and the functions of the
    animals give the eyes that are stored with the package, which were made so.

    Args:
        progress: called as progress(stage, finished fraction or None) now and then.

    Raises:
        omma.Error: no such animal.
    """
    eyes = _BUILDERS[known(name)](progress)
    head = pair_of_eyes(eyes[0]) if len(eyes) == 1 else join_eyes(eyes)
    return Species(name, LATIN[name], head, facts(name))
