"""Measured angular sensitivities from CSV files."""

from __future__ import annotations

import os

import numpy as np

from omma._core import Acceptance, Error
from omma.base.arguments import checked
from omma.base.files import PathLike
from omma.base.tables import as_grid, read_table

_PROFILE = ("angle_deg", "sensitivity")
_MAP = ("right_deg", "up_deg", "sensitivity")


@checked
def load_acceptance(path: PathLike) -> Acceptance:
    """A measured angular sensitivity from a CSV file, divided by its largest value.

    A radial profile has the columns angle_deg (from the axis) and sensitivity; a map right_deg,
    up_deg (angles from the axis) and sensitivity, one line for each node of a full grid. Lines in
    any order; empty ones, and what follows a ``#``, are passed over. Between the nodes S is linear,
    beyond the last it is 0.

    Raises:
        omma.Error: the file cannot be read or is no such table; it names the line.
    """
    header, table, _ = read_table(path, (_PROFILE, _MAP), "sensitivity")
    name = os.fsdecode(path)
    try:
        if header == _PROFILE:
            table = table[np.argsort(table[:, 0], kind="stable")]
            return Acceptance.table(np.radians(table[:, 0]), table[:, 1], path=name)
        right, up, sensitivity = as_grid(path, table, "angles to the right", "angles up")
        return Acceptance.table_2d(np.radians(right), np.radians(up), sensitivity, path=name)
    except Error as error:
        message = str(error)
        raise Error(message if message.startswith(name) else f"{name}: {message}") from None
