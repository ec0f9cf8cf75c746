"""A shard made: its views rendered, written as whole files, and recorded when they are there.

Files get their names when they are whole and on the disk; the record of a shard, with the sizes and
hashes of its files, comes after them. So what has a record is there, whenever a process is killed.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma._core import Error
from omma.base.backend_names import backend_record
from omma.base.files import WholeFiles, write_whole
from omma.base.progress import Progress
from omma.datasets.job_file import TRUTHS, Job
from omma.datasets.layout import HEAD_MOTION, Layout, is_to_error
from omma.datasets.plan import Plan
from omma.datasets.records import record_file
from omma.datasets.worlds import Workshop, names_of_things
from omma.picture.band_colours import colours_of
from omma.picture.projections import projection_ids
from omma.rendering.labels import pose_variables
from omma.rendering.renderer import Renderer
from omma.rendering.truth import GroundTruth, truth_variables
from omma.scene.capture_cameras import CaptureCameras

Arrays = dict[str, NDArray[Any]]
Motion = tuple[NDArray[np.float64], NDArray[np.float64]]  # linear, angular velocities


@dataclass(frozen=True)
class RenderedShard:
    """A shard's views, not yet written."""

    number: int
    views: range
    arrays: dict[str, Arrays]  # by eye
    backend: str
    seconds: float


def make_shard(
    store: str, workshop: Workshop, plan: Plan, layouts: Mapping[str, Layout], shard: int
) -> None:
    """Render a shard's views for all eyes into a store."""
    write_shard(store, layouts, render_shard(workshop, plan, layouts, shard))


def render_shard(
    workshop: Workshop,
    plan: Plan,
    layouts: Mapping[str, Layout],
    shard: int,
    progress: Progress | None = None,
) -> RenderedShard:
    """A shard's views for all eyes.

    Args:
        progress: called with the finished share, 0 to 1.
    """
    start = time.perf_counter()
    views = plan.views_of(shard)
    parts = plan.parts_of(views)
    poses = [
        workshop.poses(block, range(numbers.start - block.first, numbers.stop - block.first))
        for block, numbers in parts
    ]
    every = np.concatenate(poses)
    of_poses = {
        name: values
        for name, (dimensions, values, _) in pose_variables(every, "pose").items()
        if dimensions[0] == "pose"
    }
    motions: list[Motion | None] = [None] * len(parts)
    if "flow" in workshop.job.outputs:
        motions = [
            workshop.velocities(
                block, range(numbers.start - block.first, numbers.stop - block.first), some
            )
            for (block, numbers), some in zip(parts, poses)
        ]
        for name, each in zip(HEAD_MOTION, zip(*motions)):
            of_poses[name] = np.concatenate(each)
    found: dict[str, Arrays] = {}
    done = 0
    for eye in layouts:
        rendered = []
        for (block, numbers), some, motion in zip(parts, poses, motions):

            def tell(share: float, done: int = done, count: int = len(some)) -> None:
                if progress is not None:
                    progress((done + share * count) / (len(views) * len(layouts)))

            renderer, cameras = workshop.renderer(block, eye), workshop.cameras(block)
            rendered.append(
                _render(workshop.job, renderer, some, motion, cameras, numbers.start, tell)
            )
            done += len(some)
        counts = [len(some) for some in poses]
        found[eye] = {**of_poses, **_joined(rendered, counts, layouts[eye], of_poses)}
    return RenderedShard(shard, views, found, renderer.backend, time.perf_counter() - start)


def write_shard(store: str, layouts: Mapping[str, Layout], rendered: RenderedShard) -> None:
    """Write a shard into a store, and its record when its files are there.

    Arrays are given up as they are written.
    """
    start = time.perf_counter()
    try:
        said = _write_files(store, layouts, rendered)
        record = {
            "shard": rendered.number,
            "views": [rendered.views.start, rendered.views.stop],
            "seconds": round(rendered.seconds + time.perf_counter() - start, 3),
            "machine": platform.node(),
            **backend_record(rendered.backend),
            "files": said,
        }
        name = record_file(store, rendered.number)
        write_whole(name, json.dumps(record, indent=1).encode())
    except Error as error:
        raise Error(f"{error}. What is done is kept; mend that and run the job again") from None


def _write_files(
    store: str, layouts: Mapping[str, Layout], rendered: RenderedShard
) -> dict[str, Any]:
    """Write a shard's files; the size and the hash of each."""
    said: dict[str, Any] = {}
    with WholeFiles() as files:
        for eye, layout in layouts.items():
            arrays = rendered.arrays.pop(eye)
            for name in layout.variables:
                relative = layout.file(name, rendered.number)
                data = layout.encoded(name, arrays.pop(name))
                file = files.open(os.path.join(store, relative))
                file.write(data)
                file.close()
                said[relative] = {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    return said


def _render(
    job: Job,
    renderer: Renderer,
    poses: NDArray[np.float64],
    motion: Motion | None,
    cameras: CaptureCameras | None,
    first: int,
    progress: Progress,
) -> Arrays:
    """All outputs of views that begin with number ``first``."""
    found: Arrays = {}
    asked: dict[str, Any] = {"first_pose": first, "progress": progress}
    errors = "errors" in job.outputs or is_to_error(job)
    if set(TRUTHS).intersection(job.outputs) or cameras is not None:
        things = names_of_things(renderer.world.scene)
        there = [name for name in job.instances if name in things]
        truth = renderer.ground_truth(
            poses,
            shares=there,
            head_velocity=motion,
            capture_cameras=cameras,
            standard_error=errors,
            **asked,
        )
        found["response"] = truth.responses
        if truth.standard_error is not None:
            found["standard_error"] = truth.standard_error
        if truth.rays is not None:
            found["rays"] = truth.rays
        variables = truth_variables(truth, ("pose", "ommatidium"))
        found |= {name: values for name, (_, values, _) in variables.items()}
        if job.instances:
            found["share"] = _shares(job.instances, there, truth)
    elif is_to_error(job):
        found["response"], report = renderer.render(poses, report=True, **asked)
        found["standard_error"], found["rays"] = report.standard_error, report.rays
    elif errors:
        found["response"], found["standard_error"] = renderer.render(
            poses, standard_error=True, **asked
        )
    else:
        found["response"] = renderer.render(poses, **asked)
    if "receptors" in job.outputs:
        found["receptor_response"] = np.asarray(renderer.render_receptors(poses, **asked))
    if "pictures" in job.outputs:
        found["picture"] = _pictures(job, renderer, found["response"])
    return found


def _shares(names: Sequence[str], there: list[str], truth: GroundTruth) -> NDArray[np.float32]:
    """Shares (P, N, K) of all names: what is not in this world fills nothing."""
    found = np.zeros((*truth.met.shape, len(names)), np.float32)
    if truth.shares is not None:
        found[..., [names.index(name) for name in there]] = truth.shares
    return found


def _pictures(job: Job, renderer: Renderer, responses: NDArray[np.float32]) -> NDArray[np.uint8]:
    shown = colours_of(renderer.world, responses)
    ids = projection_ids(renderer.eye, job.picture_projection, job.picture_width)
    return np.stack([_core.paint(ids, np.ascontiguousarray(one), 2.2) for one in shown])


def _joined(
    rendered: list[Arrays], counts: Sequence[int], layout: Layout, known: Collection[str]
) -> Arrays:
    """What a layout has beside what is ``known`` of several parts, one after the other; NaN where a
    part has none: source distances without splats, cameras of what was not captured."""
    joined: Arrays = {}
    for name, variable in layout.variables.items():
        if name not in known:
            parts = [
                part[name] if name in part else np.full((count, *variable.shape), np.nan)
                for part, count in zip(rendered, counts, strict=True)
            ]
            joined[name] = np.concatenate(parts).astype(variable.dtype, copy=False)
    return joined
