"""Headers of PLY files: what elements there are, and of what properties."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from omma._core import Error
from omma.base.beginnings import beginning_of

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
# Of one line of a header, and of all of it.
LONGEST_HEADER = 1 << 20
# Bytes looked at behind the last row.
_TAIL = 64


class PlyProperty(NamedTuple):
    name: str
    type: str
    count_type: str  # of lists, else ""


@dataclass
class PlyElement:
    name: str
    count: int
    properties: list[PlyProperty] = field(default_factory=list)


def read_header(path: str, data: bytes, size: int) -> tuple[str, list[PlyElement], str, int]:
    """Order of bytes ("" for text), elements, name of the picture ("" for none), where rows begin.

    ``data`` is the file's beginning, ``size`` how many bytes the whole has.
    """
    if not data.startswith(b"ply"):
        raise Error(
            f"{path}: not readable as PLY: expected 'ply' in the first line, found "
            f"{beginning_of(data)}"
        )
    order: str | None = None
    elements: list[PlyElement] = []
    picture, at, number = "", 0, 0
    while True:
        end = data.find(b"\n", at, at + LONGEST_HEADER)
        if end < 0:
            raise Error(f"{path}: not readable as PLY: expected a header that ends in end_header")
        line = data[at:end].decode("utf-8", "replace").strip()
        at, number = end + 1, number + 1
        words = line.split()
        where = f"{path}, line {number}"
        if line == "end_header":
            break
        if words[:1] == ["format"]:
            order = _ORDERS.get(words[1] if len(words) > 1 else "")
            if order is None:
                known = ", ".join(_ORDERS)
                raise Error(f"{where}: expected the format {known}, found '{line[:60]}'")
        elif words[:1] == ["element"]:
            if len(words) != 3 or not (words[2].isascii() and words[2].isdecimal()):
                raise Error(f"{where}: expected 'element NAME COUNT', found '{line[:60]}'")
            elements.append(PlyElement(words[1], int(words[2])))
        elif words[:1] == ["property"]:
            is_list = words[1:2] == ["list"]
            if not elements or len(words) != (5 if is_list else 3):
                raise Error(f"{where}: expected a property of an element, found '{line[:60]}'")
            unknown = [one for one in words[2 if is_list else 1 : -1] if one not in _TYPES]
            if unknown or (is_list and _TYPES[words[2]][0] == "f"):
                raise Error(f"{where}: expected a type of PLY, found '{line[:60]}'")
            count_type = _TYPES[words[2]] if is_list else ""
            elements[-1].properties.append(PlyProperty(words[-1], _TYPES[words[-2]], count_type))
        elif words[:2] == ["comment", "TextureFile"]:
            picture = line.partition("TextureFile")[2].strip()
    if order is None:
        raise Error(f"{path}: not readable as PLY: expected a line that says the format")
    # No row takes less than a byte: whoever claims more than the file has is not waited for.
    claimed = sum(one.count for one in elements if one.properties)
    if claimed > size:
        raise Error(f"{path}: expected {claimed} rows as its header says, found {size} bytes")
    return order, elements, picture, at


def expect_end(path: str, order: str, elements: list[PlyElement], begin: int) -> None:
    """omma.Error where a binary file goes on behind its last row; of lists nothing is known."""
    if any(one.count and each.count_type for one in elements for each in one.properties):
        return
    types = [(one.count, [("", order + each.type) for each in one.properties]) for one in elements]
    end = begin + sum(count * np.dtype(row).itemsize for count, row in types)
    with open(path, "rb") as file:
        file.seek(end)
        expect_no_more(path, file.read(_TAIL), os.path.getsize(path) - end)


def expect_no_more(path: str, tail: bytes, size: int) -> None:
    """omma.Error where so many bytes, which begin with ``tail``, are more than line ends."""
    if tail[:_TAIL].strip(b" \t\r\n\0"):
        raise Error(
            f"{path}: expected the end of the file behind the rows of its header, found {size:,} "
            "bytes more"
        )
