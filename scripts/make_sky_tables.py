"""Computes the tables of the clear sky and stores them: python/omma/light/data/clear_sky.npz.

    .venv/bin/python scripts/make_sky_tables.py compute FOLDER [all, ozone, or a haze]
    .venv/bin/python scripts/make_sky_tables.py store FOLDER
    .venv/bin/python scripts/make_sky_tables.py sun
    .venv/bin/python scripts/make_sky_tables.py check [SUN_DEG ...]

The first needs g++ and the packages sasktran2 and musica, and two to three hours of a processor;
what it has done lies in FOLDER, so that it can be stopped and goes on. `store` puts the table
together, `sun` the sun's spectrum (sun.npz), which takes a second.
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
        case ["store", folder]:
            TABLE.parent.mkdir(exist_ok=True)
            np.savez_compressed(TABLE, **tables.assemble(Path(folder)))
            print(f"{TABLE.name}: {TABLE.stat().st_size / 1e6:.2f} MB")
        case ["sun"]:
            np.savez_compressed(TABLE.with_name("sun.npz"), **tables.sun_parts())
        case ["check", *suns]:
            check.check_tables([float(sun) for sun in suns])
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
