"""What is in a file of points, in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from omma._core import Error
from omma.job.extents import describe_extent
from omma.job.results_info import Lines
from omma.scene.memory import free_bytes, words_for_bytes
from omma.scene.point_files import open_points
from omma.scene.points import Sieve
from omma.scene.surfel_frames import spacing_of
from omma.scene.surfel_scenes import BYTES_PER_SURFEL

# Points of which spacing is told: those that come first.
_FIRST = 2_000_000
# Standard classes of LAS files: ASPRS LAS 1.4 R15, table 17.
_CLASSES = {
    0: "never classified", 1: "unclassified", 2: "ground", 3: "low vegetation",
    4: "medium vegetation", 5: "high vegetation", 6: "building", 7: "low noise", 9: "water",
    10: "rail", 11: "road", 13: "wire guard", 14: "wire", 15: "tower", 16: "wire connector",
    17: "bridge deck", 18: "high noise",
}  # fmt: skip


def describe_points(
    path: str,
    unit: str | float = "m",
    up: str | None = None,
    progress: Callable[[float], object] | None = None,
) -> Lines:
    """Number, size, spacing, classes and colours of a file's points, which is read in pieces."""
    sieve = Sieve(file := open_points(path), unit, up)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    first: list[np.ndarray] = []
    labels: Counter[int] = Counter()
    largest: dict[str, float] = {}
    for piece in file.pieces():
        columns = sieve.pass_through(piece, file.whites[-1])
        positions = columns["positions"]
        if not len(positions):
            continue
        low, high = np.minimum(low, positions.min(axis=0)), np.maximum(high, positions.max(axis=0))
        if sum(map(len, first)) < _FIRST:
            first.append(positions)
        numbers, counts = np.unique(columns.get("labels", ()), return_counts=True)
        labels.update(dict(zip(numbers.astype(int).tolist(), counts.tolist())))
        for name in ("colors", "intensity", "normals"):
            if name in columns:
                found = np.nanmax(getattr(piece, name), initial=0)
                largest[name] = max(largest.get(name, 0.0), float(found))
        if progress is not None:
            progress(min(sieve.read / (file.count or sieve.read), 1.0))
    if sieve.offset_m is None:
        raise Error(f"{path}: expected points, found none of {sieve.read:,} that can be used")
    size = high - low
    corners = [", ".join(f"{x:.10g}" for x in one + sieve.offset_m) for one in (low, high)]
    some = np.concatenate(first)
    whole = "" if len(some) == sieve.kept else f" (of the first {len(some):,})"
    said = file.unit or "not said by the file"
    bytes_, free = sieve.kept * BYTES_PER_SURFEL, free_bytes()
    lines = [
        ("points", f"{path}, {file.kind}"),
        ("number", f"{sieve.kept:,}"),
        ("bounds", f"({corners[0]}) to ({corners[1]}) m"),
        ("extent", describe_extent(size)),
        ("spacing", f"{spacing_of(some) * 1e3:.4g} mm to the nearest, median{whole}"),
        ("unit", f"{said}, read as {unit}; up {up or file.up}"),
    ]
    if labels:
        named = [
            f"{number} {_CLASSES.get(number, '') if file.kind == 'LAS' else ''}".strip()
            + f": {n:,}"
            for number, n in sorted(labels.items())
        ]
        lines.append(("classes", ", ".join(named)))
    lines.append(("colours", _colours(largest.get("colors"), file.whites)))
    if "intensity" in largest:
        lines.append(("intensity", f"up to {largest['intensity']:g}"))
    if "normals" in largest:
        lines.append(("normals", "of the file"))
    if file.scanners:
        lines.append(("scanners", f"{len(file.scanners)}"))
    fits = "fits" if bytes_ <= free else f"{int(free / BYTES_PER_SURFEL):,} would fit"
    memory = f"{words_for_bytes(bytes_)} of {words_for_bytes(free)} free: {fits}"
    lines.append(("as surfels", memory))
    left = {"not finite": sieve.not_finite, **file.left_out}
    lines += [("left out", f"{count:,}: {reason}") for reason, count in left.items() if count]
    return lines


def _colours(largest: float | None, whites: tuple[float, ...]) -> str:
    if not largest:
        return "none" if largest is None else "none: all are black"
    white = next((one for one in whites if largest <= one), whites[-1])
    return f"sRGB, white is {white:g}"
