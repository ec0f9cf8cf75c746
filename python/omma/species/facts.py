"""The numbers of all species: one table (facts.csv), with the source and the standing of each.

Builders read their numbers here and nowhere else, so that the table says what the models are
made of. A row is `measured` (a number that the source prints, or computed from its data),
`interpolated` (worked out from such numbers) or `assumed` (nobody's measurement).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

from omma._core import Error
from omma.base.arguments import checked, one_of
from omma.base.tables import csv_text, packaged_rows
from omma.base.values import value_class

STATUSES = ("measured", "interpolated", "assumed")
# The animals whose eyes there are.
LATIN = {
    "honeybee_worker": "Apis mellifera",
    "honeybee_drone": "Apis mellifera",
    "bumblebee": "Bombus terrestris",
    "drosophila": "Drosophila melanogaster",
    "calliphora": "Calliphora vicina",
    "holcocephala": "Holcocephala fusca",
    "cataglyphis": "Cataglyphis bicolor",
    "melophorus": "Melophorus bagoti",
    "dragonfly": "Anax junius",
    "fiddler_crab": "Gelasimus vomeris",
}
# What messages say of animals that are not there.
OTHERS = " (omma.eye.generate_eye makes an eye of another animal, by its angles)"
# What the table calls the time over which a receptor adds up light.
TIME = "integration_time"
# To SI: what a unit in the table is worth. Counts, shares and ratios stay as they are.
_UNITS = {
    "um": 1e-6,
    "mm": 1e-3,
    "nm": 1.0,
    "per um": 1e6,
    "deg": math.pi / 180.0,
    "ms": 1e-3,
}


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Source:
    """A citation, and how its numbers were read: the paper's table, its abstract, at second
    hand, or not at all (recalled)."""

    key: str
    citation: str
    read: str

    def __str__(self) -> str:
        return f"{self.citation} [{self.read}]" if self.read else self.citation


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Fact:
    """One number of one animal: ``value`` in ``unit`` as printed."""

    animal: str
    quantity: str
    value: float
    unit: str
    status: str
    source: Source
    note: str

    @property
    def si(self) -> float:
        """The value in metres, radians, per metre, seconds; wavelengths in nanometres."""
        return self.value * _UNITS.get(self.unit, 1.0)


@cache
def sources() -> tuple[Source, ...]:
    """All sources, in the order of the table of sources."""
    rows = packaged_rows("omma.species", "sources.csv")
    return tuple(Source(row["key"], row["citation"], row["read"]) for row in rows)


@cache
def facts(animal: str | None = None) -> tuple[Fact, ...]:
    """The table of facts: of one animal, or of all. Raises Error for an animal not in it.

    Of megalopta, a nocturnal bee, there are some numbers and no eye.
    """
    known = {source.key: source for source in sources()}
    table = tuple(
        Fact(
            row["animal"],
            row["quantity"],
            float(row["value"]),
            row["unit"],
            row["status"],
            known[row["source"]],
            row["note"],
        )
        for row in packaged_rows("omma.species", "facts.csv")
    )
    if animal is None:
        return table
    found = tuple(fact for fact in table if fact.animal == animal)
    if not found:
        one_of(animal, dict.fromkeys(fact.animal for fact in table), "animal", OTHERS)
    return found


@cache
def number(animal: str, quantity: str) -> float:
    """A number of the table in SI units (radians, metres; nanometres for wavelengths)."""
    return find_fact(animal, quantity).si


def time_of(animals: Iterable[str], receptor: str) -> Fact | None:
    """The row of a receptor's integration time, of the first of these animals that has one."""
    for animal in animals:
        table = {fact.quantity: fact for fact in facts(animal)}
        for quantity in (f"{receptor}_{TIME}", TIME):
            if quantity in table:
                return table[quantity]
    return None


@checked
def facts_text(animal: str | None = None, form: str = "markdown") -> str:
    """The table as text: ``markdown`` or ``csv``."""
    table = facts(animal)
    if form == "csv":
        return _csv(table)
    if form == "markdown":
        return _markdown(table, with_animal=animal is None)
    raise Error(f"form: expected 'markdown' or 'csv', found {form!r}")


def find_fact(animal: str, quantity: str) -> Fact:
    for fact in facts(animal):
        if fact.quantity == quantity:
            return fact
    known = ", ".join(fact.quantity for fact in facts(animal))
    raise Error(f"quantity: expected one of {known}, found {quantity!r}")


def _csv(table: tuple[Fact, ...]) -> str:
    header = ("animal", "quantity", "value", "unit", "status", "source", "read", "note")
    rows = (
        (one.animal, one.quantity, f"{one.value:g}", one.unit, one.status)
        + (one.source.citation, one.source.read, one.note)
        for one in table
    )
    return csv_text(header, rows)


def _markdown(table: tuple[Fact, ...], with_animal: bool) -> str:
    head = ["animal"] if with_animal else []
    head += ["quantity", "value", "status", "source", "note"]
    lines = ["| " + " | ".join(head) + " |", "| " + " | ".join(["---"] * len(head)) + " |"]
    for fact in table:
        cells = [fact.animal.replace("_", " ")] if with_animal else []
        cells += [
            fact.quantity.replace("_", " "),
            printed(fact),
            fact.status,
            fact.source.key,
            fact.note,
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def printed(fact: Fact) -> str:
    """Value and unit as people write them: 0.28°, 78 µm, 344 nm."""
    unit = {"deg": "°", "um": " µm", "per um": " /µm", "1": ""}.get(fact.unit, f" {fact.unit}")
    return f"{fact.value:,.6g}{unit}"
