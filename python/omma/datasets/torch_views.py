"""Views of a store as data sets of PyTorch. This module needs PyTorch; `for_torch` imports it."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import Dataset, IterableDataset, get_worker_info

from omma.datasets.reading import Batch, Views
from omma.datasets.records import read_manifest

# Chunks whose views are mixed.
_MIXED = 8


class _Opened:
    """Views, opened anew in each process: a forked one must not read by its parent's arrays."""

    def __init__(self, views: Views) -> None:
        self._views, self._process = views, os.getpid()

    def __getstate__(self) -> Views:
        return self._views

    def __setstate__(self, views: Views) -> None:
        self._views, self._process = views, os.getpid()

    def here(self) -> Views:
        if self._process != os.getpid():
            self._views, self._process = dataclasses.replace(self._views), os.getpid()
        return self._views


class TorchViews(Dataset):  # type: ignore[misc,unused-ignore]
    """A map-style data set; a sample is a dictionary of arrays, which loaders make tensors of."""

    def __init__(self, views: Views) -> None:
        self._opened = _Opened(views)

    def __len__(self) -> int:
        return len(self._opened.here())

    def __getitem__(self, index: int) -> Batch:
        return self._opened.here()[index]

    def __getitems__(self, indices: list[int]) -> list[Batch]:
        """What loaders ask for a batch."""
        found = self._opened.here()[indices]
        return [{name: values[k] for name, values in found.items()} for k in range(len(indices))]


class ViewStream(IterableDataset):  # type: ignore[misc,unused-ignore]
    """Batches of views, whole chunks read at a time."""

    def __init__(self, views: Views, batch_size: int, shuffle: bool) -> None:
        self._opened = _Opened(views)
        self._size, self._shuffle = batch_size, shuffle
        self._times = 0

    def __len__(self) -> int:
        """Batches of all workers together."""
        return -(-len(self._opened.here()) // self._size)

    def __iter__(self) -> Iterator[dict[str, torch.Tensor]]:
        views = self._opened.here()
        worker, workers, rng = shared_work(self._times)
        self._times += 1
        chunks = chunks_of(views)
        if self._shuffle:
            rng.shuffle(chunks)
        # The order of all views is the same in all workers, and each has batches in a row of it:
        # chunks that two workers read are only at the two ends of these.
        first, stop = (len(self) * k // workers * self._size for k in (worker, worker + 1))
        place = 0
        left: Batch | None = None
        for chunk in range(0, len(chunks), _MIXED):
            if place >= stop:
                break
            which = np.concatenate(chunks[chunk : chunk + _MIXED])
            if self._shuffle:
                rng.shuffle(which)
            own = which[max(0, first - place) : max(0, stop - place)]
            place += len(which)
            if len(own) == 0:
                continue
            found = views[own]
            if left is not None:
                found = {name: np.concatenate([left[name], found[name]]) for name in found}
            count = len(next(iter(found.values())))
            whole = count - count % self._size
            for start in range(0, whole, self._size):
                yield tensors({name: a[start : start + self._size] for name, a in found.items()})
            left = {name: values[whole:] for name, values in found.items()}
        if left is not None and len(next(iter(left.values()))):
            yield tensors(left)


def chunks_of(views: Views) -> list[NDArray[np.int64]]:
    """The indices of views that lie in one chunk, for each chunk."""
    if len(views) == 0:
        return []
    chunk = views.numbers // max(1, int(read_manifest(views.store)["views_per_chunk"]))
    edges = np.flatnonzero(np.diff(chunk)) + 1
    return [np.array(one) for one in np.split(np.arange(len(views)), edges)]


def shared_work(times: int) -> tuple[int, int, np.random.Generator]:
    """Which worker this is and of how many, and a generator that is the same in all of them: by the
    loader's seed, and by how often a worker that is kept has begun (``times``)."""
    info = get_worker_info()
    if info is None:
        drawn = int(torch.empty((), dtype=torch.int64).random_())
        return 0, 1, np.random.default_rng((drawn, 0))
    return info.id, info.num_workers, np.random.default_rng((info.seed - info.id, times))


def tensors(arrays: dict[str, Any]) -> dict[str, torch.Tensor]:
    """The same memory as tensors, where it is in one piece and may be written to."""
    return {
        name: torch.from_numpy(np.require(values, requirements=["C", "W"]))
        for name, values in arrays.items()
    }
