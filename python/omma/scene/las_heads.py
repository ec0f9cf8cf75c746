"""What LAS files say of themselves, checked before laspy reads them, and its errors."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager

from omma._core import Error
from omma.base.beginnings import beginning_of
from omma.base.files import reading

# Of a header: three scales and three offsets, which make places of whole numbers (ASPRS LAS 1.4
# R15, table 3). Scales beyond the limits, as 0 is, leave nothing of places along their axis.
_PLACES_AT = 131
_LEAST_SCALE, _MOST = 1e-18, 1e18


@contextmanager
def reading_las(path: str) -> Iterator[None]:
    """Whatever laspy and what unpacks for it raise, as omma.Error that names the file."""
    try:
        with reading(path, "LAS"):
            yield
    except BaseException as error:
        if type(error).__name__ != "PanicException":
            raise
        # Of Rust, in lazrs: no Exception, though the file is what is wrong.
        raise Error(f"{path}: cannot be read as LAZ: {error!s:.300}") from None


def check_las_head(path: str) -> int:
    """That a file has the points of its header, scales and offsets that say where they are, and no
    more records of variable length than it can have, which laspy would wait for. How many more
    points lie behind those that the header counts.

    The numbers of these records are at bytes 100 and, from LAS 1.4 on, 243 (ASPRS LAS 1.4 R15,
    table 3).
    """
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        head = file.read(375)
    number = [int.from_bytes(head[at : at + 4], "little") for at in (100, 243)]
    if head[:4] != b"LASF":
        raise Error(f"{path}: expected a file that begins with LASF, found {beginning_of(head)}")
    if len(head) < 227:
        raise Error(f"{path}: expected a header of 227 bytes, found {len(head)}")
    _check_places(path, head)
    extended = number[1] if head[25] >= 4 else 0
    if 54 * number[0] + 60 * extended > size:
        raise Error(f"{path}: expected as many records as its header says, found {size:,} bytes")
    if head[104] & 0x80:
        _check_chunk_table(path, int.from_bytes(head[96:100], "little"), size)
        return 0
    return _not_counted(path, head, size)


def _check_places(path: str, head: bytes) -> None:
    """That whole numbers become places: by scales and offsets that can be."""
    numbers = struct.unpack_from("<6d", head, _PLACES_AT)
    for axis, scale, offset in zip("xyz", numbers[:3], numbers[3:]):
        if not _LEAST_SCALE <= abs(scale) <= _MOST:
            expected = f"{_LEAST_SCALE:g} to {_MOST:g}"
            raise Error(f"{path}: expected a scale of {axis} of {expected}, found {scale:g}")
        if not abs(offset) <= _MOST:
            raise Error(f"{path}: expected an offset of {axis} up to {_MOST:g}, found {offset:g}")


def _not_counted(path: str, head: bytes, size: int) -> int:
    """Points behind those that the header of a LAS file counts: whole records, up to what may
    follow them, waveforms (LAS 1.3) and extended records (LAS 1.4)."""
    minor = head[25]
    begin, length = int.from_bytes(head[96:100], "little"), int.from_bytes(head[105:107], "little")
    count = int.from_bytes(head[247:255] if minor >= 4 else head[107:111], "little")
    if not length:
        raise Error(f"{path}: expected a length of its points' records, found 0")
    if begin + count * length > size:
        there = max(size - begin, 0) // length
        raise Error(f"{path}: expected {count:,} points, found the end of the file after {there:,}")
    starts = [int.from_bytes(head[at : at + 8], "little") for at in (227, 235)[: max(minor - 2, 0)]]
    left = min([one for one in starts if one], default=size) - begin - count * length
    return left // length if left > 0 and left % length == 0 else 0


def _check_chunk_table(path: str, begin: int, size: int) -> None:
    """Of a LAZ file: no more chunks than it has bytes, for which lazrs takes memory at once. Where
    their table lies stands before the points, or at the end (-1); its second number is how many."""
    with open(path, "rb") as file:
        file.seek(min(begin, size))
        at = int.from_bytes(file.read(8), "little", signed=True)
        if at == -1:
            file.seek(size - 8)
            at = int.from_bytes(file.read(8), "little", signed=True)
        file.seek(min(max(at, 0), size))
        table = file.read(8)
    if len(table) < 8 or int.from_bytes(table[4:], "little") > size:
        raise Error(f"{path}: expected a table of its chunks, found it cut off or damaged")
