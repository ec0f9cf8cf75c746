"""What renders from files to files did."""

from __future__ import annotations

from dataclasses import dataclass

from omma.base.values import value_class
from omma.rendering.report import SpentRays


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class RenderReport:
    """What a render did."""

    ommatidia: int  # 0 for a camera's picture
    poses: int
    rays: int
    seconds: float  # rendering alone, without reading, building and writing
    build_seconds: float  # reading the files and building the acceleration structure
    writing_seconds: float  # writing, as far as it did not happen beside rendering
    frames_per_s: float
    backend: str
    threads: int
    view: str  # where from: "camera NAME", "path FILE", ...
    eyes: tuple[str, ...]  # eye files, as they were found
    outputs: tuple[str, ...]  # files written
    warnings: tuple[str, ...]  # what the scene's loader passed over
    folders: tuple[str, ...] = ()  # that were missing and made for the outputs
    picture: tuple[int, int] | None = None  # width and height of a camera's picture
    spent: SpentRays | None = None  # where rays were spent to reach an error
    receptors: int = 0  # where their responses were asked for
    video: tuple[int, int, float] | None = None  # width, height and frames a second of a video
