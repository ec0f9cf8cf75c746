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
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma import _core
from omma.base.files import WholeFiles
from omma.datasets.job_file import Job
from omma.datasets.layout import Layout, is_to_error
from omma.datasets.plan import Plan
from omma.datasets.records import record_file
from omma.datasets.worlds import Workshop
from omma.picture.band_colours import bands_to_rgb
from omma.picture.projections import projection_ids
from omma.rendering.labels import place_variables
from omma.rendering.renderer import Renderer
from omma.rendering.truth import truth_variables

Arrays = dict[str, NDArray[Any]]


def make_shard(
    store: str,
    workshop: Workshop,
    plan: Plan,
    layouts: Mapping[str, Layout],
    shard: int,
    progress: Callable[[float], object] | None = None,
) -> dict[str, Any]:
    """Render a shard's views for all eyes into a store; what its record says.

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
    places = {
        name: values
        for name, (dimensions, values, _) in place_variables(every, "pose").items()
        if dimensions[0] == "pose"
    }
    said: dict[str, Any] = {}
    done = 0
    with WholeFiles() as files:
        for eye, layout in layouts.items():
            rendered = []
            for (block, numbers), some in zip(parts, poses):

                def tell(share: float, done: int = done, count: int = len(some)) -> None:
                    if progress is not None:
                        progress((done + share * count) / (len(views) * len(layouts)))

                renderer = workshop.renderer(block, eye)
                rendered.append(_render(workshop.job, renderer, some, numbers.start, tell))
                done += len(some)
            arrays = {**places, **_joined(rendered)}
            rendered.clear()
            for name in layout.variables:
                relative = layout.file(name, shard)
                data = layout.encoded(name, arrays.pop(name))
                file = files.open(os.path.join(store, relative))
                file.write(data)
                file.close()
                said[relative] = {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    record = {
        "shard": shard,
        "views": [views.start, views.stop],
        "seconds": round(time.perf_counter() - start, 3),
        "machine": platform.node(),
        "files": said,
    }
    with WholeFiles() as files:
        files.open(record_file(store, shard)).write(json.dumps(record, indent=1).encode())
    return record


def _render(
    job: Job,
    renderer: Renderer,
    poses: NDArray[np.float64],
    first: int,
    progress: Callable[[float], object],
) -> Arrays:
    """All outputs of views that begin with number ``first``."""
    found: Arrays = {}
    asked: dict[str, Any] = {"first_pose": first, "progress": progress}
    errors = "errors" in job.outputs or is_to_error(job)
    if "truth" in job.outputs:
        truth = renderer.ground_truth(poses, standard_error=errors, **asked)
        found["response"] = truth.responses
        if truth.standard_error is not None:
            found["standard_error"] = truth.standard_error
        if truth.rays is not None:
            found["rays"] = truth.rays
        variables = truth_variables(truth, ("pose", "ommatidium"))
        found |= {name: values for name, (_, values, _) in variables.items()}
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


def _pictures(job: Job, renderer: Renderer, responses: NDArray[np.float32]) -> NDArray[np.uint8]:
    light = renderer.world.light
    shown = responses if light is None else bands_to_rgb(responses, light)
    ids = projection_ids(renderer.eye, job.picture_projection, job.picture_width)
    return np.stack([_core.paint(ids, np.ascontiguousarray(one), 2.2) for one in shown])


def _joined(rendered: list[Arrays]) -> Arrays:
    if len(rendered) == 1:
        return rendered[0]
    return {name: np.concatenate([one[name] for one in rendered]) for name in rendered[0]}
