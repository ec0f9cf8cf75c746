"""The section of RESULTS.md about many cameras, of cameras.csv as many_cameras.py prints it."""

from __future__ import annotations

import math
from itertools import pairwise

from curves import Row, pick
from report_text import number

# Errors in percent at which times are compared.
AT_PERCENT = (30.0, 10.0, 3.0)
WAYS = (
    "Omma, own rays",
    "Omma, shared rays",
    "Omma, cube map",
    "Mitsuba, rays",
    "Mitsuba, cameras",
    "Mitsuba, still cameras",
    "Mitsuba, cube map",
)


def tables_of(rows: list[Row]) -> list[tuple[str, str]]:
    """Lightings and eyes, in the order measured."""
    return list(dict.fromkeys((row["lighting"], row["eye"]) for row in rows))


def front(rows: list[Row]) -> list[tuple[float, float]]:
    """Times in ms and errors in percent of what nothing else of these is both quicker and better
    than, the quickest first.
    """
    found: list[tuple[float, float]] = []
    for ms, error in sorted((float(r["ms_per_frame"]), float(r["error_percent"])) for r in rows):
        if not found or error < found[-1][1]:
            found.append((ms, error))
    return found


def ms_to(rows: list[Row], error: float) -> float | None:
    """Milliseconds to an error in percent, straight lines between points on logarithmic axes;
    None where it is not reached.
    """
    points = front(rows)
    if not points or points[-1][1] > error:
        return None
    for (ms, before), (later_ms, after) in pairwise(points):
        if before > error >= after:
            t = math.log(before / error) / math.log(before / after)
            return ms * (later_ms / ms) ** t
    return points[0][0]


def times_table(rows: list[Row]) -> list[list[object]]:
    """Milliseconds a frame to each of the errors, by lighting, eye and way."""
    found: list[list[object]] = []
    for lighting, eye in tables_of(rows):
        for way in WAYS:
            own = pick(rows, lighting=lighting, eye=eye, way=way)
            if not own:
                continue
            times = [ms_to(own, error) for error in AT_PERCENT]
            least = min(float(row["error_percent"]) for row in own)
            cells = ["not reached" if ms is None else number(ms) for ms in times]
            found.append([lighting, eye, way, *cells, f"{least:.2g}"])
    return found


def all_table(rows: list[Row]) -> list[list[object]]:
    """All rows, as people read them."""
    return [
        [
            row["lighting"], row["eye"], row["way"], row["setting"],
            f"{float(row['rays_per_ommatidium']):.3g}", f"{float(row['setup_s']):.2g}",
            number(float(row["ms_per_frame"])),
            *(f"{float(row[f'{key}_percent']):.2g}" for key in ("error", "noise", "bias", "place")),
        ]
        for row in rows
        if row["way"] in WAYS
    ]  # fmt: skip
