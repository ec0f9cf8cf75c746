"""Neural superposition by columns: which receptor of which facet sees for which column.

Where the columns of facets are known, no axes need to be compared (`neural_superposition_wiring`
does that for other eyes): R1 to R6 of a facet look along the axes of six others, a fixed step of
the lattice away, in the dorsal half and its mirror image below the equator.
"""

from __future__ import annotations

import numpy as np

from omma.base.arguments import checked
from omma.columns.lattice import Columns, expect_columns
from omma.eye.superposition import Wiring
from omma.eye.trapezoid import TRAPEZOID

# Steps (p, q) of the lattice: along the row that leads to the front and away from the equator, and
# along the one straight away from it.
_TO_FRONT = {True: (0, 1), False: (-1, 0)}  # dorsal: +q; ventral: -p
_TO_POLE = {True: (1, 1), False: (-1, -1)}


@checked
def cartridge_wiring(columns: Columns, equator: int = 0) -> tuple[Wiring, list[str]]:
    """Which facets' receptors meet in each column's cartridge (Kirschfeld 1967, Exp Brain Res
    3:248): six in the field of the eye, seven and eight along the equator, fewer at the rim.

    Rhabdomere R1 to R6 of a facet looks along the axis of the facet that lies as many steps away as
    the rhabdomere lies beside the middle, opposite, as the lens inverts
    (`omma.eye.superposition`). The pattern of the ventral half is the mirror image of that of the
    dorsal one. What looks where no facet is has no cartridge.

    Args:
        columns: of the facets, both eyes.
        equator: the row p + q from which on facets have the dorsal pattern. In MaleCNS the equator
            runs along 0 and -1 and is known to a row.

    Returns:
        (wiring, names): `Wiring` with a target for each column, whose index is of facets, those of
        R1 to R6 that meet there; names (K,) of the receptors, in the order of its index.

    Example:
        >>> wiring, _ = omma.columns.cartridge_wiring(omma.columns.fly_columns())
        >>> wiring.histogram()[6] > 1200
        True
    """
    expect_columns(columns)
    keys = list(zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist(), strict=True))
    row_of = {key: k for k, key in enumerate(keys)}
    found = []
    for facet, (side, p, q) in enumerate(keys):
        dorsal = p + q >= equator
        front, pole = _TO_FRONT[dorsal], _TO_POLE[dorsal]
        for number, (a, b) in enumerate(TRAPEZOID.values()):
            seen = (side, p - a * front[0] - b * pole[0], q - a * front[1] - b * pole[1])
            if seen in row_of:
                found.append((row_of[seen], facet, number))
    target, facet_of, number_of = np.array(sorted(found), np.int64).reshape(-1, 3).T
    first = np.searchsorted(target, np.arange(len(keys) + 1)).astype(np.int64)
    names = list(TRAPEZOID)
    wiring = Wiring(first, np.ascontiguousarray(facet_of), np.ones(len(target)), len(keys))
    return wiring, [names[k] for k in number_of.tolist()]
