"""Shards of data sets as bytes: those that zarr itself writes."""

import numpy as np
import pytest

from omma.datasets.shard_bytes import COMPRESSION, chunk_bytes, shard_bytes

zarr = pytest.importorskip("zarr")


def of_zarr(values, per_chunk, per_shard, fill, *, is_sharded):
    kept = {}
    codec = zarr.codecs.BloscCodec(**COMPRESSION, typesize=values.dtype.itemsize)
    with zarr.config.set({"array.write_empty_chunks": True}):
        array = zarr.create_array(
            zarr.storage.MemoryStore(kept),
            shape=values.shape,
            dtype=values.dtype,
            chunks=(per_chunk if is_sharded else per_shard, *values.shape[1:]),
            shards=(per_shard, *values.shape[1:]) if is_sharded else None,
            compressors=codec,
            fill_value=fill,
        )
        array[...] = values
    (data,) = (value for key, value in kept.items() if not key.endswith("zarr.json"))
    return data.to_bytes()


@pytest.mark.parametrize("views", [1, 7, 8, 9, 32])
@pytest.mark.parametrize(("dtype", "fill"), [("f4", np.nan), ("f8", np.nan), ("i4", 0), ("u1", 0)])
def test_bytes_are_those_of_zarr(views, dtype, fill):
    rng = np.random.default_rng(views)
    values = (100 * rng.random((views, 300, 3))).astype(dtype)
    assert shard_bytes(values, 8, 32, fill) == of_zarr(values, 8, 32, fill, is_sharded=True)
    assert chunk_bytes(values, 32, fill) == of_zarr(values, 8, 32, fill, is_sharded=False)
