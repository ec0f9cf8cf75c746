"""Eyes from old `.eye` files, of 7, 8 or 9 columns."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from omma._core import Error, Eye
from omma.base.arguments import checked
from omma.base.arrays import Floats
from omma.base.files import PathLike, metres_per_unit, open_text
from omma.base.values import value_class
from omma.eye.files import warn_of_unusual


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class ConvertedEye:
    """An eye from an old file, and what was assumed, dropped or looks wrong, a sentence each."""

    eye: Eye
    columns: int
    notes: tuple[str, ...]


@checked
def convert_eye(path: PathLike, unit: str | float = "mm", *, degrees: bool = False) -> ConvertedEye:
    """Read an `.eye` file of another age, with 7, 8 or 9 columns; `omma.save_eye` writes it anew.

    Columns 1 to 7 are position x y z, axis x y z and acceptance angle in all of them. Today's files
    have the focal offset as column 8. CompoundRay's early files have 7: no offset, rays start at
    the position, so it becomes 0. Of 9 columns the first 8 are taken for today's, which is how
    CompoundRay reads such a file; the ninth is dropped. Its meaning is not on record.

    Args:
        unit: unit of lengths: "mm", "um", "m" or a number of metres.
        degrees: column 7 holds degrees, as some early tools expected, instead of radians.

    Raises:
        omma.Error: the file cannot be read, a line has another number of columns than the first or
            something that is no number, or what the columns say is no eye.

    Warns:
        UserWarning: numbers that no animal has, mostly in another unit.
    """
    name = os.fsdecode(path)
    table = _read_table(name)
    columns = table.shape[1]
    if columns not in (7, 8, 9):
        raise Error(f"{name}, line 1: expected 7, 8 or 9 columns, found {columns}")
    notes = list(_column_notes(table))
    angle = np.radians(table[:, 6]) if degrees else table[:, 6]
    if degrees:
        notes.append("Assumed: the acceptance angles of column 7 are degrees; written as radians.")
    elif angle.max() > 2 * np.pi:
        raise Error(
            f"{name}: expected acceptance angles (column 7) from 0 to 2 pi rad, found "
            f"{angle.max():.6g}; are they degrees?"
        )
    elif angle.max() > 1:
        notes.append(
            f"Assumed: the acceptance angles of column 7 are radians. The largest is "
            f"{angle.max():.4g} rad ({np.degrees(angle.max()):.4g}°): if they are degrees, "
            "say so when converting."
        )
    offset = table[:, 7] if columns > 7 else np.zeros(len(table))
    metres = metres_per_unit(unit)
    turned = np.array([1, 1, -1])  # the file's z points ahead, ours backwards
    try:
        eye = Eye(
            table[:, 0:3] * turned * metres,
            table[:, 3:6] * turned,
            angle,
            offset * metres,
        )
    except Error as error:
        raise Error(f"{name}: {error}") from None
    warn_of_unusual(eye, name)
    return ConvertedEye(eye, columns, tuple(notes))


def _column_notes(table: Floats) -> tuple[str, ...]:
    columns = table.shape[1]
    if columns == 7:
        return (
            "Assumed: focal offset 0 (the file has 7 columns and no offset): rays start at the "
            "positions.",
        )
    if columns == 8:
        return ("Nothing to convert: the file has today's 8 columns already.",)
    ninth = table[:, 8]
    values = (
        f"all {ninth[0]:.6g}"
        if np.ptp(ninth) == 0
        else f"{ninth.min():.6g} to {ninth.max():.6g}, {len(np.unique(ninth))} different"
    )
    return (
        f"Lost: column 9 ({values}); today's format cannot hold it.",
        "Assumed: columns 7 and 8 are acceptance angle and focal offset, as CompoundRay reads a "
        "file of 9 columns.",
    )


def _read_table(name: str) -> Floats:
    rows: list[list[float]] = []
    first = 0
    for number, line in enumerate(open_text(name), start=1):
        words = line.split("#")[0].replace(",", " ").split()
        if not words:
            continue
        first = first or number
        if rows and len(words) != len(rows[0]):
            raise Error(
                f"{name}, line {number}: expected {len(rows[0])} columns as in line {first}, "
                f"found {len(words)}"
            )
        rows.append([_number(word, f"{name}, line {number}") for word in words])
    if not rows:
        raise Error(f"{name}: expected at least one ommatidium, found none")
    return np.array(rows)


def _number(word: str, where: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise Error(f"{where}: expected a finite number, found {word!r:.24}")
    return value
