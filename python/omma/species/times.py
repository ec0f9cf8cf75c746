"""What to do where an animal's integration time is not known."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from omma._core import ReceptorType
from omma.species.facts import LATIN, TIME, facts, time_of
from omma.species.stored_files import stored_receptors


def where_to_get_times(
    name: str, assume: Sequence[str], types: Sequence[ReceptorType], lacking: Collection[str]
) -> str:
    """Who has the times of these receptors, and how an animal of that name, with such types of
    receptors, takes them; of no receptors, what lacks."""
    have = [one for one in LATIN if any(fact.quantity.endswith(TIME) for fact in facts(one))]
    known, rhabdoms = ", ".join(have), _with_rhabdoms()
    if not lacking:
        return (
            f"nor its receptors. Name in assume= an animal that has both ({known}) and one whose "
            f"rhabdoms are known ({', '.join(rhabdoms)})"
        )
    donor = next((one for one in have if one != name and _has(one, lacking)), None)
    if donor is None:
        return (
            f"it is of {known}, which have no receptors of all these names. Give photon_catch a "
            "number of seconds"
        )
    names = [*assume, donor]
    if not all(one.length_m and one.absorption_per_m for one in types):
        names.append(rhabdoms[0])
    words = repr(names[0] if len(names) == 1 else tuple(names))
    return (
        f"it is of {donor}, which has receptors of these names. Give photon_catch a number of "
        f"seconds, or take {donor}'s, as in omma.species.{name}(assume={words})"
    )


def _with_rhabdoms() -> list[str]:
    """The animals whose rhabdoms' length and absorption are known."""
    needed = {"rhabdom_length", "absorption"}
    return [one for one in LATIN if needed <= {fact.quantity for fact in facts(one)}]


def _has(animal: str, receptors: Collection[str]) -> bool:
    """Whether the animal has all these receptors, by name, and their times."""
    own = set(stored_receptors(animal))
    return all(one in own and time_of([animal], one) is not None for one in receptors)
