"""What ``omma info`` says of a data set: its responses, and how many of its views are there."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from omma import _core
from omma.base.files import PathLike
from omma.base.said import is_object, object_in
from omma.datasets.records import read_manifest, read_record, shards_done, views_of
from omma.job.results_info import Lines, describe_responses
from omma.rendering.labelled_files import ZARR_MARKER, is_data_set


def is_store(path: PathLike) -> bool:
    """Whether it is a data set of `omma dataset run`; omma.Error of a damaged Zarr store."""
    name = os.fsdecode(path)
    marker = Path(name, ZARR_MARKER)
    if not marker.is_file():
        return False
    said = object_in(_core.read_file(marker), f"{name}, {ZARR_MARKER}", "a Zarr store")
    return is_data_set(said.take("attributes", is_object, {}))


def describe_store(path: PathLike) -> Lines:
    """Shape and range of its responses, how they were made and how many views are there; of several
    eyes their names.

    Raises:
        omma.Error: the store cannot be read.
    """
    name = os.fsdecode(path)
    manifest = read_manifest(name)
    views, more = _views(name, manifest)
    if len(manifest["groups"]) > 1:
        return [("data set", name), ("eyes", ", ".join(manifest["groups"])), views, more]
    lines = describe_responses(path)
    return [lines[0], views, *lines[1:], more]


def _views(name: str, manifest: dict[str, Any]) -> Lines:
    records = (read_record(name, shard) for shard in shards_done(name))
    there = f"{views_of(records):,} of {manifest['views']:,} are there"
    return [("views", there), ("more", f"omma dataset info {name}")]
