"""An animal: its two eyes, and what they are made of."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from omma._core import Error, Eye
from omma.base.arrays import Floats
from omma.base.notebook import html_table
from omma.base.values import value_class
from omma.species.facts import STATUSES, Fact, Source, find_fact, time_of
from omma.species.times import where_to_get_times


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Species:
    """An animal's two eyes, in the head frame, and what they are made of.

    ``eye`` holds the whole head: eye 0 is the left one, 1 the right one, positions and facet
    diameters in metres, an angular sensitivity and receptors for every ommatidium, and a text
    column ``region``. ``assumed`` says, in a sentence each, which numbers were taken from the
    animals of ``assume``.
    """

    name: str
    latin: str
    eye: Eye
    facts: tuple[Fact, ...]
    assume: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()

    @property
    def sources(self) -> tuple[Source, ...]:
        """The sources of the facts, each once."""
        return tuple(dict.fromkeys(fact.source for fact in self.facts))

    def fact(self, quantity: str) -> Fact:
        """The row of this quantity."""
        return find_fact(self.name, quantity)

    @property
    def integration_time_s(self) -> Floats:
        """Over which each receptor adds up light: (R,), s, for `omma.receptors.photon_catch`.

        The full width at half maximum of the impulse response in bright light, by receptor or for
        all, of the table: of this animal, or else of the first in ``assume`` that has it. The time
        that leaves an impulse response's noise, `ImpulseResponse.integration_time_s`, is 1.5 to 1.6
        times as long, and so are catches over it.

        Example:
            >>> bee = omma.species.bumblebee()
            >>> sorted({round(1000 * float(one), 1) for one in bee.integration_time_s})
            [7.9, 9.8, 12.3]

        Raises:
            omma.Error: it is not known of a receptor.
        """
        names = [one.name for one in self.eye.receptor_types]
        whose = (self.name, *self.assume)
        rows = {name: time_of(whose, name) for name in dict.fromkeys(names)}
        lacking = [name for name, row in rows.items() if row is None]
        if lacking or not names:
            raise Error(
                f"{self.name}: its integration time is not known"
                + (f" of the receptors {', '.join(lacking)}; " if lacking else ", ")
                + where_to_get_times(self.name, self.assume, self.eye.receptor_types, lacking)
            )
        times = {name: row.si for name, row in rows.items() if row is not None}
        return np.array([times[name] for name in names])[self.eye.receptor_type]

    def _repr_html_(self) -> str:
        receptors: dict[str, float] = {}
        for one in self.eye.receptor_types:
            receptors.setdefault(one.name, one.peak_wavelength_nm)
        count = Counter(fact.status for fact in self.facts)
        rows = {
            "latin": self.latin,
            "ommatidia": f"{len(self.eye):,}",
            "receptors": ", ".join(
                f"{name} {peak:g} nm" if peak else name for name, peak in receptors.items()
            ) or "none known",
            "numbers": ", ".join(f"{count[status]} {status}" for status in STATUSES),
            "sources": f"{len(self.sources)}; facts_text({self.name!r}) has them all",
        }  # fmt: skip
        if self.assumed:
            rows["assumed"] = "; ".join(self.assumed)
        picture = self.eye._repr_html_()  # type: ignore[attr-defined]
        return html_table(f"omma.species.{self.name}", rows) + str(picture)

    def __repr__(self) -> str:
        whose = f", assumed from {', '.join(self.assume)}" if self.assume else ""
        return f"Species({self.name}, {self.latin}, {len(self.eye)} ommatidia{whose})"
