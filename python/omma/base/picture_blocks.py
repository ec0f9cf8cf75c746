"""What JPEG, PNG and WebP files have beside their pixels: blocks of EXIF, of XMP and of others."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple


class BlockNames(NamedTuple):
    """What blocks of a kind are called: in JPEG how a segment APP1 begins, in PNG and WebP the name
    of a chunk."""

    jpeg: bytes
    png: bytes
    webp: bytes


def picture_blocks(file: BinaryIO, names: BlockNames) -> Iterator[bytes]:
    """The blocks of a kind in a file, as far as it is whole; of JPEG without how they begin."""
    begins = file.read(12)
    if begins.startswith(b"\xff\xd8"):
        file.seek(2)
        yield from _of_jpeg(file, names.jpeg)
    elif begins.startswith(b"\x89PNG"):
        file.seek(8)
        yield from _of_chunks(file, names.png, is_png=True)
    elif begins.startswith(b"RIFF") and begins.endswith(b"WEBP"):
        yield from _of_chunks(file, names.webp, is_png=False)


def _of_jpeg(file: BinaryIO, begin: bytes) -> Iterator[bytes]:
    """Of the segments before the pixels those that begin so."""
    while len(head := file.read(4)) == 4 and head[0] == 0xFF and head[1] != 0xDA:
        length = int.from_bytes(head[2:], "big") - 2
        if length < 0:
            return
        block = file.read(length)
        if head[1] == 0xE1 and block.startswith(begin):
            yield block.removeprefix(begin)


def _of_chunks(file: BinaryIO, wanted: bytes, *, is_png: bool) -> Iterator[bytes]:
    """Of the chunks of a PNG or WebP file those of a kind."""
    while len(head := file.read(8)) == 8:
        kind, size = (head[4:], head[:4]) if is_png else (head[:4], head[4:])
        length = int.from_bytes(size, "big" if is_png else "little")
        after = 4 if is_png else length % 2
        if kind == wanted:
            yield file.read(length)
            file.seek(after, os.SEEK_CUR)
        else:
            file.seek(length + after, os.SEEK_CUR)
