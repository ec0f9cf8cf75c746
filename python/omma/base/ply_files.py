"""PLY files, text and binary, with polygons, colours and texture coordinates of vertices and faces.

Read here, with NumPy: of what there is, trimesh and meshio refuse binary files whose faces differ
in their number of corners (Blender writes such), VTK and pyminiply round to single precision,
Open3D takes 400 MB, meshio++ is young, and plyfile is under the GPL. The format is a header and a
table.
"""

from __future__ import annotations

import os
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error, Image, Material, Texture
from omma.base.mesh_parts import MeshParts, Piece, colors_and_mode, linear
from omma.base.mesh_pictures import opaque, read_picture
from omma.base.number_lines import are_numbers, line_error, numbers_in, words_in_lines
from omma.base.ply_header import PlyElement, expect_no_more, read_header
from omma.base.polygons import triangulate

_CORNERS = ("vertex_indices", "vertex_index")
_COORDINATES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


class _Ragged(NamedTuple):
    """Lists of a property, one for each row."""

    counts: NDArray[np.int64]
    values: NDArray[Any]


_Columns = dict[str, Any]  # by name: an array of each row's value, or _Ragged


def read_ply(path: str) -> MeshParts:
    """The parts of a PLY file: one piece."""
    data = _core.read_file(path)
    order, elements, picture, body = read_header(path, data, len(data))
    if order == "":
        tables = _text_tables(path, elements, data[body:], 1 + data.count(b"\n", 0, body))
    else:
        tables = _binary_tables(path, elements, data[body:], order)
    return _parts(path, tables, picture)


def _text_tables(
    path: str, elements: list[PlyElement], body: bytes, first: int
) -> dict[str, _Columns]:
    """``first``: the number of the line with which the body begins."""
    numbers, words = numbers_in(body), words_in_lines(body)
    lines = np.flatnonzero(words)
    if numbers is None or len(numbers) != words.sum():
        texts = body.split(b"\n")
        bad = next((k for k in lines.tolist() if not are_numbers(texts[k])), 0)
        raise line_error(path, first + bad, "numbers", texts[bad])
    # Few files break rows into several lines, or join them.
    is_row = len(lines) == sum(one.count for one in elements if one.properties)
    tables: dict[str, _Columns] = {}
    at = row = 0
    for one in elements:
        tables[one.name], starts = _rows_of(path, one, numbers, at)
        at = int(starts[-1])
        if is_row and one.properties:
            here = lines[row : row + one.count]
            row += one.count
            wrong = np.flatnonzero(words[here] != np.diff(starts))
            if len(wrong):
                bad, length = int(here[wrong[0]]), int(np.diff(starts)[wrong[0]])
                expected = f"{length} numbers of {one.name} {wrong[0]}"
                raise line_error(path, first + bad, expected, body.split(b"\n")[bad])
    if at < len(numbers):
        raise Error(
            f"{path}: expected the end of the file behind the rows of its header, found "
            f"{len(numbers) - at:,} numbers more"
        )
    return tables


def _rows_of(
    path: str, element: PlyElement, numbers: NDArray[np.float64], at: int
) -> tuple[_Columns, NDArray[np.int64]]:
    """The columns of an element from numbers in a row; where its rows and the next begin."""
    lists = [i for i, one in enumerate(element.properties) if one.count_type]
    width = len(element.properties)
    # Where each row begins and how long its lists are; few files have lists of differing lengths.
    starts = np.empty(element.count + 1, np.int64)
    counts = np.zeros((element.count, len(lists)), np.int64)
    total = len(numbers)
    same = _same_lengths(element, numbers, at)
    if same is not None:
        counts[:] = same
        starts[:] = at + (width + sum(same)) * np.arange(element.count + 1)
    else:
        here = at
        for row in range(element.count):
            starts[row] = here
            for k, i in enumerate(lists):
                # Behind the properties before it, and the lists among them.
                offset = here + i + int(counts[row, :k].sum())
                length = numbers[offset] if offset < total else -1.0
                if not 0 <= length <= total:
                    raise Error(f"{path}: {element.name} {row}: expected a list, found no length")
                counts[row, k] = int(length)
            here += width + int(counts[row].sum())
        starts[-1] = here
    if starts[-1] > len(numbers):
        raise Error(
            f"{path}: expected {element.count} of {element.name}, found the end of the file"
        )
    columns: _Columns = {}
    offset = starts[:-1].copy()
    for i, one in enumerate(element.properties):
        if one.count_type:
            length = counts[:, lists.index(i)]
            columns[one.name] = _Ragged(length, numbers[_ranges(offset + 1, length)])
            offset = offset + 1 + length
        else:
            found = numbers[offset]
            # What is called float keeps the digits of the text.
            with np.errstate(invalid="ignore"):
                columns[one.name] = found if one.type[0] == "f" else found.astype(one.type)
            offset = offset + 1
    return columns, starts


def _same_lengths(element: PlyElement, numbers: NDArray[np.float64], at: int) -> list[int] | None:
    """How long the lists of the first row are, if those of all rows are as long."""
    lengths: list[int] = []
    heads: list[int] = []
    for i, one in enumerate(element.properties):
        if one.count_type:
            heads.append(i + sum(lengths))
            first = numbers[at + heads[-1]] if at + heads[-1] < len(numbers) else -1.0
            if not 0 <= first <= len(numbers):
                return None
            lengths.append(int(first))
    width = len(element.properties) + sum(lengths)
    if at + width * element.count > len(numbers):
        return None
    rows = numbers[at : at + width * element.count].reshape(element.count, width)
    return lengths if (rows[:, heads] == lengths).all() else None


def _binary_tables(
    path: str, elements: list[PlyElement], body: bytes, order: str
) -> dict[str, _Columns]:
    tables: dict[str, _Columns] = {}
    at = 0
    for one in elements:
        types = [np.dtype(order + each.type) for each in one.properties]
        if any(each.count_type for each in one.properties):
            columns, at = _binary_lists(path, one, body, at, order)
        else:
            row = np.dtype([(str(i), each) for i, each in enumerate(types)])
            if at + one.count * row.itemsize > len(body):
                raise Error(
                    f"{path}: expected {one.count} of {one.name}, found the end of the file"
                )
            rows = np.frombuffer(body, row, one.count if row.itemsize else 0, at)
            columns = {each.name: rows[str(i)] for i, each in enumerate(one.properties)}
            at += one.count * row.itemsize
        tables[one.name] = columns
    expect_no_more(path, body[at : at + 64], len(body) - at)
    return tables


def _binary_lists(
    path: str, element: PlyElement, body: bytes, at: int, order: str
) -> tuple[_Columns, int]:
    """The columns of an element that has lists, and where the next element begins."""
    same = _same_rows(element, body, at, order)
    if same is not None:
        columns: _Columns = {}
        for i, one in enumerate(element.properties):
            values = same[f"{i}"]
            if one.count_type:
                alike = np.full(element.count, values.shape[1], np.int64)
                columns[one.name] = _Ragged(alike, values.reshape(-1))
            else:
                columns[one.name] = values
        return columns, at + element.count * same.dtype.itemsize
    sizes = [np.dtype(one.type).itemsize for one in element.properties]
    heads = [
        np.dtype(one.count_type).itemsize if one.count_type else 0 for one in element.properties
    ]
    byte_order: Literal["big", "little"] = "big" if order == ">" else "little"
    # Bytes where each property's values begin, and how many there are.
    offsets = np.empty((len(sizes), element.count), np.int64)
    counts = np.ones((len(sizes), element.count), np.int64)
    end = len(body)
    for row in range(element.count):
        for i, size in enumerate(sizes):
            if heads[i]:
                length = int.from_bytes(body[at : at + heads[i]], byte_order)
                at += heads[i]
                counts[i, row] = length if at + length * size <= end else end + 1
                offsets[i, row] = at
                at += length * size
            else:
                offsets[i, row] = at
                at += size
        if at > end:
            raise Error(
                f"{path}: expected {element.count} of {element.name}, found the end of the file at "
                f"{element.name} {row}"
            )
    raw = np.frombuffer(body, np.uint8)
    columns = {}
    for i, one in enumerate(element.properties):
        picked = raw[_ranges(offsets[i], counts[i] * sizes[i])]
        values = picked.view(np.dtype(order + one.type))
        columns[one.name] = _Ragged(counts[i], values) if one.count_type else values
    return columns, at


def _same_rows(element: PlyElement, body: bytes, at: int, order: str) -> NDArray[Any] | None:
    """The rows as they lie there, if the lists of all are as long as those of the first."""
    fields: list[tuple[Any, ...]] = []
    heads: list[str] = []
    for i, one in enumerate(element.properties):
        if not one.count_type:
            fields.append((f"{i}", order + one.type))
            continue
        head = np.dtype(order + one.count_type)
        here = at + np.dtype(fields).itemsize
        if here + head.itemsize > len(body):
            return None
        length = int(np.frombuffer(body, head, 1, here)[0])
        if not 0 <= length <= len(body):
            return None
        heads.append(f"head {i}")
        fields += [(heads[-1], head), (f"{i}", order + one.type, (length,))]
    try:
        row = np.dtype(fields)
    except ValueError:  # longer than any row can be
        return None
    if at + element.count * row.itemsize > len(body):
        return None
    rows = np.frombuffer(body, row, element.count, at)
    is_same = all((rows[head] == rows[head][:1]).all() for head in heads)
    return rows if is_same else None


def _ranges(starts: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """start, start + 1, ... of each, one after the other."""
    before = np.cumsum(counts) - counts
    return np.repeat(starts - before, counts) + np.arange(int(counts.sum()))


def _parts(path: str, tables: dict[str, _Columns], picture: str) -> MeshParts:
    parts = MeshParts()
    vertices, faces = tables.get("vertex", {}), tables.get("face", {})
    if not all(isinstance(vertices.get(axis), np.ndarray) for axis in "xyz"):
        raise Error(f"{path}: expected vertices with x, y and z")
    positions = np.stack([vertices[axis].astype(np.float64) for axis in "xyz"], axis=1)
    if tables.get("tristrips"):
        parts.warnings.append("triangle strips are not shown")
    corners = next((faces[name] for name in _CORNERS if name in faces), None)
    if not isinstance(corners, _Ragged):
        return parts
    index = corners.values.astype(np.int64)
    bad = np.flatnonzero((index < 0) | (index >= len(positions)))
    if len(bad):
        raise Error(
            f"{path}: expected faces of {len(positions)} vertices, found one of vertex "
            f"{index[bad[0]]}"
        )
    cut = triangulate(positions, index, corners.counts)
    if cut.crossed:
        parts.warnings.append(
            f"{cut.crossed} of {len(corners.counts)} faces cross themselves; they are filled in "
            "one way of several"
        )
    colors = _colors(vertices)
    coordinates = _coordinates(vertices)
    triangles = index[cut.corners]
    own_colors = None if colors is not None else _colors(faces)
    own_coordinates = faces.get("texcoord") if coordinates is None else None
    if (
        isinstance(own_coordinates, _Ragged)
        and not (own_coordinates.counts == 2 * corners.counts).all()
    ):
        parts.warnings.append("texture coordinates of faces are passed over: two for each corner")
        own_coordinates = None
    if own_colors is not None or isinstance(own_coordinates, _Ragged):
        # What belongs to corners or faces: none of their vertices is another's.
        flat = cut.corners.ravel()
        positions, triangles = positions[index[flat]], np.arange(len(flat)).reshape(-1, 3)
        colors = None if colors is None else colors[index[flat]]
        if own_colors is not None:
            colors = np.repeat(own_colors[cut.face], 3, axis=0)
        if isinstance(own_coordinates, _Ragged):
            coordinates = own_coordinates.values.astype(np.float64).reshape(-1, 2)[flat]
        elif coordinates is not None:
            coordinates = coordinates[index[flat]]
    colors, mode = colors_and_mode(colors, parts.warnings)
    texture = None
    if picture and coordinates is not None:
        texture = _add_picture(path, picture, parts)
    parts.materials.append(Material(base_color_texture=texture, alpha_mode=mode, double_sided=True))
    parts.pieces.append(
        Piece(
            os.path.basename(path),
            positions,
            triangles,
            None if coordinates is None else coordinates * (1, -1) + (0, 1),
            colors,
            0,
        )
    )
    return parts


def _colors(columns: _Columns) -> NDArray[np.float64] | None:
    """Linear RGBA of a table's rows, whose colours are sRGB; None where it has none."""
    for prefix in ("", "diffuse_"):
        found = [columns.get(prefix + name) for name in ("red", "green", "blue", "alpha")]
        if all(isinstance(one, np.ndarray) for one in found[:3]):
            held = [one for one in found if isinstance(one, np.ndarray)]
            shown = np.stack([one.astype(np.float64) for one in held], axis=1)
            if held[0].dtype.kind in "iu" or shown.max(initial=0) > 1:
                shown = shown / (65535 if held[0].dtype.itemsize == 2 else 255)
            shown = np.clip(shown, 0, 1)
            return linear(shown if len(held) == 4 else np.insert(shown, 3, 1.0, axis=1))
    return None


def _coordinates(columns: _Columns) -> NDArray[np.float64] | None:
    for names in _COORDINATES:
        if all(isinstance(columns.get(name), np.ndarray) for name in names):
            return np.stack([columns[name].astype(np.float64) for name in names], axis=1)
    return None


def _add_picture(path: str, name: str, parts: MeshParts) -> int | None:
    """The number of the texture; None where its picture cannot be read, which is told."""
    file = os.path.join(os.path.dirname(path), name.replace("\\", "/"))
    try:
        if not os.path.isfile(file):
            raise Error(f"the picture {name} is missing; the mesh is seen without")
        parts.images.append(Image(opaque(read_picture(file)), name=name))
    except (Error, ValueError) as error:
        parts.warnings.append(str(error))
        return None
    parts.textures.append(Texture(len(parts.images) - 1))
    return len(parts.textures) - 1
