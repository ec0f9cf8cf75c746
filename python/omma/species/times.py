"""What to do where an animal's integration time is not known."""

from __future__ import annotations

from collections.abc import Collection

from omma.species.animals import with_catches
from omma.species.facts import LATIN, TIME, Species, facts, time_of
from omma.species.stored import stored


def where_to_get_times(species: Species, lacking: Collection[str]) -> str:
    """Who has the times of these receptors, and how to take them; of no receptors, what lacks."""
    have = [name for name in LATIN if any(one.quantity.endswith(TIME) for one in facts(name))]
    known = ", ".join(have)
    if not lacking:
        return (
            f"nor its receptors. Name in assume= an animal that has both ({known}) and one whose "
            f"rhabdoms are known ({', '.join(with_catches())})"
        )
    donor = next((name for name in have if name != species.name and _has(name, lacking)), None)
    if donor is None:
        return (
            f"it is of {known}, which have no receptors of all these names. Give photon_catch a "
            "number of seconds"
        )
    names = [*species.assume, donor]
    types = species.eye.receptor_types
    if not all(one.length_m and one.absorption_per_m for one in types):
        names.append(with_catches()[0])
    words = repr(names[0] if len(names) == 1 else tuple(names))
    return (
        f"it is of {donor}, which has receptors of these names. Give photon_catch a number of "
        f"seconds, or take {donor}'s, as in omma.species.{species.name}(assume={words})"
    )


def _has(animal: str, receptors: Collection[str]) -> bool:
    """Whether the animal has all these receptors, by name, and their times."""
    own = {one.name for one in stored(animal).eye.receptor_types}
    return all(one in own and time_of([animal], one) is not None for one in receptors)
