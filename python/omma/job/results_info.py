"""What a file of responses tells of itself: what ``omma info`` prints of one."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from omma._core import Error
from omma.base.backend_names import backend_words
from omma.base.files import PathLike, reading
from omma.base.said import Said, is_text, is_texts
from omma.job.again import check_background, check_eyes, check_scene
from omma.job.places import place_words
from omma.rendering.label_texts import beside
from omma.rendering.read_back import is_response_csv, load_responses, read_npy
from omma.rendering.settings import Sampling, Settings, options_of

if TYPE_CHECKING:
    import xarray

Lines = list[tuple[str, str]]

_READ_BYTES = 64 << 20
_SETTINGS = (
    "sampling",
    *dict.fromkeys(
        one.name for kind in (*get_args(Sampling), Settings) for one in options_of(kind)
    ),
    *("kernel", "background", "band_from_rgb", "ultraviolet"),  # kernel: of older versions
    *("at_time_s", "at_animation", "animation", "unseen", "unseen_by_light"),
)


def is_response_file(path: PathLike) -> bool:
    """Whether a file has responses, by its ending; a `.csv` by how it begins."""
    suffix = Path(os.fsdecode(path)).suffix.lower()
    return suffix in (".zarr", ".nc", ".parquet", ".npy", ".json") or (
        suffix == ".csv" and is_response_csv(path)
    )


def describe_responses(path: PathLike) -> Lines:
    """Shape and range of responses, and how they were made.

    Raises:
        omma.Error: the file cannot be read.
    """
    name = os.fsdecode(path)
    alone = Path(name).suffix.lower() == ".npy" and not os.path.exists(beside(name))
    if alone and os.path.isfile(name):
        return _describe_array(name)
    data = load_responses(path)
    with reading(path, "responses"):
        return _describe(name, data)


def _describe(name: str, data: xarray.Dataset) -> Lines:
    sizes = [f"{data.sizes[one]:,} {_plural(one, data.sizes[one])}" for one in data.response.dims]
    lines = [("responses", name), ("shape", " x ".join(map(str, sizes)))]
    if "band" in data.coords:
        lines.append(("bands", ", ".join(map(str, data.band.values.tolist()))))
    if "type" in data.coords:
        types, counts = np.unique(data.type.values, return_counts=True)
        lines.append(("types", ", ".join(f"{c:,} {t}" for t, c in zip(types, counts))))
    unit = str(data.response.attrs.get("units", "1"))
    unit = "" if unit == "1" else f" {unit}"
    lines.append(("range", _range(data.response) + unit))
    if "standard_error" in data:
        lines.append(("standard error", _range(data.standard_error) + unit))
    if "rays" in data:
        lines.append(("rays", _range(data.rays)))
    if "camera_distance" in data:
        lines.append(("camera distance", f"{_range(data.camera_distance)} m"))
    if "camera_angle" in data:
        lines.append(("camera angle", f"{_range(data.camera_angle)} degrees"))
    if "position" in data.coords and data.position.size:
        places = data.position.values
        places = places[np.isfinite(places).all(axis=1)]  # without views that are not made yet
        if len(places):
            low, high = places.min(axis=0), places.max(axis=0)
            lines.append(("positions", f"{place_words(low)} to {place_words(high)} m"))
    if not data.attrs:
        return [*lines, ("provenance", "none: the file does not say how it was made")]
    said = Said(data.attrs, name)
    if version := said.take("omma_version", is_text, ""):
        made = f"{said.take('created', is_text, '')} by Omma {version}, "
        record = {
            "backend": said.take("backend", is_text, ""),
            "instruction_set": said.take("instruction_set", is_text, None),
        }
        lines.append(("rendered", (made + backend_words(record)).strip()))
    if command := said.take("command", is_text, ""):
        lines.append(("command", command))
    if scene := said.take("scene", is_text, ""):
        lines.append(("scene", scene + _state(check_scene, said, scene)))
    if files := said.take_json("eye_files", is_texts, None):
        lines.append(("eye", ", ".join(files) + _state(check_eyes, said, files)))
    elif "eye" in data.attrs:
        lines.append(("eye", said.take("eye", is_text) or "in memory"))
    settings = [f"{one} {data.attrs[one]}" for one in _SETTINGS if one in data.attrs]
    lines.append(("settings", ", ".join(settings)))
    if "background_sha256" in data.attrs:
        background = said.take("background", is_text)
        lines.append(("background", background + _state(check_background, said)))
    warnings = said.take("scene_warnings", is_text, "")
    lines += [("warning", text) for text in warnings.splitlines()]
    return lines


def _describe_array(name: str) -> Lines:
    array = read_npy(name)
    shape = " x ".join(f"{size:,}" for size in array.shape)
    lines = [("array", name), ("shape", f"{shape}, {array.dtype}")]
    if array.dtype.kind in "biuf" and array.size:
        lines.append(("range", f"{array.min():.4g} to {array.max():.4g}"))
    return [*lines, ("provenance", f"none: there is no {beside(name)}")]


def _state(check: Callable[..., None], said: Said, *files: Any) -> str:
    """Whether files are what they were, in words."""
    try:
        check(said, *files)
    except Error as error:
        gone = [one for one in np.ravel(files) if not os.path.exists(one)]
        return " (is not there)" if gone else f" (has changed: {error})"
    return " (unchanged)"


def _range(values: xarray.DataArray) -> str:
    """Least, mean and greatest of what is a number, read some poses at a time."""
    if values.size == 0:
        return "empty"
    first = values.dims[0]
    count = max(1, _READ_BYTES // max(1, values[:1].nbytes))
    low, high, total, there = np.inf, -np.inf, 0.0, 0
    for begin in range(0, values.sizes[first], count):
        piece = values[begin : begin + count].values
        piece = piece[~np.isnan(piece)]
        if piece.size:
            low, high = min(low, float(piece.min())), max(high, float(piece.max()))
        total, there = total + float(piece.sum(dtype=np.float64)), there + piece.size
    if there == 0:
        return "no number"
    none = "" if there == values.size else f" (none in {1 - there / values.size:.1%} of them)"
    return f"{low:.4g} to {high:.4g}, mean {total / there:.4g}{none}"


def _plural(dimension: Any, count: int) -> str:
    word = str(dimension)
    if count == 1:
        return word
    return "ommatidia" if word == "ommatidium" else word + "s"
