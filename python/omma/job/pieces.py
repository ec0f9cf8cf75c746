"""Poses rendered piece by piece into writers, so that any number of them will do. A piece is
written while the next is rendered.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike

from omma.base.arrays import Floats
from omma.base.poses import Matrices
from omma.base.progress import Progress, Stage
from omma.rendering.labels import camera_variables
from omma.rendering.renderer import Renderer
from omma.rendering.report import SpentRays, report_of
from omma.rendering.response_files import Piece, Writer
from omma.rendering.settings import ToError
from omma.rendering.truth import truth_variables
from omma.scene.capture_cameras import CaptureCameras

# Two pieces are in memory, one that is rendered and one that is written.
_PIECE_BYTES = 32 << 20
# Target duration of a piece, s: writing begins soon and Ctrl-C is heard.
_PIECE_S = 0.5
# Most work, in s, that an interrupted render loses.
_KEPT_PIECE_S = 10.0

# Poses, the number of the first, and what takes the finished share.
Render = Callable[[Matrices, int, Progress], Piece]


def render_of_ommatidia(
    renderer: Renderer,
    standard_error: bool,
    spent: SpentRays | None,
    times_s: Floats | None = None,
) -> Render:
    """What renders ommatidia; with ``spent`` to an error, adding what it took; where ``times_s`` of
    all poses are given, with things where animations have them then."""

    def render(piece: Matrices, first: int, progress: Progress) -> Piece:
        when = _times_of(times_s, first, piece)
        if spent is not None:
            responses, report = renderer.render(
                piece, report=True, first_pose=first, progress=progress, times_s=when
            )
            spent.add(report, first)
            return Piece(first, responses, report.standard_error, report.rays)
        if standard_error:
            responses, errors = renderer.render(
                piece, standard_error=True, first_pose=first, progress=progress, times_s=when
            )
            return Piece(first, responses, errors)
        return Piece(
            first, renderer.render(piece, first_pose=first, progress=progress, times_s=when)
        )

    return render


class BesideCameras:
    """What renders ommatidia, to the bits of `render_of_ommatidia`, and says beside them how near
    cameras of the capture were."""

    def __init__(
        self,
        renderer: Renderer,
        cameras: CaptureCameras,
        standard_error: bool,
        spent: SpentRays | None,
        times_s: Floats | None = None,
    ) -> None:
        self._renderer, self._cameras, self._times = renderer, cameras, times_s
        self._standard_error, self._spent = standard_error, spent
        self.met = 0
        """Ommatidia times poses that saw anything but sky."""
        self.known = 0
        """Of these, how many saw what a camera had in its field."""

    def __call__(self, piece: Matrices, first: int, progress: Progress) -> Piece:
        truth = self._renderer.ground_truth(
            piece,
            capture_cameras=self._cameras,
            standard_error=self._standard_error,
            first_pose=first,
            progress=progress,
            times_s=_times_of(self._times, first, piece),
        )
        target = self._renderer.settings.sampling
        errors, rays = truth.standard_error, truth.rays
        if self._spent is not None and isinstance(target, ToError):
            assert errors is not None
            assert rays is not None
            self._spent.add(report_of(target, truth.responses, errors, rays), first)
        variables = truth_variables(truth, ("pose", "ommatidium"))
        beside = {name: variables[name][1] for name in camera_variables("pose")}
        is_met = np.isfinite(truth.distance_m)
        self.met += int(is_met.sum())
        self.known += int((is_met & np.isfinite(beside["camera_angle"])).sum())
        return Piece(first, truth.responses, errors, rays, beside)


def render_of_receptors(
    renderer: Renderer,
    ultraviolet: ArrayLike | None,
    standard_error: bool,
    times_s: Floats | None = None,
) -> Render:
    """What renders receptors; ``times_s`` as of `render_of_ommatidia`."""

    def render(piece: Matrices, first: int, progress: Progress) -> Piece:
        when = _times_of(times_s, first, piece)
        if standard_error:
            responses, errors = renderer.render_receptors(
                piece,
                ultraviolet=ultraviolet,
                standard_error=True,
                first_pose=first,
                progress=progress,
                times_s=when,
            )
            return Piece(first, responses, errors)
        responses = renderer.render_receptors(
            piece, ultraviolet=ultraviolet, first_pose=first, progress=progress, times_s=when
        )
        return Piece(first, responses)

    return render


def render_pieces(
    render: Render,
    writers: Sequence[Writer],
    poses: Matrices,
    pose_bytes: int,
    tell: Stage,
    save: Callable[[int, float], object] | None = None,
    first: int = 0,
) -> float:
    """Render the poses from ``first`` on into the writers; seconds spent rendering.

    ``save``, where there is one, is told after each piece how many poses are done and the seconds
    they took to render; pieces are then as short as what may be lost, with their writing and
    saving, and written before the next begins.
    """
    most = max(1, _PIECE_BYTES // pose_bytes)
    count = 1
    seconds = 0.0
    with ThreadPoolExecutor(1, "omma-writing") as beside:
        waiting: Future[float] | None = None
        while first < len(poses):
            piece = poses[first : first + count]

            def tell_share(done: float, first: int = first, count: int = len(piece)) -> None:
                tell("Rendering", (first + done * count) / len(poses))

            start = time.perf_counter()
            rendered = render(piece, first, tell_share)
            took = time.perf_counter() - start
            seconds += took
            first += len(piece)
            wrote = 0.0 if waiting is None else waiting.result()
            if save is None:
                waiting = beside.submit(_write, writers, rendered)
            else:
                tell("Writing", first / len(poses) if first < len(poses) else None)
                _write(writers, rendered)
                save(first, seconds)
                took = time.perf_counter() - start
            span = _PIECE_S if save is None else _KEPT_PIECE_S
            fitting = int(span * len(piece) / max(took, wrote, 1e-9))
            count = max(1, min(most, 8 * count, fitting))
        if waiting is not None:
            tell("Writing", None)  # and files are made whole
            waiting.result()
    return seconds


def _times_of(times_s: Floats | None, first: int, piece: Matrices) -> Floats | None:
    return None if times_s is None else times_s[first : first + len(piece)]


def _write(writers: Sequence[Writer], piece: Piece) -> float:
    """Seconds that it took."""
    start = time.perf_counter()
    for writer in writers:
        writer.write(piece)
    return time.perf_counter() - start
