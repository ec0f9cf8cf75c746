"""Paths that browsers bring, and what they take away: recorded paths and videos."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.files import WholeFiles
from omma.base.poses import Matrices, load_timed_poses
from omma.picture.video import FRAMES_PER_S, VideoWriter
from omma.rendering.response_files import Piece
from omma.view.command import path_text
from omma.view.page import Page
from omma.view.painting import eye_ids, paint_eye, shown_values, unseen_in
from omma.view.state import Look

_MOST_BYTES = 64 << 20
_WIDTH = 1024


def poses_of_csv(name: str, content: bytes) -> tuple[Matrices, Floats | None]:
    """Poses (P, 4, 4) of a CSV file that a browser brings, as `omma.load_poses` reads it, and when
    they are (P,), s, where it says so.

    Raises:
        omma.Error: what is wrong, and in which line; a file over 64 MB.
    """
    if len(content) > _MOST_BYTES:
        raise Error(f"{name}: expected at most 64 MB, found {len(content) >> 20} MB")
    with tempfile.TemporaryDirectory(prefix="omma-view-") as folder:
        path = Path(folder) / "path.csv"
        path.write_bytes(content)
        try:
            return load_timed_poses(path)
        except Error as error:
            raise Error(str(error).replace(str(path), name)) from None


def recorded_csv(looks: list[Look]) -> bytes:
    """A recorded path, which ``omma render --path`` takes.

    Raises:
        omma.Error: nothing was recorded.
    """
    if not looks:
        raise Error("record: nothing was recorded")
    return path_text(looks).encode()


def record_video(page: Page, looks: list[Look], client: Any, told: Any) -> None:
    """Render what was recorded, a frame at a time between those of the page, as a video, and hand
    it to the browser; ``told`` is where the page says how far it is."""
    if not looks:
        raise Error("record: nothing was recorded")
    making = _Video(page, looks)

    def next_frame() -> bool:
        try:
            more = making.step()
        except BaseException:
            told.content = ""
            making.end()
            raise
        share = 100 * making.number // len(looks)
        told.content = f"<p style='margin:0 12px'>Making the video: {share} %</p>" if more else ""
        if not more:
            client.send_file_download("eye.mp4", making.video, save_immediately=True)
            page.tell("Video", f"{len(looks) / FRAMES_PER_S:.1f} s, {len(making.video) >> 10} KB")
        return more

    page.live.do(next_frame)


class _Video:
    """A video that grows by a frame a step."""

    def __init__(self, page: Page, looks: list[Look]) -> None:
        self._page, self._looks = page, looks
        self.number, self.video = 0, b""
        self._folder = tempfile.TemporaryDirectory(prefix="omma-view-")
        self._name = str(Path(self._folder.name) / "eye.mp4")
        self._files = WholeFiles()
        self._files.__enter__()
        # As it is set now, to the end.
        self._channel, self._white, self._stops = page.channel, page.white, page.stops
        projection = page.projection
        ids = eye_ids(page.looker.eye, projection, _WIDTH)
        hidden = unseen_in(ids, projection)

        def paint(_: int, values: NDArray[np.float32]) -> NDArray[np.uint8]:
            return paint_eye(ids, values, self._white, self._stops, hidden=hidden)

        self._writer = VideoWriter(self._files, self._name, len(looks), paint)

    def step(self) -> bool:
        """The next frame; whether there is another one after it."""
        looker = self._page.looker
        look = self._looks[self.number]
        if look.receptors != self._channel.receptors:
            raise Error("record: what is shown has changed from light to receptors meanwhile")
        seen = looker.see(look)
        values = shown_values(looker.world, looker.eye, seen, self._channel)
        self._writer.write(Piece(self.number, values[None]))
        self.number += 1
        if self.number < len(self._looks):
            return True
        self._files.__exit__(None, None, None)
        self.video = Path(self._name).read_bytes()
        self.end()
        return False

    def end(self) -> None:
        """Nothing is left of it."""
        self._writer.__exit__()
        self._folder.cleanup()
