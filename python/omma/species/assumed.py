"""Numbers that an animal lacks, taken from another: what ``assume`` of the animals does, and says.

Photons are counted by facets, rhabdoms and their absorption (`omma.receptors.photon_catch`), which
are measured of few animals. Nothing is taken from another animal unless it is named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from omma._core import Error, Eye, ReceptorType
from omma.base.arguments import checked, one_of
from omma.base.warn import warn_caller
from omma.species.facts import LATIN, Fact, facts, printed, time_of
from omma.species.species import Species
from omma.species.stored import stored

# Of which animals, the first that has a number first.
Assume = str | Sequence[str] | None

# What a receptor type calls a number, what the table calls it, and what it is in words.
_OF_RHABDOM = (
    ("length_m", ("rhabdom_length", "rhabdomere_length"), "rhabdom length"),
    ("absorption_per_m", ("absorption",), "absorption"),
)


def completed(species: Species, assume: Assume) -> Species:
    """The animal, and what its eyes lack for counting photons from the animals of these names."""
    donors = _donors(assume)
    if not donors:
        return species
    eye, said = _filled(species.eye, donors)
    said += _times_taken(species.name, eye, donors)
    return replace(species, eye=eye, assume=donors, assumed=said)


@checked
def assume_rhabdoms(eye: Eye, assume: str | Sequence[str]) -> Eye:
    """An eye of one's own with what it lacks for counting photons, taken from animals here.

    Only numbers that are 0, not known, are taken: lengths and absorption of rhabdoms, facet
    diameters (the median); of an eye without receptors one of each pigment, along the axis. A
    warning says which were. Rhabdoms that absorb make sensitivities broader, so render with this
    eye. Of the animals here `make` does it: ``omma.species.bumblebee(assume="honeybee_worker")``.

    Args:
        assume: an animal, or several: of each number the first that has it.

    Raises:
        omma.Error: no such animal, or a number that none of them has.
    """
    donors = _donors(assume)
    if not donors:
        raise Error("assume: expected one animal or more, found none")
    completed_eye, said = _filled(eye, donors)
    if said:
        warn_caller(f"eye: {'; '.join(said)}", UserWarning)
    return completed_eye


def _donors(assume: Assume) -> tuple[str, ...]:
    if assume is not None and not isinstance(assume, (str, Sequence)):
        found = type(assume).__name__
        raise TypeError(f"assume: expected the name of an animal, or several, found {found}")
    names = () if assume is None else (assume,) if isinstance(assume, str) else tuple(assume)
    # Of the honeybee it is the worker that has all.
    short = {"honeybee": "honeybee_worker"}
    return tuple(one_of(short.get(name, name), LATIN, "assume") for name in names)


def _filled(eye: Eye, donors: tuple[str, ...]) -> tuple[Eye, tuple[str, ...]]:
    """The eye with what it lacks, and sentences that say what was taken from whom."""
    said = []
    if not eye.receptor_types:
        eye, sentence = _with_pigments(eye, donors)
        said.append(sentence)
    unknown = eye.facet_diameter_m == 0
    if unknown.any():
        median = float(np.median(stored(donors[0]).eye.facet_diameter_m))
        eye = eye.replace(facet_diameter_m=np.where(unknown, median, eye.facet_diameter_m))
        said.append(f"facet diameter {median * 1e6:.3g} µm, the median of {donors[0]}")
    types = eye.receptor_types
    for field, quantities, words in _OF_RHABDOM:
        lacking = [one.name for one in types if getattr(one, field) == 0]
        if lacking:
            fact = _first(donors, quantities, words)
            types = [
                one if getattr(one, field) else _with_rhabdom(one, **{field: fact.si})
                for one in types
            ]
            said.append(_taken(words, fact, lacking, len(types)))
    return eye.replace(receptor_types=types), tuple(said)


def _times_taken(name: str, eye: Eye, donors: tuple[str, ...]) -> tuple[str, ...]:
    """Sentences that say of which receptors the integration time is another animal's, and whose.

    `Species.integration_time_s` takes them from the same rows.
    """
    receptors = dict.fromkeys(one.name for one in eye.receptor_types)
    taken: dict[Fact, list[str]] = {}
    for receptor in receptors:
        fact = time_of((name, *donors), receptor)
        if fact is not None and fact.animal != name:
            taken.setdefault(fact, []).append(receptor)
    return tuple(
        _taken("integration time", fact, lacking, len(receptors)) for fact, lacking in taken.items()
    )


def _taken(words: str, fact: Fact, lacking: list[str], count: int) -> str:
    """What was taken for receptors that lack it, of so many, and whose it is."""
    whose = "" if len(lacking) == count else f" of {', '.join(dict.fromkeys(lacking))}"
    return f"{words}{whose} {printed(fact)}, as of {fact.animal} ({fact.status})"


def _first(donors: tuple[str, ...], quantities: tuple[str, ...], words: str) -> Fact:
    rows = [fact for fact in facts() if fact.quantity in quantities and fact.animal in LATIN]
    for donor in donors:
        for fact in rows:
            if fact.animal == donor:
                return fact
    known = ", ".join(dict.fromkeys(fact.animal for fact in rows))
    raise Error(
        f"assume: expected an animal whose {words} is known ({known}), found {', '.join(donors)}"
    )


def _with_pigments(eye: Eye, donors: tuple[str, ...]) -> tuple[Eye, str]:
    for donor in donors:
        kinds: dict[float, ReceptorType] = {}
        for one in stored(donor).eye.receptor_types:
            kinds.setdefault(one.peak_wavelength_nm, one)
        if kinds:
            types = [
                ReceptorType(
                    one.name,
                    peak_wavelength_nm=peak,
                    length_m=one.length_m,
                    absorption_per_m=one.absorption_per_m,
                )
                for peak, one in kinds.items()
            ]
            each = np.tile(np.arange(len(types), dtype=np.int32), (len(eye), 1))
            peaks = ", ".join(f"{peak:g}" for peak in kinds)
            return (
                eye.replace(receptor_types=types, receptors=each),
                f"one receptor of each pigment of {donor} ({peaks} nm), along the axis",
            )
    raise Error(f"assume: expected an animal with receptors, found {', '.join(donors)}")


def _with_rhabdom(one: ReceptorType, **changes: float) -> ReceptorType:
    fields = {
        "microvillus_angle_rad": one.microvillus_angle_rad,
        "polarisation_sensitivity": one.polarisation_sensitivity,
        "absorption_per_m": one.absorption_per_m,
        "length_m": one.length_m,
        "right_rad": one.right_rad,
        "up_rad": one.up_rad,
        **changes,
    }
    table = len(one.wavelength_nm) > 0
    return ReceptorType(
        one.name,
        peak_wavelength_nm=one.peak_wavelength_nm,
        wavelength_nm=one.wavelength_nm if table else None,
        sensitivity=one.sensitivity if table else None,
        acceptance=one.acceptance,
        allow_unusual=True,  # they were told when the type was made
        **fields,
    )
