"""From files to files: what the command ``omma render`` does, as one function."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omma import _core
from omma._core import Error
from omma.base.arguments import checked
from omma.base.arrays import Floats
from omma.base.files import PathLike, WholeFiles, left_behind, make_parents
from omma.base.progress import Stage
from omma.base.renamed import renamed_arguments
from omma.job.animated import times_that_move
from omma.job.begun import Begun, View, begin, input_files, view_of
from omma.job.camera_picture import render_picture
from omma.job.outputs import earlier_files, remove_earlier, writers_of
from omma.job.pieces import (
    BesideCameras,
    Render,
    render_of_ommatidia,
    render_of_receptors,
    render_pieces,
)
from omma.job.render_job import JobOptions, RenderJob, job_of, takes_job
from omma.job.reports import RenderReport
from omma.job.resuming import KeptRender, inputs_of
from omma.job.story import call_text, story_of
from omma.picture.cameras import camera_projection
from omma.picture.files import Paint, paint_of_projection, paint_side_by_side
from omma.picture.video import VideoWriter, frame_rate
from omma.rendering.labels import labels_of
from omma.rendering.renderer import Renderer
from omma.rendering.report import SpentRays
from omma.rendering.settings import Sampling, Settings, Shared, ToError, takes_options
from omma.scene.building import BUILDING
from omma.scene.light_words import warnings_of

if TYPE_CHECKING:
    from typing_extensions import Unpack


@renamed_arguments(kernel="angular_sensitivity")
@checked
@takes_options
@takes_job
def render_file(
    scene: PathLike,
    outputs: PathLike | Sequence[PathLike],
    sampling: Sampling = Settings.sampling,
    *,
    progress: Stage | None = None,
    **asked: Unpack[JobOptions],
) -> RenderReport:
    """Render a scene file through eye files, or one of its cameras, into files.

    This is what ``omma render`` does. Poses and responses go through memory a piece at a time, so
    that any number of poses will do.

    Args:
        scene: a file as `load_scene` reads it.
        outputs: files to write, by their endings. Of an eye: `.zarr`, `.nc`, `.parquet`, and
            `.npy` with a `.json` beside it, which say what the numbers are and are read by
            `omma.rendering.load_responses` (docs/datasets.md); `.csv` as `save_responses`
            writes it; `.png` a picture (of several poses: name_0000.png and on, by the number of
            the pose); `.mp4` a video with a frame for each pose, as many a second as the path's
            times have, 30 without times; the report's warnings say where times are uneven, which
            the mean rate is for, or rates are below 1 or above 240, where it is 30. Widths and
            heights of videos are even, one pixel more where they were not. Of another camera:
            `.npy`, float32 (height, width, 3) as `render_camera` gives it, and `.png`. Missing
            directories are made, which the report names. What an earlier render wrote beside an
            `.npy` file and this one does not is removed, with a warning.
        eyes: `.eye` files, together one head. None: the camera as it is, a compound one with the
            eye that it names in its ``compound-structure``, see `camera_eye`.
        unit: of lengths in the eye files: "mm" (the default), "um", "m" or metres. For a camera's
            own eye the default is the scene's unit, as in CompoundRay.
        camera: name or index of the camera in the scene that is rendered, or with ``eyes`` that the
            head is at; its whole transform is the pose, its scale too. With ``position``, ``path``
            or ``poses`` and no ``eyes`` it is the camera's own eye, in its scale, that is there.
        position, look_at: instead, where the head is and the point it looks at, (3,), m; without
            ``look_at`` it looks along -Z. Straight up or down it is as if it had lifted or lowered
            its view from along -Z: looking down, its upper side is towards -Z.
        path: instead, a CSV file of poses, see `load_poses`. Where it has times, ``t_s``, the first
            dimension of what says its numbers is ``time``, s, not ``pose``, and the scene's
            animations move what they move by these times; else it is rendered at rest, which the
            report's warnings say of a scene with animations.
        on_ground: of a head that walks: its height above the ground, m. ``path`` is then a track,
            see `omma.motion.load_track` and `omma.motion.walk_on`; it may have times too.
        ground: with it, a name or names of instances that are ground; none: everything is.
        lost: with it, what becomes of positions that lack a number, as of `omma.motion.load_track`.
        poses: instead, matrices world_from_head (P, 4, 4) or (4, 4), m.
        scene_index: which of the scenes in the file; None takes its default.
        scene_unit, scene_up, scene_voxel_m: of the scene's file, ``unit``, ``up`` and ``voxel_m``
            of `load_scene`.
        capture_cameras: where the photographs were taken from of which the scene was made, a file
            or folder as `load_capture_cameras` reads it: responses then come with how near the
            nearest camera was, ``camera_distance`` and ``camera_angle`` of `GroundTruth`. In
            `.npy` they are OUT.camera_distance.npy and OUT.camera_angle.npy, in `.csv` two more
            columns. Not with `Shared`, nor of receptors.
        capture_unit, capture_up: of its file; None: ``scene_unit`` and ``scene_up`` where these are
            said, else as `load_capture_cameras` has it.
        sampling, options: as in `Renderer`; the frame of a path's pose has its number in the path.
            A camera's picture takes `Fixed` and a seed, as `render_camera` does.
        threads, backend, devices: as in `Renderer`.
        background: a `Background`, or text as `parse_background` takes it.
        light: what lights the scene, as text that `omma.scene.light_words.parse_light` takes;
            numbers are then spectral radiance in bands, and pictures have the colours that people
            see.
        standard_error: also write standard errors of an eye's responses: beside OUT.npy an
            OUT.error.npy, in a `.csv` three more columns, else a variable or columns of their own.
        receptors: write responses of the eye's receptors: `.npy`, float32 (P, R), and `.csv`, a
            line for each pose and receptor. Not with `ToError`.
        ultraviolet: light below 400 nm for receptors, see `Renderer.render_receptors`.
        projection: of an eye in a picture, see `omma.picture.project`. None: for a camera's own eye
            the camera's ``compound-projection``, else as `omma.picture.framed`: in a frame with
            degrees, hatched where no ommatidium looks, eyes whose fields overlap apart.
        width, height: pixels of a picture, see `render_camera` and `projection_ids`. Of one panel
            without its frame where no projection is named.
        side_by_side: give each eye a panel of its own, always.
        gamma: of pictures.
        resume: of a path, into `.npy`, `.csv` and `.png`. What is rendered so far is kept where
            the work is cut off, by Ctrl-C, a kill or a loss of power, and the same call goes on
            from there, to the same bits: beside an output OUT there are then OUT.partial and,
            beside the first, OUT.resume. Pictures of several poses get their names one by one.
        command: what files that say how they were made say of it; None: this call.
        progress: called with what is being done and its finished share, None where not known.

    Without camera, position, path and poses the head is at the scene's first camera, or at the
    origin where the scene has none. Without eyes either, the first compound camera is rendered, or
    the first of all where none is.

    Raises:
        omma.Error: anything wrong with an input, named in the message; with ``resume`` also where
            what is kept was made from other inputs. No output is left then.
        KeyboardInterrupt: Ctrl-C. But for ``resume`` nothing is left.
    """
    return run_job(job_of(scene, outputs, sampling, asked), progress)


def run_job(
    job: RenderJob, progress: Stage | None = None, times_s: Floats | None = None
) -> RenderReport:
    """What `render_file` does; ``times_s`` say when poses that were given are."""
    begun = begin(job, progress if progress is not None else lambda stage, fraction: None)
    camera = begun.camera
    if camera is not None and not job.eye_files and camera.type != "compound":
        if begun.cameras is not None:
            raise Error(f"capture_cameras: is for eyes; camera '{camera.name}' is {camera.type}")
        return render_picture(begun, camera)
    view = view_of(begun)
    warnings = warnings_of(begun.scene, bool(begun.light))
    projection = _projection(begun, warnings)
    renderer = Renderer(
        begun.world(),
        view.head,
        job.settings.sampling,
        threads=job.threads,
        progress=partial(begun.tell, BUILDING),
        **job.settings.options(),
    )
    _tell_of_sharing(job, renderer, warnings)
    times_s = view.times_s if times_s is None else times_s
    moving = times_that_move(renderer.world, times_s, warnings)
    _tell_of_rate(begun.names, times_s, warnings)
    built = time.perf_counter()
    folders = make_parents(begun.names)
    kept = _kept(begun, view, renderer) if job.resume else None
    spent = kept.spent if kept is not None else None
    if spent is None and isinstance(job.settings.sampling, ToError):
        target = job.settings.sampling
        spent = SpentRays(target.error or 0.0, target.relative_error or 0.0)
    command = job.command or call_text(render_file, job.arguments())
    labels = labels_of(
        renderer,
        view.poses,
        receptors=job.receptors,
        standard_error=job.standard_error,
        with_cameras=begun.cameras is not None,
        time_s=times_s,
        more=story_of(job, view.files, begun.background, command),
        first_pose=0,
    )

    def make_paint() -> Paint:
        begun.tell("Preparing the picture", None)
        if job.side_by_side:
            return paint_side_by_side(renderer, job.width, job.height, job.gamma)
        return paint_of_projection(
            renderer, view.poses, projection, job.width, job.height, job.gamma
        )

    begun_writing, seconds_before = time.perf_counter(), 0.0 if kept is None else kept.seconds
    with WholeFiles(None if kept is None else kept.bytes) as files, ExitStack() as closed:
        writers, written = writers_of(
            files,
            closed,
            begun.names,
            labels,
            view.head,
            receptors=job.receptors,
            standard_error=job.standard_error,
            make_paint=make_paint,
        )
        earlier = earlier_files(written)
        render: Render
        if job.receptors:
            render = render_of_receptors(renderer, job.ultraviolet, job.standard_error, moving)
        elif begun.cameras is not None:
            render = BesideCameras(renderer, begun.cameras, job.standard_error, spent, moving)
        else:
            render = render_of_ommatidia(renderer, job.standard_error, spent, moving)
        pose_bytes = 4 * max(1, int(np.prod(labels.shape("response")[1:])))
        pieces = partial(render_pieces, render, writers, view.poses, pose_bytes, begun.tell)
        if kept is None:
            seconds = pieces()
        else:
            with kept.telling(len(view.poses)):
                seconds = kept.seconds + pieces(partial(kept.save, files, spent), kept.done)
    writing = time.perf_counter() - begun_writing - (seconds - seconds_before)
    if kept is not None:
        kept.remove()
    if isinstance(render, BesideCameras) and render.met and not render.known:
        warnings.append(
            f"{os.fsdecode(str(job.capture_cameras))}: no camera had anything in its field that is "
            "seen here; are its unit and its axis up those of the scene (capture_unit, capture_up)?"
        )
    warnings += [*remove_earlier(earlier), *left_behind(*_by_kind(written))]
    resumed = f", resumed at pose {kept.done:,}" if kept is not None and kept.done else ""
    return RenderReport(
        ommatidia=len(view.head),
        poses=len(view.poses),
        rays=_rays(job, renderer, len(view.poses)) if spent is None else spent.total,
        seconds=seconds,
        build_seconds=built - begun.started,
        writing_seconds=writing,
        frames_per_s=len(view.poses) / max(seconds, 1e-9),
        backend=renderer.backend,
        threads=renderer.threads,
        view=view.text + resumed,
        eyes=tuple(view.files),
        outputs=tuple(written),
        warnings=tuple(warnings),
        folders=folders,
        spent=spent,
        receptors=len(view.head.receptor_type) if job.receptors else 0,
        video=next((one.told for one in writers if isinstance(one, VideoWriter)), None),
    )


def _projection(begun: Begun, warnings: list[str]) -> str | None:
    """How an eye is shown in a picture; None: as `omma.picture.framed`."""
    job, camera = begun.job, begun.camera
    if job.projection is not None:
        if job.side_by_side:
            raise Error("projection: side_by_side has its own")
        return job.projection
    if camera is None or job.eye_files:
        return None
    projection, warning = camera_projection(camera)
    warnings += [] if warning is None else [warning]
    return projection


def _tell_of_sharing(job: RenderJob, renderer: Renderer, warnings: list[str]) -> None:
    if isinstance(job.settings.sampling, Shared) and not job.receptors:
        shared, ommatidia = np.count_nonzero(renderer.shared_ommatidia), len(renderer.eye)
        if 2 * shared < ommatidia:
            warnings.append(
                f"sampling: {shared:,} of {ommatidia:,} ommatidia share rays; the others would "
                "gain nothing and trace their own"
            )


def _tell_of_rate(names: Sequence[str], times_s: Floats | None, warnings: list[str]) -> None:
    _, off = frame_rate(times_s)
    videos = [name for name in names if Path(name).suffix.lower() == ".mp4"]
    if off is not None and videos:
        warnings.append(f"{', '.join(videos)}: {off}")


def _kept(begun: Begun, view: View, renderer: Renderer) -> KeptRender:
    """What is left of a render of the same inputs that was cut off."""
    job = begun.job
    read = [*input_files(job), *view.files]
    inputs = inputs_of(job.settings, job.recorded(), read, begun.names, renderer.backend)
    return KeptRender(begun.names, inputs)


def _rays(job: RenderJob, renderer: Renderer, poses: int) -> int:
    """Rays of a render whose number is fixed."""
    each = renderer.rays_per_receptor_frame if job.receptors else renderer.rays_per_frame
    return poses * each * (_core.error_scrambles if job.standard_error else 1)


def _by_kind(written: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names of files, and of those that are directories."""
    directories = [name for name in written if Path(name).is_dir()]
    return [name for name in written if name not in directories], directories
