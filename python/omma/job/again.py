"""Renders that are made again from what they wrote: ``omma render-again``."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from omma import _core
from omma._core import Error
from omma.base.arguments import checked
from omma.base.backend_names import backend_differences, backend_record, backend_words
from omma.base.files import PathLike, check_kept, digests_of, reading
from omma.base.progress import Stage
from omma.base.said import (
    Said,
    is_count,
    is_list,
    is_number,
    is_object_of_texts,
    is_text,
    is_texts,
)
from omma.eye.files import load_head
from omma.job.render_job import RenderJob
from omma.job.rendering import run_job
from omma.job.reports import RenderReport
from omma.rendering.label_texts import beside
from omma.rendering.labels import eye_digest
from omma.rendering.read_back import load_responses
from omma.rendering.settings import settings_from_record
from omma.scene.capture_cameras import capture_files
from omma.scene.light_words import words_of_before


@checked
def render_like(
    like: PathLike,
    outputs: PathLike | Sequence[PathLike],
    *,
    scene: PathLike | None = None,
    eyes: PathLike | Sequence[PathLike] = (),
    threads: int = 0,
    command: str | None = None,
    progress: Stage | None = None,
) -> RenderReport:
    """Render again what a file of responses was made of, to the same bits.

    Poses, settings, seed and background are those that the file says, and scene and eyes must be
    what they were. The bits are the same for the same version of Omma on the same kind of
    processor; where one of them differs the report's warnings say so.

    Args:
        like: what `render_file` wrote: `.zarr`, `.nc`, `.parquet`, or `.npy` with its `.json`.
        outputs: files to write, as in `render_file`.
        scene, eyes: where they are now, if not where they were.
        threads, command, progress: as in `render_file`.

    Raises:
        omma.Error: a file that does not say how it was made, or was made by `Renderer.dataset`,
            which has no command; a scene, eye or background that is another now, with both
            hashes; and as `render_file`.
    """
    name = os.fsdecode(like)
    several = [outputs] if isinstance(outputs, (str, os.PathLike)) else outputs
    check_kept(several, [name, beside(name)])
    data = load_responses(like)
    record = dict(data.attrs)
    said = Said(record, name)
    is_from_python = "eye_sha256" in record and "eye_files" not in record
    if is_from_python and "world_from_head" in data.coords:
        raise Error(
            f"{name}: has no command (made by Renderer.dataset). A renderer of the same world, eye "
            "and settings renders it again: render(data.world_from_head.values, "
            "first_pose=data.attrs.get('first_pose'))"
        )
    if "eye_files" not in record or "world_from_head" not in data.coords:
        raise Error(
            f"{name}: does not say how it was made; what omma render writes as .zarr, .nc, "
            ".parquet or .npy does"
        )
    if not said.take("scene", is_text):
        raise Error(f"{name}: was rendered of a scene that was in memory, not in a file")
    background = said.take("background", is_text, None)
    if background == "":
        raise Error(f"{name}: was rendered before a background that was in memory, not in a file")
    scene_file = said.take("scene", is_text) if scene is None else scene
    check_scene(said, scene_file)
    given = [eyes] if isinstance(eyes, (str, os.PathLike)) else list(eyes)
    eye_files = given or said.take_json("eye_files", is_texts)
    check_eyes(said, eye_files)
    check_background(said)
    check_cameras(said)
    with reading(name, "responses"):
        poses = data.world_from_head.values
        # Of a track with times.
        times_s = data.time.values if "time" in data.world_from_head.dims else None
    version = said.take("omma_version", is_text)
    backend = said.take("backend", is_text)
    try:
        settings = settings_from_record(record)
    except (Error, TypeError) as error:  # of values that no setting has
        raise Error(f"{name}: {error}") from None
    job = RenderJob(
        scene_file,
        outputs,
        settings,
        eyes=eye_files,
        unit=said.take("eye_unit_m", is_number),
        poses=poses,
        scene_index=said.take("scene_index", is_count, None),
        scene_unit=said.take("scene_unit_m", is_number, None),
        scene_up=said.take("scene_up", is_text, None),
        scene_voxel_m=said.take("scene_voxel_m", is_number, None),
        capture_cameras=said.take("capture_cameras", is_text, None),
        capture_unit=said.take("capture_unit_m", is_number, None),
        capture_up=said.take("capture_up", is_text, None),
        threads=threads,
        backend=backend_word(backend),
        background=background,
        light=words_of_before(said.take("light_words", is_text, None)),
        standard_error="standard_error" in data,
        receptors="receptor" in data.response.dims,
        ultraviolet=said.take_json("ultraviolet", is_list, None),
        command=command or f"omma.job.render_like({name!r}, ...)",
    )
    report = run_job(job, progress, times_s)
    differs = []
    if version != _core.__version__:
        differs.append((f"Omma {version}", f"Omma {_core.__version__}"))
    made_by = {
        "backend": backend,
        "instruction_set": said.take("instruction_set", is_text, None),
    }
    here = backend_record(report.backend)
    if any(backend_differences(made_by, here)):
        differs.append((backend_words(made_by), backend_words(here)))
    told = [
        f"{name} was rendered with {was}, this is {now}: the last bits may differ"
        for was, now in differs
    ]
    return replace(report, warnings=(*report.warnings, *told))


def check_scene(said: Said, scene: PathLike) -> None:
    """omma.Error where the scene's files are not what they were."""
    digests = said.take_json("scene_sha256", is_object_of_texts)
    was = _beside_each_other(digests, said.take("scene", is_text))
    now = _beside_each_other(digests_of(scene), os.fsdecode(scene))
    for file in [*now, *(file for file in was if file not in now)]:
        if was.get(file) != now.get(file):
            raise Error(
                f"{os.path.join(os.path.dirname(os.fsdecode(scene)), file)}: is not what "
                f"{said.where} was rendered of: SHA-256 was {was.get(file)}, is {now.get(file)}"
            )


def check_eyes(said: Said, eyes: Sequence[PathLike]) -> None:
    """omma.Error where eye files do not give the eye that it was."""
    was = said.take("eye_sha256", is_text)
    digest = eye_digest(load_head(eyes, said.take("eye_unit_m", is_number)))
    if digest != was:
        raise Error(
            f"{', '.join(os.fsdecode(eye) for eye in eyes)}: is not the eye that {said.where} was "
            f"rendered through: SHA-256 was {was}, is {digest}"
        )


def check_background(said: Said) -> None:
    """omma.Error where a background's picture is not what it was."""
    was = said.take_json("background_sha256", is_object_of_texts, None)
    if was is None:
        return
    background = said.take("background", is_text)
    now = digests_of(background)
    if was != now:
        raise Error(
            f"{background}: is not the background of {said.where}: SHA-256 was "
            f"{', '.join(was.values())}, is {', '.join(now.values())}"
        )


def check_cameras(said: Said) -> None:
    """omma.Error where the cameras of a capture are not what they were."""
    was = said.take_json("capture_sha256", is_object_of_texts, None)
    if was is None:
        return
    path = said.take("capture_cameras", is_text)
    files = capture_files(path)
    now = {name: one for file in files for name, one in digests_of(file).items()}
    if was != now:
        raise Error(
            f"{path}: is not what the cameras of {said.where} were: SHA-256 was "
            f"{', '.join(was.values())}, is {', '.join(now.values())}"
        )


def backend_word(backend: str) -> str:
    """What chooses a backend, from what it calls itself, "embree 3.13.5" or "cuda:0 (…)"."""
    return (re.split("[ ,:]", backend.strip()) or [""])[0]


def _beside_each_other(digests: Mapping[str, str], scene: str) -> dict[str, str]:
    """Digests by where files are as seen from the scene's folder."""
    folder = os.path.dirname(scene) or "."
    return {os.path.relpath(file or ".", folder): one for file, one in digests.items()}
