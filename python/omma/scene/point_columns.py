"""What the columns of a text file of points are, where its first line does not name them: by their
number, and by what they hold where that leaves a choice. And what separates them."""

from __future__ import annotations

import re

import numpy as np

from omma.base.arrays import Floats

# Of three columns and so on. .pts files have the intensity before the colour, CloudCompare behind.
BY_NUMBER = {
    3: "x y z", 4: "x y z intensity", 6: "x y z red green blue",
    7: "x y z intensity red green blue",
}  # fmt: skip
_NORMALS, _COLOUR_FIRST = "x y z nx ny nz", "x y z red green blue intensity"
# Normals are written to three digits and more.
_LENGTH_OFF = 0.02


def unnamed_columns(some: Floats, is_pts: bool) -> str:
    """The names of the columns of some points (n, columns), "" where there are none by rule."""
    count = some.shape[1]
    if count == 6 and _are_normals(some[:, 3:]):
        return _NORMALS
    if count == 7 and not is_pts and _are_bytes(some[:, 3:6]) and not _are_bytes(some[:, 6:]):
        return _COLOUR_FIRST
    return BY_NUMBER.get(count, "")


def may_be_otherwise(some: Floats, is_pts: bool) -> bool:
    """Whether colours may as well come before the intensity: all are whole numbers of 8 bits."""
    return some.shape[1] == 7 and not is_pts and _are_bytes(some[:, 3:])


def _are_normals(three: Floats) -> bool:
    """Whether columns are no colours: some are below 0, or all have the length of 1."""
    if (three < 0).any():
        return True
    lengths = np.linalg.norm(three, axis=1)
    return bool((np.abs(lengths - 1) < _LENGTH_OFF).all()) and len(np.unique(three)) > 1


def _are_bytes(columns: Floats) -> bool:
    return bool(((columns >= 0) & (columns <= 255) & (columns == np.rint(columns))).all())


def has_decimal_commas(lines: list[bytes]) -> bool:
    """Whether lines of numbers have both commas and other separators between them."""
    return any(re.search(rb"\d,\d+[ \t]*[;\t]", line) for line in lines)


def words_of(line: bytes, blank: bytes) -> list[str]:
    return line.translate(blank).decode("utf-8", "replace").replace('"', " ").split()


def rows_of(lines: list[bytes], blank: bytes, columns: int) -> Floats:
    """Those of some lines that are whole rows of numbers: (n, columns)."""
    words = [words_of(line, blank) for line in lines[:-1] or lines]
    rows = [one for one in words if len(one) == columns and all(map(is_number, one))]
    return np.array(rows, np.float64).reshape(-1, columns)


def is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
