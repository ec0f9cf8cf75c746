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
from omma.datasets.samplers import PoseSet, read_pose_set
from omma.datasets.tables import (
    Table,
    check_unlike,
    choices,
    count,
    name,
    number_above_0,
    numbers,
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
    settings_as_record,
)
from omma.scene.baking import Bake
from omma.scene.device_list import ordinals
from omma.scene.light_words import SKIES

OUTPUTS = ("responses", "errors", "receptors", "truth", "flow", "shares", "pictures")
# Those that ground truth gives.
TRUTHS = ("truth", "flow", "shares")

_MOST_SEED = (1 << 63) - 1


@dataclass(frozen=True)
class SceneInput:
    """A scene file and how it is read."""

    name: str
    file: str
    options: dict[str, Any]  # of `omma.load_scene`


@dataclass(frozen=True)
class EyeInput:
    """One head: eye files together, or a species."""

    name: str
    files: tuple[str, ...]
    unit: str | float
    species: str


@dataclass(frozen=True)
class PlacedObject:
    """A scene file that is put into a scene."""

    file: str
    position_m: tuple[float, ...]  # (3,)
    yaw_deg: float  # to the right, as a head turns
    scale: float


@dataclass(frozen=True)
class Condition:
    """How a scene is lit and what stands in it besides."""

    name: str
    background: str  # as `parse_background` takes it; "" for the scene's own
    sky: str  # one of `SKIES`; "" for a world without light
    sky_options: dict[str, Any]
    world_options: dict[str, Any]  # lighting, depth and others, of `omma.World`
    objects: tuple[PlacedObject, ...]

    @property
    def light(self) -> tuple[str, str, dict[str, Any]]:
        """Its name, the sky and the sky's arguments."""
        return self.name, self.sky, self.sky_options


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
    def files(self) -> list[str]:
        """Every file it is made of, but for those that scene files name."""
        found = [one.file for one in self.scenes]
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
    about = Table(job.take("dataset", _same, {}), f"{file}, dataset")
    store = about.take("store", text, f"{Path(file).stem}.zarr")
    seed = about.take("seed", lambda value, where: count(value + 1, where) - 1, 0)
    outputs = about.take("outputs", texts, ("responses",))
    for one in outputs:
        choices(OUTPUTS)(one, f"{file}, dataset.outputs")
    instances = about.take("instances", texts, ())
    views_per_chunk = about.take("views_per_chunk", count, 0)
    views_per_shard = about.take("views_per_shard", count, 0)
    about.end()
    rendering = Table(job.take("rendering", _same, {}), f"{file}, rendering")
    bands = rendering.take("bands", count, 0)
    backend = rendering.take("backend", text, "")
    devices = rendering.take("devices", ordinals, ())
    settings = _settings(rendering)
    pictures = Table(job.take("pictures", _same, {}), f"{file}, pictures")
    width = pictures.take("width", count, 128)
    projection = pictures.take("projection", text, None)
    pictures.end()
    scenes = tuple(_scene(one, folder) for one in job.take("scene", tables))
    eyes = tuple(_eye(one, folder) for one in job.take("eye", tables))
    conditions = tuple(_condition(one, folder) for one in job.take("condition", tables, [])) or (
        Condition("plain", "", "", {}, {}, ()),
    )
    poses = tuple(
        read_pose_set(one, folder, [scene.name for scene in scenes])
        for one in job.take("poses", tables)
    )
    slurm = dict(Table(job.take("slurm", _same, {}), f"{file}, slurm").rest())
    job.end()
    for kind, inputs in (("scene", scenes), ("eye", eyes), ("condition", conditions)):
        check_unlike([one.name for one in inputs], f"{file}, {kind}")
    check_unlike([one.name for one in poses], f"{file}, poses")
    check_unlike(instances, f"{file}, dataset.instances")
    _check_together(file, outputs, settings, conditions)
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


def _scene(table: Table, folder: Path) -> SceneInput:
    file = table.take("file", _file_in(folder))
    options = {
        "scene_index": table.take("scene_index", lambda value, where: count(value + 1, where) - 1,
                                  None),
        "color_rule": table.take("color_rule", text, "gltf"),
        "unit": table.take("unit", _same, None),
        "up": table.take("up", text, None),
        "voxel_m": table.take("voxel_m", number_above_0, None),
    }  # fmt: skip
    found = SceneInput(table.take("name", name, _plain_name(file)), file, options)
    table.end()
    return found


def _eye(table: Table, folder: Path) -> EyeInput:
    species = table.take("species", text, "")
    files = table.take("files", texts, ())
    if bool(species) == bool(files):
        raise Error(f"{table.where}: expected either files or a species")
    read = _file_in(folder)
    found = EyeInput(
        table.take("name", name, species or _plain_name(files[0] if files else "")),
        tuple(read(file, f"{table.where}.files") for file in files),
        table.take("unit", _same, "mm"),
        species,
    )
    table.end()
    return found


def _condition(table: Table, folder: Path) -> Condition:
    called = table.take("name", name)
    background = table.take("background", text, "")
    if (folder / background).is_file():
        background = str(folder / background)
    sky, sky_options = "", {}
    if table.has("light"):
        light = Table(table.take("light", _same), f"{table.where}.light")
        sky = light.take("sky", choices(SKIES))
        sky_options = light.rest()
    world = {
        key: table.take(key, _same)
        for key in ("lighting", "depth", "ultraviolet", "sun", "emission_cd_m2")
        if table.has(key)
    }
    if table.has("bake"):
        world["bake"] = _bake(Table(table.take("bake", _same), f"{table.where}.bake"))
    if world and not sky:
        raise Error(f"{table.where}.{next(iter(world))}: goes with a light")
    if sky:
        world.setdefault("lighting", "path")
    if "bake" in world and world["lighting"] != "baked":
        raise Error(f'{table.where}.bake: goes with lighting = "baked"')
    objects = tuple(_object(one, folder) for one in table.take("object", tables, []))
    table.end()
    return Condition(called, background, sky, sky_options, world, objects)


def _bake(table: Table) -> Bake:
    given = {key: table.take(key, _same, None) for key in ("cell_m", "paths", "most_bytes", "seed")}
    table.end()
    try:
        return Bake(**{key: value for key, value in given.items() if value is not None})
    except (Error, TypeError) as error:
        raise Error(f"{table.where}: {error}") from None


def _object(table: Table, folder: Path) -> PlacedObject:
    found = PlacedObject(
        table.take("file", _file_in(folder)),
        table.take("position_m", numbers(3), (0.0, 0.0, 0.0)),
        table.take("yaw_deg", lambda value, where: numbers(1)([value], where)[0], 0.0),
        table.take("scale", number_above_0, 1.0),
    )
    table.end()
    return found


def _settings(table: Table) -> Settings:
    """Of the table, which ends with it."""
    ways: dict[str, Sampling] = {}
    try:
        if table.has("samples"):
            ways["samples"] = Fixed(table.take("samples", _same))
        if table.has("shared"):
            ways["shared"] = Shared(table.take("shared", _same))
        if table.has("error") or table.has("relative_error"):
            of_error = [one.name for one in options_of(ToError)]
            ways["error"] = ToError(**{key: table.take(key, _same, None) for key in of_error})
        if len(ways) > 1:
            raise Error(f"{' and '.join(ways)}: only one of them can say how many rays there are")
        names = [*(one.name for one in options_of(Settings)), "kernel"]  # the old name too
        options = {name: table.take(name, _same) for name in names if table.has(name)}
        settings = Settings(next(iter(ways.values()), Settings.sampling), **options)
    except (Error, TypeError) as error:
        raise Error(f"{table.where}: {error}") from None
    for one in (
        *settings_as_record(settings),
        *(one.name for one in options_of(ToError)),
        "shared",
    ):
        table.take(one, _same, None)
    table.end()
    return settings


def _file_in(folder: Path) -> Any:
    def read(value: Any, where: str) -> str:
        file = str(folder / text(value, where))
        if not os.path.isfile(file):
            raise Error(f"{where}: expected a file, found none at {file}")
        return os.path.normpath(file)

    return read


def _plain_name(file: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in Path(file).stem) or "_"


def _same(value: Any, where: str) -> Any:
    return value


def _as_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _as_json(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_as_json(one) for one in value]
    return value.isoformat() if isinstance(value, (datetime, date, time)) else value


def _toml() -> Any:
    name = "tomllib" if sys.version_info >= (3, 11) else "tomli"
    return needs(name, "datasets", f"jobs need {name}")
