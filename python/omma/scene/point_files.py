"""Files of points, read in pieces: LAS and LAZ by laspy, E57 by pye57, PLY and text here."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.beginnings import beginning_of, is_plain_text, shown
from omma.base.files import reading
from omma.base.number_lines import text_tables
from omma.base.optional import needs
from omma.base.ply_header import LONGEST_HEADER, PlyElement, expect_end, read_header
from omma.scene.e57_heads import check_e57_head
from omma.scene.las_heads import check_las_head, reading_las
from omma.scene.las_units import las_units
from omma.scene.point_columns import (
    BY_NUMBER,
    has_decimal_commas,
    is_number,
    may_be_otherwise,
    rows_of,
    unnamed_columns,
    words_of,
)
from omma.scene.point_units import METRES, Units

POINT_FILES = (".las", ".laz", ".e57", ".xyz", ".pts", ".asc")
TEXT_FILES = (".xyz", ".pts", ".asc", ".txt", ".csv")
# Of a piece: some 100 MB while it is read.
PIECE = 1 << 20

# Names of columns, as scanners, CloudCompare and others write them.
_COLOURS = (
    ("red", "green", "blue"),
    ("r", "g", "b"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
)
_NORMALS = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))
_INTENSITY = ("intensity", "scalar_intensity", "reflectance", "i")
_LABELS = ("classification", "class", "label", "scalar_classification", "scalar_label", "semantic")
# Of a LAS file: what its authors marked as wrong (ASPRS LAS 1.4 R15, table 17).
_NOISE = (7, 18)
# Of E57 files: unit normals in the scanner's frame, by the extension E57_EXT_surface_normals
# (libe57.org, revision 2), whatever its prefix, or by the names that others write.
_E57_NORMALS = tuple(re.compile(rf"(\w+:)?(normal{a.upper()}|n{a})") for a in "xyz")
# What vertices of files of Gaussian splats have: a colour by harmonics, a scale and a turn of each
# (Kerbl et al. 2023), of which a broken file may lack one, or these packed (PlayCanvas).
_OF_SPLATS = (
    {"f_dc_0", "scale_0"},
    {"f_dc_0", "rot_0"},
    {"scale_0", "rot_0"},
    {"packed_position", "packed_rotation"},
)


@dataclass
class Piece:
    """Some points as a file has them; what the file lacks is None."""

    positions: Floats  # (n, 3), in the file's unit
    colors: NDArray[Any] | None = None  # (n, 3), sRGB
    intensity: NDArray[Any] | None = None
    normals: NDArray[Any] | None = None
    labels: NDArray[Any] | None = None


@dataclass
class PointFile:
    """What the head of a file says. ``whites`` are what the largest value of a colour may be: the
    first that no colour exceeds."""

    path: str
    kind: str
    count: int | None  # None: not known before it is read
    pieces: Callable[[], Iterator[Piece]]
    whites: tuple[float, ...] = (1.0,)
    bounds: Floats | None = None  # (2, 3), in the file's unit
    up: str = "z"
    units: Units = field(default_factory=Units)  # that the file says
    scanners: list[Floats] = field(default_factory=list)  # (3,) each, in the file's unit
    left_out: dict[str, int] = field(default_factory=dict)  # by reason
    doubt: str = ""  # what may have been meant otherwise, in words


def is_point_file(path: str) -> bool:
    """Whether a scene's file holds points: by its ending, a PLY file by having no faces."""
    ending = Path(path).suffix.lower()
    if ending != ".ply" or not os.path.isfile(path):
        return ending in POINT_FILES
    _, elements, _ = ply_head(path)
    if holds_splats(elements):
        return False
    rows = {one.name: one.count for one in elements}
    return rows.get("vertex", 0) > 0 and not (rows.get("face", 0) or rows.get("tristrips", 0))


def holds_splats(elements: list[PlyElement]) -> bool:
    """Whether the vertices of a PLY file are Gaussian splats."""
    names = {p.name for one in elements if one.name == "vertex" for p in one.properties}
    return any(some <= names for some in _OF_SPLATS)


def open_points(path: str) -> PointFile:
    """The head of a file of points.

    Raises:
        omma.Error: another ending, no file, or one that cannot be read.
    """
    ending = Path(path).suffix.lower()
    openers = {".ply": _open_ply, ".las": _open_las, ".laz": _open_las, ".e57": _open_e57}
    openers.update(dict.fromkeys(TEXT_FILES, _open_text))
    if ending not in openers:
        raise Error(f"{path}: expected a name ending in {', '.join(openers)}")
    if not os.path.isfile(path):
        found = "a directory" if os.path.isdir(path) else "none"
        raise Error(f"{path}: expected a file, found {found}")
    with reading(path, "points"):
        return openers[ending](path)


def ply_head(path: str) -> tuple[str, list[PlyElement], int]:
    """Order of bytes ("" for text), elements, and where rows begin."""
    with reading(path, "PLY"), open(path, "rb") as file:
        order, elements, _, begin = read_header(
            path, file.read(LONGEST_HEADER), os.path.getsize(path)
        )
    return order, elements, begin


def _open_ply(path: str) -> PointFile:
    order, elements, begin = ply_head(path)
    names = [one.name for one in elements]
    if "vertex" not in names:
        raise Error(f"{path}: expected vertices, found {', '.join(names) or 'nothing'}")
    before, vertex = elements[: names.index("vertex")], elements[names.index("vertex")]
    if any(one.count_type for each in (*before, vertex) for one in each.properties):
        raise Error(f"{path}: expected vertices without lists in them or before them")
    types = {one.name.lower(): one.type for one in vertex.properties}
    if holds_splats(elements):
        raise Error(
            f"{path}: expected points on surfaces, found Gaussian splats, which omma.load_scene "
            "reads"
        )
    colour = types.get(next((names[0] for names in _COLOURS if names[0] in types), ""), "u1")
    whites = {"u1": (255.0,), "u2": (65535.0,)}.get(colour, (1.0, 255.0))
    if order == "":
        skipped = sum(one.count for one in before)
        is_last = not any(one.count for one in elements[len(before) + 1 :])
        most, count = (None, vertex.count) if is_last else (vertex.count, None)

        def pieces() -> Iterator[Piece]:
            rows = 0
            for table in text_tables(
                path, begin, len(types), skipped=skipped, most=most, count=count
            ):
                rows += len(table)
                yield _piece(path, dict(zip(types, table.T)))
            expect_all(path, vertex.count, rows)

    else:
        expect_end(path, order, elements, begin)
        row = np.dtype([(name, order + kind) for name, kind in types.items()])
        begin += sum(
            one.count * np.dtype([("", p.type) for p in one.properties]).itemsize for one in before
        )

        def pieces() -> Iterator[Piece]:
            there = (os.path.getsize(path) - begin) // max(row.itemsize, 1)
            expect_all(path, vertex.count, min(there, vertex.count))
            table = np.memmap(path, row, "r", begin, (vertex.count,))
            for start in range(0, vertex.count, PIECE):
                some = np.array(table[start : start + PIECE])
                yield _piece(path, {name: some[name] for name in types})

    return PointFile(path, "PLY", vertex.count, pieces, whites, up="y")


def expect_all(path: str, expected: int, found: int) -> None:
    """omma.Error where a file ends too early."""
    if found < expected:
        raise Error(
            f"{path}: expected {expected:,} points, found the end of the file after {found:,}"
        )


def _open_text(path: str) -> PointFile:
    with open(path, "rb") as file:
        head = file.read(1 << 16)
    if not is_plain_text(head):
        raise Error(f"{path}: expected lines of numbers, found {beginning_of(head)}")
    first = head.split(b"\n")
    # Decimal commas, where columns are separated by something else.
    blank = bytes.maketrans(b",;", b". " if has_decimal_commas(first) else b"  ")
    begin, names, unnamed, doubt = 0, "", "", ""
    count: int | None = None
    found = "no line of several columns"
    for k, line in enumerate(first):
        # Comments are passed over; .pts files, and some others, begin with the number of points.
        words = words_of(line.lstrip(b"#/ "), blank)
        if words[:1] and words[0].lower() == "ncols":
            raise Error(
                f"{path}: expected lines of points, found a grid of heights (ESRI ASCII), which is "
                "not read; save it as points (x y z) or as a mesh"
            )
        if words[:1] in (["x"], ["X"]):
            names = " ".join(words).lower()
        elif len(words) > 1 and not line.lstrip().startswith((b"#", b"/")):
            if not is_number(words[0]):
                names, begin = " ".join(words).lower(), begin + len(line) + 1
            elif len(words) != len(names.split()):
                some = rows_of(first[k:], blank, len(words))
                is_pts = path.lower().endswith(".pts")
                names = unnamed = unnamed_columns(some, is_pts)
                if may_be_otherwise(some, is_pts):
                    doubt = f"its columns have no names and are read as {names}; name them in its "
                    doubt += (
                        "first line, as by # x y z red green blue intensity, if they are others"
                    )
            found = f"line {k + 1} of {len(words)} columns, {shown(line)}"
            break
        elif len(words) == 1 and line.strip().isdigit():
            count = (count or 0) + int(line)
        begin += len(line) + 1
    columns = names.split()
    if not {"x", "y", "z"} <= set(columns):
        raise Error(
            f"{path}: expected columns x, y and z named in the first line, or "
            f"{', '.join(map(str, BY_NUMBER))} of them ({'; '.join(BY_NUMBER.values())}), found "
            f"{found}"
        )

    def pieces() -> Iterator[Piece]:
        for table in text_tables(path, begin, len(columns), count=count, blank=blank):
            yield _piece(path, dict(zip(columns, table.T)))

    kind = f"text, read as {unnamed}" if unnamed else "text"
    return PointFile(path, kind, None, pieces, (1.0, 255.0, 65535.0), doubt=doubt)


def _piece(path: str, columns: dict[str, NDArray[Any]]) -> Piece:
    """A piece of named columns."""

    def stacked(*choices: tuple[str, ...]) -> NDArray[Any] | None:
        names = next((some for some in choices if all(one in columns for one in some)), None)
        return None if names is None else np.stack([columns[one] for one in names], axis=1)

    positions = stacked(("x", "y", "z"))
    if positions is None:
        raise Error(f"{path}: expected vertices with x, y and z")
    labels = next((columns[name] for name in _LABELS if name in columns), None)
    if labels is not None:
        with np.errstate(invalid="ignore"):
            labels = np.nan_to_num(labels).astype(np.int32)
    return Piece(
        positions.astype(np.float64),
        stacked(*_COLOURS),
        next((columns[name] for name in _INTENSITY if name in columns), None),
        stacked(*_NORMALS),
        labels,
    )


def _open_las(path: str) -> PointFile:
    laspy = needs("laspy", "points", "LAS and LAZ files need laspy")
    not_counted = check_las_head(path)
    with reading_las(path), laspy.open(path) as reader:
        header = reader.header
        dimensions = set(header.point_format.dimension_names)
    made = PointFile(path, "LAS", int(header.point_count), lambda: iter(()), (255.0, 65535.0))
    made.bounds = np.array([header.mins, header.maxs], np.float64)
    made.units = las_units(header)

    def pieces() -> Iterator[Piece]:
        made.left_out.clear()
        if not_counted:
            made.left_out["behind those that its header counts"] = not_counted
        rows = 0
        with reading_las(path), laspy.open(path) as reader:
            for some in reader.chunk_iterator(PIECE):
                rows += len(some)
                yield _las_piece(some, dimensions, made.left_out)
        expect_all(path, made.count or 0, rows)

    made.pieces = pieces
    return made


def _las_piece(some: Any, dimensions: set[str], left_out: dict[str, int]) -> Piece:
    labels = np.asarray(some.classification).astype(np.int32)
    taken = np.ones(len(labels), bool)
    for number in _NOISE:
        taken &= labels != number
    left_out["class noise"] = left_out.get("class noise", 0) + int((~taken).sum())
    if "withheld" in dimensions:
        held = np.asarray(some.withheld).astype(bool) & taken
        left_out["withheld"] = left_out.get("withheld", 0) + int(held.sum())
        taken &= ~held
    colors = None
    if {"red", "green", "blue"} <= dimensions:
        colors = np.stack(
            [np.asarray(some[one])[taken] for one in ("red", "green", "blue")], axis=1
        )
    positions = np.stack([np.asarray(some[one])[taken] for one in ("x", "y", "z")], axis=1)
    return Piece(positions, colors, np.asarray(some.intensity)[taken], None, labels[taken])


def _open_e57(path: str) -> PointFile:
    pye57 = needs("pye57", "e57", "E57 files need pye57")
    check_e57_head(path)
    with pye57.E57(path) as file:
        headers = [file.get_header(i) for i in range(file.scan_count)]
        counts = [header.point_count for header in headers]
        scanners = [header.translation if header.has_pose() else None for header in headers]
        white = max((_e57_white(header) for header in headers), default=1.0)

    made = PointFile(path, "E57", sum(counts), lambda: iter(()), (white,))

    def pieces() -> Iterator[Piece]:
        made.left_out.clear()
        with reading(path, "E57"), pye57.E57(path) as file:
            for index in range(file.scan_count):
                yield from _e57_scan(pye57, file, index, made.left_out)

    made.pieces = pieces
    made.units = Units(METRES, METRES)
    made.scanners = [np.asarray(one, np.float64) for one in scanners if one is not None]
    return made


def _e57_white(header: Any) -> float:
    try:
        return float(header.node["colorLimits"]["colorRedMaximum"].value())
    except Exception:  # libE57's own, where a scan says no limits
        return 255.0


def _e57_scan(pye57: Any, file: Any, index: int, left_out: dict[str, int]) -> Iterator[Piece]:
    header = file.get_header(index)
    there = set(header.point_fields)
    is_round = "cartesianX" not in there
    axes = ["sphericalRange", "sphericalAzimuth", "sphericalElevation"]
    axes = axes if is_round else ["cartesianX", "cartesianY", "cartesianZ"]
    state = "sphericalInvalidState" if is_round else "cartesianInvalidState"
    colours = ["colorRed", "colorGreen", "colorBlue"]
    kinds: dict[str, str] = dict.fromkeys(axes, "f8")
    kinds.update({one: "u2" for one in colours if set(colours) <= there})
    kinds.update({"intensity": "f4"} if "intensity" in there else {})
    kinds.update({state: "i1"} if state in there else {})
    normals = [name for one in _E57_NORMALS for name in sorted(there) if one.fullmatch(name)]
    normals = normals if len(normals) == 3 else []
    kinds.update(dict.fromkeys(normals, "f4"))
    size = min(PIECE, max(int(header.point_count), 1))
    data = {name: np.zeros(size, kind) for name, kind in kinds.items()}
    buffers = pye57.libe57.VectorSourceDestBuffer()
    for name, array in data.items():
        buffers.append(
            pye57.libe57.SourceDestBuffer(file.image_file, name, array, size, True, True)
        )
    reader = header.points.reader(buffers)
    while count := reader.read():
        taken = np.arange(count)
        if state in data:
            taken = np.flatnonzero(data[state][:count] == 0)
            left_out["invalid"] = left_out.get("invalid", 0) + count - len(taken)
        a, b, c = (data[name][taken] for name in axes)
        if is_round:  # ASTM E2807: the azimuth from +X towards +Y, the elevation from that plane
            a, b, c = a * np.cos(c) * np.cos(b), a * np.cos(c) * np.sin(b), a * np.sin(c)
        positions = np.stack([a, b, c], axis=1)
        if header.has_pose():
            positions = file.to_global(positions, header.rotation, header.translation)
        stacked = np.stack([data[one][taken] for one in colours], 1) if "colorRed" in data else None
        shades = data["intensity"][taken] if "intensity" in data else None
        directions = np.stack([data[one][taken] for one in normals], 1) if normals else None
        if directions is not None and header.has_pose():
            directions = file.to_global(directions, header.rotation, np.zeros(3))
        yield Piece(positions, stacked, shades, directions)
