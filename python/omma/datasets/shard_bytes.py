"""A shard of an array as the bytes of its file, as Zarr 3 has them.

zarr would make the same bytes, in three times the processor time: every chunk goes through an event
loop and a thread there. The format is in Zarr's specification: the sharding-indexed codec with its
index at the end, chunks in the order of the views, each packed by Blosc and with its CRC32C.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.rendering.labelled_files import load_package

# How chunks are packed: LZ4 is fast both ways, and bytes of floats are alike where shuffled.
COMPRESSION: dict[str, Any] = {"cname": "lz4", "clevel": 5, "shuffle": "shuffle"}
# And what is behind each, by which changed bits are noticed when they are read.
CHECKSUM = "crc32c"

# Offset and length of a chunk that is not there.
_NO_CHUNK = (1 << 64) - 1


def chunk_bytes(values: NDArray[Any], views: int, fill: float, *, is_summed: bool = True) -> bytes:
    """One chunk of so many views, whose first are ``values``; the others are filled.

    Args:
        is_summed: False: without a checksum, as in stores of older versions.
    """
    chunk = _packed(_codec(), values, views, fill)
    return _summed(chunk) if is_summed else chunk


def shard_bytes(
    values: NDArray[Any],
    views_per_chunk: int,
    views_per_shard: int,
    fill: float,
    *,
    is_summed: bool = True,
) -> bytes:
    """A shard with these views as its first, and with no chunks behind them."""
    index = np.full((views_per_shard // views_per_chunk, 2), _NO_CHUNK, "<u8")
    codec = _codec()
    chunks, offset = [], 0
    for k, first in enumerate(range(0, len(values), views_per_chunk)):
        chunk = _packed(codec, values[first : first + views_per_chunk], views_per_chunk, fill)
        if is_summed:
            chunk = _summed(chunk)
        index[k] = offset, len(chunk)
        offset += len(chunk)
        chunks.append(chunk)
    return b"".join([*chunks, _summed(index.tobytes())])


def _codec() -> Any:
    load_package("zarr", "datasets")  # which turns Blosc's own threads off
    blosc = load_package("numcodecs", "datasets").Blosc
    return blosc(COMPRESSION["cname"], COMPRESSION["clevel"], blosc.SHUFFLE)


def _summed(data: bytes) -> bytes:
    """With its checksum behind it."""
    crc32c = load_package("google_crc32c", "datasets")
    return data + int(crc32c.value(data)).to_bytes(4, "little")


def _packed(codec: Any, values: NDArray[Any], views: int, fill: float) -> bytes:
    if len(values) < views:
        whole = np.full((views, *values.shape[1:]), fill, values.dtype)
        whole[: len(values)] = values
        values = whole
    return bytes(codec.encode(np.ascontiguousarray(values)))
