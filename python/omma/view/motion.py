"""What moves by itself: a path or an animation that is played, and what is recorded for a video."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from omma.picture.video import FRAMES_PER_S
from omma.view.state import Look

# Two minutes; beyond, a video takes longer to make than anyone waits for.
MOST_FRAMES = 120 * FRAMES_PER_S


class Clock:
    """Ticks 30 times a second while anything plays or is recorded; a thread of its own.

    Args:
        on_play: called with how many frames have gone by since the last call, while it plays.
        look: what is wanted at the moment, which is what is recorded.
        on_full: called where a recording has become too long, and has ended.
        on_error: called with what one of these raises.
    """

    def __init__(
        self,
        on_play: Callable[[float], None],
        look: Callable[[], Look],
        on_full: Callable[[], None],
        on_error: Callable[[Exception], None],
    ) -> None:
        self._on_play, self._look, self._on_full = on_play, look, on_full
        self._on_error = on_error
        self._playing = self._recording = self._closed = False
        self._recorded: list[Look] = []
        self._wake = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="omma-view-clock", daemon=True)
        self._thread.start()

    def play(self, wanted: bool) -> None:
        """Begin to play, or stop."""
        with self._wake:
            self._playing = wanted
            self._wake.notify()

    def record(self) -> None:
        """Begin a recording."""
        with self._wake:
            self._recorded = []
            self._recording = True
            self._wake.notify()

    def recorded(self) -> list[Look]:
        """End the recording and hand it over, a `Look` for each frame."""
        with self._wake:
            self._recording = False
            return self._recorded

    def close(self) -> None:
        """End the thread."""
        with self._wake:
            self._closed = True
            self._wake.notify()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        before = time.monotonic()
        while True:
            with self._wake:
                if not (self._playing or self._recording or self._closed):
                    self._wake.wait()
                    before = time.monotonic()
                if self._closed:
                    return
                playing, recording = self._playing, self._recording
            now = time.monotonic()
            try:
                self._tick(playing, recording, (now - before) * FRAMES_PER_S)
            except Exception as error:
                self.play(False)
                self._on_error(error)
            before = now
            with self._wake:
                self._wake.wait(max(0.0, now + 1 / FRAMES_PER_S - time.monotonic()))

    def _tick(self, playing: bool, recording: bool, frames: float) -> None:
        if playing:
            self._on_play(frames)
        if recording:
            look = self._look()
            with self._wake:
                self._recorded.append(look)
                full = len(self._recorded) >= MOST_FRAMES
                self._recording = not full
            if full:
                self._on_full()
