"""PLY files of Gaussian splats as PlayCanvas and SuperSplat pack them: chunks of 256 splats, each
with bounds, in which positions, scales and colours are fractions of 8 to 11 bits.

The layout is that of playcanvas/splat-transform (MIT), src/lib/readers/decompress-ply.ts. There and
here a byte of a harmonic stands for the middle of its interval.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.ply_header import PlyElement, expect_end
from omma.base.progress import Progress
from omma.scene.point_files import expect_all
from omma.scene.splat_columns import PIECE, REST_COUNTS, SplatColumns, sample_of

_CHUNK = 256
_BOUNDS = tuple(
    f"{end}_{name}{axis}" for name in ("", "scale_") for end in ("min", "max") for axis in "xyz"
)
_COLOUR_BOUNDS = tuple(f"{end}_{axis}" for end in ("min", "max") for axis in "rgb")
_PACKED = ("packed_position", "packed_rotation", "packed_scale", "packed_color")
# Of the constant function: what 0.5 + Y c = colour is solved by.
_Y0 = float(np.sqrt(1 / (4 * np.pi)))
# The three that are stored, by which of w, x, y, z is the largest.
_OTHERS = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])

_Table = NDArray[Any]


@dataclass
class PackedPly:
    """Tables of a packed file, read when they are asked for."""

    path: str
    chunk: _Table
    vertex: _Table
    sh: _Table | None

    def read(self, progress: Progress | None) -> SplatColumns:
        count = len(self.vertex)
        terms = 1 if self.sh is None else 1 + len(self.sh.dtype.names or ()) // 3
        columns = SplatColumns(self.path, count, terms)
        some = sample_of(self.chunk, len(self.chunk))
        ends = [[some[name] for name in names] for names in (_BOUNDS[:3], _BOUNDS[3:6])]
        columns.find_offset(np.concatenate(ends, axis=1).T, are_ends=True)
        for start in range(0, count, PIECE):  # whole chunks
            rows = slice(start, min(start + PIECE, count))
            self._add(columns, rows, terms)
            if progress is not None:
                progress(rows.stop / count)
        return columns

    def _add(self, columns: SplatColumns, rows: slice, terms: int) -> None:
        vertex = {name: self.vertex[name][rows].astype(np.uint32) for name in _PACKED}
        count = len(vertex[_PACKED[0]])
        # Bounds of each splat, those of its chunk.
        chunks = slice(rows.start // _CHUNK, -(-rows.stop // _CHUNK))
        bounds = np.stack([self.chunk[name][chunks].astype(np.float64) for name in _BOUNDS], axis=1)
        bounds = np.repeat(bounds, _CHUNK, axis=0)[:count]
        with np.errstate(over="ignore", invalid="ignore"):
            positions = _between(bounds[:, 0:6], _fractions(vertex["packed_position"]))
            scales = _between(bounds[:, 6:12], _fractions(vertex["packed_scale"]))
            shifts = np.array([24, 16, 8, 0])
            colours = (vertex["packed_color"][:, None] >> shifts & 255) / 255
            rgb, opacities = colours[:, :3], colours[:, 3]
            if "min_r" in (self.chunk.dtype.names or ()):
                ends = [self.chunk[one][chunks].astype(np.float64) for one in _COLOUR_BOUNDS]
                ends_of = np.repeat(np.stack(ends, axis=1), _CHUNK, axis=0)[:count]
                rgb = _between(ends_of, rgb)
        harmonics = np.zeros((count, terms, 3))
        harmonics[:, 0] = (rgb - 0.5) / _Y0
        if self.sh is not None:
            some = np.array(self.sh[rows])
            bytes_ = np.stack([some[f"f_rest_{k}"] for k in range(3 * (terms - 1))], axis=1)
            shares = np.where(bytes_ == 0, 0, np.where(bytes_ == 255, 1, (bytes_ + 0.5) / 256))
            rest = ((shares - 0.5) * 8).reshape(count, 3, terms - 1)
            harmonics[:, 1:] = rest.transpose(0, 2, 1)
        positions -= columns.offset
        columns.add(
            positions, scales, _quaternions(vertex["packed_rotation"]), opacities, harmonics
        )


def _between(ends: Floats, shares: Floats) -> Floats:
    return ends[:, :3] * (1 - shares) + ends[:, 3:] * shares


def _fractions(packed: NDArray[np.uint32]) -> Floats:
    """11, 10 and 11 bits, from the highest."""
    columns = [(packed >> 21) / 2047, (packed >> 11 & 1023) / 1023, (packed & 2047) / 2047]
    return np.stack(columns, axis=1)


def _quaternions(packed: NDArray[np.uint32]) -> Floats:
    """x, y, z, w: the largest is what the others leave of length 1."""
    shifts = np.array([20, 10, 0])
    three = ((packed[:, None] >> shifts & 1023) / 1023 - 0.5) * np.sqrt(2)
    largest = packed >> 30
    wxyz = np.empty((len(packed), 4))
    np.put_along_axis(wxyz, _OTHERS[largest], three, axis=1)
    left = np.sqrt(np.maximum(0, 1 - (three**2).sum(axis=1)))
    np.put_along_axis(wxyz, largest[:, None].astype(np.int64), left[:, None], axis=1)
    return wxyz[:, [1, 2, 3, 0]]


def read_packed_ply(path: str, order: str, elements: list[PlyElement], begin: int) -> PackedPly:
    """The tables of such a file.

    Raises:
        omma.Error: what they lack, or have otherwise.
    """
    if order == "":
        raise Error(f"{path}: expected packed splats in a binary file, found text")
    named = {one.name: one for one in elements}
    if len(named) < len(elements) or not {"chunk", "vertex"} <= named.keys():
        raise Error(
            f"{path}: expected packed splats, chunk and vertex, found "
            f"{', '.join(one.name for one in elements)}"
        )
    first = begin
    tables: dict[str, _Table] = {}
    for one in elements:
        names = [p.name for p in one.properties]
        if any(p.count_type for p in one.properties) or len(set(names)) < len(names):
            raise Error(f"{path}: expected {one.name} without lists, and each property once")
        if one.count and names:
            row = np.dtype([(p.name, order + p.type) for p in one.properties])
            there = max(os.path.getsize(path) - begin, 0) // row.itemsize
            expect_all(path, one.count, min(there, one.count))
            tables[one.name] = np.memmap(path, row, "r", begin, (one.count,))
            begin += one.count * row.itemsize
    if "vertex" not in tables:
        raise Error(f"{path}: expected Gaussian splats, found none")
    count = named["vertex"].count
    has_colours = "min_r" in {p.name for p in named["chunk"].properties}
    _expect_columns(path, named["chunk"], _BOUNDS + _COLOUR_BOUNDS * has_colours, "f4")
    _expect_columns(path, named["vertex"], _PACKED, "u4")
    _expect_count(path, named["chunk"], -(-count // _CHUNK))
    if "sh" in tables:
        rest = len(named["sh"].properties)
        if rest not in REST_COUNTS[1:]:
            raise Error(f"{path}: expected 9, 24 or 45 properties of sh, found {rest}")
        _expect_columns(path, named["sh"], tuple(f"f_rest_{k}" for k in range(rest)), "u1")
        _expect_count(path, named["sh"], count)
    expect_end(path, order, elements, first)
    return PackedPly(path, tables["chunk"], tables["vertex"], tables.get("sh"))


def _expect_columns(path: str, element: PlyElement, names: tuple[str, ...], kind: str) -> None:
    types = {one.name: one.type for one in element.properties}
    wrong = [name for name in names if types.get(name) != kind]
    if wrong:
        words = {"f4": "float", "u4": "uint", "u1": "uchar"}[kind]
        found = "another type" if wrong[0] in types else "none"
        raise Error(
            f"{path}: expected {element.name} with {wrong[0]} of the type {words}, found {found}"
        )


def _expect_count(path: str, element: PlyElement, expected: int) -> None:
    if element.count != expected:
        raise Error(
            f"{path}: expected {expected:,} rows of {element.name} for its splats, found "
            f"{element.count:,}"
        )
