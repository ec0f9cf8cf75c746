"""Data sets as tar files in the way of WebDataset: the files of a sample share the number before
the first dot of their names."""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma.base.addresses import expect_local
from omma.base.arguments import checked, whole
from omma.base.files import PathLike, WholeFiles, make_directory
from omma.base.progress import Progress
from omma.datasets.reading import Batch, Views, open_views
from omma.datasets.records import read_manifest

_MOST = 1 << 30
_READ = 256  # views at once
_ABOUT = ("scene", "condition", "pose_set", "pose", "world_from_head")


@checked
def to_webdataset(
    store: PathLike,
    folder: PathLike,
    variables: Sequence[str] = ("response",),
    *,
    eye: str | None = None,
    views_per_file: int = 1000,
    progress: Progress | None = None,
) -> list[str]:
    """Write the views of a data set as tar files ``views-000000.tar`` and on; their names.

    Of view 17 there are 00000017.response.npy, one such file for each variable, and 00000017.json
    with the names of scene, condition and set of poses, the number of the pose and the pose itself,
    ``world_from_head``. Views come in their order; what trains on them should shuffle.

    Args:
        store, variables, eye: as of `open_views`.
        folder: is made where it is missing.
        views_per_file: how many views a file has.
        progress: called with the finished share, 0 to 1.

    Raises:
        omma.Error: no data set, no such eye or variable; a file cannot be written. Files are there
            whole or not at all.

    Warns:
        UserWarning: the data set is not whole, as of `open_views`.
    """
    number = whole(views_per_file, "views_per_file", 1, _MOST)
    views = open_views(store, (*dict.fromkeys((*variables, *_ABOUT)),), eye=eye)
    job = read_manifest(views.store)["names"]
    target = Path(expect_local(folder, "a folder of shards"))
    make_directory(target)
    written = []
    for first in range(0, len(views), number):
        path = str(target / f"views-{first // number:06}.tar")
        with WholeFiles() as files:
            stream: Any = _Stream(files.open(path))
            with tarfile.open(fileobj=stream, mode="w|", format=tarfile.USTAR_FORMAT) as tar:
                for begin in range(first, min(first + number, len(views)), _READ):
                    stop = min(begin + _READ, first + number, len(views))
                    _add(tar, views, begin, stop, variables, job)
                    if progress is not None:
                        progress(stop / len(views))
        written.append(path)
    return written


class _Stream:
    """The part of a file's interface that tarfile writes to."""

    def __init__(self, file: Any) -> None:
        self._file = file

    def write(self, data: bytes) -> int:
        self._file.write(data)
        return len(data)


def _add(
    tar: tarfile.TarFile,
    views: Views,
    first: int,
    stop: int,
    variables: Sequence[str],
    names: dict[str, list[str]],
) -> None:
    found = views[first:stop]
    for k, view in enumerate(views.numbers[first:stop].tolist()):
        for name in variables:
            _put(tar, f"{view:08}.{name}.npy", _npy(found[name][k]))
        _put(tar, f"{view:08}.json", json.dumps(_about(found, k, names)).encode())


def _about(found: Batch, k: int, names: dict[str, list[str]]) -> dict[str, Any]:
    """What a view is of."""
    said: dict[str, Any] = {name: known[int(found[name][k])] for name, known in names.items()}
    return {
        **said,
        "pose": int(found["pose"][k]),
        "world_from_head": found["world_from_head"][k].tolist(),
    }


def _npy(values: NDArray[Any]) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


def _put(tar: tarfile.TarFile, name: str, data: bytes) -> None:
    about = tarfile.TarInfo(name)
    about.size = len(data)
    tar.addfile(about, io.BytesIO(data))
