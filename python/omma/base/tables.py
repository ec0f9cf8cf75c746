"""Tables of numbers with named columns from CSV files, and full grids among them."""

from __future__ import annotations

import csv
import io
import math
import os
import re
from array import array
from collections.abc import Callable, Iterable, Sequence
from importlib.resources import files
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.files import PathLike, open_text

# How programs write that a number is not known, in small letters.
MISSING = ("", "nan", "na", "n/a", "none", "null")
# Of tables with commas between cells.
_COMMAS = "decimals have points where commas separate the cells, or commas where semicolons do"
# How tables call what is t_s, and which way a head looks, without a unit.
TIMES = ("t", "time", "timestamp", "timestamps", "datetime", "date", "utc", "seconds", "sec")
HEADINGS = ("heading", "bearing", "yaw", "azimuth", "orientation", "direction", "theta")
# A number with a decimal comma.
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(e[+-]?\d+)?", re.IGNORECASE)


def separator_of(line: str) -> str:
    """What is between the cells of a table, by one of its lines: semicolons or tabs where it has
    some, else commas."""
    return next((one for one in ";\t" if one in line), ",")


def has_decimal_comma(cell: str) -> bool:
    """Whether a cell is a number with a decimal comma."""
    return _DECIMAL_COMMA.fullmatch(cell) is not None


def decimal_point(cell: str) -> str:
    """A cell, whose decimal comma is a point then."""
    return cell.replace(",", ".") if has_decimal_comma(cell) else cell


def read_table(
    path: PathLike,
    headers: Sequence[tuple[str, ...]],
    row: str,
    *,
    missing: bool = False,
    remedy: Callable[[tuple[str, ...]], str] = lambda columns: "",
) -> tuple[tuple[str, ...], Floats, Sequence[int]]:
    """Of a CSV file the names of its columns, one of ``headers``, the rows (N, columns) in that
    order, and the number of each one's line; ``row`` is what one of them is called. A cell that is
    empty or NaN is NaN with ``missing``, else refused. Of other columns ``remedy`` may say what to
    do about them.

    Columns may come in any order. Their names say what separates them, commas, semicolons or tabs;
    decimals may have commas where these do not. Empty lines, and what follows a #, are passed over.

    Raises:
        omma.Error: the file cannot be read or is no such table; it names the line.
    """
    name = os.fsdecode(path)
    columns: tuple[str, ...] = ()
    header: tuple[str, ...] = ()
    between = ","
    numbers = array("d")  # 8 bytes a number: a million poses are few
    lines = array("q")
    for number, full in enumerate(open_text(path), start=1):
        line, where = full.split("#", 1)[0].strip(), f"{name}, line {number}"
        if not line:
            continue
        if not columns:
            between = separator_of(line)
        try:
            read = csv.reader([line], delimiter=between, skipinitialspace=between != "\t")
            cells = [cell.strip() for cell in next(read)]
        except csv.Error as error:
            raise Error(f"{where}: is not CSV: {error}") from None
        if not columns:
            columns = tuple(cell.lower() for cell in cells)
            header = next((one for one in headers if sorted(one) == sorted(columns)), ())
            if not header:
                expected = " or ".join(",".join(header) for header in headers)
                advice = remedy(columns)
                raise Error(
                    f"{where}: expected a header line {expected}, found '{line[:60]}'"
                    + (f"; {advice}" if advice else "")
                )
            continue
        if len(cells) != len(columns):
            word = {",": "commas", ";": "semicolons", "\t": "tabs"}[between]
            comma = f"; {_COMMAS}" if between == "," and len(cells) > len(columns) else ""
            raise Error(
                f"{where}: expected {len(columns)} numbers separated by {word}, found "
                f"{len(cells)}{comma}"
            )
        if between != ",":
            cells = [decimal_point(cell) for cell in cells]
        numbers.extend(map(_number, cells, columns, repeat(where), repeat(missing)))
        lines.append(number)
    if not numbers:
        raise Error(f"{name}: holds no {row}")
    order = [columns.index(one) for one in header]
    return header, np.array(numbers).reshape(-1, len(columns))[:, order], lines


def check_growing(name: str, times_s: Floats, lines: Sequence[int] | NDArray[np.int64]) -> None:
    """omma.Error where times (P,), s, in lines of a table do not grow; it names the line."""
    wrong = np.flatnonzero(np.diff(times_s) <= 0)
    if len(wrong) > 0:
        row = int(wrong[0]) + 1
        raise Error(
            f"{name}, line {lines[row]}: expected times that grow, found t_s {times_s[row]:.10g} "
            f"after {times_s[row - 1]:.10g} in line {lines[row - 1]}"
        )


def stems_of(columns: Iterable[str]) -> dict[str, str]:
    """Columns by their names without a unit."""
    return {re.split(r"[^a-z]", one)[0]: one for one in columns}


def say_units(columns: Sequence[str], known: dict[str, str]) -> str:
    """What columns with other units, or without one, would be called; "" where none is.

    Args:
        known: what columns are called, by their names without a unit. Of those that are called the
            same the first that is there counts.
    """
    stems = stems_of(columns)
    found = {name: stems[stem] for stem, name in reversed(known.items()) if stem in stems}
    other = [
        f"{name} for {found[name]}"
        for name in dict.fromkeys(known.values())
        if name in found and name not in columns
    ]
    return f"columns are in seconds, metres and degrees: {', '.join(other)}" if other else ""


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


def _number(cell: str, column: str, where: str, missing: bool) -> float:
    if missing and cell.lower() in MISSING:
        return math.nan
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        advice = f"; {_COMMAS}" if has_decimal_comma(cell) else ""
        if column == "t_s" and ":" in cell:
            advice = "; t_s is in seconds, from any moment on, not a date or a time of day"
        raise Error(
            f"{where}, column {column}: expected a finite number, found '{cell[:40]}'{advice}"
        )
    return value


def csv_text(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A table as CSV: what `read_table` reads, where all cells are numbers."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()


def packaged_rows(package: str, name: str) -> list[dict[str, str]]:
    """The rows of a CSV file that comes with a subpackage, by column; lines that begin with # are
    passed over."""
    text = files(package).joinpath(name).read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
