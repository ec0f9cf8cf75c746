"""Reads the tables of a bench run and finds, on the curves of error against rays and against time,
where a given error is reached.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

Row = dict[str, str]


def read(results: Path, name: str) -> list[Row]:
    """The rows of a table, none where it was not measured."""
    path = results / f"{name}.csv"
    if not path.exists():
        return []
    with path.open() as file:
        return list(csv.DictReader(file))


def pick(rows: list[Row], **wanted: object) -> list[Row]:
    """The rows with these values."""
    return [row for row in rows if all(row[key] == str(v) for key, v in wanted.items())]


def scenes_of(rows: list[Row]) -> list[str]:
    """The scenes of a table, in its order."""
    return list(dict.fromkeys(row["scene"] for row in rows))


@dataclass(frozen=True)
class Reached:
    """What it takes to reach an error: rays per ommatidium, milliseconds per frame, and how."""

    rays: float
    ms: float
    method: str


def random_error(rows: list[Row], rays: float) -> float:
    """Error of that many random rays, from all numbers measured: independent rays, so it falls
    exactly with the square root of their number.
    """
    found = [float(row["rms"]) ** 2 * float(row["rays"]) for row in pick(rows, method="random")]
    return math.sqrt(sum(found) / len(found) / rays)


def crossing(rows: list[Row], error: float) -> Reached | None:
    """Where one method's curve falls to ``error``, straight lines between points on logarithmic
    axes. Its first point where that is good enough already; None where it never gets there.
    """
    points = sorted((float(r["rays"]), float(r["rms"]), float(r["ms_per_frame"])) for r in rows)
    if not points or points[-1][1] > error:
        return None
    found = points[0]
    for before, after in pairwise(points):
        if before[1] > error >= after[1]:
            t = math.log(before[1] / error) / math.log(before[1] / after[1])
            rays, ms = (before[i] * (after[i] / before[i]) ** t for i in (0, 2))
            found = (rays, error, ms)
    return Reached(found[0], found[2], rows[0]["method"])


def methods(rows: list[Row], begins: str) -> list[str]:
    """Names of the methods that begin so, in the order measured."""
    return list(dict.fromkeys(r["method"] for r in rows if r["method"].startswith(begins)))


def least(rows: list[Row], begins: str, error: float, key: str = "rays") -> Reached | None:
    """The least rays (or "ms") to an error of all methods that begin so."""
    found = [crossing(pick(rows, method=name), error) for name in methods(rows, begins)]
    return min((f for f in found if f), key=lambda f: getattr(f, key), default=None)
