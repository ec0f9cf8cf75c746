"""Tables that other programs wrote of a scan: CSV with a header, and plain lists of points."""

from __future__ import annotations

import csv
import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.files import PathLike

Floats = NDArray[np.float64]


class ScanTable:
    """A CSV file with a header, read as texts."""

    def __init__(self, name: str) -> None:
        self.name = name
        try:
            with open(name, encoding="utf-8-sig", newline="") as file:
                reader = csv.reader(file)
                rows = []
                self.lines = []
                for row in reader:
                    if row:
                        rows.append(row)
                        self.lines.append(reader.line_num)
        except OSError as error:
            raise Error(f"{name}: cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise Error(f"{name}: expected UTF-8 text, found other bytes") from None
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

    def texts(self, column: str) -> list[str]:
        at = self.columns.index(column)
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


def read_points(value: PathLike | ArrayLike, name: str) -> Floats:
    """(N, 3) numbers, from an array or a CSV file."""
    if isinstance(value, str | os.PathLike):
        name = os.fsdecode(value)
        points = _read_points(name)
    else:
        try:
            points = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise Error(f"{name}: expected numbers of shape (N, 3)") from None
    if points.ndim != 2 or points.shape[1] != 3:
        raise Error(f"{name}: expected numbers of shape (N, 3), found {points.shape}")
    if not np.isfinite(points).all():
        at = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise Error(f"{name}: expected finite numbers, found others at point {at}")
    if len(points) < 12:
        raise Error(f"{name}: expected at least 12 points, found {len(points)}")
    return points


def _read_points(name: str) -> Floats:
    try:
        with open(name, encoding="utf-8-sig") as file:
            first = file.readline().strip()
    except OSError as error:
        raise Error(f"{name}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise Error(f"{name}: expected UTF-8 text, found other bytes") from None
    separator = "," if "," in first else None
    try:
        [float(word) for word in first.split(separator)]
        header = False
    except ValueError:
        header = True
    columns: tuple[int, ...] | None = None
    if header:
        words = [word.strip().strip('"').lower().split("_")[0] for word in first.split(separator)]
        if not {"x", "y", "z"} <= set(words):
            raise Error(f"{name}, line 1: expected columns x, y, z, found {first[:60]!r}")
        columns = tuple(words.index(letter) for letter in "xyz")
    try:
        return np.loadtxt(
            name,
            delimiter=separator,
            skiprows=int(header),
            usecols=columns,
            ndmin=2,
            encoding="utf-8-sig",
        )
    except (ValueError, UnicodeDecodeError) as error:
        raise Error(f"{name}: expected three numbers a line: {error}") from None
