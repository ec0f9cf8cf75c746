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
from omma.base.arrays import Floats
from omma.base.files import WholeFiles, check_target
from omma.base.optional import needs
from omma.picture.files import Paint, on_threads
from omma.rendering.response_files import Piece

#: Frames a second of poses that have no times.
FRAMES_PER_S = 30
# What players show.
_LEAST_PER_S, _MOST_PER_S = 1.0, 240.0
# Of the time between frames: as far from its own time may a frame be shown. Times that are rounded
# to milliseconds are still even.
_MOST_OFF = 0.25

_QUALITY = 8  # of 10: facets keep their edges
_COPIED_BYTES = 1 << 20


def frame_rate(times_s: Floats | None) -> tuple[float, str | None]:
    """Frames a second of poses at these growing times (P,), s, and in words where they are not
    shown at their times: those that are uneven come at the mean rate, at a rate that players do not
    take 30 a second."""
    if times_s is None or len(times_s) < 2:
        return FRAMES_PER_S, None
    lasts_s = float(times_s[-1]) - float(times_s[0])
    rate = (len(times_s) - 1) / lasts_s
    if not _LEAST_PER_S <= rate <= _MOST_PER_S:
        return FRAMES_PER_S, (
            f"expected {_LEAST_PER_S:g} to {_MOST_PER_S:g} poses a second, found {rate:.4g} by the "
            f"times of the path: the video shows {FRAMES_PER_S} a second, and "
            f"{(len(times_s) - 1) / FRAMES_PER_S:.3g} s stand for {lasts_s:.4g}"
        )
    off_s = float(np.abs(times_s - np.linspace(times_s[0], times_s[-1], len(times_s))).max())
    if off_s * rate > _MOST_OFF:
        return rate, (
            f"the times of the path are not even: the video shows {rate:.4g} frames a second, the "
            f"mean, and a frame up to {off_s:.3g} s from its time"
        )
    return rate, None


class VideoWriter:
    """A frame of each pose; the file is there when the last has come, and whole.

    H.264 takes even numbers of pixels: an odd width or height gets a last column or row more, which
    repeats the one before.
    """

    def __init__(
        self,
        files: WholeFiles,
        name: str,
        pose_count: int,
        paint: Paint,
        frames_per_s: float = FRAMES_PER_S,
    ) -> None:
        _load_ffmpeg()
        check_target(name)
        self._files, self._name, self._paint = files, name, paint
        self._waiting = pose_count
        self._frames_per_s = frames_per_s
        self._size = (0, 0)
        self._folder = tempfile.TemporaryDirectory(prefix="omma-video-")
        self._made = Path(self._folder.name) / "video.mp4"
        self._frames: Generator[None, Any, None] | None = None

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()
        self._folder.cleanup()

    @property
    def told(self) -> tuple[int, int, float]:
        """Width and height of its frames, pixels, and how many it shows a second."""
        return *self._size, self._frames_per_s

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
        self._size = (even.shape[1], even.shape[0])
        try:
            if self._frames is None:
                self._frames = _load_ffmpeg().write_frames(
                    str(self._made),
                    self._size,
                    fps=self._frames_per_s,
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
