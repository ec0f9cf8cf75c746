"""Tables of numbers with named columns from CSV files, and full grids among them."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.files import PathLike, open_text

Floats = NDArray[np.float64]


def read_table(path: PathLike, *headers: Sequence[str]) -> tuple[list[str], Floats]:
    """The header of a CSV file, which is one of ``headers``, and its numbers (N, columns).

    Lines that begin with # are passed over.

    Raises:
        omma.Error: the file cannot be read or is no such table; it names the line.
    """
    name = os.fsdecode(path)
    lines = [
        (n, line)
        for n, line in enumerate(open_text(path), start=1)
        if line.strip() and not line.startswith("#")
    ]
    try:
        rows = [(n, next(csv.reader([line], skipinitialspace=True))) for n, line in lines]
    except csv.Error as error:
        raise Error(f"{name}: is not CSV: {error}") from None
    header = [word.strip() for word in rows[0][1]] if rows else []
    if header not in [list(known) for known in headers]:
        expected = " or ".join(", ".join(known) for known in headers)
        raise Error(f"{name}: expected the columns {expected}, found {', '.join(header) or 'none'}")
    table = [_numbers(words, len(header), f"{name}, line {n}") for n, words in rows[1:]]
    if not table:
        raise Error(f"{name}: expected at least one line of numbers")
    return header, np.array(table)


def as_grid(path: PathLike, table: Floats, across: str, upwards: str) -> tuple[Floats, ...]:
    """Of a table whose first two columns are coordinates: those across (A,) and upwards (E,),
    ascending, and for each further column its values (E, A).

    Raises:
        omma.Error: a pair of coordinates is missing or there twice.
    """
    columns, column = np.unique(table[:, 0], return_inverse=True)
    rows, row = np.unique(table[:, 1], return_inverse=True)
    cell = row * len(columns) + column
    filled = np.bincount(cell, minlength=len(columns) * len(rows))
    if (filled != 1).any():
        wrong = int(np.flatnonzero(filled != 1)[0])
        raise Error(
            f"{os.fsdecode(path)}: expected one line for each of {len(columns)} {across} at each "
            f"of {len(rows)} {upwards}, found {filled[wrong]} for "
            f"{columns[wrong % len(columns)]:g}, {rows[wrong // len(columns)]:g}"
        )
    grids = []
    for values in table[:, 2:].T:
        grid = np.empty(len(cell))
        grid[cell] = values
        grids.append(grid.reshape(len(rows), -1))
    return (columns, rows, *grids)


def _numbers(words: list[str], count: int, where: str) -> list[float]:
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) != count or not all(math.isfinite(value) for value in values):
        raise Error(f"{where}: expected {count} numbers, found {','.join(words)!r:.60}")
    return values
