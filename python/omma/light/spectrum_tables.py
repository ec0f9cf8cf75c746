"""Tables of spectra as spectrometers, databases and R write them, whatever is between numbers."""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error
from omma.base.arrays import Floats
from omma.base.files import PathLike
from omma.base.tables import decimal_point, has_decimal_comma, separator_of
from omma.base.warn import warn_caller

# The lines of Ocean Optics' and its successors' files between which the table is.
_BEGIN, _END = re.compile(r">+\s*Begin .*Spectral Data"), re.compile(r">+\s*End .*Spectral Data")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_MISSING = ("", "na", "nan", "n/a", "inf", "-inf", "∞", "-∞")
_WAVELENGTH = re.compile(r"(wl|wave|wavelengths?|lambda|λ|nm)([^a-z].*)?", re.IGNORECASE)
_UNIT = re.compile(r"\[.*\]")
_NANOMETRES = re.compile(r"[\[(]?(nm|nanomet(er|re)s?)[\])]?", re.IGNORECASE)


@dataclass(frozen=True)
class SpectrumTable:
    """Numbers (N, columns) of a file, what its columns are called, the line of each row, and the
    units of the columns where they have a line of their own, "" elsewhere."""

    path: str
    names: list[str]
    numbers: Floats
    lines: NDArray[np.int64]
    units: list[str]


def read_spectrum_table(path: PathLike) -> SpectrumTable:
    """The numbers of a text file as they stand there; NaN where there is none.

    Raises:
        omma.Error: it cannot be read or holds no such table; it names the line.
    """
    name = os.fsdecode(path)
    lines = [(n, line.strip(" ")) for n, line in enumerate(_text(path).splitlines(), start=1)]
    begin = next((k for k, (_, line) in enumerate(lines) if _BEGIN.search(line)), None)
    if begin is not None:
        lines = lines[begin + 1 :]
        lines = lines[: next((k for k, (_, line) in enumerate(lines) if _END.search(line)), None)]
    lines = [(n, line) for n, line in lines if line.strip() and not line.startswith("#")]
    if not lines:
        raise Error(f"{name}: expected a table of wavelengths and values, found no line of one")
    try:
        delimiter = _delimiter_of([line for _, line in lines])
        rows = list(csv.reader([line for _, line in lines], delimiter=delimiter,
                               skipinitialspace=True))  # fmt: skip
    except csv.Error as error:
        raise Error(f"{name}: cannot be read as a table: {error}") from None
    numbered = list(zip((n for n, _ in lines), _same_width(rows)))
    if delimiter == ",":
        _check_commas(name, numbered)
    comma = any(has_decimal_comma(cell) for _, row in numbered for cell in row)
    parsed = [(n, row, [_number(cell, comma) for cell in row]) for n, row in numbered]
    first = next(
        (k for k, (_, _, found) in enumerate(parsed) if len(found) > 1 and None not in found), None
    )
    for n, row, found in parsed[: len(parsed) if first is None else first]:
        if len(found) > 1 and found[0] is not None and not np.isnan(found[0]):
            raise _no_number(name, n, row, found)
    if first is None:
        raise Error(f"{name}: expected lines of wavelengths and values, found none")
    width = len(parsed[first][1])
    above = [row for _, row, _ in parsed[max(first - 2, 0) : first]]
    units = _units(above)
    if any(units):
        above = above[:1]
    names = _names(name, above, width)
    for n, row, found in parsed[first:]:
        if None in found:
            raise _no_number(name, n, row, found)
        if len(found) != width:
            raise Error(f"{name}, line {n}: expected {width} numbers, found {len(found)}")
    numbers = np.array([found for _, _, found in parsed[first:]], np.float64)
    if not above and _is_of_flowers(numbers):
        return _of_flowers(name, numbers, np.array([n for n, _, _ in parsed[first:]]))
    at = _wavelength_column(name, names)
    order = [at, *(k for k in range(width) if k != at and names[k] != _ROW_NAMES)]
    chosen = [names[k] for k in order]
    twice = next((one for one in chosen if chosen.count(one) > 1), None)
    if twice is not None:
        raise Error(f"{name}: expected columns of different names, found {twice!r} twice")
    if len(chosen) < 2:
        raise Error(f"{name}: expected a column of values beside the wavelengths, found none")
    units = units if len(units) == width else [""] * width
    return SpectrumTable(
        name,
        chosen,
        numbers[:, order],
        np.array([n for n, _, _ in parsed[first:]]),
        [units[k] for k in order],
    )


def _is_of_flowers(numbers: Floats) -> bool:
    """Whether lines are the number of a flower, a wavelength and a value."""
    if numbers.shape[1] != 3 or len(numbers) < 2 or numbers[0, 0] != numbers[1, 0]:
        return False
    return bool(np.all(np.mod(numbers[:, 0], 1) == 0) and numbers[:, 1].min() >= 100)


def _of_flowers(path: str, numbers: Floats, lines: NDArray[np.int64]) -> SpectrumTable:
    """Columns by the numbers of flowers, which all have the same wavelengths."""
    flowers = list(dict.fromkeys(numbers[:, 0].tolist()))
    rows = [np.flatnonzero(numbers[:, 0] == one) for one in flowers]
    nm = numbers[rows[0], 1]
    for one, own in zip(flowers, rows):
        if not np.array_equal(numbers[own, 1], nm):
            raise Error(
                f"{path}, line {lines[own[0]]}: expected flower {one:g} at the wavelengths of "
                f"flower {flowers[0]:g}, found others; expected a file for each"
            )
    columns = np.column_stack([nm, *(numbers[own, 2] for own in rows)])
    names = ["", *(f"{one:g}" for one in flowers)]
    return SpectrumTable(path, names, columns, lines[rows[0]], [""] * len(names))


# What a column of the numbers of rows, which R writes, is called here.
_ROW_NAMES = "\0rows"


def _text(path: PathLike) -> str:
    data = _core.read_file(path)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # instruments under Windows
        return data.decode("cp1252", "replace")


def _delimiter_of(lines: list[str]) -> str:
    """What is between the cells of most of the last lines of numbers: one of them may be cut."""
    found = [(_delimiter(line), len(line.split())) for line in lines[:-4:-1] if _NUMBER.match(line)]
    found = [one for one in found if one != (" ", 1)]
    delimiters = [delimiter for delimiter, _ in found] or [_delimiter(lines[-1])]
    return max(delimiters, key=delimiters.count)


def _delimiter(line: str) -> str:
    """What is between the cells of a line of numbers."""
    separator = separator_of(line)
    if separator != ",":
        return separator
    words = line.split()
    spaced = len(words) > 1 and all(
        _NUMBER.fullmatch(word) or has_decimal_comma(word) for word in words
    )
    return " " if spaced or "," not in line else ","


def _same_width(rows: list[list[str]]) -> list[list[str]]:
    """The cells of each line, without the empty ones that end all lines of numbers; so also of
    lines above these, where a name stands over such."""
    rows = [[cell.strip() for cell in row] for row in rows]
    used = [max((k for k, cell in enumerate(row, start=1) if cell), default=0) for row in rows]
    numbers = [
        k
        for k, row in enumerate(rows)
        if all(not cell or _NUMBER.fullmatch(decimal_point(cell)) for cell in row)
    ]
    width = max((used[k] for k in numbers), default=0)
    first = next((k for k in numbers if used[k] > 1), 0)
    for k in range(first):
        if used[k] <= len(rows[first]):
            used[k] = min(used[k], width)
    return [row[: max(end, min(width, len(row)), 1)] for row, end in zip(rows, used)]


def _check_commas(name: str, numbered: list[tuple[int, list[str]]]) -> None:
    """Refuses numbers whose decimal commas cannot be told from those between them: 300,6,123."""
    rows = [(n, row) for n, row in numbered if row and all(cell.isdecimal() for cell in row)]
    if len(rows) < 2:
        return
    above = [row for n, row in numbered if n < rows[0][0]]
    names = len(above[-1]) if above and is_wavelength_name(above[-1][0]) else 0
    width = len(rows[0][1])
    # A comma in each value, perhaps in wavelengths too, and no numbers of rows ahead of these; and
    # decimals may begin with a 0.
    is_wider = names > 1 and width in (2 * names - 1, 2 * names) and int(rows[0][1][0]) >= 100
    is_wider = is_wider and any(int(row[1]) < 100 for _, row in rows)
    zeros = (n for n, row in rows if any(len(cell) > 1 and cell[0] == "0" for cell in row[1:]))
    at = rows[0][0] if is_wider else next(zeros, None)
    if at is not None and not any("." in cell for _, row in numbered for cell in row[1:]):
        raise Error(
            f"{name}, line {at}: commas are between numbers and seem to be in them, so that it "
            "stays open which is which: write the file with semicolons or tabs between numbers, or "
            "with decimal points"
        )


def _number(cell: str, comma: bool) -> float | None:
    """NaN where there is no value, None where the cell is no number."""
    text = decimal_point(cell) if comma else cell
    if text.lower() in _MISSING:
        return float("nan")
    return float(text) if _NUMBER.fullmatch(text) else None


def _no_number(name: str, line: int, row: list[str], found: list[float | None]) -> Error:
    wrong = row[found.index(None)] if None in found else ""
    return Error(f"{name}, line {line}: expected numbers, found {wrong!r:.40}")


def _units(above: list[list[str]]) -> list[str]:
    """A line of units below one of names: where wavelengths are, it says nanometres alone."""
    if len(above) < 2 or len(above[0]) != len(above[1]):
        return []
    pairs = zip(*above)
    if any(is_wavelength_name(one) and _NANOMETRES.fullmatch(unit) for one, unit in pairs):
        # Avantes' brackets are a part of the name, `_names`.
        return [] if all(_UNIT.fullmatch(one) for one in above[1]) else above[1]
    return []


def _names(path: str, above: list[list[str]], width: int) -> list[str]:
    """What columns are called, by the lines above: names, and below them units in brackets as
    Avantes writes them. Warns where there are names, but not for these columns."""
    header = above[-1] if above else []
    if len(above) == 2 and len(above[0]) == len(header) and all(_UNIT.fullmatch(c) for c in header):
        header = [f"{one} {unit}" for one, unit in zip(*above)]
    if len(header) == width - 1 and header and _WAVELENGTH.fullmatch(header[0]):
        header = [_ROW_NAMES, *header]
    elif len(header) == width > 2 and header[0] == "" and _WAVELENGTH.fullmatch(header[1]):
        header = [_ROW_NAMES, *header[1:]]
    if len(header) != width:
        numbered = [f"column {k}" for k in range(2, width + 1)]
        names = ["", *([Path(path).stem] if width == 2 else numbered)]
        if len(header) > 1 and is_wavelength_name(header[0]):
            warn_caller(
                f"{path}: expected a name for each of {width} columns of numbers, found "
                f"{len(header)} names; its spectra are called {', '.join(names[1:]):.100}",
                UserWarning,
            )
        return names
    return [one or f"column {k}" for k, one in enumerate(header, start=1)]


def is_wavelength_name(name: str) -> bool:
    """Whether a column of this name has wavelengths."""
    return _WAVELENGTH.fullmatch(name) is not None


def _wavelength_column(path: str, names: list[str]) -> int:
    found = [k for k, one in enumerate(names) if is_wavelength_name(one)]
    if len(found) > 1:
        raise Error(
            f"{path}: expected one column of wavelengths, found "
            f"{', '.join(names[k] for k in found)}"
        )
    return found[0] if found else 0
