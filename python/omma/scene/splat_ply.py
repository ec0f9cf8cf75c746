"""PLY files of Gaussian splats as 3DGS trains and writes them (Kerbl et al. 2023): log scales,
logits of opacities, quaternions w, x, y, z, harmonics by colour. Files of Mip-Splatting that have
``filter_3D`` (Yu et al. 2024) hold Gaussians before that filter; it is applied here as its own
``save_fused_ply`` does, after which they are 3DGS's.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, SplatCloud
from omma.base.arrays import Floats
from omma.base.files import WholeFile
from omma.base.number_lines import text_tables
from omma.base.ply_header import PlyElement, expect_end
from omma.base.progress import Progress
from omma.scene.point_files import expect_all, holds_splats, ply_head
from omma.scene.splat_columns import PIECE, REST_COUNTS, SplatColumns, sample_of, sigmoid
from omma.scene.splat_packed_ply import read_packed_ply

_POSITION = ("x", "y", "z")
_COLOUR = ("f_dc_0", "f_dc_1", "f_dc_2")
_SCALE = ("scale_0", "scale_1", "scale_2")
_ROTATION = ("rot_0", "rot_1", "rot_2", "rot_3")  # w, x, y, z
_NEEDED = (*_POSITION, *_COLOUR, "opacity", *_SCALE, *_ROTATION)
_FILTER = "filter_3D"
_REST = "f_rest_"
# The logit of what is opaque, or not there, in files: infinite ones not every reader takes.
_OPAQUE = 40.0


def read_ply_splats(path: str, progress: Progress | None) -> SplatColumns:
    """All that can be used of the splats of a PLY file."""
    order, elements, begin = ply_head(path)
    names = [one.name for one in elements]
    if not holds_splats(elements):
        raise Error(
            f"{path}: expected Gaussian splats, vertices with f_dc_0, scale_0 and rot_0, found "
            f"{', '.join(names) or 'nothing'} without them"
        )
    vertex = elements[names.index("vertex")]
    if "packed_position" in {one.name for one in vertex.properties}:
        return read_packed_ply(path, order, elements, begin).read(progress)
    before = elements[: names.index("vertex")]
    if any(one.count_type for each in (*before, vertex) for one in each.properties):
        raise Error(f"{path}: expected vertices without lists in them or before them")
    wanted, terms = _wanted(path, vertex)
    if order == "":
        skipped = sum(one.count for one in before)
        is_last = not any(one.count for one in elements[len(before) + 1 :])
        blocks = _text_blocks(path, begin, vertex, wanted, skipped, is_last)
    else:
        if vertex.count:
            expect_end(path, order, elements, begin)
        begin += sum(one.count * _row_of(order, one).itemsize for one in before)
        expect_rows(path, vertex, begin, _row_of(order, vertex).itemsize)
        blocks = _binary_blocks(path, order, begin, vertex, wanted)
    columns = SplatColumns(path, vertex.count, terms)
    if order == "":
        places = [sample_of(block[:, :3], vertex.count) for block in blocks()]
        columns.find_offset(np.concatenate(places) if places else np.empty((0, 3)))
    else:
        columns.find_offset(_binary_places(path, order, begin, vertex))
    rows = 0
    for block in blocks():
        _add(columns, block, terms)
        rows += len(block)
        if progress is not None:
            progress(rows / vertex.count)
    expect_all(path, vertex.count, rows)
    return columns


def _row_of(order: str, element: PlyElement) -> np.dtype[Any]:
    # Without names, which a broken file may have twice.
    return np.dtype([("", order + one.type) for one in element.properties])


def expect_rows(path: str, element: PlyElement, begin: int, width: int) -> None:
    """omma.Error where a file ends before all rows of an element."""
    there = max(os.path.getsize(path) - begin, 0) // max(width, 1)
    expect_all(path, element.count, min(there, element.count))


def _wanted(path: str, vertex: PlyElement) -> tuple[list[str], int]:
    """The names of the columns to read, in the order in which blocks have them, and how many
    coefficients each colour has."""
    types: dict[str, str] = {}
    for one in vertex.properties:
        if one.name in types:
            raise Error(f"{path}: expected each property of vertices once, found {one.name} twice")
        types[one.name] = one.type
    missing = [name for name in _NEEDED if name not in types]
    if missing:
        raise Error(
            f"{path}: expected splats with {', '.join(_NEEDED)}, found none called "
            f"{', '.join(missing)}"
        )
    rest = [name for name in types if name.startswith(_REST)]
    if len(rest) not in REST_COUNTS:
        raise Error(
            f"{path}: expected harmonics of degree 0 to 3, {', '.join(map(str, REST_COUNTS))} "
            f"properties {_REST}0 and so on, found {len(rest)}"
        )
    ordered = [f"{_REST}{number}" for number in range(len(rest))]
    absent = [name for name in ordered if name not in types]
    if absent:
        raise Error(f"{path}: expected {_REST}0 to {ordered[-1]}, found no {absent[0]}")
    wanted = [*_NEEDED, *ordered, *([_FILTER] if _FILTER in types else [])]
    wrong = [name for name in wanted if types[name][0] != "f"]
    if wrong:
        raise Error(
            f"{path}: expected numbers of the type float or double, found {wrong[0]} of the type "
            f"{'int' if types[wrong[0]][0] == 'i' else 'uint'}{8 * int(types[wrong[0]][1])}"
        )
    return wanted, 1 + len(rest) // 3


def _text_blocks(
    path: str, begin: int, vertex: PlyElement, wanted: list[str], skipped: int, is_last: bool
) -> Callable[[], Iterator[NDArray[Any]]]:
    names = [one.name for one in vertex.properties]
    chosen = [names.index(name) for name in wanted]
    most, count = (None, vertex.count) if is_last else (vertex.count, None)

    def blocks() -> Iterator[NDArray[Any]]:
        for table in text_tables(path, begin, len(names), skipped=skipped, most=most, count=count):
            yield table[:, chosen]

    return blocks


def _binary_blocks(
    path: str, order: str, begin: int, vertex: PlyElement, wanted: list[str]
) -> Callable[[], Iterator[NDArray[Any]]]:
    """(n, columns), of the file's own type where all are of one, which is much faster."""
    names = [one.name for one in vertex.properties]
    row = _row_of(order, vertex)
    chosen = [names.index(name) for name in wanted]
    is_even = {one.type for one in vertex.properties} == {"f4"}

    def blocks() -> Iterator[NDArray[Any]]:
        with open(path, "rb") as file:
            file.seek(begin)
            for start in range(0, vertex.count, PIECE):
                some = np.fromfile(file, row, min(PIECE, vertex.count - start))
                if is_even:
                    even = some.view(order + "f4").reshape(len(some), len(names))
                    yield even.astype(np.float32, copy=False)[:, chosen]
                else:
                    columns = [some[f"f{k}"].astype(np.float64) for k in chosen]
                    yield np.stack(columns, axis=1)

    return blocks


def _binary_places(path: str, order: str, begin: int, vertex: PlyElement) -> NDArray[Any]:
    """Some positions (n, 3), of the file's own type where all are of one."""
    names = [one.name for one in vertex.properties]
    table = np.memmap(path, _row_of(order, vertex), "r", begin, (vertex.count,))
    some = np.array(sample_of(table, vertex.count))
    return np.stack([some[f"f{names.index(axis)}"] for axis in _POSITION], axis=1)


def _add(columns: SplatColumns, block: NDArray[Any], terms: int) -> None:
    offset = columns.offset
    positions = block[:, :3] - offset if offset.any() else block[:, :3]
    harmonics = np.empty((len(block), terms, 3), block.dtype)
    harmonics[:, 0] = block[:, 3:6]
    scales, quaternions = block[:, 7:10], block[:, 10:14]
    rest = block[:, 14 : 14 + 3 * (terms - 1)]
    harmonics[:, 1:] = rest.reshape(len(block), 3, terms - 1).transpose(0, 2, 1)
    opacities = sigmoid(block[:, 6])
    if block.shape[1] > 14 + rest.shape[1]:
        scales, opacities = _filtered(scales, opacities, block[:, -1:])
    columns.add(positions, scales, quaternions[:, [1, 2, 3, 0]], opacities, harmonics)


def _filtered(
    log_scales: NDArray[Any], opacities: Floats, filter_3d: NDArray[Any]
) -> tuple[Floats, Floats]:
    """Log scales and opacities of Gaussians smoothed by a round one of that standard deviation,
    whose integral stays."""
    with np.errstate(over="ignore", under="ignore", divide="ignore", invalid="ignore"):
        before = np.exp(log_scales.astype(np.float64))
        after = np.hypot(before, filter_3d.astype(np.float64))
        return np.log(after), opacities * np.prod(before / after, axis=1)


def ply_header_of(count: int, terms: int, is_far: bool = False) -> bytes:
    """The header of a file as 3DGS writes it, little-endian; of splats far from the origin with
    positions in double precision."""
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count}"]
    lines += [
        f"property {'double' if is_far and name in _POSITION else 'float'} {name}"
        for name in _written(terms)
    ]
    return ("\n".join([*lines, "end_header"]) + "\n").encode()


def _written(terms: int) -> list[str]:
    rest = [f"{_REST}{number}" for number in range(3 * (terms - 1))]
    return [*_POSITION, "nx", "ny", "nz", *_COLOUR, *rest, "opacity", *_SCALE, *_ROTATION]


def write_ply_rows(file: WholeFile, splats: SplatCloud, offset: Floats) -> None:
    """Rows of splats that are, but for an offset (3,), in the file's frame already. Normals, which
    mean nothing, are 0."""
    count, terms = splats.harmonics.shape[:2]
    table = np.zeros((count, len(_written(terms))), "<f4")
    table[:, :3] = splats.positions_m
    table[:, 6:9] = splats.harmonics[:, 0]
    rest = splats.harmonics[:, 1:].transpose(0, 2, 1)
    table[:, 9 : 9 + 3 * (terms - 1)] = rest.reshape(count, -1)
    with np.errstate(divide="ignore"):
        opacities = splats.opacities.astype(np.float64)
        logits = np.log(opacities) - np.log1p(-opacities)
    table[:, -8] = np.clip(logits, -_OPAQUE, _OPAQUE)
    table[:, -7:-4] = np.log(splats.scales_m.astype(np.float64))
    table[:, -4:] = splats.rotations[:, [3, 0, 1, 2]]
    if not offset.any():
        file.write(table.tobytes())
        return
    wide = np.empty(count, [("position", "<f8", 3), ("rest", "<f4", table.shape[1] - 3)])
    wide["position"] = splats.positions_m + offset
    wide["rest"] = table[:, 3:]
    file.write(wide.tobytes())
