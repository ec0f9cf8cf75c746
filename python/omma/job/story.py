"""What files of responses say of how they were made, so that it can be done again."""

from __future__ import annotations

import inspect
import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from omma._core import Background
from omma.base.files import digests_of, metres_per_unit
from omma.job.render_job import RenderJob
from omma.receptors.sensitivity import ultraviolet_mix
from omma.scene.backgrounds import NAMED_BACKGROUNDS
from omma.scene.capture_cameras import capture_files
from omma.scene.light_words import full_words

# Arguments that do not change responses.
_SILENT = ("threads", "progress", "resume", "command")
_LONGEST = 200  # characters of an argument


def story_of(
    job: RenderJob, eyes: Sequence[str], background: Background | None, command: str
) -> dict[str, Any]:
    """Attributes beyond those of a renderer: of a job, the files of the eyes, the background
    instead of the scene's own."""
    # What a camera names is in scene units, eye files are in millimetres.
    default = "mm" if job.eye_files else "m"
    unit = default if job.unit is None else job.unit
    story: dict[str, Any] = {
        "command": command,
        "eye_files": json.dumps(list(eyes)),
        "eye_unit_m": metres_per_unit(unit),
    }
    if job.scene_index is not None:
        story["scene_index"] = int(job.scene_index)
    if job.scene_unit is not None:
        story["scene_unit_m"] = metres_per_unit(job.scene_unit)
    if job.scene_up is not None:
        story["scene_up"] = job.scene_up
    if job.scene_voxel_m is not None:
        story["scene_voxel_m"] = float(job.scene_voxel_m)
    if job.capture_cameras is not None:
        story["capture_cameras"] = os.fsdecode(job.capture_cameras)
        files = capture_files(job.capture_cameras)
        digests = {name: one for file in files for name, one in digests_of(file).items()}
        story["capture_sha256"] = json.dumps(digests)
        if job.capture_unit is not None:
            story["capture_unit_m"] = metres_per_unit(job.capture_unit)
        if job.capture_up is not None:
            story["capture_up"] = job.capture_up
    if job.ultraviolet is not None:
        story["ultraviolet"] = json.dumps(ultraviolet_mix(job.ultraviolet).tolist())
    if job.light is not None:
        story["light_words"] = full_words(job.light)
    if background is not None:
        story["background"] = _background_text(job.background, background)
        if os.path.isfile(story["background"]):
            story["background_sha256"] = json.dumps(digests_of(story["background"]))
    return story


def call_text(function: Callable[..., Any], values: Mapping[str, Any]) -> str:
    """The call of `render_file` with these arguments, as code; what was left out is left out."""
    words = []
    for name, parameter in inspect.signature(function).parameters.items():
        value = _plain(values.get(name, parameter.default))
        if parameter.default is inspect.Parameter.empty:
            words.append(repr(value))
        elif name not in _SILENT and value != _plain(parameter.default):
            text = repr(value)
            words.append(f"{name}={text if len(text) <= _LONGEST else text[:_LONGEST] + '...'}")
    return f"omma.{function.__name__}({', '.join(words)})"


def _plain(value: Any) -> Any:
    if isinstance(value, os.PathLike):
        return os.fsdecode(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    return value


def _background_text(given: Any, background: Background) -> str:
    """As `parse_background` takes it; "" where no text says it."""
    if isinstance(given, str):
        return given
    if background.type == "constant":
        return ",".join(repr(float(value)) for value in background.color)
    return background.type if background.type in NAMED_BACKGROUNDS else ""
