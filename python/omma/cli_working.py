"""What every command does while it works: a progress bar, Ctrl-C, one line for what went wrong."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn


@contextmanager
def working() -> Iterator[DelayedBar]:
    """A progress bar while a command works; Ctrl-C ends the command with one line."""
    with interruptible(), DelayedBar() as bar:
        yield bar


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C ends the command with one line."""
    # Before typer sees it, which would print an empty line first.
    try:
        yield
    except KeyboardInterrupt:
        raise typer.Exit(fail("interrupted", 130)) from None


def fail(message: str, code: int) -> int:
    """Say on stderr what went wrong; the exit code is handed back."""
    print("omma: error: " + " ".join(message.split()), file=sys.stderr)
    return code


class DelayedBar:
    """A progress bar on stderr that appears after a second, and never where that is no terminal."""

    def __init__(self) -> None:
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task("", total=None)
        self._stage = ""
        self._timer = threading.Timer(1.0, self._bar.start)
        self._timer.daemon = True
        self._wanted = sys.stderr.isatty() and sys.stdout.isatty()

    def show(self, stage: str, share: float | None) -> None:
        if stage != self._stage:
            # Else the time left would be that of the stage before, which is over.
            self._bar.reset(self._task)
            self._stage = stage
        self._bar.update(
            self._task,
            description=stage,
            total=None if share is None else 1.0,
            completed=share or 0.0,
        )

    def share_of(self, stage: str) -> Callable[[float], None]:
        """Takes the finished share of that stage."""
        return partial(self.show, stage)

    def __enter__(self) -> DelayedBar:
        if self._wanted:
            self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()
        if self._wanted:
            self._timer.join()
            self._bar.stop()
