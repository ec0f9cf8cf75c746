"""Grows the eyes of all animals anew and stores them in the package: python/omma/species/data/.

    .venv/bin/python scripts/make_species.py                  all of them, about ten minutes
    .venv/bin/python scripts/make_species.py drosophila ...   some

To be run when a number in facts.csv or a builder in python/omma/species has changed. A change of a
number asks for all; tests/python/test_species_data.py says so.
"""

import sys
from pathlib import Path

import omma
from omma.species.stored import store

DATA = Path(__file__).resolve().parents[1] / "python" / "omma" / "species" / "data"


def main() -> None:
    DATA.mkdir(exist_ok=True)
    for name in sys.argv[1:] or omma.species.names():
        path = DATA / f"{name}.npz"
        head = omma.species.build(name).eye
        store(path, head)
        print(
            f"{path.name}: {len(head):,} ommatidia, {path.stat().st_size / 1000:.0f} kB", flush=True
        )


if __name__ == "__main__":
    main()
