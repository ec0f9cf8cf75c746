"""Views read back for training: in any order, in batches, ahead of time."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma._core import Error
from omma.base.arguments import checked, one_of, whole
from omma.base.files import PathLike, reading
from omma.base.rows import is_one, row_of, rows_of
from omma.base.values import value_class
from omma.base.warn import warn_caller
from omma.datasets.layout import VIEW
from omma.datasets.records import (
    open_store,
    read_manifest,
    read_record,
    reading_shards,
    shards_done,
    whole_shards,
)

Batch = dict[str, NDArray[Any]]

_MOST = 1 << 40
MOST_SEED = (1 << 64) - 1  # as of `torch.initial_seed`
_NAMED = 8
_READERS = 2  # threads; Zarr reads the chunks of one batch with more


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Views:
    """The views of one eye in a data set that are there: a sequence, read in any order.

    `open_views` makes it. ``views[k]`` is a dictionary of arrays, one view of each variable;
    ``views[[5, 2, 9]]`` or ``views[10:20]`` of several, in that order, read together;
    ``views[mask]`` of those where a mask (V,) of bool is True.

    It is picklable; each process opens the store for itself.
    """

    store: str
    eye: str
    variables: tuple[str, ...]
    numbers: NDArray[np.int64]
    """(V,), ascending: which views of the data set it has."""
    total: int | None = None
    """How many views the data set has when it is whole."""

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, index: int | slice | ArrayLike) -> Batch:
        """Views by their index in ``numbers``, below 0 from the end, or by a mask.

        Raises:
            IndexError: there is no such view.
            omma.Error: a mask of another length, indices that are no whole numbers, a file that
                is not as it was written.
            TypeError: no index at all, as a variable's name or True.
        """
        found: Any
        if isinstance(index, slice):
            found = self.numbers[index]
        elif is_one(index):
            found = self.numbers[row_of(index, "index", len(self))]
        else:
            found = self.numbers[rows_of(index, "index", len(self))]
        shards = np.unique(found // self._views_per_shard).tolist()
        with reading_shards(self.store, shards):
            return self._read(found)

    def _read(self, found: NDArray[np.int64]) -> Batch:
        if np.ndim(found) == 0:
            return {name: np.asarray(array[int(found)]) for name, array in self._arrays.items()}
        wanted = np.asarray(found)
        # Ascending and each once, as Zarr reads best; then as they were asked for.
        sorted_, back = np.unique(wanted, return_inverse=True)
        if len(wanted) == 0:
            return {name: array[0:0] for name, array in self._arrays.items()}
        if sorted_[-1] - sorted_[0] + 1 == len(sorted_):
            rows: Any = slice(int(sorted_[0]), int(sorted_[-1]) + 1)
            return {name: array[rows][back] for name, array in self._arrays.items()}
        return {name: array.oindex[sorted_][back] for name, array in self._arrays.items()}

    @cached_property
    def _views_per_shard(self) -> int:
        return int(read_manifest(self.store)["views_per_shard"])

    def __repr__(self) -> str:
        names = ", ".join(self.variables)
        of = "" if self.total is None else f" of {self.total:,}"
        return f"Views({len(self):,}{of} views of {self.eye!r} in {self.store!r}: {names})"

    @cached_property
    def _arrays(self) -> dict[str, Any]:
        group = open_store(self.store)
        inside = read_manifest(self.store)["groups"][self.eye]
        return {
            name: group[os.path.join(inside, name) if inside else name] for name in self.variables
        }


@checked
def open_views(
    store: PathLike, variables: Sequence[str] = ("response",), *, eye: str | None = None
) -> Views:
    """The views in a data set that are there, also of one that is not whole yet.

    Shards of which a file is missing or not as large as it was written are not there, as for a
    run. Of a store that is not whole scenes, conditions or sets of poses may be missing altogether,
    as views are made in this order.

    Args:
        store: the data set.
        variables: which arrays to read: "response", "world_from_head", "scene", "distance", ...
        eye: whose; None where there is one eye.

    Raises:
        omma.Error: no data set, no such eye or variable.

    Warns:
        UserWarning: the data set is not whole: how many of its views are there, and of which
            scenes, conditions and sets of poses there is none.
    """
    path = os.fsdecode(store)
    manifest = read_manifest(path)
    names = list(manifest["groups"])
    if eye is None:
        if len(names) > 1:
            raise Error(f"eye: expected one of {', '.join(names)}, found none")
        eye = names[0]
    one_of(eye, names, "eye")
    if isinstance(variables, str) or not all(isinstance(one, str) for one in variables):
        raise TypeError(f"variables: expected a list of names, found {variables!r:.60}")
    inside = manifest["groups"][eye]
    group = open_store(path)
    with reading(path, "a Zarr store"):
        arrays = dict((group[inside] if inside else group).arrays())
    known = [
        name
        for name, array in arrays.items()
        if (array.metadata.dimension_names or ())[:1] == (VIEW,)
    ]
    for one in variables:
        one_of(one, sorted(known), "variables")
    parts = [np.arange(0)]
    for shard in whole_shards(path, shards_done(path)):
        first, stop = read_record(path, shard)["views"]
        if stop > manifest["views"]:
            raise Error(
                f"{path}: expected views up to {manifest['views']}, found {stop} in the record of "
                f"shard {shard}"
            )
        parts.append(np.arange(first, stop))
    numbers = np.concatenate(parts)
    if len(numbers) < manifest["views"]:
        with reading(path, "a data set"):
            missing = _missing(arrays, manifest["names"], numbers)
        none = f", none of {', '.join(missing)}" if missing and len(numbers) else ""
        warn_caller(
            f"{path}: {len(numbers):,} of {manifest['views']:,} views are there{none}; a run of "
            "its job makes the others",
            UserWarning,
        )
    return Views(os.path.abspath(path), eye, tuple(variables), numbers, manifest["views"])


def _missing(
    arrays: Mapping[str, Any], names: Mapping[str, list[str]], numbers: NDArray[np.int64]
) -> list[str]:
    """Scenes, conditions and sets of poses of which there is no view, a few by their names."""
    found = []
    for kind in ("scene", "condition", "pose_set"):
        of_views = np.asarray(arrays[kind][...])
        lacking = [names[kind][k] for k in np.setdiff1d(of_views, of_views[numbers])]
        found += [f"{kind} {name!r}" for name in lacking]
    more = [f"{len(found) - _NAMED} more"] if len(found) > _NAMED else []
    return found[:_NAMED] + more


@checked
def batches(
    views: Views,
    batch_size: int = 64,
    *,
    shuffle: bool = True,
    seed: int = 0,
    epoch: int = 0,
    ahead: int = 4,
) -> Iterator[Batch]:
    """All views once, in batches that are read ahead while others are used.

    Args:
        views: of `open_views`.
        batch_size: views in a batch; the last may have fewer.
        shuffle: in an order that ``seed``, 0 to 2⁶⁴ − 1, and ``epoch`` say, else as they come.
        ahead: batches that are read before they are asked for.

    Example:
        for epoch in range(10):
            for batch in omma.datasets.batches(views, 256, epoch=epoch):
                train(batch["response"])

    Raises:
        omma.Error: an argument is out of its range.
    """
    size = whole(batch_size, "batch_size", 1, _MOST)
    seed, epoch = whole(seed, "seed", 0, MOST_SEED), whole(epoch, "epoch", 0, _MOST)
    ahead = whole(ahead, "ahead", 1, 1 << 16)
    order = np.arange(len(views))
    if shuffle:
        np.random.default_rng((seed, epoch)).shuffle(order)
    return _read_ahead(views, [order[k : k + size] for k in range(0, len(order), size)], ahead)


def _read_ahead(views: Views, pieces: list[NDArray[np.int64]], ahead: int) -> Iterator[Batch]:
    waiting: deque[Future[Batch]] = deque()
    with ThreadPoolExecutor(_READERS) as readers:
        try:
            for piece in pieces:
                waiting.append(readers.submit(views.__getitem__, piece))
                if len(waiting) > ahead:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            readers.shutdown(wait=False, cancel_futures=True)
