"""Spectra from tables that spectrometers, databases and R write: a column of wavelengths, and
columns of values.

What a file leaves open, per cent or fractions, is decided by a rule and said in a warning; what
cannot be right is an error that names the line.
"""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error, Spectrum
from omma.base.arguments import checked, one_of
from omma.base.arrays import Floats
from omma.base.files import PathLike
from omma.base.warn import warn_caller

SpectrumUnit = Literal["fraction", "percent", "as_is"]

# The lines of Ocean Optics' and its successors' files between which the table is.
_BEGIN, _END = re.compile(r">+\s*Begin .*Spectral Data"), re.compile(r">+\s*End .*Spectral Data")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(e[+-]?\d+)?", re.IGNORECASE)
_MISSING = ("", "na", "nan", "n/a", "inf", "-inf", "∞", "-∞")
_WAVELENGTH = re.compile(r"(wl|wave|wavelengths?|lambda|λ|nm)([^a-z].*)?", re.IGNORECASE)
_UNIT = re.compile(r"\[.*\]")
_PERCENT = re.compile(r"%|per ?cent", re.IGNORECASE)

# No reflectance is larger but of gloss, and no per cents of anything but black are smaller.
_MOST_FRACTION, _LEAST_PERCENT = 1.0, 1.5
# Noise about 0: of a reflectance, and as a share of the largest of other values.
_NOISE = 0.05


@dataclass(frozen=True)
class _Table:
    """Numbers (N, columns) of a file, what its columns are called and the line of each row."""

    path: str
    names: list[str]
    numbers: Floats
    lines: NDArray[np.int64]


@checked
def load_spectra(
    path: PathLike,
    *,
    unit: SpectrumUnit | None = None,
    columns: Sequence[str] | None = None,
    range_nm: tuple[float, float] | None = None,
) -> dict[str, Spectrum]:
    """Spectra of a text file by the names of their columns.

    Tables with a column of wavelengths in nm (called wl, wavelength, lambda or nm, or else the
    first) and one or more of values: comma, semicolon, tab or spaces between them, points or
    commas as decimal signs, with or without a line of names, after any lines of an instrument and
    lines that begin with #. So are CSV, tables of the R package pavo with or without row names, and
    text files of Ocean Optics (">>>>>Begin Spectral Data<<<<<") and Avantes, and downloads of the
    Floral Reflectance Database (lines of a flower's number, by which its spectrum is called, a
    wavelength and a value). Without names a spectrum is called as the file, or "column 2" and so
    on. Wavelengths that all descend are turned round.

    Args:
        unit: "percent", divided by 100; "fraction"; "as_is", whatever the numbers are, such as an
            irradiance. None: reflectances, per cent where a name says so (% or percent) or where
            any is above 1.5, fractions where none is above 1; a warning says which was taken.
        columns: names of those that are wanted. None: all.
        range_nm: from where to where, nm, linear between the file's wavelengths; what the file has
            beyond is not looked at, such as the noise at the ends of a spectrometer. None: all.

    Returns:
        Name to spectrum, in the file's order. Values of at least -0.05 (of other numbers: -5 % of
        the column's largest) are noise about 0 and become 0, of which a warning tells.

    Example:
        >>> with open("petals.csv", "w") as file:
        ...     _ = file.write("wl,white,red\\n300,5,3\\n500,70,4\\n700,72,61\\n")
        >>> petals = omma.light.load_spectra("petals.csv", unit="percent")
        >>> petals["red"]
        <omma.light.Spectrum of 3 values from 300 to 700 nm>

    Raises:
        omma.Error: a file that cannot be read or holds no such table, cells that are no numbers,
            wavelengths that do not ascend, are there twice or are not nanometres, a range beyond
            them, values that are negative beyond noise or neither fractions nor per cent; it names
            the file and, where there is one, the line.
    """
    if unit is not None:
        one_of(unit, ("fraction", "percent", "as_is"), "unit")
    table = _in_range(_ascending(_read(path)), range_nm)
    if isinstance(columns, str):
        columns = [columns]
    wanted = table.names[1:] if columns is None else list(columns)
    index = [1 + table.names[1:].index(one_of(n, table.names[1:], "columns")) for n in wanted]
    missing = np.argwhere(~np.isfinite(table.numbers[:, index]))
    if len(missing):
        row, column = missing[0]
        raise Error(
            f"{table.path}, line {table.lines[row]}: expected a number, found none of "
            f"{wanted[column]!r} at {table.numbers[row, 0]:g} nm; columns= and range_nm= leave out "
            "what is not wanted"
        )
    values = table.numbers[:, index] / _divisor(table, index, unit)
    values = _without_noise(table, wanted, values, unit)
    return {name: Spectrum(table.numbers[:, 0], one) for name, one in zip(wanted, values.T)}


def _read(path: PathLike) -> _Table:
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
        rows = list(csv.reader([line for _, line in lines], delimiter=_delimiter(lines[-1][1]),
                               skipinitialspace=True))  # fmt: skip
    except csv.Error as error:
        raise Error(f"{name}: cannot be read as a table: {error}") from None
    numbered = [(n, _cells(row)) for (n, _), row in zip(lines, rows)]
    comma = any(_DECIMAL_COMMA.fullmatch(cell) for _, row in numbered for cell in row)
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
    names = _names(above, width, Path(name).stem)
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
    return _Table(name, chosen, numbers[:, order], np.array([n for n, _, _ in parsed[first:]]))


def _is_of_flowers(numbers: Floats) -> bool:
    """Whether lines are the number of a flower, a wavelength and a value."""
    if numbers.shape[1] != 3 or len(numbers) < 2 or numbers[0, 0] != numbers[1, 0]:
        return False
    return bool(np.all(np.mod(numbers[:, 0], 1) == 0) and numbers[:, 1].min() >= 100)


def _of_flowers(path: str, numbers: Floats, lines: NDArray[np.int64]) -> _Table:
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
    return _Table(path, ["", *(f"{one:g}" for one in flowers)], columns, lines[rows[0]])


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


def _delimiter(line: str) -> str:
    """What is between the cells of a line of numbers."""
    for sign in "\t;":
        if sign in line:
            return sign
    words = line.split()
    spaced = len(words) > 1 and all(
        _NUMBER.fullmatch(word) or _DECIMAL_COMMA.fullmatch(word) for word in words
    )
    return " " if spaced or "," not in line else ","


def _cells(row: list[str]) -> list[str]:
    cells = [cell.strip() for cell in row]
    while len(cells) > 1 and not cells[-1]:
        cells.pop()
    return cells


def _number(cell: str, comma: bool) -> float | None:
    """NaN where there is no value, None where the cell is no number."""
    text = cell.replace(",", ".") if comma and _DECIMAL_COMMA.fullmatch(cell) else cell
    if text.lower() in _MISSING:
        return float("nan")
    return float(text) if _NUMBER.fullmatch(text) else None


def _no_number(name: str, line: int, row: list[str], found: list[float | None]) -> Error:
    wrong = row[found.index(None)] if None in found else ""
    return Error(f"{name}, line {line}: expected numbers, found {wrong!r:.40}")


def _names(above: list[list[str]], width: int, stem: str) -> list[str]:
    """What columns are called, by the lines above: names, and below them units in brackets as
    Avantes writes them."""
    header = above[-1] if above else []
    if len(above) == 2 and len(above[0]) == len(header) and all(_UNIT.fullmatch(c) for c in header):
        header = [f"{one} {unit}" for one, unit in zip(*above)]
    if len(header) == width - 1 and header and _WAVELENGTH.fullmatch(header[0]):
        header = [_ROW_NAMES, *header]
    elif len(header) == width > 2 and header[0] == "" and _WAVELENGTH.fullmatch(header[1]):
        header = [_ROW_NAMES, *header[1:]]
    if len(header) != width:
        return ["", stem] if width == 2 else ["", *(f"column {k}" for k in range(2, width + 1))]
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


def _ascending(table: _Table) -> _Table:
    """The table with wavelengths that ascend; omma.Error where they cannot be nanometres."""
    nm = table.numbers[:, 0]
    if len(nm) > 1 and np.all(np.diff(nm) < 0):
        table = _Table(table.path, table.names, table.numbers[::-1], table.lines[::-1])
        nm = table.numbers[:, 0]
    wrong = np.flatnonzero(~(np.diff(nm, prepend=-np.inf) > 0))
    if len(wrong):
        k = int(wrong[0])
        before = "" if k == 0 else f" after {nm[k - 1]:g}"
        raise Error(
            f"{table.path}, line {table.lines[k]}: expected wavelengths that ascend, each once, "
            f"found {nm[k]:g}{before} nm"
        )
    if not (nm[0] >= 100 and nm[-1] <= 5000):
        what = ", which look like micrometres: multiply by 1000" if nm[-1] < 10 else ""
        raise Error(
            f"{table.path}: expected wavelengths of 100 to 5000 nm, found {nm[0]:g} to "
            f"{nm[-1]:g}{what}"
        )
    return table


def _in_range(table: _Table, range_nm: tuple[float, float] | None) -> _Table:
    nm = table.numbers[:, 0]
    if range_nm is None:
        if len(nm) < 2:
            raise Error(f"{table.path}: expected two wavelengths or more, found {len(nm)}")
        return table
    if np.shape(range_nm) != (2,) or not range_nm[0] < range_nm[1]:
        raise Error(f"range_nm: expected two wavelengths, low and high, found {range_nm!r:.40}")
    low, high = (float(end) for end in range_nm)
    if nm[0] > low or nm[-1] < high:
        raise Error(
            f"range_nm: expected wavelengths that {table.path} has, {nm[0]:g} to {nm[-1]:g} nm, "
            f"found {low:g} to {high:g}"
        )
    inside = (nm > low) & (nm < high)
    ends = []
    for end, near in (
        (low, np.argmin(nm < low)),
        (high, len(nm) - 1 - np.argmax(nm[::-1] <= high)),
    ):
        row = [end, *(np.interp(end, nm, one) for one in table.numbers[:, 1:].T)]
        ends.append((np.array(row), table.lines[near]))
    return _Table(
        table.path,
        table.names,
        np.vstack([ends[0][0], table.numbers[inside], ends[1][0]]),
        np.array([ends[0][1], *table.lines[inside], ends[1][1]]),
    )


def _divisor(table: _Table, index: list[int], unit: str | None) -> float:
    """What numbers are divided by."""
    largest = float(table.numbers[:, index].max(initial=0.0))
    if unit is None:
        if any(_PERCENT.search(table.names[k]) for k in index):
            unit = "percent"
        else:
            unit = _guessed_unit(table.path, largest)
    divisor = 100.0 if unit == "percent" else 1.0
    if unit != "as_is" and largest / divisor > _LEAST_PERCENT:
        raise Error(
            f"{table.path}: expected reflectances of at most {_LEAST_PERCENT:g}, found "
            f"{largest / divisor:g} (of {unit}); columns= and range_nm= leave out what is not "
            'wanted, unit="as_is" takes other numbers, such as irradiances, as they stand'
        )
    return divisor


def _guessed_unit(path: str, largest: float) -> str:
    if _MOST_FRACTION < largest <= _LEAST_PERCENT:
        raise Error(
            f"{path}: expected reflectances that are fractions, up to 1, or per cent, above 1.5, "
            f'found {largest:g} as the largest, which may be either; say unit="fraction" or '
            'unit="percent"'
        )
    unit = "percent" if largest > _LEAST_PERCENT else "fraction"
    words = "per cent" if unit == "percent" else "fractions"
    warn_caller(
        f"{path}: its values, up to {largest:.4g}, are taken as {words}; unit={unit!r} says so",
        UserWarning,
    )
    return unit


def _without_noise(table: _Table, names: list[str], values: Floats, unit: str | None) -> Floats:
    """Values of at least 0; omma.Error where one is below what noise may be."""
    lowest = np.full(len(names), -_NOISE)
    if unit == "as_is":
        lowest *= values.max(axis=0, initial=0.0)
    wrong = np.argwhere(values < lowest)
    if len(wrong):
        row, column = wrong[0]
        raise Error(
            f"{table.path}, line {table.lines[row]}: expected values of at least "
            f"{lowest[column]:.3g}, which is noise, found {values[row, column]:.4g} of "
            f"{names[column]!r} at {table.numbers[row, 0]:g} nm; range_nm= leaves out noisy ends"
        )
    below = values < 0
    if below.any():
        warn_caller(
            f"{table.path}: {np.count_nonzero(below)} values below 0, down to {values.min():.3g}, "
            "are taken as 0",
            UserWarning,
        )
    return np.where(values > 0, values, 0.0)  # no negative zeros
