"""What is in a file of points, in words."""

from __future__ import annotations

from collections import Counter

import numpy as np

from omma.base.progress import Progress
from omma.job.extents import LONG_POINTS_M, ODD_M, describe_extent
from omma.job.places import place_words
from omma.job.results_info import Lines
from omma.scene.memory import free_bytes, words_for_bytes
from omma.scene.point_cells import CellMeans, Columns
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


class _Found:
    """What is known of points that come in pieces; positions are from the sieve's offset on."""

    def __init__(self) -> None:
        self.low, self.high = np.full(3, np.inf), np.full(3, -np.inf)
        self.first: list[np.ndarray] = []
        self.labels: Counter[int] = Counter()
        self.count = 0

    def add(self, columns: Columns) -> None:
        positions = columns["positions"]
        self.count += len(positions)
        self.low = np.minimum(self.low, positions.min(axis=0))
        self.high = np.maximum(self.high, positions.max(axis=0))
        if sum(map(len, self.first)) < _FIRST:
            self.first.append(positions)
        numbers, counts = np.unique(columns.get("labels", ()), return_counts=True)
        self.labels.update(dict(zip(numbers.astype(int).tolist(), counts.tolist())))


def describe_points(
    path: str,
    unit: str | float | None = None,
    up: str | None = None,
    progress: Progress | None = None,
    *,
    voxel_m: float | None = None,
) -> Lines:
    """Number, size, spacing, classes and colours of a file's points, which is read in pieces; with
    ``voxel_m`` of their means in the cells of a grid."""
    in_unit = "m" if unit is None else unit
    sieve = Sieve(file := open_points(path), in_unit, up, voxel_m=voxel_m)
    cells = None if sieve.voxel_m is None else CellMeans(sieve.voxel_m)
    found = _Found()
    largest: dict[str, float] = {}
    least, greatest = np.inf, -np.inf  # of intensities
    for piece in file.pieces():
        columns = sieve.pass_through(piece, file.whites[-1])
        if not len(columns["positions"]):
            continue
        if "intensity" in columns:
            least = min(least, float(columns["intensity"].min()))
            greatest = max(greatest, float(columns["intensity"].max()))
        for name in ("colors", "normals"):
            if name in columns:
                value = np.nanmax(getattr(piece, name), initial=0)
                largest[name] = max(largest.get(name, 0.0), float(value))
        if cells is None:
            found.add(columns)
        else:
            cells.add(columns)
        if progress is not None:
            progress(min(sieve.read / (file.count or sieve.read), 1.0))
    if sieve.offset_m is None:
        raise sieve.none_found()
    thinned = ""
    if cells is not None:
        found.add(cells.columns())
        thinned = f", means of {sieve.kept:,} in cells of {sieve.voxel_m:g} m"
    ends = (found.low, found.high)
    corners = [place_words(one + sieve.offset_m) for one in ends]
    some = np.concatenate(found.first)
    whole = "" if len(some) == found.count else f" (of the first {len(some):,})"
    bytes_, free = found.count * BYTES_PER_SURFEL, free_bytes()
    suspect = unit is None and file.units.across is None
    extent = describe_extent(
        found.high - found.low,
        may_be_mm_above=LONG_POINTS_M if suspect else ODD_M,
        up=up or file.up,
    )
    lines = [
        ("points", f"{path}, {file.kind}"),
        ("number", f"{found.count:,}{thinned}"),
        ("bounds", f"{corners[0]} to {corners[1]} m"),
        ("extent", extent),
        ("spacing", f"{spacing_of(some) * 1e3:.4g} mm to the nearest, median{whole}"),
        ("unit", f"{file.units}, read as {in_unit}; up {up or file.up}"),
    ]
    if found.labels:
        named = [
            f"{number} {_CLASSES.get(number, '') if file.kind == 'LAS' else ''}".strip()
            + f": {n:,}"
            for number, n in sorted(found.labels.items())
        ]
        lines.append(("classes", ", ".join(named)))
    lines.append(("colours", _colours(largest.get("colors"), file.whites)))
    if least <= greatest:
        begin = f"from {least:g} " if least < 0 else "up "
        lines.append(("intensity", f"{begin}to {greatest:g}"))
    if "normals" in largest:
        lines.append(("normals", "of the file"))
    if file.scanners:
        lines.append(("scanners", f"{len(file.scanners)}"))
    fits = "fits" if bytes_ <= free else f"{int(free / BYTES_PER_SURFEL):,} would fit"
    memory = f"{words_for_bytes(bytes_)} of {words_for_bytes(free)} free: {fits}"
    lines.append(("as surfels", memory))
    lines += [("left out", f"{count:,}: {reason}") for reason, count in sieve.left_out.items()]
    if advice := file.units.advice(sieve.world_from_file):
        lines.append(("warning", advice))
    return lines


def _colours(largest: float | None, whites: tuple[float, ...]) -> str:
    if not largest:
        return "none" if largest is None else "none: all are black"
    white = next((one for one in whites if largest <= one), whites[-1])
    return f"sRGB, white is {white:g}"
