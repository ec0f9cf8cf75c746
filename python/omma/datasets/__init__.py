"""Data sets as jobs: millions of views of scenes, in one Zarr store that training code reads.

A job is a TOML file; `run` makes its views and goes on where it was cut off; `Views` reads them
(docs/datasets.md).

Files: `plan` says which view is what, `shards` makes a shard (rendering and writing overlap),
`records` knows what is there, `running` and `cluster` who makes it; `samplers` of poses, by
`free_space`, rays that find free positions, and `far_map`, where nothing is near; `shard_bytes`
is a shard as Zarr's bytes; `reading`; `for_torch` gives PyTorch what is in a store (`torch_views`)
or what is rendered when it is asked for (`torch_rendered`).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
