"""Jobs: which scenes, eyes, conditions and poses a data set is made of, read from a TOML file."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

from omma import _core
from omma._core import Error
from omma.base.addresses import expect_local
from omma.base.arguments import checked
from omma.base.files import PathLike, digests_of
from omma.base.optional import needs
from omma.base.values import value_class
from omma.datasets.job_inputs import (
    Condition,
    EyeInput,
    SceneInput,
    read_condition,
    read_eye_input,
    read_scene_input,
    same,
)
from omma.datasets.samplers import PoseSet, read_pose_set
from omma.datasets.tables import (
    Table,
    check_unlike,
    choices,
    count,
    tables,
    text,
    texts,
)
from omma.rendering.settings import (
    Fixed,
    Sampling,
    Settings,
    Shared,
    ToError,
    options_of,
)
from omma.scene.device_list import ordinals
from omma.scene.gltf_text import names_splats
from omma.scene.splat_files import is_splat_file

OUTPUTS = ("responses", "errors", "receptors", "truth", "flow", "shares", "pictures")
# Those that ground truth gives.
TRUTHS = ("truth", "flow", "shares")

_MOST_SEED = (1 << 63) - 1


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class Job:
    """A data set that is to be made: made by `load_job`."""

    path: str  # the file
    text: str  # what stands in it
    plain: dict[str, Any]  # the same as JSON has it, without what makes no difference to the views
    store: str
    seed: int
    outputs: tuple[str, ...]
    instances: tuple[str, ...]  # names of things whose shares of the field are an output
    scenes: tuple[SceneInput, ...]
    eyes: tuple[EyeInput, ...]
    conditions: tuple[Condition, ...]
    poses: tuple[PoseSet, ...]
    settings: Settings
    backend: str
    devices: tuple[int, ...]  # of that backend
    bands: int  # of worlds with light; 0: as many as `omma.light.Bands.equal` has
    picture_width: int
    picture_projection: str | None
    views_per_chunk: int  # 0: what suits
    views_per_shard: int
    slurm: dict[str, Any]  # for dask_jobqueue.SLURMCluster

    def __repr__(self) -> str:
        return (
            f"Job({self.path!r}, {len(self.scenes)} scenes, {len(self.eyes)} eyes, "
            f"{len(self.conditions)} conditions, {len(self.poses)} sets of poses)"
        )

    @property
    def is_captured(self) -> bool:
        """Whether it is told how near cameras were, in some of its scenes."""
        return any(one.capture is not None for one in self.scenes)

    @property
    def may_hold_splats(self) -> bool:
        """Whether there may be Gaussian splats in some of its worlds."""
        files = [one.file for one in self.scenes]
        files += [one.file for condition in self.conditions for one in condition.objects]
        return any(is_splat_file(file) or names_splats(file) for file in dict.fromkeys(files))

    @property
    def files(self) -> list[str]:
        """Every file it is made of, but for those that scene files name."""
        found = [one.file for one in self.scenes]
        found += [file for one in self.scenes if one.capture for file in one.capture.files]
        found += [file for one in self.eyes for file in one.files]
        found += [one.file for one in self.poses if one.file]
        for condition in self.conditions:
            found += [one.file for one in condition.objects]
            if os.path.isfile(condition.background):
                found.append(condition.background)
        return list(dict.fromkeys(found))

    def digests(self, file: str) -> dict[str, str]:
        """SHA-256 of a file, and of those that a scene file names, by their names from the job's
        folder: so a job and its files can be moved together."""
        folder = os.path.dirname(os.path.abspath(self.path))
        found = digests_of(file)
        return {os.path.relpath(name, folder): digest for name, digest in found.items()}


@checked
def load_job(path: PathLike) -> Job:
    """Read a job from a TOML file (docs/datasets.md says what can be in it).

    Names of files in it are taken from the folder that the job is in.

    Raises:
        omma.Error: the file is missing or no TOML, or something in it is missing, unknown or out of
            its range; it says where.
    """
    file = os.fsdecode(path)
    try:
        said = _core.read_file(file).decode("utf-8-sig")
        values = _toml().loads(said)
    except ValueError as error:
        raise Error(f"{file}: expected TOML, found something else: {error}") from None
    return job_from(values, file, said)


def job_from(values: Mapping[str, Any], file: str, said: str) -> Job:
    """The job of what stands in a file; ``said`` is its text."""
    folder = Path(file).resolve().parent
    job = Table(values, file)
    about = Table(job.take("dataset", same, {}), f"{file}, dataset")
    store = about.take("store", text, f"{Path(file).stem}.zarr")
    seed = about.take("seed", lambda value, where: count(value + 1, where) - 1, 0)
    outputs = about.take("outputs", texts, ("responses",))
    for one in outputs:
        choices(OUTPUTS)(one, f"{file}, dataset.outputs")
    instances = about.take("instances", texts, ())
    views_per_chunk = about.take("views_per_chunk", count, 0)
    views_per_shard = about.take("views_per_shard", count, 0)
    about.end()
    rendering = Table(job.take("rendering", same, {}), f"{file}, rendering")
    bands = rendering.take("bands", count, 0)
    backend = rendering.take("backend", text, "")
    devices = rendering.take("devices", ordinals, ())
    settings = _settings(rendering)
    pictures = Table(job.take("pictures", same, {}), f"{file}, pictures")
    width = pictures.take("width", count, 128)
    projection = pictures.take("projection", text, None)
    pictures.end()
    scenes = tuple(read_scene_input(one, folder) for one in job.take("scene", tables))
    eyes = tuple(read_eye_input(one, folder) for one in job.take("eye", tables))
    conditions = tuple(
        read_condition(one, folder) for one in job.take("condition", tables, [])
    ) or (Condition("plain", "", "", {}, {}, ()),)
    poses = tuple(
        read_pose_set(one, folder, [scene.name for scene in scenes])
        for one in job.take("poses", tables)
    )
    slurm = dict(Table(job.take("slurm", same, {}), f"{file}, slurm").rest())
    job.end()
    for kind, inputs in (("scene", scenes), ("eye", eyes), ("condition", conditions)):
        check_unlike([one.name for one in inputs], f"{file}, {kind}")
    check_unlike([one.name for one in poses], f"{file}, poses")
    check_unlike(instances, f"{file}, dataset.instances")
    _check_together(file, outputs, settings, conditions)
    if any(one.capture for one in scenes) and isinstance(settings.sampling, Shared):
        raise Error(f"{file}, rendering.shared: expected samples where there are capture_cameras")
    _check_truths(file, outputs, instances, poses)
    plain = {key: value for key, value in values.items() if key not in ("slurm",)}
    if devices:
        plain["rendering"] = {k: v for k, v in plain["rendering"].items() if k != "devices"}
    plain["dataset"] = {k: v for k, v in plain.get("dataset", {}).items() if k != "store"}
    store = str(folder / expect_local(store, "a data set"))
    return Job(
        file, said, _as_json(plain), store, seed, outputs, instances, scenes, eyes,
        conditions, poses, settings, backend, devices, bands, width, projection,
        views_per_chunk, views_per_shard, slurm,
    )  # fmt: skip


def lights_from(said: str) -> list[tuple[str, str, dict[str, Any]]]:
    """The light of each condition in the text of a job, as `Condition.light` has it, whether its
    files are still there or not."""
    found = []
    for one in _toml().loads(said).get("condition", []):
        options = dict(one.get("light", {}))
        found.append((one["name"], options.pop("sky", ""), options))
    return found


def _check_together(
    file: str, outputs: tuple[str, ...], settings: Settings, conditions: tuple[Condition, ...]
) -> None:
    if "receptors" in outputs and isinstance(settings.sampling, ToError):
        raise Error(f"{file}, rendering.error: expected samples where receptors are an output")
    truths = [one for one in TRUTHS if one in outputs]
    if truths and isinstance(settings.sampling, Shared):
        raise Error(f"{file}, rendering.shared: expected samples where {truths[0]} is an output")
    polarized = [one.name for one in conditions if one.world_options.get("polarized")]
    if polarized and isinstance(settings.sampling, Shared):
        raise Error(
            f"{file}, rendering.shared: expected samples where a condition is polarized, as "
            f"{polarized[0]!r} is: rays that ommatidia share have no one axis for it"
        )
    lit = [one.name for one in conditions if one.sky]
    unlit = [one.name for one in conditions if not one.sky]
    if lit and unlit:
        raise Error(
            f"{file}, condition: expected a light in all or in none, as they share their bands; "
            f"found one in {lit[0]!r}, none in {unlit[0]!r}"
        )


def _check_truths(
    file: str, outputs: tuple[str, ...], instances: tuple[str, ...], poses: tuple[PoseSet, ...]
) -> None:
    if ("shares" in outputs) != bool(instances):
        found = "no instances" if "shares" in outputs else "no output shares"
        raise Error(
            f"{file}, dataset: expected instances, names of things, beside the output shares; "
            f"found {found}"
        )
    for one in poses:
        if "flow" in outputs and not one.is_moving:
            keys = (
                "step_s, between two poses" if one.sampler == "path" else "speed_m_s or turn_deg_s"
            )
            raise Error(
                f"{file}, poses {one.name!r}: expected {keys}, as flow is an output, found none"
            )


def _settings(table: Table) -> Settings:
    """Of the table, which ends with it."""
    of_error = [one.name for one in options_of(ToError)]
    of_rays = ["samples", "shared", *of_error]
    given = [name for name in of_rays if table.has(name)]
    sampling: Sampling = Settings.sampling
    try:
        if len(given) > 1 and not set(given) <= set(of_error):
            raise Error(f"{' and '.join(given)}: only one of them can say how many rays there are")
        if table.has("samples"):
            sampling = Fixed(table.take("samples", same))
        elif table.has("shared"):
            sampling = Shared(table.take("shared", same))
        elif given:
            sampling = ToError(**{key: table.take(key, same, None) for key in of_error})
        names = [*(one.name for one in options_of(Settings)), "kernel"]  # the old name too
        options = {name: table.take(name, same) for name in names if table.has(name)}
        settings = Settings(sampling, **options)
    except (Error, TypeError) as error:
        raise Error(f"{table.where}: {error}") from None
    for name in (*of_rays, *(one.name for one in options_of(Settings))):
        table.take(name, same, None)  # what is not there is known too
    table.end()
    return settings


def _as_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _as_json(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_as_json(one) for one in value]
    return value.isoformat() if isinstance(value, (datetime, date, time)) else value


def _toml() -> Any:
    name = "tomllib" if sys.version_info >= (3, 11) else "tomli"
    return needs(name, "datasets", f"jobs need {name}")
