"""Videos of an eye's responses: a frame for each pose, H.264 in an `.mp4`.

Written by the ffmpeg that comes with imageio-ffmpeg, an optional extra, frame by frame.
"""

from __future__ import annotations

import tempfile
from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.files import WholeFiles, check_target
from omma.base.optional import needs
from omma.picture.files import Paint, on_threads
from omma.rendering.response_files import Piece

#: Frames a second. A path of poses has no times.
FRAMES_PER_S = 30

_QUALITY = 8  # of 10: facets keep their edges
_COPIED_BYTES = 1 << 20


class VideoWriter:
    """A frame of each pose; the file is there when the last has come, and whole.

    H.264 takes even numbers of pixels: an odd width or height gets a last column or row more, which
    repeats the one before.
    """

    def __init__(self, files: WholeFiles, name: str, pose_count: int, paint: Paint) -> None:
        _load_ffmpeg()
        check_target(name)
        self._files, self._name, self._paint = files, name, paint
        self._waiting = pose_count
        self._folder = tempfile.TemporaryDirectory(prefix="omma-video-")
        self._made = Path(self._folder.name) / "video.mp4"
        self._frames: Generator[None, Any, None] | None = None

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()
        self._folder.cleanup()

    def write(self, piece: Piece) -> None:
        def painted(i: int) -> NDArray[Any]:
            return self._paint(piece.first + i, piece.responses[i])

        for pixels in on_threads(painted, len(piece.responses)):
            self._add(pixels)
        if self._waiting == 0:
            self._end()
            self._copy()

    def _add(self, pixels: NDArray[Any]) -> None:
        height, width = pixels.shape[:2]
        even = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        try:
            if self._frames is None:
                self._frames = _load_ffmpeg().write_frames(
                    str(self._made),
                    (even.shape[1], even.shape[0]),
                    fps=FRAMES_PER_S,
                    codec="libx264",
                    quality=_QUALITY,
                    macro_block_size=1,
                    ffmpeg_log_level="error",
                    # No dates and versions: the same frames give the same bytes.
                    output_params=["-fflags", "+bitexact", "-flags:v", "+bitexact"],
                )
                self._frames.send(None)
            self._frames.send(np.ascontiguousarray(even))
        except OSError as error:
            raise Error(f"{self._name}: cannot be made: {str(error).strip()}") from None
        self._waiting -= 1

    def _end(self) -> None:
        if self._frames is not None:
            self._frames.close()
            self._frames = None

    def _copy(self) -> None:
        if not self._made.is_file():
            raise Error(f"{self._name}: cannot be made: ffmpeg wrote nothing")
        target = self._files.open(self._name)
        with self._made.open("rb") as made:
            while piece := made.read(_COPIED_BYTES):
                target.write(piece)
        target.close()


def _load_ffmpeg() -> Any:
    return needs("imageio_ffmpeg", "video", "a video needs imageio-ffmpeg")
