"""The thread that renders: the newest settings first, then finer and finer while nothing changes.

All that touches the engine runs here, one thing after the other: a world that is being rendered
cannot be moved.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from omma.view.state import Look, Looker, Seen, finer

# Something to do between two frames; whether there is more of it to do.
Job = Callable[[], bool]


class _ChangedError(Exception):
    """Settings have changed: the frame in work is not wanted any more."""


class Live:
    """Renders what is wanted and hands it on.

    Args:
        looker: what renders.
        look: the first settings.
        on_seen: called with each frame.
        on_still: called once after the first frame of what then holds still.
        on_error: called with what went wrong; the thread goes on with the next settings.
    """

    def __init__(
        self,
        looker: Looker,
        look: Look,
        *,
        on_seen: Callable[[Seen], None],
        on_still: Callable[[Look], None],
        on_error: Callable[[Exception], None],
    ) -> None:
        self._looker = looker
        self._look = look
        self._version = 1
        self._refine = True
        self._jobs: deque[Job] = deque()
        self._closed = False
        self._changed = threading.Condition()
        self._on_seen, self._on_still, self._on_error = on_seen, on_still, on_error
        self._thread = threading.Thread(target=self._run, name="omma-view-render", daemon=True)

    def start(self) -> None:
        """Begin; what is called back may come from now on."""
        self._thread.start()

    @property
    def look(self) -> Look:
        """The settings that are wanted."""
        with self._changed:
            return self._look

    def want(self, look: Look) -> None:
        """Show this from now on."""
        with self._changed:
            if look != self._look:
                self._look = look
                self._version += 1
                self._changed.notify()

    def refine(self, wanted: bool) -> None:
        """Whether what holds still gets finer."""
        with self._changed:
            self._refine = wanted
            self._changed.notify()

    def do(self, job: Job) -> None:
        """Run something between two frames, in the thread that renders; and again after the next
        frame as long as it says that there is more."""
        with self._changed:
            self._jobs.append(job)
            self._version += 1
            self._changed.notify()

    def close(self) -> None:
        """End the thread; what is being rendered ends at once."""
        with self._changed:
            self._closed = True
            self._version += 1
            self._changed.notify()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join(timeout=10.0)

    def _check(self, version: int) -> Callable[[float], None]:
        def check(_: float) -> None:
            if self._version != version:
                raise _ChangedError

        return check

    def _run(self) -> None:
        last: Seen | None = None
        failed: Look | None = None
        job_was_last = False
        while True:
            with self._changed:
                while not self._closed and not self._jobs and not self._due(last, failed):
                    self._changed.wait()
                if self._closed:
                    return
                look, version = self._look, self._version
                # Alternates with what moves, so that neither starves.
                moves = look != failed and (last is None or last.look != look)
                job = self._jobs.popleft() if self._jobs and not (moves and job_was_last) else None
            job_was_last = job is not None
            try:
                if job is not None:
                    if job():
                        with self._changed:
                            self._jobs.append(job)
                elif last is None or last.look != look:
                    # Not cut off by what is newer: one frame after the other is what moves.
                    last = self._looker.see(look)
                    failed = None
                    self._on_seen(last)
                    if self._version == version:
                        self._on_still(look)
                elif self._due(last, failed):
                    after = finer(last)
                    assert after is not None
                    last = self._looker.see(look, *after, progress=self._check(version))
                    self._on_seen(last)
            except _ChangedError:
                continue
            except Exception as error:
                if job is None:
                    last, failed = None, look
                self._on_error(error)

    def _due(self, last: Seen | None, failed: Look | None) -> bool:
        if self._look == failed:
            return False
        if last is None or last.look != self._look:
            return True
        return self._refine and finer(last) is not None
