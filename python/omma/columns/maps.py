"""Published maps of where columns look, from CSV and JSON files: their names for the coordinates,
the side and the direction are known in many spellings, and what was taken for what is kept.
"""

from __future__ import annotations

import csv
import json
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from omma._core import Error
from omma.base.arguments import checked, one_of
from omma.base.arrays import Floats, Ints
from omma.base.files import PathLike, check_ending, open_text
from omma.columns.coordinates import pq_from_hex
from omma.columns.lattice import Columns

Rows = list[tuple[str, Mapping[str, Any]]]  # where in the file, and what is there

# Of each quantity the names it may have, in small letters and without signs.
_NAMES = {
    "p": ("p", "pid", "hexp"),
    "q": ("q", "qid", "hexq"),
    "hex1": ("hex1", "hex1id"),
    "hex2": ("hex2", "hex2id"),
    "side": ("side", "hemisphere", "eye", "eyeside"),
    "x": ("x", "dirx", "directionx", "viewx", "axisx"),
    "y": ("y", "diry", "directiony", "viewy", "axisy"),
    "z": ("z", "dirz", "directionz", "viewz", "axisz"),
    "azimuth": ("azimuth", "az", "azimuthdeg", "azdeg", "azimuthrad", "azrad"),
    "elevation": ("elevation", "el", "elev", "elevationdeg", "eldeg", "elevationrad", "elrad"),
}
_SIDES = {"left": -1, "l": -1, "-1": -1, "right": 1, "r": 1, "1": 1}
# Axes of the head's frame.
_WAYS = {
    "right": (1, 0, 0), "left": (-1, 0, 0), "up": (0, 1, 0),
    "down": (0, -1, 0), "back": (0, 0, 1), "front": (0, 0, -1),
}  # fmt: skip


@checked
def load_columns(
    path: PathLike,
    *,
    side: Literal["left", "right"] | None = None,
    xyz: Sequence[str] = ("right", "up", "back"),
    azimuth_grows: Literal["right", "left"] = "right",
) -> Columns:
    """Columns from a table of viewing directions: a CSV file with a header line, or JSON.

    Each row has

    - the column: ``p`` and ``q`` (FlyWire), or else ``hex1`` and ``hex2`` (MaleCNS; also
      ``hex1_id``), which become p and q as `pq_from_hex` says;
    - its eye: ``side``, ``hemisphere`` or ``eye``, "left" or "right" (or L, R, -1, 1); or ``side=``
      says it of all;
    - where it looks: ``x``, ``y``, ``z`` of any length, or else ``azimuth`` and ``elevation``,
      degrees, but radians where the name ends in "rad".

    Capitals and signs in names do not count (``Azimuth (deg)``); other columns are passed over.
    JSON is a list of rows, or a mapping of names to lists, or a mapping that holds such a list; of
    mappings "left" and "right" each is that eye's.

    Args:
        path: a name ending in .csv or .json.
        side: of all columns, where the file does not say it.
        xyz: where the file's x, y and z point, in the head: three of right, left, up, down, front
            and back.
        azimuth_grows: to which side azimuths grow, from 0 ahead.

    Returns:
        Columns in the order of the file; ``taken_from`` says which of its names were taken.

    Raises:
        omma.Error: the file cannot be read or does not have these; it names the file, the row and
            what was expected.
    """
    check_ending(path, ".csv", ".json")
    name = os.fsdecode(path)
    turn = _turn(xyz)
    sign = 1 if one_of(azimuth_grows, ("right", "left"), "azimuth_grows") == "right" else -1
    given_side = 0 if side is None else _SIDES[one_of(side, ("left", "right"), "side")]
    rows = rows_of_table(path)
    called = _called(rows[0][1], name, given_side)
    numbers = {key: _numbers(rows, word) for key, word in called.items() if key != "side"}
    p, q = _coordinates(rows, called)
    if given_side:
        sides = np.full(len(rows), given_side)
    else:
        sides = np.array([_side(row, called["side"], where) for where, row in rows])
    if "x" in called:
        axis = np.stack([numbers["x"], numbers["y"], numbers["z"]], axis=1) @ turn
    else:
        azimuth, elevation = (
            numbers[key] if _plain(called[key]).endswith("rad") else np.radians(numbers[key])
            for key in ("azimuth", "elevation")
        )
        bad = np.flatnonzero(np.abs(elevation) > np.pi / 2 + 1e-6)
        if len(bad):
            raise Error(
                f"{rows[bad[0]][0]}: expected an elevation of -90 to 90 degrees, found "
                f"{np.degrees(elevation[bad[0]]):.4g} (a colatitude is 90 less that)"
            )
        level, azimuth = np.cos(elevation), sign * azimuth
        axis = np.stack(
            [level * np.sin(azimuth), np.sin(elevation), -level * np.cos(azimuth)], axis=1
        )
    _check(rows, p, q, sides, axis)
    return Columns(p, q, sides, axis, tuple(sorted(called.items())))


def rows_of_table(path: PathLike) -> Rows:
    """The rows of a .csv or .json table, each with where it is in the file; at least one."""
    check_ending(path, ".csv", ".json")
    name = os.fsdecode(path)
    rows = list(_csv_rows(path) if name.lower().endswith(".csv") else _json_rows(path))
    if not rows:
        raise Error(f"{name}: expected at least one row, found none")
    return rows


def whole_numbers(rows: Rows, word: str) -> Ints:
    """The whole numbers (K,) of one column of a table's rows."""
    numbers = _numbers(rows, word)
    wrong = np.flatnonzero((numbers % 1 != 0) | (np.abs(numbers) > 2**31))
    if len(wrong):
        found = numbers[wrong[0]]
        raise Error(f"{rows[wrong[0]][0]}, {word}: expected a whole number, found {found:g}")
    return numbers.astype(np.int64)


def _plain(word: str) -> str:
    return re.sub(r"[^a-z0-9]", "", word.lower())


def _called(row: Mapping[str, Any], name: str, given_side: int) -> dict[str, str]:
    """What the file calls each quantity that is needed."""
    words: dict[str, list[str]] = {}
    for word in row:
        words.setdefault(_plain(word), []).append(word)
    found = {}
    for key, spellings in _NAMES.items():
        here = [word for spelling in spellings for word in words.get(spelling, [])]
        if len(here) > 1:
            raise Error(f"{name}: expected one column for {key}, found {' and '.join(here)}")
        if here:
            found[key] = here[0]
    seen = ", ".join(row) or "none"
    wanted: list[str] = []
    coordinates, direction = (
        (("p", "q"), ("hex1", "hex2")),
        (("x", "y", "z"), ("azimuth", "elevation")),
    )
    for either, other in (coordinates, direction):
        keys = next((keys for keys in (either, other) if all(key in found for key in keys)), None)
        if keys is None:
            raise Error(
                f"{name}: expected columns {', '.join(either)}, or {' and '.join(other)}, found "
                f"{seen:.200}"
            )
        wanted += keys
    if not given_side:
        if "side" not in found:
            raise Error(
                f"{name}: expected a column side, hemisphere or eye, found {seen:.200}; or say "
                "side= of all"
            )
        wanted.append("side")
    return {key: found[key] for key in wanted}


def _csv_rows(path: PathLike) -> Iterator[tuple[str, Mapping[str, Any]]]:
    name, header = os.fsdecode(path), None
    for number, line in enumerate(open_text(path), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            cells = [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True))]
        except csv.Error as error:
            raise Error(f"{name}, line {number}: is not CSV: {error}") from None
        if header is None:
            header = cells
        elif len(cells) != len(header):
            raise Error(
                f"{name}, line {number}: expected {len(header)} cells as in the header, found "
                f"{len(cells)}"
            )
        else:
            yield f"{name}, line {number}", dict(zip(header, cells, strict=True))


def _json_rows(path: PathLike) -> Rows:
    name = os.fsdecode(path)
    try:
        document = json.load(open_text(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise Error(f"{name}: is not JSON: {error}") from None
    return _rows_of(document, name)


def _rows_of(document: Any, name: str) -> Rows:
    if isinstance(document, list):
        for k, row in enumerate(document):
            if not isinstance(row, dict):
                raise Error(f"{name}, row {k}: expected names and values, found {row!r:.40}")
        return [(f"{name}, row {k}", row) for k, row in enumerate(document)]
    if not isinstance(document, dict):
        raise Error(f"{name}: expected a list of rows, found {document!r:.40}")
    sides = {key: value for key, value in document.items() if _plain(key) in ("left", "right")}
    if sides:
        return [
            (where, {"side": _plain(key), **row})
            for key, value in sides.items()
            for where, row in _rows_of(value, f"{name}, {key}")
        ]
    lists = {key: value for key, value in document.items() if isinstance(value, list)}
    rows = [key for key, value in lists.items() if value and isinstance(value[0], dict)]
    if len(rows) == 1:
        return _rows_of(lists[rows[0]], f"{name}, {rows[0]}")
    if rows or not lists:
        found = ", ".join(map(str, document)) or "nothing"
        raise Error(
            f"{name}: expected one list of rows, or a list for each name, found {found:.99}"
        )
    lengths = {key: len(value) for key, value in lists.items()}
    if len(set(lengths.values())) > 1:
        raise Error(f"{name}: expected lists of one length, found {lengths!r:.120}")
    columns = [dict(zip(lists, values)) for values in zip(*lists.values(), strict=True)]
    return [(f"{name}, row {k}", row) for k, row in enumerate(columns)]


def _numbers(rows: Rows, word: str) -> Floats:
    found = np.empty(len(rows))
    for k, (where, row) in enumerate(rows):
        value = row.get(word)
        try:
            found[k] = math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            found[k] = math.nan
        if not math.isfinite(found[k]):
            raise Error(f"{where}, {word}: expected a number, found {value!r:.40}")
    return found


def _coordinates(rows: Rows, called: Mapping[str, str]) -> tuple[Ints, Ints]:
    pair = ("p", "q") if "p" in called else ("hex1", "hex2")
    one, other = (whole_numbers(rows, called[key]) for key in pair)
    return (one, other) if "p" in called else pq_from_hex(one, other)


def _side(row: Mapping[str, Any], word: str, where: str) -> int:
    value = str(row.get(word)).strip().lower().removesuffix(".0")
    if value not in _SIDES:
        raise Error(f"{where}, {word}: expected left or right, found {row.get(word)!r:.40}")
    return _SIDES[value]


def _turn(xyz: Sequence[str]) -> Floats:
    """The rows of a file's x, y and z in the head's frame."""
    if isinstance(xyz, str) or len(xyz) != 3:
        raise Error(f"xyz: expected three of {', '.join(_WAYS)}, found {xyz!r:.40}")
    turn = np.array([_WAYS[one_of(way, _WAYS, "xyz")] for way in xyz], np.float64)
    if abs(np.linalg.det(turn)) < 0.5:
        raise Error(f"xyz: expected three ways at right angles, found {', '.join(xyz)}")
    return turn


def _check(rows: Rows, p: Ints, q: Ints, sides: Ints, axis: Floats) -> None:
    # As the value does, but by the file's rows.
    seen: dict[tuple[int, int, int], str] = {}
    for (where, _), *column in zip(rows, sides.tolist(), p.tolist(), q.tolist(), strict=True):
        before = seen.setdefault((column[0], column[1], column[2]), where)
        if before != where:
            raise Error(
                f"{where}: expected each column of an eye once, found p = {column[1]}, q = "
                f"{column[2]} in {before} too"
            )
    nowhere = np.flatnonzero(np.linalg.norm(axis, axis=1) == 0)
    if len(nowhere):
        raise Error(f"{rows[nowhere[0]][0]}: expected a direction, found 0, 0, 0")
