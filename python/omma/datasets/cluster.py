"""Shards made by the workers of a Dask cluster: one that is there, or one of jobs in SLURM."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from omma._core import Error
from omma.base.optional import needs
from omma.base.progress import Stage
from omma.datasets.job_file import Job
from omma.datasets.layout import Layout
from omma.datasets.plan import Plan
from omma.datasets.records import check_worker
from omma.datasets.shards import make_shard
from omma.datasets.worlds import Workshop, backend_of

# How often a shard is tried again whose worker failed.
_RETRIES = 3
# A scheduler is asked for this long, and then given up.
_TIMEOUT_S = 30

_lock = threading.Lock()
_workshops: dict[str, Workshop] = {}


@contextmanager
def scheduler_of(job: Job, dask: str | None, slurm: int) -> Iterator[Any]:
    """A client of the scheduler at an address, or of one that is made with so many jobs in SLURM.

    Raises:
        omma.Error: a package is missing, or no scheduler answers.
    """
    distributed = _load("distributed")
    with _told_by_us():
        yield from _clients(distributed, job, dask, slurm)


def _clients(distributed: Any, job: Job, dask: str | None, slurm: int) -> Iterator[Any]:
    if dask is None:
        cluster = slurm_cluster(job)
        with cluster, distributed.Client(cluster) as client:
            cluster.scale(jobs=slurm)
            yield client
        return
    try:
        client = distributed.Client(dask, timeout=_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        raise Error(f"dask: no scheduler answers at {dask!r:.80}: {error}") from None
    try:
        yield client
    finally:
        client.close(timeout=2)


@contextmanager
def _told_by_us() -> Iterator[None]:
    """Dask logs a page where a scheduler goes away, which is one line as an error of ours."""
    logger = logging.getLogger("distributed.client")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)


def slurm_cluster(job: Job) -> Any:
    """The cluster that a job's table ``slurm`` describes, without workers.

    Raises:
        omma.Error: dask-jobqueue is missing, or refuses what the table says.
    """
    jobqueue = _load("dask_jobqueue")
    try:
        return jobqueue.SLURMCluster(**job.slurm)
    except (TypeError, ValueError, OSError) as error:
        raise Error(f"{job.path}, slurm: {error}") from None


def make_on_cluster(
    client: Any,
    path: str,
    job: Job,
    digests: dict[str, str],
    plan: Plan,
    layouts: Mapping[str, Layout],
    missing: list[int],
    tell: Stage,
) -> None:
    """Have the workers make the shards; returns when all are there.

    Raises:
        omma.Error: a shard could not be made, or the scheduler has gone away.
    """
    distributed = _load("distributed")
    tell("Waiting for workers", None)
    # Sent to each worker once, not with each shard.
    common = client.scatter((path, job, digests, plan, dict(layouts)), broadcast=False, hash=False)
    waiting = {
        client.submit(_make_one, common, shard, retries=_RETRIES, pure=False): shard
        for shard in missing
    }
    done = 0
    while waiting:
        try:
            with client.as_current():  # `wait` has no other way to be told
                finished = distributed.wait(
                    list(waiting), timeout=1, return_when="FIRST_COMPLETED"
                ).done
        except (TimeoutError, distributed.TimeoutError):
            finished = set()
        except distributed.client.CancelledError:
            raise _gone(client) from None
        for future in finished:
            shard = waiting.pop(future)
            if future.status == "cancelled":
                raise _gone(client)
            if future.status == "error":
                raise _told(future.exception(), shard)
            future.release()
            done += 1
            tell("Rendering", done / len(missing))
        if client.status not in ("running", "connecting"):
            raise _gone(client)
        if not finished and not _answers(client):
            raise _gone(client)


def _make_one(common: tuple[Any, ...], shard: int) -> int:
    """In a worker: make a shard; worlds are built by the first and kept."""
    path, job, digests, plan, layouts = common
    if not os.path.isdir(path):
        raise Error(f"{path}: expected the store, which a worker does not see under that name")
    # A worker's threads make shards side by side, so each renders with one.
    with _lock:
        if path not in _workshops:
            check_worker(path, backend_of(job))
            _workshops.clear()
            _workshops[path] = Workshop(job, digests, threads=1)
        workshop = _workshops[path]
    make_shard(path, workshop, plan, layouts, shard)
    return shard


def _answers(client: Any) -> bool:
    """Whether the scheduler still does."""
    try:
        client.sync(client.scheduler.identity, callback_timeout=_TIMEOUT_S)
    except Exception:
        return False
    return True


def _gone(client: Any) -> Error:
    address = getattr(getattr(client, "scheduler", None), "address", "") or ""
    return Error(f"dask: the scheduler {address} has gone away. What is done is kept")


def _told(error: BaseException | None, shard: int) -> Error:
    if isinstance(error, Error):
        return error
    return Error(f"dask: shard {shard} could not be made: {type(error).__name__}: {error}")


def _load(package: str) -> Any:
    return needs(package, "cluster", f"clusters need {package.replace('_', '-')}")
