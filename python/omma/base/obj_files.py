"""OBJ files: tinyobjloader reads them, in double precision. It cuts names at their first space,
knows no lines that go on after a backslash, no comments behind faces, and stops at no index too
large, so the lines that name materials are numbered before it sees them, and what it gives is
checked. Of what its Python package has, the lists are right; its arrays (numpy_indices and their
kin) are not in all versions. What is no number it takes for 0, or cuts off where it no longer is
one, so numbers are looked at before.
"""

from __future__ import annotations

import os
import re
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error
from omma.base.arrays import Ints
from omma.base.mesh_parts import MeshParts, Piece, linear
from omma.base.mtl_files import Materials
from omma.base.named_files import MATERIAL_LIBRARY, text_of_name
from omma.base.optional import needs
from omma.base.polygons import triangulate

_USE = re.compile(rb"^[ \t]*usemtl\b[ \t]*([^\r\n]*)", re.MULTILINE)
# x, y, z, and w or a colour behind them; in texture coordinates 1 to 3 numbers.
_NUMBER = rb"[ \t]+[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_END = rb"[ \t]*(?:#[^\r\n]*)?\r?$"
_NO_VERTEX, _NO_COORDINATE, _NO_NORMAL = (
    re.compile(
        rb"^[ \t]*%s(?=[ \t])(?!(?:%s){%s}%s)[^\r\n]*" % (kind, _NUMBER, count, _END), re.MULTILINE
    )
    for kind, count in ((b"v", b"3,8"), (b"vt", b"1,3"), (b"vn", b"3"))
)
# Numbers of a vertex, which is not 0, of its texture coordinate and of its normal.
_CORNER = rb"[ \t]+[+-]?0*[1-9]\d*(?:/[+-]?\d*){0,2}"
_NO_FACE = re.compile(rb"^[ \t]*f(?=[ \t])(?!(?:%s)+%s)[^\r\n]*" % (_CORNER, _END), re.MULTILINE)
# Slashes with nothing behind them, after which the library takes the next corner's number.
_OPEN = re.compile(rb"/+(?=[ \t\r\n]|\Z)")
_WITH_OPEN = re.compile(rb"^[ \t]*f[ \t][^\r\n]*?/(?=[ \t\r\n]|\Z)[^\r\n]*", re.MULTILINE)
_COMMENT = re.compile(rb"^([ \t]*f[ \t][^\r\n#]*)#[^\r\n]*", re.MULTILINE)
# Lines that go on after a backslash, with the last of them.
_CONTINUED = re.compile(rb"^(?:[^\n]*\\[ \t]*\r?\n)+[^\n]*", re.MULTILINE)
_CURVED = re.compile(rb"^[ \t]*(?:curv2?|surf)[ \t]", re.MULTILINE)


def read_obj(path: str) -> MeshParts:
    """The parts of an OBJ file, one piece for each material."""
    data = _core.read_file(path)
    if b"\\" in data:
        data = _CONTINUED.sub(_in_one_line, data)
    _expect_lines(path, data)
    data = _COMMENT.sub(rb"\1", data)
    data = _WITH_OPEN.sub(lambda face: _OPEN.sub(b"", face[0]), data)
    libraries = [text_of_name(one).strip() for one in MATERIAL_LIBRARY.findall(data)]
    names: dict[bytes, int] = {}

    def numbered(found: re.Match[bytes]) -> bytes:
        return b"usemtl %d" % names.setdefault(found[1].strip(), len(names))

    data = MATERIAL_LIBRARY.sub(b"", _USE.sub(numbered, data))
    reader = _parsed(path, b"mtllib m\n" + data, len(names))
    used = [text_of_name(one) for one in names]
    materials = Materials(path, libraries, used)
    parts = materials.parts
    _add_pieces(path, data, reader, parts, used)
    if wrong := len(_NO_COORDINATE.findall(data)):
        parts.warnings.append(
            f"{wrong} texture coordinates are no numbers, and count as 0 where they are none"
        )
    if wrong := len(_NO_NORMAL.findall(data)):
        parts.warnings.append(f"{wrong} normals are no numbers; normals of OBJ files do not count")
    if _CURVED.search(data):
        parts.warnings.append("curves and curved surfaces are not shown")
    return parts


def _in_one_line(found: re.Match[bytes]) -> bytes:
    """Lines that go on as one, with empty ones behind it, so that others keep their numbers."""
    one = re.sub(rb"\\[ \t]*\r?\n", b" ", found[0])
    return one + b"\n" * (found[0].count(b"\n") - one.count(b"\n"))


def _expect_lines(path: str, data: bytes) -> None:
    """omma.Error where a vertex has no position or a face is not one of numbers."""
    vertex, face = _NO_VERTEX.search(data), _NO_FACE.search(data)
    found = vertex or face
    if found is None:
        return
    line = data.count(b"\n", 0, found.start()) + 1
    expected = "v and three finite numbers or more"
    if vertex is None:
        expected = "f and corners as 1, 1/2, 1//3 or 1/2/3, numbers of vertices not 0"
    commas = "; decimals are behind points, not commas" if b"," in found[0] else ""
    raise Error(
        f"{path}: line {line}: expected {expected}, found "
        f"{text_of_name(found[0].strip())!r:.60}{commas}"
    )


def _parsed(path: str, data: bytes, material_count: int) -> Any:
    loader = _tinyobjloader()
    reader, settings = loader.ObjReader(), loader.ObjReaderConfig()
    settings.triangulate = False
    known = "".join(f"newmtl {i}\n" for i in range(material_count))
    if not reader.ParseFromString(data.decode("latin-1"), known, settings):
        # Its line numbers are one too large, by the line that names the materials.
        said = re.sub(r"[Ll]ine (\d+)", lambda at: f"line {int(at[1]) - 1}", reader.Error())
        if (face := re.search(r"parse `f' line.*?(line \d+)", said, re.DOTALL)) is not None:
            raise Error(f"{path}: {face[1]}: expected a face of vertices that stand before it")
        raise Error(f"{path}: not readable as OBJ: {' '.join(said.split()) or 'no reason given'}")
    return reader


def _expect_indices(path: str, data: bytes, many: str, index: Ints, size: int) -> None:
    """omma.Error where a face has a vertex or a texture coordinate that the file does not; -1 is
    no texture coordinate."""
    is_vertex = many == "vertices"
    bad = index[(index < (0 if is_vertex else -1)) | (index >= size)]
    if not len(bad):
        return
    number = int(bad[0]) + 1
    before = b"" if is_vertex else rb"[^\s/]+/"
    face = rb"^[ \t]*f[ \t](?:[^\r\n]*[ \t])?%s\+?0*%d(?=[/ \t\r\n]|\Z)" % (before, number)
    found = re.search(face, data, re.MULTILINE)
    above = 0 if found is None else data.count(b"\n", 0, found.start())
    line = "" if found is None else f"line {above + 1}: "
    raise Error(
        f"{path}: {line}expected faces of the {size} {many} that there are, found one of "
        f"number {number}"
    )


def _add_pieces(path: str, data: bytes, reader: Any, parts: MeshParts, used: list[str]) -> None:
    attributes = reader.GetAttrib()
    positions = _rows(attributes.vertices, 3)
    coordinates = _rows(attributes.texcoords, 2)
    colors = _rows(attributes.colors, 3)
    shapes = reader.GetShapes()
    if any(len(one.lines.indices) or len(one.points.indices) for one in shapes):
        parts.warnings.append("points and lines are not shown")
    faces = [one.mesh for one in shapes if len(one.mesh.material_ids)]
    if not faces:
        return
    counts = _joined([one.num_face_vertices for one in faces])
    material = _joined([one.material_ids for one in faces])
    vertex = _joined([one.vertex_indices() for one in faces])
    coordinate = _joined([one.texcoord_indices() for one in faces])
    _expect_indices(path, data, "vertices", vertex, len(positions))
    _expect_indices(path, data, "texture coordinates", coordinate, len(coordinates))
    cut = triangulate(positions, vertex, counts)
    if cut.crossed:
        parts.warnings.append(
            f"{cut.crossed} of {len(counts)} faces cross themselves; they are filled in one way "
            "of several"
        )
    stem = os.path.splitext(os.path.basename(path))[0]
    shown = colors if len(colors) == len(positions) and (colors != 1).any() else None
    if shown is not None and (shown.max() > 1 or shown.min() < 0):
        shown = np.clip(shown / (255 if shown.max() > 1 else 1), 0, 1)
    of_triangle = material[cut.face]
    for number in np.unique(of_triangle).tolist():
        at = cut.corners[of_triangle == number]
        # Vertices with their texture coordinates, each pair once.
        pair = vertex[at].ravel() * (len(coordinates) + 1) + coordinate[at].ravel() + 1
        pairs, triangles = np.unique(pair, return_inverse=True)
        of, texel = pairs // (len(coordinates) + 1), pairs % (len(coordinates) + 1) - 1
        # Corners without one beside others that have one read the picture's first pixel.
        laid = np.where(texel[:, None] >= 0, coordinates[texel], 0) if (texel >= 0).any() else None
        parts.pieces.append(
            Piece(
                used[number] if number >= 0 and used[number] else stem,
                positions[of],
                triangles.reshape(-1, 3),
                None if laid is None else laid * (1, -1) + (0, 1),
                None if shown is None else linear(np.insert(shown[of], 3, 1.0, axis=1)),
                number if number >= 0 else len(used),
            )
        )
    if not (of_triangle < 0).any():
        parts.materials.pop()  # of faces that name none


def _rows(flat: Any, columns: int) -> NDArray[np.float64]:
    values = np.array(flat, np.float64).reshape(-1)
    return values[: len(values) // columns * columns].reshape(-1, columns)


def _joined(lists: list[list[int]]) -> Ints:
    return np.concatenate([np.array(one, np.int64) for one in lists])


def _tinyobjloader() -> ModuleType:
    module: ModuleType = needs("tinyobjloader", "obj", "OBJ files need tinyobjloader")
    return module
