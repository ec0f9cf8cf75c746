"""What renders print when they are done."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby

from omma.cli.working import note, say, warn
from omma.job.all_cameras import AllCamerasReport
from omma.job.reports import RenderReport

# Pictures of several poses, as they are called (picture/files.py), and how many are all named.
_NUMBERED, _MOST_OF_SERIES = re.compile(r"(.*)_\d{4,}\.png", re.IGNORECASE | re.DOTALL), 6


def say_cameras(report: AllCamerasReport) -> None:
    """Say what was rendered of all cameras of a scene, after what there is to warn of."""
    for warning in report.warnings:
        warn(warning)
    say(*_camera_lines(report))


def say_report(report: RenderReport) -> None:
    """Say what was rendered, after which folders were made for it and what there is to warn of."""
    for folder in report.folders:
        note(f"made the folder {folder}")
    for warning in report.warnings:
        warn(warning)
    say(*_report_lines(report))


def _camera_lines(report: AllCamerasReport) -> list[str]:
    lines = []
    for camera in report.cameras:
        kind = camera.type + (f", {camera.projection}" if camera.projection else "")
        lines.append(
            f"camera {camera.index:<3} {camera.name} ({kind}): {camera.width} x {camera.height} "
            f"pixels in {camera.seconds:.3f} s"
        )
        lines.append(f"wrote      {camera.output}")
    prepared = f"{report.build_seconds:.3f} s of preparation"
    return [*lines, f"backend    {report.backend}, {report.threads} threads, {prepared}"]


def _report_lines(report: RenderReport) -> list[str]:
    rate = report.rays / max(report.seconds, 1e-9) / 1e6
    if report.picture is not None:
        width, height = report.picture
        each = report.rays // (width * height)
        what = [
            ("view", report.view),
            ("picture", f"{width} x {height} pixels"),
            ("rays", f"{report.rays:,} ({each:,} per pixel)"),
        ]
    else:
        each = report.rays // max(1, report.poses * report.ommatidia)
        what = [
            ("eye", ", ".join(report.eyes)),
            ("ommatidia", f"{report.ommatidia:,}"),
            *([("receptors", f"{report.receptors:,}")] if report.receptors else []),
            ("poses", f"{report.poses:,} ({report.view})"),
            ("rays", f"{report.rays:,} ({each:,} per ommatidium and pose)"),
        ]
        if report.spent is not None:
            what[-1:] = [("rays", report.spent.rays_text()), ("error", report.spent.missed_text())]
    lines = [
        *what,
        ("speed", f"{report.frames_per_s:,.1f} frames/s, {rate:,.1f} million rays/s"),
        (
            "time",
            f"{report.seconds:.3f} s of rendering, {report.writing_seconds:.3f} s more of writing, "
            f"after {report.build_seconds:.3f} s of preparation",
        ),
        ("backend", f"{report.backend}, {report.threads} threads"),
        *([] if report.video is None else [("video", _video_text(report.video, report.poses))]),
        *(("wrote", name) for name in _shown(report.outputs)),
    ]
    return [f"{what:<10} {value}" for what, value in lines]


def _video_text(video: tuple[int, int, float], poses: int) -> str:
    width, height, rate = video
    return (
        f"{width} x {height} pixels (even, as H.264 takes them), {rate:.4g} frames a second, "
        f"{poses / rate:.4g} s"
    )


def _shown(names: Sequence[str]) -> list[str]:
    """All names; of long series of pictures, numbered by pose, the first ones and the last."""
    shown: list[str] = []
    for series, members in groupby(names, _series_of):
        run = list(members)
        if series is not None and len(run) > _MOST_OF_SERIES:
            run = [*run[:3], f"... {len(run) - 4} more", run[-1]]
        shown += run
    return shown


def _series_of(name: str) -> str | None:
    found = _NUMBERED.fullmatch(name)
    return None if found is None else found[1]
