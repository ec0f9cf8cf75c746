"""Lines of numbers, of which each has to have as many as the others."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.beginnings import shown

# Of a text that is read at once.
_TEXT_BYTES = 1 << 25
_BLANK = bytes.maketrans(b",;", b"  ")


def numbers_in(text: bytes) -> Floats | None:
    """The numbers of a text, separated by blanks and line ends; None where there is more."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # what is no number ends NumPy's reading with a warning
        try:
            return np.fromstring(text, np.float64, sep=" ")
        except (DeprecationWarning, ValueError):
            return None


def words_in_lines(text: bytes) -> NDArray[np.intp]:
    """How many words each line has; the last line may have no end."""
    bytes_ = np.frombuffer(text if text.endswith(b"\n") else text + b"\n", np.uint8)
    is_blank = bytes_ <= 32
    begins = ~is_blank
    begins[1:] &= is_blank[:-1]
    ends = np.flatnonzero(bytes_ == 10)
    return np.diff(np.searchsorted(np.flatnonzero(begins), ends), prepend=0)


def line_error(path: str, number: int, expected: str, line: bytes) -> Error:
    """Of a line that is not as expected; the first of a file is 1."""
    return Error(f"{path}, line {number}: expected {expected}, found {shown(line)}")


def text_tables(
    path: str,
    begin: int,
    columns: int,
    *,
    skipped: int = 0,
    most: int | None = None,
    count: int | None = None,
    blank: bytes = _BLANK,
) -> Iterator[Floats]:
    """(n, columns) after some lines that are skipped; at most so many rows in all.

    With ``count`` the file says how many there are, and more where further blocks begin, each with
    a line of its own count. ``blank``: the table by which separators become blanks.

    Raises:
        omma.Error: a line of other text or of another number of columns, with its number; more or
            fewer rows than ``count``.
    """
    with open(path, "rb") as file:
        number = 1 + file.read(begin).count(b"\n") + skipped
        for _ in range(skipped):
            file.readline()
        rows = 0
        while most is None or rows < most:
            given = file.read(_TEXT_BYTES) + file.readline()
            if not given:
                break
            text = given.translate(blank)
            words = words_in_lines(text)
            if count is not None and (words == 1).any():
                text, more = _without_counts(text, words)
                count += more
            taken = np.flatnonzero(words)
            if not len(taken):
                number += len(words)
                continue
            if most is not None and len(taken) > most - rows:
                taken = taken[: most - rows]
                text = b"\n".join(text.split(b"\n", taken[-1] + 1)[:-1])
            numbers = numbers_in(text)
            if (
                numbers is None
                or (words[taken] != columns).any()
                or len(numbers) != columns * len(taken)
            ):
                lines, found = given.split(b"\n"), text.split(b"\n")
                bad = next(
                    k
                    for k in taken.tolist()
                    if len(found[k].split()) != columns or not are_numbers(found[k])
                )
                raise line_error(path, number + bad, f"{columns} numbers", lines[bad])
            number += len(words)
            rows += len(taken)
            yield numbers.reshape(-1, columns)
    if count is not None and rows != count:
        raise Error(f"{path}: expected {count:,} points, as it says itself, found {rows:,}")


def are_numbers(line: bytes) -> bool:
    """Whether all words of a line are numbers."""
    numbers = numbers_in(line)
    return numbers is not None and len(numbers) == len(line.split())


def _without_counts(text: bytes, words: NDArray[np.intp]) -> tuple[bytes, int]:
    """A text whose lines of one whole number are empty, as ``words`` then says too; their sum."""
    lines, total = text.split(b"\n"), 0
    for k in np.flatnonzero(words == 1).tolist():
        word = lines[k].strip()
        if word.isdigit():
            total += int(word)
            lines[k], words[k] = b"", 0
    return b"\n".join(lines), total
