"""What a store says of itself: its manifest, the records of its shards, who is writing it now.

Beside Zarr's own files a store has a folder ``omma``: in it ``done``, a record for each shard that
is there, and ``lock``.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from omma import _core
from omma._core import Error
from omma.base.backend_names import backend_differences, backend_record
from omma.base.files import reading
from omma.base.locks import lock
from omma.base.processors import processor_model
from omma.base.said import (
    Said,
    is_count,
    is_number,
    is_object,
    is_object_of_texts,
    is_span,
    is_text,
    is_texts,
    object_in,
)
from omma.datasets.job_file import Job
from omma.datasets.plan import MOST_VIEWS, Plan
from omma.datasets.shard_bytes import CHECKSUM, COMPRESSION
from omma.rendering.labelled_files import DATA_SET, ZARR_MARKER, load_package

FORMAT = f"{DATA_SET} 1"

# Members of a manifest that are JSON texts in the store, as netCDF has no objects for attributes.
# Older versions wrote objects.
_JSON = ("job_plain", "inputs_sha256", "compression", "versions", "groups", "names")

_RECORD = re.compile(r"(\d+)\.json")


def record_folder(store: str) -> str:
    """Where the records of shards are."""
    return os.path.join(store, "omma", "done")


def record_file(store: str, shard: int) -> str:
    """The record of a shard."""
    return os.path.join(record_folder(store), f"{shard:08}.json")


def shards_done(store: str) -> list[int]:
    """The shards that have records."""
    try:
        names = os.listdir(record_folder(store))
    except OSError:
        raise Error(f"{store}: expected a data set of Omma, found no records in it") from None
    found = (_RECORD.fullmatch(name) for name in names)
    return sorted(int(match[1]) for match in found if match)


def read_record(store: str, shard: int) -> dict[str, Any]:
    """What the record of a shard says; omma.Error where it is none."""
    path = record_file(store, shard)
    said = object_in(_core.read_file(path), path, "the record of a shard")
    views = said.take("views", is_span)
    files = said.take("files", is_object)
    for name, one in files.items():
        about = Said(one, f"{path}: files.{name}")
        about.take("bytes", is_count)
        about.take("sha256", is_text)
    return {
        "shard": said.take("shard", is_count),
        "views": views,
        "files": files,
        "seconds": said.take("seconds", is_number),
        "machine": said.take("machine", is_text),
        "instruction_set": said.take("instruction_set", is_text, None),
    }


def digests_of_inputs(job: Job) -> dict[str, str]:
    """SHA-256 of every file that a job is made of, those that scene files name included, by their
    names from the job's folder."""
    return {name: digest for path in job.files for name, digest in job.digests(path).items()}


def make_manifest(
    job: Job, plan: Plan, digests: Mapping[str, str], backend: str, groups: Mapping[str, str]
) -> dict[str, Any]:
    """What a store was made of, and by what."""
    return {
        "format": FORMAT,
        "job": job.text,
        "job_plain": job.plain,
        "inputs_sha256": dict(digests),
        "omma_version": _core.__version__,
        **backend_record(backend),
        "compression": dict(COMPRESSION),
        "checksum": CHECKSUM,
        "versions": {
            name: load_package(name, "datasets").__version__
            for name in ("numpy", "zarr", "numcodecs")
        },
        "python": platform.python_version(),
        "machine": ", ".join(
            (platform.node(), platform.machine(), processor_model() or "unknown processor")
        ),
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "groups": dict(groups),
        "names": {
            "scene": [one.name for one in job.scenes],
            "condition": [one.name for one in job.conditions],
            "pose_set": [one.name for one in job.poses],
        },
        "views": plan.views,
        "views_per_chunk": plan.views_per_chunk,
        "views_per_shard": plan.views_per_shard,
    }


def manifest_attributes(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """A manifest as the attributes of a store, texts and numbers."""
    return {name: json.dumps(value) if name in _JSON else value for name, value in manifest.items()}


def read_manifest(store: str) -> dict[str, Any]:
    """The manifest of a store.

    Raises:
        omma.Error: it is no data set, or one of another version of the format.
    """
    marker = Path(store) / ZARR_MARKER
    if not marker.is_file():
        raise Error(f"{store}: expected a data set, a Zarr 3 store; there is no {marker}")
    load_package("zarr", store)
    a_set = "a data set of Omma"
    said = object_in(_core.read_file(marker), f"{store}, {ZARR_MARKER}", a_set)
    attributes = said.take("attributes", is_object, {})
    if "format" not in attributes:
        raise Error(f"{store}: expected {a_set}, found another Zarr store")
    found = attributes["format"]
    if found != FORMAT:
        raise Error(
            f"{store}: expected {FORMAT!r}, found {found!r:.60}: it is of another version of Omma. "
            "What is in it is kept; go on with that version, or make a new store"
        )
    where = f"{store}, {ZARR_MARKER}: attributes"
    texts = Said(attributes, where)
    manifest = dict(attributes)
    for name in _JSON:
        if isinstance(attributes.get(name), str):
            manifest[name] = texts.take_json(name, is_object)
    _check_manifest(Said(manifest, where))
    return manifest


def _check_manifest(said: Said) -> None:
    """Checks the members that readers use."""
    for name in ("views", "views_per_chunk", "views_per_shard"):
        said.take(name, is_count)
    if said.take("views", is_count) > MOST_VIEWS:
        said.refuse("views", f"at most {MOST_VIEWS:,}")
    if said.take("views_per_shard", is_count) == 0:
        said.refuse("views_per_shard", "1 or more")
    for name in ("omma_version", "backend", "created", "job"):
        said.take(name, is_text)
    said.take("instruction_set", is_text, None)
    for name in ("job_plain", "inputs_sha256", "versions", "compression"):
        said.take(name, is_object)
    if not said.take("groups", is_object_of_texts):
        said.refuse("groups", "at least one eye")
    names = Said(said.take("names", is_object), f"{said.where}.names")
    for name in ("scene", "condition", "pose_set"):
        names.take(name, is_texts)


def shard_count(manifest: Mapping[str, Any]) -> int:
    """How many shards a store has when it is whole."""
    return int(-(-manifest["views"] // manifest["views_per_shard"]))


def views_of(records: Iterable[Mapping[str, Any]]) -> int:
    """How many views shards have, by what their records say."""
    return sum(stop - first for first, stop in (one["views"] for one in records))


def open_store(store: str) -> Any:
    """The Zarr group of a store, to be read."""
    zarr = load_package("zarr", store)
    with reading(store, "a Zarr store"):
        return zarr.open_group(store, mode="r")


def check_same(store: str, then: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """omma.Error where a store was begun from something else than what goes on with it."""
    other = list(_differences(then, now))
    if other:
        raise Error(
            f"{store}: was begun from something else: {'; '.join(other[:8])}. What is in it is "
            "kept; make a new store, or put back what it was made of"
        )


def check_worker(store: str, backend: str) -> None:
    """omma.Error where views that a worker makes by this backend would have other bits than those
    in the store."""
    other = list(backend_differences(read_manifest(store), backend_record(backend)))
    if other:
        raise Error(
            f"{store}: was begun on another kind of machine than its worker {platform.node()}: "
            f"{'; '.join(other)}. What is in it is kept; begin it on a machine as the workers are, "
            'or with backend = "portable" in [rendering]'
        )


def _differences(then: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    if str(then.get("omma_version")) != now["omma_version"]:
        yield f"omma_version was {then.get('omma_version')!r}, is {now['omma_version']!r}"
    yield from backend_differences(then, now)
    before, after = dict(then.get("inputs_sha256", {})), now["inputs_sha256"]
    for file in [*after, *(file for file in before if file not in after)]:
        if before.get(file) != after.get(file):
            yield f"{file} has changed"
    for name in ("compression", "versions"):
        yield from _unlike(then.get(name, {}), now[name], name)
    yield from _unlike(then.get("job_plain"), now["job_plain"], "job")


def _unlike(then: Any, now: Any, where: str) -> Iterator[str]:
    if isinstance(then, dict) and isinstance(now, dict):
        for key in dict.fromkeys([*then, *now]):
            yield from _unlike(then.get(key), now.get(key), f"{where}.{key}")
    elif isinstance(then, list) and isinstance(now, list) and len(then) == len(now):
        for k, (one, other) in enumerate(zip(then, now)):
            yield from _unlike(one, other, f"{where}[{k}]")
    elif then != now:
        yield f"{where} was {then!r:.60}, is {now!r:.60}"


@contextmanager
def writing(store: str) -> Iterator[None]:
    """Nobody else writes the store meanwhile; the system lets go where a process is killed."""
    path = os.path.join(store, "omma", "lock")
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise Error(f"{path}: cannot be written: {error.strerror}") from None
    try:
        if not lock(descriptor):
            raise Error(f"{store}: is being written by another run")
        yield
    finally:
        os.close(descriptor)


def whole_shards(store: str, shards: Iterable[int]) -> list[int]:
    """Those of which all files are there, in the size that they had; hashes are for `verify`."""
    found = []
    for shard in shards:
        files = read_record(store, shard)["files"]
        if all(_size(os.path.join(store, name)) == said["bytes"] for name, said in files.items()):
            found.append(shard)
    return found


def damages(store: str, shard: int) -> list[str]:
    """What is wrong with the files of a shard, a sentence each."""
    found = []
    for name, said in read_record(store, shard)["files"].items():
        path = os.path.join(store, name)
        size = _size(path)
        if size is None:
            found.append(f"{name} is missing")
        elif size != said["bytes"]:
            found.append(f"{name} has {size} bytes, expected {said['bytes']}")
        else:
            digest = hashlib.sha256(Path(path).read_bytes()).hexdigest()
            if digest != said["sha256"]:
                found.append(f"{name} has other bytes than were written")
    return found


@contextmanager
def reading_shards(store: str, shards: Iterable[int]) -> Iterator[None]:
    """As `reading`. Where something of these shards is not as it was written, the error names the
    file, and how to mend it."""
    try:
        with reading(store, "a Zarr store"):
            yield
    except Error:
        for shard in shards:
            if found := damages(store, shard):
                raise Error(
                    f"{store}: shard {shard} is damaged: {found[0]}; to make it anew: omma dataset "
                    f"verify --forget {shlex.quote(store)}, then run its job again"
                ) from None
        raise


def _size(path: str) -> int | None:
    try:
        return os.stat(path).st_size
    except OSError:
        return None
