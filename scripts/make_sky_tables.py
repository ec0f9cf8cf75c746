"""Computes the tables of the clear sky and stores them: python/omma/light/data/clear_sky.npz.

    .venv/bin/python scripts/make_sky_tables.py compute FOLDER [all, ozone, heights, or a haze]
    .venv/bin/python scripts/make_sky_tables.py store FOLDER
    .venv/bin/python scripts/make_sky_tables.py store-heights FOLDER
    .venv/bin/python scripts/make_sky_tables.py sun
    .venv/bin/python scripts/make_sky_tables.py hazes
    .venv/bin/python scripts/make_sky_tables.py check [SUN_DEG ...]

The first needs g++ and the packages sasktran2 and musica, and two to three hours of a processor;
what it has done lies in FOLDER, so that it can be stopped and goes on. `store` puts the table
together, and what high ground changes (clear_sky_heights.npz), `store-heights` that alone. `sun` is
the sun's spectrum (sun.npz), `hazes` what haze of every kind does (haze_kinds.npz): seconds each.
`check` compares what is stored with direct computations between its nodes, and prints for
docs/light.md how far they are apart. The parts are in scripts/sky/.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "sky"))

import check
import grid
import numpy as np
import pieces
import tables

TABLE = Path(__file__).resolve().parents[1] / "python/omma/light/data/clear_sky.npz"


def main() -> None:
    match sys.argv[1:]:
        case ["compute", folder, *rest]:
            what = rest[0] if rest else "all"
            for haze in grid.HAZE:
                if what in ("all", f"{haze:g}"):
                    pieces.compute(Path(folder), haze)
            if what in ("all", "ozone"):
                pieces.compute_ozone(Path(folder))
            if what in ("all", "heights"):
                pieces.compute_heights(Path(folder))
        case ["store", folder]:
            TABLE.parent.mkdir(exist_ok=True)
            np.savez_compressed(TABLE, **tables.assemble(Path(folder)))
            _store_heights(folder)
            print(f"{TABLE.name}: {TABLE.stat().st_size / 1e6:.2f} MB")
        case ["store-heights", folder]:
            _store_heights(folder)
        case ["sun"]:
            np.savez_compressed(TABLE.with_name("sun.npz"), **tables.sun_parts())
        case ["hazes"]:
            np.savez_compressed(TABLE.with_name("haze_kinds.npz"), **tables.haze_parts())
        case ["check", *suns]:
            check.check_tables([float(sun) for sun in suns])
        case _:
            sys.exit(__doc__)


def _store_heights(folder: str) -> None:
    parts = tables.height_parts(Path(folder))
    np.savez_compressed(TABLE.with_name("clear_sky_heights.npz"), **parts)


if __name__ == "__main__":
    main()
