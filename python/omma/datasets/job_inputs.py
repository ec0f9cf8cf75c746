"""What a job names: scenes, eyes, conditions and what stands in them, read from its tables."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omma._core import Error
from omma.datasets.tables import (
    Table,
    choices,
    count,
    name,
    number_above_0,
    numbers,
    tables,
    text,
    texts,
)
from omma.scene.baking import Bake
from omma.scene.capture_cameras import capture_files
from omma.scene.light_words import OF_WORLD, SKIES


@dataclass(frozen=True)
class CaptureInput:
    """Where the photographs were taken from of which a scene was made."""

    path: str
    unit: str | float
    up: str | None

    @property
    def files(self) -> list[str]:
        """Those that are read."""
        return capture_files(self.path)


@dataclass(frozen=True)
class SceneInput:
    """A scene file and how it is read."""

    name: str
    file: str
    options: dict[str, Any]  # of `omma.load_scene`
    capture: CaptureInput | None = None


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


def read_scene_input(table: Table, folder: Path) -> SceneInput:
    """A table of a scene; names of files are taken from the folder."""
    file = table.take("file", _file_in(folder))
    options = {
        "scene_index": table.take("scene_index", lambda value, where: count(value + 1, where) - 1,
                                  None),
        "color_rule": table.take("color_rule", text, "gltf"),
        "unit": table.take("unit", same, None),
        "up": table.take("up", text, None),
        "voxel_m": table.take("voxel_m", number_above_0, None),
    }  # fmt: skip
    capture = _capture(table, folder, options)
    found = SceneInput(table.take("name", name, _plain_name(file)), file, options, capture)
    table.end()
    return found


def _capture(table: Table, folder: Path, of_scene: dict[str, Any]) -> CaptureInput | None:
    """Cameras of a scene, in its unit and with its axis up unless they say others."""
    given = table.take("capture_cameras", text, None)
    unit = table.take("capture_unit", same, None)
    up = table.take("capture_up", text, None)
    if given is None:
        if unit is not None or up is not None:
            raise Error(f"{table.where}: expected capture_cameras with their unit or axis up")
        return None
    path = os.path.normpath(folder / given)
    if not os.path.exists(path):
        raise Error(f"{table.where}.capture_cameras: expected a file or folder, found no {path}")
    capture_files(path)
    unit = of_scene["unit"] if unit is None else unit
    up = of_scene["up"] if up is None else up
    return CaptureInput(path, "m" if unit is None else unit, up)


def read_eye_input(table: Table, folder: Path) -> EyeInput:
    """A table of a head."""
    species = table.take("species", text, "")
    files = table.take("files", texts, ())
    if bool(species) == bool(files):
        raise Error(f"{table.where}: expected either files or a species")
    read = _file_in(folder)
    found = EyeInput(
        table.take("name", name, species or _plain_name(files[0] if files else "")),
        tuple(read(file, f"{table.where}.files") for file in files),
        table.take("unit", same, "mm"),
        species,
    )
    table.end()
    return found


def read_condition(table: Table, folder: Path) -> Condition:
    """A table of a condition."""
    called = table.take("name", name)
    background = table.take("background", text, "")
    if (folder / background).is_file():
        background = str(folder / background)
    sky, sky_options = "", {}
    if table.has("light"):
        light = Table(table.take("light", same), f"{table.where}.light")
        sky = light.take("sky", choices(SKIES))
        sky_options = light.rest()
    world = {key: table.take(key, same) for key in OF_WORLD if table.has(key)}
    if not isinstance(world.get("polarized", False), bool):
        raise Error(f"{table.where}.polarized: expected true or false, found {world['polarized']}")
    if table.has("bake"):
        world["bake"] = _bake(Table(table.take("bake", same), f"{table.where}.bake"))
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
    given = {key: table.take(key, same, None) for key in ("cell_m", "paths", "most_bytes", "seed")}
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


def _file_in(folder: Path) -> Any:
    def read(value: Any, where: str) -> str:
        file = str(folder / text(value, where))
        if not os.path.isfile(file):
            raise Error(f"{where}: expected a file, found none at {file}")
        return os.path.normpath(file)

    return read


def _plain_name(file: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in Path(file).stem) or "_"


def same(value: Any, where: str) -> Any:
    """Whatever it is."""
    return value
