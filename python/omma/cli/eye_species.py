"""``omma eye species``: eyes of animals from published numbers, and where the numbers are from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from omma import species
from omma._core import Error
from omma.base.arguments import as_named
from omma.base.files import check_ending, write_whole
from omma.cli.parameters import argument, option, out, switch
from omma.cli.working import check_outputs, say, working
from omma.eye.files import EYE_SUFFIXES, save_eye
from omma.species.facts import printed

_FORMS = {".csv": "csv", ".md": "markdown"}

SPECIES_HELP = """
Make the eyes of an animal, and say what they are made of.

Without NAME, the animals there are. With it, the animal's numbers: which are measured, which
interpolated, which assumed, and by whom. With -o the whole head is made and written; .csv, .gltf
and .glb keep all of it, .eye only positions, axes and angles (say --lossy then).

**Examples**

`omma eye species`

`omma eye species holcocephala`

`omma eye species holcocephala -o robber_fly.csv`

With what it lacks for counting photons from other animals, of each number the first that has it:

`omma eye species bumblebee --assume honeybee -o bumblebee.csv`

All animals' numbers in one file, .csv or .md:

`omma eye species --facts species.csv`
"""


def add_species_command(app: typer.Typer) -> None:
    """Register ``species`` with ``omma eye``."""
    app.command(
        name="species",
        help=SPECIES_HELP,
        short_help="Make an animal's eyes from published numbers.",
    )(species_command)


def species_command(
    name: Annotated[str | None, argument("The animal.", "NAME")] = None,
    output: Annotated[Path | None, out("Eye file to write: .csv, .glb, .eye.")] = None,
    facts: Annotated[
        Path | None, option("Write the table of numbers: .csv or .md.", "OUT", name="--facts")
    ] = None,
    lossy: Annotated[
        bool, switch("--lossy", "Write an .eye file, which cannot hold all of it.")
    ] = False,
    assume: Annotated[
        list[str] | None,
        option(
            "An animal from which numbers are taken that this one lacks; may be repeated.", "NAME"
        ),
    ] = None,
) -> None:
    """Make the eyes of an animal."""
    if output is not None:
        check_ending(output, *EYE_SUFFIXES)
    if facts is not None:
        check_ending(facts, *_FORMS)
    if assume and output is None:
        raise Error(
            "--assume: expected with -o, as it changes the eyes, not the table; found no -o"
        )
    check_outputs(output, facts)
    if name is not None:
        with as_named(animal="NAME"):
            species.facts(name)  # an unknown animal is said before anything is written
    if facts is not None:
        _write_facts(facts, name)
    if output is not None:
        if name is None:
            raise Error("NAME: expected with -o, found none; `omma eye species` lists them")
        with working(), as_named(assume="--assume"):
            animal = species.make(name, assume=assume)
            save_eye(output, animal.eye, lossy=lossy)
        say(f"wrote {output}: {animal.latin}, {len(animal.eye):,} ommatidia of two eyes")
        for sentence in animal.assumed:
            say(f"assumed: {sentence}")
    if facts is None and output is None:
        _show(name)


def _write_facts(path: Path, name: str | None) -> None:
    write_whole(path, species.facts_text(name, _FORMS[path.suffix.lower()]).encode())
    say(f"wrote {path}")


def _show(name: str | None) -> None:
    console = Console()
    if name is None:
        for animal in species.names():
            say(animal)
        others = dict.fromkeys(fact.animal for fact in species.facts())
        for animal in others:
            if animal not in species.names():
                say(f"{animal} (numbers only: too few are known for its eyes)")
        return
    table = Table(title=name.replace("_", " "), title_justify="left")
    for heading in ("quantity", "value", "status", "source", "note"):
        table.add_column(heading, overflow="fold")
    for fact in species.facts(name):
        quantity = fact.quantity.replace("_", " ")
        table.add_row(quantity, printed(fact), fact.status, fact.source.key, fact.note)
    console.print(table)
    for source in dict.fromkeys(fact.source for fact in species.facts(name)):
        read = f" (read: {source.read})" if source.read else ""
        say(f"{source.key}: {source.citation}{read}")
