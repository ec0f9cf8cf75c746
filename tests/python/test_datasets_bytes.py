"""Shards of data sets as bytes: those that zarr itself writes."""

import numpy as np
import pytest

from omma.datasets.shard_bytes import COMPRESSION, chunk_bytes, shard_bytes

zarr = pytest.importorskip("zarr")


def of_zarr(values, per_chunk, per_shard, fill, *, is_sharded, is_summed):
    kept = {}
    codec = zarr.codecs.BloscCodec(**COMPRESSION, typesize=values.dtype.itemsize)
    with zarr.config.set({"array.write_empty_chunks": True}):
        array = zarr.create_array(
            zarr.storage.MemoryStore(kept),
            shape=values.shape,
            dtype=values.dtype,
            chunks=(per_chunk if is_sharded else per_shard, *values.shape[1:]),
            shards=(per_shard, *values.shape[1:]) if is_sharded else None,
            compressors=[codec, zarr.codecs.Crc32cCodec()] if is_summed else codec,
            fill_value=fill,
        )
        array[...] = values
    (data,) = (value for key, value in kept.items() if not key.endswith("zarr.json"))
    return data.to_bytes()


@pytest.mark.parametrize("is_summed", [True, False])
@pytest.mark.parametrize("views", [1, 7, 8, 9, 32])
@pytest.mark.parametrize(("dtype", "fill"), [("f4", np.nan), ("f8", np.nan), ("i4", 0), ("u1", 0)])
def test_bytes_are_those_of_zarr(views, dtype, fill, is_summed):
    rng = np.random.default_rng(views)
    values = (100 * rng.random((views, 300, 3))).astype(dtype)
    summed = {"is_summed": is_summed}
    shard, chunk = (
        of_zarr(values, 8, 32, fill, is_sharded=is_sharded, **summed)
        for is_sharded in (True, False)
    )
    assert shard_bytes(values, 8, 32, fill, **summed) == shard
    assert chunk_bytes(values, 32, fill, **summed) == chunk
