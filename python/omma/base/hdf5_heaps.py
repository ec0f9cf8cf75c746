"""Damaged heaps of HDF5 files, found before the HDF5 library reads some of them without end.

A global heap holds texts and lists of varying length: "GCOL", a version, its size, then objects,
each with an index, its own size and its bytes ("HDF5 File Format Specification Version 3.0", level
1E). HDF5 2.0 goes from one object to the next, and never on from free space of size 0.
"""

from __future__ import annotations

import mmap
import os

_SIGNATURE = b"GCOL\x01\x00\x00\x00"
_HEADER = 16  # of the heap and of each object, bytes
_SEARCHED = 128 << 20  # at both ends of a file: heaps are written with what describes the numbers


def check_heaps(name: str) -> None:
    """Raises:
    ValueError: of a heap that the library would read without end.
    OSError: the file cannot be read.
    """
    size = os.path.getsize(name)
    if size < _HEADER:
        return
    with open(name, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        if not _has_long_lengths(data):
            return
        last = max(_SEARCHED, size - _SEARCHED)
        for begin, end in ((0, _SEARCHED), (last, size)):
            at = data.find(_SIGNATURE, begin, end)
            while at >= 0:
                _check_heap(data, at, size)
                at = data.find(_SIGNATURE, at + 1, end)


def _has_long_lengths(data: mmap.mmap) -> bool:
    """Whether sizes have 8 bytes, as in all files but those made for tiny systems."""
    size_of_lengths = 14 if data[8] < 2 else 10  # by the superblock's version (level 0A)
    return data[size_of_lengths] == 8


def _check_heap(data: mmap.mmap, heap: int, size: int) -> None:
    def number(at: int, count: int) -> int:
        return int.from_bytes(data[at : at + count], "little")

    end = min(heap + number(heap + 8, 8), size)
    at = heap + _HEADER
    while at + _HEADER <= end:
        index, own = number(at, 2), number(at + 8, 8)
        taken = own if index == 0 else _HEADER + (own + 7) // 8 * 8
        if taken < _HEADER or taken > end - at:
            raise ValueError(f"a heap of texts is damaged at byte {at}")
        at += taken
