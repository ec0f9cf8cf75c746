"""The store of a data set: its groups, arrays and attributes, and a shard's rows of an array as the
bytes of its file.

Zarr 3. Each eye has a group, which is the store itself where there is one eye. All arrays of views
have ``view`` as their first dimension; other dimensions are in one piece.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Eye
from omma.datasets.job_file import Job
from omma.datasets.plan import Plan
from omma.datasets.samplers import times_of, walks_of
from omma.datasets.shard_bytes import CHECKSUM, COMPRESSION, chunk_bytes, shard_bytes
from omma.datasets.worlds import make_light
from omma.picture.projections import projection_ids
from omma.rendering.labelled_files import load_package, write_coordinate
from omma.rendering.labels import Labels, camera_variables, labels_of, pose_variables
from omma.rendering.renderer import Renderer
from omma.rendering.settings import ToError
from omma.rendering.truth import GroundTruth, truth_variables

VIEW = "view"

# How heads move, where flow is an output.
HEAD_MOTION = {
    "head_velocity": "linear velocity of the head",
    "head_turn": "angular velocity of the head, right-handed",
}

# Attributes of labels that the manifest says better.
_NOT_OF_EYES = (
    *("created", "omma_version", "backend", "instruction_set"),
    *("scene", "light", "scene_warnings"),
)


@dataclass(frozen=True)
class Variable:
    """An array of views: what one view has."""

    dimensions: tuple[str, ...]  # without the view's
    shape: tuple[int, ...]
    dtype: str
    attributes: dict[str, Any]
    is_sharded: bool = True  # else a shard is one chunk: small things, read all together


@dataclass(frozen=True)
class Layout:
    """The group of one eye."""

    group: str  # "" for the store itself
    variables: dict[str, Variable]
    labels: Labels  # of one view: coordinates and attributes
    views: int = 1
    views_per_chunk: int = 1
    views_per_shard: int = 1
    is_summed: bool = True  # whether chunks have checksums

    def file(self, variable: str, shard: int) -> str:
        """Where a shard of a variable is, in the store."""
        zeros = ".0" * len(self.variables[variable].shape)
        return os.path.join(self.group, variable, f"c.{shard}{zeros}")

    def encoded(self, variable: str, values: NDArray[Any]) -> bytes:
        """Values of a shard's views as the bytes of its file."""
        one = self.variables[variable]
        values = np.asarray(values, one.dtype)
        fill = _fill_value(one.dtype)
        if one.is_sharded:
            return shard_bytes(
                values, self.views_per_chunk, self.views_per_shard, fill, is_summed=self.is_summed
            )
        return chunk_bytes(values, self.views_per_shard, fill, is_summed=self.is_summed)

    def create(self, root: Any, coordinates: Mapping[str, Any]) -> None:
        """Make the group in an open one; ``coordinates`` are those of views that are known."""
        group = root.require_group(self.group) if self.group else root
        group.attrs.update(
            {key: value for key, value in self.labels.attributes.items() if key not in _NOT_OF_EYES}
        )
        known = {**self.labels.coordinates, **coordinates}
        along_views = [name for name, variable in self.variables.items() if not variable.is_sharded]
        for name, (dimensions, values, attributes) in known.items():
            if dimensions[:1] == ("pose",):
                continue  # those of the one view that labels were made of
            write_coordinate(group, name, dimensions, values, attributes)
        for name, variable in self.variables.items():
            beside = [
                other
                for other, (dimensions, _, _) in known.items()
                if dimensions != (other,) and dimensions[0] in (VIEW, *variable.dimensions)
                and dimensions[0] != "pose"
            ]  # fmt: skip
            if variable.is_sharded:
                beside += along_views
            more = {"coordinates": " ".join(dict.fromkeys(beside))} if variable.is_sharded else {}
            array = self._array(name, self.views)
            array["attributes"] = variable.attributes | more
            group.create_array(name, **array)

    def _array(self, variable: str, views: int) -> dict[str, Any]:
        """Arguments that make the array of a variable."""
        one = self.variables[variable]
        codecs = load_package("zarr", "datasets").codecs
        inner = self.views_per_chunk if one.is_sharded else self.views_per_shard
        return {
            "shape": (views, *one.shape),
            "dtype": one.dtype,
            "chunks": (inner, *one.shape),
            "shards": (self.views_per_shard, *one.shape) if one.is_sharded else None,
            "dimension_names": (VIEW, *one.dimensions),
            "compressors": [
                codecs.BloscCodec(**COMPRESSION, typesize=np.dtype(one.dtype).itemsize),
                codecs.Crc32cCodec(),
            ],
            "fill_value": _fill_value(one.dtype),
            "chunk_key_encoding": {"name": "default", "separator": "."},
        }


def _fill_value(dtype: str) -> float:
    """The value of views that are not made yet."""
    return np.nan if np.dtype(dtype).kind == "f" else 0


def make_layouts(job: Job, eyes: Mapping[str, Eye]) -> dict[str, Layout]:
    """The group of each eye, by the eye's name, as of one view: `view_bytes` says how large it is,
    by which there is a plan, and `planned` makes them those of all views."""
    found = {}
    for eye_name, eye in eyes.items():
        labels = _labels(job, eye)
        variables, coordinates = _variables(job, eye, labels)
        labels = replace(labels, coordinates=labels.coordinates | coordinates)
        group = "" if len(eyes) == 1 else eye_name
        found[eye_name] = Layout(group, variables, labels)
    return found


def planned(layouts: Mapping[str, Layout], plan: Plan) -> dict[str, Layout]:
    """The groups with the views of a plan."""
    return {
        eye: replace(
            layout,
            views=plan.views,
            views_per_chunk=plan.views_per_chunk,
            views_per_shard=plan.views_per_shard,
        )
        for eye, layout in layouts.items()
    }


def as_begun(layouts: Mapping[str, Layout], manifest: Mapping[str, Any]) -> dict[str, Layout]:
    """The groups as those of the store with this manifest: those of older versions of Omma have no
    checksums."""
    is_summed = manifest.get("checksum") == CHECKSUM
    return {eye: replace(layout, is_summed=is_summed) for eye, layout in layouts.items()}


def view_bytes(layouts: Mapping[str, Layout]) -> tuple[int, int]:
    """Of a view of the largest eye: all variables, and the largest of them."""
    sizes = [
        [
            int(np.prod(one.shape)) * np.dtype(one.dtype).itemsize
            for one in layout.variables.values()
        ]
        for layout in layouts.values()
    ]
    return max(map(sum, sizes)), max(map(max, sizes))


def view_coordinates(job: Job, plan: Plan) -> dict[str, Any]:
    """Which scene, condition and set of poses each view is of, as (dimensions, values, attributes);
    the attributes say the names, as the CF conventions have it (3.5). Where poses follow one
    another, also of which walk it is and when."""
    columns = np.empty((4, plan.views), np.int32)
    for block in plan.blocks:
        views = slice(block.first, block.first + block.count)
        columns[:3, views] = [[block.scene], [block.condition], [block.poses]]
        columns[3, views] = np.arange(block.count)
    kinds = (("scene", job.scenes), ("condition", job.conditions), ("pose_set", job.poses))
    found: dict[str, Any] = {}
    for (name, inputs), values in zip(kinds, columns):
        names = [one.name for one in inputs]  # type: ignore[attr-defined]
        about = {"flag_values": list(range(len(names))), "flag_meanings": " ".join(names)}
        found[name] = ((VIEW,), values, about)
    found["pose"] = ((VIEW,), columns[3], {"long_name": "number of the pose in its set"})
    walks = np.concatenate([walks_of(job.poses[block.poses]) for block in plan.blocks])
    times_s = np.concatenate([times_of(job.poses[block.poses]) for block in plan.blocks])
    if (walks >= 0).any():
        about_walks = {"long_name": "number of the walk in its set, -1 where there is none"}
        found["walk"] = ((VIEW,), walks, about_walks)
    if np.isfinite(times_s).any():
        about_times = {"units": "s", "long_name": "since the walk began, or as its track says"}
        found["time"] = ((VIEW,), times_s, about_times)
    return found


def create_store(
    path: str,
    layouts: Mapping[str, Layout],
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> None:
    """Make all groups and arrays, without the views, in an empty directory."""
    zarr = load_package("zarr", "datasets")
    with warnings.catch_warnings():
        # Of texts, which are newer than Zarr's standard and read by zarr and xarray.
        warnings.simplefilter("ignore")
        root = zarr.open_group(path, mode="a", zarr_format=3)
        for layout in layouts.values():
            layout.create(root, coordinates)
        root.attrs.update(attributes)
        zarr.consolidate_metadata(path)


def _labels(job: Job, eye: Eye) -> Labels:
    """Of one view in a world with nothing in it, which has the bands and the settings."""
    from omma._core import Scene
    from omma.scene.world import World

    light = make_light(*job.conditions[0].light, job.bands)
    renderer = Renderer(
        World(Scene(), light=light, backend=job.backend, devices=job.devices, threads=1),
        eye,
        job.settings.sampling,
        threads=1,
        **job.settings.options(),
    )
    return labels_of(renderer, np.eye(4)[None], standard_error="errors" in job.outputs)


def _variables(job: Job, eye: Eye, labels: Labels) -> tuple[dict[str, Variable], dict[str, Any]]:
    """What is kept of each view of an eye, and coordinates that this has besides."""
    found: dict[str, Variable] = {}
    coordinates: dict[str, Any] = {}
    for name, (dimensions, values, about) in pose_variables(np.eye(4)[None], "pose").items():
        if dimensions[0] == "pose":
            shape = values.shape[1:]
            found[name] = Variable(dimensions[1:], shape, values.dtype.name, about, False)
    for name, (dimensions, dtype, about) in labels.variables.items():
        if name == "response" and "responses" not in job.outputs:
            continue
        shape = labels.shape(name)[1:]
        found[name] = Variable(dimensions[1:], shape, dtype, about)
    if "receptors" in job.outputs:
        about = {"units": labels.variables["response"][2]["units"]}
        found["receptor_response"] = Variable(
            ("receptor",), (len(eye.receptor_type),), "float32", about
        )
    for name, (dimensions, values, about) in truth_variables(
        _no_truth(job, len(eye)), ("pose", "ommatidium")
    ).items():
        kind = "shares" if name == "share" else "flow" if name.startswith("flow") else "truth"
        if dimensions[0] != "pose":
            coordinates[name] = (dimensions, values, about)
        elif name in camera_variables("pose"):
            shape = values.shape[1:]
            found[name] = Variable(dimensions[1:], shape, values.dtype.name, about, bool(shape))
        elif kind in job.outputs:
            found[name] = Variable(dimensions[1:], values.shape[1:], values.dtype.name, about)
    if "flow" in job.outputs:
        for name, unit in (("head_velocity", "m s-1"), ("head_turn", "rad s-1")):
            about = {"units": unit, "long_name": f"{HEAD_MOTION[name]}, in the world's frame"}
            found[name] = Variable(("axis",), (3,), "float64", about, False)
    if "pictures" in job.outputs:
        shape = (*projection_ids(eye, job.picture_projection, job.picture_width).shape, 3)
        about = {"long_name": "picture of the response, as a screen shows it"}
        found["picture"] = Variable(("row_of_picture", "column_of_picture", "colour"), shape,
                                    "uint8", about)  # fmt: skip
    return found, coordinates


def _no_truth(job: Job, ommatidia: int) -> GroundTruth:
    """Of one view, of the shapes and types that it has."""
    one = np.zeros((1, ommatidia), np.float32)
    three = np.zeros((1, ommatidia, 3), np.float32)
    more: dict[str, Any] = {}
    if "shares" in job.outputs:
        names = job.instances
        more = {"names": names, "shares": np.zeros((1, ommatidia, len(names)), np.float32)}
    if "flow" in job.outputs:
        more |= dict.fromkeys(
            ("flow_rotation_rad_s", "flow_translation_rad_s", "flow_objects_rad_s"), three[..., :2]
        )
    if job.may_hold_splats:
        more["source_distance_m"] = one
    if job.is_captured:
        more |= {"camera_distance_m": np.zeros(1), "camera_angle_deg": one}
    return GroundTruth(three, one, one, one, one, three.astype(np.float64), three, **more)


def is_to_error(job: Job) -> bool:
    """Whether views have standard errors and rays in any case."""
    return isinstance(job.settings.sampling, ToError)
