"""Data sets made: a store begun or gone on with, its missing shards made here or on a cluster."""

from __future__ import annotations

import os
import re
import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from omma import _core
from omma._core import Error
from omma.base.addresses import expect_local
from omma.base.arguments import checked, whole
from omma.base.directories import WholeDirectory
from omma.base.files import PathLike, make_directory, named_in_errors
from omma.base.progress import Progress, Stage
from omma.base.values import value_class
from omma.datasets.cluster import make_on_cluster, scheduler_of
from omma.datasets.job_file import Job, load_job
from omma.datasets.layout import (
    Layout,
    as_begun,
    create_store,
    make_layouts,
    planned,
    view_bytes,
    view_coordinates,
)
from omma.datasets.plan import Plan, make_plan
from omma.datasets.records import (
    check_same,
    damages,
    digests_of_inputs,
    make_manifest,
    manifest_attributes,
    read_manifest,
    record_file,
    record_folder,
    shard_count,
    shards_done,
    whole_shards,
    writing,
)
from omma.datasets.shards import render_shard, write_shard
from omma.datasets.worlds import (
    Workshop,
    backend_of,
    check_instances,
    load_cameras,
    load_eyes,
)
from omma.rendering.labelled_files import ZARR_MARKER


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class RunReport:
    """What a run did."""

    store: str
    views: int  # of the data set
    shards: int
    made: int  # shards, by this run
    views_made: int
    seconds: float  # spent on making them, without reading and checking inputs
    warnings: tuple[str, ...] = ()  # of scenes that this process has read


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class VerifyReport:
    """What is wrong with a data set; nothing, where ``missing`` and ``damaged`` are empty."""

    store: str
    shards: int
    missing: tuple[int, ...]  # shards that are not made yet
    damaged: tuple[str, ...]  # a sentence for each file that is not as it was written
    left: tuple[str, ...]  # files that killed runs left behind; the next run removes them

    @property
    def is_whole(self) -> bool:
        """Whether all is there, as it was written."""
        return not self.missing and not self.damaged


@checked
def run(
    job: Job | PathLike,
    store: PathLike | None = None,
    *,
    threads: int = 0,
    dask: str | None = None,
    slurm: int = 0,
    progress: Stage | None = None,
) -> RunReport:
    """Make a data set, or what is missing of it: what ``omma dataset run`` does.

    Shards are the pieces of work. Each is there whole, with the hashes of its files, or not at all;
    whatever ends a run, the next one makes what is missing and nothing else. The bits do not depend
    on threads, workers and interruptions (docs/datasets.md says on what processors they do).

    Args:
        job: a job, or the file of one.
        store: the directory to write, a Zarr 3 store; None takes what the job says. One that is
            there is gone on with.
        threads: of the renderer on this machine; 0 takes all cores.
        dask: address of a Dask scheduler, such as "tcp://host:8786", whose workers make the shards.
            They must see the job's files and the store under the same names.
        slurm: make so many jobs in SLURM, each a Dask worker as the job's table ``slurm`` says.
        progress: called with what is being done and its finished share, None where not known.

    Raises:
        omma.Error: something in the job or its files; a store of another job, of inputs that
            changed, of another version, backend or, with Embree, instruction set; a full disk; a
            scheduler that went away; no free position for a pose. What is done is kept.
        KeyboardInterrupt: Ctrl-C. What is done is kept.
    """
    tell: Stage = progress if progress is not None else lambda stage, share: None
    threads = whole(threads, "threads", 0, 1 << 16)
    slurm = whole(slurm, "slurm", 0, 1 << 16)
    if dask is not None and not re.fullmatch(r"\w+://\S+", dask):
        raise Error(f"dask: expected an address such as tcp://host:8786, found {dask!r:.80}")
    if dask is not None and slurm:
        raise Error("slurm: only one of dask and slurm can say who works")
    if not isinstance(job, Job):
        job = load_job(job)
    path = os.path.abspath(job.store if store is None else expect_local(store, "a data set"))
    _expect_writable(path)
    tell("Reading the eyes", None)
    eyes = load_eyes(job)
    load_cameras(job)
    tell("Laying out the store", None)
    of_one_view = make_layouts(job, eyes)
    plan = make_plan(job, view_bytes(of_one_view))
    layouts = planned(of_one_view, plan)
    tell("Checking inputs", None)
    digests = digests_of_inputs(job)
    tell("Opening the store", None)
    _begin(job, path, plan, layouts, digests)
    if len(whole_shards(path, shards_done(path))) == plan.shards:
        return RunReport(path, plan.views, plan.shards, 0, 0, 0.0)
    layouts = as_begun(layouts, read_manifest(path))
    with writing(path):
        done = whole_shards(path, shards_done(path))
        missing = sorted(set(range(plan.shards)) - set(done))
        _remove_left(path, plan, layouts, missing)
        start = time.perf_counter()
        told: tuple[str, ...] = ()
        if missing and (dask is not None or slurm):
            with scheduler_of(job, dask, slurm) as client:
                make_on_cluster(client, path, job, digests, plan, layouts, missing, tell)
            _remove_left(path, plan, layouts, missing)  # of workers that were killed
        elif missing:
            told = _make_here(path, job, digests, plan, layouts, missing, threads, tell)
    made = sum(len(plan.views_of(shard)) for shard in missing)
    seconds = time.perf_counter() - start
    return RunReport(path, plan.views, plan.shards, len(missing), made, seconds, told)


@checked
def verify(
    store: PathLike, *, forget: bool = False, progress: Progress | None = None
) -> VerifyReport:
    """Whether all shards of a data set are there, each byte as it was written.

    Args:
        forget: forget the records of shards that are damaged, so that the next run makes them anew.
        progress: called with the finished share, 0 to 1.

    Raises:
        omma.Error: no data set, or one of another version.
    """
    path = expect_local(store, "a data set")
    manifest = read_manifest(path)
    shards = shard_count(manifest)
    done = shards_done(path)
    damaged: list[str] = []
    for k, shard in enumerate(done):
        found = damages(path, shard)
        damaged += [f"shard {shard}: {one}" for one in found]
        if found and forget:
            with writing(path):
                os.remove(record_file(path, shard))
        if progress is not None:
            progress((k + 1) / len(done))
    left = [str(file) for file in sorted(Path(path).rglob(".*.partial"))]
    missing = sorted(set(range(shards)) - set(done))
    return VerifyReport(path, shards, tuple(missing), tuple(damaged), tuple(left))


def _expect_writable(path: str) -> None:
    """omma.Error at once, not after minutes of work, where no store can be made or gone on with;
    where one is whole nothing need be written."""
    if os.path.lexists(path):
        shards = shard_count(read_manifest(path))
        if len(whole_shards(path, shards_done(path))) == shards:
            return
        with writing(path):
            return
    folder = Path(path).parent
    while not os.path.lexists(folder):
        folder = folder.parent
    if not folder.is_dir():
        raise Error(f"{path}: cannot be written: {folder} is not a directory")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise Error(f"{path}: cannot be written: nothing may be made in {folder}")


def _begin(
    job: Job,
    path: str,
    plan: Plan,
    layouts: dict[str, Layout],
    digests: dict[str, str],
) -> None:
    """Make the store where there is none; else, also where another run has made one meanwhile, see
    that it is of this very job."""
    groups = {eye: layout.group for eye, layout in layouts.items()}
    manifest = make_manifest(job, plan, digests, backend_of(job), groups)
    if not os.path.lexists(path):
        check_instances(job)
        make_directory(Path(path).parent)
        store = WholeDirectory(path, ZARR_MARKER)
        try:
            with named_in_errors(path):
                attributes = manifest_attributes(manifest)
                create_store(store.temporary, layouts, view_coordinates(job, plan), attributes)
                os.makedirs(record_folder(store.temporary))
            store.sync()
            if store.finish(replaces=False):
                return
        finally:
            store.discard()
    check_same(path, read_manifest(path), manifest)


def _make_here(
    path: str,
    job: Job,
    digests: dict[str, str],
    plan: Plan,
    layouts: dict[str, Layout],
    missing: list[int],
    threads: int,
    tell: Stage,
) -> tuple[str, ...]:
    """Render shards one after the other; each is written while the next is rendered. What there is
    to warn of the scenes."""
    tell("Building worlds", None)
    workshop = Workshop(job, digests, threads, tell)
    with ThreadPoolExecutor(1) as writer:
        written: Future[None] | None = None
        for k, shard in enumerate(missing):

            def tell_share(share: float, k: int = k) -> None:
                tell("Rendering", (k + share) / len(missing))

            rendered = render_shard(workshop, plan, layouts, shard, tell_share)
            if written is not None:
                written.result()
            written = writer.submit(write_shard, path, layouts, rendered)
            del rendered  # the writer gives its arrays up as it writes them
            tell_share(1.0)
        if written is not None:
            tell("Writing", None)
            written.result()
    return tuple(workshop.warnings)


def _remove_left(path: str, plan: Plan, layouts: dict[str, Layout], missing: list[int]) -> None:
    """Remove what killed runs left of shards that are to be made, not what workers still write."""
    names = [
        os.path.join(path, layout.file(variable, shard))
        for shard in missing
        for layout in layouts.values()
        for variable in layout.variables
    ]
    names += [record_file(path, shard) for shard in missing]
    for file, _ in _core.left_behind(names):
        Path(file).unlink(missing_ok=True)
