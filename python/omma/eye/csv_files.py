"""Eyes from CSV files as others write them: with semicolons or tabs between cells, decimal commas,
gaps in what was measured, and names of columns that are not read.

The engine reads commas and points. What differs is written anew beside, line for line, and read
from there.
"""

from __future__ import annotations

import csv
import io
import os
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from omma import _core
from omma._core import Error, Eye
from omma.base.arrays import Floats
from omma.base.directions import angle_of_chord
from omma.base.files import PathLike, open_text
from omma.base.tables import MISSING, decimal_point, separator_of
from omma.base.warn import warn_caller
from omma.eye.alike_columns import instead_of_needed, left_unread

# What becomes of ommatidia without an acceptance angle and a kernel.
MISSING_ACCEPTANCE = ("refuse", "neighbours", "interommatidial")
# Of how many nearest ommatidia a gap is filled.
_NEAREST = 6
_ACCEPTANCE = "acceptance_angle_"
# What Excel reads in the first line of a file.
_SEPARATOR = re.compile(r"sep=.?", re.IGNORECASE)


@dataclass
class _Table:
    """The records of a CSV file, the header first, and the line that each begins in."""

    comments: str
    records: list[list[str]]
    lines: list[int]
    between: str

    @property
    def names(self) -> list[str]:
        """Of the columns."""
        return self.records[0]

    def gaps(self) -> list[int]:
        """Numbers of the ommatidia that have neither an acceptance angle nor a kernel."""
        column = self._column()
        kernel = self.names.index("kernel") if "kernel" in self.names else len(self.names)
        return [
            number
            for number, cells in enumerate(self.records[1:])
            if (column is None or (column < len(cells) and cells[column].lower() in MISSING))
            and (kernel >= len(cells) or not cells[kernel])
        ]

    def _column(self) -> int | None:
        """Which one has acceptance angles; None where there is none."""
        return next((k for k, one in enumerate(self.names) if one.startswith(_ACCEPTANCE)), None)

    def text(self, filled: list[int]) -> str:
        """With commas and points, each record in its line; those of ``filled`` have the angle 0, in
        a column made for it where there is none."""
        made = io.StringIO()
        made.write(self.comments)
        writer = csv.writer(made, lineterminator="\n")
        column = self._column()
        gaps = set(filled)
        line = self.lines[0]
        for number, (cells, at) in enumerate(zip(self.records, self.lines, strict=True), start=-1):
            made.write("\n" * (at - line))
            if number >= 0 and self.between != ",":
                cells = [decimal_point(cell) for cell in cells]
            if column is not None and number in gaps:
                cells = [*cells[:column], "0", *cells[column + 1 :]]
            elif column is None and filled:
                added = f"{_ACCEPTANCE}deg" if number < 0 else "0" if number in gaps else ""
                cells = [*cells, added]
            writer.writerow(cells)
            line = at + 1 + sum(cell.count("\n") for cell in cells)
        return made.getvalue()


def load_csv(path: PathLike, missing: str) -> Eye:
    """An eye from a CSV file; ``missing`` says what becomes of ommatidia without an acceptance
    angle: one of `MISSING_ACCEPTANCE`, or "0", which is theirs until they are given others.

    Raises:
        omma.Error: it cannot be read; it says what may help.
    """
    name = os.fsdecode(path)
    header = _header(path)
    between = "," if "," in header else separator_of(header)
    try:
        if between == "," and missing == "refuse" and _is_plain(path):
            eye = _core.load_eye(path, 1e-3, "")
        else:
            eye = _read_anew(_read(path, between), name, missing)
    except Error as error:
        raise Error(f"{error}{_hint(path, between, missing)}") from None
    for sentence in left_unread(_cells(header, between)):
        warn_caller(f"{name}: {sentence}", UserWarning)
    return eye


def _is_rest(line: str) -> bool:
    """Whether a line is what Excel leaves: `sep=;` at the top, or a row whose cells are empty."""
    return _SEPARATOR.fullmatch(line.strip()) is not None or (
        bool(line.strip()) and not line.strip(" \t\r\n,;")
    )


def _is_plain(path: PathLike) -> bool:
    """Whether the engine reads it as it is: UTF-8 without what Excel leaves."""
    text = open_text(path)
    return text.encoding == "utf-8-sig" and not any(_is_rest(line) for line in text)


def _header(path: PathLike) -> str:
    """The first line that is no comment; "" where there is none."""
    return next((one.strip() for one in open_text(path) if _is_header(one)), "")


def _is_header(line: str) -> bool:
    return bool(line.strip()) and not line.startswith("#") and not _is_rest(line)


def _cells(line: str, between: str) -> list[str]:
    try:
        read = next(csv.reader([line], delimiter=between, skipinitialspace=between != "\t"), [])
    except csv.Error:  # a cell of megabytes
        return []
    return [cell.strip() for cell in read]


def _read(path: PathLike, between: str) -> _Table:
    lines = list(open_text(path))
    first = next((k for k, one in enumerate(lines) if _is_header(one)), len(lines))
    before = [one if one.startswith("#") else "\n" for one in lines[:first]]
    records, begins = [], []
    for line, cells in _records(lines[first:], between, os.fsdecode(path), first):
        if any(cell.strip() for cell in cells):
            records.append([cell.strip() for cell in cells])
            begins.append(line)
    if not records:
        raise Error(f"{os.fsdecode(path)}: expected a header, found none")
    return _Table("".join(before), records, begins, between)


def _records(
    lines: list[str], between: str, name: str, before: int
) -> Iterator[tuple[int, list[str]]]:
    """The line that each record begins in, counted from 1 in the whole file, and its cells."""
    reader = csv.reader(lines, delimiter=between, skipinitialspace=between != "\t")
    while True:
        line = before + reader.line_num + 1
        try:
            cells = next(reader, None)
        except csv.Error as error:
            raise Error(f"{name}, line {line}: is not CSV: {error}") from None
        if cells is None:
            return
        yield line, cells


def _read_anew(table: _Table, name: str, missing: str) -> Eye:
    gaps = [] if missing == "refuse" else table.gaps()
    eye = _read_copy(table, name, gaps)
    if not gaps or missing == "0":
        return eye
    angle = (_of_neighbours if missing == "neighbours" else _as_far_as_neighbours)(eye, gaps)
    own = [eye.acceptances[k] if k >= 0 else None for k in eye.acceptance_of.tolist()]
    return eye.replace(acceptance_angle_rad=angle, acceptance=own)


def _read_copy(table: _Table, name: str, gaps: list[int]) -> Eye:
    """The eye as the engine reads it, with 0 in the gaps."""
    try:
        with tempfile.TemporaryDirectory(prefix="omma-eye-") as folder:
            copy = os.path.join(folder, "eye.csv")
            with open(copy, "w", encoding="utf-8", newline="") as file:
                file.write(table.text(gaps))
            try:
                eye = _core.load_eye(copy, 1e-3, "")
            except Error as error:
                raise Error(str(error).replace(copy, name)) from None
    except OSError as error:
        raise Error(f"{name}: cannot be written anew: {error.strerror}: {error.filename}") from None
    return eye.replace(path=name)


def _as_far_as_neighbours(eye: Eye, gaps: list[int]) -> Floats:
    """Acceptance angles (N,): where there are gaps the local interommatidial angles."""
    angle = eye.acceptance_angle_rad.astype(np.float64)
    apart = eye.interommatidial_angle_rad().astype(np.float64)[gaps]
    if not (apart > 0).all():
        raise Error(
            f"{eye.path}: expected an interommatidial angle in place of each acceptance angle that "
            f"lacks, found none of ommatidium {gaps[int(np.argmin(apart > 0))]}: it has no "
            "neighbour, or only ones with the same axis"
        )
    angle[gaps] = apart
    warn_caller(
        f"{eye.path}: {len(gaps):,} of {len(eye):,} ommatidia without an acceptance angle have "
        f"their interommatidial angle, {np.degrees(np.median(apart)):.3g} degrees in the median: "
        "it is assumed, not measured",
        UserWarning,
    )
    return angle


def _of_neighbours(eye: Eye, gaps: list[int]) -> Floats:
    """Acceptance angles (N,): where there are gaps the mean of those that look nearest."""
    angle = eye.acceptance_angle_rad.astype(np.float64)
    axis = eye.axis.astype(np.float64)
    known = (eye.acceptance_of < 0) & (angle > 0)
    known[gaps] = False
    farthest = 0.0
    for gap in gaps:
        others = np.flatnonzero(known & (eye.eye_id == eye.eye_id[gap]))
        if len(others) == 0:
            raise Error(
                f"{eye.path}: expected acceptance angles of some ommatidia of eye "
                f"{eye.eye_id[gap]}, found none to fill the others by"
            )
        chord = np.linalg.norm(axis[others] - axis[gap], axis=1)
        nearest = np.argsort(chord, kind="stable")[:_NEAREST]
        angle[gap] = angle[others[nearest]].mean()
        farthest = max(farthest, float(chord[nearest].max()))
    warn_caller(
        f"{eye.path}: {len(gaps):,} of {len(eye):,} ommatidia without an acceptance angle have the "
        f"mean of the {_NEAREST} with one that look nearest, up to "
        f"{np.degrees(angle_of_chord(np.array(farthest))):.3g} degrees off",
        UserWarning,
    )
    return angle


def _reads_filled(table: _Table, gaps: list[int]) -> bool:
    """Whether the gaps are all that is wrong with a file."""
    try:
        _read_copy(table, "", gaps)
    except Error:
        return False
    return True


def _hint(path: PathLike, between: str, missing: str) -> str:
    """What may help a file that was refused, for the end of the error."""
    try:
        table = _read(path, between)
    except Error:
        return ""
    alike = instead_of_needed(table.names)
    gaps = table.gaps()
    if alike or missing not in ("refuse", "neighbours") or not gaps:
        return alike
    if not _reads_filled(table, gaps):
        return ""
    every = len(table.records) - 1
    if len(gaps) < every and missing == "refuse":
        return (
            f"; {len(gaps):,} of {every:,} ommatidia lack one: "
            'load_eye(missing_acceptance="neighbours"), or omma eye convert --missing-acceptance '
            f"neighbours, gives them the mean of the {_NEAREST} that look nearest"
        )
    told = (
        f"; none of {every:,} ommatidia has one"
        if len(gaps) == every
        else f"; {len(gaps):,} of {every:,} ommatidia lack one"
    )
    return (
        f'{told}: load_eye(missing_acceptance="interommatidial"), or omma eye convert '
        "--missing-acceptance interommatidial, gives them the angles to their neighbours; omma eye "
        "acceptance --degrees or --ratio sets those of all"
    )
