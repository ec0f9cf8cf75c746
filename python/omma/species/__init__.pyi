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
)
from .facts import Fact, Source, Species, facts, facts_text, sources
from .growing import build

__all__ = [
    "Fact",
    "Source",
    "Species",
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
    "melophorus",
    "names",
    "sources",
]
