"""What is in a data set, in words: what ``omma dataset info`` prints."""

from __future__ import annotations

import os
from operator import itemgetter
from pathlib import Path
from typing import Any

from omma.base.arguments import checked
from omma.base.backend_names import backend_words
from omma.base.files import PathLike, reading
from omma.datasets.layout import VIEW
from omma.datasets.records import (
    open_store,
    read_manifest,
    read_record,
    shard_count,
    shards_done,
    views_of,
)


@checked
def describe(store: PathLike) -> list[str]:
    """Lines of text: how many views of what, how much of it is there, its arrays and its size.

    Raises:
        omma.Error: no data set, or one of another version.
    """
    path = os.fsdecode(store)
    manifest = read_manifest(path)
    done = shards_done(path)
    shards = shard_count(manifest)
    records = [read_record(path, shard) for shard in done]
    seconds = sum(one["seconds"] for one in records)
    machines = sorted({one["machine"] for one in records})
    size = sum(file.stat().st_size for file in Path(path).rglob("*") if file.is_file())
    names = manifest["names"]
    lines = [
        f"{path}: {views_of(records):,} of {manifest['views']:,} views are there, {len(done)} of "
        f"{shards} shards, {size / 1e6:,.1f} MB",
        f"scenes: {', '.join(names['scene'])}",
        f"conditions: {', '.join(names['condition'])}",
        f"sets of poses: {', '.join(names['pose_set'])}",
        f"made by Omma {manifest['omma_version']} with {backend_words(manifest)}, begun "
        f"{manifest['created']}"
        + (f", {seconds:,.0f} s of work on {', '.join(machines)}" if records else ""),
    ]
    root = open_store(path)
    for eye, inside in manifest["groups"].items():
        lines.append(f"eye {eye}:")
        with reading(path, "a Zarr store"):
            arrays = sorted((root[inside] if inside else root).arrays(), key=itemgetter(0))
            lines += [
                f"  {name} {_about(array)}"
                for name, array in arrays
                if (array.metadata.dimension_names or ())[:1] == (VIEW,)
            ]
    return lines


def _about(array: Any) -> str:
    sizes = ", ".join(
        f"{name} {size:,}" for name, size in zip(array.metadata.dimension_names, array.shape)
    )
    unit = array.attrs.get("units", "1")
    return f"({sizes}) {array.dtype}" + (f", {unit}" if unit != "1" else "")
