"""Tables that other programs wrote of a scan: CSV with a header, and plain lists of points."""

from __future__ import annotations

import csv
import os
import re

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error
from omma.base.arguments import array_of
from omma.base.arrays import Floats
from omma.base.files import METRES_PER_UNIT, PathLike, open_text
from omma.base.tables import decimal_point

# Units as programs write them: µ is the micro sign or the Greek letter.
UNITS = METRES_PER_UNIT | {"\u00b5m": 1e-6, "\u03bcm": 1e-6, "nm": 1e-9}
# Columns of points in three dimensions as napari writes them: its axes are those of an image's
# array, planes first.
_NAPARI = {"axis-0": "z", "axis-1": "y", "axis-2": "x"}
_EXPECTED = (
    "expected columns x, y, z, or Position X, Position Y, Position Z, or napari's axis-0, axis-1, "
    "axis-2"
)


class ScanTable:
    """A CSV file with a header, read as texts."""

    def __init__(self, name: str) -> None:
        self.name = name
        try:
            reader = csv.reader(open_text(name))
            rows = []
            self.lines = []
            for row in reader:
                if row:
                    rows.append(row)
                    self.lines.append(reader.line_num)
        except csv.Error as error:
            raise Error(f"{name}: is not CSV: {error}") from None
        if len(rows) < 2:
            raise Error(f"{name}: expected a header and a line for each point, found none")
        self.columns = [cell.strip() for cell in rows[0]]
        for row, line in zip(rows, self.lines, strict=True):
            if len(row) != len(self.columns):
                raise Error(
                    f"{name}, line {line}: expected {len(self.columns)} cells, found {len(row)}"
                )
        self.rows = rows[1:]
        self.lines = self.lines[1:]
        # Of columns with one name the first; looked up, as files with many thousands exist.
        self._at = {name: i for i, name in reversed(list(enumerate(self.columns)))}

    def drop(self, rows: NDArray[np.bool_]) -> None:
        """Leaves out the rows that ``rows`` (N,) says."""
        kept = np.flatnonzero(~rows)
        self.rows = [self.rows[i] for i in kept]
        self.lines = [self.lines[i] for i in kept]

    def texts(self, column: str) -> list[str]:
        at = self._at[column]
        return [row[at] for row in self.rows]

    def numbers(self, column: str) -> Floats:
        """(N,); nan where a cell is empty."""
        values = np.full(len(self.rows), np.nan)
        for i, text in enumerate(self.texts(column)):
            try:
                if text.strip():
                    values[i] = float(text)
            except ValueError:
                raise Error(
                    f"{self.name}, line {self.lines[i]}, column {column}: expected a number, "
                    f"found {text[:24]!r}"
                ) from None
        return values

    def vectors(self, column: str) -> Floats:
        """(N, 3), from texts such as "[0.1, 0.2, nan]"."""
        values = np.empty((len(self.rows), 3))
        for i, text in enumerate(self.texts(column)):
            words = text.strip().strip("[]").replace(",", " ").split()
            try:
                values[i] = [float(word) for word in words]
            except ValueError:
                raise Error(
                    f"{self.name}, line {self.lines[i]}, column {column}: expected three numbers "
                    f"in brackets, found {text[:40]!r}"
                ) from None
        return values

    def extra(self, column: str) -> Floats | list[str]:
        try:
            return self.numbers(column)
        except Error:
            return self.texts(column)


def read_points(value: PathLike | ArrayLike, name: str, metres: float | None) -> Floats:
    """(N, 3) positions in metres, from an array or a text file.

    Args:
        metres: those of the numbers; None for the unit that the file says, else micrometres.
    """
    said = None
    if isinstance(value, str | os.PathLike):
        name = os.fsdecode(value)
        points, said = _read_points(name, metres is None)
    else:
        points = array_of(value, name)
    if points.ndim != 2 or points.shape[1] != 3:
        raise Error(f"{name}: expected numbers of shape (N, 3), found {points.shape}")
    if not np.isfinite(points).all():
        at = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise Error(f"{name}: expected finite numbers, found others at point {at}")
    if len(points) < 12:
        raise Error(f"{name}: expected at least 12 points, found {len(points)}")
    return points * (metres or said or METRES_PER_UNIT["um"])


def _read_points(name: str, with_unit: bool) -> tuple[Floats, float | None]:
    """(N, 3) numbers as they are in the file, and the metres of the unit it says, if it does."""
    lines = _lines(name)
    # Imaris writes a title and a line of ==== above the header.
    for start, (_, line) in enumerate(lines[:6]):
        separator = _separator(line)
        words = _cells(line, separator)
        named = _columns(name, lines[start][0], words)
        if named or _all_numbers(words):
            break
    else:
        number, line = lines[0] if lines else (1, "")
        raise Error(f"{name}, line {number}: {_EXPECTED}, found {line[:60]!r}")
    if not named and start > 0:
        # As many words as numbers below are names of columns, no title.
        number, line = lines[start - 1]
        if not line.lstrip().startswith("#") and len(_cells(line, separator)) == len(words):
            raise Error(f"{name}, line {number}: {_EXPECTED}, found {line[:60]!r}")
    at, said = (named[0], named[1]) if named else ([0, 1, 2], None)
    unit_column = next((i for i, word in enumerate(words) if word.lower() == "unit"), None)
    points: list[list[float]] = []
    units: dict[str, int] = {}
    for number, line in lines[start + bool(named) :]:
        cells = _cells(line, separator)
        if not named and len(cells) != 3:
            raise Error(f"{name}, line {number}: expected three numbers, found {line[:60]!r}")
        try:
            points.append([float(cells[i]) for i in at])
        except (IndexError, ValueError):
            raise Error(
                f"{name}, line {number}: expected three numbers, found {line[:60]!r}"
            ) from None
        if named and unit_column is not None and unit_column < len(cells):
            units.setdefault(cells[unit_column], number)
    if with_unit and units:
        said = _one_unit(name, units)
    return np.array(points, dtype=np.float64).reshape(-1, 3), said


def _separator(line: str) -> str | None:
    """What is between the numbers of a line, or the names of a header; None: spaces."""
    if _all_numbers(_cells(line, None)):  # which may have decimal commas
        return None
    return next((one for one in (";", "\t", ",") if one in line), None)


def _cells(line: str, separator: str | None) -> list[str]:
    """The cells of a line, with decimal points; None is for spaces between them."""
    cells = [cell.strip().strip('"') for cell in line.split(separator)]
    return cells if separator == "," else [decimal_point(cell) for cell in cells]


def _lines(name: str) -> list[tuple[int, str]]:
    """The lines of a text file that are not empty, with their numbers from 1."""
    data = _core.read_file(name)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Programs on Windows write µ in its own code page; all else in such a file is ASCII.
        text = data.decode("latin-1")
    if "\0" in text:
        raise Error(f"{name}: expected text, found other bytes")
    lines = enumerate(text.splitlines(), start=1)
    return [(number, line) for number, line in lines if line.strip(" \t,;")]


def _columns(name: str, line: int, words: list[str]) -> tuple[list[int], float | None] | None:
    """Where x, y and z are in a header, and the metres of the unit behind their names; None where
    the words are no header."""
    found: dict[str, list[tuple[int, str]]] = {"x": [], "y": [], "z": []}
    for i, word in enumerate(words):
        if word in _NAPARI and "axis-3" not in words:  # with which the first one is time
            found[_NAPARI[word]].append((i, ""))
        match = re.fullmatch(r"(?:position[ ._])?([xyz])(?:_(\w+))?", word, re.IGNORECASE)
        if match:
            found[match[1].lower()].append((i, match[2] or ""))
    if not all(found.values()):
        return None
    for letter, columns in found.items():
        if len(columns) > 1:
            several = ", ".join(words[i] for i, _ in columns)
            raise Error(f"{name}, line {line}: expected one column {letter}, found {several}")
    units = {found[letter][0][1].lower() for letter in "xyz"} & UNITS.keys()
    if len(units) > 1:
        raise Error(f"{name}, line {line}: expected one unit, found {', '.join(sorted(units))}")
    return [found[letter][0][0] for letter in "xyz"], UNITS[units.pop()] if units else None


def _all_numbers(words: list[str]) -> bool:
    try:
        [float(word) for word in words]
    except ValueError:
        return False
    return True


def _one_unit(name: str, units: dict[str, int]) -> float:
    """Metres of the unit of a column, of which ``units`` has all cells and the first line each is
    in."""
    for text, line in units.items():
        if text.lower() not in UNITS:
            raise Error(
                f"{name}, line {line}, column Unit: expected um, µm, mm, m or nm, found "
                f"{text[:24]!r}; unit (--scan-unit) says it instead"
            )
    if len({UNITS[text.lower()] for text in units}) > 1:
        raise Error(f"{name}, column Unit: expected one unit, found {', '.join(units)}")
    return UNITS[next(iter(units)).lower()]
