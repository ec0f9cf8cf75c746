"""The columns of the measured fly, and the published files from which such a fly can be read."""

from __future__ import annotations

import os

import numpy as np

from omma._core import Error
from omma.base.arguments import checked, one_of
from omma.base.files import PathLike
from omma.columns.coordinates import pq_from_hex
from omma.columns.lattice import Columns
from omma.columns.maps import load_columns, rows_of_table, whole_numbers
from omma.columns.names import column_of_name
from omma.species.measured import eye_map, medulla_names

# Half a last digit: directions have six decimals, angles four, in degrees.
_XYZ_ROUNDED, _ANGLE_ROUNDED_RAD = 0.5e-6, np.radians(0.5e-4)
_TYPES = {
    "pale": "pale", "p": "pale", "yellow": "yellow", "y": "yellow", "dra": "dorsal rim",
    "d": "dorsal rim", "dorsal rim": "dorsal rim", "dorsal_rim": "dorsal rim",
}  # fmt: skip


@checked
def fly_columns() -> Columns:
    """The columns of `omma.species.measured_drosophila`, in the order of its ommatidia: 850 of the
    left eye, 846 of the right one, with the measured axes as they are published, to six decimals.

    Example:
        >>> columns = omma.columns.fly_columns()
        >>> (columns.side < 0).sum(), (columns.side > 0).sum()
        (np.int64(850), np.int64(846))
    """
    table = eye_map()
    p, q = pq_from_hex(table.hex1, table.hex2)
    return Columns(p, q, table.side, table.axis, (("source", "eyemap_mcns_f20240701"),))


@checked
def load_eye_map(left: PathLike | None = None, right: PathLike | None = None) -> Columns:
    """Columns from files of the eye map archive of Zhao et al., one for each eye.

    A CSV file with the columns p, q, x, y, z, theta, phi, and perhaps rootid, or hex1 and hex2
    (github.com/artxz/eyemap-archive): x points ahead, y to the left, z up; theta is the angle from
    up, phi the azimuth to the right, degrees. They say the same twice, and hex1 = q + 18, hex2 = p
    + 19: a file that contradicts itself is refused.

    Args:
        left, right: the files; at least one.

    Returns:
        Columns, the left eye's first, in the order of the files.

    Raises:
        omma.Error: no file, or one that is not of this form.
    """
    parts = []
    for path, side in ((left, "left"), (right, "right")):
        if path is None:
            continue
        columns = load_columns(path, side=side, xyz=("front", "left", "up"))  # type: ignore[arg-type]
        _check_twice(path, columns)
        parts.append(columns)
    if not parts:
        raise Error("left, right: expected at least one file, found none")
    p, q, sides, axis = (
        np.concatenate([getattr(one, name) for one in parts]) for name in ("p", "q", "side", "axis")
    )
    return Columns(p, q, sides, axis, parts[0].taken_from)


@checked
def load_column_types(path: PathLike, *, side: str | None = None) -> dict[str, str]:
    """Which columns are pale, yellow or of the dorsal rim, by name, from a table of them (CSV).

    As Nern et al. 2025 publish for the right eye (Pale-Yellow_column-assignment, saved as CSV):
    hex1_id, hex2_id and column_type, "pale", "yellow", "DRA" or "unclear"; or with the column's
    name (column, "ME_R_col_18_19") in place of both. What is none of the three is left out, so that
    `omma.species.measured_drosophila` draws it.

    Args:
        side: "left" or "right", of all columns that have no name that says it.

    Returns:
        "pale", "yellow" or "dorsal rim" by MaleCNS's name.

    Raises:
        omma.Error: the file cannot be read or is no such table.
    """
    name = os.fsdecode(path)
    rows = rows_of_table(path)
    called = {key.lower().replace("_id", ""): key for key in rows[0][1]}
    if "column_type" not in called:
        raise Error(f"{name}: expected a column column_type, found {', '.join(rows[0][1]):.200}")
    found: dict[str, str] = {}
    if "column" in called:
        keys = [column_of_name(row[called["column"]]) for _, row in rows]
        p, q, sides = (np.array([key[k] for key in keys]) for k in (1, 2, 0))
    else:
        for wanted in ("hex1", "hex2"):
            if wanted not in called:
                raise Error(
                    f"{name}: expected the columns hex1_id and hex2_id, or column, found "
                    f"{', '.join(rows[0][1]):.200}"
                )
        given = one_of(side, ("left", "right"), "side")
        p, q = pq_from_hex(*(whole_numbers(rows, called[key]) for key in ("hex1", "hex2")))
        sides = np.full(len(rows), 1 if given == "right" else -1)
    names = medulla_names(q + 18, p + 19, sides)
    for key, (where, row) in zip(names, rows, strict=True):
        if key in found:
            raise Error(f"{where}: expected each column once, found {key} twice")
        found[key] = _TYPES.get(row[called["column_type"]].strip().lower(), "")
    return {key: kind for key, kind in found.items() if kind}


def _check_twice(path: PathLike, columns: Columns) -> None:
    name = os.fsdecode(path)
    rows = rows_of_table(path)
    header = list(rows[0][1])
    for wanted in ("p", "q", "x", "y", "z", "theta", "phi"):
        if wanted not in header:
            raise Error(
                f"{name}: expected the columns p, q, x, y, z, theta, phi, found "
                f"{', '.join(header):.200}"
            )
    theta, phi = (np.radians([float(row[key]) for _, row in rows]) for key in ("theta", "phi"))
    # Head frame: right, up, back.
    said = np.stack(
        [np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], axis=1
    )
    apart = np.linalg.norm(columns.axis - said, axis=1)
    # Three numbers and two angles, each off by half its last digit.
    wrong = np.flatnonzero(apart > 2 * (3**0.5 * _XYZ_ROUNDED + 2**0.5 * _ANGLE_ROUNDED_RAD))
    if len(wrong):
        k = wrong[0]
        raise Error(
            f"{rows[k][0]}: expected theta and phi of the direction x, y, z, found one "
            f"{np.degrees(apart[k]):.3g}° beside it"
        )
    if "hex1" in header and "hex2" in header:
        p, q = pq_from_hex(*(whole_numbers(rows, key) for key in ("hex1", "hex2")))
        off = np.flatnonzero((p != columns.p) | (q != columns.q))
        if len(off):
            raise Error(
                f"{rows[off[0]][0]}: expected hex1 = q + 18 and hex2 = p + 19, found "
                f"{rows[off[0]][1]['hex1']} and {rows[off[0]][1]['hex2']}"
            )
