from .animals import (
    bumblebee,
    calliphora,
    cataglyphis,
    dragonfly,
    drosophila,
    fiddler_crab,
    holcocephala,
    honeybee_drone,
    honeybee_worker,
    make,
    melophorus,
    names,
    with_catches,
)
from .assumed import assume_rhabdoms
from .facts import Fact, Source, facts, facts_text, sources
from .growing import build
from .measured import measured_drosophila
from .species import Species

__all__ = [
    "Fact",
    "Source",
    "Species",
    "assume_rhabdoms",
    "build",
    "bumblebee",
    "calliphora",
    "cataglyphis",
    "dragonfly",
    "drosophila",
    "facts",
    "facts_text",
    "fiddler_crab",
    "holcocephala",
    "honeybee_drone",
    "honeybee_worker",
    "make",
    "measured_drosophila",
    "melophorus",
    "names",
    "sources",
    "with_catches",
]
