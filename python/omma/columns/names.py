"""Columns by the names that the releases of connectomes give them, both ways.

MaleCNS: "ME_R_col_18_19", hex1 before hex2; the same columns of lobula and lobula plate are LO and
LOP. FlyWire: hemisphere, p and q.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of, checked
from omma.base.arrays import Ints
from omma.columns.coordinates import hex_from_pq, pq_from_hex
from omma.columns.lattice import Columns, expect_columns
from omma.species.measured import medulla_names

_NAME = re.compile(r"(?:ME|LO|LOP)_([LR])_col_(\d{1,2})_(\d{1,2})")
# What root ids of FlyWire begin with; all have 18 digits.
_ROOT_ID = re.compile(r"7205759\d{11}")


@checked
def malecns_names(columns: Columns) -> list[str]:
    """What MaleCNS calls these columns of the medulla: (M,) texts, as "ME_R_col_18_19".

    Example:
        >>> omma.columns.malecns_names(omma.columns.fly_columns())[0]
        'ME_L_col_02_05'

    Raises:
        omma.Error: columns whose hex1 or hex2 are not 0 to 99, which have no such names.
    """
    expect_columns(columns)
    hex1, hex2 = hex_from_pq(columns.p, columns.q)
    outside = np.flatnonzero((np.minimum(hex1, hex2) < 0) | (np.maximum(hex1, hex2) > 99))
    if len(outside):
        k = outside[0]
        raise Error(
            f"columns: expected hex1 and hex2 of 0 to 99, found {hex1[k]} and {hex2[k]} of p = "
            f"{columns.p[k]}, q = {columns.q[k]}"
        )
    return medulla_names(hex1, hex2, columns.side)


@checked
def flywire_names(columns: Columns) -> list[tuple[str, int, int]]:
    """What FlyWire's table of columns calls them: (hemisphere, p, q), for each.

    On the right these are taken to be the p and q of MaleCNS. The eye map archive gives columns of
    FlyWire the axes that it gives those of MaleCNS with p one less; Codex' column_assignment spans
    as many p and q (37 and 34) as that map, and begins one p before it. No row of Codex' table was
    seen. Where its left eye begins to count was not found out: p and q here are MaleCNS's.

    Example:
        >>> omma.columns.flywire_names(omma.columns.fly_columns())[-1]
        ('right', 14, 18)
    """
    expect_columns(columns)
    rows = zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist(), strict=True)
    return [("right" if side > 0 else "left", p, q) for side, p, q in rows]


@checked
def find_columns(columns: Columns, names: Sequence[str] | Sequence[tuple[str, int, int]]) -> Ints:
    """Where columns of these names are among ``columns``: (K,) indices, in the order of the names.

    Args:
        names: MaleCNS's, as "ME_R_col_18_19" (or LO, LOP), or FlyWire's, ("right", 0, 0).

    Example:
        >>> fly = omma.columns.fly_columns()
        >>> where = omma.columns.find_columns(fly, ["ME_R_col_18_19", "ME_L_col_18_19"])
        >>> fly.p[where].tolist(), fly.side[where].tolist()
        ([0, 0], [1, -1])

    Raises:
        omma.Error: what is no such name, as root ids of neurons; a column that is not among them,
            as those of the rim that have no measured axis.
    """
    expect_columns(columns)
    is_one = isinstance(names, tuple) and names[:1] in (("left",), ("right",))
    if is_one or isinstance(names, str) or not isinstance(names, Iterable):
        raise Error(f"names: expected a list of names of columns, found {names!r:.40}")
    keys = zip(columns.side.tolist(), columns.p.tolist(), columns.q.tolist(), strict=True)
    row_of = {key: k for k, key in enumerate(keys)}
    found = []
    for name in names:
        side, p, q = column_of_name(name)
        if (side, p, q) not in row_of:
            raise Error(
                f"names: {name!r:.40} is p = {p}, q = {q} of the {'right' if side > 0 else 'left'} "
                f"eye, which is none of these {len(columns)} columns; those at the rim of a lobe "
                "have no facet whose axis was measured"
            )
        found.append(row_of[side, p, q])
    return np.array(found, np.int64)


def column_of_name(name: object) -> tuple[int, int, int]:
    """(side, p, q) of a name of MaleCNS's, or of FlyWire's (hemisphere, p, q)."""
    if isinstance(name, (tuple, list)) and len(name) == 3 and name[0] in ("left", "right"):
        p, q = _whole(name[1], name), _whole(name[2], name)
        return (1 if name[0] == "right" else -1), p, q
    match = _NAME.fullmatch(name) if isinstance(name, str) else None
    if match is None:
        hint = ""
        if _ROOT_ID.fullmatch(str(name)):
            hint = "; a root id is a neuron of FlyWire, whose table of columns says its p and q"
        raise Error(
            "names: expected names of columns, as 'ME_R_col_18_19' (MaleCNS) or ('right', 0, 0) "
            f"(FlyWire), found {name!r:.60}{hint}"
        )
    p_, q_ = pq_from_hex([int(match[2])], [int(match[3])])
    return (1 if match[1] == "R" else -1), int(p_[0]), int(q_[0])


def _whole(value: ArrayLike, name: object) -> int:
    number = array_of(value, f"names, {name!r:.40}", (), np.int64)
    return int(number)
